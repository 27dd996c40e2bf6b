//! Shapes that a scene writes as numbers: one structure each, which reads the file, makes the JSON Schema and builds the gap.

use serde::Deserialize;

use crate::error::InputError;
use crate::gap::{AnyGap, Cone, Flat, Outline, Paraboloid, Polyhedron, Power, Revolved, RoundedTip, Sphere};
#[cfg(feature = "formula")]
use crate::gap::{Formula, Minimum};

/// Most planes of a polyhedron: to find its ridges takes the square of them.
const MOST_PLANES: usize = 1000;

/// Most points of a generatrix.
const MOST_POINTS: usize = 100_000;

/// Most corners of an outline.
const MOST_CORNERS: usize = 10_000;

/// # Errors
/// When there are more of something than are allowed.
pub(super) fn at_most(most: usize, number: usize, path: &str, of: &str) -> Result<(), InputError> {
    if number <= most {
        return Ok(());
    }
    Err(InputError::new(path, format!("{number} {of}"), format!("at most {most} of them")))
}

fn radians(inclination: f64) -> Result<f64, InputError> {
    if inclination > 0.0 && inclination < 90.0 {
        return Ok(inclination.to_radians());
    }
    Err(InputError::new("inclination", inclination, "an angle greater than 0 and less than 90 degrees"))
}

/// x^2/(2 R1) + y^2/(2 R2).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ParaboloidForm {
    /// Relative radii of curvature along x and y, greater than 0; "flat" or null for a straight generator.
    radii: [Option<RadiusForm>; 2],
}

/// A radius of curvature, or the word for none.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "a number greater than 0, or \"flat\" for a straight generator")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum RadiusForm {
    Length(f64),
    Straight(StraightForm),
}

/// A straight generator: the radius of curvature is infinite.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum StraightForm {
    Flat,
}

impl ParaboloidForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        let radii = self.radii.map(|radius| match radius {
            Some(RadiusForm::Length(radius)) => radius,
            Some(RadiusForm::Straight(StraightForm::Flat)) | None => f64::INFINITY,
        });
        Paraboloid::new(radii).map(AnyGap::new)
    }
}

/// A true sphere.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct SphereForm {
    /// Radius, greater than 0.
    radius: f64,
}

impl SphereForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        Sphere::new(self.radius).map(AnyGap::new)
    }
}

/// A cone.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ConeForm {
    /// Angle between the cone and the surface, degrees, greater than 0 and less than 90.
    inclination: f64,
    /// Radius of curvature of a round tip, greater than 0: a parabola that the flank touches.
    rounded: Option<f64>,
}

impl ConeForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        let inclination = radians(self.inclination)?;
        match self.rounded {
            None => Cone::new(inclination).map(AnyGap::new),
            Some(radius) => RoundedTip::cone(inclination, radius).map(AnyGap::new),
        }
    }
}

/// coefficient r^exponent.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct PowerForm {
    /// Greater than 0.
    coefficient: f64,
    /// Greater than 0.
    exponent: f64,
}

impl PowerForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        Power::new(self.coefficient, self.exponent).map(AnyGap::new)
    }
}

/// A regular pyramid: tan(inclination) max over k of (x cos(2 pi k/faces) + y sin(2 pi k/faces)).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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

impl PyramidForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        tipped(self.faces, radians(self.inclination)?, self.flat, self.rounded)
    }
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

/// Nominal angles between axis and face, degrees (ISO 14577-2:2015, section 4.2).
const BERKOVICH: f64 = 65.27;
const VICKERS: f64 = 68.0;

/// An indenter: a regular pyramid by its name. Face angles are counted from the axis to a face, as ISO 14577 does: 65.27 degrees
/// (berkovich, the modified one), 68 (vickers: 136 between opposite faces), 35.26 (cube_corner). The inclination of a pyramid is 90
/// degrees less.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct IndenterForm {
    /// Angle between the axis and a face, degrees, greater than 0 and less than 90, where it is not the nominal one.
    face_angle: Option<f64>,
    /// Inradius of a flat tip.
    flat: Option<f64>,
    /// Radius of curvature of a round tip and of the edges between the faces, greater than 0; not with `flat`.
    rounded: Option<f64>,
}

impl IndenterForm {
    pub fn berkovich(self) -> Result<AnyGap, InputError> {
        self.build(3, BERKOVICH.to_radians().tan())
    }

    pub fn vickers(self) -> Result<AnyGap, InputError> {
        self.build(4, VICKERS.to_radians().tan())
    }

    pub fn cube_corner(self) -> Result<AnyGap, InputError> {
        // Faces of a cube meet its diagonal at tan = 1/sqrt(2).
        self.build(3, std::f64::consts::FRAC_1_SQRT_2)
    }

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
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct PolyhedronForm {
    /// [slope_x, slope_y, offset] each.
    planes: Vec<[f64; 3]>,
}

impl PolyhedronForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        at_most(MOST_PLANES, self.planes.len(), "planes", "planes")?;
        Polyhedron::new(self.planes).map(AnyGap::new)
    }
}

/// A flat punch: 0 inside the outline, no contact outside.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct FlatForm {
    /// The edge.
    outline: OutlineForm,
}

impl FlatForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        self.outline.build().map(|outline| AnyGap::new(Flat::new(outline))).map_err(|e| e.within("outline"))
    }
}

/// A plan-form: radius, semi-axes, or corners.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct RevolvedForm {
    /// Points [r, z] of the generatrix, r rising; z is the gap.
    points: Vec<[f64; 2]>,
}

impl RevolvedForm {
    pub fn build(self) -> Result<AnyGap, InputError> {
        at_most(MOST_POINTS, self.points.len(), "points", "points")?;
        Revolved::new(self.points).map(AnyGap::new)
    }
}

/// A gap written as an expression in x, y, r and theta.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(not(feature = "formula"), expect(dead_code, reason = "read, then refused by name"))]
pub(super) struct FormulaForm {
    /// For instance "x^2/2 + 0.1*abs(y)^3".
    expression: String,
    /// Where the body has material; everywhere when left out.
    region: Option<OutlineForm>,
}

impl FormulaForm {
    #[cfg(feature = "formula")]
    pub fn build(self) -> Result<AnyGap, InputError> {
        let formula = match self.region {
            None => Formula::new(&self.expression),
            Some(region) => {
                let region = region.build().map_err(|e| e.within("region"))?;
                Formula::within(&self.expression, region)
            }
        }?;
        match formula.parts() {
            Some(parts) => Minimum::new(parts.into_iter().map(AnyGap::new).collect()).map(AnyGap::new),
            None => Ok(AnyGap::new(formula)),
        }
    }

    #[cfg(not(feature = "formula"))]
    pub fn build(self) -> Result<AnyGap, InputError> {
        Err(InputError::new("kind", "formula", "another kind: this build has no formulas (feature formula)"))
    }
}
