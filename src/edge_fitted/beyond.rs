//! What is shown of the residual where there is no contact, and which continuation of it counts there.
//!
//! A pressure p on the cells of contact A, r = f - S p; m on A too, v = 1 - S m. chi is 1 on A and fades over half of a cell, chi' is 1 on A
//! and on all cells around A, where chi ends, and fades over more of them. On the material w = max(chi r, chi' r) is r under p and no less
//! anywhere, if r <= 0 where chi' < 1. There chi = 0, w = 0, and
//!
//! ```text
//! (1 - chi') v <= tau |r| where chi' < 1   ==>   (1 - chi') v <= tau (w - r) everywhere on the material,
//! ```
//!
//! which is what [`super::force`] takes. Both signs are shown on subcells: values at nodes, in Bernstein's form, and what their
//! interpolation leaves out at most. Where a sign cannot be shown and need not be, both continuations are counted.

use std::sync::OnceLock;

use super::gauss::{LEBESGUE, NODES, legendre, monic_size};
use super::interpolation::Errors;

/// Bounds of a function by its values at the nodes of a subcell, the index of t slower, and what interpolation leaves out.
pub(crate) fn range(values: &[f64], [m, n]: [usize; 2], left_out: f64) -> [f64; 2] {
    let (Some(bs), Some(bt)) = (bernstein(m), bernstein(n)) else { return [f64::NEG_INFINITY, f64::INFINITY] };
    let mut lines = [0.0; 25];
    for (line, row) in lines.chunks_exact_mut(m).zip(values.chunks_exact(m)) {
        for (out, weights) in line.iter_mut().zip(bs.chunks_exact(m)) {
            *out = weights.iter().zip(row).map(|(w, v)| w * v).sum();
        }
    }
    let (mut low, mut high, mut size) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for weights in bt.chunks_exact(n) {
        for i in 0..m {
            let c: f64 = weights.iter().enumerate().map(|(j, w)| w * lines[j * m + i]).sum();
            (low, high, size) = (low.min(c), high.max(c), size.max(c.abs()));
        }
    }
    let off = left_out + 1e-13 * size;
    [low - off, high + off]
}

/// What interpolation of the displacement leaves out of a subcell at most, by the numbers of nodes less two: where no logarithm is kept aside.
///
/// The monic polynomial of the Gauss nodes is at most sqrt(2 m + 1) of its mean square; what one direction leaves out is interpolated along
/// the other one. By direction, and what smaller subcells do not change.
pub(crate) fn largest(errors: &Errors, choice: [usize; 2]) -> [f64; 3] {
    let [i, j] = choice;
    let own = |k: usize, i: usize| monic_size(i + NODES[0]) * errors.value[k][i];
    [own(0, i), LEBESGUE[i] * own(1, j), LEBESGUE[i] * LEBESGUE[j] * errors.fixed[1]]
}

/// The Bernstein coefficients on [-1, 1] of the interpolant of each node: row by coefficient.
fn bernstein(m: usize) -> Option<&'static [f64]> {
    static ALL: OnceLock<Vec<Option<Vec<f64>>>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        (0..=NODES[1])
            .map(|m| {
                let x = &legendre(m.max(1)).0;
                let degree = m.max(1) - 1;
                let binomial = |i: usize| (0..i).map(|k| (degree - k) as f64 / (k + 1) as f64).product::<f64>();
                let value = |k: usize, i: usize| {
                    let t = 0.5 * (1.0 + x[k]);
                    binomial(i) * t.powi(i as i32) * (1.0 - t).powi((degree - i) as i32)
                };
                let values = nalgebra::DMatrix::from_fn(degree + 1, degree + 1, value);
                values.try_inverse().map(|inverse| inverse.transpose().iter().copied().collect())
            })
            .collect()
    });
    all[m].as_deref()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_fitted::gauss::lagrange;

    #[test]
    fn a_range_holds_all_values() {
        for (m, n) in [(2, 2), (3, 5), (5, 4), (4, 2)] {
            let values: Vec<f64> = (0..m * n).map(|k| ((k * k) as f64 * 1.7).sin()).collect();
            let [low, high] = range(&values, [m, n], 0.0);
            let (x, y) = (&legendre(m).0, &legendre(n).0);
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..=40 {
                for j in 0..=40 {
                    let (bs, bt) = (lagrange(x, -1.0 + 0.05 * f64::from(i)), lagrange(y, -1.0 + 0.05 * f64::from(j)));
                    let value: f64 =
                        (0..n).map(|l| bt[l] * (0..m).map(|k| bs[k] * values[l * m + k]).sum::<f64>()).sum();
                    (least, most) = (least.min(value), most.max(value));
                }
            }
            assert!(low <= least && most <= high && high - low < 8.0 * (most - least), "{low} {least} {most} {high}");
        }
    }

    #[test]
    fn lebesgue_constants() {
        for i in 0..LEBESGUE.len() {
            let x = &legendre(i + NODES[0]).0;
            let most = (0..=2000)
                .map(|k| lagrange(x, -1.0 + 1e-3 * f64::from(k)).iter().map(|l| l.abs()).sum::<f64>())
                .fold(0.0, f64::max);
            assert!(most <= LEBESGUE[i] && LEBESGUE[i] < 1.01 * most);
        }
    }
}
