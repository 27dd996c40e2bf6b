//! The convolution of a field over a box of cells with an even kernel by transforms, in either precision.
//!
//! Rows are transformed first, and only those that hold something; then each column, there and back; then the rows that are
//! wanted. Between the passes the numbers of a column lie side by side. The order of every sum is fixed: the number of threads does
//! not change a bit of the result.

use std::ops::Range;

use rustfft::num_complex::Complex;

use super::columns::Columns;
use super::lanes::{GROUP, Lane, Room, TILE, apart, share, share_rows};
use super::rows::Rows;
use super::symbol::{Real, Symbol};

/// A convolution, ready to be applied.
#[derive(Clone)]
pub(super) struct Convolution<T> {
    shape: [usize; 2],
    /// Lengths of the transforms that the product stands for.
    length: [usize; 2],
    rows: Rows<T>,
    columns: Columns<T>,
    /// The symbol over the number of points, column by column, as the columns want it.
    symbol: Vec<T>,
}

impl<T> std::fmt::Debug for Convolution<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Convolution").field("shape", &self.shape).field("length", &self.length).finish_non_exhaustive()
    }
}

impl<T: Real> Convolution<T> {
    /// Over `shape` cells.
    pub(super) fn new(shape: [usize; 2], symbol: &Symbol) -> Self {
        let Symbol { length, padded, mirrored, ref values } = *symbol;
        let [over_x, over_y] = [length[0], if mirrored { length[1] / 2 } else { length[1] }];
        let parts = if padded { 2 } else { 1 };
        let (rows, columns) = (Rows::new(over_x / parts, padded), Columns::new(over_y / parts, padded, mirrored));
        let norm = 1.0 / (over_x as f64 * over_y as f64);
        let height = length[1] / 2 + 1;
        let mut arranged = Vec::with_capacity(rows.columns() * columns.numbers());
        for k in rows.frequencies() {
            columns.arrange(&values[k * height..(k + 1) * height], norm, &mut arranged);
        }
        Self { shape, length, rows, columns, symbol: arranged }
    }

    /// Number of cells along x and y.
    pub(super) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Lengths of the transforms that the product stands for.
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
        if given.is_empty() || wanted.is_empty() {
            u[wanted.start * nx..wanted.end * nx].fill(T::of(0.0));
            return;
        }
        let columns = self.rows.columns();
        let (width, pitch) = (apart(columns), apart(self.columns.height()));
        room.lanes.resize_with(lanes, Lane::default);
        let Room { columns: turned, lanes } = room;
        let turned = turned.of(columns * pitch);

        share_rows(lanes, turned, pitch, given.clone(), |lane, rows, parts, at| {
            let Lane { row, spectra, fft, .. } = lane;
            let spectra = spectra.of(rows.len() * width);
            for (j, spectrum) in rows.clone().zip(spectra.chunks_exact_mut(width)) {
                self.rows.there(&p[j * nx..][..nx], &mut spectrum[..columns], row, fft);
            }
            to_columns(spectra, width, parts, at..at + rows.len());
        });
        let size = self.columns.numbers();
        share(lanes, turned, pitch, |lane, k, column| {
            let symbol = &self.symbol[k * size..(k + 1) * size];
            self.columns.product(column, symbol, &given, &wanted, &mut lane.column, &mut lane.fft);
        });
        let turned = &*turned;
        share(lanes, &mut u[wanted.start * nx..wanted.end * nx], GROUP * nx, |lane, group, rows| {
            let Lane { row, spectra, fft, .. } = lane;
            let (first, here) = (wanted.start + group * GROUP, rows.len() / nx);
            let spectra = spectra.of(here * width);
            to_rows(turned, pitch, first..first + here, spectra, width);
            for (u, spectrum) in rows.chunks_exact_mut(nx).zip(spectra.chunks_exact_mut(width)) {
                self.rows.back(&mut spectrum[..columns], u, row, fft);
            }
        });
    }
}

/// Spectra, `width` apart, into the numbers `at` of the columns: by tiles, which stay in the nearest cache.
fn to_columns<T: Real>(spectra: &[Complex<T>], width: usize, columns: &mut [&mut [Complex<T>]], at: Range<usize>) {
    for (c, columns) in columns.chunks_mut(TILE).enumerate() {
        for j in (0..at.len()).step_by(TILE) {
            let rows = at.start + j..at.end.min(at.start + j + TILE);
            let from = &spectra[j * width + c * TILE..];
            for (k, column) in columns.iter_mut().enumerate() {
                let to = &mut column[rows.clone()];
                match <&mut [_; TILE]>::try_from(&mut *to) {
                    Ok(to) => *to = std::array::from_fn(|t| from[t * width + k]),
                    Err(_) => to.iter_mut().zip(from[k..].iter().step_by(width)).for_each(|(to, from)| *to = *from),
                }
            }
        }
    }
}

/// The way back of [`to_columns`]: the numbers `at` of columns, `pitch` apart, into spectra.
fn to_rows<T: Real>(columns: &[Complex<T>], pitch: usize, at: Range<usize>, spectra: &mut [Complex<T>], width: usize) {
    for (c, columns) in columns.chunks(TILE * pitch).enumerate() {
        for j in (0..at.len()).step_by(TILE) {
            let rows = at.start + j..at.end.min(at.start + j + TILE);
            let mut tile = [Complex::default(); TILE * TILE];
            for (k, column) in columns.chunks_exact(pitch).enumerate() {
                let to = tile[k..].iter_mut().step_by(TILE);
                to.zip(&column[rows.clone()]).for_each(|(to, from)| *to = *from);
            }
            // The last columns may be fewer; there is room behind them.
            for (spectrum, row) in
                spectra[j * width..].chunks_exact_mut(width).zip(tile.chunks_exact(TILE)).take(rows.len())
            {
                spectrum[c * TILE..][..TILE].copy_from_slice(row);
            }
        }
    }
}
