//! Polynomials of a cell: Legendre's, up to degree 4 along each side, and those that cell means determine.
//!
//! With (s, t) in sides of the cell from its centre the basis is P_a(2s) P_b(2t), a, b <= 4, sorted by parity:
//! even in both, odd in s, odd in t, odd in both; within a class a runs fastest.

/// Polynomials of the basis.
pub(super) const POLYNOMIALS: usize = 25;

/// First polynomial of each class, and the end.
pub(super) const CLASSES: [usize; 5] = [0, 9, 15, 21, 25];

/// Degrees (a, b) of each polynomial.
pub(super) const DEGREES: [[usize; 2]; POLYNOMIALS] = [
    [0, 0],
    [2, 0],
    [4, 0],
    [0, 2],
    [2, 2],
    [4, 2],
    [0, 4],
    [2, 4],
    [4, 4],
    [1, 0],
    [3, 0],
    [1, 2],
    [3, 2],
    [1, 4],
    [3, 4],
    [0, 1],
    [2, 1],
    [4, 1],
    [0, 3],
    [2, 3],
    [4, 3],
    [1, 1],
    [3, 1],
    [1, 3],
    [3, 3],
];

/// Cells on either side of the middle one whose means determine the polynomial.
pub(super) const NODES: usize = 3;

/// The polynomial of degree 6 with the means n_-3 ... n_3 over seven cells in a row, less what it has of P_5 and P_6 in the middle
/// one: c_0, c_2, c_4 from n_0, n_1 + n_-1, n_2 + n_-2, n_3 + n_-3. Exact for polynomials of degree 4.
pub(super) const EVEN: [[f64; 4]; 3] = [
    [1.0, 0.0, 0.0, 0.0],
    [-745.0 / 3024.0, 559.0 / 4032.0, -169.0 / 10080.0, 79.0 / 60480.0],
    [41.0 / 6930.0, -51.0 / 12320.0, 1.0 / 770.0, -13.0 / 110_880.0],
];

/// c_1, c_3 from n_1 - n_-1, n_2 - n_-2, n_3 - n_-3.
pub(super) const ODD: [[f64; 3]; 2] =
    [[7843.0 / 20160.0, -211.0 / 2520.0, 191.0 / 20160.0], [-61.0 / 4320.0, 19.0 / 2160.0, -1.0 / 864.0]];

/// Bounds, over all waves exp(i theta k) of unit size, of the mean over the middle cell of the square of that polynomial and of
/// the square of its slope: 1.2517 and 4.1649, reached at theta = pi.
pub(super) const GROWTH: [f64; 2] = [1.26, 4.2];

/// P_0(2s) ... P_4(2s).
pub(super) fn legendre(s: f64) -> [f64; 5] {
    let x = 2.0 * s;
    let x2 = x * x;
    [1.0, x, 1.5 * x2 - 0.5, x * (2.5 * x2 - 1.5), (4.375 * x2 - 3.75) * x2 + 0.375]
}

/// Their derivatives by s.
pub(super) fn slopes(s: f64) -> [f64; 5] {
    let x = 2.0 * s;
    let x2 = x * x;
    [0.0, 2.0, 6.0 * x, 15.0 * x2 - 3.0, x * (35.0 * x2 - 15.0)]
}

/// Largest |d^2 P_a(2s)/ds^2| in the cell.
pub(super) const BENDS: [f64; 5] = [0.0, 0.0, 12.0, 60.0, 180.0];

/// Coefficients c_a from seven means.
pub(super) fn through(n: [f64; 7]) -> [f64; 5] {
    let sums = [n[3], n[4] + n[2], n[5] + n[1], n[6] + n[0]];
    let differences = [n[4] - n[2], n[5] - n[1], n[6] - n[0]];
    let even = EVEN.map(|row| row.iter().zip(sums).map(|(c, s)| c * s).sum::<f64>());
    let odd = ODD.map(|row| row.iter().zip(differences).map(|(c, d)| c * d).sum::<f64>());
    [even[0], odd[0], even[1], odd[1], even[2]]
}

/// The coefficients of 1, x, ..., y^3 ([`super::overlap::Taylor`]) in the basis of a cell of sides `h`; only nine differ from zero.
pub(super) fn of_taylor(t: &[f64; 10], [hx, hy]: [f64; 2]) -> [(usize, f64); 10] {
    // s = P_1/2, s^2 = 1/12 + P_2/6, s^3 = 3 P_1/40 + P_3/20.
    let (x2, xy, y2) = (t[3] * hx * hx, t[4] * hx * hy, t[5] * hy * hy);
    let (x3, x2y, xy2, y3) = (t[6] * hx * hx * hx, t[7] * hx * hx * hy, t[8] * hx * hy * hy, t[9] * hy * hy * hy);
    [
        (0, t[0] + (x2 + y2) / 12.0),
        (1, x2 / 6.0),
        (3, y2 / 6.0),
        (9, t[1] * hx / 2.0 + 3.0 * x3 / 40.0 + xy2 / 24.0),
        (10, x3 / 20.0),
        (11, xy2 / 12.0),
        (15, t[2] * hy / 2.0 + 3.0 * y3 / 40.0 + x2y / 24.0),
        (16, x2y / 12.0),
        (18, y3 / 20.0),
        (21, xy / 4.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::GaussLegendre;

    #[test]
    fn means_of_a_quartic_give_it_back() {
        let c = [0.3, -1.1, 0.7, 0.25, -0.6];
        let rule = GaussLegendre::new(8);
        // P_a(2s) continued beyond the cell.
        let value = |s: f64| legendre(s).iter().zip(c).map(|(p, c)| p * c).sum::<f64>();
        let means = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|k| rule.sum(value, k - 0.5, k + 0.5));
        for (found, c) in through(means).into_iter().zip(c) {
            assert!((found - c).abs() < 1e-12, "{found} {c}");
        }
    }

    #[test]
    fn the_cubic_of_taylor_is_the_same_function_in_the_basis() {
        let t = [0.1, -0.4, 0.9, 1.3, -0.8, 0.2, 2.0, -1.0, 0.6, 0.7];
        let h = [0.8, 1.0];
        let terms = of_taylor(&t, h);
        for [s, u] in [[0.2, -0.4], [-0.5, 0.5], [0.31, 0.07]] {
            let (x, y) = (s * h[0], u * h[1]);
            let powers = [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
            let exact: f64 = t.iter().zip(powers).map(|(t, p)| t * p).sum();
            let (a, b) = (legendre(s), legendre(u));
            let found: f64 = terms.iter().map(|(k, c)| c * a[DEGREES[*k][0]] * b[DEGREES[*k][1]]).sum();
            assert!((found - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn no_wave_of_cell_means_grows_by_more_than_stated() {
        let rule = GaussLegendre::new(10);
        for k in 0..=2000 {
            let theta = std::f64::consts::PI * f64::from(k) / 2000.0;
            let means = |f: fn(f64) -> f64| [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|n: f64| f(theta * n));
            let (re, im) = (through(means(f64::cos)), through(means(f64::sin)));
            let sum = |of: fn(f64) -> [f64; 5]| {
                let at = |s: f64, c: &[f64; 5]| of(s).iter().zip(c).map(|(p, c)| p * c).sum::<f64>().powi(2);
                rule.sum(|s| at(s, &re) + at(s, &im), -0.5, 0.5)
            };
            // Between two of these waves nothing changes by more than 7 pi/2000 of itself.
            assert!(sum(legendre) < GROWTH[0] * 0.995 && sum(slopes) < GROWTH[1] * 0.9925, "{theta}");
        }
    }
}
