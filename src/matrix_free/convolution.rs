//! The convolution of a field over a box of cells with an even kernel, in either precision: by transforms, or, of few cells, by the
//! sums themselves. They skip what carries nothing, and need no symbol: measured up to 200 cells, less than half the work.

use std::ops::Range;

use super::real::Real;
use super::split::Split;
use super::symbol::Symbol;
use super::transforms::Transforms;

/// A convolution, ready to be applied.
#[derive(Debug)]
pub(super) enum Convolution<T> {
    Sums(Sums<T>),
    Transforms(Transforms<T>),
    Split(Box<Split<T>>),
}

impl<T: Real> Convolution<T> {
    /// By transforms, over `shape` cells.
    pub(super) fn new(shape: [usize; 2], symbol: &Symbol) -> Self {
        Self::Transforms(Transforms::new(shape, symbol))
    }
}

/// Cells up to which sums are less work than transforms.
pub(super) const FEW: usize = 256;

/// Sums done side by side.
const LANES: usize = 16;

/// Every coefficient from row to row: of a small box they stay in the nearest cache.
#[derive(Debug)]
pub(super) struct Sums<T> {
    shape: [usize; 2],
    /// For each row of p and each of u those of offsets -(n_x - 1) to n_x - 1.
    coefficients: Vec<T>,
}

impl<T: Real> Sums<T> {
    /// Over `shape` cells, no more than [`FEW`], the upper half of twice as many rows when `mirrored`, of a kernel of offsets in
    /// cells.
    pub(super) fn new(shape: [usize; 2], mirrored: bool, kernel: impl Fn(usize, usize) -> f64) -> Self {
        let [nx, ny] = shape;
        let wide = 2 * nx - 1;
        let mut coefficients = vec![T::of(0.0); ny * ny * wide + LANES];
        let rows = if mirrored { 2 * ny } else { ny };
        let half: Vec<T> = (0..rows * nx).map(|k| T::of(kernel(k % nx, k / nx))).collect();
        let half = |j: usize| &half[j * nx..(j + 1) * nx];
        for (k, row) in coefficients.chunks_exact_mut(wide).take(ny * ny).enumerate() {
            let (j, y) = (k / ny, k % ny);
            let (left, right) = row.split_at_mut(nx - 1);
            right.copy_from_slice(half(y.abs_diff(j)));
            if mirrored {
                // The image of row j is row -1 - j.
                right.iter_mut().zip(half(y + j + 1)).for_each(|(to, image)| *to = *to + *image);
            }
            left.iter_mut().rev().zip(&right[1..]).for_each(|(to, from)| *to = *from);
        }
        Self { shape, coefficients }
    }

    /// As [`Transforms::apply`].
    pub(super) fn apply(&self, p: &[T], given: Range<usize>, u: &mut [T], wanted: Range<usize>) {
        let [nx, ny] = self.shape;
        let (wide, zero) = (2 * nx - 1, T::of(0.0));
        // What presses, and the coefficient from it to the first cell.
        let (mut loads, mut count) = ([(zero, 0); FEW], 0);
        for j in given {
            for (i, &p) in p[j * nx..(j + 1) * nx].iter().enumerate().filter(|(_, p)| **p != zero) {
                loads[count] = (p, j * ny * wide + nx - 1 - i);
                count += 1;
            }
        }
        for y in wanted {
            for (c, u) in u[y * nx..(y + 1) * nx].chunks_mut(LANES).enumerate() {
                let mut sums = [zero; LANES];
                for (p, first) in &loads[..count] {
                    let row = self.coefficients[first + y * wide + c * LANES..].first_chunk::<LANES>();
                    for (sum, coefficient) in sums.iter_mut().zip(row.into_iter().flatten()) {
                        *sum = *sum + *p * *coefficient;
                    }
                }
                u.copy_from_slice(&sums[..u.len()]);
            }
        }
    }
}
