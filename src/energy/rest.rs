//! Norms of what expansions leave out: polynomials of higher degree, and the cells far away.

use super::basis::NODES;

/// Bound of a polynomial in the cell.
pub(super) fn supremum<const N: usize>(c: &[[f64; N]; N]) -> f64 {
    c.iter().flatten().map(|c| c.abs()).sum::<f64>() * MARGIN
}

/// What the coefficients from degree N on and rounding may add to norms that are sums over the ones before.
const MARGIN: f64 = 1.01;

/// Norms over the cell of the gradient, enlarged by twice the value over half the shorter side (what a fade over half a cell can
/// add), and of the value.
pub(super) fn norms<const N: usize>(c: &[[f64; N]; N], h: [f64; 2]) -> [f64; 2] {
    let (mut value, mut slopes) = (0.0, [0.0; 2]);
    // P_a' has the coefficients 2k + 1 of P_k for k = a - 1, a - 3, ...
    let slope = |line: [f64; N]| {
        (0..N).map(|k| (2 * k + 1) as f64 * line.iter().skip(k + 1).step_by(2).sum::<f64>().powi(2)).sum::<f64>()
    };
    for (b, row) in c.iter().enumerate() {
        let size = 1.0 / (2 * b + 1) as f64;
        value += size * row.iter().enumerate().map(|(a, c)| c * c / (2 * a + 1) as f64).sum::<f64>();
        slopes[0] += 4.0 * size * slope(*row) / (h[0] * h[0]);
        slopes[1] += 4.0 * size * slope(std::array::from_fn(|k| c[k][b])) / (h[1] * h[1]);
    }
    let area = h[0] * h[1];
    let value = (area * value).sqrt();
    let fade = 2.0 / h[0].min(h[1]);
    [((area * (slopes[0] + slopes[1])).sqrt() + fade * value) * MARGIN, value * MARGIN]
}

/// Sums over all cells further away than `far`, in longer sides, of bounds of |grad (L_j - I L_j)| (enlarged as in [`norms`]) and |L_j - I L_j|,
/// times their offset in cells.
///
/// About the centre 1/r differs from its Taylor polynomial T of degree 6 by |x|^7/d^8 at most and its gradient from that of T by
/// 7 |x|^6/d^8, d the least distance of the source from the points between (all n-th derivatives of 1/r are at most n!/r^(n+1)). T is
/// its own interpolant but for the parts of P_5 and P_6, less than 2^-6/d^6 (slopes: 1/(2 d^6)); a remainder counts at the nodes, too.
pub(super) fn beyond(far: f64, h: [f64; 2]) -> [f64; 2] {
    // Suprema over the cell of what a mean of 1, k cells away, does to the interpolant, and to its slope.
    const NODAL: [f64; 4] = [1.126, 0.510, 0.0905, 0.0096];
    const SLOPES: [f64; 4] = [1.360, 1.358, 0.218, 0.0237];
    let shortest = h[0].min(h[1]);
    let by_one = |distance: f64| {
        let x = h[0].hypot(h[1]) / 2.0;
        let d = distance - x;
        let mut value = x.powi(7) / d.powi(8) + 2f64.powi(-6) / d.powi(6);
        let mut slope = 7.0 * x.powi(6) / d.powi(8) + 0.5 / d.powi(6) / shortest;
        for b in 0..=NODES {
            for a in 0..=NODES {
                let x = ((a as f64 + 0.5) * h[0]).hypot((b as f64 + 0.5) * h[1]);
                let images = if a == 0 { 1.0 } else { 2.0 } * if b == 0 { 1.0 } else { 2.0 };
                let rest = images * x.powi(7) / (distance - x).powi(8);
                value += rest * NODAL[a] * NODAL[b];
                slope += rest * (SLOPES[a] * NODAL[b]).hypot(NODAL[a] * SLOPES[b]) / shortest;
            }
        }
        [slope + 2.0 / shortest * value, value]
    };
    // Rings of width 1 around the square of half side far + 1/2 hold an area below 8 (R + 2), each point of them further away than R.
    let mut sum = [0.0; 2];
    let mut last = [0.0; 2];
    for ring in 0..64 {
        let r = far + f64::from(ring);
        last = by_one(r).map(|e| std::f64::consts::FRAC_1_PI * 8.0 * (r + 2.0) * (r + 2.0) / shortest * e);
        (0..2).for_each(|k| sum[k] += last[k]);
    }
    // Of the sixth power at least: the rest is less than a fifth of R times the last.
    [0, 1].map(|k| sum[k] + 20.0 * last[k])
}
