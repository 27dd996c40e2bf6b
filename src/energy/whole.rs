//! The residual f - u in whole cells, several at a time: integrals of its square and of the square of its gradient.
//!
//! With r = sum of c_k P_k - sum of z_f Z_f both are quadratic forms in (c, z): the integral of r^2 has no mixed terms, and that of
//! |grad r|^2 has them within each class of parity.

use pulp::{Arch, Simd, WithSimd};

use super::basis::{CLASSES, DEGREES, POLYNOMIALS};
use super::expansion::Expansions;
use super::lane::{LANES, Lane, add, add_product, add_square, difference, sum};
use super::tables::Tables;
use super::touching::FIRSTS;

/// Coefficients of Taylor polynomials in cells side by side ([`super::basis::of_taylor`]): places 0, 1, 3, 9, ...
pub(super) type Overlaps = [Lane; POLYNOMIALS];

/// (integral of |grad r|^2, integral of r^2) in each cell, lengths in longer sides; r = overlap - u.
pub(super) fn integrals(tables: &Tables, u: &Expansions, overlap: &Overlaps) -> [Lane; 2] {
    Arch::new().dispatch(Forms { tables, u, overlap })
}

/// The quadratic forms of cells side by side.
struct Forms<'a> {
    tables: &'a Tables,
    u: &'a Expansions,
    overlap: &'a Overlaps,
}

impl WithSimd for Forms<'_> {
    type Output = [Lane; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Lane; 2] {
        let Self { tables, u, overlap } = self;
        let mut c = *overlap;
        for (c, u) in c.iter_mut().zip(&u.polynomial) {
            *c = difference(simd, c, u);
        }
        let z = &u.singular;
        let (mut values, mut slopes, mut along, mut across) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (c, [a, b]) in c.iter().zip(DEGREES) {
            add_square(simd, &mut values, 1.0 / ((2 * a + 1) * (2 * b + 1)) as f64, c);
        }
        let [hx, hy] = tables.h;
        // The slope of c_1 P_1 + c_3 P_3 is 2 (c_1 + c_3) P_0 + 10 c_3 P_2, that of c_2 P_2 + c_4 P_4 is 6 (c_2 + c_4) P_1 + 14 c_4 P_3.
        for class in 0..4 {
            let (x, y) = (if class & 1 == 0 { 3 } else { 2 }, if class & 2 == 0 { 3 } else { 2 });
            let at = |m: usize, n: usize| &c[CLASSES[class] + n * x + m];
            let degree = |odd: bool, m: usize| 2 * m + usize::from(odd);
            for n in 0..y {
                let weight = 4.0 / (2 * degree(class & 2 != 0, n) + 1) as f64;
                line(simd, &mut along, weight, class & 1 != 0, |m| at(m, n));
            }
            for m in 0..x {
                let weight = 4.0 / (2 * degree(class & 1 != 0, m) + 1) as f64;
                line(simd, &mut across, weight, class & 2 != 0, |n| at(m, n));
            }
            for f in FIRSTS[class]..FIRSTS[class + 1] {
                let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
                for (g, z) in z[FIRSTS[class]..FIRSTS[class + 1]].iter().enumerate() {
                    add(simd, &mut value, tables.values[f][g] / (hx * hy), z);
                    add(simd, &mut slope, tables.gradients[f][g], z);
                }
                for (k, c) in c[CLASSES[class]..CLASSES[class + 1]].iter().enumerate() {
                    add(simd, &mut slope, -2.0 * tables.mixed[f][k], c);
                }
                add_product(simd, &mut values, &z[f], &value);
                add_product(simd, &mut slopes, &z[f], &slope);
            }
        }
        add(simd, &mut slopes, hy / hx, &along);
        add(simd, &mut slopes, hx / hy, &across);
        [slopes, values.map(|v| hx * hy * v)]
    }
}

/// Adds weight/4 times the integral along a line of the square of the slope of a sum of polynomials of one parity.
#[inline(always)]
fn line<'a, S: Simd>(simd: S, to: &mut Lane, weight: f64, odd: bool, c: impl Fn(usize) -> &'a Lane) {
    if odd {
        add_square(simd, to, weight, &sum(simd, c(0), c(1)));
        add_square(simd, to, 5.0 * weight, c(1));
    } else {
        add_square(simd, to, 3.0 * weight, &sum(simd, c(1), c(2)));
        add_square(simd, to, 7.0 * weight, c(2));
    }
}

#[cfg(test)]
mod tests {
    use super::super::basis::of_taylor;
    use super::super::expansion::Workspace;
    use super::super::field::Field;
    use super::super::potential::Corners;
    use super::super::tables::graded;
    use super::*;
    use crate::grid::Grid;

    /// By sums over all cells, at the points of a fine rule.
    fn slow(grid: &Grid, p: &[f64], cell: [usize; 2], t: &[f64; 10]) -> [f64; 2] {
        let half = graded([8, 16]);
        let rule: Vec<(f64, f64)> = half.iter().map(|(s, w)| (-s, *w)).chain(half.iter().copied()).collect();
        let h = grid.spacing;
        let centre = grid.centre(cell[0], cell[1]);
        let mut sums = [0.0; 2];
        for (s, v) in &rule {
            for (r, w) in &rule {
                let (x, y) = (s * h[0], r * h[1]);
                let mut u = [0.0; 3];
                for (k, p) in p.iter().enumerate().filter(|(_, p)| **p != 0.0) {
                    let c = grid.centre_of(k);
                    let (dx, dy) = (centre[0] + x - c[0], centre[1] + y - c[1]);
                    let (a, b) = (0.5 * h[0], 0.5 * h[1]);
                    let one = Corners::new(&[dx - a, dx + a], &[dy - b, dy + b]).cell([0, 1], [0, 1]);
                    (0..3).for_each(|k| u[k] += p * one[k]);
                }
                let taylor =
                    super::super::overlap::Taylor { terms: *t, rest: [0.0; 2], most: [0.0; 2], bend: [0.0; 2] };
                let f = taylor.at([x, y]);
                let weight = v * w * h[0] * h[1];
                sums[0] += weight * ((f[1] - u[1]).powi(2) + (f[2] - u[2]).powi(2));
                sums[1] += weight * (f[0] - u[0]).powi(2);
            }
        }
        sums
    }

    #[test]
    fn integrals_over_a_cell_are_those_of_slow_sums_but_for_the_rest() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for spacing in [[0.1, 0.1], [0.06, 0.08], [0.11, 0.06]] {
            let grid = Grid { origin: [0.3, -0.2], spacing, shape: [26, 24] };
            let p: Vec<f64> = (0..grid.len())
                .map(|k| {
                    let (x, y) = ((k % 26) as f64 / 13.0 - 1.0, (k / 26) as f64 / 12.0 - 1.0);
                    let smooth = (0.8 - x * x - y * y).max(0.0).sqrt();
                    if smooth > 0.0 { smooth + 0.2 * random() } else { 0.0 }
                })
                .collect();
            let field = Field::new(&grid, &p).unwrap();
            for [i, j] in [[12, 12], [5, 7], [20, 17], [3, 12], [1, 2]] {
                let expansions = Expansions::new(&field, i as isize, j as isize, &mut Workspace::new());
                // The overlap: about the displacement itself, so that little is left.
                let c = expansions.polynomial.map(|lane| lane[0] * field.scale);
                let h = spacing;
                let t = [c[0], 2.0 * c[9] / h[0], 2.0 * c[15] / h[1], 0.4, -0.3, 0.1, 0.5, 0.2, -0.7, 0.3];
                let scaled = {
                    // In longer sides of a cell, as the displacement.
                    let s = field.scale;
                    let powers = [0, 1, 1, 2, 2, 2, 3, 3, 3, 3];
                    std::array::from_fn(|k| t[k] * f64::powi(s, powers[k]) / s)
                };
                let mut overlap = [[0.0; LANES]; POLYNOMIALS];
                for (k, v) in of_taylor(&scaled, field.tables.h) {
                    overlap[k][0] = v;
                }
                let fast = integrals(&field.tables, &expansions, &overlap);
                let slow = slow(&grid, &p, [i, j], &t);
                let s = field.scale;
                let fast = [fast[0][0] * s * s, fast[1][0] * s.powi(4)];
                let share = [0, 1].map(|k| (fast[k] / slow[k] - 1.0).abs());
                println!("{spacing:?} {i} {j}: {fast:?} {slow:?} {share:?}");
                assert!(share[0] < 0.01 && share[1] < 0.02, "{spacing:?} {i} {j}: {fast:?} {slow:?}");
            }
        }
    }
}
