//! The field of a formula: values at centres, which solve no grid, and how each fits the displacement of its neighbours.

use super::bounds::{loaded, violations};
use super::one_cell::of_cell;
use super::summation::{Receiver, Summation};
use crate::gap::{AnyGap, Gap};
use crate::grid::Pressure;
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

/// Largest share by which a pressure differs from what its residual and those of its four neighbours say, three cells and
/// more from the edge of the contact and from kinks of the gap, where the pressure is no smoother than a logarithm; and where.
pub(super) fn unexplained(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, pressure: &Pressure) -> (f64, [f64; 2]) {
    let (grid, [nx, ny]) = (&pressure.grid, pressure.grid.shape);
    let q: Vec<f64> = pressure.values.iter().map(|p| p / modulus.e_star()).collect();
    let wanted: Vec<bool> = q.iter().map(|&q| q > 0.0).collect();
    let u = Summation::new(grid, &q).in_cells(Receiver::Point([0.5; 2]), &wanted);
    let left = |k: usize| depth - gap.gap(grid.centre_of(k)[0], grid.centre_of(k)[1]) - u[k];
    let unit = |i: f64, j: f64| of_cell(grid.spacing, [i * grid.spacing[0], j * grid.spacing[1]]);
    let response = unit(0.0, 0.0) - 0.5 * (unit(1.0, 0.0) + unit(0.0, 1.0));
    let (mut worst, mut at) = (0.0, [0.0; 2]);
    for j in 3..ny.saturating_sub(3) {
        for i in 3..nx.saturating_sub(3) {
            if !(j - 3..=j + 3).all(|j| (i - 3..=i + 3).all(|i| q[j * nx + i] > 0.0)) {
                continue;
            }
            let k = j * nx + i;
            let around = 0.25 * (left(k - 1) + left(k + 1) + left(k - nx) + left(k + nx));
            let off = ((left(k) - around) / response / q[k]).abs();
            if !(off <= worst) && !kinked(gap, grid.centre(i, j), grid.spacing) {
                (worst, at) = (off, grid.centre(i, j));
            }
        }
    }
    (worst, at)
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
