//! Displacement and its slopes at any point by unit pressure on one rectangle, E* = 1.
//!
//! Near the rectangle Love's repaired form (1929), further out tensor Gauss rules on 1/r; every value is good to
//! [`RELATIVE_ERROR`] of itself for cells that are not more slender than [`MOST_SLENDER`].

use std::f64::consts::FRAC_1_PI;

/// Relative error of the displacement that is allowed for in every bound; ten times the largest one seen in the tests.
pub(super) const RELATIVE_ERROR: f64 = 1e-11;

/// Aspect ratio of a cell up to which that holds.
pub(super) const MOST_SLENDER: f64 = 16.0;

/// Abscissae and weights of the Gauss rules with 2, 3, 4 points on [-1/2, 1/2].
const GAUSS: [&[(f64, f64)]; 3] = [
    &[(-0.288_675_134_594_812_9, 0.5), (0.288_675_134_594_812_9, 0.5)],
    &[(-0.387_298_334_620_741_7, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.387_298_334_620_741_7, 5.0 / 18.0)],
    &[
        (-0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
        (-0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
        (0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
        (0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
    ],
];

/// Displacement (a length) and its two slopes at the offset `(x, y)` from the centre of a rectangle of sides `h`.
pub(crate) fn displacement(h: [f64; 2], x: f64, y: f64) -> [f64; 3] {
    let distance = (x * x + y * y).sqrt() / h[0].max(h[1]);
    match distance {
        d if d < 20.0 => love(h, x, y),
        d if d < 60.0 => gauss(GAUSS[2], h, x, y),
        d if d < 600.0 => gauss(GAUSS[1], h, x, y),
        _ => gauss(GAUSS[0], h, x, y),
    }
}

/// Love (1929): the second difference of F(u, v) = u asinh(v/|u|) + v asinh(u/|v|), whose slope along u is asinh(v/|u|).
///
/// The asinh at two ends differ by one logarithm.
fn love(h: [f64; 2], x: f64, y: f64) -> [f64; 3] {
    let (a, b) = (0.5 * h[0], 0.5 * h[1]);
    let (u, v) = ([x + a, x - a], [y + b, y - b]);
    let r = u.map(|u| v.map(|v| (u * u + v * v).sqrt()));
    let along = [0, 1].map(|k| between(u[k], v, r[k]));
    let across = [0, 1].map(|k| between(v[k], u, [r[0][k], r[1][k]]));
    let sum = u[0] * along[0] - u[1] * along[1] + v[0] * across[0] - v[1] * across[1];
    // On the very edge the slope is infinite and has no use.
    [sum, along[0] - along[1], across[0] - across[1]].map(|s| FRAC_1_PI * s)
}

/// asinh(v0/|u|) - asinh(v1/|u|) with r = sqrt(u^2 + v^2); 0 where u = 0: it only stands beside a factor u, or in a slope that
/// is infinite there.
fn between(u: f64, v: [f64; 2], r: [f64; 2]) -> f64 {
    if u == 0.0 {
        return 0.0;
    }
    // r + v, without cancellation.
    let sum = |k: usize| if v[k] >= 0.0 { r[k] + v[k] } else { u * u / (r[k] - v[k]) };
    (sum(0) / sum(1)).ln()
}

fn gauss(rule: &[(f64, f64)], h: [f64; 2], x: f64, y: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &(s, v) in rule {
        let dx = x - s * h[0];
        for &(t, w) in rule {
            let dy = y - t * h[1];
            let inverse = 1.0 / (dx * dx + dy * dy).sqrt();
            let weighted = v * w * inverse;
            let cubed = weighted * inverse * inverse;
            sum[0] += weighted;
            sum[1] -= dx * cubed;
            sum[2] -= dy * cubed;
        }
    }
    sum.map(|s| FRAC_1_PI * h[0] * h[1] * s)
}

/// Largest second derivative, in any direction and at any point of a cell, of the displacement by unit pressure on the
/// cell that lies `offset` cells away; at least two cells in one direction.
///
/// The second derivatives of 1/r are at most 2/r^3. Each loaded cell is cut into parts, and each part is put at its
/// point nearest to the cell that looks on.
pub(super) fn curvature(h: [f64; 2], offset: [usize; 2]) -> f64 {
    let parts = if offset[0].max(offset[1]) <= 16 { 4 } else { 1 };
    let part = 1.0 / parts as f64;
    let mut sum = 0.0;
    for k in 0..parts {
        let dx = (offset[0] as f64 - 1.0 + k as f64 * part).max(0.0) * h[0];
        for l in 0..parts {
            let dy = (offset[1] as f64 - 1.0 + l as f64 * part).max(0.0) * h[1];
            let r2 = dx * dx + dy * dy;
            sum += 1.0 / (r2 * r2.sqrt());
        }
    }
    2.0 * FRAC_1_PI * h[0] * h[1] * sum * part * part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gauss on 64 x 64 parts: good wherever the point is not on the rectangle.
    fn slow(h: [f64; 2], x: f64, y: f64) -> [f64; 3] {
        let (n, mut sum) = (64, [0.0; 3]);
        let part = [h[0] / n as f64, h[1] / n as f64];
        for i in 0..n {
            for j in 0..n {
                let x = x + h[0] * ((i as f64 + 0.5) / n as f64 - 0.5);
                let y = y + h[1] * ((j as f64 + 0.5) / n as f64 - 0.5);
                let value = gauss(GAUSS[2], part, x, y);
                (0..3).for_each(|k| sum[k] += value[k]);
            }
        }
        sum
    }

    #[test]
    fn agrees_with_slow_quadrature_across_all_forms() {
        for h in [[1.0, 1.0], [1.0, 0.25], [0.07, 1.0]] {
            for (x, y) in [
                (0.9, 0.2),
                (2.3, -1.7),
                (0.6, 8.0),
                (12.2, 3.4),
                (19.9, 0.1),
                (20.1, 0.3),
                (-35.0, 12.0),
                (59.0, 8.0),
                (61.0, 1.0),
                (300.0, -400.0),
                (601.0, 0.0),
                (3000.0, 10.0),
            ] {
                let (fast, slow) = (displacement(h, x, y), slow(h, x, y));
                assert!((fast[0] / slow[0] - 1.0).abs() < RELATIVE_ERROR / 10.0, "{h:?} {x} {y}: {fast:?} {slow:?}");
                for k in 1..3 {
                    let allowed = 1e-9 * slow[0] / x.hypot(y);
                    assert!((fast[k] - slow[k]).abs() < allowed, "{h:?} {x} {y}: {fast:?} {slow:?}");
                }
            }
        }
    }

    #[test]
    fn curvature_bounds_the_second_differences() {
        let h = [1.0, 0.6];
        for offset in [[2, 0], [0, 2], [2, 2], [3, 1], [17, 0], [5, 40]] {
            let bound = curvature(h, offset);
            for s in [-0.5, -0.2, 0.3, 0.45] {
                for t in [-0.45, 0.0, 0.5] {
                    let (x, y) = ((offset[0] as f64 + s) * h[0], (offset[1] as f64 + t) * h[1]);
                    let e = 1e-2;
                    let u = |x: f64, y: f64| displacement(h, x, y)[0];
                    let along_x = (u(x + e, y) - 2.0 * u(x, y) + u(x - e, y)) / (e * e);
                    let along_y = (u(x, y + e) - 2.0 * u(x, y) + u(x, y - e)) / (e * e);
                    assert!(along_x.abs() < bound && along_y.abs() < bound, "{offset:?}");
                }
            }
        }
    }
}
