//! Dense Cholesky factor of a symmetric positive definite matrix, by blocks of columns, and the solves with it.

use crate::numeric::simd::{Kernel, vectorised};
use crate::threads::parts;

/// Columns of a block.
const BLOCK: usize = 64;

/// Columns before it that are taken off at a time: a strip of 8 of them and the rows of a tile stay in the first cache.
const DEEP: usize = 256;

/// Rows of a tile: with 8 columns its sums are twelve vectors, which leaves registers for what they are made of.
const HIGH: usize = 6;

/// Rows that are worked on at a time by one thread.
const JOB: usize = 16 * HIGH;

/// Rows from which threads pay.
const WORTH_THREADS: usize = 384;

/// The lower factor, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Cholesky {
    n: usize,
    rows: Vec<f64>,
}

impl Cholesky {
    /// Factors the lower triangle of the `n` x `n` matrix given row by row; None where it is not positive definite. The number of threads
    /// does not change the factor.
    pub fn new(matrix: Vec<f64>, n: usize, threads: usize) -> Option<Self> {
        let mut rows = matrix;
        let threads = if n < WORTH_THREADS { 1 } else { threads };
        let mut blocks = (0..n).step_by(BLOCK);
        let definite = blocks.all(|start| columns(&mut rows, n, start, threads));
        definite.then_some(Self { n, rows })
    }

    /// Overwrites `x` by the solution.
    pub fn solve(&self, x: &mut [f64]) {
        vectorised(Solve { factor: self, x });
    }
}

/// The block of columns that begins at `start`, whether it is positive definite.
fn columns(rows: &mut [f64], n: usize, start: usize, threads: usize) -> bool {
    let end = (start + BLOCK).min(n);
    let (above, below) = rows.split_at_mut(end * n);
    let own = &mut above[start * n..];
    let strips = strips(own, n, start);
    vectorised(Part { rows: own, n, start, strips: &strips, factored: &[] });
    let Some(factored) = triangle(own, n, start) else { return false };
    let part = |rows: &mut [f64]| vectorised(Part { rows, n, start, strips: &strips, factored: &factored });
    parts(below, JOB * n, threads, part);
    true
}

/// The rows of a block before it, transposed, [`DEEP`] columns at a time and 8 rows at a time: row k of strip s is
/// L[start + 8 s.., from + k].
fn strips(own: &[f64], n: usize, start: usize) -> Vec<[f64; 8]> {
    let mut strips = vec![[0.0; 8]; BLOCK / 8 * start];
    for (c, row) in own.chunks_exact(n).enumerate() {
        for (from, deep) in pieces(start) {
            let strip = &mut strips[BLOCK / 8 * from + c / 8 * deep..];
            strip.iter_mut().zip(&row[from..from + deep]).for_each(|(strip, l)| strip[c % 8] = *l);
        }
    }
    strips
}

/// The columns before a block: the first of each piece, and how many.
fn pieces(start: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..start).step_by(DEEP).map(move |from| (from, DEEP.min(start - from)))
}

/// Factors the block of rows on the diagonal, whose earlier columns have been taken off: its columns one after another, from the diagonal
/// down; `None` where it is not positive definite.
fn triangle(own: &mut [f64], n: usize, start: usize) -> Option<Vec<[f64; BLOCK]>> {
    let width = own.len() / n;
    let mut factored = vec![[0.0; BLOCK]; width];
    for j in 0..width {
        let pivot = own[j * n + start + j];
        if !(pivot > 0.0) {
            return None;
        }
        let pivot = pivot.sqrt();
        for i in j..width {
            let l = if i == j { pivot } else { own[i * n + start + j] / pivot };
            own[i * n + start + j] = l;
            factored[j][i] = l;
        }
        for i in j + 1..width {
            let l = factored[j][i];
            let row = &mut own[i * n + start..][..=i];
            row[j + 1..].iter_mut().zip(&factored[j][j + 1..]).for_each(|(to, f)| *to -= l * f);
        }
    }
    Some(factored)
}

/// Some rows of a block of columns.
struct Part<'a> {
    rows: &'a mut [f64],
    n: usize,
    start: usize,
    strips: &'a [[f64; 8]],
    /// The block on the diagonal, column by column, for rows below it.
    factored: &'a [[f64; BLOCK]],
}

impl Kernel for Part<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { rows, n, start, strips, factored } = self;
        update(rows, n, start, strips);
        for row in rows.chunks_exact_mut(n) {
            let row = &mut row[start..];
            for (j, column) in factored.iter().enumerate() {
                let l = row[j] / column[j];
                row[j] = l;
                row[j + 1..].iter_mut().zip(&column[j + 1..]).for_each(|(to, f)| *to -= l * f);
            }
        }
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

/// Subtracts from rows of the block of columns what the columns before it contribute, [`DEEP`] of those at a time.
#[inline(always)]
fn update(rows: &mut [f64], n: usize, start: usize, strips: &[[f64; 8]]) {
    let (count, width) = (rows.len() / n, BLOCK.min(n - start));
    for (from, deep) in pieces(start) {
        for i in (0..count).step_by(HIGH) {
            let high = HIGH.min(count - i);
            for (c, strip) in (0..width).step_by(8).zip(strips[BLOCK / 8 * from..].chunks_exact(deep)) {
                // Rows of less than a tile: the last one again.
                let row = |r: usize| &rows[(i + r.min(high - 1)) * n + from..][..deep];
                let sums = tile(std::array::from_fn(row), strip);
                for (r, sum) in sums.iter().enumerate().take(high) {
                    let to = &mut rows[(i + r) * n + start + c..][..8.min(width - c)];
                    to.iter_mut().zip(sum).for_each(|(l, sum)| *l -= sum);
                }
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planted_solution() {
        for n in [1, 5, 64, 65, 200, 333, 777] {
            let entry = |i: usize, j: usize| 1.0 / (1.0 + (i as f64 - j as f64).abs()) + if i == j { 1.0 } else { 0.0 };
            let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let planted: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).sin()).collect();
            let rhs: Vec<f64> = (0..n).map(|i| product(&matrix[i * n..(i + 1) * n], &planted)).collect();
            let [one, two] = [1, 2].map(|threads| {
                let mut x = rhs.clone();
                Cholesky::new(matrix.clone(), n, threads).unwrap().solve(&mut x);
                x
            });
            assert_eq!(one, two);
            for (a, b) in one.iter().zip(&planted) {
                assert!((a - b).abs() < 1e-12, "{n}");
            }
        }
        assert!(Cholesky::new(vec![1.0, 2.0, 2.0, 1.0], 2, 1).is_none());
    }
}
