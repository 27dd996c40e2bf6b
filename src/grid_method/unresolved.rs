//! What the cells of one grid leave open, whatever other grids say: one step from grid to grid may be small by luck.
//!
//! Measured on 70 paraboloids of aspects to 7 and powers of exponents 1.3 to 6.3, at any turn and place, on 40 to 90 cells, both
//! kernels: the stiffness of the true contact lies within 0.25 of rho^1.5, and its area within 0.06 of it.

use std::f64::consts::PI;

use crate::discrete::Discrete;
use crate::grid::Grid;

/// Shares of rho^1.5: of two forces that may agree by chance; of stiffnesses, twice what is seen; and of areas, whose edges lie between cells.
const OF_RIM: f64 = 0.4;
const OF_END: f64 = 0.6;
const OF_AREA: f64 = 0.2;

/// Relative error of a force that rests on where the boundary lies between cells.
pub(crate) fn boundary(grid: &Grid, pressure: &[f64]) -> f64 {
    OF_RIM * rim(grid, pressure)
}

/// rho^1.5: rho is the share of the pressed cells that have a free neighbour; that of a contact without cells is all.
fn rim(grid: &Grid, pressure: &[f64]) -> f64 {
    let [nx, ny] = grid.shape;
    let pressed = |k: usize| pressure[k] > 0.0;
    let on_rim = |k: &usize| {
        let (i, j) = (k % nx, k / nx);
        let inner = i > 0 && i + 1 < nx && j > 0 && j + 1 < ny;
        !(inner && pressed(k - 1) && pressed(k + 1) && pressed(k - nx) && pressed(k + nx))
    };
    let all = (0..pressure.len()).filter(|&k| pressed(k));
    let (count, rim) = all.fold((0_usize, 0_usize), |(n, r), k| (n + 1, r + usize::from(on_rim(&k))));
    if count == 0 { 1.0 } else { (rim as f64 / count as f64).powf(1.5) }
}

/// Area that one side of a contact may be off by where it runs along the cells, in cells of its length: half a cell, and as much across.
const OF_RUN: f64 = 2.0;

/// How much of a free cell beside a pressed one may be contact, over the share of the deepest overlap that the overlap falls by from the
/// one to the other: 0.4 is seen on blunt cones and worn pyramids whose flanks are 1/4 to 20 cells wide.
const OF_FALL: f64 = 0.8;

/// Where pressed cells lie beside free ones.
struct Rim {
    /// Sides that are shared by a pressed and a free cell: the most of them in one straight line.
    longest: usize,
    /// Sum of what the overlap falls by across each, in shares of the deepest, no more than all of it.
    falls: f64,
}

impl Rim {
    fn of(problem: &Discrete, pressure: &[f64]) -> Self {
        let Discrete { grid, overlap, .. } = problem;
        let (shape, deepest) = (grid.shape, problem.deepest());
        let mut found = Self { longest: 0, falls: 0.0 };
        for along in [0, 1] {
            let at = |i: usize, j: usize| if along == 0 { j * shape[0] + i } else { i * shape[0] + j };
            for j in 0..shape[1 - along].saturating_sub(1) {
                // Cells of row j that are pressed where those of the next are free, or the other way round.
                let (mut run, mut before) = (0, None);
                for i in 0..shape[along] {
                    let [low, high] = [at(i, j), at(i, j + 1)];
                    let side = match [low, high].map(|k| pressure[k] > 0.0) {
                        [true, false] => Some([low, high]),
                        [false, true] => Some([high, low]),
                        _ => None,
                    };
                    run = match side {
                        None => 0,
                        Some([inner, _]) if before == Some(inner == low) => run + 1,
                        Some(_) => 1,
                    };
                    before = side.map(|[inner, _]| inner == low);
                    found.longest = found.longest.max(run);
                    if let Some([inner, outer]) = side {
                        found.falls += ((overlap[inner] - overlap[outer]) / deepest).clamp(0.0, 1.0);
                    }
                }
            }
        }
        found
    }
}

/// Relative error of an area that the cells leave open.
pub(crate) fn area(problem: &Discrete, pressure: &[f64]) -> f64 {
    by_ends(problem, pressure, OF_AREA)
}

/// The same of a stiffness, and of all that rests on which cells are in contact.
pub(crate) fn end(problem: &Discrete, pressure: &[f64]) -> f64 {
    by_ends(problem, pressure, OF_END)
}

/// A share of [`rim`] for a curved boundary; what a straight one along the cells is off by as a whole, on top of it where a line contact has
/// straight sides and curved ends; and how steeply the overlap ends between cells.
fn by_ends(problem: &Discrete, pressure: &[f64], share: f64) -> f64 {
    let count = pressure.iter().filter(|p| **p > 0.0).count().max(1) as f64;
    let Rim { longest, falls } = Rim::of(problem, pressure);
    let straight = OF_RUN * longest as f64;
    // In a row of cells beside a circle of radius r cells there are 2 sqrt(2 r), which the curved boundary has.
    let round = OF_RUN * 2.0 * (2.0 * (count / PI).sqrt()).sqrt();
    let curved = share * rim(&problem.grid, pressure) * count;
    (straight.max(curved).max(curved + straight - round) + OF_FALL * falls) / count
}

/// Growth of the drop from one cell to two where the pressure is smooth about its peak: 3 or 4 for a paraboloid of pressure, 2.4 to
/// 2.8 where it falls as r^1.5.
const SMOOTH: f64 = 2.9;

/// The same where the pressure has a cusp, p0 - p ~ r^s with s below 0.3, in the middle of a cell or on a corner of it: 1.72 and 1.6 for s = 0.
const CUSP: [f64; 2] = [1.9, 1.72];

/// Least drop to a cell beside the peak over the largest below which the peak is on a side or a corner.
const EVEN: f64 = 0.25;

/// Error of a peak over the drop to the cells beside it: smooth, not, and at a cusp, where it would be 1/s.
const OF_DROP: [f64; 3] = [0.5, 2.5, 10.0];

/// Relative error of the largest pressure of a grid, from how much the pressure varies from cell to cell about it.
pub(crate) fn peak(grid: &Grid, pressure: &[f64], strongest: usize) -> f64 {
    let [nx, ny] = grid.shape.map(|n| n as i64);
    let (i, j) = (strongest as i64 % nx, strongest as i64 / nx);
    let highest = pressure[strongest];
    let drops = |far: i64| {
        let at = |(di, dj): (i64, i64)| {
            let (i, j) = (i + far * di, j + far * dj);
            let inside = (0..nx).contains(&i) && (0..ny).contains(&j);
            (if inside { highest - pressure[(j * nx + i) as usize] } else { highest }) / highest
        };
        [(1, 0), (-1, 0), (0, 1), (0, -1)].map(at)
    };
    let most = |drops: [f64; 4]| drops.into_iter().fold(0.0, f64::max);
    let beside = drops(1);
    let [near, far] = [beside, drops(2)].map(most);
    let on_side = beside.iter().any(|drop| *drop < EVEN * near);
    let kind = if far > SMOOTH * near {
        0
    } else if far > CUSP[usize::from(on_side)] * near {
        1
    } else {
        2
    };
    OF_DROP[kind] * near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_cells_leave_less_open() {
        let left = |n: usize, power: f64| {
            let grid = Grid { origin: [-1.0; 2], spacing: [2.0 / n as f64; 2], shape: [n, n] };
            let p: Vec<f64> = grid.centres().map(|[x, y]| (1.0 - x.hypot(y).powf(power)).max(0.0)).collect();
            let strongest = (0..p.len()).max_by(|&a, &b| p[a].total_cmp(&p[b])).unwrap();
            // A peak of 1 at the middle, met by a cell or by a corner of four.
            (OF_END * rim(&grid, &p), peak(&grid, &p, strongest), (1.0 / p[strongest] - 1.0).abs())
        };
        for power in [0.5, 1.0, 2.0] {
            for n in [20, 21, 40, 41, 80] {
                let (rim, drop, off) = left(n, power);
                assert!(off <= drop, "{n} cells, r^{power}: {off} {drop}");
                // A cell stays in the middle, or a corner.
                let (finer, lower, _) = left(2 * n + n % 2, power);
                assert!(finer < 0.5 * rim && lower < drop);
            }
        }
    }
}
