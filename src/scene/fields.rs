//! What a scene file may say besides the gap: bodies, loading, how to solve, what to write.
//!
//! The structures are declared once: they read the file and make the JSON Schema.

use serde::Deserialize;

use super::decode::{decode, unknown};
use super::document::{Json, key_in_path, quoted};
use crate::error::{InputError, finite};
use crate::gap::{AnyGap, Gap};
use crate::grid::Kernel;
use crate::problem::{Body, BoundaryFamily, EffectiveModulus, ErrorBar, Load, Loading, Method, Outputs, Settings};
use crate::units::UnitLabels;

/// States of loading in one scene: more than any curve needs. Each one is a solve, unless the gap is homogeneous.
const MOST_STEPS: usize = 100_000;

/// Cells along the longer side; memory grows with the square of it, about 17 GB at this limit.
pub(crate) const MOST_CELLS: usize = 16_384;

/// A body: its Young's or shear modulus with Poisson's ratio, or "rigid".
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum BodyForm {
    Young(YoungForm),
    Shear(ShearForm),
    YoungLetters(YoungLettersForm),
    ShearLetters(ShearLettersForm),
    Rigid(RigidForm),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct YoungForm {
    /// Young's modulus E > 0, in units of stress.
    youngs_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    poissons_ratio: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct ShearForm {
    /// Shear modulus mu > 0, in units of stress.
    shear_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    poissons_ratio: f64,
}

/// The same in the letters of the field.
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) struct YoungLettersForm {
    /// Young's modulus E > 0, in units of stress.
    #[schemars(rename = "E")]
    youngs_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[schemars(rename = "nu")]
    poissons_ratio: f64,
}

/// The same in the letters of the field.
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) struct ShearLettersForm {
    /// Shear modulus mu > 0, in units of stress.
    #[schemars(rename = "G")]
    shear_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[schemars(rename = "nu")]
    poissons_ratio: f64,
}

/// A body that does not deform.
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum RigidForm {
    Rigid,
}

/// The letters of the field for the keys of a body.
const LETTERS: [(&str, &str); 3] = [("E", "youngs_modulus"), ("nu", "poissons_ratio"), ("G", "shear_modulus")];

/// A body whose keys may be letters; errors name the key as it was written.
fn body(value: &Json, path: &str) -> Result<Body, InputError> {
    let Json::Object(entries) = value else { return spelled(value, path) };
    for (letter, key) in LETTERS {
        if value.get(letter).is_some() && value.get(key).is_some() {
            return Err(InputError::new(path, format!("both {letter} and {key}"), "one of the two: they are the same"));
        }
    }
    let long = |key: &str| LETTERS.iter().find(|(letter, _)| *letter == key).map_or(key, |(_, long)| long).to_owned();
    let written = Json::Object(entries.iter().map(|(key, value)| (long(key), value.clone())).collect());
    spelled(&written, path).map_err(|mut e| {
        for (letter, key) in LETTERS {
            if value.get(letter).is_some() && e.path == format!("{path}.{key}") {
                e.path = format!("{path}.{letter}");
            }
        }
        e
    })
}

fn spelled(value: &Json, path: &str) -> Result<Body, InputError> {
    let body = match value {
        Json::String(word) if word == "rigid" => return Ok(Body::RIGID),
        Json::String(word) if strsim::jaro_winkler(word, "rigid") < 0.8 => {
            let allowed = "numbers, as there is no table of materials: {\"youngs_modulus\": 2.1e11, \"poissons_ratio\": 0.3} is steel \
                           in Pa; or \"rigid\"";
            return Err(InputError::new(path, quoted(word), allowed));
        }
        Json::String(word) => return Err(unknown(path.into(), quoted(word), word, &["rigid"])),
        Json::Object(_) if value.get("shear_modulus").is_some() && value.get("youngs_modulus").is_some() => {
            return Err(InputError::new(
                path,
                "both youngs_modulus and shear_modulus",
                "one of the two, with poissons_ratio",
            ));
        }
        Json::Object(_) if value.get("shear_modulus").is_some() => {
            let ShearForm { shear_modulus, poissons_ratio } = decode(value, path)?;
            Body::elastic_in_shear(shear_modulus, poissons_ratio)
        }
        Json::Object(_) => {
            let YoungForm { youngs_modulus, poissons_ratio } = decode(value, path)?;
            Body::elastic(youngs_modulus, poissons_ratio)
        }
        other => {
            let allowed = "{youngs_modulus, poissons_ratio}, {shear_modulus, poissons_ratio} or \"rigid\"";
            return Err(InputError::new(path, other.brief(), allowed));
        }
    };
    body.map_err(|e| e.within(path))
}

/// E* from `bodies` or `effective_modulus`.
pub(super) fn modulus(bodies: Option<&Json>, e_star: Option<f64>) -> Result<EffectiveModulus, InputError> {
    match (bodies, e_star) {
        (Some(_), Some(_)) => Err(InputError::new(
            "effective_modulus",
            "a modulus of the pair beside bodies",
            "either bodies or effective_modulus",
        )),
        (None, Some(e_star)) => EffectiveModulus::from_e_star(e_star),
        (None, None) => {
            Err(InputError::new("bodies", "nothing", "one or two bodies, or effective_modulus in their place"))
        }
        (Some(Json::Array(items)), None) => match items.as_slice() {
            [one] => EffectiveModulus::of_pair(body(one, "bodies[0]")?, Body::RIGID)
                .map_err(|e| InputError { given: "one rigid body".into(), ..e }),
            [one, other] => EffectiveModulus::of_pair(body(one, "bodies[0]")?, body(other, "bodies[1]")?),
            _ => Err(InputError::new("bodies", format!("a list of {}", items.len()), "one or two bodies")),
        },
        (Some(other), None) => {
            let allowed = "a list of one or two bodies, in brackets: [{\"youngs_modulus\": E, \"poissons_ratio\": nu}, \"rigid\"]";
            Err(InputError::new("bodies", other.brief(), allowed))
        }
    }
}

/// One state of loading, or several.
#[cfg(feature = "cli")]
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
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct DepthForm {
    /// Approach at the origin.
    depth: f64,
    /// Slopes [ax, ay] of a tilted punch: overlap = depth + ax x + ay y - gap.
    tilt: Option<[f64; 2]>,
}

/// Normal force; with `through` or `moment` on a punch free to tilt.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct DepthsForm {
    depths: Vec<f64>,
}

/// Several forces, answered in order.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct ForcesForm {
    forces: Vec<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct RangeForm {
    depth_range: RangeFields,
}

/// Equal steps of depth; 0 is left out.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
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

/// Labels of the units that the numbers of a scene are in.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct UnitsForm {
    /// Unit of length, such as "mm".
    length: String,
    /// Unit of force, such as "N".
    force: String,
}

pub(super) fn units(form: UnitsForm) -> Result<UnitLabels, InputError> {
    UnitLabels::new(&form.length, &form.force).map_err(|e| e.within("units"))
}

/// A number of cells, or those of a height map.
#[derive(Debug, Clone, Copy)]
pub(super) enum CellsForm {
    Along(usize),
    Map,
}

impl<'de> Deserialize<'de> for CellsForm {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Cells;
        impl serde::de::Visitor<'_> for Cells {
            type Value = CellsForm;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a whole number, or \"map\"")
            }

            fn visit_u64<E: serde::de::Error>(self, cells: u64) -> Result<CellsForm, E> {
                Ok(CellsForm::Along(usize::try_from(cells).unwrap_or(usize::MAX)))
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<CellsForm, E> {
                if word == "map" {
                    return Ok(CellsForm::Map);
                }
                Err(E::invalid_value(serde::de::Unexpected::Str(word), &self))
            }
        }
        from.deserialize_u64(Cells)
    }
}

/// Cells along the longer side, or "map".
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
enum CellsSchema {
    Along(usize),
    Named(CellsName),
}

#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
enum CellsName {
    Map,
}

/// Names of the methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema, clap::ValueEnum), value(rename_all = "snake_case"))]
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

/// Names of the kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema, clap::ValueEnum), value(rename_all = "snake_case"))]
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

/// Names of what the stated error is to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema, clap::ValueEnum), value(rename_all = "snake_case"))]
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

/// Boundaries that `fabrikant` may choose from; a Fourier series for a(theta) by its order.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct SolveForm {
    /// Which method; by default the cheapest that reaches the tolerance.
    method: Option<MethodName>,
    /// Cells along the longer side, 1 to 16384, or "map": the nodes of the height map are the cells; by default as many as the
    /// tolerance asks for.
    #[cfg_attr(feature = "cli", schemars(with = "Option<CellsSchema>"))]
    cells: Option<CellsForm>,
    /// Means over cells (the default) or values at their centres.
    kernel: Option<KernelName>,
    /// Relative error of the force that is good enough, between 0 and 1; by default 0.001.
    tolerance: Option<f64>,
    /// Boundaries that `fabrikant` may choose from.
    boundary: Option<BoundaryForm>,
    /// What the error of the force is to be: "proof" by default, "estimate" for inner loops.
    evidence: Option<EvidenceName>,
    /// CPU seconds that one state of loading may take, 0 or more; 60 by default, 0 for no limit.
    seconds: Option<f64>,
}

/// What else to compute and write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
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
        Some(CellsForm::Map) => {
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
