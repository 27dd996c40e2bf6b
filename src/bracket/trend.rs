//! What a pressure that rises steadily from cell to cell leaves of the polynomial of the displacement.
//!
//! With X_j the offset of cell j from the middle one, in cells, E_x is the sum of X_j e_j over the block B, and E_y likewise.
//! Within the contact nearly all of the jumps around a cell are of this kind, and they cancel in the middle and at the borders of
//! a cell, where a bound cell by cell adds them up.

use std::f64::consts::FRAC_1_PI;

use super::polynomial::LATTICE;
use super::source::Source;

/// Tiles along half a cell.
const TILES: usize = 32;

/// Of E_x and E_y.
#[derive(Debug)]
pub(super) struct Trend {
    /// Least and greatest over each quarter, in the order of [`super::polynomial::QUARTERS`].
    pub quarters: [[[f64; 2]; 4]; 2],
    /// At the points of [`LATTICE`] along x and y, x fastest.
    pub lattice: [[f64; 16]; 2],
}

impl Trend {
    pub fn new(h: [f64; 2], block: [usize; 2]) -> Self {
        let along = Strips::new(h, block);
        let across = if h[0] == h[1] { None } else { Some(Strips::new([h[1], h[0]], [block[1], block[0]])) };
        let across = across.as_ref().unwrap_or(&along);
        // E is odd along its own axis and even across it.
        let ranges = [along.range(), if h[0] == h[1] { along.range() } else { across.range() }];
        let side = |axis: usize, up: bool| if up { ranges[axis] } else { [-ranges[axis][1], -ranges[axis][0]] };
        let quarters = [0, 1].map(|axis| std::array::from_fn(|k| side(axis, (k >> axis) & 1 == 1)));
        let at = |k: usize| [LATTICE[k % 4], LATTICE[k / 4]];
        let lattice = [
            std::array::from_fn(|k| along.value(at(k))[0]),
            std::array::from_fn(|k| across.value([at(k)[1], at(k)[0]])[0]),
        ];
        Self { quarters, lattice }
    }
}

/// Columns of the block on either side of the middle one: X and its source.
struct Strips(Vec<(f64, Source)>);

impl Strips {
    fn new(h: [f64; 2], block: [usize; 2]) -> Self {
        let sides = [h[0], (2 * block[1] + 1) as f64 * h[1]];
        let reach = block[0] as i64;
        let columns = (-reach..=reach).filter(|x| *x != 0);
        Self(columns.map(|x| (x as f64, Source::new(h, sides, [x, 0]))).collect())
    }

    /// E and its slopes per side.
    fn value(&self, at: [f64; 2]) -> [f64; 3] {
        self.0.iter().fold([0.0; 3], |sum, (x, source)| {
            let e = source.error(at);
            [0, 1, 2].map(|m| sum[m] + x * e[m])
        })
    }

    /// Bounds over 0 <= s, t <= 1/2.
    ///
    /// The second derivatives of 1/r are at most 2/r^3, whose integral over a half-plane at the distance D is 2/D: those of
    /// the displacement by a strip are at most 4/(pi D). Beside the strip itself it lies between two of its values.
    fn range(&self) -> [f64; 2] {
        let tile = 0.25 / TILES as f64;
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        for k in 0..TILES * TILES {
            let at = [k % TILES, k / TILES].map(|k| (2 * k + 1) as f64 * tile);
            let (mut sum, mut off) = ([0.0; 3], 0.0);
            for (x, source) in &self.0 {
                let h = source.h;
                let apart = (x.abs() - 0.5 - x.signum() * at[0] - tile) * h[0];
                let (plane, rest) = if apart > 0.5 * tile * h[0] {
                    let square = tile * tile * (h[0] * h[0] + h[1] * h[1]);
                    (source.displacement(at), 2.0 * FRAC_1_PI / apart * square)
                } else {
                    let [low, high] = source.within(at, tile);
                    ([0.5 * (low + high), 0.0, 0.0], 0.5 * (high - low))
                };
                let polynomial = source.polynomial.at(at);
                (0..3).for_each(|m| sum[m] += x * (plane[m] - polynomial[m]));
                off += x.abs() * (rest + source.polynomial.bend(tile));
            }
            let off = off + (sum[1].abs() + sum[2].abs()) * tile + 1e-9;
            bounds = [bounds[0].min(sum[0] - off), bounds[1].max(sum[0] + off)];
        }
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::super::polynomial::QUARTERS;
    use super::*;

    #[test]
    fn no_point_of_a_quarter_lies_outside_its_range() {
        for (h, block) in [([1.0, 1.0], [10, 10]), ([1.0, 0.5], [10, 20])] {
            let trend = Trend::new(h, block);
            let along = Strips::new(h, block);
            let across = Strips::new([h[1], h[0]], [block[1], block[0]]);
            for (k, middle) in QUARTERS.into_iter().enumerate() {
                let mut seen = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
                for n in 0..400 {
                    let f = |step: f64| (step * f64::from(n)).fract() - 0.5;
                    let at = [middle[0] + 0.5 * f(0.754_877_666), middle[1] + 0.5 * f(0.569_840_291)];
                    let values = [along.value(at)[0], across.value([at[1], at[0]])[0]];
                    for (value, seen) in values.into_iter().zip(&mut seen) {
                        *seen = [seen[0].min(value), seen[1].max(value)];
                    }
                }
                for ([low, high], [least, most]) in trend.quarters.map(|q| q[k]).into_iter().zip(seen) {
                    assert!(low <= least && most <= high, "{h:?} {k}: [{low}, {high}] [{least}, {most}]");
                    assert!(high - low < 1.4 * (most - least), "{h:?} {k}: [{low}, {high}] [{least}, {most}]");
                }
            }
        }
    }
}
