//! The polynomial through the values at the centres of 5 x 5 cells, in the middle one.

/// Cells on either side of the middle one.
pub(super) const NODES: usize = 2;

/// Nodes along each side.
const SIDE: usize = 2 * NODES + 1;

/// sum of c[l][k] s^k t^l, k, l <= 4, with s and t in sides of a cell from its centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polynomial {
    c: [[f64; SIDE]; SIDE],
}

/// Middles of the quarters of the cell.
pub(super) const QUARTERS: [[f64; 2]; 4] = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];

/// Places along a side where a cell is sampled: its left border counts, its right one is the next cell's.
pub(super) const LATTICE: [f64; 4] = [-0.5, -0.25, 0.0, 0.25];

/// Coefficients of the polynomial of degree 4 through the values at -2, -1, 0, 1, 2.
fn through([a, b, c, d, e]: [f64; SIDE]) -> [f64; SIDE] {
    [
        c,
        (a - 8.0 * b + 8.0 * d - e) / 12.0,
        (16.0 * (b + d) - a - e - 30.0 * c) / 24.0,
        (e - a + 2.0 * (b - d)) / 12.0,
        (a + e - 4.0 * (b + d) + 6.0 * c) / 24.0,
    ]
}

impl Polynomial {
    /// The factor by which errors of the values can grow, for values, slopes per side and second derivatives alike.
    pub const GROWTH: f64 = 16.0;

    /// `value(i, j)`: that at the node (i - 2, j - 2).
    pub fn through(value: impl Fn(usize, usize) -> f64) -> Self {
        let rows: [[f64; SIDE]; SIDE] = std::array::from_fn(|j| through(std::array::from_fn(|i| value(i, j))));
        let mut c = [[0.0; SIDE]; SIDE];
        for k in 0..SIDE {
            let column = through(std::array::from_fn(|j| rows[j][k]));
            (0..SIDE).for_each(|l| c[l][k] = column[l]);
        }
        Self { c }
    }

    /// Value, and slopes per side of the cell.
    pub fn at(&self, [s, t]: [f64; 2]) -> [f64; 3] {
        let (mut value, mut along, mut across) = (0.0, 0.0, 0.0);
        for row in self.c.iter().rev() {
            let (mut v, mut d) = (0.0, 0.0);
            for c in row.iter().rev() {
                d = d * s + v;
                v = v * s + c;
            }
            across = across * t + value;
            value = value * t + v;
            along = along * t + d;
        }
        [value, along, across]
    }

    /// As [`Polynomial::at`] at the middles of the four quarters ([`QUARTERS`]), with what they share computed once.
    pub fn at_quarters(&self) -> [[f64; 3]; 4] {
        const Q: f64 = 0.25;
        // Value and slope at -1/4 and 1/4.
        let both = |[a, b, c, d, e]: [f64; SIDE]| {
            let (even, odd) = (a + Q * Q * (c + Q * Q * e), Q * (b + Q * Q * d));
            let (slope, bent) = (b + 3.0 * Q * Q * d, Q * (2.0 * c + 4.0 * Q * Q * e));
            [[even - odd, slope - bent], [even + odd, slope + bent]]
        };
        let rows = self.c.map(both);
        let column = |side: usize, what: usize| both(rows.map(|row| row[side][what]));
        let mut quarters = [[0.0; 3]; 4];
        for side in 0..2 {
            let (values, slopes) = (column(side, 0), column(side, 1));
            for up in 0..2 {
                quarters[2 * up + side] = [values[up][0], slopes[up][0], values[up][1]];
            }
        }
        quarters
    }

    /// Value and slopes per side at the centre.
    pub fn at_centre(&self) -> [f64; 3] {
        [self.c[0][0], self.c[0][1], self.c[1][0]]
    }

    /// Values at the points of [`LATTICE`] along both sides, row by row.
    pub fn at_lattice(&self) -> [f64; 16] {
        const Q: f64 = 0.25;
        let four = |[a, b, c, d, e]: [f64; SIDE]| {
            let (even, odd) = (a + Q * Q * (c + Q * Q * e), Q * (b + Q * Q * d));
            let edge = a + Q * (c + Q * e) - 0.5 * (b + Q * d);
            [edge, even - odd, a, even + odd]
        };
        let rows = self.c.map(four);
        let mut values = [0.0; 16];
        for k in 0..4 {
            let column = four(rows.map(|row| row[k]));
            (0..4).for_each(|l| values[4 * l + k] = column[l]);
        }
        values
    }

    /// Bounds of the second derivatives over the cell: along, mixed, across.
    pub fn curvature(&self) -> [f64; 3] {
        // 2^-n for the powers that are left.
        const HALF: [f64; SIDE] = [1.0, 0.5, 0.25, 0.125, 0.0625];
        let mut most = [0.0; 3];
        for (l, row) in self.c.iter().enumerate() {
            for (k, c) in row.iter().enumerate() {
                let c = c.abs();
                if k >= 2 {
                    most[0] += (k * (k - 1)) as f64 * HALF[k - 2] * HALF[l] * c;
                }
                if l >= 2 {
                    most[2] += (l * (l - 1)) as f64 * HALF[l - 2] * HALF[k] * c;
                }
                if k >= 1 && l >= 1 {
                    most[1] += (k * l) as f64 * HALF[k - 1] * HALF[l - 1] * c;
                }
            }
        }
        most
    }

    /// Largest distance from the tangent plane at the centre of a square of this half side within the cell.
    pub fn bend(&self, half: f64) -> f64 {
        let [a, b, c] = self.curvature();
        0.5 * (a + 2.0 * b + c) * half * half
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_degree_four_is_its_own() {
        let f = |s: f64, t: f64| 0.3 + s - 2.0 * t + s * t * t - 0.7 * s.powi(4) * t + 0.2 * t.powi(4) * s.powi(3);
        let p = Polynomial::through(|i, j| f(i as f64 - 2.0, j as f64 - 2.0));
        let (s, t) = (0.31, -0.22);
        let [value, along, across] = p.at([s, t]);
        assert!((value - f(s, t)).abs() < 1e-14);
        let e = 1e-5;
        assert!((along - (f(s + e, t) - f(s - e, t)) / (2.0 * e)).abs() < 1e-8);
        assert!((across - (f(s, t + e) - f(s, t - e)) / (2.0 * e)).abs() < 1e-8);
        for (at, [value, along, across]) in QUARTERS.into_iter().zip(p.at_quarters()) {
            let other = p.at(at);
            assert!((value - other[0]).abs() < 1e-14, "{at:?}");
            assert!((along - other[1]).abs() < 1e-14 && (across - other[2]).abs() < 1e-14, "{at:?}");
        }
        for (k, value) in p.at_lattice().into_iter().enumerate() {
            let at = [LATTICE[k % 4], LATTICE[k / 4]];
            assert!((value - p.at(at)[0]).abs() < 1e-14, "{at:?}");
        }
        assert_eq!(p.at_centre(), p.at([0.0; 2]));
        let half = 0.125;
        for (a, b) in [(half, half), (-half, half), (half, -half), (0.0, half)] {
            let off = f(s + a, t + b) - value - a * along - b * across;
            assert!(off.abs() <= p.bend(half) && p.bend(half) < 0.1, "{off} {}", p.bend(half));
        }
    }
}
