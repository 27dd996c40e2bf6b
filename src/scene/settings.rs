//! What a scene says of how to solve, what to write, and its units.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::gap::{AnyGap, Gap};
use crate::grid::Kernel;
use crate::problem::{BoundaryFamily, ErrorBar, Method, Outputs, Settings};
use crate::units::UnitLabels;

/// Cells along the longer side; memory grows with the square of it, about 17 GB at this limit.
pub(crate) const MOST_CELLS: usize = 16_384;

/// Labels of the units that the numbers of a scene are in.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct UnitsForm {
    /// Unit of length, such as "mm".
    length: String,
    /// Unit of force, such as "N".
    force: String,
}

pub(super) fn units(form: UnitsForm) -> Result<UnitLabels, InputError> {
    UnitLabels::new(&form.length, &form.force).map_err(|e| e.within("units"))
}

/// Cells along the longer side, or "map".
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "a whole number, or \"map\"")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum CellsForm {
    Along(usize),
    Named(CellsName),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum CellsName {
    Map,
}

/// Names of the methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum), value(rename_all = "snake_case"))]
pub(crate) enum MethodName {
    /// The cheapest method that reaches the tolerance.
    Auto,
    /// A formula, where one is known.
    ClosedForm,
    /// The best ellipse: a rigorous lower bound of the force.
    Ritz,
    /// Fabrikant's flat punch and the boundary of largest force.
    Fabrikant,
    /// The quadratic programme on a grid.
    Qp,
    /// The same programme by conjugate gradients and fast Fourier transforms.
    Fft,
    /// Cells graded to the edges of the material: level polygons, flats with flanks, gaps of revolution.
    EdgeFitted,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Auto => Self::Auto,
            MethodName::ClosedForm => Self::ClosedForm,
            MethodName::Ritz => Self::Ritz,
            MethodName::Fabrikant => Self::Fabrikant,
            MethodName::Qp => Self::Qp,
            MethodName::Fft => Self::Fft,
            MethodName::EdgeFitted => Self::EdgeFitted,
        }
    }
}

impl From<Method> for MethodName {
    fn from(method: Method) -> Self {
        match method {
            Method::Auto => Self::Auto,
            Method::ClosedForm => Self::ClosedForm,
            Method::Ritz => Self::Ritz,
            Method::Fabrikant => Self::Fabrikant,
            Method::Qp => Self::Qp,
            Method::Fft => Self::Fft,
            Method::EdgeFitted => Self::EdgeFitted,
        }
    }
}

/// Names of the kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum), value(rename_all = "snake_case"))]
pub(crate) enum KernelName {
    /// Means over cells.
    Galerkin,
    /// Values at the centres of cells.
    Collocation,
}

impl From<KernelName> for Kernel {
    fn from(name: KernelName) -> Self {
        match name {
            KernelName::Galerkin => Self::Galerkin,
            KernelName::Collocation => Self::Collocation,
        }
    }
}

impl From<Kernel> for KernelName {
    fn from(kernel: Kernel) -> Self {
        match kernel {
            Kernel::Galerkin => Self::Galerkin,
            Kernel::Collocation => Self::Collocation,
        }
    }
}

/// Names of what the stated error is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum), value(rename_all = "snake_case"))]
pub(crate) enum EvidenceName {
    /// A proved bracket wherever a theorem reaches.
    Proof,
    /// An estimate, for inner loops.
    Estimate,
}

impl From<EvidenceName> for ErrorBar {
    fn from(name: EvidenceName) -> Self {
        match name {
            EvidenceName::Proof => Self::Proof,
            EvidenceName::Estimate => Self::Estimate,
        }
    }
}

impl From<ErrorBar> for EvidenceName {
    fn from(bar: ErrorBar) -> Self {
        match bar {
            ErrorBar::Proof => Self::Proof,
            ErrorBar::Estimate => Self::Estimate,
        }
    }
}

/// Boundaries that `fabrikant` may choose from; a Fourier series for a(theta) by its order.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum BoundaryForm {
    Stationary,
    Ellipse,
    Circle,
    PlanForm,
    Auto,
    Fourier(usize),
}

/// How to solve; everything here has a default.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct SolveForm {
    /// Which method; by default the cheapest that reaches the tolerance.
    method: Option<MethodName>,
    /// Cells along the longer side, 1 to 16384, or "map": the nodes of the height map are the cells; by default as many as the
    /// tolerance asks for.
    cells: Option<CellsForm>,
    /// Means over cells (the default) or values at their centres.
    kernel: Option<KernelName>,
    /// Relative error of the force that is good enough, between 0 and 1; by default 0.001.
    tolerance: Option<f64>,
    /// Boundaries that `fabrikant` may choose from.
    boundary: Option<BoundaryForm>,
    /// What the error of the force is to be: "proof" by default, "estimate" for inner loops.
    evidence: Option<EvidenceName>,
    /// CPU seconds that one state of loading may take, 0 or more; 60 by default, 0 for no limit. Where they end before there is any number, an
    /// estimate to a hundredth may take half as many again (0.05 to 5).
    seconds: Option<f64>,
}

/// What else to compute and write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum OutputName {
    /// The boundary of the patch as closed lines.
    Patch,
    /// The pressure field.
    Pressure,
    /// The gap after loading, on the same grid.
    Gap,
    /// A lower and an upper bound of the force.
    Bracket,
    /// Force against depth up to the given load.
    Curve,
    /// Stored energy and moments where they cost more solves (approximate methods).
    Energy,
}

/// Checks a number of cells given at `path`.
pub(crate) fn checked_cells(path: &str, cells: usize) -> Result<usize, InputError> {
    if (1..=MOST_CELLS).contains(&cells) {
        return Ok(cells);
    }
    let allowed = format!("a whole number from 1 to {MOST_CELLS}: memory grows with its square");
    Err(InputError::new(path, cells, allowed))
}

/// Checks a tolerance given at `path`.
pub(crate) fn checked_tolerance(path: &str, tolerance: f64) -> Result<f64, InputError> {
    if tolerance > 0.0 && tolerance < 1.0 {
        return Ok(tolerance);
    }
    Err(InputError::new(path, tolerance, "a number greater than 0 and less than 1"))
}

/// Checks CPU seconds given at `path`; 0 stands for no limit.
pub(crate) fn checked_seconds(path: &str, seconds: f64) -> Result<f64, InputError> {
    if seconds.is_finite() && seconds >= 0.0 {
        return Ok(seconds);
    }
    Err(InputError::new(path, seconds, "CPU seconds, 0 or more; 0: no limit"))
}

pub(super) fn settings(solve: SolveForm, output: &[OutputName], gap: &AnyGap) -> Result<Settings, InputError> {
    let mut settings = Settings::default();
    if let Some(method) = solve.method {
        settings.method = method.into();
    }
    match solve.cells {
        None => {}
        Some(CellsForm::Along(cells)) => settings.cells = Some(checked_cells("solve.cells", cells)?),
        Some(CellsForm::Named(CellsName::Map)) => {
            let nodes = gap.nodes().ok_or_else(|| {
                let given = "\"map\", where the gap has no height map whose rows run along x or y";
                InputError::new("solve.cells", given, "a whole number of cells, or a gap of kind height_map")
            })?;
            settings.cells = Some(checked_cells("solve.cells", nodes.shape[0].max(nodes.shape[1]))?);
            settings.nodes = true;
        }
    }
    if let Some(kernel) = solve.kernel {
        settings.kernel = kernel.into();
    }
    if let Some(tolerance) = solve.tolerance {
        settings.tolerance = checked_tolerance("solve.tolerance", tolerance)?;
    }
    if let Some(evidence) = solve.evidence {
        settings.evidence = evidence.into();
    }
    if let Some(seconds) = solve.seconds {
        settings.seconds = checked_seconds("solve.seconds", seconds)?;
    }
    settings.boundary = match solve.boundary {
        None | Some(BoundaryForm::Stationary) => BoundaryFamily::Stationary,
        Some(BoundaryForm::Ellipse) => BoundaryFamily::Ellipse,
        Some(BoundaryForm::Circle) => BoundaryFamily::Circle,
        Some(BoundaryForm::PlanForm) => BoundaryFamily::PlanForm,
        Some(BoundaryForm::Auto) => BoundaryFamily::Auto,
        Some(BoundaryForm::Fourier(order @ 0..=64)) => BoundaryFamily::Fourier(order),
        Some(BoundaryForm::Fourier(order)) => {
            return Err(InputError::new("solve.boundary.fourier", order, "an order from 0 to 64"));
        }
    };
    settings.outputs = Outputs {
        patch: output.contains(&OutputName::Patch),
        pressure: output.contains(&OutputName::Pressure),
        gap: output.contains(&OutputName::Gap),
        bracket: output.contains(&OutputName::Bracket),
        curve: output.contains(&OutputName::Curve),
        energy: output.contains(&OutputName::Energy),
    };
    Ok(settings)
}
