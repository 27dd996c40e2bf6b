//! Contacts that were lost: overlap where no cell is, and more of it than the pressure elsewhere can push away.

use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use super::broken;
use crate::gap::enclosure::{Candidate, halves};
use crate::gap::{AnyGap, Gap, Reach};
use crate::numeric::geometry::Rect;
use crate::solution::{Unsolved, Verdict};

/// Rectangles looked at for an overlap that was left out.
const BUDGET: usize = 400;

/// How far beyond the boxes is looked, in the size of all of them.
const BEYOND: f64 = 8.0;

/// Size of the smallest contact that is looked for, in that of the place that is looked at.
const POINT: f64 = 1e-6;

/// Points a side where a gap has no bounds.
const LATTICE: usize = 32;

/// Holds the gap at a depth against the boxes whose cells carry `force`: at a distance D from all of them the surface is pushed away by
/// no more than force/(pi D), so that a larger overlap there is a contact without pressure.
///
/// # Errors
/// `Inconsistent`, with the place.
pub(crate) fn nothing_left_out(gap: &AnyGap, depth: f64, boxes: &[Rect], force: f64) -> Result<(), Unsolved> {
    let Some(all) = boxes.iter().copied().reduce(|a, b| a.union(&b)) else { return Ok(()) };
    let beyond = all.scaled(BEYOND);
    let search = Search { gap, depth, boxes, force, least: POINT * beyond.longer_side() };
    // Where it is known that nothing overlaps, a gap may be beyond the range of numbers.
    let known_apart = |point: [f64; 2]| match gap.reach(depth) {
        Reach::Within(rect) => !rect.contains(point),
        Reach::Nowhere => true,
        Reach::Unbounded { .. } | Reach::Unknown => false,
    };
    for ring in [1.0, 2.0, BEYOND] {
        let rect = all.scaled(ring);
        let ([w, h], [x, y]) = (rect.size(), rect.centre());
        let at = |k: usize| (TAU * k as f64 / 16.0).sin_cos();
        for (sin, cos) in (0..16).map(at) {
            let square = sin.abs().max(cos.abs());
            let point = [x + 0.5 * w * cos / square, y + 0.5 * h * sin / square];
            if gap.gap(point[0], point[1]).is_nan() && !known_apart(point) {
                let [x, y] = point;
                return broken(format!(
                    "the gap at ({x:.3e}, {y:.3e}) is beyond the range of numbers: the overlap may go on"
                ));
            }
        }
    }
    match search.by_bounds(&beyond).unwrap_or_else(|| search.on_lattice(&beyond)) {
        None => Ok(()),
        Some([x, y]) => broken(format!(
            "the bodies overlap at ({x:.3e}, {y:.3e}) by more than the pressure elsewhere can push away, and no cell is there"
        )),
    }
}

/// The verdict where the number of cells was prescribed: a contact smaller than one of them is not to be seen.
pub(crate) fn too_few_cells(broken: &Unsolved) -> Unsolved {
    let reason = "the prescribed cells are too large for one of the contacts";
    Unsolved::new(Verdict::ToleranceNotReached, reason).without_numbers(broken)
}

struct Search<'a> {
    gap: &'a AnyGap,
    depth: f64,
    boxes: &'a [Rect],
    force: f64,
    /// What touches only nearer to a point than this is a needle that carries nothing.
    least: f64,
}

impl Search<'_> {
    /// Least distance of a point from the boxes.
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        let outside = |low: f64, high: f64, x: f64| (low - x).max(x - high).max(0.0);
        let from = |rect: &Rect| outside(rect.min[0], rect.max[0], x).hypot(outside(rect.min[1], rect.max[1], y));
        self.boxes.iter().map(from).fold(f64::INFINITY, f64::min)
    }

    /// Overlap less the most that it can have been pushed away by.
    fn excess(&self, point: [f64; 2]) -> f64 {
        self.depth - self.gap.gap(point[0], point[1]) - self.force / (PI * self.distance(point)) * (1.0 + 1e-6)
    }

    /// Whether there is an excess at a point and on all sides of it.
    fn touches_about(&self, [x, y]: [f64; 2]) -> bool {
        let h = self.least;
        [[x, y], [x - h, y], [x + h, y], [x, y - h], [x, y + h]].into_iter().all(|point| self.excess(point) > 0.0)
    }

    fn candidate(&self, rect: Rect) -> Option<Candidate> {
        let [lower, _] = self.gap.bounds(&rect, [0.0; 2])?;
        let [w, h] = rect.size();
        let farthest = self.distance(rect.centre()) + 0.5 * w.hypot(h);
        // The most that the overlap in it can exceed the displacement by.
        Some(Candidate { bound: self.depth - lower - self.force / (PI * farthest), rect })
    }

    /// A point in contact without a cell, by branch and bound; `None` where the gap has no bounds.
    fn by_bounds(&self, domain: &Rect) -> Option<Option<[f64; 2]>> {
        let mut open = BinaryHeap::from([self.candidate(*domain)?]);
        for _ in 0..BUDGET {
            let Some(Candidate { bound: excess, rect }) = open.pop() else { break };
            if !(excess > 0.0) {
                break;
            }
            let centre = rect.centre();
            if self.touches_about(centre) {
                return Some(Some(centre));
            }
            open.extend(halves(&rect, [1.0; 2]).into_iter().filter_map(|half| self.candidate(half)));
        }
        Some(None)
    }

    /// The same at the points of a lattice.
    fn on_lattice(&self, domain: &Rect) -> Option<[f64; 2]> {
        let size = domain.size();
        let at = |n: usize, m: usize| domain.min[m] + size[m] * (n as f64 + 0.5) / LATTICE as f64;
        (0..LATTICE * LATTICE)
            .map(|k| [at(k % LATTICE, 0), at(k / LATTICE, 1)])
            .find(|&point| self.touches_about(point))
    }
}
