//! A power law.

use super::radial::{self, Profile, disc, distances, rising};
use super::{Cubic, Degree, Gap, Generatrix, Growth, Known, Law, Quadratic, Reach, Taylor};
use crate::error::{InputError, finite, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// c r^n: a power law with real exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Power {
    coefficient: f64,
    exponent: f64,
}

impl Power {
    /// c > 0 (length^(1-n)) and n > 0.
    ///
    /// # Errors
    /// Names the parameter that is not a finite number greater than zero.
    pub fn new(coefficient: f64, exponent: f64) -> Result<Self, InputError> {
        finite("coefficient", coefficient)?;
        Ok(Self { coefficient: positive("coefficient", coefficient)?, exponent: positive("exponent", exponent)? })
    }

    /// c.
    #[must_use]
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }

    /// n.
    #[must_use]
    pub fn exponent(&self) -> f64 {
        self.exponent
    }
}

impl Power {
    fn profile(&self, r: Interval) -> Profile {
        let (n, one) = (Interval::point(self.exponent), Interval::point(1.0));
        let c = Interval::point(self.coefficient);
        let lowered = if self.exponent == 2.0 { c } else { c * r.powf(n - Interval::point(2.0)) };
        Profile {
            value: c * r.powf(n),
            slope_over_r: n * lowered,
            curvature: if self.exponent == 1.0 { Interval::ZERO } else { n * (n - one) * lowered },
        }
    }
}

impl Gap for Power {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.coefficient * x.hypot(y).powf(self.exponent)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let r = x.hypot(y);
        let slope = self.coefficient * self.exponent * r.powf(self.exponent - 1.0);
        Some(if r > 0.0 { [slope * (x / r), slope * (y / r)] } else { [slope, 0.0] })
    }

    fn describe(&self) -> Known {
        let (coefficient, exponent) = (self.coefficient, self.exponent);
        Known {
            law: Some(Law { degree: Degree::Power(exponent), lowest: 0.0 }),
            quadratic: (exponent == 2.0).then_some(Quadratic {
                about: [0.0; 2],
                value: 0.0,
                gradient: [0.0; 2],
                hessian: [2.0 * coefficient, 0.0, 2.0 * coefficient],
            }),
            ..rising(Generatrix::Power { coefficient, exponent, lowest: 0.0 })
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        // Large powers of a quotient that is off by rounding are off by their share of it.
        let room = 1.0 + 4.0 * f64::EPSILON / self.exponent;
        disc((depth / self.coefficient).powf(1.0 / self.exponent) * room)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let value = Interval::point(self.coefficient) * distances(rect).powf(Interval::point(self.exponent));
        Some(radial::bounds(rect, slope, value, || self.taylor(rect)))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        radial::taylor(rect, |r| self.profile(r))
    }

    /// g''' = c n (n - 1) (n - 2) r^(n - 3), (g'' - g'/r)/r = c n (n - 2) r^(n - 3).
    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        let (n, one) = (Interval::point(self.exponent), Interval::point(1.0));
        let less = n - Interval::point(2.0);
        let thirds = |r: Interval| {
            if self.exponent == 2.0 {
                return [Interval::ZERO; 2];
            }
            let across = Interval::point(self.coefficient) * n * less * r.powf(n - Interval::point(3.0));
            [if self.exponent == 1.0 { Interval::ZERO } else { (n - one) * across }, across]
        };
        radial::cubic(rect, |r| self.profile(r), thirds)
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let (n, one) = (Interval::point(self.exponent), Interval::point(1.0));
        let steep = if self.exponent == 1.0 { one } else { radial::distances(rect).powf(n - one) };
        radial::slopes(rect, n * Interval::point(self.coefficient) * steep)
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Some(radial::power(self.coefficient, self.exponent, from))
    }
}
