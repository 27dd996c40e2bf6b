//! The non-linear spring: force over depth from few exact solves, with an error estimate, in any form people load.

mod export;
mod family;
mod law;
mod spline;

pub use spline::Knot;

use crate::error::{InputError, positive};
use crate::overlap::least;
use crate::problem::{Contact, Settings};
use crate::solution::{Singular, Unsolved, Verdict};
use family::Family;
use law::Law;
use spline::Spline;

/// Most states of one curve.
const MOST_STATES: usize = 200;

/// Share of the accuracy that is left to the error of the states; the rest is for what lies between them.
const OF_STATES: f64 = 0.4;

/// Share of the accuracy by which the convex interpolant may differ from the law through the states.
const OF_FORM: f64 = 0.02;

/// Least depth of a curve that is asked for by its end alone, as a share of it.
const SHALLOWEST: f64 = 1.0 / 200.0;

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
    /// Stored energy.
    pub energy: Option<f64>,
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
    interpolation_error: f64,
    solves: usize,
}

impl Curve {
    /// The curve of a punch that does not tilt; the loading of the contact is not used. Depths are solved where the interpolant misses
    /// them by more than the accuracy; a homogeneous gap takes one solve.
    ///
    /// ```
    /// use contact_patch::{Contact, Curve, CurveRange, EffectiveModulus, Loading, Settings, gap::Paraboloid};
    /// let modulus = EffectiveModulus::from_e_star(1.0)?;
    /// let sphere = Contact::new(modulus, Paraboloid::new([1.0, 1.0])?, Loading::depth(1.0))?;
    /// let range = CurveRange { from: 0.01, to: 1.0, accuracy: 1e-5 };
    /// let spring = Curve::new(&sphere, &Settings::default(), range)?;
    /// assert!((spring.force(0.25).unwrap() - 4.0 / 3.0 * 0.125).abs() < 2e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// What stops the solve at some depth; `NotApplicable` when the range is not 0 < from < to.
    pub fn new(contact: &Contact, settings: &Settings, range: CurveRange) -> Result<Self, Unsolved> {
        range.checked().map_err(|e| Unsolved::new(Verdict::NotApplicable, e.to_string()))?;
        let (_, first_touch) = least(contact.gap());
        let CurveRange { from, to, accuracy } = range;
        let mut family = Family::new(contact, settings, OF_STATES * accuracy, first_touch, to);
        // On a prescribed grid nearly all of a state's error is that of the grid, the same from one state to the next.
        let share = if settings.cells.is_some() { 0.1 } else { 1.0 };
        let doubt = |state: &Sample| share * state.force_error.unwrap_or(0.0);
        let left = (1.0 - OF_STATES - OF_FORM) * accuracy;
        let (law, samples) = Law::solved([from, to], left, MOST_STATES, first_touch, doubt, |s| family.at(s))?;
        let (spline, off) = convex(&law, OF_FORM * accuracy);
        Ok(Self { first_touch, spline, samples, interpolation_error: law.error + off, solves: family.solves() })
    }

    /// The curve up to a depth, from a two-hundredth of the overlap there on: as [`Curve::new`].
    ///
    /// # Errors
    /// As [`Curve::new`]; `NotApplicable` when the bodies do not touch at that depth.
    pub fn up_to(contact: &Contact, settings: &Settings, depth: f64, accuracy: f64) -> Result<Self, Unsolved> {
        let to = depth - least(contact.gap()).1;
        if !(to.is_finite() && to > 0.0) {
            let reason = format!("a curve up to depth {depth:e}, at which the bodies do not touch");
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        Self::new(contact, settings, CurveRange { from: SHALLOWEST * to, to, accuracy })
    }

    /// Force at a depth: zero before first touch, `None` beyond the range.
    #[must_use]
    pub fn force(&self, depth: f64) -> Option<f64> {
        self.spline.at(depth - self.first_touch).map(|p| p[0])
    }

    /// dP/dd at a depth; `None` beyond the range.
    #[must_use]
    pub fn stiffness(&self, depth: f64) -> Option<f64> {
        self.spline.at(depth - self.first_touch).map(|p| p[1])
    }

    /// Depth at a force: the inverse of [`Curve::force`]; `None` for a pull and beyond the range.
    #[must_use]
    pub fn depth(&self, force: f64) -> Option<f64> {
        self.spline.overlap_at(force).map(|s| self.first_touch + s)
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
    /// between them, and their own error.
    #[must_use]
    pub fn interpolation_error(&self) -> f64 {
        self.interpolation_error
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
            .filter_map(|s| self.spline.at(s).map(|p| [s.ln(), p[0].ln()]))
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

impl CurveRange {
    fn checked(self) -> Result<(), InputError> {
        positive("from", self.from)?;
        positive("to", self.to)?;
        positive("accuracy", self.accuracy)?;
        if self.from < self.to { Ok(()) } else { Err(InputError::new("from", self.from, "less than to")) }
    }
}

/// The increasing convex interpolant of the law, and by how much it differs from it.
fn convex(law: &Law, allowed: f64) -> (Spline, f64) {
    let mut pieces = 1;
    loop {
        let spline = Spline::new(&law.sampled(pieces));
        let off = |row: &[f64; 3]| spline.at(row[0]).map_or(0.0, |p| (p[0] / row[1] - 1.0).abs());
        let worst = law.sampled(4 * pieces).iter().map(off).fold(0.0, f64::max);
        if worst <= allowed || pieces == MOST_PIECES {
            return (spline, worst);
        }
        pieces *= 2;
    }
}

/// Most pieces of the interpolant between two states.
const MOST_PIECES: usize = 16;
