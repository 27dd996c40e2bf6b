//! The gap of a scene: one structure a kind, chosen by the key `kind`.

use serde::Deserialize;

use super::Any;
use super::decode::{decode, decode_kind};
use super::document::Json;
use super::given::Sources;
use super::measured::{HeightMapForm, ProfileForm};
use super::shapes::{
    ConeForm, FlatForm, FormulaForm, IndenterForm, ParaboloidForm, PolyhedronForm, PowerForm, PyramidForm,
    RevolvedForm, SphereForm, at_most,
};
use crate::error::InputError;
use crate::gap::{AnyGap, Minimum, Sum};

/// The initial gap of the undeformed bodies at zero depth.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(
    test,
    derive(schemars::JsonSchema),
    schemars(tag = "kind", transform = super::schema::with_place)
)]
pub(super) enum GapForm {
    Paraboloid(ParaboloidForm),
    Sphere(SphereForm),
    Cone(ConeForm),
    Power(PowerForm),
    Pyramid(PyramidForm),
    Berkovich(IndenterForm),
    Vickers(IndenterForm),
    CubeCorner(IndenterForm),
    Polyhedron(PolyhedronForm),
    Flat(FlatForm),
    Revolved(RevolvedForm),
    Formula(FormulaForm),
    HeightMap(Box<HeightMapForm>),
    Profile(Box<ProfileForm>),
    Sum(PartsForm),
    Min(PartsForm),
}

/// Keys that every kind takes.
const COMMON: [&str; 3] = ["kind", "at", "rotate"];

/// A gap made of others.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct PartsForm {
    /// The gaps, at least one.
    #[cfg_attr(test, schemars(with = "Vec<GapForm>"))]
    // Read one by one.
    #[serde(rename = "of")]
    _of: Any,
}

/// A gap that the calling program holds; files cannot say it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenForm {
    name: String,
}

/// Where a gap stands and how it is turned.
#[derive(Deserialize)]
struct Place {
    at: Option<[f64; 2]>,
    rotate: Option<f64>,
}

/// Most gaps that a sum or a minimum is made of, those inside of others counted: what is asked of the whole is asked of each.
const MOST_PARTS: usize = 1000;

/// Gaps that are not made of others, in this one.
fn simple_parts(value: &Json) -> usize {
    match value.get("of") {
        Some(Json::Array(parts)) => parts.iter().map(simple_parts).sum(),
        _ => 1,
    }
}

/// The gap of a scene; `from` has what it names.
pub(super) fn whole(value: &Json, path: &str, from: &Sources) -> Result<AnyGap, InputError> {
    at_most(MOST_PARTS, simple_parts(value), path, "gaps in one another")?;
    gap(value, path, from)
}

/// The gap described by `value`, which stands at `path`; `from` has what it names.
fn gap(value: &Json, path: &str, from: &Sources) -> Result<AnyGap, InputError> {
    let inner = own(value, path, from)?;
    let Place { at, rotate } = decode(value, path)?;
    if at.is_none() && rotate.is_none() {
        return Ok(inner);
    }
    let turn = rotate.unwrap_or(0.0).rem_euclid(360.0).to_radians();
    inner.placed(at.unwrap_or([0.0; 2]), turn).map_err(|e| e.within(path))
}

/// The gap in its own place.
fn own(value: &Json, path: &str, from: &Sources) -> Result<AnyGap, InputError> {
    if from.any_gap() && matches!(value.get("kind"), Some(Json::String(kind)) if kind == "given") {
        let GivenForm { name } = decode_kind(value, path, "kind", &COMMON)?;
        return from.gap(&name).map_err(|e| e.within(path));
    }
    let built = match decode_kind(value, path, "kind", &COMMON)? {
        GapForm::Paraboloid(form) => form.build(),
        GapForm::Sphere(form) => form.build(),
        GapForm::Cone(form) => form.build(),
        GapForm::Power(form) => form.build(),
        GapForm::Pyramid(form) => form.build(),
        GapForm::Berkovich(form) => form.berkovich(),
        GapForm::Vickers(form) => form.vickers(),
        GapForm::CubeCorner(form) => form.cube_corner(),
        GapForm::Polyhedron(form) => form.build(),
        GapForm::Flat(form) => form.build(),
        GapForm::Revolved(form) => form.build(),
        GapForm::Formula(form) => form.build(),
        GapForm::HeightMap(form) => form.build(from),
        GapForm::Profile(form) => form.build(from.files).map(AnyGap::new),
        GapForm::Sum(_) => Sum::new(parts(value, path, from)?).map(AnyGap::new),
        GapForm::Min(_) => Minimum::new(parts(value, path, from)?).map(AnyGap::new),
    };
    built.map_err(|e| e.within(path))
}

fn parts(value: &Json, path: &str, from: &Sources) -> Result<Vec<AnyGap>, InputError> {
    match value.get("of") {
        Some(Json::Array(items)) => {
            items.iter().enumerate().map(|(k, item)| gap(item, &format!("{path}.of[{k}]"), from)).collect()
        }
        other => {
            let given = other.map_or_else(|| "nothing".into(), Json::brief);
            Err(InputError::new(format!("{path}.of"), given, "a list of gaps"))
        }
    }
}
