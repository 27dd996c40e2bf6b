//! What the energy of a field cannot prove: the theorem of [`crate::energy`] by direct summation, with none of its code.
//!
//! U_low is summed over the cells. Of gamma, |w| |grad w|/4 with w = f - u under pressure, points in the cells see a part: slopes
//! between them are no steeper than they are on the way, and the strip beyond the contact is left out. A bracket narrower than what
//! they see is not one that the field proves.

use super::cells::Cells;
use super::summation::{Receiver, Summation};
use crate::gap::{AnyGap, Degree, Gap};
use crate::grid::{Kernel, Pressure};
use crate::problem::EffectiveModulus;

/// Points along a side of a cell.
const POINTS: usize = 3;

/// Share of what the points see that has to be in a bracket: sums over points are not integrals.
const SEEN: f64 = 0.9;

/// Relative error of an energy by such sums.
const OF_SUMS: f64 = 1e-6;

/// The force that a bracket may have at most as its lower end, and at least as its upper one, where the gap is homogeneous.
pub(super) fn ends(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, field: &Pressure) -> Option<[f64; 2]> {
    let law = gap.known().law.filter(|law| law.degree != Degree::Flat)?;
    let lower = Cells::of(gap, modulus, depth, field, Kernel::Galerkin).energy();
    let seen = seen(gap, modulus, depth, field);
    let per_energy = modulus.e_star() * (2.0 + law.degree.inverse()) / (depth - law.lowest);
    let ends = [lower * (1.0 + OF_SUMS), lower * (1.0 - OF_SUMS) + SEEN * seen].map(|u| u * per_energy);
    ends.iter().all(|end| end.is_finite()).then_some(ends)
}

/// What points in the cells under pressure see of gamma, E* = 1.
fn seen(gap: &AnyGap, modulus: EffectiveModulus, depth: f64, field: &Pressure) -> f64 {
    let grid = &field.grid;
    let [nx, ny] = grid.shape;
    let pressure: Vec<f64> = field.values.iter().map(|p| p / modulus.e_star()).collect();
    let pressed: Vec<bool> = pressure.iter().map(|p| *p > 0.0).collect();
    let summation = Summation::new(grid, &pressure);
    let place = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    // f - u at all points, x fastest; NaN where there is no pressure.
    let wide = nx * POINTS;
    let mut w = vec![f64::NAN; wide * ny * POINTS];
    for t in 0..POINTS {
        for s in 0..POINTS {
            let u = summation.in_cells(Receiver::Point([place(s), place(t)]), &pressed);
            for k in (0..u.len()).filter(|k| pressed[*k]) {
                let (i, j) = (k % nx, k / nx);
                let at = [
                    grid.origin[0] + (i as f64 + place(s)) * grid.spacing[0],
                    grid.origin[1] + (j as f64 + place(t)) * grid.spacing[1],
                ];
                w[(j * POINTS + t) * wide + i * POINTS + s] = depth - gap.gap(at[0], at[1]) - u[k];
            }
        }
    }
    let step = grid.spacing.map(|h| h / POINTS as f64);
    let (mut value, mut slope) = (0.0, 0.0);
    for (k, w0) in w.iter().enumerate().filter(|(_, w)| w.is_finite()) {
        value += w0 * w0;
        let right = if (k + 1) % wide == 0 { None } else { w.get(k + 1) };
        for (next, h) in [(right, step[0]), (w.get(k + wide), step[1])] {
            slope += next.filter(|w| w.is_finite()).map_or(0.0, |w1| ((w1 - w0) / h).powi(2));
        }
    }
    0.25 * step[0] * step[1] * (value * slope).sqrt()
}
