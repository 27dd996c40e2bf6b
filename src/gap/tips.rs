//! Where to look for what a gap may hide between the points at which it is sampled.

use super::{Gap, Reach};
use crate::geometry::Rect;

/// Directions around a tip.
const DIRECTIONS: usize = 8;

/// Rings around a tip, each a third as wide as the one before.
const RINGS: i32 = 14;

/// How many times the points of a gap whose values are all that is known of it have to be more.
const UNKNOWN: usize = 8;

/// Points around each of several tips within `reach`, where a part that is narrow would stand out; none when there is but one,
/// about which the gap is drawn.
pub(crate) fn around_tips(gap: &dyn Gap, reach: &Rect) -> Vec<[f64; 2]> {
    let tips = gap.tips();
    if tips.len() < 2 {
        return Vec::new();
    }
    let size = reach.size()[0].max(reach.size()[1]);
    let mut points = Vec::new();
    for tip in tips.into_iter().filter(|&tip| reach.contains(tip)) {
        points.push(tip);
        for ring in 0..RINGS {
            let r = 0.5 * size * 3f64.powi(-ring);
            for k in 0..DIRECTIONS {
                // Turned from ring to ring, so that no direction is left out.
                let angle = std::f64::consts::TAU * (k as f64 + 0.381_966 * f64::from(ring) + 0.1) / DIRECTIONS as f64;
                points.push([tip[0] + r * angle.cos(), tip[1] + r * angle.sin()]);
            }
        }
    }
    points.retain(|&p| reach.contains(p));
    points
}

/// Points at which a gap is to be looked at where `known` are enough for one that knows its own shape.
pub(crate) fn enough(gap: &dyn Gap, depth: f64, known: usize) -> usize {
    if matches!(gap.certain_reach(depth), Reach::Unknown) { UNKNOWN * known } else { known }
}
