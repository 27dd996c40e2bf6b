//! What is known about a gap from the way it is written, at no depth in particular.
//!
//! Nothing here is sampled: a closed form, a law of similarity or a proof may rest on every entry. `None` means "not known", never "not so".

use std::sync::Arc;

use super::{Outline, Reach};
use crate::numeric::geometry::Rect;

/// Facts about a gap that follow from its construction.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// A point to start from: the apex where there is one, else a low point.
    pub centre: [f64; 2],
    /// The gap's own origin: the point that it was drawn about.
    pub reference: [f64; 2],
    /// Centres of the parts that the gap is made of, when there are several.
    pub tips: Vec<[f64; 2]>,
    /// The gap is nowhere less; minus infinity when no bound is known.
    pub floor: f64,
    /// Similarity about [`Known::centre`].
    pub law: Option<Law>,
    /// The gap as a polynomial of second degree, everywhere.
    pub quadratic: Option<Quadratic>,
    /// The axis, when the gap depends on the distance from it alone.
    pub axis: Option<Axis>,
    /// A flat (or tilted) face with a sharp edge: a plane inside an outline, no material outside.
    pub face: Option<Face>,
    /// The same with a curved face.
    pub crown: Option<Crown>,
    /// Where there can be material.
    pub material: Material,
    /// Whether the gap is its own image in the lines x = c and y = c through [`Known::centre`].
    pub mirrors: [bool; 2],
    /// A direction, radians counter-clockwise from x, along which the gap falls below any depth again and again, without end, that it is below
    /// anywhere: that of a row of waves.
    pub recurs_along: Option<f64>,
    /// Corners of a polygon outside of which there is no material, where that is known of a gap that ends at straight edges.
    pub ends: Option<Arc<[[f64; 2]]>>,
    /// Angle of the axes that it was drawn along, radians counter-clockwise from x: those of its longest straight edge, else its own. Any
    /// value is true; the right one saves work.
    pub drawn_along: f64,
}

impl Known {
    /// Nothing is known: any closure.
    #[must_use]
    pub const fn nothing() -> Self {
        Self {
            centre: [0.0; 2],
            reference: [0.0; 2],
            tips: Vec::new(),
            floor: f64::NEG_INFINITY,
            law: None,
            quadratic: None,
            axis: None,
            face: None,
            crown: None,
            material: Material::Unknown,
            mirrors: [false; 2],
            recurs_along: None,
            ends: None,
            drawn_along: 0.0,
        }
    }

    /// Whether a law, a form or an axis is known, from which force and pressure follow sooner than from values.
    pub(super) fn is_telling(&self) -> bool {
        self.law.is_some() || self.quadratic.is_some() || self.axis.is_some()
    }

    /// The degree of a law whose least value is 0: then P ~ d^(1 + 1/k).
    #[must_use]
    pub fn degree(&self) -> Option<Degree> {
        self.law.filter(|law| law.lowest == 0.0).map(|law| law.degree)
    }
}

/// g(c + s v) - g0 = s^k (g(c + v) - g0) for every s > 0 and every v: all contacts are similar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// k.
    pub degree: Degree,
    /// g0, the gap at the centre c.
    pub lowest: f64,
}

impl Law {
    /// dP/dd of a force P ~ s^(1 + 1/k) at the overlap s = d - g0.
    pub(crate) fn stiffness(&self, force: f64, overlap: f64) -> f64 {
        (1.0 + self.degree.inverse()) * force / overlap
    }

    /// The energy that it stores.
    pub(crate) fn energy(&self, force: f64, overlap: f64) -> f64 {
        force * overlap / (2.0 + self.degree.inverse())
    }
}

/// The degree of a homogeneous gap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Degree {
    /// k > 0.
    Power(f64),
    /// Zero inside a fixed plan-form, no material outside: the limit of k without end. The force grows as the depth.
    Flat,
}

impl Degree {
    /// 1/k.
    #[must_use]
    pub fn inverse(self) -> f64 {
        match self {
            Self::Power(k) => 1.0 / k,
            Self::Flat => 0.0,
        }
    }
}

/// value + gradient . v + v . H v/2 with v measured from `about`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic {
    /// The point that the polynomial is expanded about.
    pub about: [f64; 2],
    /// The gap there.
    pub value: f64,
    /// Its slopes there.
    pub gradient: [f64; 2],
    /// xx, xy, yy.
    pub hessian: [f64; 3],
}

impl Quadratic {
    /// The same polynomial about another point.
    #[must_use]
    pub fn about(&self, point: [f64; 2]) -> Self {
        let [x, y] = [point[0] - self.about[0], point[1] - self.about[1]];
        let [xx, xy, yy] = self.hessian;
        let rise = [xx * x + xy * y, xy * x + yy * y];
        let [gx, gy] = self.gradient;
        Self {
            about: point,
            value: self.value + (gx + 0.5 * rise[0]) * x + (gy + 0.5 * rise[1]) * y,
            gradient: [gx + rise[0], gy + rise[1]],
            hessian: self.hessian,
        }
    }

    /// The sum of both, about the point of the one that curves more.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let size = |q: &Self| q.hessian.iter().fold(0.0_f64, |m, h| m.max(h.abs()));
        let (keep, moved) = if size(self) >= size(other) { (self, other) } else { (other, self) };
        let moved = moved.about(keep.about);
        Self {
            about: keep.about,
            value: keep.value + moved.value,
            gradient: [0, 1].map(|m| keep.gradient[m] + moved.gradient[m]),
            hessian: [0, 1, 2].map(|m| keep.hessian[m] + moved.hessian[m]),
        }
    }

    /// The lowest point, of a form that curves upwards in every direction.
    #[must_use]
    pub fn lowest(&self) -> Option<[f64; 2]> {
        let [xx, xy, yy] = self.hessian;
        let det = xx * yy - xy * xy;
        let [gx, gy] = self.gradient;
        let step = [(yy * gx - xy * gy) / det, (xx * gy - xy * gx) / det];
        let found = xx > 0.0 && det > 0.0 && step.iter().all(|s| s.is_finite());
        found.then(|| [self.about[0] - step[0], self.about[1] - step[1]])
    }

    /// The gap is nowhere less; minus infinity when it falls in some direction.
    #[must_use]
    pub fn floor(&self) -> f64 {
        match self.lowest() {
            Some(point) => {
                let low = self.about(point).value;
                // What rounding hides of it.
                let size = self.value.abs()
                    + self
                        .gradient
                        .iter()
                        .zip(point.iter().zip(self.about))
                        .map(|(g, (p, a))| (g * (p - a)).abs())
                        .sum::<f64>();
                low - 16.0 * f64::EPSILON * size
            }
            // A cylinder, a plane: flat along one direction at least.
            None if self.gradient == [0.0; 2] && self.is_trough() => self.value,
            None => f64::NEG_INFINITY,
        }
    }

    /// Whether the form falls in no direction.
    fn is_trough(&self) -> bool {
        let [xx, xy, yy] = self.hessian;
        xx >= 0.0 && yy >= 0.0 && xx * yy - xy * xy >= 0.0
    }

    /// Where the form is less than a depth; `None` where rounding decides whether it rises in every direction.
    #[must_use]
    pub fn reach(&self, depth: f64) -> Option<Reach> {
        let Some(centre) = self.lowest() else { return self.endless(depth) };
        let overlap = depth - self.floor();
        if overlap <= 0.0 {
            return Some(Reach::Nowhere);
        }
        // Half sides of the box around v . H v/2 = overlap: sqrt(2 overlap (H^-1)_mm).
        let [xx, xy, yy] = self.hessian;
        let det = xx * yy - xy * xy;
        // What cancels in the determinant counts in full.
        let room = 1.0 + 8.0 * f64::EPSILON * (1.0 + xx * yy / det);
        let half = [yy, xx].map(|h| room * (2.0 * (h / det)).sqrt() * overlap.sqrt());
        let margin = [0, 1].map(|m| 8.0 * f64::EPSILON * (centre[m].abs() + self.about[m].abs()));
        let rect = Rect::around(centre, [half[0] + margin[0], half[1] + margin[1]]);
        half.iter().all(|h| h.is_finite()).then_some(Reach::Within(rect))
    }

    /// A ray along which the form falls, or stays below a depth.
    fn endless(&self, depth: f64) -> Option<Reach> {
        let [xx, xy, yy] = self.hessian;
        let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
        // The axes, and the principal direction of the lesser curvature.
        for (sin, cos) in [(0.0, 1.0), (1.0, 0.0), (turn.cos(), -turn.sin())] {
            let [hx, hy, hxy] = [xx * cos * cos, yy * sin * sin, 2.0 * xy * sin * cos];
            let (curvature, rounding) = (hx + hy + hxy, 1e-14 * (hx.abs() + hy.abs() + hxy.abs()));
            let slope = self.gradient[0] * cos + self.gradient[1] * sin;
            let sense = if slope > 0.0 { -1.0 } else { 1.0 };
            let direction = [sense * cos, sense * sin];
            let excess = (self.value - depth).max(0.0);
            let along = direction[1].atan2(direction[0]);
            let at = |t: f64| [self.about[0] + t * direction[0], self.about[1] + t * direction[1]];
            if curvature < -rounding {
                let t = 2.0 * (2.0 * excess / -curvature).sqrt();
                return Some(Reach::Unbounded { from: at(t), along });
            }
            if curvature == 0.0 && slope != 0.0 && xy == 0.0 {
                return Some(Reach::Unbounded { from: at(2.0 * excess / slope.abs()), along });
            }
            if curvature == 0.0 && slope == 0.0 && xy == 0.0 {
                // A cylinder: its lowest line.
                let (across, bend) = (if cos == 0.0 { 0 } else { 1 }, if cos == 0.0 { xx } else { yy });
                let mut from = self.about;
                if bend > 0.0 {
                    from[across] -= self.gradient[across] / bend;
                }
                if self.about(from).value < depth {
                    return Some(Reach::Unbounded { from, along });
                }
                return (depth <= self.floor()).then_some(Reach::Nowhere);
            }
        }
        None
    }

    /// Whether the form curves upwards by the same amount in every direction.
    #[must_use]
    pub fn is_round(&self) -> bool {
        let [xx, xy, yy] = self.hessian;
        xx == yy && xy == 0.0 && xx > 0.0
    }
}

/// An axis of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Where it meets the surface.
    pub at: [f64; 2],
    /// What is known of the generatrix.
    pub generatrix: Generatrix,
}

/// g as a function of the distance r from an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Generatrix {
    /// g0 + c r^n.
    Power {
        /// c > 0.
        coefficient: f64,
        /// n > 0.
        exponent: f64,
        /// g0.
        lowest: f64,
    },
    /// g0 + R - sqrt(R^2 - r^2), no material beyond R.
    Sphere {
        /// R.
        radius: f64,
        /// g0.
        lowest: f64,
    },
    /// g0 + r^2/(2 R) up to r = R t, beyond it a flank of slope t that continues it.
    RoundedCone {
        /// R.
        radius: f64,
        /// t.
        slope: f64,
        /// g0.
        lowest: f64,
    },
    /// Any other.
    General,
}

impl Generatrix {
    /// That of the sum of two gaps about one axis.
    #[must_use]
    pub fn plus(a: &Self, b: &Self) -> Self {
        match (*a, *b) {
            (
                Self::Power { coefficient: c, exponent: n, lowest: p },
                Self::Power { coefficient: d, exponent: m, lowest: q },
            ) if n == m => Self::Power { coefficient: c + d, exponent: n, lowest: p + q },
            _ => Self::General,
        }
    }
}

/// A plane inside an outline.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The outline, in a frame of its own.
    pub outline: Outline,
    /// Where the origin of that frame lies.
    pub at: [f64; 2],
    /// By how much it is turned, radians.
    pub turn: f64,
    /// The gap at `at`.
    pub value: f64,
    /// Its slopes along x and y.
    pub slope: [f64; 2],
}

impl Face {
    /// As a form without curvature.
    pub(super) fn crown(&self) -> Crown {
        let form = Quadratic { about: self.at, value: self.value, gradient: self.slope, hessian: [0.0; 3] };
        Crown { outline: self.outline.clone(), at: self.at, turn: self.turn, form }
    }

    /// Where it is lowest, and the gap there: the point of the outline farthest down the slope.
    pub(crate) fn lowest(&self) -> ([f64; 2], f64) {
        let ([sx, sy], (sin, cos)) = (self.slope, self.turn.sin_cos());
        let [u, v] = [cos * sx + sin * sy, cos * sy - sin * sx];
        let (p, fall) = match self.outline.semi_axes() {
            Some([a, b]) => {
                let fall = (a * u).hypot(b * v);
                let at =
                    |semi_axis: f64, slope: f64| if fall > 0.0 { -semi_axis * (semi_axis * slope / fall) } else { 0.0 };
                ([at(a, u), at(b, v)], -fall)
            }
            None => {
                let along = |p: &[f64; 2]| u * p[0] + v * p[1];
                let lower = |p: &&[f64; 2], q: &&[f64; 2]| along(p).total_cmp(&along(q));
                let corner = self.outline.corners().iter().min_by(lower).copied().unwrap_or_default();
                (corner, along(&corner))
            }
        };
        let at = [self.at[0] + cos * p[0] - sin * p[1], self.at[1] + sin * p[0] + cos * p[1]];
        (at, self.value + fall)
    }
}

/// A polynomial of second degree inside an outline, no material outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Crown {
    /// The outline, in a frame of its own.
    pub outline: Outline,
    /// Where the origin of that frame lies.
    pub at: [f64; 2],
    /// By how much it is turned, radians.
    pub turn: f64,
    /// The gap inside.
    pub form: Quadratic,
}

impl Crown {
    /// The plane that it is where nothing curves.
    pub(super) fn face(&self) -> Option<Face> {
        let plane = Some(self.form.about(self.at)).filter(|form| form.hessian == [0.0; 3])?;
        let (outline, value, slope) = (self.outline.clone(), plane.value, plane.gradient);
        Some(Face { outline, at: self.at, turn: self.turn, value, slope })
    }
}

/// Where there can be material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Wherever the gap has a value: nothing is cut off.
    Everywhere,
    /// Inside this rectangle at most.
    Within(Rect),
    /// Not known.
    Unknown,
}
