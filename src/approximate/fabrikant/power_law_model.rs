//! The shape of G_a along a ray, from its value and slope at one place: what lets one sweep predict the next.
//! (By roots of each ray instead, a 2:1 paraboloid takes 1.6 times the instructions, formulas 1.2 to 1.3 times.)

use super::ray_fan::Ray;

/// G_a along a ray as 2 f0 x - C x^m, which is exact for gaps that are homogeneous about the centre: T = C a^m and m from
/// G_a and G_aa at a.
#[derive(Clone, Copy)]
pub(super) struct PowerLawModel {
    pub a: f64,
    linear: f64,
    t: f64,
    m: f64,
    /// Maximum of the model: place (in units of a) and height.
    pub top: [f64; 2],
}

impl PowerLawModel {
    /// `None` where the model has no maximum. Beyond a kink it is no more than a guess.
    pub fn through(ray: &Ray, f0: f64) -> Option<Self> {
        let (a, linear) = (ray.a, 2.0 * f0 * ray.a);
        let t = linear - ray.along.g_a;
        let m = (linear - ray.along.g_aa * a) / t;
        if !(t > 1e-14 * linear && m > 1.02 && m < 1e4) {
            return None;
        }
        let y = if (m - 2.0).abs() < 1e-9 { 0.5 * linear / t } else { (linear / (m * t)).powf(1.0 / (m - 1.0)) };
        Some(Self { a, linear, t, m, top: [y, linear * y * (1.0 - 1.0 / m)] })
    }

    /// The outer root of the model, in units of a; `None` when D exceeds its maximum.
    pub fn root(&self, d: f64) -> Option<f64> {
        let Self { linear, t, m, .. } = *self;
        if d > self.top[1] {
            return None;
        }
        if (m - 2.0).abs() < 1e-9 {
            let half = 0.5 * linear;
            return Some((half + (half * half - t * d).max(0.0).sqrt()) / t);
        }
        // From the root for D = 0 Newton comes down monotonically: the model is concave there.
        let mut y = self.top[0] * m.powf(1.0 / (m - 1.0));
        for _ in 0..60 {
            let power = t * y.powf(m - 1.0);
            let step = (y * (linear - power) - d) / (linear - m * power);
            y -= step;
            if !(step > 1e-15 * y) {
                break;
            }
        }
        Some(y.max(self.top[0]))
    }

    /// G at y a, less G at a.
    pub fn gain(&self, y: f64) -> f64 {
        let Self { linear, t, m, .. } = *self;
        let power = if (m - 2.0).abs() < 1e-9 { y * y * y } else { y.powf(m + 1.0) };
        self.a * (0.5 * linear * (y * y - 1.0) - t * (power - 1.0) / (m + 1.0))
    }
}
