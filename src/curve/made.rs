//! How a curve comes about: its range, the states that it takes, the convex interpolant through them.

use super::family::Family;
use super::law::Law;
use super::spline::Spline;
use super::{Beyond, Curve, CurveRange, Sample};
use crate::error::{InputError, positive};
use crate::gap::{Gap, Reach};
use crate::loading::axes::Axes;
use crate::overlap::{least, reach_of};
use crate::problem::{Contact, Load, Loading, Settings};
use crate::solution::{Unsolved, Verdict};

/// Most states of one curve.
const MOST_STATES: usize = 200;

/// Share of the accuracy that is left to the error of the states; the rest is for what lies between them.
const OF_STATES: f64 = 0.4;

/// Share of the accuracy by which the convex interpolant may differ from the law through the states.
const OF_FORM: f64 = 0.02;

/// Share of the accuracy by which the stiffness of the one may differ from that of the other.
const OF_FORM_IN_SLOPE: f64 = 0.5;

/// Least depth of a curve that is asked for by its end alone, as a share of it.
const SHALLOWEST: f64 = 1.0 / 200.0;

/// The same as a multiple of what the samples of a measured gap leave open: below it the force is that of their noise.
const ABOVE_NOISE: f64 = 5.0;

/// Largest share of the depth at which a curve that is asked for by its end alone begins, however coarse the samples.
const DEEPEST_START: f64 = 0.25;

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
        Self::watched(contact, settings, range, &mut |_, _| {})
    }

    /// As [`Curve::new`]; `told` is given the states solved so far and, once there are enough to tell, the largest relative error that
    /// the widest distance between two of them leaves open.
    ///
    /// # Errors
    /// As [`Curve::new`].
    pub fn watched(
        contact: &Contact,
        settings: &Settings,
        range: CurveRange,
        told: &mut dyn FnMut(usize, Option<f64>),
    ) -> Result<Self, Unsolved> {
        range.checked().map_err(|e| Unsolved::new(Verdict::NotApplicable, e.to_string()))?;
        let Some(axes) = Axes::of(contact, settings) else { return Self::along(contact, settings, range, told) };
        let mut curve = Self::along(&axes.inward(contact), settings, range, told)?;
        for state in &mut curve.samples {
            state.centre = state.centre.map(|centre| axes.vector_outward(centre));
        }
        Ok(curve)
    }

    /// The curve of a contact that is solved along the user's axes.
    fn along(
        contact: &Contact,
        settings: &Settings,
        range: CurveRange,
        told: &mut dyn FnMut(usize, Option<f64>),
    ) -> Result<Self, Unsolved> {
        let wanted = OF_STATES * range.accuracy;
        let curve = Self::through_states(contact, settings, range, wanted, told)?;
        // The errors of states as good as they were wanted may still leave no convex curve between them that is near enough.
        let as_wanted = curve.samples.iter().all(|state| state.force_error.is_none_or(|error| error <= wanted));
        if !as_wanted || curve.interpolation_error() <= range.accuracy {
            return Ok(curve);
        }
        let closer = Self::through_states(contact, settings, range, 0.5 * wanted, told)?;
        let solves = curve.solves + closer.solves;
        let better = if closer.interpolation_error() < curve.interpolation_error() { closer } else { curve };
        Ok(Self { solves, ..better })
    }

    /// The curve through states whose forces are good to `wanted`, or to what can be had.
    fn through_states(
        contact: &Contact,
        settings: &Settings,
        CurveRange { from, to, accuracy }: CurveRange,
        wanted: f64,
        told: &mut dyn FnMut(usize, Option<f64>),
    ) -> Result<Self, Unsolved> {
        let (_, first_touch) = least(contact.gap());
        let mut family = Family::new(contact, settings, wanted, first_touch, to);
        // On a prescribed grid nearly all of a state's error is that of the grid, the same from one state to the next.
        let share = if settings.cells.is_some() { 0.1 } else { 1.0 };
        let doubt = |state: &Sample| share * state.force_error.unwrap_or(0.0);
        let left = (1.0 - OF_STATES - OF_FORM) * accuracy;
        let solve = |overlaps: &[f64]| family.at(overlaps);
        let (law, samples) = Law::solved([from, to], left, MOST_STATES, first_touch, doubt, solve, told)?;
        let (spline, errors) = convex(&law, accuracy);
        Ok(Self {
            first_touch,
            spline,
            samples,
            errors,
            solves: family.solves(),
            e_star: contact.modulus().e_star(),
            beyond: Beyond::Refuse,
            homogeneous: contact.gap().known().law.is_some(),
        })
    }

    /// The curve up to a depth, from [`Curve::natural_start`] on: as [`Curve::new`].
    ///
    /// # Errors
    /// As [`Curve::new`]; `NotApplicable` when the bodies do not touch at that depth.
    pub fn up_to(contact: &Contact, settings: &Settings, depth: f64, accuracy: f64) -> Result<Self, Unsolved> {
        let to = depth - least(contact.gap()).1;
        if !(to.is_finite() && to > 0.0) {
            let reason = format!("a curve up to depth {depth:e}, at which the bodies do not touch");
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        Self::new(contact, settings, CurveRange { from: Self::natural_start(contact, depth), to, accuracy })
    }

    /// The range of the curve of a loading: from the depth `from`, or from [`Curve::natural_start`] on, to [`Curve::end_of`]. What the solve
    /// for a force cannot do is the inner error.
    ///
    /// # Errors
    /// Names `loading` as [`Curve::end_of`]; names `from` unless it lies between first touch and the largest depth.
    pub fn range_of(
        contact: &Contact,
        settings: &Settings,
        from: Option<f64>,
        accuracy: f64,
    ) -> Result<Result<CurveRange, Unsolved>, InputError> {
        let deepest = match Self::end_of(contact, settings)? {
            Ok(deepest) => deepest,
            Err(unsolved) => return Ok(Err(unsolved)),
        };
        let touch = least(contact.gap()).1;
        let from = match from {
            None => Self::natural_start(contact, deepest),
            Some(from) if from > touch && from < deepest => from - touch,
            Some(from) => {
                let allowed =
                    format!("a depth greater than {touch:e} (first touch) and less than {deepest:e} (the largest)");
                return Err(InputError::new("from", from, allowed));
            }
        };
        Ok(Ok(CurveRange { from, to: deepest - touch, accuracy }))
    }

    /// The depth at which the curve of a loading ends: the largest of its depths, or that of its largest force. What the solve for a force
    /// cannot do is the inner error.
    ///
    /// # Errors
    /// Names `loading`: tilts and moments, and loads under which the bodies do not touch.
    pub fn end_of(contact: &Contact, settings: &Settings) -> Result<Result<f64, Unsolved>, InputError> {
        let (mut deepest, mut strongest) = (f64::NEG_INFINITY, 0.0f64);
        for load in contact.loading().loads() {
            match *load {
                Load::Depth(depth) => deepest = deepest.max(depth),
                Load::Force(force) => strongest = strongest.max(force),
                Load::Tilted { .. } | Load::ForceMoment { .. } => {
                    let allowed = "depths or forces of a punch that does not tilt";
                    return Err(InputError::new("loading", "a tilt or a moment", allowed));
                }
            }
        }
        if strongest > 0.0 {
            let pressed = contact.under(Loading::force(strongest));
            match crate::solve::solve(&pressed, settings).remove(0).or_else(Unsolved::accept_best) {
                Ok(state) => deepest = deepest.max(state.depth),
                Err(unsolved) => return Ok(Err(unsolved)),
            }
        }
        if deepest > least(contact.gap()).1 {
            return Ok(Ok(deepest));
        }
        Err(InputError::new("loading", deepest, "a depth beyond first touch or a force greater than 0"))
    }

    /// Where a curve up to a depth begins unless said, as depth below first touch: at a two-hundredth of the whole, and for a measured
    /// gap not below five times what its samples leave open, the states there being those of its noise; at most at a quarter.
    #[must_use]
    pub fn natural_start(contact: &Contact, depth: f64) -> f64 {
        let to = depth - least(contact.gap()).1;
        let off = match reach_of(contact.gap(), depth) {
            Reach::Within(rect) => contact.gap().sampling_error(&rect),
            _ => 0.0,
        };
        (SHALLOWEST * to).max((ABOVE_NOISE * off).min(DEEPEST_START * to))
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

/// The increasing convex interpolant of the law, and the errors of the law in every interval with what the form adds.
fn convex(law: &Law, accuracy: f64) -> (Spline, Vec<[f64; 2]>) {
    let states: Vec<f64> = law.overlaps().collect();
    let mut pieces = 1;
    loop {
        let spline = Spline::new(&law.sampled(pieces));
        let mut errors = law.errors.clone();
        let mut worst = [0.0f64; 2];
        for [s, force, slope] in law.sampled(4 * pieces) {
            let off = spline
                .at(s, Beyond::Power)
                .map_or([0.0; 2], |p| [(p[0] / force - 1.0).abs(), (p[1] / slope - 1.0).abs()]);
            let k = states.partition_point(|&state| state < s).clamp(1, errors.len()) - 1;
            for n in 0..2 {
                errors[k][n] = errors[k][n].max(law.errors[k][n] + off[n]);
                worst[n] = worst[n].max(off[n]);
            }
        }
        if worst[0] <= OF_FORM * accuracy && worst[1] <= OF_FORM_IN_SLOPE * accuracy || pieces == MOST_PIECES {
            return (spline, errors);
        }
        pieces *= 2;
    }
}

/// Most pieces of the interpolant between two states.
const MOST_PIECES: usize = 16;
