//! Force from above without a grid: a simpler gap, or a flat punch, that is pressed with at least as much.
//!
//! P grows with the overlap. A gap h - c with a repaired form that is no larger than g wherever g < d is pressed with at least the
//! force of g; h is given, and c is the supremum of h - g over {g < d}, found by halving rectangles on which g bounds itself
//! ([`crate::gap::Gap::bounds`]), or on a lattice where it cannot.

use std::collections::BinaryHeap;

use super::depth::first_touch;
use super::{Evidence, Repair, Side, Theorem};
use crate::closed_form::{FlatPunch, Hertz, Power};
use crate::gap::{AnyGap, Gap};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::problem::EffectiveModulus;

/// Points a side of the lattice on which comparison gaps are chosen.
const LATTICE: usize = 48;

/// Points a side of the lattice in place of a proof.
const SAMPLED: usize = 400;

/// Rectangles looked at before the supremum is taken as it is bounded by then.
const MOST: usize = 20_000;

/// Distance of the bound of a supremum from its value that is good enough, relative to the overlap.
const CLOSE: f64 = 1e-5;

/// Rectangles a side around what can touch.
const AROUND: usize = 96;

/// What a comparison starts from.
pub(super) struct Comparisons<'a> {
    pub gap: &'a AnyGap,
    pub modulus: EffectiveModulus,
    pub depth: f64,
    /// Holds {g < d}.
    pub reach: Rect,
    pub certain: bool,
}

/// A convex gap with a repaired form, zero at its centre.
#[derive(Clone, Copy)]
enum Simple {
    /// c r^n, n >= 1.
    Power { centre: [f64; 2], coefficient: f64, exponent: f64 },
    /// (a u^2 + b v^2)/2, u turned by an angle.
    Quadratic { centre: [f64; 2], curvatures: [f64; 2], angle: f64 },
}

impl Simple {
    /// Value and slopes.
    fn at(&self, [x, y]: [f64; 2]) -> (f64, [f64; 2]) {
        match *self {
            Self::Power { centre, coefficient, exponent } => {
                let v = [x - centre[0], y - centre[1]];
                let r = v[0].hypot(v[1]);
                let value = coefficient * r.powf(exponent);
                let slope = if r > 0.0 { value * exponent / (r * r) } else { 0.0 };
                (value, v.map(|v| v * slope))
            }
            Self::Quadratic { centre, curvatures: [a, b], angle } => {
                let (sin, cos) = angle.sin_cos();
                let v = [x - centre[0], y - centre[1]];
                let (s, t) = (cos * v[0] + sin * v[1], cos * v[1] - sin * v[0]);
                (0.5 * (a * s * s + b * t * t), [a * s * cos - b * t * sin, a * s * sin + b * t * cos])
            }
        }
    }

    fn scaled(self, by: f64) -> Self {
        match self {
            Self::Power { centre, coefficient, exponent } => {
                Self::Power { centre, coefficient: by * coefficient, exponent }
            }
            Self::Quadratic { centre, curvatures, angle } => {
                Self::Quadratic { centre, curvatures: curvatures.map(|c| by * c), angle }
            }
        }
    }

    fn force(&self, modulus: EffectiveModulus, depth: f64) -> Option<f64> {
        if depth <= 0.0 {
            return Some(0.0);
        }
        let force = match *self {
            Self::Power { coefficient, exponent, .. } => {
                Power::new(modulus, coefficient, exponent).ok()?.at_depth(depth).ok()?.force
            }
            Self::Quadratic { curvatures, .. } => {
                Hertz::new(modulus, curvatures.map(f64::recip)).ok()?.at_depth(depth).ok()?.force
            }
        };
        // The repaired forms are good to a few roundings.
        Some(force * (1.0 + 1e-12))
    }
}

impl Comparisons<'_> {
    /// The least force over the comparison gaps.
    pub fn least(&self, middle: [f64; 2], axes: Option<([f64; 2], f64)>) -> Side {
        let (touch, sure) = first_touch(self.gap, self.depth);
        let mut best = self.around(middle, touch, sure);
        let lattice = Grid::over(&self.reach, [LATTICE; 2]);
        let samples: Vec<([f64; 2], f64)> =
            lattice.centres().map(|p| (p, self.gap.gap(p[0], p[1]))).filter(|s| s.1 < self.depth).collect();
        for simple in self.candidates(middle, axes) {
            let above = |s: f64| {
                let trial = simple.scaled(s);
                let c = samples.iter().map(|(p, g)| trial.at(*p).0 - g).fold(f64::NEG_INFINITY, f64::max);
                trial.force(self.modulus, self.depth + c).unwrap_or(f64::INFINITY)
            };
            // The force over the scale has one minimum where it matters; a missed one costs width, not truth.
            let (mut scale, mut step) = (1.0, 1.3);
            let mut least = above(scale);
            for _ in 0..24 {
                let better = [scale * step, scale / step].map(|s| (s, above(s))).into_iter().find(|t| t.1 < least);
                match better {
                    Some(found) => (scale, least) = found,
                    None => step = 1.0 + 0.4 * (step - 1.0),
                }
            }
            if !(least < best.force) {
                continue;
            }
            let trial = simple.scaled(scale);
            let (c, at, proved) = self.supremum(&trial);
            let c = c + 1e-12 * (self.depth - touch).abs();
            if let Some(force) = trial.force(self.modulus, self.depth + c).filter(|f| *f < best.force) {
                best = self.side(force.next_up(), c, at, proved);
            }
        }
        best
    }

    fn side(&self, force: f64, violation: f64, at: [f64; 2], proved: bool) -> Side {
        Side {
            force,
            theorem: Theorem::Comparison,
            evidence: if proved { Evidence::Proved } else { Evidence::Sampled { per_cell: 0 } },
            violation: violation.max(0.0),
            at,
            repair: Repair::default(),
            pressure: None,
        }
    }

    /// A flat ellipse around everything that can touch, as deep as anything is: as wide as its box or a disc, whichever carries
    /// less.
    fn around(&self, middle: [f64; 2], touch: f64, sure: bool) -> Side {
        let half = self.reach.size().map(|s| 0.5 * s);
        let longer = half[0].max(half[1]);
        let corners = self.touching();
        let shapes = [(self.reach.centre(), half), (self.reach.centre(), [longer; 2]), (middle, [longer; 2])];
        let force = shapes
            .into_iter()
            .map(|(centre, half)| {
                // The least multiple of this shape that holds every corner.
                let from = |p: &[f64; 2]| ((p[0] - centre[0]) / half[0]).hypot((p[1] - centre[1]) / half[1]);
                let scale = corners.iter().map(from).fold(0.0, f64::max) * (1.0 + 1e-12);
                let punch = FlatPunch::ellipse(self.modulus, half.map(|h| h * scale));
                let force = punch.and_then(|p| p.at_depth(self.depth - touch)).map(|c| c.force * (1.0 + 1e-12));
                force.unwrap_or(f64::INFINITY)
            })
            .fold(f64::INFINITY, f64::min);
        self.side(force, 0.0, self.reach.centre(), sure && self.certain)
    }

    /// Corners of rectangles that together hold {g < d}.
    fn touching(&self) -> Vec<[f64; 2]> {
        let cells = Grid::over(&self.reach, [AROUND; 2]);
        let may = |rect: &Rect| self.gap.bounds(rect, [0.0; 2]).is_none_or(|[low, _]| low < self.depth);
        let rects = (0..cells.len()).map(|k| cells.cell(k % AROUND, k / AROUND).scaled(1.0 + 1e-9)).filter(may);
        rects.flat_map(|rect| rect.corners()).collect()
    }

    fn candidates(&self, middle: [f64; 2], axes: Option<([f64; 2], f64)>) -> Vec<Simple> {
        let lowest = self.gap.known().centre;
        let value = |[x, y]: [f64; 2]| self.gap.gap(x, y);
        let size = 0.25 * self.reach.size()[0].min(self.reach.size()[1]);
        let ring = |r: f64| {
            (0..16)
                .map(|k| (std::f64::consts::TAU * (f64::from(k) + 0.1) / 16.0).sin_cos())
                .map(|(s, c)| value([lowest[0] + r * c, lowest[1] + r * s]) - value(lowest))
                .fold(f64::INFINITY, f64::min)
        };
        let (inner, outer) = (ring(0.5 * size), ring(size));
        let mut all = Vec::new();
        let law = (outer / inner).log2();
        for exponent in [1.0, 2.0, law] {
            if exponent.is_finite() && exponent >= 1.0 && outer > 0.0 && outer.is_finite() {
                all.push(Simple::Power { centre: lowest, coefficient: outer / size.powf(exponent), exponent });
            }
        }
        if let Some(([a, b], angle)) = axes {
            let (sin, cos) = angle.sin_cos();
            let rise = |l: f64, [x, y]: [f64; 2]| {
                let ends = [1.0, -1.0].map(|s| value([middle[0] + s * l * x, middle[1] + s * l * y]));
                (ends[0] + ends[1] - 2.0 * value(middle)) / (l * l)
            };
            let curvatures = [rise(a, [cos, sin]), rise(b, [-sin, cos])];
            if curvatures.iter().all(|c| *c > 0.0 && c.is_finite()) {
                all.push(Simple::Quadratic { centre: middle, curvatures, angle });
            }
        }
        all
    }

    /// A bound of h - g over {g < d}, where it is nearly reached, and whether it is proved.
    fn supremum(&self, simple: &Simple) -> (f64, [f64; 2], bool) {
        let difference = |p: [f64; 2]| {
            let g = self.gap.gap(p[0], p[1]);
            if g < self.depth { simple.at(p).0 - g } else { f64::NEG_INFINITY }
        };
        // h is convex: less its tangent it is highest in a corner.
        let bound = |rect: &Rect| -> Option<f64> {
            if self.gap.bounds(rect, [0.0; 2])?[0] >= self.depth {
                return Some(f64::NEG_INFINITY);
            }
            let c = rect.centre();
            let (_, slope) = simple.at(c);
            let plane = |p: [f64; 2]| slope[0] * (p[0] - c[0]) + slope[1] * (p[1] - c[1]);
            let high = rect.corners().iter().map(|&p| simple.at(p).0 - plane(p)).fold(f64::NEG_INFINITY, f64::max);
            Some(high - self.gap.bounds(rect, slope)?[0])
        };
        let proved = self.certain.then(|| highest(&self.reach, bound, difference, CLOSE * self.depth.abs())).flatten();
        if let Some((c, at)) = proved {
            return (c, at, true);
        }
        let lattice = Grid::over(&self.reach, [SAMPLED; 2]);
        let points = lattice.centres().map(|p| (difference(p), p));
        let (c, at) = points.fold((f64::NEG_INFINITY, lattice.centre_of(0)), |a, b| if b.0 > a.0 { b } else { a });
        // What lies between the points: as much again as the steps of the lattice around the highest one.
        let [hx, hy] = lattice.spacing;
        let around = [[hx, 0.0], [-hx, 0.0], [0.0, hy], [0.0, -hy]].map(|s| difference([at[0] + s[0], at[1] + s[1]]));
        let step = around.into_iter().filter(|v| v.is_finite()).map(|v| c - v).fold(0.0, f64::max);
        (c + step, at, false)
    }
}

/// An upper bound of the supremum of a function over a rectangle, at most `close` above one of its values where that can be had,
/// by halving the rectangle with the highest bound. `None` when there are no bounds.
fn highest(
    rect: &Rect,
    bound: impl Fn(&Rect) -> Option<f64>,
    value: impl Fn([f64; 2]) -> f64,
    close: f64,
) -> Option<(f64, [f64; 2])> {
    let mut waiting = BinaryHeap::new();
    waiting.push(Piece { bound: bound(rect)?, rect: *rect });
    let mut found = (value(rect.centre()), rect.centre());
    for _ in 0..MOST {
        let top = waiting.pop()?;
        if top.bound <= found.0 + close {
            return Some((top.bound, found.1));
        }
        let c = top.rect.centre();
        let [w, h] = top.rect.size();
        let (mut low, mut high, axis) = (top.rect, top.rect, usize::from(h > w));
        (low.max[axis], high.min[axis]) = (c[axis], c[axis]);
        for rect in [low, high] {
            let middle = rect.centre();
            let there = value(middle);
            if there > found.0 {
                found = (there, middle);
            }
            waiting.push(Piece { bound: bound(&rect)?.min(top.bound), rect });
        }
    }
    waiting.pop().map(|top| (top.bound, found.1))
}

/// A rectangle, ordered by its bound.
struct Piece {
    bound: f64,
    rect: Rect,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound)
    }
}
