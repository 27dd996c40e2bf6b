//! What is said in place of a scene's own `solve`: options of the commands, told again in the result that they gave.

use serde::{Deserialize, Serialize};

#[cfg(feature = "cli")]
use super::Json;
use super::settings::{self, EvidenceName, KernelName, MethodName, SolveForm};
#[cfg(feature = "cli")]
use super::settings::{checked_cells, checked_tolerance};
use super::{Scene, decode};
#[cfg(feature = "cli")]
use crate::error::InputError;
#[cfg(feature = "cli")]
use crate::problem::Settings;

/// Options that replace what the scene says under `solve`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub(crate) struct SolveOptions {
    /// Which method
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "METHOD"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<MethodName>,
    /// Cells along the longer side
    #[cfg_attr(feature = "cli", arg(long, value_name = "N"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<usize>,
    /// Means over cells, or values at their centres
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "KERNEL"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<KernelName>,
    /// Whether the error of the force is to be proved
    #[cfg_attr(feature = "cli", arg(long, value_enum, value_name = "EVIDENCE"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<EvidenceName>,
    /// Relative error of the force that is good enough
    #[cfg_attr(feature = "cli", arg(long, value_name = "T", allow_negative_numbers = true))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

#[cfg(feature = "cli")]
impl SolveOptions {
    /// Puts them in place of what the settings say; an error has its path from `prefix`, as `--` or `options.`.
    pub fn apply(&self, prefix: &str, settings: &mut Settings) -> Result<(), InputError> {
        if let Some(method) = self.method {
            settings.method = method.into();
        }
        if let Some(cells) = self.cells {
            settings.cells = Some(checked_cells(&format!("{prefix}cells"), cells)?);
            settings.nodes = false;
        }
        if let Some(kernel) = self.kernel {
            settings.kernel = kernel.into();
        }
        if let Some(evidence) = self.evidence {
            settings.evidence = evidence.into();
        }
        if let Some(tolerance) = self.tolerance {
            settings.tolerance = checked_tolerance(&format!("{prefix}tolerance"), tolerance)?;
        }
        Ok(())
    }

    /// Those that a result tells of; none where it tells of none.
    pub fn told_in(result: &Json) -> Result<Self, InputError> {
        result.get("options").map_or_else(|| Ok(Self::default()), |options| decode::decode(options, "options"))
    }
}

impl SolveOptions {
    /// What the settings of a scene say in place of its document; `None` where they say the same.
    pub fn of(scene: &Scene) -> Option<Self> {
        let form: SolveForm = match scene.document.get("solve") {
            None => SolveForm::default(),
            Some(solve) => decode::decode(solve, "solve").ok()?,
        };
        let (used, asked) = (scene.settings, settings::settings(form, &[], scene.contact.gap()).ok()?);
        let options = Self {
            method: (used.method != asked.method).then(|| used.method.into()),
            cells: used.cells.filter(|_| (used.cells, used.nodes) != (asked.cells, asked.nodes)),
            kernel: (used.kernel != asked.kernel).then(|| used.kernel.into()),
            evidence: (used.evidence != asked.evidence).then(|| used.evidence.into()),
            tolerance: Some(used.tolerance).filter(|_| used.tolerance != asked.tolerance),
        };
        (options != Self::default()).then_some(options)
    }
}
