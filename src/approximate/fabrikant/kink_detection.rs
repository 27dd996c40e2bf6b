//! Kinks along a ray that the gap does not name: the ridges of a formula with abs, a cone's apex passed closely.
//!
//! The slope is evaluated in equal steps. Where it is smooth, its changes from step to step are alike; a step with far more than
//! its neighbours holds a kink, or a bend as sharp as one, and is halved towards it. Rules split there see smooth pieces.

use super::ray::{RayLine, ScaledOverlap};

/// Steps over the range.
const STEPS: usize = 64;
/// Evaluations of the gap that a search takes, about.
pub(super) const PRICE: usize = 100;
/// A change of slope so many times that of the neighbours is a kink.
const SHARP: f64 = 3.0;
/// Changes of slope below this, in units of the problem, are not worth a split.
const FAINT: f64 = 1e-9;
/// Kinks closer together than this, relative, are one.
const SAME: f64 = 1e-6;
/// Where the slope comes from differences: half their base, in units of the problem.
const BASE: f64 = 1e-6;

/// Appends the kinks up to `range` that are not in the list from `from` on.
pub(super) fn find(line: &RayLine, overlap: &ScaledOverlap, range: f64, from: usize, kinks: &mut Vec<f64>) {
    let told = kinks.len();
    let slope = |r: f64| overlap.slope_along(line.centre, line.direction, r, BASE);
    let narrowest = if overlap.has_gradient() { 1e-13 } else { 8.0 * BASE };
    let step = range / STEPS as f64;
    // (slope before, change over the step) of the last three steps.
    let mut last = slope(narrowest.max(1e-9));
    let mut changes = [0.0_f64; 3];
    let mut starts = [last; 3];
    for k in 1..=STEPS + 1 {
        let next = if k <= STEPS { slope(step * k as f64) } else { last };
        if !next.is_finite() {
            break;
        }
        changes = [changes[1], changes[2], if k <= STEPS { next - last } else { 0.0 }];
        starts = [starts[1], starts[2], last];
        last = next;
        let (here, beside) = (changes[1].abs(), changes[0].abs().max(changes[2].abs()));
        // The first and the last step have one neighbour only.
        let beside = if k == 2 {
            changes[2].abs()
        } else if k > STEPS {
            changes[0].abs()
        } else {
            beside
        };
        if k >= 2 && here > FAINT && here > SHARP * beside {
            let start = (step * (k - 2) as f64).max(narrowest);
            kinks.push(closer(slope, [start, step * (k - 1) as f64], [starts[1], starts[1] + changes[1]], narrowest));
        }
    }
    let known: Vec<f64> = kinks[from..told].to_vec();
    let mut place = told;
    while place < kinks.len() {
        let kink = kinks[place];
        if known.iter().any(|k| (k - kink).abs() <= SAME * kink) {
            kinks.swap_remove(place);
        } else {
            place += 1;
        }
    }
}

/// Where most of the change of slope over this step happens.
fn closer(
    slope: impl Fn(f64) -> f64,
    [mut low, mut high]: [f64; 2],
    [mut at_low, mut at_high]: [f64; 2],
    narrowest: f64,
) -> f64 {
    let all = (at_high - at_low).abs();
    while high - low > narrowest * high.max(1.0) {
        let middle = 0.5 * (low + high);
        let at = slope(middle);
        if (at - at_low).abs() >= (at_high - at).abs() {
            (high, at_high) = (middle, at);
        } else {
            (low, at_low) = (middle, at);
        }
        // A bend, not a kink: wide enough for the rules by now.
        if (at_high - at_low).abs() < 0.25 * all {
            break;
        }
    }
    0.5 * (low + high)
}
