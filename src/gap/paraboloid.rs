//! A paraboloid.

use super::{Axis, Cubic, Degree, Gap, Generatrix, Growth, Known, Law, Material, Quadratic, Reach, Taylor};
use crate::error::InputError;
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Room for the rounding of a radius.
const ROUNDING: f64 = 1.0 + 1e-14;

/// x^2/(2 R1) + y^2/(2 R2): two bodies of relative principal curvatures 1/R1, 1/R2 (Hertz).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paraboloid {
    radii: [f64; 2],
}

impl Paraboloid {
    /// Relative radii of curvature R1 along x and R2 along y, both greater than zero. An infinite radius is a straight
    /// generator: `[0.02, f64::INFINITY]` is a cylinder of radius 0.02 whose axis lies along y.
    ///
    /// # Errors
    /// Names the radius that is not greater than zero.
    pub fn new(radii: [f64; 2]) -> Result<Self, InputError> {
        for (path, radius) in [("radii[0]", radii[0]), ("radii[1]", radii[1])] {
            if radius.is_nan() || radius <= 0.0 {
                return Err(InputError::new(
                    path,
                    radius,
                    "a number greater than 0, infinite for a straight generator",
                ));
            }
        }
        Ok(Self { radii })
    }

    /// R1 and R2.
    #[must_use]
    pub fn radii(&self) -> [f64; 2] {
        self.radii
    }
}

impl Gap for Paraboloid {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let [r1, r2] = self.radii;
        0.5 * (x * (x / r1) + y * (y / r2))
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        Some([x / self.radii[0], y / self.radii[1]])
    }

    fn describe(&self) -> Known {
        let [r1, r2] = self.radii;
        let round = (r1 == r2 && r1.is_finite()).then(|| Generatrix::Power {
            coefficient: 0.5 / r1,
            exponent: 2.0,
            lowest: 0.0,
        });
        Known {
            floor: 0.0,
            law: Some(Law { degree: Degree::Power(2.0), lowest: 0.0 }),
            quadratic: Some(Quadratic {
                about: [0.0; 2],
                value: 0.0,
                gradient: [0.0; 2],
                hessian: [r1.recip(), 0.0, r2.recip()],
            }),
            axis: round.map(|generatrix| Axis { at: [0.0; 2], generatrix }),
            material: Material::Everywhere,
            mirrors: [true; 2],
            ..Known::nothing()
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        if depth <= 0.0 {
            return Reach::Nowhere;
        }
        if let Some(axis) = (0..2).find(|&m| self.radii[m] == f64::INFINITY) {
            return Reach::Unbounded { from: [0.0; 2], along: axis as f64 * std::f64::consts::FRAC_PI_2 };
        }
        Reach::Within(Rect::around([0.0; 2], self.radii.map(|r| (2.0 * r).sqrt() * depth.sqrt() * ROUNDING)))
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        self.taylor(rect).map(|t| t.bounds(rect.size(), slope))
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        self.taylor(rect).map(Taylor::cubic)
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let c = rect.centre().map(Interval::point);
        let curvature = self.radii.map(|r| Interval::point(1.0) / Interval::point(r));
        let curvature = [0, 1].map(|m| if self.radii[m] == f64::INFINITY { Interval::ZERO } else { curvature[m] });
        let gradient = [0, 1].map(|m| curvature[m] * c[m]);
        let value = Interval::point(0.5) * (gradient[0] * c[0] + gradient[1] * c[1]);
        Taylor { value, gradient, hessian: [curvature[0], Interval::ZERO, curvature[1]] }.finite()
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        let [a, b] = self.radii.map(|r| Interval::point(0.5 / r));
        Some(Growth::power(2.0, a * sector.cos().powi(2) + b * sector.sin().powi(2), from))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        // Mean of x^2 over an interval of length w about c: c^2 + w^2/12.
        let ([x, y], [w, h], [r1, r2]) = (cell.centre(), cell.size(), self.radii);
        self.gap(x, y) + (w * (w / r1) + h * (h / r2)) / 24.0
    }
}
