//! A sphere.

use super::radial::{self, Profile, disc, distances, rising};
use super::{Cubic, Gap, Generatrix, Growth, Known, Material, Reach, Taylor};
use crate::error::{InputError, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// R - sqrt(R^2 - r^2): a true sphere of radius R, no material beyond r = R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    radius: f64,
}

impl Sphere {
    /// A sphere of this radius, greater than zero.
    ///
    /// # Errors
    /// When the radius is not a finite number greater than zero.
    pub fn new(radius: f64) -> Result<Self, InputError> {
        Ok(Self { radius: positive("radius", radius)? })
    }

    /// R.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Gap for Sphere {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let rho = x.hypot(y) / self.radius;
        if rho > 1.0 {
            return f64::INFINITY;
        }
        // R (1 - c) = R rho^2/(1 + c) with c = sqrt(1 - rho^2): nothing cancels at the pole.
        self.radius * rho * rho / (1.0 + ((1.0 - rho) * (1.0 + rho)).sqrt())
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let rho = x.hypot(y) / self.radius;
        let height = self.radius * ((1.0 - rho) * (1.0 + rho)).max(0.0).sqrt();
        Some([x / height, y / height])
    }

    fn describe(&self) -> Known {
        let around = Rect::around([0.0; 2], [self.radius; 2]);
        Known { material: Material::Within(around), ..rising(Generatrix::Sphere { radius: self.radius, lowest: 0.0 }) }
    }

    fn reach(&self, depth: f64) -> Reach {
        let t = depth / self.radius;
        disc(if t >= 1.0 { self.radius } else { self.radius * (t * (2.0 - t)).max(0.0).sqrt() })
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(radial::bounds(rect, slope, self.profile(distances(rect)).value, || self.taylor(rect)))
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        radial::taylor(rect, |r| self.profile(r))
    }

    /// g''' = 3 rho/(R^2 c^5), (g'' - g'/r)/r = rho/(R^2 c^3).
    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        let (one, radius) = (Interval::point(1.0), Interval::point(self.radius));
        let thirds = |r: Interval| {
            let rho = r / radius;
            let c = ((one - rho) * (one + rho)).sqrt();
            let across = rho / (radius.powi(2) * c.powi(3));
            [Interval::point(3.0) * across / c.powi(2), across]
        };
        radial::cubic(rect, |r| self.profile(r), thirds)
    }

    fn growth(&self, _: Interval, from: f64) -> Option<Growth> {
        Growth::ended(&Rect::around([0.0; 2], [self.radius; 2]), from)
    }
}

impl Sphere {
    /// g = R rho^2/(1 + c), g'/r = 1/(R c), g'' = 1/(R c^3) with rho = r/R, c = sqrt(1 - rho^2).
    fn profile(&self, r: Interval) -> Profile {
        let (one, radius) = (Interval::point(1.0), Interval::point(self.radius));
        let rho = r / radius;
        let c = ((one - rho) * (one + rho)).sqrt();
        let value = |rho: Interval, c: Interval| radius * rho.powi(2) / (one + c);
        // g rises with r: its bounds lie at the ends.
        let end = |rho: f64| {
            let rho = Interval::point(rho);
            value(rho, ((one - rho) * (one + rho)).sqrt())
        };
        let top = if c.defined { end(rho.hi).hi } else { self.radius.next_up() };
        Profile {
            value: if c.is_empty() {
                Interval::EMPTY
            } else {
                Interval { lo: end(rho.lo).lo.max(0.0), hi: top, defined: c.defined }
            },
            slope_over_r: one / (radius * c),
            curvature: one / (radius * c.powi(3)),
        }
    }
}
