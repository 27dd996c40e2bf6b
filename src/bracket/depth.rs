//! The depth under a prescribed force, from a bracket of the force near it.

use super::problem::degree_of;
use super::{DepthBracket, Evidence, ForceBracket};
use crate::gap::{AnyGap, Gap, Reach};

impl DepthBracket {
    /// The depth at which the force is `force`, from its bracket at `depth`.
    ///
    /// P(d) is convex and zero up to first touch d0: chords from there lie above it on this side of `depth` and below it on the
    /// other, P(d') <= P(d) (d' - d0)/(d - d0) for d' <= d. A homogeneous gap has P ~ d^(1 + 1/k) instead.
    #[must_use]
    pub fn under(gap: impl Into<AnyGap>, depth: f64, force: f64, bracket: &ForceBracket) -> Self {
        let gap = &gap.into();
        let (_, sure) = first_touch(gap, depth);
        let [lower, upper] = Self::bounds(gap, depth, force, [bracket.lower(), bracket.upper()]);
        Self {
            lower,
            upper: upper.is_finite().then_some(upper),
            evidence: match bracket.evidence() {
                Evidence::Proved if !sure => Evidence::Sampled { per_cell: 0 },
                evidence => evidence,
            },
        }
    }

    /// The bounds alone, from those of the force; infinite above where there is none.
    pub(crate) fn bounds(gap: &AnyGap, depth: f64, force: f64, [below, above]: [f64; 2]) -> [f64; 2] {
        let (touch, sure) = first_touch(gap, depth);
        let slope = degree_of(gap).filter(|_| sure && touch == 0.0).map_or(1.0, |k| 1.0 / (1.0 + 1.0 / k));
        let exact = slope != 1.0 || degree_of(gap) == Some(f64::INFINITY);
        let at = |share: f64| touch + (depth - touch) * share.powf(slope);
        // A hair more for the rounding of the last steps.
        let hair = 8.0 * f64::EPSILON * (depth.abs() + touch.abs());
        let share = force / above;
        let lower = if share < 1.0 || exact { at(share) } else { depth };
        let share = force / below;
        let upper = if share > 1.0 || exact { at(share) } else { depth };
        [lower - hair, upper + hair]
    }
}

/// A depth at which the bodies do not overlap yet, as large as can be found, and whether that is certain.
pub(super) fn first_touch(gap: &AnyGap, depth: f64) -> (f64, bool) {
    let lowest = crate::overlap::least(gap).1.min(depth);
    let overlap = depth - lowest;
    let none = |d: f64| matches!(gap.reach(d), Reach::Nowhere);
    let below = std::iter::once(lowest).chain((0..40).map(|k| lowest - overlap * 1e-12 * f64::powi(2.0, k)));
    below.into_iter().find(|&d| none(d)).map_or((lowest, false), |d| (d, true))
}
