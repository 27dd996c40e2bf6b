//! Dense Cholesky factor of a symmetric positive definite matrix, by blocks of columns, and the solves with it.

use crate::numeric::simd::{Kernel, vectorised};

/// Columns of a block: three rows of 64 doubles and an 8 x 8 tile stay in the first cache.
const BLOCK: usize = 64;

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

/// Subtracts from the block of columns what the columns before it contribute.
#[inline(always)]
fn update(rows: &mut [f64], n: usize, start: usize, end: usize) {
    if start == 0 {
        return;
    }
    let width = end - start;
    // The block's own rows, transposed: column k of the packed array is L[start.., k].
    let mut packed = vec![0.0; start * BLOCK];
    for (c, i) in (start..end).enumerate() {
        for k in 0..start {
            packed[k * BLOCK + c] = rows[i * n + k];
        }
    }
    let mut i = start;
    while i < n {
        let count = (n - i).min(4);
        let mut c = 0;
        while c < width {
            let mut sums = [[0.0; 8]; 4];
            if count == 4 {
                let (r0, r1) = (&rows[i * n..i * n + start], &rows[(i + 1) * n..(i + 1) * n + start]);
                let (r2, r3) = (&rows[(i + 2) * n..(i + 2) * n + start], &rows[(i + 3) * n..(i + 3) * n + start]);
                for k in 0..start {
                    let l = &packed[k * BLOCK + c..k * BLOCK + c + 8];
                    for m in 0..8 {
                        sums[0][m] += r0[k] * l[m];
                        sums[1][m] += r1[k] * l[m];
                        sums[2][m] += r2[k] * l[m];
                        sums[3][m] += r3[k] * l[m];
                    }
                }
            } else {
                for (r, sum) in sums.iter_mut().enumerate().take(count) {
                    let row = &rows[(i + r) * n..(i + r) * n + start];
                    for k in 0..start {
                        let l = &packed[k * BLOCK + c..k * BLOCK + c + 8];
                        for m in 0..8 {
                            sum[m] += row[k] * l[m];
                        }
                    }
                }
            }
            for (r, sum) in sums.iter().enumerate().take(count) {
                for m in 0..8.min(width - c) {
                    rows[(i + r) * n + start + c + m] -= sum[m];
                }
            }
            c += 8;
        }
        i += count;
    }
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
