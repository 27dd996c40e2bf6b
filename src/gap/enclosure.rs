//! What follows from certain bounds of a gap over rectangles: where it is below a depth, in how many parts, and its mean.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};

use super::{Gap, Reach};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// A side is found to this part of the rectangle's extent.
const FINE: f64 = 1.0 / 32.0;

/// The same while the rectangle still shrinks.
const COARSE: f64 = 0.25;

/// Rectangles looked at for one side.
const BUDGET: usize = 600;

/// Rounds of shrinking: each leaves at most four fifths.
const ROUNDS: usize = 200;

/// A rectangle of a branch and bound, the one of the largest bound first.
pub(crate) struct Candidate {
    /// Bound of what is sought.
    pub bound: f64,
    pub rect: Rect,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// The two halves of a rectangle, cut across the side that is longer in units of `extent`.
pub(crate) fn halves(rect: &Rect, extent: [f64; 2]) -> [Rect; 2] {
    let ([w, h], c) = (rect.size(), rect.centre());
    let (mut a, mut b) = (*rect, *rect);
    let axis = usize::from(h / extent[1] > w / extent[0]);
    (a.max[axis], b.min[axis]) = (c[axis], c[axis]);
    [a, b]
}

/// How far {lower < depth} inside `outer` reaches along an axis (`upwards` or down), to `fine` of the extent; `None` when it is empty.
fn farthest(
    lower: &dyn Fn(&Rect) -> f64,
    depth: f64,
    outer: &Rect,
    axis: usize,
    upwards: bool,
    fine: f64,
) -> Option<f64> {
    let extent = outer.size();
    let far = |rect: &Rect| if upwards { rect.max[axis] } else { -rect.min[axis] };
    let mut open = BinaryHeap::from([Candidate { bound: far(outer), rect: *outer }]);
    for _ in 0..BUDGET {
        let Candidate { bound: reached, rect } = open.pop()?;
        if !(lower(&rect) < depth) {
            continue;
        }
        if rect.size()[axis] <= fine * extent[axis] {
            return Some(if upwards { reached } else { -reached });
        }
        for half in halves(&rect, extent) {
            open.push(Candidate { bound: far(&half), rect: half });
        }
    }
    open.pop().map(|c| if upwards { c.bound } else { -c.bound })
}

/// The part of `outer` that holds all points where the gap can be below the depth, from lower bounds of the gap over rectangles.
/// `mirrors`: a point, and whether the gap is its own image in the lines x = c and y = c through it.
pub(super) fn tightened(
    lower: &dyn Fn(&Rect) -> f64,
    depth: f64,
    outer: &Rect,
    mirrors: ([f64; 2], [bool; 2]),
) -> Reach {
    let mut rect = *outer;
    let (c, mirrored) = mirrors;
    let mut fine = COARSE;
    for _ in 0..ROUNDS {
        let before = rect.size();
        for (axis, upwards) in [(0, true), (0, false), (1, true), (1, false)] {
            let side = if mirrored[axis] && !upwards {
                // The other side was found already.
                let image = 2.0 * c[axis] - rect.max[axis];
                image - 4.0 * f64::EPSILON * (image.abs() + c[axis].abs())
            } else {
                match farthest(lower, depth, &rect, axis, upwards, fine) {
                    Some(side) => side,
                    None => return Reach::Nowhere,
                }
            };
            if upwards {
                rect.max[axis] = rect.max[axis].min(side);
            } else {
                rect.min[axis] = rect.min[axis].max(side);
            }
        }
        let snug = (0..2).all(|m| rect.size()[m] > 0.7 * before[m]);
        if fine == FINE {
            break;
        }
        if snug {
            fine = FINE;
        }
    }
    Reach::Within(rect)
}

/// Least value of a gap over a rectangle: a point, the value there, and a bound below all others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Least {
    /// Where the least value was found.
    pub at: [f64; 2],
    /// The value there.
    pub value: f64,
    /// No value is less.
    pub bound: f64,
}

/// Rectangles looked at for the least value.
const LEAST_BUDGET: usize = 20_000;

/// The least value of a gap over a rectangle, by branch and bound on its lower bounds: until value and bound differ by less than
/// `close`, a value is less than `enough`, or every bound is at least `enough`. `None` where the gap has no bounds.
pub(crate) fn least(gap: &(impl Gap + ?Sized), outer: &Rect, close: f64, enough: f64) -> Option<Least> {
    least_but_for(gap, outer, close, enough, None)
}

/// The same where a low point is known: about it the gap is not looked at where it is known to be convex.
pub(crate) fn lower_than(gap: &(impl Gap + ?Sized), outer: &Rect, enough: f64, low: [f64; 2]) -> Option<Least> {
    least_but_for(gap, outer, 0.0, enough, basin(gap, outer, low).filter(|(_, bound)| *bound >= enough))
}

/// A rectangle about a point in which the gap is convex, and what it is nowhere less than there: its tangent plane at the point.
fn basin(gap: &(impl Gap + ?Sized), outer: &Rect, low: [f64; 2]) -> Option<(Rect, f64)> {
    let convex = |rect: &Rect| {
        let taylor = gap.taylor(rect)?;
        let [xx, xy, yy] = taylor.hessian;
        (xx.lo > 0.0 && yy.lo > 0.0 && (xx.lo * yy.lo).next_down() > xy.magnitude().powi(2).next_up()).then_some(taylor)
    };
    let sizes = (0..BASINS).map(|k| outer.size().map(|side| side * f64::from(1 << k).recip()));
    let (rect, taylor) = sizes.map(|half| Rect::around(low, half)).find_map(|rect| Some((rect, convex(&rect)?)))?;
    let [w, h] = rect.size();
    let [gx, gy] = taylor.gradient.map(Interval::magnitude);
    Some((rect, taylor.value.lo - 0.5 * (gx * w + gy * h) * (1.0 + 8.0 * f64::EPSILON)))
}

/// Sizes of such a rectangle that are tried, each half of the one before.
const BASINS: i32 = 12;

fn least_but_for(
    gap: &(impl Gap + ?Sized),
    outer: &Rect,
    close: f64,
    enough: f64,
    basin: Option<(Rect, f64)>,
) -> Option<Least> {
    let value = |[x, y]: [f64; 2]| Some(gap.gap(x, y)).filter(|g| !g.is_nan()).unwrap_or(f64::INFINITY);
    let c = outer.centre();
    let mut best = Least { at: c, value: value(c), bound: gap.bounds(outer, [0.0; 2])?[0] };
    let mut open = BinaryHeap::from([Candidate { bound: -best.bound, rect: *outer }]);
    let mut dropped = f64::INFINITY;
    for _ in 0..LEAST_BUDGET {
        let Some(Candidate { bound: far, rect }) = open.pop() else { break };
        best.bound = (-far).min(dropped);
        if best.value - best.bound <= close || best.value < enough || best.bound >= enough {
            return Some(best);
        }
        for half in halves(&rect, outer.size()) {
            if let Some((_, bound)) = basin.filter(|(convex, _)| half.corners().iter().all(|c| convex.contains(*c))) {
                dropped = dropped.min(bound);
                continue;
            }
            let [low, _] = gap.bounds(&half, [0.0; 2])?;
            let mut points = vec![half.centre()];
            points.extend(half.corners());
            for at in points {
                let here = value(at);
                if here < best.value {
                    best = Least { at, value: here, ..best };
                }
            }
            let c = half.centre();
            // A rectangle that cannot be cut any more is a point.
            let cut = (0..2).any(|m| half.min[m] < c[m] && c[m] < half.max[m]);
            if low < best.value && cut {
                open.push(Candidate { bound: -low, rect: half });
            } else {
                dropped = dropped.min(low.max(best.value));
            }
        }
    }
    best.bound = open.peek().map_or(best.value, |c| -c.bound).min(dropped).min(best.value);
    Some(best)
}

/// Parts along a side into which a rectangle is cut when its pieces are told apart.
const PARTS: usize = 24;

/// Zooming into a piece ends after so many levels: each is at most a quarter as long as the one before.
const DEEPEST: usize = 60;

/// More pieces than this are not told apart.
const MOST: usize = 256;

/// Rectangles that are cut into parts, at most: a thin strip aslant to them falls into ever more pieces.
const ZOOMS: usize = 512;

/// Rectangles that together hold all points of `outer` where the gap can be below the depth, separate as far as bounds over
/// rectangles tell them apart.
pub(super) fn components(lower: &dyn Fn(&Rect) -> f64, depth: f64, outer: &Rect) -> Vec<Rect> {
    let mut done = Vec::new();
    let mut open = VecDeque::from([(*outer, 0)]);
    let mut zooms = 0;
    while let Some((rect, level)) = open.pop_front() {
        zooms += 1;
        if zooms > ZOOMS {
            done.push(rect);
            continue;
        }
        let parts = clusters(lower, depth, &rect);
        for part in parts {
            let (size, whole) = (part.size(), rect.size());
            let small = (0..2).all(|m| size[m] < 0.25 * whole[m]);
            if small && level < DEEPEST && open.len() + done.len() < MOST {
                open.push_back((part, level + 1));
            } else {
                done.push(part);
            }
        }
        if done.len() + open.len() > MOST {
            return vec![*outer];
        }
    }
    done
}

/// The connected groups of cells of a lattice over the rectangle that can hold points below the depth, each as its rectangle.
fn clusters(lower: &dyn Fn(&Rect) -> f64, depth: f64, rect: &Rect) -> Vec<Rect> {
    let lattice = crate::grid::Grid::over(rect, [PARTS; 2]);
    let alive: Vec<bool> = (0..PARTS * PARTS).map(|k| lower(&lattice.cell(k % PARTS, k / PARTS)) < depth).collect();
    let mut label = vec![usize::MAX; alive.len()];
    let mut found: Vec<Rect> = Vec::new();
    for start in (0..alive.len()).filter(|&k| alive[k]).collect::<Vec<_>>() {
        if label[start] != usize::MAX {
            continue;
        }
        let (group, mut stack) = (found.len(), vec![start]);
        label[start] = group;
        let mut hull = lattice.cell(start % PARTS, start / PARTS);
        while let Some(k) = stack.pop() {
            let (i, j) = (k % PARTS, k / PARTS);
            hull = hull.union(&lattice.cell(i, j));
            for m in j.saturating_sub(1)..(j + 2).min(PARTS) {
                for n in i.saturating_sub(1)..(i + 2).min(PARTS) {
                    let next = m * PARTS + n;
                    if alive[next] && label[next] == usize::MAX {
                        label[next] = group;
                        stack.push(next);
                    }
                }
            }
        }
        found.push(hull);
    }
    found
}

/// Bounds of the mean of a gap over a rectangle, from its Taylor form or its range.
pub(super) fn mean(gap: &(impl Gap + ?Sized), rect: &Rect) -> Option<[f64; 2]> {
    if let Some(taylor) = gap.taylor(rect) {
        let mean = taylor.mean(rect.size());
        // Close to a tip second derivatives have no bound, and values have.
        let rise = taylor.gradient[0].magnitude() * rect.size()[0] + taylor.gradient[1].magnitude() * rect.size()[1];
        if mean.width() <= rise {
            return Some([mean.lo, mean.hi]);
        }
        let [low, high] = gap.bounds(rect, [0.0; 2])?;
        return Some([mean.lo.max(low), mean.hi.min(high)]);
    }
    let [x, y] = rect.centre();
    let slope = gap.gradient(x, y).filter(|g| g.iter().all(|g| g.is_finite())).unwrap_or([0.0; 2]);
    gap.bounds(rect, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: ([f64; 2], [bool; 2]) = ([0.0; 2], [false; 2]);

    /// Least distance squared of a rectangle from a point.
    fn near(rect: &Rect, [x, y]: [f64; 2]) -> f64 {
        let d = |m: usize, v: f64| (rect.min[m] - v).max(v - rect.max[m]).max(0.0);
        d(0, x).powi(2) + d(1, y).powi(2)
    }

    #[test]
    fn a_small_disc_in_a_vast_rectangle_is_found() {
        for scale in [1.0, 1e-9, 1e-80] {
            let lower = |rect: &Rect| near(rect, [0.3, -0.7]);
            let outer = Rect::around([0.0; 2], [1.0; 2]);
            let Reach::Within(found) = tightened(&lower, scale * scale * 1e-4, &outer, NONE) else { panic!("bounded") };
            let r = 1e-2 * scale;
            if scale > 1e-20 {
                assert!(found.max[0] >= 0.3 + r && found.max[0] <= 0.3 + 1.1 * r, "{scale}: {found:?}");
                assert!(found.min[1] <= -0.7 - r && found.min[1] >= -0.7 - 1.1 * r, "{scale}: {found:?}");
            }
        }
        assert_eq!(tightened(&|_| 2.0, 1.0, &Rect::around([0.0; 2], [1.0; 2]), NONE), Reach::Nowhere);
    }

    #[test]
    fn two_pits_a_million_radii_apart_are_two() {
        let lower = |rect: &Rect| near(rect, [-1.0, 0.0]).min(near(rect, [1.0, 0.3]));
        let found = components(&lower, 1e-12, &Rect::around([0.0; 2], [1.5; 2]));
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|r| r.size()[0] < 2e-5 && r.size()[0] >= 2e-6), "{found:?}");
    }
}
