//! The field of a formula: values at centres, which solve no grid, and how each fits the displacement of its neighbours.

use super::bounds::{loaded, violations};
use super::one_cell::of_cell;
use super::summation::{Receiver, Summation};
use crate::gap::{AnyGap, Gap};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;
use crate::problem::EffectiveModulus;

/// Bounds of the force by sampled violations of a field: P(d - e2) <= P(field) <= P(d + e1), with a flat disc around everything for
/// the difference.
pub(super) fn window(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, pressure: &Pressure) -> [f64; 2] {
    let carried = pressure.force();
    let sampled = [true, false].map(|above| violations(gap, modulus, depth, pressure, above));
    let [over, under] = sampled.each_ref().map(|s| s.violations.iter().map(|v| v.0).fold(0.0, f64::max));
    let reach = sampled.iter().flat_map(|s| s.violations.iter().map(|v| v.1)).chain(loaded(pressure));
    let [w, h] = Rect::holding(reach).map_or([0.0; 2], |r| r.size());
    let disc = modulus.e_star() * w.hypot(h);
    let rounding = 1e-6 * carried;
    [carried - disc * under - rounding, carried + disc * over + rounding]
}

/// Cells around one in which those at the edge of the contact count.
const AROUND: usize = 12;

/// Largest share by which a pressure differs from what its residual and those of its four neighbours say, three cells and
/// more from the edge of the contact and from kinks of the gap, where the pressure is no smoother than a logarithm; and where. The
/// value at the centre of a cell at the edge, where the pressure may be infinite, is no mean: such cells leave open what they do.
pub(super) fn unexplained(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, pressure: &Pressure) -> (f64, [f64; 2]) {
    let (grid, [nx, ny]) = (&pressure.grid, pressure.grid.shape);
    let q: Vec<f64> = pressure.values.iter().map(|p| p / modulus.e_star()).collect();
    let wanted: Vec<bool> = q.iter().map(|&q| q > 0.0).collect();
    let u = Summation::new(grid, &q).in_cells(Receiver::Point([0.5; 2]), &wanted);
    let left = |k: usize| depth - gap.gap(grid.centre_of(k)[0], grid.centre_of(k)[1]) - u[k];
    let table: Vec<f64> =
        (0..=AROUND).flat_map(|j| (0..=AROUND).map(move |i| [i, j])).map(|[i, j]| bend(grid, i, j).abs()).collect();
    let response = table[0];
    let at_edge = edge(&q, [nx, ny]);
    let open = |i: usize, j: usize| -> f64 {
        let rows = j.saturating_sub(AROUND)..(j + AROUND + 1).min(ny);
        let columns = i.saturating_sub(AROUND)..(i + AROUND + 1).min(nx);
        let of_row = |b: usize| -> f64 {
            let each = columns.clone().filter(|a| at_edge[b * nx + a]);
            each.map(|a| q[b * nx + a] * table[b.abs_diff(j) * (AROUND + 1) + a.abs_diff(i)]).sum()
        };
        rows.map(of_row).sum()
    };
    let (mut worst, mut at) = (0.0, [0.0; 2]);
    for j in 3..ny.saturating_sub(3) {
        for i in 3..nx.saturating_sub(3) {
            if !(j - 3..=j + 3).all(|j| (i - 3..=i + 3).all(|i| q[j * nx + i] > 0.0)) {
                continue;
            }
            let k = j * nx + i;
            let around = 0.25 * (left(k - 1) + left(k + 1) + left(k - nx) + left(k + nx));
            let off = (left(k) - around).abs();
            let off = if off.is_finite() { (off - open(i, j)).max(0.0) / response / q[k] } else { off };
            if !(off <= worst) && !kinked(gap, grid.centre(i, j), grid.spacing) {
                (worst, at) = (off, grid.centre(i, j));
            }
        }
    }
    (worst, at)
}

/// What unit pressure on a cell does at so many cells from it, less the mean of what it does around there.
fn bend(grid: &Grid, i: usize, j: usize) -> f64 {
    let at = |di: f64, dj: f64| {
        of_cell(grid.spacing, [(i as f64 + di) * grid.spacing[0], (j as f64 + dj) * grid.spacing[1]])
    };
    at(0.0, 0.0) - 0.25 * (at(1.0, 0.0) + at(-1.0, 0.0) + at(0.0, 1.0) + at(0.0, -1.0))
}

/// The cells under pressure beside one without, or at the end of the grid.
fn edge(q: &[f64], [nx, ny]: [usize; 2]) -> Vec<bool> {
    let inside = |k: usize| {
        let (i, j) = (k % nx, k / nx);
        let within = i > 0 && j > 0 && i + 1 < nx && j + 1 < ny;
        within && (j - 1..=j + 1).all(|j| (i - 1..=i + 1).all(|i| q[j * nx + i] > 0.0))
    };
    (0..q.len()).map(|k| q[k] > 0.0 && !inside(k)).collect()
}

/// Whether the gap has a kink within three cells of a point, along the axes: its second differences over quarters of a cell are then a quarter or
/// an eighth of those over cells, and a sixteenth where it is smooth.
fn kinked(gap: &AnyGap, [x, y]: [f64; 2], spacing: [f64; 2]) -> bool {
    (0..2).any(|axis| {
        let along = |n: i32| {
            let t = 0.25 * f64::from(n) * spacing[axis];
            if axis == 0 { gap.gap(x + t, y) } else { gap.gap(x, y + t) }
        };
        let values: Vec<f64> = (-12..=12).map(along).collect();
        let bend = |stride: usize| {
            let second = |k: usize| (values[k - stride] - 2.0 * values[k] + values[k + stride]).abs();
            (stride..values.len() - stride).map(second).fold(0.0, f64::max)
        };
        let size = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let (fine, coarse) = (bend(1), bend(4));
        coarse > 1e-9 * size && fine > 0.1 * coarse
    })
}
