//! The convolution of a field over a box of cells with an even kernel by transforms, in either precision.
//!
//! Rows are transformed first, and only those that hold something; then each column, there and back; then the rows that are
//! wanted. Between the passes the numbers of a column lie side by side. The order of every sum is fixed: the number of threads does
//! not change a bit of the result.

use std::ops::Range;
use std::sync::Arc;

use realfft::{ComplexToReal, RealToComplex};

use super::columns::Columns;
use super::lanes::{GROUP, Lane, Workspace, first, share, share_rows};
use super::real::Real;
use super::symbol::Symbol;

/// The transforms of a convolution, ready to be applied.
#[derive(Clone)]
pub(super) struct Transforms<T> {
    shape: [usize; 2],
    /// Lengths of the transforms that the product stands for.
    length: [usize; 2],
    forward: Arc<dyn RealToComplex<T>>,
    inverse: Arc<dyn ComplexToReal<T>>,
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
        let Symbol { length, mirrored, ref values } = *symbol;
        let [width, height] = [length[0], if mirrored { length[1] / 2 } else { length[1] }];
        let (forward, inverse) =
            T::with_planners(width, |real, _| (real.plan_fft_forward(width), real.plan_fft_inverse(width)));
        let columns = Columns::new(height, mirrored);
        let values: Vec<_> = values.chunks_exact(length[1] / 2 + 1).collect();
        let symbol = columns.arrange(&values, 1.0 / (width as f64 * height as f64));
        Self { shape, length, forward, inverse, columns, symbol }
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
        room: &mut Workspace<T>,
        lanes: usize,
    ) {
        let nx = self.shape[0];
        if given.is_empty() || wanted.is_empty() {
            u[wanted.start * nx..wanted.end * nx].fill(T::of(0.0));
            return;
        }
        let base = given.start.min(wanted.start);
        let (points, width) = (self.length[0], self.length[0] / 2 + 1);
        // Columns whose length is a power of two would share their place in the cache.
        let pitch = (given.end.max(wanted.end) - base) | 1;
        let row_fft = self.forward.get_scratch_len().max(self.inverse.get_scratch_len());
        let [column_points, column_fft] = self.columns.room();
        room.lanes.resize_with(lanes, Lane::default);
        let Workspace { columns: turned, lanes, .. } = room;
        let turned = first(turned, width * pitch);

        share_rows(lanes, turned, pitch, given.start - base..given.end - base, |lane, rows, parts, at| {
            let (row, spectra, fft) = lane.room(points, rows.len() * width, row_fft);
            for (j, spectrum) in rows.clone().zip(spectra.chunks_exact_mut(width)) {
                row[..nx].copy_from_slice(&p[(base + j) * nx..][..nx]);
                row[nx..].fill(T::of(0.0));
                let done = self.forward.process_with_scratch(row, spectrum, fft);
                debug_assert!(done.is_ok());
            }
            for (k, column) in parts.iter_mut().enumerate() {
                for (t, to) in column[at..at + rows.len()].iter_mut().enumerate() {
                    *to = spectra[t * width + k];
                }
            }
        });
        let size = self.columns.numbers();
        share(lanes, turned, pitch, |lane, k, column| {
            let (_, both, fft) = lane.room(0, column_points, column_fft);
            self.columns.product(column, &self.symbol[k * size..(k + 1) * size], [&given, &wanted], both, fft);
        });
        let turned = &*turned;
        share(lanes, &mut u[wanted.start * nx..wanted.end * nx], GROUP * nx, |lane, group, rows| {
            let (at, count) = (wanted.start - base + group * GROUP, rows.len() / nx);
            let (row, spectra, fft) = lane.room(points, count * width, row_fft);
            for (k, column) in turned.chunks_exact(pitch).enumerate() {
                for (t, from) in column[at..at + count].iter().enumerate() {
                    spectra[t * width + k] = *from;
                }
            }
            for (u, spectrum) in rows.chunks_exact_mut(nx).zip(spectra.chunks_exact_mut(width)) {
                // Zero up to rounding; the transform wants it exactly.
                (spectrum[0].im, spectrum[width - 1].im) = (T::of(0.0), T::of(0.0));
                let done = self.inverse.process_with_scratch(spectrum, row, fft);
                debug_assert!(done.is_ok());
                u.copy_from_slice(&row[..nx]);
            }
        });
    }
}
