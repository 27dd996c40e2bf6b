//! Strips in which bodies overlap: where along a line, and that they do nowhere else.

use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::Rect;
use crate::numeric::scalar::{bisected, maximum, root};

/// Points of a line at which the lowest gap is looked for.
const LOOKS: usize = 48;

/// What a strip is wider by, over its width, where it is shown that the bodies overlap nowhere else.
const ROOM: f64 = 0.3;

/// Boxes that this may take, and the least of them over the width of the strip.
const MOST_BOXES: usize = 200_000;
const SMALLEST: f64 = 0.01;

/// Where along a line, between two ends, the bodies overlap about `inside`, if they overlap there, else about the lowest gap.
pub(super) fn interval(
    gap: impl Fn(f64) -> f64,
    depth: f64,
    [a, b]: [f64; 2],
    inside: Option<f64>,
) -> Option<[f64; 2]> {
    let above = |s: f64| gap(s) - depth;
    let inside = inside.filter(|s| above(*s) < 0.0).unwrap_or_else(|| maximum(|s| -gap(s), a, b, LOOKS).at);
    let end = |last: f64| match above(last) {
        there if there < 0.0 => last,
        there if there.is_finite() => root(above, inside, last).map_or(last, |found| found.at),
        // No material there.
        _ => bisected(|s| above(s) < 0.0, [inside, last], 60)[0],
    };
    (above(inside) < 0.0).then(|| [end(a), end(b)])
}

/// The middle of a line.
pub(super) fn middle([a, b]: [f64; 2]) -> f64 {
    0.5 * (a + b)
}

/// Lines 0 to `last`, each looked at about the middle of the one before, where it is likely to be within the strip, too; `None` where one
/// is not.
pub(super) fn line_by_line(
    last: usize,
    line: impl Fn(usize, Option<f64>) -> Option<[f64; 2]>,
) -> Option<Vec<[f64; 2]>> {
    let mut inside = None;
    let next = |k: usize| {
        let found = line(k, inside)?;
        inside = Some(middle(found));
        Some(found)
    };
    (0..=last).map(next).collect()
}

/// Where bodies overlap on lines across a strip, evenly from its beginning to its end.
pub(super) struct Lines(pub Vec<[f64; 2]>);

impl Lines {
    /// Whether all that lies between two shares of the length and two distances across is in the strip, with its room.
    pub fn hold(&self, along: [f64; 2], across: [f64; 2]) -> bool {
        let last = (self.0.len() - 1) as f64;
        let line = |at: f64| at.clamp(0.0, last) as usize;
        let own = line((along[0] * last).floor())..=line((along[1] * last).ceil());
        self.0[own].iter().all(|[a, b]| across[0] >= a - ROOM * (b - a) && across[1] <= b + ROOM * (b - a))
    }

    /// Whether the bounds of the gap show that the bodies overlap within a box nowhere but `in_strip`, which is asked of parts of it.
    pub fn hold_all(&self, gap: &AnyGap, depth: f64, all: Rect, in_strip: impl Fn(&Rect) -> bool) -> bool {
        let narrowest = self.0.iter().map(|[a, b]| b - a).fold(f64::INFINITY, f64::min);
        let mut left = vec![all];
        let mut boxes = 0;
        while let Some(own) = left.pop() {
            boxes += 1;
            if gap.bounds(&own, [0.0; 2]).is_some_and(|[low, _]| low > depth) || in_strip(&own) {
                continue;
            }
            if boxes > MOST_BOXES || own.longer_side() < SMALLEST * narrowest {
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
}
