//! The gap of a scene: one structure a kind, chosen by the key `kind`.

use serde::Deserialize;

use super::decode::{decode, decode_without, unknown};
use super::document::{Json, quoted};
use crate::error::InputError;
use crate::gap::{AnyGap, Cone, Flat, Minimum, Outline, Paraboloid, Placed, Polyhedron, Power, Revolved, Sphere, Sum};

/// The initial gap of the undeformed bodies at zero depth.
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(tag = "kind", rename_all = "snake_case", transform = super::schema::with_place)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum GapForm {
    Paraboloid(ParaboloidForm),
    Sphere(SphereForm),
    Cone(ConeForm),
    Power(PowerForm),
    Pyramid(PyramidForm),
    Polyhedron(PolyhedronForm),
    Flat(FlatForm),
    Revolved(RevolvedForm),
    Sum(PartsForm),
    Min(PartsForm),
}

const KINDS: [&str; 10] =
    ["paraboloid", "sphere", "cone", "power", "pyramid", "polyhedron", "flat", "revolved", "sum", "min"];

/// Keys that every kind takes.
const COMMON: [&str; 3] = ["kind", "at", "rotate"];

/// x^2/(2 R1) + y^2/(2 R2).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct ParaboloidForm {
    /// Relative radii of curvature along x and y, greater than 0; null for a straight generator.
    radii: [Option<f64>; 2],
}

/// A true sphere.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct SphereForm {
    /// Radius, greater than 0.
    radius: f64,
}

/// A cone.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct ConeForm {
    /// Angle between the cone and the surface, degrees, greater than 0 and less than 90.
    inclination: f64,
}

/// coefficient r^exponent.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct PowerForm {
    /// Greater than 0.
    coefficient: f64,
    /// Greater than 0.
    exponent: f64,
}

/// A regular pyramid: tan(inclination) max over k of (x cos(2 pi k/faces) + y sin(2 pi k/faces)).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct PyramidForm {
    /// Number of faces, 2 (a wedge) or more.
    faces: usize,
    /// Angle between a face and the surface, degrees, greater than 0 and less than 90.
    inclination: f64,
    /// Inradius of the flat tip.
    flat: Option<f64>,
}

/// The highest of several planes.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct PolyhedronForm {
    /// [slope_x, slope_y, offset] each.
    planes: Vec<[f64; 3]>,
}

/// A flat punch: 0 inside the outline, no contact outside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct FlatForm {
    /// The edge.
    outline: OutlineForm,
}

/// A plan-form: radius, semi-axes, or corners.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) enum OutlineForm {
    Disc(f64),
    Ellipse([f64; 2]),
    Polygon(Vec<[f64; 2]>),
}

impl OutlineForm {
    fn build(self) -> Result<Outline, InputError> {
        match self {
            Self::Disc(radius) => Outline::disc(radius),
            Self::Ellipse(semi_axes) => Outline::ellipse(semi_axes),
            Self::Polygon(corners) => Outline::polygon(&corners),
        }
    }
}

/// A body of revolution.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct RevolvedForm {
    /// Points [r, z] of the generatrix, r rising; z is the gap.
    points: Vec<[f64; 2]>,
}

/// A gap made of others.
#[cfg(feature = "cli")]
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) struct PartsForm {
    /// The gaps, at least one.
    of: Vec<GapForm>,
}

/// Reads `of` without looking into the parts.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartsKeys {
    #[serde(rename = "of")]
    _of: Unread,
}

struct Unread;

impl<'de> Deserialize<'de> for Unread {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        serde::de::IgnoredAny::deserialize(from).map(|_| Self)
    }
}

/// Where a gap stands and how it is turned.
#[derive(Deserialize)]
struct Place {
    at: Option<[f64; 2]>,
    rotate: Option<f64>,
}

/// The gap described by `value`, which stands at `path`.
pub(super) fn gap(value: &Json, path: &str) -> Result<AnyGap, InputError> {
    let Json::Object(_) = value else {
        return Err(InputError::new(path, value.brief(), "an object with the key kind"));
    };
    let kind_path = format!("{path}.kind");
    let kind = match value.get("kind") {
        Some(Json::String(kind)) => kind.as_str(),
        Some(other) => return Err(InputError::new(kind_path, other.brief(), format!("one of: {}", KINDS.join(", ")))),
        None => return Err(InputError::new(kind_path, "nothing", format!("one of: {}", KINDS.join(", ")))),
    };
    let inner = own(kind, value, path)?;
    let Place { at, rotate } = decode(value, path)?;
    if at.is_none() && rotate.is_none() {
        return Ok(inner);
    }
    let turn = rotate.unwrap_or(0.0).rem_euclid(360.0).to_radians();
    Placed::new(inner, at.unwrap_or([0.0; 2]), turn).map(AnyGap::new).map_err(|e| e.within(path))
}

/// The gap of this kind in its own place.
fn own(kind: &str, value: &Json, path: &str) -> Result<AnyGap, InputError> {
    let built = match kind {
        "paraboloid" => {
            let ParaboloidForm { radii } = form(value, path)?;
            Paraboloid::new(radii.map(|r| r.unwrap_or(f64::INFINITY))).map(AnyGap::new)
        }
        "sphere" => {
            let SphereForm { radius } = form(value, path)?;
            Sphere::new(radius).map(AnyGap::new)
        }
        "cone" => {
            let ConeForm { inclination } = form(value, path)?;
            radians(inclination).and_then(Cone::new).map(AnyGap::new)
        }
        "power" => {
            let PowerForm { coefficient, exponent } = form(value, path)?;
            Power::new(coefficient, exponent).map(AnyGap::new)
        }
        "pyramid" => {
            let PyramidForm { faces, inclination, flat } = form(value, path)?;
            radians(inclination)
                .and_then(|inclination| match flat {
                    None => Polyhedron::pyramid(faces, inclination),
                    Some(flat) => Polyhedron::truncated_pyramid(faces, inclination, flat),
                })
                .map(AnyGap::new)
        }
        "polyhedron" => {
            let PolyhedronForm { planes } = form(value, path)?;
            Polyhedron::new(planes).map(AnyGap::new)
        }
        "flat" => {
            let FlatForm { outline } = form(value, path)?;
            outline.build().map(|outline| AnyGap::new(Flat::new(outline))).map_err(|e| e.within("outline"))
        }
        "revolved" => {
            let RevolvedForm { points } = form(value, path)?;
            Revolved::new(points).map(AnyGap::new)
        }
        "sum" => Sum::new(parts(value, path)?).map(AnyGap::new),
        "min" => Minimum::new(parts(value, path)?).map(AnyGap::new),
        _ => return Err(unknown(format!("{path}.kind"), quoted(kind), kind, &KINDS)),
    };
    built.map_err(|e| e.within(path))
}

fn form<'a, T: Deserialize<'a>>(value: &'a Json, path: &str) -> Result<T, InputError> {
    decode_without(value, path, &COMMON)
}

fn parts(value: &Json, path: &str) -> Result<Vec<AnyGap>, InputError> {
    let _: PartsKeys = form(value, path)?;
    match value.get("of") {
        Some(Json::Array(items)) => {
            items.iter().enumerate().map(|(k, item)| gap(item, &format!("{path}.of[{k}]"))).collect()
        }
        other => {
            let given = other.map_or_else(|| "nothing".into(), Json::brief);
            Err(InputError::new(format!("{path}.of"), given, "a list of gaps"))
        }
    }
}

fn radians(inclination: f64) -> Result<f64, InputError> {
    if inclination > 0.0 && inclination < 90.0 {
        return Ok(inclination.to_radians());
    }
    Err(InputError::new("inclination", inclination, "an angle greater than 0 and less than 90 degrees"))
}
