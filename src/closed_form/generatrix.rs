//! The generatrix of a body of revolution, and its integrals D and M (see `sneddon`).

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use crate::clock::Deadline;
use crate::numeric::quadrature::{Integral, adaptive, from_zero};

/// g'(r) or g(r).
pub(super) type Profile = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// The clock is read once for so many integrals: that costs as much as a short one.
const CHECKED: u32 = 8;

/// A gap of revolution.
pub(super) struct Generatrix {
    pub(super) profile: Profile,
    /// Whether the profile is g'(r) or g(r).
    pub(super) by_slope: bool,
    /// Radii of corners, increasing, inside the body.
    pub(super) kinks: Vec<f64>,
    /// Where the body ends with a sharp rim; infinite when it does not.
    pub(super) radius: f64,
    /// No contact at the depth asked for is larger; infinite where that is not known.
    pub(super) overlap: f64,
    /// From then on integrals are NaN.
    pub(super) deadline: Deadline,
    /// Integrals so far.
    pub(super) integrals: AtomicU32,
    /// Whether it has been read to be past the deadline.
    pub(super) is_late: AtomicBool,
}

impl fmt::Debug for Generatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Generatrix").field("kinks", &self.kinks).field("radius", &self.radius).finish_non_exhaustive()
    }
}

impl Generatrix {
    /// Rounding of the integrands: by slope, and by gap with its cancellation.
    pub(super) fn tolerance(&self) -> f64 {
        if self.by_slope { 1e-13 } else { 1e-12 }
    }

    /// int_0^{pi/2} F dt with r = s sin t on the panel next to the axis, where r has to keep its digits, and
    /// r = s cos theta on the others, where s - r has to: `f(r, sin t, cos t)`.
    fn integral(&self, s: f64, f: impl Fn(f64, f64, f64) -> f64) -> Integral {
        if self.integrals.fetch_add(1, Ordering::Relaxed).is_multiple_of(CHECKED) && self.deadline.has_passed() {
            self.is_late.store(true, Ordering::Relaxed);
        }
        if self.is_late.load(Ordering::Relaxed) {
            return Integral { value: f64::NAN, error: f64::INFINITY, evaluations: 0 };
        }
        let first_kink = self.kinks.first().copied().filter(|&b| b < s).map_or(FRAC_PI_2, |b| (b / s).asin());
        let split = first_kink.min(FRAC_PI_4);
        let near = |t: f64| {
            let (sin, cos) = t.sin_cos();
            // A slope may be infinite at the axis.
            f((s * sin).max(f64::MIN_POSITIVE), sin, cos)
        };
        let far = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            f(s * cos, cos, sin)
        };
        let theta = |b: &f64| ((s - b) * (s + b)).max(0.0).sqrt().atan2(*b);
        let breaks: Vec<f64> = self.kinks.iter().filter(|&&b| b < s).map(theta).collect();
        let end = if split < FRAC_PI_4 { breaks.first().copied().unwrap_or(FRAC_PI_4) } else { FRAC_PI_4 };
        let outer = adaptive(far, 0.0, end, &breaks, self.tolerance());
        from_zero(near, split, self.tolerance()).plus(outer)
    }

    /// D(s). From the gap: D = g(s) - g(0) + int (g(s) - g(s sin t)) sin t/cos^2 t dt, by parts.
    pub(super) fn abel(&self, s: f64) -> Integral {
        let g = &self.profile;
        if self.by_slope {
            return self.integral(s, |r, _, _| g(r)).times(s);
        }
        let (at_rim, at_axis) = (g(s), g(0.0));
        let rest = self.integral(s, |r, sin, cos| (at_rim - g(r)) * sin / (cos * cos));
        Integral { value: at_rim - at_axis + rest.value, ..rest }
    }

    /// M(a). From the gap: a D(a) - a int (g(a sin t) - g(0)) sin t dt.
    pub(super) fn moment(&self, a: f64) -> Integral {
        let g = &self.profile;
        if self.by_slope {
            return self.integral(a, |r, sin, _| sin * sin * g(r)).times(a).times(a);
        }
        let at_axis = g(0.0);
        let volume = self.integral(a, |r, sin, _| (g(r) - at_axis) * sin);
        self.abel(a).plus(volume.times(-1.0)).times(a)
    }

    /// g(r) - g(0), to a few digits.
    pub(super) fn gap(&self, r: f64) -> f64 {
        let g = &self.profile;
        if !self.by_slope {
            return g(r) - g(0.0);
        }
        let first = self.kinks.first().copied().unwrap_or(r).min(r);
        from_zero(g, first, 1e-8).value + adaptive(g, first, r, &self.kinks, 1e-8).value
    }

    /// g' just beside r, on the side of `sign`.
    pub(super) fn slope_beside(&self, r: f64, sign: f64) -> f64 {
        let g = &self.profile;
        if self.by_slope {
            return g(r * (1.0 + sign * 1e-9));
        }
        let h = sign * 1e-5 * r;
        (g(r + h) - g(r)) / h
    }
}
