//! Convolution of a field on a box of cells with an even kernel, by the fast Fourier transform.
//!
//! u = K * p over n_x by n_y cells. Padded with zeros to at least 2n - 1 in each direction the cyclic convolution is the
//! linear one (Hockney 1970; Liu, Wang & Liu, Wear 243 (2000) 101); not padded it is the periodic one, a third of the work.
//! The kernel is even in x and in y, so its transform (the symbol) is real and even: a quarter of it is stored.
//!
//! Rows are transformed first, and only those that hold something; then blocks of columns, there and back; then the rows
//! that are wanted. The order of every sum is fixed: the number of threads does not change a bit of the result.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::influence::InfluenceTable;

/// Columns transformed together: their rows then share cache lines.
const BLOCK: usize = 8;

const ZERO: Complex<f64> = Complex { re: 0.0, im: 0.0 };

thread_local! {
    /// Twiddle factors outlive an operator: small problems would spend most of their time on them.
    static PLANNERS: RefCell<(RealFftPlanner<f64>, FftPlanner<f64>)> =
        RefCell::new((RealFftPlanner::new(), FftPlanner::new()));
}

/// The least number not below `n` of the form 2^a 3^b 5^c 7^d, even if `even`: lengths whose transforms are fast.
fn good_length(n: usize, even: bool) -> usize {
    (n.max(1)..)
        .find(|&m| {
            let mut rest = m;
            for prime in [2, 3, 5, 7] {
                while rest % prime == 0 {
                    rest /= prime;
                }
            }
            rest == 1 && (m % 2 == 0 || !even)
        })
        .unwrap_or(n)
}

/// A symmetric convolution over a box of cells.
#[derive(Clone)]
pub struct Operator {
    shape: [usize; 2],
    length: [usize; 2],
    /// Symbol over length_x length_y; column k holds its length_y/2 + 1 values next to each other.
    symbol: Vec<f64>,
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_inverse: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_inverse: Arc<dyn Fft<f64>>,
}

/// Room for the transforms of an [`Operator`]; owned by the caller, grown as needed, kept from product to product.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Transformed rows, one after the other.
    rows: Vec<Complex<f64>>,
    /// Columns on their way back, in blocks: rows of [`BLOCK`] numbers.
    blocks: Vec<Complex<f64>>,
    threads: Vec<Lane>,
    parallel: bool,
}

/// Room that one thread needs.
#[derive(Debug, Default)]
struct Lane {
    row: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    columns: Vec<Complex<f64>>,
    fft: Vec<Complex<f64>>,
}

impl Scratch {
    /// Room for products by one thread.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Room for products by all threads of the rayon pool that the product is called in.
    #[cfg(feature = "parallel")]
    #[must_use]
    pub fn parallel() -> Self {
        Self { parallel: true, ..Self::default() }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of::<Complex<f64>>() * (self.rows.capacity() + self.blocks.capacity())
    }

    fn lanes(&self) -> usize {
        #[cfg(feature = "parallel")]
        if self.parallel {
            return rayon::current_num_threads();
        }
        let _ = self.parallel;
        1
    }
}

impl std::fmt::Debug for Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Operator").field("shape", &self.shape).field("length", &self.length).finish()
    }
}

impl Operator {
    /// Displacement by pressure (E* = 1) over `shape` cells of these sides. The table must have their aspect ratio and
    /// at least `shape` offsets.
    #[must_use]
    pub fn compliance(table: &InfluenceTable, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let length = [2 * good_length(shape[0], false), 2 * good_length(shape[1], false)];
        let scale = InfluenceTable::scale(spacing);
        Self::with(shape, length, |j, row| {
            if j < shape[1] {
                for (to, from) in row.iter_mut().zip(&table.row(j)[..shape[0]]) {
                    *to = scale * from;
                }
            }
        })
    }

    /// Its approximate inverse: the inverse of the periodic convolution with the same coefficients on a grid that is not
    /// padded (Strang's circulant; close to the symbol |q|/2 of the half-space). Positive definite.
    #[must_use]
    pub fn preconditioner(table: &InfluenceTable, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let length = [good_length(shape[0], true), good_length(shape[1], false)];
        let scale = InfluenceTable::scale(spacing);
        let last = table.shape()[1] - 1;
        let mut operator = Self::with(shape, length, |j, row| {
            if j <= last {
                for (to, from) in row.iter_mut().zip(table.row(j)) {
                    *to = scale * from;
                }
            }
        });
        // Of a truncated kernel a value of the symbol could come out negative: kept away from zero.
        let cells = (length[0] * length[1]) as f64;
        let largest = operator.symbol.iter().copied().fold(0.0, f64::max);
        for s in &mut operator.symbol {
            *s = 1.0 / (s.abs().max(1e-9 * largest) * cells * cells);
        }
        operator
    }

    /// The operator whose kernel at offsets i = 0..=length_x/2 of row j is what `fill` puts in place of zeros.
    fn with(shape: [usize; 2], length: [usize; 2], fill: impl Fn(usize, &mut [f64])) -> Self {
        let [mx, my] = length;
        let (row_forward, row_inverse, column_forward, column_inverse) = PLANNERS.with_borrow_mut(|(real, complex)| {
            (
                real.plan_fft_forward(mx),
                real.plan_fft_inverse(mx),
                complex.plan_fft_forward(my),
                complex.plan_fft_inverse(my),
            )
        });
        let (columns, half) = (mx / 2 + 1, my / 2 + 1);
        // Rows of the kernel, extended evenly: their transforms are real.
        let mut rows = vec![0.0; half * columns];
        let mut lane = Lane::default();
        lane.row.resize(mx, 0.0);
        lane.spectrum.resize(columns, ZERO);
        lane.fft.resize(row_forward.get_scratch_len().max(column_forward.get_inplace_scratch_len()), ZERO);
        for j in 0..half {
            lane.row.fill(0.0);
            fill(j, &mut lane.row[..columns]);
            for i in columns..mx {
                lane.row[i] = lane.row[mx - i];
            }
            if lane.row[0] != 0.0 {
                let done = row_forward.process_with_scratch(&mut lane.row, &mut lane.spectrum, &mut lane.fft);
                debug_assert!(done.is_ok());
                for (to, from) in rows[j * columns..].iter_mut().zip(&lane.spectrum) {
                    *to = from.re;
                }
            }
        }
        // Two real even columns make one complex transform.
        let norm = 1.0 / (mx * my) as f64;
        let mut symbol = vec![0.0; columns * half];
        lane.columns.resize(BLOCK * my, ZERO);
        for first in (0..columns).step_by(2 * BLOCK) {
            let pairs = (columns - first).div_ceil(2).min(BLOCK);
            for j in 0..half {
                for c in 0..pairs {
                    let k = first + 2 * c;
                    let im = if k + 1 < columns { rows[j * columns + k + 1] } else { 0.0 };
                    let value = Complex { re: rows[j * columns + k], im };
                    lane.columns[c * my + j] = value;
                    lane.columns[c * my + (my - j) % my] = value;
                }
            }
            column_forward.process_with_scratch(&mut lane.columns[..pairs * my], &mut lane.fft);
            for c in 0..pairs {
                let k = first + 2 * c;
                for l in 0..half {
                    let value = lane.columns[c * my + l];
                    symbol[k * half + l] = value.re * norm;
                    if k + 1 < columns {
                        symbol[(k + 1) * half + l] = value.im * norm;
                    }
                }
            }
        }
        Self { shape, length, symbol, row_forward, row_inverse, column_forward, column_inverse }
    }

    /// Number of cells along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Lengths of the transforms.
    #[must_use]
    pub fn length(&self) -> [usize; 2] {
        self.length
    }

    /// The kernel at zero offset.
    pub(super) fn at_origin(&self) -> f64 {
        let ([mx, my], half) = (self.length, self.length[1] / 2 + 1);
        // A value stands for all that are equal to it by evenness.
        let times = |k: usize, m: usize| if k == 0 || 2 * k == m { 1.0 } else { 2.0 };
        let column = |k: usize| (0..half).map(|l| times(l, my) * self.symbol[k * half + l]).sum::<f64>();
        (0..=mx / 2).map(|k| times(k, mx) * column(k)).sum()
    }

    /// A bound of the 2-norm: the largest value of the symbol.
    pub(super) fn norm(&self) -> f64 {
        let largest = self.symbol.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        largest * (self.length[0] * self.length[1]) as f64
    }

    /// Writes the rows `wanted` of K * p to `u`; the rest of `u` is left as it is. Only the rows `given` of `p` are read:
    /// the others must be zero. Fields have the operator's shape, x fastest.
    pub fn apply(&self, p: &[f64], given: Range<usize>, u: &mut [f64], wanted: Range<usize>, scratch: &mut Scratch) {
        let nx = self.shape[0];
        let columns = self.length[0] / 2 + 1;
        if given.is_empty() || wanted.is_empty() {
            u[wanted.start * nx..wanted.end * nx].fill(0.0);
            return;
        }
        let lanes = scratch.lanes();
        scratch.threads.resize_with(lanes, Lane::default);
        for lane in &mut scratch.threads {
            self.fit(lane);
        }
        grow(&mut scratch.rows, given.len() * columns);
        grow(&mut scratch.blocks, columns.div_ceil(BLOCK) * wanted.len() * BLOCK);

        let Scratch { rows, blocks, threads, .. } = scratch;
        let p = &p[given.start * nx..given.end * nx];
        let rows = &mut rows[..given.len() * columns];
        share(threads, rows, columns, |lane, j, row| self.row_there(&p[j * nx..(j + 1) * nx], row, lane));
        let rows = &*rows;
        let blocks = &mut blocks[..columns.div_ceil(BLOCK) * wanted.len() * BLOCK];
        share(threads, blocks, wanted.len() * BLOCK, |lane, b, block| {
            self.columns_there_and_back(rows, given.clone(), b * BLOCK, wanted.start, block, lane);
        });
        let (blocks, height) = (&*blocks, wanted.len());
        share(threads, &mut u[wanted.start * nx..wanted.end * nx], nx, |lane, j, row| {
            for (b, part) in lane.spectrum.chunks_mut(BLOCK).enumerate() {
                let from = (b * height + j) * BLOCK;
                part.copy_from_slice(&blocks[from..from + part.len()]);
            }
            self.row_back(lane, row);
        });
    }

    fn fit(&self, lane: &mut Lane) {
        let fft = self
            .row_forward
            .get_scratch_len()
            .max(self.row_inverse.get_scratch_len())
            .max(self.column_forward.get_inplace_scratch_len())
            .max(self.column_inverse.get_inplace_scratch_len());
        lane.row.resize(self.length[0], 0.0);
        lane.spectrum.resize(self.length[0] / 2 + 1, ZERO);
        lane.columns.resize(BLOCK * self.length[1], ZERO);
        grow(&mut lane.fft, fft);
    }

    fn row_there(&self, p: &[f64], spectrum: &mut [Complex<f64>], lane: &mut Lane) {
        lane.row[..p.len()].copy_from_slice(p);
        lane.row[p.len()..].fill(0.0);
        let done = self.row_forward.process_with_scratch(&mut lane.row, spectrum, &mut lane.fft);
        debug_assert!(done.is_ok());
    }

    fn columns_there_and_back(
        &self,
        rows: &[Complex<f64>],
        given: Range<usize>,
        first: usize,
        start: usize,
        block: &mut [Complex<f64>],
        lane: &mut Lane,
    ) {
        let (my, columns, half) = (self.length[1], self.length[0] / 2 + 1, self.length[1] / 2 + 1);
        let count = BLOCK.min(columns - first);
        let work = &mut lane.columns[..count * my];
        for column in work.chunks_exact_mut(my) {
            column[..given.start].fill(ZERO);
            column[given.end..].fill(ZERO);
        }
        for j in given.clone() {
            let row = &rows[(j - given.start) * columns + first..][..count];
            for (c, &value) in row.iter().enumerate() {
                work[c * my + j] = value;
            }
        }
        self.column_forward.process_with_scratch(work, &mut lane.fft);
        for (c, column) in work.chunks_exact_mut(my).enumerate() {
            let symbol = &self.symbol[(first + c) * half..(first + c + 1) * half];
            let (low, high) = column.split_at_mut(half);
            for (value, s) in low.iter_mut().zip(symbol) {
                *value *= s;
            }
            for (value, s) in high.iter_mut().zip(symbol[1..].iter().take(my - half).rev()) {
                *value *= s;
            }
        }
        self.column_inverse.process_with_scratch(work, &mut lane.fft);
        for (j, part) in block.chunks_exact_mut(BLOCK).enumerate() {
            for (c, value) in part.iter_mut().enumerate().take(count) {
                *value = work[c * my + start + j];
            }
        }
    }

    fn row_back(&self, lane: &mut Lane, u: &mut [f64]) {
        // Zero up to rounding; the transform wants it exactly.
        lane.spectrum[0].im = 0.0;
        if let (true, Some(last)) = (self.length[0] % 2 == 0, lane.spectrum.last_mut()) {
            last.im = 0.0;
        }
        let done = self.row_inverse.process_with_scratch(&mut lane.spectrum, &mut lane.row, &mut lane.fft);
        debug_assert!(done.is_ok());
        u.copy_from_slice(&lane.row[..u.len()]);
    }
}

fn grow(room: &mut Vec<Complex<f64>>, length: usize) {
    if room.len() < length {
        room.resize(length, ZERO);
    }
}

/// Calls `work` on each chunk of `data`, the chunks shared out among the lanes.
fn share<T: Send>(lanes: &mut [Lane], data: &mut [T], chunk: usize, work: impl Fn(&mut Lane, usize, &mut [T]) + Sync) {
    #[cfg(feature = "parallel")]
    if lanes.len() > 1 {
        let each = data.len().div_ceil(chunk).div_ceil(lanes.len());
        rayon::scope(|scope| {
            for (part, (lane, data)) in lanes.iter_mut().zip(data.chunks_mut(each * chunk)).enumerate() {
                let work = &work;
                scope.spawn(move |_| {
                    for (k, piece) in data.chunks_mut(chunk).enumerate() {
                        work(lane, part * each + k, piece);
                    }
                });
            }
        });
        return;
    }
    if let Some(lane) = lanes.first_mut() {
        for (k, piece) in data.chunks_mut(chunk).enumerate() {
            work(lane, k, piece);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Kernel;

    #[test]
    fn product_is_the_sum() {
        for (shape, h) in [
            ([5, 4], [1.0, 1.0]),
            ([1, 9], [0.5, 2.0]),
            ([7, 1], [1.0, 0.1]),
            ([1, 1], [1.0, 1.0]),
            ([12, 11], [0.2, 0.1]),
        ] {
            let table = InfluenceTable::new(Kernel::Galerkin, h, shape);
            let operator = Operator::compliance(&table, h, shape);
            let n = shape[0] * shape[1];
            let p: Vec<f64> = (0..n).map(|k| ((k * 7919) % 13) as f64 - 3.0).collect();
            let mut u = vec![0.0; n];
            operator.apply(&p, 0..shape[1], &mut u, 0..shape[1], &mut Scratch::new());
            for (k, &uk) in u.iter().enumerate() {
                let sum: f64 = (0..n)
                    .map(|l| {
                        table.get((k % shape[0]).abs_diff(l % shape[0]), (k / shape[0]).abs_diff(l / shape[0])) * p[l]
                    })
                    .sum();
                assert!((uk - sum).abs() < 1e-13 * n as f64, "{shape:?} {k}: {uk} {sum}");
            }
        }
    }

    #[test]
    fn rows_left_out_change_nothing() {
        let (shape, h) = ([9, 14], [1.0, 1.0]);
        let table = InfluenceTable::new(Kernel::Collocation, h, shape);
        let operator = Operator::compliance(&table, h, shape);
        let p: Vec<f64> = (0..126).map(|k| if (36..81).contains(&k) { (k % 5) as f64 } else { 0.0 }).collect();
        let (mut whole, mut part) = (vec![0.0; 126], vec![0.0; 126]);
        let mut scratch = Scratch::new();
        operator.apply(&p, 0..14, &mut whole, 0..14, &mut scratch);
        operator.apply(&p, 4..9, &mut part, 3..12, &mut scratch);
        for k in 27..108 {
            assert!((whole[k] - part[k]).abs() < 1e-13);
        }
        assert_eq!(part[0], 0.0);
    }
}
