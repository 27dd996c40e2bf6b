//! The convolution of a field over a box of cells with an even kernel by transforms, in either precision.
//!
//! Rows are transformed first, and only those that hold something; then each column, there and back; then the rows that are
//! wanted. Between the passes the numbers of a column lie side by side. The order of every sum is fixed: the number of threads does
//! not change a bit of the result.

use std::ops::Range;

use rustfft::num_complex::Complex;

use super::columns::Columns;
use super::lanes::{GROUP, Lane, Room, share, share_rows};
use super::real::{Real, TILE, apart};
use super::rows::Rows;
use super::symbol::Symbol;

/// The transforms of a convolution, ready to be applied.
#[derive(Clone)]
pub(super) struct Transforms<T> {
    shape: [usize; 2],
    /// Lengths of the transforms that the product stands for.
    length: [usize; 2],
    rows: Rows<T>,
    columns: Columns<T>,
    /// The symbol over the number of points, column by column, as the columns want it.
    symbol: Vec<T>,
}

impl<T> std::fmt::Debug for Transforms<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Transforms").field("shape", &self.shape).field("length", &self.length).finish_non_exhaustive()
    }
}

impl<T: Real> Transforms<T> {
    /// Over `shape` cells.
    pub(super) fn new(shape: [usize; 2], symbol: &Symbol) -> Self {
        let Symbol { length, split, mirrored, ref values } = *symbol;
        let over = [length[0], if mirrored { length[1] / 2 } else { length[1] }];
        let [width, height] = [0, 1].map(|k| if split[k] { over[k] / 2 } else { over[k] });
        let (rows, columns) = (Rows::new(width, split[0]), Columns::new(height, split[1], mirrored));
        let norm = 1.0 / (over[0] as f64 * over[1] as f64);
        let values: Vec<_> = values.chunks_exact(length[1] / 2 + 1).collect();
        let symbol = columns.arrange(rows.frequencies().map(|k| values[k]), norm, rows.columns());
        Self { shape, length, rows, columns, symbol }
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
        let base = given.start.min(wanted.start);
        let (columns, height) = (self.rows.columns(), given.end.max(wanted.end) - base);
        let (width, pitch) = (apart(columns), apart(height));
        let (row_room, column_room) = (self.rows.room(), self.columns.room());
        room.lanes.resize_with(lanes, Lane::default);
        let Room { columns: turned, lanes } = room;
        let turned = turned.of(columns * pitch);

        share_rows(lanes, turned, pitch, given.start - base..given.end - base, |lane, rows, parts, at| {
            let (row, spectra, fft) =
                (lane.row.of(row_room[0]), lane.spectra.of(rows.len() * width), lane.fft.of(row_room[1]));
            for (j, spectrum) in rows.clone().zip(spectra.chunks_exact_mut(width)) {
                self.rows.there(&p[(base + j) * nx..][..nx], &mut spectrum[..columns], row, fft);
            }
            to_columns(spectra, width, parts, at..at + rows.len());
        });
        let size = self.columns.numbers();
        share(lanes, turned, TILE * pitch, |lane, tile, columns| {
            let (both, fft) = (lane.column.of(column_room[0]), lane.fft.of(column_room[1]));
            for (column, symbol) in
                columns.chunks_exact_mut(pitch).zip(self.symbol[tile * TILE * size..].chunks_exact(size))
            {
                self.columns.product(column, symbol, &given, &wanted, base, both, fft);
            }
        });
        let turned = &*turned;
        share(lanes, &mut u[wanted.start * nx..wanted.end * nx], GROUP * nx, |lane, group, rows| {
            let (first, here) = (wanted.start - base + group * GROUP, rows.len() / nx);
            let (row, spectra, fft) =
                (lane.row.of(row_room[0]), lane.spectra.of(here * width), lane.fft.of(row_room[1]));
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
                    Err(_) => to.iter_mut().enumerate().for_each(|(t, to)| *to = from[t * width + k]),
                }
            }
        }
    }
}

/// The way back of [`to_columns`]: the numbers `at` of columns, `pitch` apart, into spectra.
fn to_rows<T: Real>(columns: &[Complex<T>], pitch: usize, at: Range<usize>, spectra: &mut [Complex<T>], width: usize) {
    for (c, columns) in columns.chunks(TILE * pitch).enumerate() {
        for j in (0..at.len()).step_by(TILE) {
            let here = TILE.min(at.len() - j);
            let mut tile = [[Complex::default(); TILE]; TILE];
            for (k, column) in columns.chunks_exact(pitch).take(TILE).enumerate() {
                // There is room behind the last rows, and behind the last columns.
                if let Some(from) = column[at.start + j..].first_chunk::<TILE>() {
                    tile.iter_mut().zip(from).for_each(|(to, from)| to[k] = *from);
                } else {
                    tile.iter_mut().zip(&column[at.start + j..]).for_each(|(to, from)| to[k] = *from);
                }
            }
            for (t, row) in tile.iter().enumerate().take(here) {
                if let Some(to) = spectra[(j + t) * width + c * TILE..].first_chunk_mut() {
                    *to = *row;
                }
            }
        }
    }
}
