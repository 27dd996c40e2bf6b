//! The loading of a scene.

use serde::Deserialize;

use super::decode::decode;
use super::document::{Json, key_in_path};
use super::fault::unknown;
use crate::error::{InputError, finite};
use crate::problem::{Load, Loading};

/// States of loading in one scene: more than any curve needs. Each one is a solve, unless the gap is homogeneous.
const MOST_STEPS: usize = 100_000;

/// One state of loading, or several.
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum LoadingForm {
    Depth(DepthForm),
    Force(ForceForm),
    Depths(DepthsForm),
    Forces(ForcesForm),
    Range(RangeForm),
}

/// Approach of the bodies, in units of length; negative: they do not touch.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct DepthForm {
    /// Approach at the origin.
    depth: f64,
    /// Slopes [ax, ay] of a tilted punch: overlap = depth + ax x + ay y - gap.
    tilt: Option<[f64; 2]>,
}

/// Normal force; with `through` or `moment` on a punch free to tilt.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ForceForm {
    /// Normal force, 0 or more.
    force: f64,
    /// Where the line of action meets the surface, [x, y].
    through: Option<[f64; 2]>,
    /// Moments [Mx, My] about the origin: Mx = force y, My = -force x.
    moment: Option<[f64; 2]>,
}

/// Several depths, answered in order.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct DepthsForm {
    depths: Vec<f64>,
}

/// Several forces, answered in order.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ForcesForm {
    forces: Vec<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RangeForm {
    depth_range: RangeFields,
}

/// Equal steps of depth; 0 is left out.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RangeFields {
    /// The last depth.
    to: f64,
    /// How many depths.
    steps: usize,
}

/// The keys of which a loading holds exactly one, and those that may stand beside some.
const LOADINGS: [&str; 5] = ["depth", "force", "depths", "forces", "depth_range"];
const BESIDE: [&str; 3] = ["through", "moment", "tilt"];

pub(super) fn loading(value: &Json) -> Result<Loading, InputError> {
    const PATH: &str = "loading";
    let Json::Object(entries) = value else {
        return Err(InputError::new(PATH, value.brief(), format!("an object with one of: {}", LOADINGS.join(", "))));
    };
    let known: Vec<&str> = LOADINGS.into_iter().chain(BESIDE).collect();
    if let Some((key, _)) = entries.iter().find(|(key, _)| !known.contains(&key.as_str())) {
        return Err(unknown(format!("{PATH}.{}", key_in_path(key)), "an unknown key", key, &known));
    }
    let chosen: Vec<&str> = entries.iter().map(|(key, _)| key.as_str()).filter(|k| LOADINGS.contains(k)).collect();
    let [chosen] = chosen.as_slice() else {
        let given = if chosen.is_empty() { value.brief() } else { format!("{} together", chosen.join(" and ")) };
        return Err(InputError::new(PATH, given, format!("exactly one of: {}", LOADINGS.join(", "))));
    };
    match *chosen {
        "depth" => {
            let DepthForm { depth, tilt } = decode(value, PATH)?;
            Ok(Loading::Single(tilt.map_or(Load::Depth(depth), |tilt| Load::Tilted { depth, tilt })))
        }
        "force" => force(decode(value, PATH)?),
        "depths" => {
            let DepthsForm { depths } = decode(value, PATH)?;
            several("loading.depths", depths.into_iter().map(Load::Depth).collect())
        }
        "forces" => {
            let ForcesForm { forces } = decode(value, PATH)?;
            for (k, &force) in forces.iter().enumerate() {
                not_pulled(&format!("loading.forces[{k}]"), force)?;
            }
            several("loading.forces", forces.into_iter().map(Load::Force).collect())
        }
        _ => {
            let RangeForm { depth_range: RangeFields { to, steps } } = decode(value, PATH)?;
            if !(1..=MOST_STEPS).contains(&steps) {
                let allowed = format!("a whole number from 1 to {MOST_STEPS}");
                return Err(InputError::new("loading.depth_range.steps", steps, allowed));
            }
            Ok(Loading::depth_range(finite("loading.depth_range.to", to)?, steps))
        }
    }
}

fn force(form: ForceForm) -> Result<Loading, InputError> {
    let force = not_pulled("loading.force", form.force)?;
    match (form.through, form.moment) {
        (None, None) => Ok(Loading::force(force)),
        (Some(through), None) => Ok(Loading::force_through(force, through)),
        (None, Some(moment)) => Ok(Loading::Single(Load::ForceMoment { force, moment })),
        (Some(_), Some(_)) => {
            Err(InputError::new("loading", "through and moment together", "at most one of through and moment"))
        }
    }
}

fn not_pulled(path: &str, force: f64) -> Result<f64, InputError> {
    if force.is_finite() && force >= 0.0 {
        return Ok(force);
    }
    Err(InputError::new(path, force, "a finite force, 0 or more: bodies that do not adhere cannot be pulled"))
}

fn several(path: &str, loads: Vec<Load>) -> Result<Loading, InputError> {
    if loads.is_empty() {
        return Err(InputError::new(path, "an empty list", "at least one number"));
    }
    if loads.len() > MOST_STEPS {
        let given = format!("a list of {}", loads.len());
        return Err(InputError::new(path, given, format!("at most {MOST_STEPS} numbers")));
    }
    Ok(Loading::Steps(loads))
}
