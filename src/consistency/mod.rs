//! Laws that every frictionless contact obeys, held against an answer by ways that did not lead to it. An answer that breaks one of
//! them is no answer, whatever error it states: the verdict is `inconsistent`, with the law and the numbers.
//!
//! | law | what breaks it |
//! |---|---|
//! | a limit of grids lies no further from the finest than half an order of convergence leaves room for | a law of similarity that the gap does not follow |
//! | P >= P(A), the force of the flat punch A under the overlap (Barber 1974), A the ellipse of the patch, or the flat part of the gap | a force that is too low |
//! | where the bodies overlap and no cell is, the pressure elsewhere has pushed the surface away | contacts that were lost |
//! | the overlap ends: no value near its end is beyond the range of numbers | an overflow taken for the end of the material |
//! | P is convex in the depth d above first touch: P <= S d, P^2/(2 S) <= U <= P d/2; for a gap of degree k, U = P d/(2 + 1/k) | energy, stiffness and force of different contacts |
//! | a proved bracket holds part of what the error allows | an error that is too small |
//!
//! E* = 1 throughout.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use crate::approximate::fabrikant::agm;
use crate::gap::{AnyGap, Degree, Gap};
use crate::grid_method::single_grid::GridState;
use crate::numeric::geometry::Rect;
use crate::numeric::quadrature::GaussLegendre;
use crate::overlap::Scaled;
use crate::solution::{Unsolved, Verdict};

/// The force of a contact at a depth, and its error, absolute.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Claim {
    pub force: f64,
    pub error: f64,
}

/// The least order of convergence; of a homogeneous gap whose degree is less, that: its pressure is singular at the tip.
const LEAST_ORDER: f64 = 0.5;

/// What a rule of quadrature, the cells of a patch, or a stiffness on them may be off by.
const ROOM: f64 = 5e-3;

/// The same of a stiffness: that of a patch whose edge is known to a cell.
const ROOM_OF_STIFFNESS: f64 = 0.1;

/// # Errors
/// `Inconsistent`, when the limit of grids is not that of their sums of pressures, coarse to fine.
pub(crate) fn limit_of(sums: &[f64], degree: Option<Degree>, claim: Claim) -> Result<(), Unsolved> {
    let Some(&finest) = sums.last() else { return Ok(()) };
    let steps = sums.iter().rev().take(3).map(|s| (s - finest).abs()).fold(0.0, f64::max);
    let order = degree.map_or(LEAST_ORDER, |k| LEAST_ORDER.min(1.0 / k.inverse()));
    // From the finer of two grids, one of twice the cells, the limit lies so many steps between the two.
    let steps_left = 1.0 / (order.exp2() - 1.0);
    let room = steps_left * steps + claim.error + 1e-9 * finest;
    if (claim.force - finest).abs() <= room {
        return Ok(());
    }
    let Claim { force, error } = claim;
    broken(format!(
        "the force {force:e}, stated to {error:.1e}, is not the limit of grids: the pressures of the finest add up to {finest:e}"
    ))
}

/// # Errors
/// `Inconsistent`, when the flat punch on the ellipse of the patch alone carries more.
pub(crate) fn above_ellipse(scaled: &Scaled, state: &GridState, claim: Claim) -> Result<(), Unsolved> {
    let Some(least) = Ellipse::of(state).and_then(|ellipse| ellipse.force(scaled, state)) else { return Ok(()) };
    above(least * (1.0 - ROOM), claim, "an ellipse of the size of the patch")
}

/// # Errors
/// `Inconsistent`, when less is claimed than a flat punch carries.
fn above(least: f64, Claim { force, error }: Claim, punch: &str) -> Result<(), Unsolved> {
    if force + error >= least {
        return Ok(());
    }
    broken(format!("the force {force:e}, stated to {error:.1e}, is below {least:e}, that of a flat punch on {punch}"))
}

/// # Errors
/// `Inconsistent`, when the force lies outside of bounds by more than its error.
pub(crate) fn within([lower, upper]: [f64; 2], Claim { force, error }: Claim, whose: &str) -> Result<(), Unsolved> {
    let room = error + 1e-12 * force;
    if force + room >= lower && force - room <= upper {
        return Ok(());
    }
    broken(format!(
        "the force {force:e}, stated to {error:.1e}, does not lie between {lower:e} and {upper:e}, the bounds by {whose}"
    ))
}

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
    let search = Search { gap, depth, boxes, force, least: POINT * beyond.size()[0].max(beyond.size()[1]) };
    for ring in [1.0, 2.0, BEYOND] {
        let rect = all.scaled(ring);
        let ([w, h], [x, y]) = (rect.size(), rect.centre());
        let at = |k: usize| (TAU * k as f64 / 16.0).sin_cos();
        for (sin, cos) in (0..16).map(at) {
            let square = sin.abs().max(cos.abs());
            let point = [x + 0.5 * w * cos / square, y + 0.5 * h * sin / square];
            if gap.gap(point[0], point[1]).is_nan() {
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

struct Search<'a> {
    gap: &'a AnyGap,
    depth: f64,
    boxes: &'a [Rect],
    force: f64,
    /// What touches only nearer to a point than this is a needle that carries nothing.
    least: f64,
}

/// A rectangle and the most that the overlap in it can exceed the displacement by.
struct Candidate {
    excess: f64,
    rect: Rect,
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
        self.excess.total_cmp(&other.excess)
    }
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
        Some(Candidate { excess: self.depth - lower - self.force / (PI * farthest), rect })
    }

    /// A point in contact without a cell, by branch and bound; `None` where the gap has no bounds.
    fn by_bounds(&self, domain: &Rect) -> Option<Option<[f64; 2]>> {
        let mut open = BinaryHeap::from([self.candidate(*domain)?]);
        for _ in 0..BUDGET {
            let Some(Candidate { excess, rect }) = open.pop() else { break };
            if !(excess > 0.0) {
                break;
            }
            let centre = rect.centre();
            if self.touches_about(centre) {
                return Some(Some(centre));
            }
            let axis = usize::from(rect.size()[1] > rect.size()[0]);
            let (mut a, mut b) = (rect, rect);
            (a.max[axis], b.min[axis]) = (centre[axis], centre[axis]);
            open.extend([a, b].into_iter().filter_map(|half| self.candidate(half)));
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

/// The ellipse with the area and the second moments of a patch.
struct Ellipse {
    centre: [f64; 2],
    semi_axes: [f64; 2],
    turn: f64,
}

impl Ellipse {
    fn of(state: &GridState) -> Option<Self> {
        let grid = &state.problem.grid;
        let pressed = || (0..grid.len()).filter(|&k| state.solution.pressure[k] > 0.0).map(|k| grid.centre_of(k));
        let count = pressed().count();
        if count < 16 {
            return None;
        }
        let mean = |of: &dyn Fn([f64; 2]) -> f64| pressed().map(of).sum::<f64>() / count as f64;
        let centre = [mean(&|p| p[0]), mean(&|p| p[1])];
        let about = |i: usize, j: usize| mean(&|p| (p[i] - centre[i]) * (p[j] - centre[j]));
        let (xx, xy, yy) = (about(0, 0), about(0, 1), about(1, 1));
        let (half, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        // A uniform ellipse has second moments of a quarter of its squared semi-axes.
        let semi_axes = [2.0 * (half + radius).sqrt(), 2.0 * (half - radius).max(0.0).sqrt()];
        let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
        (semi_axes[1] > 0.0).then_some(Self { centre, semi_axes, turn })
    }

    /// P(A) = K * mean of the overlap under the pressure of the flat punch A, K = pi a/K(e) for semi-axes a >= b (Barber & Billings
    /// 1990, eq. 5, exact on an ellipse), less what two rules differ by. `None` where there is no material on part of it.
    fn force(&self, scaled: &Scaled, state: &GridState) -> Option<f64> {
        let (sin, cos) = self.turn.sin_cos();
        let [a, b] = self.semi_axes;
        let grid = &state.problem.grid;
        let own = |[x, y]: [f64; 2]| {
            let (x, y) = (x - self.centre[0], y - self.centre[1]);
            [(cos * x + sin * y) / a, (cos * y - sin * x) / b]
        };
        // Cells that the ellipse meets.
        let near = 1.0 + grid.spacing[0].max(grid.spacing[1]) / b;
        let meets = |k: &usize| {
            let [x, y] = own(grid.centre_of(*k));
            x.hypot(y) <= near
        };
        if (0..grid.len()).filter(meets).any(|k| !state.problem.overlap[k].is_finite()) {
            return None;
        }
        let mean = |radii: usize, angles: usize| {
            // With rho = sqrt(1 - t^2) the weight rho/sqrt(1 - rho^2) d rho is dt.
            GaussLegendre::new(radii)
                .nodes()
                .iter()
                .map(|(t, weight)| {
                    let rho = (1.0 - (0.5 + 0.5 * t).powi(2)).sqrt();
                    let around = |k: usize| {
                        let (s, c) = (TAU * (k as f64 + 0.5) / angles as f64).sin_cos();
                        let (x, y) = (a * rho * c, b * rho * s);
                        let point = [self.centre[0] + cos * x - sin * y, self.centre[1] + sin * x + cos * y];
                        scaled.depth - Gap::gap(&scaled.gap, point[0], point[1])
                    };
                    0.5 * weight * (0..angles).map(around).sum::<f64>() / angles as f64
                })
                .sum::<f64>()
        };
        // K(e) = pi/(2 agm(1, b/a)).
        let stiffness = 2.0 * a * agm(1.0, b / a);
        let (fine, coarse) = (stiffness * mean(16, 48), stiffness * mean(9, 28));
        let least = fine - 2.0 * (fine - coarse).abs();
        least.is_finite().then_some(least)
    }
}

/// Force, energy and stiffness of one state in any units, and the depth above first touch, or above a bound of all gaps where that is not
/// known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Response {
    pub claim: Claim,
    pub energy: Option<f64>,
    pub stiffness: f64,
    pub depth: f64,
    pub degree: Option<Degree>,
}

impl Response {
    /// # Errors
    /// `Inconsistent`, when force, energy and stiffness cannot belong to one contact.
    pub fn of_one_contact(&self) -> Result<(), Unsolved> {
        let Self { claim: Claim { force, error }, energy, stiffness, depth, degree } = *self;
        let error = error / force + 1e-9;
        // P/S and U/P, lengths: products may be beyond the range of numbers.
        let straight = force / stiffness;
        if !(straight <= depth * (1.0 + error + ROOM_OF_STIFFNESS)) {
            return broken(format!("the force {force:e} is more than stiffness {stiffness:e} times depth {depth:e}"));
        }
        let Some(energy) = energy else { return Ok(()) };
        let mean = energy / force;
        if let Some(degree) = degree {
            let law = depth / (2.0 + degree.inverse());
            if !((mean - law).abs() <= error * law) {
                return broken(format!(
                    "the energy {energy:e} is {mean:e} times the force {force:e}; by the law of the gap it is {law:e}"
                ));
            }
        }
        let (low, high) = (0.5 * straight, 0.5 * depth);
        if low * (1.0 - error - ROOM_OF_STIFFNESS) <= mean && mean <= high * (1.0 + error + ROOM) {
            return Ok(());
        }
        broken(format!(
            "the energy {energy:e} is {mean:e} times the force {force:e}, not from {low:e} (by the stiffness) to {high:e}"
        ))
    }
}

fn broken(reason: String) -> Result<(), Unsolved> {
    let hint = "this should not happen: another method (`contact-patch compare`) or a prescribed number of cells may answer; please report it";
    Err(Unsolved::new(Verdict::Inconsistent, reason).with_hint(hint))
}

#[cfg(test)]
mod tests {
    //! Causes that no caller can put back: estimates on too few cells, and grids where a flat part is known.
    use super::*;
    use crate::by_edges;
    use crate::gap::Polyhedron;
    use crate::overlap::Overlap;
    use crate::problem::Settings;
    #[cfg(feature = "formula")]
    use crate::{
        energy::{Trial, force_bounds},
        refinement::as_far_as,
        settings::{ErrorBar, Method},
    };

    fn assert_stopped(answer: Result<(), Unsolved>) {
        match answer {
            Err(unsolved) => assert_eq!(unsolved.verdict, Verdict::Inconsistent, "{unsolved}"),
            Ok(()) => panic!("not stopped"),
        }
    }

    fn overlap(gap: AnyGap, depth: f64) -> Overlap {
        Overlap::of(&gap, depth).unwrap().unwrap()
    }

    /// A slender homogeneous gap on few cells across the contact: a force off by 2.1, 3.4 and 5.6 times what it stated was printed once.
    #[cfg(feature = "formula")]
    #[test]
    fn an_estimate_from_too_few_cells_is_stopped_by_the_proof() {
        let gap = crate::gap::Formula::new("x^4 + 16*y^4").unwrap();
        let scaled = overlap(gap.into_any(), 0.158).scaled();
        let law = scaled.gap.known().law.unwrap();
        let settings = Settings { evidence: ErrorBar::Estimate, tolerance: 1e-5, ..Settings::default() };
        let found = as_far_as(200, &scaled, &settings, Method::Fft, Some(law)).unwrap();
        let GridState { problem, solution, .. } = &found.state;
        let trial =
            Trial { grid: &problem.grid, pressure: &solution.pressure, displacement: Some(&solution.displacement) };
        let bounds = force_bounds(&scaled, law.degree, &trial, settings.tolerance).unwrap();
        let stated = 1e-3 * found.force;
        within(bounds, Claim { force: found.force, error: found.error }, "the energy").unwrap();
        for off in [2.1, 3.4, 5.6] {
            assert_stopped(within(bounds, Claim { force: found.force - off * stated, error: stated }, "the energy"));
            assert_stopped(within(bounds, Claim { force: found.force + off * stated, error: stated }, "the energy"));
        }
    }

    /// A truncated pyramid on a grid: 2.5 stated errors below the punch that its flat is.
    #[test]
    fn a_force_below_that_of_the_flat_is_stopped() {
        let settings = Settings::default();
        let pyramid = Polyhedron::truncated_pyramid(4, 45f64.to_radians(), 0.5).unwrap();
        let overlap = overlap(pyramid.into_any(), 5e-5);
        let [lower, upper] = by_edges::force_bounds(&overlap, &settings).unwrap();
        let stated = 1e-3 * lower;
        let claim = |force: f64| Claim { force, error: stated };
        within([lower, upper], claim(lower), "").unwrap();
        assert_stopped(within([lower, upper], claim(lower - 2.5 * stated), ""));
    }
}
