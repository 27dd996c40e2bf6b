//! Fabrikant's flat punch, equations (10) and (11): pressure and stiffness for any star-shaped plan-form.

use std::f64::consts::{PI, TAU};

use super::approximation::Error;
use super::sectors::{SIXTH, Sectors};
use crate::error::{InputError, finite};
use crate::numeric::geometry::{area, centroid};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// A flat punch whose plan-form is r = a(theta) about its centroid.
///
/// Exact for ellipses and a few per cent off otherwise, with either sign: -3.65 % for the equilateral triangle, -1.5 % for
/// the square, +6 % for the rectangle 10:1.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatPunch {
    centroid: [f64; 2],
    area: f64,
    l: f64,
    shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Corners about the centroid, counter-clockwise.
    Polygon(Vec<[f64; 2]>),
    /// Semi-axes along x and y.
    Ellipse([f64; 2]),
}

impl FlatPunch {
    /// A polygon by its corners in order, of either sense. L in closed form: the sum over the edges of
    /// q (asinh(l2/q) - asinh(l1/q)), q the distance of the edge from the centroid, l1 and l2 its ends along it.
    ///
    /// ```
    /// use contact_patch::{EffectiveModulus, fabrikant::FlatPunch};
    /// let square = FlatPunch::polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])?;
    /// let modulus = EffectiveModulus::from_e_star(1.0)?;
    /// assert!((square.stiffness(modulus) - 1.134593).abs() < 1e-6); // exact: 1.152298
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An input error for fewer than three corners, numbers that are not finite, or no area; the verdict `NotStarShaped`
    /// when an edge is not seen from the centroid.
    pub fn polygon(corners: &[[f64; 2]]) -> Result<Self, Error> {
        if corners.len() < 3 {
            return Err(InputError::new("polygon", corners.len(), "at least three corners").into());
        }
        for (k, corner) in corners.iter().enumerate() {
            finite(&format!("polygon[{k}][0]"), corner[0])?;
            finite(&format!("polygon[{k}][1]"), corner[1])?;
        }
        let signed = area(corners);
        if !signed.is_normal() {
            return Err(InputError::new("polygon", "a polygon without area", "corners that enclose an area").into());
        }
        let middle = centroid(corners);
        let mut about: Vec<_> = corners.iter().map(|p| [p[0] - middle[0], p[1] - middle[1]]).collect();
        if signed < 0.0 {
            about.reverse();
        }
        let (mut l, mut turn) = (0.0, 0.0);
        for (k, (p, q)) in edges(&about).enumerate() {
            let [dx, dy] = [q[0] - p[0], q[1] - p[1]];
            let length = dx.hypot(dy);
            if length == 0.0 {
                continue;
            }
            let cross = p[0] * q[1] - p[1] * q[0];
            let distance = cross / length;
            turn += cross.atan2(p[0] * q[0] + p[1] * q[1]);
            // An edge on a line through the centroid is seen end on: the boundary has no single radius there.
            if distance <= 1e-13 * length {
                return Err(hidden(k, distance).into());
            }
            let along = |c: [f64; 2]| (c[0] * dx + c[1] * dy) / length;
            l += distance * ((along(q) / distance).asinh() - (along(p) / distance).asinh());
        }
        if (turn - TAU).abs() > 1e-6 {
            let reason = format!("the outline turns {:.3} times about its centroid, not once", turn / TAU);
            return Err(Unsolved::new(Verdict::NotStarShaped, reason).into());
        }
        Ok(Self { centroid: middle, area: signed.abs(), l, shape: Shape::Polygon(about) })
    }

    /// An ellipse about the origin with these semi-axes along x and y: here the equations are exact.
    ///
    /// # Errors
    /// Names the semi-axis that is not a finite number greater than zero.
    pub fn ellipse(semi_axes: [f64; 2]) -> Result<Self, Error> {
        let a = crate::error::positive("ellipse[0]", semi_axes[0])?;
        let b = crate::error::positive("ellipse[1]", semi_axes[1])?;
        // L = 4 b K(e): 2 pi over the arithmetic-geometric mean of 1/a and 1/b.
        let l = TAU * a * b / agm(a, b);
        Ok(Self { centroid: [0.0; 2], area: PI * a * b, l, shape: Shape::Ellipse(semi_axes) })
    }

    /// Any plan-form r = a(theta) about `centre`, its corners at the angles `corners` (radians). The centroid is not
    /// moved: the caller says where it is, and an error tells when it is elsewhere.
    ///
    /// Returns L, the area, and the relative error estimate of L.
    ///
    /// # Errors
    /// `NotStarShaped` where a(theta) is not a positive number, or when the centroid of the region lies more than 1e-6 of
    /// its size away from the centre.
    pub fn integrals(a: impl Fn(f64) -> f64, corners: &[f64]) -> Result<(f64, f64, f64), Error> {
        let mut sectors = Sectors::between(corners, SIXTH);
        let mut nodes = Vec::new();
        loop {
            sectors.nodes(&mut nodes);
            let radii: Vec<f64> = nodes.iter().map(|s| a(s.angle)).collect();
            if let Some(k) = radii.iter().position(|r| !(*r > 0.0 && r.is_finite())) {
                let reason = format!("a(theta) = {} at {:.4} degrees", radii[k], nodes[k].angle.to_degrees());
                return Err(Unsolved::new(Verdict::NotStarShaped, reason).into());
            }
            let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
                nodes.iter().zip(&radii).map(|(s, &r)| s.fine * f(s.angle, r)).sum()
            };
            let l = sum(&|_, r| r);
            let error = sectors.error(&nodes, &radii);
            if error <= 1e-13 * l || !sectors.refine(&nodes, &radii, 1e-13 * l, 20_000) {
                let area = 0.5 * sum(&|_, r| r * r);
                let off = sum(&|t, r| r.powi(3) * t.cos()).hypot(sum(&|t, r| r.powi(3) * t.sin())) / (3.0 * area);
                if off > 1e-6 * area.sqrt() {
                    let reason = format!("the centroid lies {off:e} away from the centre of r = a(theta)");
                    return Err(Unsolved::new(Verdict::NotStarShaped, reason).into());
                }
                return Ok((l, area, error / l));
            }
        }
    }

    /// Force per depth, 4 E* A/L (equation 10 integrated).
    #[must_use]
    pub fn stiffness(&self, modulus: EffectiveModulus) -> f64 {
        4.0 * modulus.e_star() * (self.area / self.l)
    }

    /// Pressure at a point for this depth (equation 10); zero outside, infinite on the outline.
    #[must_use]
    pub fn pressure(&self, modulus: EffectiveModulus, depth: f64, at: [f64; 2]) -> f64 {
        let [x, y] = [at[0] - self.centroid[0], at[1] - self.centroid[1]];
        let r = x.hypot(y);
        // At the centroid every direction gives the same.
        let a = if r > 0.0 { self.radius(y.atan2(x)) } else { 1.0 };
        let rho = r / a;
        if rho > 1.0 {
            return 0.0;
        }
        2.0 * modulus.e_star() * depth / (self.l * ((1.0 - rho) * (1.0 + rho)).sqrt())
    }

    /// a(theta) about the centroid, theta in radians.
    #[must_use]
    pub fn radius(&self, theta: f64) -> f64 {
        let (sin, cos) = theta.sin_cos();
        match &self.shape {
            Shape::Ellipse([a, b]) => 1.0 / (cos / a).hypot(sin / b),
            Shape::Polygon(corners) => {
                // The edge that the ray crosses: its ends lie on either side.
                let side = |p: [f64; 2]| cos * p[1] - sin * p[0];
                edges(corners)
                    .filter(|&(p, q)| side(p) <= 0.0 && side(q) > 0.0)
                    .map(|(p, q)| (p[0] * q[1] - p[1] * q[0]) / (side(q) - side(p)))
                    .next()
                    .unwrap_or_default()
            }
        }
    }

    /// L, the integral of a(theta) (equation 11).
    #[must_use]
    pub fn l(&self) -> f64 {
        self.l
    }

    /// Area.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Centroid, the origin of the polar coordinates.
    #[must_use]
    pub fn centroid(&self) -> [f64; 2] {
        self.centroid
    }
}

fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(p, q)| (*p, *q))
}

fn hidden(edge: usize, distance: f64) -> Unsolved {
    Unsolved::new(
        Verdict::NotStarShaped,
        format!("edge {edge} is not seen from the centroid: its signed distance is {distance:e}"),
    )
}

/// Arithmetic-geometric mean.
pub(crate) fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..40 {
        if (a - b).abs() <= 2e-16 * a.abs() {
            break;
        }
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    0.5 * (a + b)
}
