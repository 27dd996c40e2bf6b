//! Dense Cholesky factor of a symmetric positive definite matrix, by blocks of columns, and the solves with it.

use crate::numeric::simd::{Kernel, vectorised};

/// Columns of a block.
const BLOCK: usize = 64;

/// Columns before it that are taken off at a time: a strip of 8 of them and the rows of a tile stay in the first cache.
const DEEP: usize = 256;

/// Rows of a tile: with 8 columns its sums are twelve vectors, which leaves registers for what they are made of.
const HIGH: usize = 6;

/// The lower factor, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Cholesky {
    n: usize,
    rows: Vec<f64>,
}

impl Cholesky {
    /// Factors the lower triangle of the `n` x `n` matrix given row by row; None where it is not positive definite.
    pub fn new(matrix: Vec<f64>, n: usize) -> Option<Self> {
        let mut rows = matrix;
        let mut definite = true;
        let mut start = 0;
        while start < n && definite {
            let end = (start + BLOCK).min(n);
            definite = vectorised(Columns { rows: &mut rows, n, start, end });
            start = end;
        }
        definite.then_some(Self { n, rows })
    }

    /// Overwrites `x` by the solution.
    pub fn solve(&self, x: &mut [f64]) {
        vectorised(Solve { factor: self, x });
    }
}

/// One block of columns.
struct Columns<'a> {
    rows: &'a mut [f64],
    n: usize,
    start: usize,
    end: usize,
}

impl Kernel for Columns<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        update(self.rows, self.n, self.start, self.end);
        factor(self.rows, self.n, self.start, self.end)
    }
}

/// Both triangular solves.
struct Solve<'a> {
    factor: &'a Cholesky,
    x: &'a mut [f64],
}

impl Kernel for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (n, rows, x) = (self.factor.n, &self.factor.rows, self.x);
        for i in 0..n {
            let row = &rows[i * n..i * n + i];
            x[i] = (x[i] - product(row, &x[..i])) / rows[i * n + i];
        }
        for i in (0..n).rev() {
            x[i] /= rows[i * n + i];
            let v = x[i];
            let row = &rows[i * n..i * n + i];
            for (x, l) in x[..i].iter_mut().zip(row) {
                *x -= v * l;
            }
        }
    }
}

/// The scalar product in four lanes of eight.
#[inline(always)]
fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    tail + sums.iter().sum::<f64>()
}

/// Subtracts from the block of columns what the columns before it contribute, [`DEEP`] of those at a time.
#[inline(always)]
fn update(rows: &mut [f64], n: usize, start: usize, end: usize) {
    let width = end - start;
    // The block's own rows, transposed, by strips of 8: row k of strip s is L[start + 8 s.., from + k].
    let mut packed = vec![[0.0; 8]; BLOCK / 8 * DEEP];
    for from in (0..start).step_by(DEEP) {
        let deep = DEEP.min(start - from);
        for (c, i) in (start..end).enumerate() {
            for (k, l) in rows[i * n + from..][..deep].iter().enumerate() {
                packed[c / 8 * DEEP + k][c % 8] = *l;
            }
        }
        let mut i = start;
        while i < n {
            let count = HIGH.min(n - i);
            for (c, strip) in (0..width).step_by(8).zip(packed.chunks_exact(DEEP)) {
                // Rows of less than a tile: the last one again.
                let row = |r: usize| &rows[(i + r.min(count - 1)) * n + from..][..deep];
                let sums = tile(std::array::from_fn(row), &strip[..deep]);
                for (r, sum) in sums.iter().enumerate().take(count) {
                    let to = &mut rows[(i + r) * n + start + c..][..8.min(width - c)];
                    to.iter_mut().zip(sum).for_each(|(l, sum)| *l -= sum);
                }
            }
            i += count;
        }
    }
}

/// Products of rows with the columns of a strip.
#[inline(always)]
fn tile(rows: [&[f64]; HIGH], strip: &[[f64; 8]]) -> [[f64; 8]; HIGH] {
    let rows = rows.map(|row| &row[..strip.len()]);
    let mut sums = [[0.0; 8]; HIGH];
    for (k, l) in strip.iter().enumerate() {
        for r in 0..HIGH {
            for m in 0..8 {
                sums[r][m] += rows[r][k] * l[m];
            }
        }
    }
    sums
}

/// Factors the block of columns, whose earlier columns have been taken off.
#[inline(always)]
fn factor(rows: &mut [f64], n: usize, start: usize, end: usize) -> bool {
    for j in start..end {
        let head: Vec<f64> = rows[j * n + start..j * n + j].to_vec();
        let pivot = rows[j * n + j] - product(&head, &head);
        if !(pivot > 0.0) {
            return false;
        }
        let pivot = pivot.sqrt();
        rows[j * n + j] = pivot;
        for i in j + 1..n {
            let sum = product(&rows[i * n + start..i * n + j], &head);
            rows[i * n + j] = (rows[i * n + j] - sum) / pivot;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planted_solution() {
        for n in [1, 5, 64, 65, 200, 333] {
            let entry = |i: usize, j: usize| 1.0 / (1.0 + (i as f64 - j as f64).abs()) + if i == j { 1.0 } else { 0.0 };
            let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let planted: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
            let mut x: Vec<f64> = (0..n).map(|i| product(&matrix[i * n..(i + 1) * n], &planted)).collect();
            Cholesky::new(matrix, n).unwrap().solve(&mut x);
            for (a, b) in x.iter().zip(&planted) {
                assert!((a - b).abs() < 1e-12, "{n}");
            }
        }
        assert!(Cholesky::new(vec![1.0, 2.0, 2.0, 1.0], 2).is_none());
    }
}
