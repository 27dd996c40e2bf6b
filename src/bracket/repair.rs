//! From suprema to forces: how a pressure that is nearly admissible becomes one that is.
//!
//! Two ways, for each side. *Scaling*: with S q >= f/lambda where f > 0, lambda q is admissible; with S q <= lambda f on
//! supp q, q/lambda is. *Discs*: a flat disc of radius R under displacement e carries 2 E* R e (Boussinesq) and has no
//! negative displacement anywhere, so a stack of discs that covers every {violation > e} repairs an upper pressure; and since
//! P(f + v) <= P(f) + P(v), the force of the same stack is the most that a lower pressure can be too large by.
//! *Another depth*: S q >= f - e makes q enough for the depth d - e, and the force of a homogeneous gap follows from that at
//! any other depth; likewise S q <= f + e. Discs then repair what exceeds e.
//! A lower pressure may also drop cells: what is left displaces less everywhere.

use super::exterior::Exterior;
use super::problem::BracketProblem;
use super::violation::Violation;
use super::{Evidence, Repair, Side, Theorem};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;

/// A side of the bracket in the units of the problem.
pub(super) struct Repaired {
    pub force: f64,
    pub theorem: Theorem,
    /// What every pressure is multiplied by.
    pub factor: f64,
    /// Cells that keep their pressure; `None`: all.
    pub kept: Option<Vec<bool>>,
    /// Largest violation that scaling and dropping leave.
    pub left: f64,
    /// Force of the discs.
    pub discs: f64,
    /// Violation made good by another depth.
    pub level: f64,
    /// The cell, or rectangle, with the largest violation before repair.
    pub at: [f64; 2],
}

impl Repaired {
    /// A side in the user's units.
    pub fn side(self, problem: &BracketProblem, q: &[f64], evidence: Evidence) -> Side {
        let kept = |k: usize| self.kept.as_ref().is_none_or(|kept| kept[k]);
        let factor = self.factor * problem.unit_pressure;
        let values = q.iter().enumerate().map(|(k, q)| if kept(k) { q * factor } else { 0.0 }).collect();
        Side {
            force: self.force * problem.unit_force,
            theorem: self.theorem,
            evidence,
            violation: self.left * problem.units.height,
            at: problem.units.outward(self.at),
            repair: Repair {
                discs: self.discs * problem.unit_force,
                level: self.level * problem.units.height,
                degree: problem.degree.filter(|_| self.level > 0.0),
            },
            pressure: Some(Pressure { grid: problem.given, values }),
        }
    }
}

/// Steps between no scaling and scaling alone.
const MIXTURES: usize = 8;

/// Levels of a stack of discs: a height counts as the next level above.
const LEVELS: usize = 400;

/// Calls `with` with every level and the force of the stack of discs over what exceeds it: 2 times the integral of the
/// radius over the height. `violations`: (height, cell), heights that are positive count; `rest`: more of them, where they are.
/// The last level is 0.
fn stacks(
    grid: &Grid,
    violations: impl Iterator<Item = (f64, usize)> + Clone,
    rest: impl Iterator<Item = (f64, Rect)> + Clone,
    mut with: impl FnMut(f64, f64),
) {
    let highest = violations.clone().map(|v| v.0).chain(rest.clone().map(|v| v.0)).fold(0.0, f64::max);
    with(highest, 0.0);
    if !(highest > 0.0 && highest.is_finite()) {
        if highest > 0.0 {
            with(0.0, f64::INFINITY);
        }
        return;
    }
    // What lies above each level, in cells as long as that will do.
    let nx = grid.shape[0];
    let level = |height: f64| ((height / highest * LEVELS as f64) as usize).min(LEVELS - 1);
    let mut boxes: [Option<[[usize; 2]; 2]>; LEVELS] = [None; LEVELS];
    for (height, k) in violations.clone().filter(|v| v.0 > 0.0) {
        let (i, j) = (k % nx, k / nx);
        let [low, high] = boxes[level(height)].get_or_insert([[i, j], [i, j]]);
        (low[0], high[0]) = (low[0].min(i), high[0].max(i));
        (low[1], high[1]) = (low[1].min(j), high[1].max(j));
    }
    let mut rects =
        boxes.map(|held| held.map(|[low, high]| grid.cell(low[0], low[1]).union(&grid.cell(high[0], high[1]))));
    for (height, rect) in rest.filter(|v| v.0 > 0.0) {
        let held = &mut rects[level(height)];
        *held = Some(held.map_or(rect, |h| h.union(&rect)));
    }
    let Some(centre) = rects.iter().flatten().copied().reduce(|a, b| a.union(&b)).map(|r| r.centre()) else { return };
    // Distances of the furthest corners from there.
    let mut about_centre = [0.0_f64; LEVELS];
    let half = grid.spacing.map(|h| 0.5 * h);
    for (height, k) in violations.filter(|v| v.0 > 0.0) {
        let c = grid.centre(k % nx, k / nx);
        let [x, y] = [(c[0] - centre[0]).abs() + half[0], (c[1] - centre[1]).abs() + half[1]];
        let held = &mut about_centre[level(height)];
        *held = held.max(x * x + y * y);
    }
    about_centre.iter_mut().for_each(|far| *far = far.sqrt());
    for (rect, far) in rects.iter().zip(&mut about_centre) {
        // The boxes of what lies beyond the grid are not taken apart.
        let Some(rect) = rect.filter(|r| !grid.extent().contains(r.min) || !grid.extent().contains(r.max)) else {
            continue;
        };
        for c in rect.corners() {
            *far = far.max((c[0] - centre[0]).hypot(c[1] - centre[1]));
        }
    }
    let (mut force, mut radius, mut held) = (0.0, 0.0_f64, None::<Rect>);
    let mut furthest = 0.0_f64;
    for k in (0..LEVELS).rev() {
        if let Some(rect) = rects[k] {
            let all = held.map_or(rect, |h| h.union(&rect));
            held = Some(all);
            furthest = furthest.max(about_centre[k]);
            let [w, h] = all.size();
            // A hair more for the rounding of the levels.
            radius = furthest.min(0.5 * w.hypot(h)) * (1.0 + 1e-12);
        }
        force += 2.0 * radius * highest / LEVELS as f64;
        with(highest * k as f64 / LEVELS as f64, force * (1.0 + 1e-12));
    }
}

/// Share of the depth by which another depth may differ: what a sampled supremum misses is magnified by the quotient.
const FURTHEST: f64 = 0.25;

/// (depth'/depth)^(1 + 1/k), where a homogeneous gap allows it; without one, 1 for the same depth.
fn stronger(problem: &BracketProblem, by: f64) -> Option<f64> {
    if by == 0.0 {
        return Some(1.0);
    }
    let near = by.abs() <= FURTHEST * problem.depth;
    problem.degree.filter(|_| near).map(|k| (1.0 + by / problem.depth).powf(1.0 + 1.0 / k))
}

/// Sum by rows, so that its rounding grows with the side of the grid and not with its cells.
fn total(grid: &Grid, values: impl Fn(usize) -> f64) -> f64 {
    let nx = grid.shape[0];
    (0..grid.shape[1]).map(|j| (0..nx).map(|i| values(j * nx + i)).sum::<f64>()).sum::<f64>() * grid.cell_area()
}

/// Relative rounding of a total and of the few operations after it.
fn rounding(grid: &Grid) -> f64 {
    (grid.shape[0] + grid.shape[1] + 64) as f64 * f64::EPSILON
}

/// The least force that the pressure `q`, repaired, proves to be enough.
pub(super) fn upper(problem: &BracketProblem, q: &[f64], found: &Violation, exterior: &Exterior) -> Repaired {
    let (grid, uncovered) = (&problem.grid, &exterior.uncovered);
    let nx = grid.shape[0];
    let base = total(grid, |k| q[k]);
    // Beyond the grid u >= f is known, and no more.
    let floor = if exterior.covered { 1.0 } else { f64::NEG_INFINITY };
    let shortest = found.short.iter().copied().chain(uncovered.iter().map(|s| s.short)).fold(floor, f64::max);
    let cell = |k: usize| grid.cell(k % nx, k / nx);
    let worst =
        (0..grid.len()).map(|k| (found.over[k], k)).fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a });
    let worst_spill = uncovered.iter().max_by(|a, b| a.over.total_cmp(&b.over));
    let at = match worst_spill {
        Some(spill) if spill.over > worst.0 => spill.rect.centre(),
        _ => cell(worst.1).centre(),
    };
    let mut best = Repaired {
        force: f64::INFINITY,
        theorem: Theorem::Scaling,
        factor: 1.0,
        kept: None,
        left: 0.0,
        discs: 0.0,
        level: 0.0,
        at,
    };
    if shortest == f64::NEG_INFINITY {
        // No point has f > 0.
        return Repaired { force: 0.0, factor: 0.0, ..best };
    }
    let up = 1.0 + rounding(grid);
    if base > 0.0 && shortest.is_finite() {
        let factor = shortest.max(0.0) * (1.0 + 8.0 * f64::EPSILON);
        best = Repaired { force: (factor * base * up).next_up(), factor, ..best };
    }
    let furthest = if base > 0.0 && shortest.is_finite() { (shortest - 1.0).max(0.0) } else { 0.0 };
    for step in 0..MIXTURES {
        let more = furthest * step as f64 / MIXTURES as f64;
        // What is left of f - lambda u after scaling: at most (f - u) - (lambda - 1) u.
        let left = (0..grid.len()).map(|k| (found.over[k] - more * found.least[k].max(0.0), k));
        let beyond = uncovered.iter().map(|s| (s.over - more * s.least, s.rect));
        let highest = left.clone().map(|v| v.0).chain(beyond.clone().map(|v| v.0)).fold(0.0, f64::max);
        stacks(grid, left, beyond, |level, discs| {
            // S (lambda q + discs) >= f - level: enough for the depth less the level.
            let Some(weaker) = stronger(problem, -level) else { return };
            let force = (((1.0 + more) * base + discs) / weaker * up).next_up();
            if force < best.force {
                let theorem = if level > 0.0 { Theorem::OtherDepth } else { Theorem::Discs };
                best = Repaired { force, theorem, factor: 1.0 + more, left: highest, discs, level, kept: None, at };
            }
        });
        // More scaling alone would cost what the discs do.
        let next = furthest * (step + 1) as f64 / MIXTURES as f64;
        if furthest == 0.0 || (1.0 + next) * base >= best.force {
            break;
        }
    }
    best
}

/// The largest force that the pressure `q`, repaired, proves to be carried.
pub(super) fn lower(problem: &BracketProblem, q: &[f64], found: &Violation) -> Repaired {
    let grid = &problem.grid;
    let nx = grid.shape[0];
    let cell = |k: usize| grid.cell(k % nx, k / nx);
    let mut loaded: Vec<usize> = (0..grid.len()).filter(|&k| q[k] > 0.0).collect();
    let mut best = Repaired {
        force: 0.0,
        theorem: Theorem::Scaling,
        factor: 0.0,
        kept: None,
        left: 0.0,
        discs: 0.0,
        level: 0.0,
        at: [0.0; 2],
    };
    let Some(&worst) = loaded.iter().max_by(|&&a, &&b| found.under[a].total_cmp(&found.under[b])) else { return best };
    best.at = cell(worst).centre();
    let down = 1.0 - rounding(grid);
    let area = grid.cell_area();

    // Scaling: for each lambda the cells with u/f <= lambda are kept.
    let mut by_long: Vec<(f64, f64)> =
        loaded.iter().map(|&k| (found.long[k], q[k])).filter(|(l, _)| *l > 0.0 && l.is_finite()).collect();
    by_long.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut chosen) = (0.0, None);
    for (lambda, q) in by_long {
        sum += q;
        let force = sum / lambda * area;
        if force > best.force {
            best.force = force;
            chosen = Some(lambda);
        }
    }
    if let Some(lambda) = chosen {
        let kept: Vec<bool> = (0..grid.len()).map(|k| q[k] > 0.0 && found.long[k] <= lambda).collect();
        let force = total(grid, |k| if kept[k] { q[k] } else { 0.0 }) / lambda * down;
        best = Repaired { force: force.next_down().max(0.0), factor: 1.0 / lambda, kept: Some(kept), ..best };
    }

    // Discs: the worst cells dropped up to a share of the load, the rest repaired.
    // Only these need an order.
    let hopeless = loaded.iter().filter(|&&k| found.under[k] == f64::INFINITY).count();
    let front = (hopeless + loaded.len() / 10 + 16).min(loaded.len());
    if front < loaded.len() {
        loaded.select_nth_unstable_by(front, |&a, &b| found.under[b].total_cmp(&found.under[a]));
    }
    loaded[..front].sort_unstable_by(|&a, &b| found.under[b].total_cmp(&found.under[a]));
    let all: f64 = loaded.iter().map(|&k| q[k]).sum();
    let mut dropped = 0;
    let mut gone = 0.0;
    let mut share = 0.0;
    loop {
        while dropped < front && (found.under[loaded[dropped]] == f64::INFINITY || gone < share * all) {
            gone += q[loaded[dropped]];
            dropped += 1;
        }
        let rest = &loaded[dropped..];
        if rest.is_empty() {
            break;
        }
        let left = rest.iter().map(|&k| (found.under[k], k));
        let highest = left.clone().map(|v| v.0).fold(0.0, f64::max);
        let mut kept = vec![false; grid.len()];
        rest.iter().for_each(|&k| kept[k] = true);
        let carried = total(grid, |k| if kept[k] { q[k] } else { 0.0 }) * down;
        let mut chosen: Option<(f64, f64, f64)> = None;
        stacks(grid, left, std::iter::empty(), |level, discs| {
            // S q <= f + level + what the discs displace: no more than the force at the depth plus the level, and theirs.
            let Some(greater) = stronger(problem, level) else { return };
            let force = ((carried - discs * (1.0 + rounding(grid))) / greater).next_down();
            if force > chosen.map_or(best.force, |(force, ..)| force) {
                chosen = Some((force, discs, level));
            }
        });
        if let Some((force, discs, level)) = chosen {
            let theorem = if level > 0.0 { Theorem::OtherDepth } else { Theorem::Discs };
            let at = best.at;
            best = Repaired { force, theorem, factor: 1.0, kept: Some(kept), left: highest, discs, level, at };
        }
        share = if share == 0.0 { 1e-4 } else { share * 2.0 };
        if dropped == front || share > 0.5 || (1.0 - share) * all * area <= best.force {
            break;
        }
    }
    best
}
