//! Brackets without a solve: the best ellipse or a corrected Fabrikant pressure from below, a simpler gap from above.
//!
//! Below: the exact pressure m of a flat elliptical punch has S m <= 1, so that the integral of f m is at most P (Rayleigh &
//! Ritz; [`crate::approximate::ritz`]); so has any pressure over the supremum of its displacement ([`super::measure`]). Above:
//! [`super::comparison`].

use super::comparison::Comparisons;
use super::{BracketCost, Evidence, ForceBracket, Repair, Side, Theorem, measure};
use crate::approximate::ritz;
use crate::approximate::{fabrikant, solve};
use crate::clock::{Deadline, Stopwatch};
use crate::closed_form::FlatPunch;
use crate::gap::{AnyGap, Gap};
use crate::overlap::Overlap;
use crate::problem::EffectiveModulus;
use crate::solution::Unsolved;

/// Times the quadrature's own estimate of its error that the lower bound gives up.
const DOUBT: f64 = 10.0;

/// Bracket of the force without a grid, in about the time of an approximate method.
///
/// Its evidence is [`Evidence::Sampled`]: the lower side rests on a quadrature, with ten times its own estimate of its error
/// taken off. The upper side alone may be proved ([`Side::evidence`]).
///
/// # Errors
/// [`crate::Verdict::Unbounded`] when the gap stays below the depth without end.
///
/// ```
/// use contact_patch::{EffectiveModulus, bracket, gap::Polyhedron};
/// let punch = Polyhedron::pyramid(4, std::f64::consts::FRAC_PI_4)?;
/// let bracket = bracket::approximate(&punch, EffectiveModulus::from_e_star(1.0)?, 1.0)?;
/// assert!(bracket.contains(0.737616) && bracket.relative_width() < 0.4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn approximate(gap: impl Into<AnyGap>, modulus: EffectiveModulus, depth: f64) -> Result<ForceBracket, Unsolved> {
    approximate_before(&gap.into(), modulus, depth, Deadline::NEVER)
}

/// As [`approximate`].
///
/// # Errors
/// `TimeLimit`, too.
pub(super) fn approximate_before(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    deadline: Deadline,
) -> Result<ForceBracket, Unsolved> {
    let started = Stopwatch::start();
    let Some(Overlap { reach, certain, .. }) = Overlap::of(gap, depth)? else {
        return Ok(ForceBracket::no_contact(None));
    };
    let settings = fabrikant::Settings { tolerance: 1e-6, boundary_points: 64, deadline, ..Default::default() };
    let found = ritz::ellipse(gap, modulus, depth, &settings).ok();
    let lower = found.as_ref().and_then(|e| e.lower_bound.map(|b| e.force - DOUBT * (e.force - b.force())));
    let middle = found.as_ref().map_or(gap.known().centre, |e| e.centroid);
    let comparisons = Comparisons { gap, modulus, depth, reach, certain };
    deadline.check()?;
    let ellipse = lower.unwrap_or(0.0).max(inscribed(&comparisons));
    let fabrikant = [fabrikant::Family::Stationary, fabrikant::Family::PlanForm]
        .into_iter()
        .find_map(|family| solve(gap, modulus, depth, family, &settings).ok())
        .map_or(0.0, |found| measure::corrected_fabrikant(gap, modulus, depth, &found.boundary));
    deadline.check()?;
    let below = Side {
        force: ellipse.max(fabrikant),
        theorem: if fabrikant > ellipse { Theorem::CorrectedFabrikant } else { Theorem::Ellipse },
        evidence: Evidence::Sampled { per_cell: 0 },
        violation: 0.0,
        at: middle,
        repair: Repair::default(),
        pressure: None,
    };
    let axes = found.map(|e| {
        let points = e.boundary.polyline();
        let from = |p: &[f64; 2]| [p[0] - middle[0], p[1] - middle[1]];
        let far = points.iter().map(from).max_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        let [x, y] = far.unwrap_or([1.0, 0.0]);
        let a = x.hypot(y);
        ([a, e.area / (std::f64::consts::PI * a)], y.atan2(x))
    });
    let above = comparisons.least(middle, axes);
    let cost = BracketCost { seconds: started.seconds(), ..BracketCost::default() };
    Ok(ForceBracket { lower: below, upper: above, cost })
}

/// The force of the best flat ellipse in the box of {g < d} that is pressed in no deeper than the overlap everywhere under it:
/// what is left where the best ellipse of all ends at a sharp edge.
fn inscribed(of: &Comparisons) -> f64 {
    const RINGS: u32 = 24;
    let ([x, y], half) = (of.reach.centre(), of.reach.size().map(|s| 0.5 * s * (1.0 - 1e-9)));
    let mut highest = of.gap.gap(x, y);
    let mut best = 0.0_f64;
    for ring in 1..=RINGS {
        let s = f64::from(ring) / f64::from(RINGS);
        let around = (0..96).map(|k| (std::f64::consts::TAU * f64::from(k) / 96.0).sin_cos());
        let rim = around.map(|(sin, cos)| of.gap.gap(x + s * half[0] * cos, y + s * half[1] * sin));
        highest = rim.fold(highest, f64::max);
        if !(highest < of.depth) {
            break;
        }
        let punch = FlatPunch::ellipse(of.modulus, half.map(|h| s * h)).and_then(|p| p.at_depth(of.depth - highest));
        best = best.max(punch.map_or(0.0, |p| p.force * (1.0 - 1e-12)));
    }
    best
}
