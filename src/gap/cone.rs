//! A cone.

use super::radial::{self, Profile, disc, distances, rising};
use super::{Cubic, Degree, Gap, Generatrix, Growth, Known, Law, Reach, Taylor};
use crate::error::{InputError, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// r tan(inclination): a cone (Love 1939).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    slope: f64,
}

impl Cone {
    /// A cone whose flank makes this angle (radians, in (0, pi/2)) with the surface.
    ///
    /// # Errors
    /// When the inclination is out of range.
    pub fn new(inclination: f64) -> Result<Self, InputError> {
        Ok(Self { slope: slope_of(inclination)? })
    }

    /// A cone whose flank rises by `slope` > 0 a unit of radius.
    ///
    /// # Errors
    /// When the slope is not a finite number greater than zero.
    pub fn with_slope(slope: f64) -> Result<Self, InputError> {
        Ok(Self { slope: positive("slope", slope)? })
    }

    /// Rise a unit of radius.
    #[must_use]
    pub fn slope(&self) -> f64 {
        self.slope
    }

    fn profile(&self, r: Interval) -> Profile {
        let slope = Interval::point(self.slope);
        Profile { value: slope * r, slope_over_r: slope / r, curvature: Interval::ZERO }
    }
}

/// tan of an inclination in radians, in (0, pi/2). The message speaks of degrees, as scenes do.
pub(super) fn slope_of(inclination: f64) -> Result<f64, InputError> {
    let slope = inclination.tan();
    if inclination > 0.0 && inclination < std::f64::consts::FRAC_PI_2 && slope.is_normal() {
        Ok(slope)
    } else {
        let allowed = "an angle greater than 0 and less than 90 degrees";
        Err(InputError::new("inclination", format!("{} degrees", inclination.to_degrees()), allowed))
    }
}

impl Gap for Cone {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.slope * x.hypot(y)
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let r = x.hypot(y);
        Some(if r > 0.0 { [self.slope * (x / r), self.slope * (y / r)] } else { [self.slope, 0.0] })
    }

    fn describe(&self) -> Known {
        Known {
            law: Some(Law { degree: Degree::Power(1.0), lowest: 0.0 }),
            ..rising(Generatrix::Power { coefficient: self.slope, exponent: 1.0, lowest: 0.0 })
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        disc(depth / self.slope)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let value = Interval::point(self.slope) * distances(rect);
        let [low, high] = radial::bounds(rect, slope, value, || self.taylor(rect));
        // The cone lies above each of its tangent planes, also across the apex.
        let [x, y] = rect.centre();
        let below = |t: [f64; 2]| {
            let [w, h] = rect.size();
            let plane = Interval::point(t[0]) * Interval::point(x) + Interval::point(t[1]) * Interval::point(y);
            let rest = (t[0] - slope[0]).abs() * w + (t[1] - slope[1]).abs() * h;
            plane.lo - (0.5 * rest).next_up()
        };
        // A slope slightly less than the cone's: rounding keeps the plane below.
        let tangent = self.gradient(x, y).map_or([0.0; 2], |g| g.map(|g| g * (1.0 - 4.0 * f64::EPSILON)));
        Some([low.max(below(tangent)), high])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        radial::taylor(rect, |r| self.profile(r))
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        let slope = Interval::point(self.slope);
        radial::cubic(rect, |r| self.profile(r), |r| [Interval::ZERO, -slope / r.powi(2)])
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        radial::slopes(rect, Interval::point(self.slope))
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Some(radial::power(self.slope, 1.0, from))
    }
}
