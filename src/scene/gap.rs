//! The gap of a scene: one structure a kind, chosen by the key `kind`.

use serde::Deserialize;

use super::decode::{decode, decode_without, unknown};
use super::document::{Json, quoted};
use super::given::Sources;
use super::measured::{HeightMapForm, ProfileForm};
use crate::error::InputError;
#[cfg(feature = "formula")]
use crate::gap::Formula;
use crate::gap::{
    AnyGap, Cone, Flat, Minimum, Outline, Paraboloid, Polyhedron, Power, Revolved, RoundedTip, Sphere, Sum,
};

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
    Berkovich(IndenterForm),
    Vickers(IndenterForm),
    CubeCorner(IndenterForm),
    Polyhedron(PolyhedronForm),
    Flat(FlatForm),
    Revolved(RevolvedForm),
    Formula(FormulaForm),
    HeightMap(HeightMapForm),
    Profile(ProfileForm),
    Sum(PartsForm),
    Min(PartsForm),
}

const KINDS: [&str; 16] = [
    "paraboloid",
    "sphere",
    "cone",
    "power",
    "pyramid",
    "berkovich",
    "vickers",
    "cube_corner",
    "polyhedron",
    "flat",
    "revolved",
    "formula",
    "height_map",
    "profile",
    "sum",
    "min",
];

/// Keys that every kind takes.
const COMMON: [&str; 3] = ["kind", "at", "rotate"];

/// x^2/(2 R1) + y^2/(2 R2).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct ParaboloidForm {
    /// Relative radii of curvature along x and y, greater than 0; "flat" or null for a straight generator.
    radii: [Option<RadiusForm>; 2],
}

/// A radius of curvature, or the word for none.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema), schemars(untagged))]
pub(super) enum RadiusForm {
    Length(f64),
    Straight(StraightForm),
}

/// A straight generator: the radius of curvature is infinite.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema), schemars(rename_all = "snake_case"))]
pub(super) enum StraightForm {
    Flat,
}

impl<'de> Deserialize<'de> for RadiusForm {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Either;
        impl serde::de::Visitor<'_> for Either {
            type Value = RadiusForm;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a number greater than 0, or \"flat\" for a straight generator")
            }

            fn visit_f64<E: serde::de::Error>(self, length: f64) -> Result<RadiusForm, E> {
                Ok(RadiusForm::Length(length))
            }

            fn visit_u64<E: serde::de::Error>(self, length: u64) -> Result<RadiusForm, E> {
                Ok(RadiusForm::Length(length as f64))
            }

            fn visit_i64<E: serde::de::Error>(self, length: i64) -> Result<RadiusForm, E> {
                Ok(RadiusForm::Length(length as f64))
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<RadiusForm, E> {
                match word {
                    "flat" => Ok(RadiusForm::Straight(StraightForm::Flat)),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
                }
            }
        }
        from.deserialize_any(Either)
    }
}

impl RadiusForm {
    fn value(this: Option<Self>) -> f64 {
        match this {
            Some(Self::Length(radius)) => radius,
            Some(Self::Straight(StraightForm::Flat)) | None => f64::INFINITY,
        }
    }
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
    /// Radius of curvature of a round tip, greater than 0: a parabola that the flank touches.
    rounded: Option<f64>,
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
    /// Radius of curvature of a round tip and of the edges between the faces, greater than 0; not with `flat`.
    rounded: Option<f64>,
}

/// A pyramid that is pointed, cut off or round.
fn tipped(faces: usize, inclination: f64, flat: Option<f64>, rounded: Option<f64>) -> Result<AnyGap, InputError> {
    match (flat, rounded) {
        (None, None) => Polyhedron::pyramid(faces, inclination).map(AnyGap::new),
        (Some(flat), None) => Polyhedron::truncated_pyramid(faces, inclination, flat).map(AnyGap::new),
        (None, Some(radius)) => RoundedTip::pyramid(faces, inclination, radius).map(AnyGap::new),
        (Some(_), Some(radius)) => Err(InputError::new("rounded", radius, "a tip that is either rounded or flat")),
    }
}

/// An indenter: a regular pyramid by its name. Face angles are counted from the axis to a face, as ISO 14577 does: 65.27 degrees
/// (berkovich, the modified one), 68 (vickers: 136 between opposite faces), 35.26 (cube_corner). The inclination of a pyramid is 90
/// degrees less.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub(super) struct IndenterForm {
    /// Angle between the axis and a face, degrees, greater than 0 and less than 90, where it is not the nominal one.
    face_angle: Option<f64>,
    /// Inradius of a flat tip.
    flat: Option<f64>,
    /// Radius of curvature of a round tip and of the edges between the faces, greater than 0; not with `flat`.
    rounded: Option<f64>,
}

impl IndenterForm {
    /// The nominal face angle is given by its tangent.
    fn build(&self, faces: usize, tangent: f64) -> Result<AnyGap, InputError> {
        let inclination = match self.face_angle {
            None => (1.0 / tangent).atan(),
            Some(angle) if angle > 0.0 && angle < 90.0 => (90.0 - angle).to_radians(),
            Some(angle) => {
                let allowed = "an angle between the axis and a face greater than 0 and less than 90 degrees: half of that between opposite \
                               faces (68 where those make 136), 90 less the inclination";
                return Err(InputError::new("face_angle", angle, allowed));
            }
        };
        tipped(faces, inclination, self.flat, self.rounded)
    }
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
            Self::Polygon(corners) => {
                at_most(MOST_CORNERS, corners.len(), "polygon", "corners")?;
                Outline::polygon(&corners)
            }
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

/// A gap written as an expression in x, y, r and theta.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[cfg_attr(not(feature = "formula"), expect(dead_code, reason = "read, then refused by name"))]
pub(super) struct FormulaForm {
    /// For instance "x^2/2 + 0.1*abs(y)^3".
    expression: String,
    /// Where the body has material; everywhere when left out.
    region: Option<OutlineForm>,
}

/// A gap that the calling program holds; files cannot say it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenForm {
    name: String,
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

/// Nominal angles between axis and face, degrees (ISO 14577-2:2015, section 4.2).
const BERKOVICH: f64 = 65.27;
const VICKERS: f64 = 68.0;

/// Most gaps that a sum or a minimum is made of, those inside of others counted: what is asked of the whole is asked of each.
const MOST_PARTS: usize = 1000;

/// Most planes of a polyhedron: to find its ridges takes the square of them.
const MOST_PLANES: usize = 1000;

/// Most points of a generatrix.
const MOST_POINTS: usize = 100_000;

/// Most corners of an outline.
const MOST_CORNERS: usize = 10_000;

/// # Errors
/// When there are more of something than are allowed.
fn at_most(most: usize, number: usize, path: &str, of: &str) -> Result<(), InputError> {
    if number <= most {
        return Ok(());
    }
    Err(InputError::new(path, format!("{number} {of}"), format!("at most {most} of them")))
}

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
    let Json::Object(_) = value else {
        return Err(InputError::new(path, value.brief(), "an object with the key kind"));
    };
    let kind_path = format!("{path}.kind");
    let kind = match value.get("kind") {
        Some(Json::String(kind)) => kind.as_str(),
        Some(other) => return Err(InputError::new(kind_path, other.brief(), format!("one of: {}", KINDS.join(", ")))),
        None => {
            let given = if value.get("type").is_some() { "nothing (\"type\" stands in its place)" } else { "nothing" };
            return Err(InputError::new(kind_path, given, format!("one of: {}", KINDS.join(", "))));
        }
    };
    let inner = own(kind, value, path, from)?;
    let Place { at, rotate } = decode(value, path)?;
    if at.is_none() && rotate.is_none() {
        return Ok(inner);
    }
    let turn = rotate.unwrap_or(0.0).rem_euclid(360.0).to_radians();
    inner.placed(at.unwrap_or([0.0; 2]), turn).map_err(|e| e.within(path))
}

/// The gap of this kind in its own place.
fn own(kind: &str, value: &Json, path: &str, from: &Sources) -> Result<AnyGap, InputError> {
    let built = match kind {
        "paraboloid" => {
            let ParaboloidForm { radii } = form(value, path)?;
            Paraboloid::new(radii.map(RadiusForm::value)).map(AnyGap::new)
        }
        "sphere" => {
            let SphereForm { radius } = form(value, path)?;
            Sphere::new(radius).map(AnyGap::new)
        }
        "cone" => {
            let ConeForm { inclination, rounded } = form(value, path)?;
            radians(inclination).and_then(|inclination| match rounded {
                None => Cone::new(inclination).map(AnyGap::new),
                Some(radius) => RoundedTip::cone(inclination, radius).map(AnyGap::new),
            })
        }
        "power" => {
            let PowerForm { coefficient, exponent } = form(value, path)?;
            Power::new(coefficient, exponent).map(AnyGap::new)
        }
        "pyramid" => {
            let PyramidForm { faces, inclination, flat, rounded } = form(value, path)?;
            radians(inclination).and_then(|inclination| tipped(faces, inclination, flat, rounded))
        }
        "berkovich" => {
            let indenter: IndenterForm = form(value, path)?;
            indenter.build(3, BERKOVICH.to_radians().tan())
        }
        "vickers" => {
            let indenter: IndenterForm = form(value, path)?;
            indenter.build(4, VICKERS.to_radians().tan())
        }
        "cube_corner" => {
            let indenter: IndenterForm = form(value, path)?;
            // Faces of a cube meet its diagonal at tan = 1/sqrt(2).
            indenter.build(3, std::f64::consts::FRAC_1_SQRT_2)
        }
        "polyhedron" => {
            let PolyhedronForm { planes } = form(value, path)?;
            at_most(MOST_PLANES, planes.len(), &format!("{path}.planes"), "planes")?;
            Polyhedron::new(planes).map(AnyGap::new)
        }
        "flat" => {
            let FlatForm { outline } = form(value, path)?;
            outline.build().map(|outline| AnyGap::new(Flat::new(outline))).map_err(|e| e.within("outline"))
        }
        "revolved" => {
            let RevolvedForm { points } = form(value, path)?;
            at_most(MOST_POINTS, points.len(), &format!("{path}.points"), "points")?;
            Revolved::new(points).map(AnyGap::new)
        }
        #[cfg(feature = "formula")]
        "formula" => {
            let FormulaForm { expression, region } = form(value, path)?;
            match region {
                None => Formula::new(&expression),
                Some(region) => region
                    .build()
                    .map_err(|e| e.within("region"))
                    .and_then(|region| Formula::within(&expression, region)),
            }
            .map(AnyGap::new)
        }
        #[cfg(not(feature = "formula"))]
        "formula" => {
            let _: FormulaForm = form(value, path)?;
            Err(InputError::new("kind", "formula", "another kind: this build has no formulas (feature formula)"))
        }
        "height_map" => {
            let map: HeightMapForm = form(value, path)?;
            map.build(from)
        }
        "profile" => {
            let profile: ProfileForm = form(value, path)?;
            profile.build(from.files).map(AnyGap::new)
        }
        "given" if from.any_gap() => {
            let GivenForm { name } = form(value, path)?;
            from.gap(&name)
        }
        "sum" => Sum::new(parts(value, path, from)?).map(AnyGap::new),
        "min" => Minimum::new(parts(value, path, from)?).map(AnyGap::new),
        _ => return Err(unknown(format!("{path}.kind"), quoted(kind), kind, &KINDS)),
    };
    built.map_err(|e| e.within(path))
}

fn form<'a, T: Deserialize<'a>>(value: &'a Json, path: &str) -> Result<T, InputError> {
    decode_without(value, path, &COMMON)
}

fn parts(value: &Json, path: &str, from: &Sources) -> Result<Vec<AnyGap>, InputError> {
    let _: PartsKeys = form(value, path)?;
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

fn radians(inclination: f64) -> Result<f64, InputError> {
    if inclination > 0.0 && inclination < 90.0 {
        return Ok(inclination.to_radians());
    }
    Err(InputError::new("inclination", inclination, "an angle greater than 0 and less than 90 degrees"))
}
