//! The non-linear spring: force over depth from few exact solves, with an error estimate, in any form people load.

mod export;
mod family;
#[cfg(feature = "scene")]
mod fmu;
mod header;
mod law;
mod made;
mod spline;
mod tilted;
mod warm;

pub use export::About;
#[cfg(feature = "scene")]
pub use fmu::{Binary, Source};
pub use spline::{Beyond, Knot};
pub use tilted::{TiltRange, TiltTable, TiltedForce};
pub use warm::{Pose, Reaction, WarmContact};

use crate::solution::Singular;
use spline::Spline;

/// What [`Curve::new`] is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveRange {
    /// Smallest depth below first touch at which a state is solved, greater than zero. Shallower forces follow the power law that
    /// continues value and slope there.
    pub from: f64,
    /// Largest depth below first touch.
    pub to: f64,
    /// Relative error of interpolation that is good enough.
    pub accuracy: f64,
}

/// A solved state behind the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Depth.
    pub depth: f64,
    /// Force.
    pub force: f64,
    /// Estimate of its relative error, where the method gives one.
    pub force_error: Option<f64>,
    /// dP/dd.
    pub stiffness: f64,
    /// Area of the patch.
    pub area: f64,
    /// Largest pressure, where the method gives a finite one.
    pub max_pressure: Option<f64>,
    /// Relative error of that.
    pub max_pressure_error: Option<f64>,
    /// Why the exact pressure is infinite somewhere, where it is known to be.
    pub singular: Option<Singular>,
    /// Relative error of the stiffness.
    pub stiffness_error: Option<f64>,
    /// Relative error of the area.
    pub area_error: Option<f64>,
    /// Relative error of the stored energy.
    pub energy_error: Option<f64>,
    /// Centre of pressure.
    pub centre: Option<[f64; 2]>,
    /// Half the axes of an elliptical patch, the longer one first.
    pub semi_axes: Option<[f64; 2]>,
    /// Stored energy.
    pub energy: Option<f64>,
    /// Share of the force that the samples of a measured gap leave open, on top of `force_error`; `None` for gaps that are no
    /// measurements.
    pub map_error: Option<f64>,
}

/// P = k s^e fitted to a curve, s the depth below first touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    /// k, in units of force over length^e.
    pub coefficient: f64,
    /// e.
    pub exponent: f64,
    /// Largest relative error over the range.
    pub error: f64,
}

/// Force over depth: increasing, convex, once differentiable.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    first_touch: f64,
    spline: Spline,
    samples: Vec<Sample>,
    /// Largest relative errors of force and stiffness between neighbouring samples.
    errors: Vec<[f64; 2]>,
    solves: usize,
    e_star: f64,
    beyond: Beyond,
    /// Whether one law holds at all depths.
    homogeneous: bool,
}

impl Curve {
    /// The same curve with this continuation beyond its largest depth; [`Beyond::Refuse`] unless said.
    ///
    /// ```
    /// use contact_patch::{Contact, Curve, EffectiveModulus, Loading, Settings, curve::Beyond, gap::Paraboloid};
    /// let sphere = Contact::new(EffectiveModulus::from_e_star(1.0)?, Paraboloid::new([1.0, 1.0])?, Loading::depth(1.0))?;
    /// let spring = Curve::up_to(&sphere, &Settings::default(), 1.0, 1e-4)?;
    /// assert_eq!(spring.force(1.2), None);
    /// let spring = spring.continued(Beyond::Power);
    /// assert!((spring.force(1.2).unwrap() / (4.0 / 3.0 * 1.2f64.powf(1.5)) - 1.0).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn continued(self, beyond: Beyond) -> Self {
        Self { beyond, ..self }
    }

    /// What it says beyond its largest depth.
    #[must_use]
    pub fn beyond(&self) -> Beyond {
        self.beyond
    }

    /// Force, stiffness dP/dd and d2P/dd2 at a depth: zero before first touch; beyond the range as [`Curve::beyond`] says.
    #[must_use]
    pub fn derivatives(&self, depth: f64) -> Option<[f64; 3]> {
        self.spline.at(depth - self.first_touch, self.beyond)
    }

    /// Force at a depth: zero before first touch; beyond the range as [`Curve::beyond`] says, `None` where it refuses.
    #[must_use]
    pub fn force(&self, depth: f64) -> Option<f64> {
        self.derivatives(depth).map(|p| p[0])
    }

    /// dP/dd at a depth, as [`Curve::force`].
    #[must_use]
    pub fn stiffness(&self, depth: f64) -> Option<f64> {
        self.derivatives(depth).map(|p| p[1])
    }

    /// Depth at a force: the inverse of [`Curve::force`]; `None` for a pull, and beyond the range where that refuses.
    #[must_use]
    pub fn depth(&self, force: f64) -> Option<f64> {
        self.spline.overlap_at(force, self.beyond).map(|s| self.first_touch + s)
    }

    /// Area of the patch: powers of the overlap between the solved states, continued on both sides; zero before first touch, `None`
    /// where the force is.
    #[must_use]
    pub fn area(&self, depth: f64) -> Option<f64> {
        self.derivatives(depth)?;
        let s = depth - self.first_touch;
        if s <= 0.0 {
            return Some(0.0);
        }
        let [a, b] = self.beside(depth);
        let (la, lb) = ((a.depth - self.first_touch).ln(), (b.depth - self.first_touch).ln());
        let exponent = (b.area / a.area).ln() / (lb - la);
        Some(a.area * ((s.ln() - la) * exponent).exp())
    }

    /// Centre of pressure: lines between the solved states, constant beyond them; `None` where the force is, and where the method
    /// gives none.
    #[must_use]
    pub fn centre(&self, depth: f64) -> Option<[f64; 2]> {
        self.derivatives(depth)?;
        let [a, b] = self.beside(depth);
        let (ca, cb) = (a.centre?, b.centre?);
        let t = ((depth - a.depth) / (b.depth - a.depth)).clamp(0.0, 1.0);
        Some([0, 1].map(|m| ca[m] + t * (cb[m] - ca[m])))
    }

    /// The solved states beside a depth, or the two at the end nearest to it.
    fn beside(&self, depth: f64) -> [&Sample; 2] {
        let k = self.interval(depth);
        [&self.samples[k], &self.samples[k + 1]]
    }

    fn interval(&self, depth: f64) -> usize {
        self.samples.partition_point(|s| s.depth < depth).clamp(1, self.samples.len() - 1) - 1
    }

    /// Depth at which the bodies first touch.
    #[must_use]
    pub fn first_touch(&self) -> f64 {
        self.first_touch
    }

    /// Largest depth.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        self.first_touch + self.spline.knots.last().map_or(0.0, |k| k.overlap)
    }

    /// Estimate (not a bound) of the largest relative error of the force within the range: what the solved states leave open
    /// between them, and their own error. What the samples of a measured gap leave open is beside it: [`Curve::map_error`].
    #[must_use]
    pub fn interpolation_error(&self) -> f64 {
        self.errors.iter().map(|e| e[0]).fold(0.0, f64::max)
    }

    /// The same of the stiffness.
    #[must_use]
    pub fn stiffness_error(&self) -> f64 {
        self.errors.iter().map(|e| e[1]).fold(0.0, f64::max)
    }

    /// The same of force and stiffness at one depth; `None` outside of the range, where they follow a continuation. The law of a
    /// homogeneous gap holds at every depth.
    #[must_use]
    pub fn errors_at(&self, depth: f64) -> Option<[f64; 2]> {
        let inside = depth >= self.samples[0].depth && depth <= self.deepest();
        (inside || self.homogeneous).then(|| self.errors[self.interval(depth)])
    }

    /// Largest share of the force that the samples of a measured gap leave open within the range; `None` for other gaps.
    #[must_use]
    pub fn map_error(&self) -> Option<f64> {
        self.samples.iter().filter_map(|s| s.map_error).reduce(f64::max)
    }

    /// E* of the bodies.
    #[must_use]
    pub fn e_star(&self) -> f64 {
        self.e_star
    }

    /// States that were solved; a homogeneous gap needs one.
    #[must_use]
    pub fn solves(&self) -> usize {
        self.solves
    }

    /// The states, by depth.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The knots of the interpolant, by depth.
    #[must_use]
    pub fn knots(&self) -> &[Knot] {
        &self.spline.knots
    }

    /// P = k s^e, least squares of ln P over ln s at points spread evenly in ln s over the solved range.
    #[must_use]
    pub fn power_law(&self) -> PowerLaw {
        const POINTS: i32 = 64;
        let (first, last) = (self.spline.knots[0], self.spline.knots[self.spline.knots.len() - 1]);
        let ratio = (last.overlap / first.overlap).ln();
        let points: Vec<[f64; 2]> = (0..=POINTS)
            .map(|k| (first.overlap * (ratio * f64::from(k) / f64::from(POINTS)).exp()).min(last.overlap))
            .filter_map(|s| self.spline.at(s, self.beyond).map(|p| [s.ln(), p[0].ln()]))
            .collect();
        let n = points.len() as f64;
        let [x, y] = [0, 1].map(|m| points.iter().map(|p| p[m]).sum::<f64>() / n);
        let exponent = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>()
            / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
        let level = y - exponent * x;
        let error = points.iter().map(|p| ((level + exponent * p[0] - p[1]).exp() - 1.0).abs()).fold(0.0, f64::max);
        PowerLaw { coefficient: level.exp(), exponent, error }
    }
}
