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

use std::ops::Range;
use std::sync::Arc;

use realfft::{ComplexToReal, RealToComplex};
use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::lanes::{ASIDE, BLOCK, GROUP, Lane, Room, share, share_rows};
use super::symbol::{Real, Symbol};

/// Numbers in a square of a block, and half its side.
const TILE: usize = BLOCK * BLOCK;
const HALF: usize = BLOCK / 2;

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

impl<T> std::fmt::Debug for Convolution<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Convolution").field("shape", &self.shape).field("length", &self.length).finish_non_exhaustive()
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
