//! What can stop a solve.

use std::fmt::Display;

use super::Solution;
use crate::clock::OutOfTime;

/// Why a state of loading was not solved: an answer, not a fault. It carries the best numbers that were found, if any.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{verdict}: {reason}")]
pub struct Unsolved {
    /// What is wrong, in one word.
    pub verdict: Verdict,
    /// The same in a sentence, with the figures that show it.
    pub reason: String,
    /// What to try, in a sentence.
    pub hint: Option<String>,
    /// The best state that was found, with its true error; under [`Verdict::ToleranceNotReached`] and
    /// [`Verdict::TimeLimit`] wherever there is one.
    pub best: Option<Box<Solution>>,
}

impl Unsolved {
    /// A verdict with its reason.
    pub fn new(verdict: Verdict, reason: impl Into<String>) -> Self {
        Self { verdict, reason: reason.into(), hint: None, best: None }
    }

    /// The same with the best state that was found.
    #[must_use]
    pub fn with_best(mut self, best: Solution) -> Self {
        self.best = Some(Box::new(best));
        self
    }

    /// The same with what to try.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The best state, when only its error is larger than asked for ([`Verdict::ToleranceNotReached`]).
    ///
    /// ```
    /// use contact_patch::{Contact, EffectiveModulus, Loading, Settings, Unsolved, gap::Paraboloid, solve};
    /// let modulus = EffectiveModulus::from_e_star(1.0)?;
    /// let contact = Contact::new(modulus, Paraboloid::new([1.0, 2.0])?, Loading::depth(1.0))?;
    /// // Sixteen cells are too few for an error of 1e-6; their force is there all the same.
    /// let settings = Settings { cells: Some(16), tolerance: 1e-6, ..Settings::default() };
    /// let state = solve(&contact, &settings).remove(0).or_else(Unsolved::accept_best)?;
    /// assert!(state.force > 0.0 && state.force_error.unwrap() > 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Itself, under any other verdict, when no state was found, and when the error of its force is not stated or not below 100 %.
    pub fn accept_best(self) -> Result<Solution, Self> {
        let known = |state: &Solution| state.force_error.is_some_and(|error| error < 1.0);
        match self.best {
            Some(best) if self.verdict == Verdict::ToleranceNotReached && known(&best) => Ok(*best),
            best => Err(Self { best, ..self }),
        }
    }

    /// The same with its best state changed.
    pub(crate) fn map_best(mut self, change: impl FnOnce(Solution) -> Solution) -> Self {
        self.best = self.best.map(|best| Box::new(change(*best)));
        self
    }

    /// The same where there are no numbers to show: the best so far break a law.
    pub(crate) fn without_numbers(self, broken: &Self) -> Self {
        let reason = format!("{}; the numbers so far are left out: {}", self.reason, broken.reason);
        Self { reason, best: None, ..self }
    }

    /// The error that was reached is not the one asked for, and why no less was tried.
    pub(crate) fn short_of(tolerance: f64, reached: f64, why: &str) -> Self {
        let reached = if reached.is_finite() {
            format!("relative error {} reached", rounded_up(reached))
        } else {
            "an error that is not known".to_owned()
        };
        let reason = format!("{reached}, the tolerance is {tolerance:.1e}: {why}");
        Self::new(Verdict::ToleranceNotReached, reason)
    }
}

/// Two digits of an error, never less than it.
pub(crate) fn rounded_up(error: f64) -> String {
    let nearest = format!("{error:.1e}");
    if nearest.parse::<f64>().is_ok_and(|shown| shown < error) {
        let step = 0.1 * 10.0_f64.powf(error.log10().floor());
        return format!("{:.1e}", error + 0.5 * step);
    }
    nearest
}

/// What is wrong, in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// The contact reaches as far as one looks: a cylinder on its side, a plane without an edge.
    Unbounded,
    /// The plan-form cannot be written as r = a(theta) about its centroid.
    NotStarShaped,
    /// Equation (15) has no boundary on the concave branch.
    NoStationaryBoundary,
    /// The force has no maximum within the family: the optimiser left the branch.
    NoMaximum,
    /// No closed form is known for this gap and loading.
    NoClosedForm,
    /// The load acts where no part of the punch can balance it.
    NoEquilibrium,
    /// The iteration limit came before the tolerance.
    IterationLimit,
    /// The tolerance was not reached with the cells allowed.
    ToleranceNotReached,
    /// More cells than this method can hold.
    TooLarge,
    /// The method does not answer this kind of question.
    NotApplicable,
    /// The CPU seconds that one state may take were used up.
    TimeLimit,
    /// The answer lacks a part, or a number of it is beyond the range of numbers.
    Incomplete,
    /// The answer breaks a law that every contact obeys.
    Inconsistent,
}

impl Verdict {
    /// The word that stands in a result.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Unbounded => "unbounded",
            Self::NotStarShaped => "not_star_shaped",
            Self::NoStationaryBoundary => "no_stationary_boundary",
            Self::NoMaximum => "no_maximum",
            Self::NoClosedForm => "no_closed_form",
            Self::NoEquilibrium => "no_equilibrium",
            Self::IterationLimit => "iteration_limit",
            Self::ToleranceNotReached => "tolerance_not_reached",
            Self::TooLarge => "too_large",
            Self::NotApplicable => "not_applicable",
            Self::TimeLimit => "time_limit",
            Self::Incomplete => "incomplete",
            Self::Inconsistent => "inconsistent",
        }
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

impl From<OutOfTime> for Unsolved {
    fn from(out_of_time: OutOfTime) -> Self {
        Self::new(Verdict::TimeLimit, out_of_time.to_string())
    }
}
