//! The transforms of a convolution with an even kernel over a box of cells, in either precision.
//!
//! Rows are transformed first, and only those that hold something; then blocks of columns, there and back; then the rows
//! that are wanted. Between the passes a block of columns lies in one piece, so that every pass reads or writes whole cache
//! lines. The order of every sum is fixed: the number of threads does not change a bit of the result.
//!
//! A field with a mirror at the lower edge of its rows is held by its upper half. With x_j even about j = -1/2 and
//! S_l the symbol over 2K points, the product is diagonal in the cosine transform of K points (DCT-II), which is a
//! transform of K points of v_j = x_2j, v_(K-1-j) = x_(2j+1) (Makhoul, IEEE Trans. ASSP 28 (1980) 27). In terms of V
//!
//!   V'_l = s_l V_l + d_l t_l V_(K-l),   s, d = (S_l +- S_(K-l))/2,   t_l = exp(i pi l/K):
//!
//! half the rows, columns of half the length.

use std::cell::RefCell;
use std::ops::{Mul, MulAssign, Range};
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};

/// Columns transformed together: their rows then share cache lines.
pub(super) const BLOCK: usize = 8;

/// Numbers in a square of a block, and half its side.
const TILE: usize = BLOCK * BLOCK;
const HALF: usize = BLOCK / 2;

/// Rows handed over together: what passes between rows and columns then comes in pieces of several cache lines.
const GROUP: usize = 4;

/// Room between columns side by side, in numbers: lengths that are powers of two would share their place in the cache.
const ASIDE: usize = 8;

/// A precision to compute in.
pub(super) trait Real: FftNum + Mul<Output = Self> + MulAssign + Default {
    /// Calls with the planners of this thread. Twiddle factors outlive an operator: small problems would spend most of
    /// their time on them.
    fn with_planners<R>(work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R;

    /// The nearest number of this precision.
    fn of(value: f64) -> Self;
}

type Planners<T> = RefCell<(RealFftPlanner<T>, FftPlanner<T>)>;

thread_local! {
    static DOUBLE: Planners<f64> = RefCell::new((RealFftPlanner::new(), FftPlanner::new()));
    static SINGLE: Planners<f32> = RefCell::new((RealFftPlanner::new(), FftPlanner::new()));
}

impl Real for f64 {
    fn with_planners<R>(work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R {
        DOUBLE.with_borrow_mut(|(real, complex)| work(real, complex))
    }

    fn of(value: f64) -> Self {
        value
    }
}

impl Real for f32 {
    fn with_planners<R>(work: impl FnOnce(&mut RealFftPlanner<Self>, &mut FftPlanner<Self>) -> R) -> R {
        SINGLE.with_borrow_mut(|(real, complex)| work(real, complex))
    }

    fn of(value: f64) -> Self {
        value as Self
    }
}

/// The transform of an even kernel: real and even, so a quarter of it. Column k holds its rows next to each other.
pub(super) struct Symbol {
    /// Lengths of the whole transform.
    pub(super) length: [usize; 2],
    pub(super) values: Vec<f64>,
}

impl Symbol {
    /// The transform of the kernel whose row j, offsets i = 0..=length_x/2, is what `fill` puts in place of zeros.
    pub(super) fn of(length: [usize; 2], fill: impl Fn(usize, &mut [f64])) -> Self {
        let [mx, my] = length;
        let zero = Complex::default();
        let (along, across) =
            f64::with_planners(|real, complex| (real.plan_fft_forward(mx), complex.plan_fft_forward(my)));
        let (columns, half) = (mx / 2 + 1, my / 2 + 1);
        // Rows of the kernel, extended evenly: their transforms are real.
        let mut rows = vec![0.0; half * columns];
        let (mut row, mut spectrum) = (vec![0.0; mx], vec![zero; columns]);
        let mut scratch = vec![zero; along.get_scratch_len().max(across.get_inplace_scratch_len())];
        for j in 0..half {
            row.fill(0.0);
            fill(j, &mut row[..columns]);
            for i in columns..mx {
                row[i] = row[mx - i];
            }
            if row[0] != 0.0 {
                let done = along.process_with_scratch(&mut row, &mut spectrum, &mut scratch);
                debug_assert!(done.is_ok());
                for (to, from) in rows[j * columns..].iter_mut().zip(&spectrum) {
                    *to = from.re;
                }
            }
        }
        // Two real even columns make one complex transform.
        let mut values = vec![0.0; columns * half];
        let mut work = vec![zero; BLOCK * (my + ASIDE)];
        for first in (0..columns).step_by(2 * BLOCK) {
            let pairs = (columns - first).div_ceil(2).min(BLOCK);
            for j in 0..half {
                let row = &rows[j * columns..(j + 1) * columns][first..];
                for (pair, column) in row.chunks(2).zip(work.chunks_exact_mut(my + ASIDE)) {
                    let value = Complex { re: pair[0], im: pair.get(1).copied().unwrap_or(0.0) };
                    column[j] = value;
                    column[(my - j) % my] = value;
                }
            }
            for (c, column) in work.chunks_exact_mut(my + ASIDE).enumerate().take(pairs) {
                across.process_with_scratch(&mut column[..my], &mut scratch);
                let k = first + 2 * c;
                for (l, value) in column[..half].iter().enumerate() {
                    values[k * half + l] = value.re;
                    if k + 1 < columns {
                        values[(k + 1) * half + l] = value.im;
                    }
                }
            }
        }
        Self { length, values }
    }

    /// The largest magnitude: the 2-norm of the convolution, or a bound of it.
    pub(super) fn norm(&self) -> f64 {
        self.values.iter().fold(0.0, |m: f64, s| m.max(s.abs()))
    }
}

/// A convolution, ready to be applied.
#[derive(Clone)]
pub(super) struct Convolution<T> {
    shape: [usize; 2],
    /// Lengths of the transforms that are done.
    length: [usize; 2],
    /// The symbol over the product of the lengths, column by column: S_l, or s_l and d_l in pairs where there is a mirror.
    symbol: Vec<T>,
    /// t_l of the module's header; empty without a mirror.
    turns: Vec<Complex<T>>,
    row_forward: Arc<dyn RealToComplex<T>>,
    row_inverse: Arc<dyn ComplexToReal<T>>,
    column_forward: Arc<dyn Fft<T>>,
    column_inverse: Arc<dyn Fft<T>>,
}

/// Room for the transforms of a [`Convolution`], grown as needed, kept from product to product.
#[derive(Debug)]
pub(super) struct Room<T> {
    /// Blocks of columns; in each, rows of [`BLOCK`] numbers.
    blocks: Vec<Complex<T>>,
    lanes: Vec<Lane<T>>,
}

/// Room that one thread needs.
#[derive(Debug, Default)]
struct Lane<T> {
    row: Vec<T>,
    spectrum: Vec<Complex<T>>,
    columns: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

impl<T> Default for Room<T> {
    fn default() -> Self {
        Self { blocks: Vec::new(), lanes: Vec::new() }
    }
}

impl<T> Room<T> {
    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Complex<T>>() * self.blocks.capacity()
    }
}

impl<T: Real> Convolution<T> {
    /// Over `shape` cells; `mirrored`: these are the upper half of twice as many rows.
    pub(super) fn new(shape: [usize; 2], symbol: &Symbol, mirrored: bool) -> Self {
        let [mx, full] = symbol.length;
        let my = if mirrored { full / 2 } else { full };
        let (row_forward, row_inverse, column_forward, column_inverse) = T::with_planners(|real, complex| {
            (
                real.plan_fft_forward(mx),
                real.plan_fft_inverse(mx),
                complex.plan_fft_forward(my),
                complex.plan_fft_inverse(my),
            )
        });
        let norm = 1.0 / (mx as f64 * my as f64);
        let mut turns = Vec::new();
        let values = if mirrored {
            let turn = std::f64::consts::PI / my as f64;
            turns.extend((0..=my / 2).map(|l| {
                let (sin, cos) = (turn * l as f64).sin_cos();
                Complex { re: T::of(cos), im: T::of(sin) }
            }));
            let mut pairs = Vec::with_capacity((mx / 2 + 1) * 2 * (my / 2 + 1));
            for column in symbol.values.chunks_exact(my + 1) {
                pairs.extend([T::of(norm * column[0]), T::of(0.0)]);
                for (a, b) in column[1..=my / 2].iter().zip(column[..my].iter().rev()) {
                    pairs.extend([T::of(0.5 * norm * (a + b)), T::of(0.5 * norm * (a - b))]);
                }
            }
            pairs
        } else {
            symbol.values.iter().map(|s| T::of(norm * s)).collect()
        };
        Self {
            shape,
            length: [mx, my],
            symbol: values,
            turns,
            row_forward,
            row_inverse,
            column_forward,
            column_inverse,
        }
    }

    /// Number of cells along x and y.
    pub(super) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Lengths of the transforms.
    pub(super) fn length(&self) -> [usize; 2] {
        self.length
    }

    /// Writes the rows `wanted` of K * p to `u`; the rest of `u` is left as it is. Only the rows `given` of `p` are read:
    /// the others must be zero. Fields have the shape of the convolution, x fastest.
    pub(super) fn apply(
        &self,
        p: &[T],
        given: Range<usize>,
        u: &mut [T],
        wanted: Range<usize>,
        room: &mut Room<T>,
        lanes: usize,
    ) {
        let nx = self.shape[0];
        let columns = self.length[0] / 2 + 1;
        if given.is_empty() || wanted.is_empty() {
            u[wanted.start * nx..wanted.end * nx].fill(T::of(0.0));
            return;
        }
        room.lanes.resize_with(lanes, Lane::default);
        for lane in &mut room.lanes {
            self.fit(lane);
        }
        let base = given.start.min(wanted.start);
        // One row more than there are: blocks must not lie a power of two apart.
        let pitch = BLOCK * (given.end.max(wanted.end) - base + 1);
        let size = columns.div_ceil(BLOCK) * pitch;
        if room.blocks.len() < size {
            room.blocks.resize(size, Complex::default());
        }
        let Room { blocks, lanes } = room;
        let blocks = &mut blocks[..size];

        share_rows(lanes, blocks, pitch, given.start - base..given.end - base, |lane, rows, parts, at| {
            let Lane { row, spectrum, fft, .. } = lane;
            for (j, spectrum) in rows.clone().zip(spectrum.chunks_exact_mut(columns)) {
                row[..nx].copy_from_slice(&p[(base + j) * nx..][..nx]);
                row[nx..].fill(T::of(0.0));
                let done = self.row_forward.process_with_scratch(row, spectrum, fft);
                debug_assert!(done.is_ok());
            }
            for (b, part) in parts.iter_mut().enumerate() {
                let count = BLOCK.min(columns - b * BLOCK);
                let pieces = part[at..].chunks_exact_mut(BLOCK).take(rows.len());
                for (piece, spectrum) in pieces.zip(spectrum.chunks_exact(columns)) {
                    piece[..count].copy_from_slice(&spectrum[b * BLOCK..][..count]);
                }
            }
        });
        share(lanes, blocks, pitch, |lane, b, block| {
            let count = BLOCK.min(columns - b * BLOCK);
            self.columns_there_and_back(block, b * BLOCK, count, &given, &wanted, base, lane);
        });
        let blocks = &*blocks;
        share(lanes, &mut u[wanted.start * nx..wanted.end * nx], GROUP * nx, |lane, group, rows| {
            let Lane { row, spectrum, fft, .. } = lane;
            let (at, here) = ((wanted.start + group * GROUP - base) * BLOCK, rows.len() / nx);
            for (b, block) in blocks.chunks_exact(pitch).enumerate() {
                let count = BLOCK.min(columns - b * BLOCK);
                let pieces = block[at..].chunks_exact(BLOCK).take(here);
                for (piece, spectrum) in pieces.zip(spectrum.chunks_exact_mut(columns)) {
                    spectrum[b * BLOCK..][..count].copy_from_slice(&piece[..count]);
                }
            }
            for (u, spectrum) in rows.chunks_exact_mut(nx).zip(spectrum.chunks_exact_mut(columns)) {
                self.row_back(row, spectrum, fft, u);
            }
        });
    }

    fn fit(&self, lane: &mut Lane<T>) {
        let fft = self
            .row_forward
            .get_scratch_len()
            .max(self.row_inverse.get_scratch_len())
            .max(self.column_forward.get_inplace_scratch_len())
            .max(self.column_inverse.get_inplace_scratch_len());
        lane.row.resize(self.length[0], T::of(0.0));
        lane.spectrum.resize(GROUP * (self.length[0] / 2 + 1), Complex::default());
        lane.columns.resize(BLOCK * (self.length[1] + ASIDE), Complex::default());
        if lane.fft.len() < fft {
            lane.fft.resize(fft, Complex::default());
        }
    }

    /// Where row j stands in a column that is transformed.
    fn place(&self, j: usize) -> usize {
        match (self.turns.is_empty(), j.is_multiple_of(2)) {
            (true, _) => j,
            (false, true) => j / 2,
            (false, false) => self.length[1] - 1 - j / 2,
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one pass")]
    fn columns_there_and_back(
        &self,
        block: &mut [Complex<T>],
        first: usize,
        count: usize,
        given: &Range<usize>,
        wanted: &Range<usize>,
        base: usize,
        lane: &mut Lane<T>,
    ) {
        let (my, zero) = (self.length[1], Complex::default());
        let pitch = my + ASIDE;
        let work = &mut lane.columns[..];
        for column in work.chunks_exact_mut(pitch).take(count) {
            if self.turns.is_empty() {
                column[..given.start].fill(zero);
                column[given.end..].fill(zero);
            } else {
                column[..given.start.div_ceil(2)].fill(zero);
                column[given.end.div_ceil(2)..my - given.end / 2].fill(zero);
                column[my - given.start / 2..].fill(zero);
            }
        }
        let from = &block[(given.start - base) * BLOCK..(given.end - base) * BLOCK];
        self.gather_columns(from, given.start, work);
        let size = self.symbol.len() / (self.length[0] / 2 + 1);
        for (c, column) in work.chunks_exact_mut(pitch).enumerate().take(count) {
            let column = &mut column[..my];
            self.column_forward.process_with_scratch(column, &mut lane.fft);
            self.multiply(column, &self.symbol[(first + c) * size..(first + c + 1) * size]);
            self.column_inverse.process_with_scratch(column, &mut lane.fft);
        }
        let to = &mut block[(wanted.start - base) * BLOCK..(wanted.end - base) * BLOCK];
        self.scatter_rows(work, wanted.start, to);
    }

    /// Rows of a block, from row `first` on, into columns side by side: by tiles, which stay in the nearest cache.
    fn gather_columns(&self, mut rows: &[Complex<T>], first: usize, columns: &mut [Complex<T>]) {
        let (my, mut j) = (self.length[1], first);
        let pitch = my + ASIDE;
        let mirrored = !self.turns.is_empty();
        while !rows.is_empty() {
            match rows.split_first_chunk::<TILE>() {
                Some((tile, rest)) if !mirrored => {
                    for (c, column) in columns.chunks_exact_mut(pitch).enumerate() {
                        if let Some(to) = column[j..].first_chunk_mut::<BLOCK>() {
                            *to = std::array::from_fn(|t| tile[t * BLOCK + c]);
                        }
                    }
                    (rows, j) = (rest, j + BLOCK);
                }
                Some((tile, rest)) if j.is_multiple_of(2) => {
                    for (c, column) in columns.chunks_exact_mut(pitch).enumerate() {
                        if let Some(to) = column[j / 2..].first_chunk_mut::<HALF>() {
                            *to = std::array::from_fn(|t| tile[2 * t * BLOCK + c]);
                        }
                        if let Some(to) = column[..my - j / 2].last_chunk_mut::<HALF>() {
                            *to = std::array::from_fn(|t| tile[(2 * (HALF - t) - 1) * BLOCK + c]);
                        }
                    }
                    (rows, j) = (rest, j + BLOCK);
                }
                _ => {
                    let place = self.place(j);
                    columns.chunks_exact_mut(pitch).zip(rows).for_each(|(column, value)| column[place] = *value);
                    (rows, j) = (&rows[BLOCK..], j + 1);
                }
            }
        }
    }

    /// The way back of [`Self::gather_columns`].
    fn scatter_rows(&self, columns: &[Complex<T>], first: usize, mut rows: &mut [Complex<T>]) {
        let (my, mut j) = (self.length[1], first);
        let columns = || columns.chunks_exact(my + ASIDE).enumerate();
        let mirrored = !self.turns.is_empty();
        while !rows.is_empty() {
            let whole = rows.len() >= TILE && (!mirrored || j.is_multiple_of(2));
            let (tile, rest) = rows.split_at_mut(if whole { TILE } else { BLOCK });
            let here = tile.len() / BLOCK;
            match tile.first_chunk_mut::<TILE>() {
                Some(tile) if !mirrored => {
                    for (c, column) in columns() {
                        if let Some(from) = column[j..].first_chunk::<BLOCK>() {
                            from.iter().enumerate().for_each(|(t, value)| tile[t * BLOCK + c] = *value);
                        }
                    }
                }
                Some(tile) => {
                    for (c, column) in columns() {
                        let low = column[j / 2..].first_chunk::<HALF>();
                        if let (Some(low), Some(high)) = (low, column[..my - j / 2].last_chunk::<HALF>()) {
                            for t in 0..HALF {
                                tile[2 * t * BLOCK + c] = low[t];
                                tile[(2 * (HALF - t) - 1) * BLOCK + c] = high[t];
                            }
                        }
                    }
                }
                None => {
                    let place = self.place(j);
                    tile.iter_mut().zip(columns()).for_each(|(value, (_, column))| *value = column[place]);
                }
            }
            j += here;
            rows = rest;
        }
    }

    /// A transformed column times its symbol.
    fn multiply(&self, column: &mut [Complex<T>], symbol: &[T]) {
        let my = column.len();
        if self.turns.is_empty() {
            let half = my / 2 + 1;
            let (low, high) = column.split_at_mut(half);
            for (value, s) in low.iter_mut().zip(symbol) {
                *value = *value * *s;
            }
            for (value, s) in high.iter_mut().zip(symbol[1..].iter().take(my - half).rev()) {
                *value = *value * *s;
            }
            return;
        }
        // Pairs l, K - l for 0 < l < K/2; 0 and K/2 stand alone.
        let pairs = (my - 1) / 2;
        column[0] = column[0] * symbol[0];
        if my.is_multiple_of(2) {
            column[my / 2] = column[my / 2] * symbol[my];
        }
        let (low, high) = column.split_at_mut(my - pairs);
        let (low, symbol, turns) = (&mut low[1..=pairs], &symbol[2..], &self.turns[1..]);
        for (((a, b), sd), t) in low.iter_mut().zip(high.iter_mut().rev()).zip(symbol.chunks_exact(2)).zip(turns) {
            let (old_a, old_b) = (*a, *b);
            *a = old_a * sd[0] + t * old_b * sd[1];
            *b = old_b * sd[0] + t.conj() * old_a * sd[1];
        }
    }

    fn row_back(&self, row: &mut [T], spectrum: &mut [Complex<T>], fft: &mut [Complex<T>], u: &mut [T]) {
        // Zero up to rounding; the transform wants it exactly.
        spectrum[0].im = T::of(0.0);
        if let (true, Some(last)) = (self.length[0].is_multiple_of(2), spectrum.last_mut()) {
            last.im = T::of(0.0);
        }
        let done = self.row_inverse.process_with_scratch(spectrum, row, fft);
        debug_assert!(done.is_ok());
        u.copy_from_slice(&row[..u.len()]);
    }
}

/// Calls `work` for groups of `rows` with their places in all blocks, the groups shared out among the lanes: with the lane, the
/// rows, the parts of the blocks that the lane may write to and where in them the rows begin.
fn share_rows<T: Real>(
    lanes: &mut [Lane<T>],
    blocks: &mut [Complex<T>],
    pitch: usize,
    rows: Range<usize>,
    work: impl Fn(&mut Lane<T>, Range<usize>, &mut [&mut [Complex<T>]], usize) + Sync,
) {
    #[cfg(feature = "parallel")]
    if lanes.len() > 1 {
        let each = rows.len().div_ceil(lanes.len());
        let mut shares: Vec<Vec<&mut [Complex<T>]>> = lanes.iter().map(|_| Vec::new()).collect();
        for block in blocks.chunks_exact_mut(pitch) {
            let rows = block[rows.start * BLOCK..rows.end * BLOCK].chunks_mut(each * BLOCK);
            shares.iter_mut().zip(rows).for_each(|(share, part)| share.push(part));
        }
        rayon::scope(|scope| {
            for (part, (lane, mut parts)) in lanes.iter_mut().zip(shares).enumerate() {
                let (work, first) = (&work, rows.start + part * each);
                let last = (first + each).min(rows.end);
                scope.spawn(move |_| {
                    for j in (first..last).step_by(GROUP) {
                        work(lane, j..(j + GROUP).min(last), &mut parts, (j - first) * BLOCK);
                    }
                });
            }
        });
        return;
    }
    if let Some(lane) = lanes.first_mut() {
        let mut parts: Vec<&mut [Complex<T>]> = blocks.chunks_exact_mut(pitch).collect();
        for j in rows.clone().step_by(GROUP) {
            work(lane, j..(j + GROUP).min(rows.end), &mut parts, j * BLOCK);
        }
    }
}

/// Calls `work` on each chunk of `data`, the chunks shared out among the lanes.
fn share<T: Send, U: Send>(
    lanes: &mut [Lane<T>],
    data: &mut [U],
    chunk: usize,
    work: impl Fn(&mut Lane<T>, usize, &mut [U]) + Sync,
) {
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
