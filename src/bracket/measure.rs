//! Force from below by a pressure over the supremum of its displacement.
//!
//! For any m >= 0 and U no less than S m where m > 0, the integral of f m is at most P U: m/U is a point of the dual of the linear
//! programme. Fabrikant's pressure of a flat punch with the boundary a(theta),
//!
//!   m = (1 - r^2/a(theta)^2)^(-1/2)
//!
//! up to a factor (Fabrikant 1986; Barber & Billings 1990, equation 6), is one that nearly has a constant displacement. It is where
//! this begins, and not what the bound rests on: on a grid it is corrected, cell by cell and several times over, by what the
//! displacement there exceeds its mean by. The bound is that of the corrected pressure; his own, over its supremum alone, proves less.

use super::field::{Field, Surroundings};
use crate::approximate::fabrikant::Boundary;
use crate::gap::{AnyGap, Gap};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::problem::EffectiveModulus;

/// Cells along the longer side of the boundary.
const CELLS: usize = 48;

/// Points along a side of a cell for its share of the pressure; what they miss makes another pressure, not a wrong bound.
const POINTS: usize = 6;

/// Times the pressure is made less where it displaces much: by the displacement at the centres, and by its suprema.
const ROUNDS: [usize; 2] = [12, 3];

/// The bound by Fabrikant's pressure, corrected, within this boundary; 0 where it proves nothing. The mean overlap of a cell is that of
/// [`Gap::mean`].
pub(super) fn corrected_fabrikant(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, boundary: &Boundary) -> f64 {
    let Some(rect) = Rect::holding(boundary.polyline()) else { return 0.0 };
    let [w, h] = rect.size();
    let side = w.max(h) / CELLS as f64;
    if !(side > 0.0 && side.is_finite()) {
        return 0.0;
    }
    let shape = [w, h].map(|s| ((s / side).ceil() as usize).max(1));
    let half = shape.map(|n| 0.5 * n as f64 * side);
    let grid = Grid { spacing: [side; 2], ..Grid::over(&Rect::around(rect.centre(), half), shape) };
    let mut overlap = vec![0.0; grid.len()];
    let mut q = vec![0.0; grid.len()];
    for k in 0..grid.len() {
        let cell = grid.cell(k % shape[0], k / shape[0]);
        let share = share(boundary, &cell);
        if share > 0.0 {
            overlap[k] = depth - gap.mean(&cell);
            q[k] = if overlap[k] > 0.0 { share } else { 0.0 };
        }
    }
    // In units of the grid.
    let unit = Grid { origin: [0.0; 2], spacing: [1.0; 2], shape };
    let mut around = Surroundings::new(&unit, 4);
    let mut best = 0.0_f64;
    for round in 0..ROUNDS[0] + ROUNDS[1] {
        let field = Field::new(&mut around, &q);
        let highest: Vec<f64> = if round < ROUNDS[0] {
            (0..q.len()).map(|k| field.at_centre(k % shape[0], k / shape[0])).collect()
        } else {
            let highest = suprema(&around, &field, &q);
            let most = highest.iter().copied().fold(0.0, f64::max);
            if !(most > 0.0) {
                break;
            }
            let carried: f64 = q.iter().zip(&overlap).map(|(q, f)| q * f).sum();
            best = best.max(carried / most);
            highest
        };
        // Towards a constant displacement.
        let mean = q.iter().zip(&highest).map(|(q, u)| q * u).sum::<f64>() / q.iter().sum::<f64>();
        q.iter_mut().zip(&highest).filter(|(q, _)| **q > 0.0).for_each(|(q, u)| *q *= mean / u);
    }
    best * side * modulus.e_star() * (1.0 - 1e-9)
}

/// Mean of Fabrikant's pressure over a cell, roughly.
fn share(boundary: &Boundary, cell: &Rect) -> f64 {
    let ([w, h], [cx, cy]) = (cell.size(), boundary.centre);
    let place = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    let sum: f64 = (0..POINTS * POINTS)
        .map(|k| [cell.min[0] + w * place(k % POINTS) - cx, cell.min[1] + h * place(k / POINTS) - cy])
        .map(|[x, y]| {
            let ratio = x.hypot(y) / boundary.radius(y.atan2(x).rem_euclid(std::f64::consts::TAU));
            if ratio < 1.0 { 1.0 / (1.0 - ratio * ratio).sqrt() } else { 0.0 }
        })
        .sum();
    sum / (POINTS * POINTS) as f64
}

/// Upper bound of the displacement over every loaded cell, 0 elsewhere; close where it is greatest.
fn suprema(around: &Surroundings, field: &Field, q: &[f64]) -> Vec<f64> {
    let squares = &around.tables.squares[0];
    let nx = around.shape()[0];
    let high = |[u, s, t]: [f64; 3], half: f64, rest: f64| u + (s.abs() + t.abs()) * half + rest + field.rounding(u);
    let mut highest = vec![0.0; q.len()];
    let mut order: Vec<usize> = (0..q.len()).filter(|&k| q[k] > 0.0).collect();
    for &k in &order {
        let cell = field.cell(k % nx, k / nx);
        let rest = cell.left_out() + cell.bend(0.25);
        highest[k] = cell.quarters().into_iter().map(|plane| high(plane, 0.25, rest)).fold(0.0, f64::max);
    }
    order.sort_unstable_by(|&a, &b| highest[b].total_cmp(&highest[a]));
    let (mut room, mut most) = (Vec::new(), 0.0_f64);
    for k in order {
        if highest[k] <= most {
            break;
        }
        let cell = field.cell(k % nx, k / nx);
        let jumps = cell.jumps();
        let planes = cell.squares(&jumps, squares, &mut room);
        let closely = planes.iter().map(|&[u, s, t, rest]| high([u, s, t], squares.half, rest)).fold(0.0, f64::max);
        highest[k] = highest[k].min(closely);
        most = most.max(highest[k]);
    }
    highest
}
