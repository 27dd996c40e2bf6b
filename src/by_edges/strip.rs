//! Strips in which bodies overlap: where along a line, and that they do nowhere else.

use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::Rect;
use crate::numeric::scalar::{bisected, maximum};

/// Points of a line at which the lowest gap is looked for.
const LOOKS: usize = 48;

/// What a strip is wider by, over its width, where it is shown that the bodies overlap nowhere else.
pub(super) const ROOM: f64 = 0.3;

/// Boxes that this may take.
const MOST_BOXES: usize = 200_000;

/// Where along a line, between two ends, the bodies overlap about the lowest gap.
pub(super) fn interval(gap: impl Fn(f64) -> f64, depth: f64, [a, b]: [f64; 2]) -> Option<[f64; 2]> {
    let lowest = maximum(|s| -gap(s), a, b, LOOKS).at;
    let end = |last: f64| if gap(last) < depth { last } else { bisected(|s| gap(s) < depth, [lowest, last], 60)[0] };
    (gap(lowest) < depth).then(|| [end(a), end(b)])
}

/// Whether the bounds of the gap show that the bodies overlap within a box only where `in_strip` holds, which is asked of parts of it no
/// smaller than `smallest`.
pub(super) fn overlaps_only_in(
    gap: &AnyGap,
    depth: f64,
    all: Rect,
    smallest: f64,
    in_strip: impl Fn(&Rect) -> bool,
) -> bool {
    let mut left = vec![all];
    let mut boxes = 0;
    while let Some(own) = left.pop() {
        boxes += 1;
        if gap.bounds(&own, [0.0; 2]).is_some_and(|[low, _]| low > depth) || in_strip(&own) {
            continue;
        }
        if boxes > MOST_BOXES || own.longer_side() < smallest {
            return false;
        }
        let middle = own.centre();
        let [x, y] = [0, 1].map(|m| [own.min[m], middle[m], own.max[m]]);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            left.push(Rect { min: [x[i], y[j]], max: [x[i + 1], y[j + 1]] });
        }
    }
    true
}
