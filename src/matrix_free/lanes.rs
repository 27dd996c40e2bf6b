//! Workspace for the passes of a convolution, and their work shared out among threads.

use std::ops::Range;

use rustfft::num_complex::Complex;

use super::real::Real;

/// Rows handed over together: what passes between rows and columns then comes in pieces of several cache lines.
pub(super) const GROUP: usize = 32;

/// The first n of some numbers, with what was left in them; grown as needed.
pub(super) fn first<T: Copy + Default>(numbers: &mut Vec<T>, n: usize) -> &mut [T] {
    if numbers.len() < n {
        numbers.resize(n, T::default());
    }
    &mut numbers[..n]
}

/// Workspace for the transforms of a [`super::transforms::Transforms`], grown as needed, kept from product to product.
#[derive(Debug, Default)]
pub(super) struct Workspace<T> {
    /// The columns between the passes.
    pub(super) columns: Vec<Complex<T>>,
    /// Far points, and their displacements spread out along the rows.
    pub(super) points: Vec<T>,
    pub(super) spread: Vec<T>,
    pub(super) lanes: Vec<Lane<T>>,
}

/// Workspace that one thread needs.
#[derive(Debug, Default)]
pub(super) struct Lane<T> {
    row: Vec<T>,
    /// Spectra of a group of rows, or a column.
    spectra: Vec<Complex<T>>,
    fft: Vec<Complex<T>>,
}

impl<T: Real> Lane<T> {
    /// Room for a row, with what was left in it.
    pub(super) fn row(&mut self, row: usize) -> &mut [T] {
        first(&mut self.row, row)
    }

    /// Room for a row, spectra and the scratch of their transforms, with what was left in it.
    pub(super) fn room(
        &mut self,
        row: usize,
        spectra: usize,
        fft: usize,
    ) -> (&mut [T], &mut [Complex<T>], &mut [Complex<T>]) {
        (first(&mut self.row, row), first(&mut self.spectra, spectra), first(&mut self.fft, fft))
    }
}

impl<T> Workspace<T> {
    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Complex<T>>() * self.columns.capacity()
            + size_of::<T>() * (self.points.capacity() + self.spread.capacity())
    }
}

/// Calls `work` for groups of `rows` with their places in all columns, `pitch` apart, the groups shared out among the lanes: with the
/// lane, the rows, the parts of the columns that the lane may write to and where in them the rows begin.
pub(super) fn share_rows<T: Real>(
    lanes: &mut [Lane<T>],
    columns: &mut [Complex<T>],
    pitch: usize,
    rows: Range<usize>,
    work: impl Fn(&mut Lane<T>, Range<usize>, &mut [&mut [Complex<T>]], usize) + Sync,
) {
    #[cfg(feature = "parallel")]
    if lanes.len() > 1 {
        let each = rows.len().div_ceil(lanes.len());
        let mut shares: Vec<Vec<&mut [Complex<T>]>> = lanes.iter().map(|_| Vec::new()).collect();
        for column in columns.chunks_exact_mut(pitch) {
            let rows = column[rows.clone()].chunks_mut(each);
            shares.iter_mut().zip(rows).for_each(|(share, part)| share.push(part));
        }
        rayon::scope(|scope| {
            for (part, (lane, mut parts)) in lanes.iter_mut().zip(shares).enumerate() {
                let (work, first) = (&work, rows.start + part * each);
                let last = (first + each).min(rows.end);
                scope.spawn(move |_| {
                    for j in (first..last).step_by(GROUP) {
                        work(lane, j..(j + GROUP).min(last), &mut parts, j - first);
                    }
                });
            }
        });
        return;
    }
    if let Some(lane) = lanes.first_mut() {
        let mut parts: Vec<&mut [Complex<T>]> = columns.chunks_exact_mut(pitch).collect();
        for j in rows.clone().step_by(GROUP) {
            work(lane, j..(j + GROUP).min(rows.end), &mut parts, j);
        }
    }
}

/// Calls `work` on each chunk of `data`, the chunks shared out among the lanes.
pub(super) fn share<T: Send, U: Send>(
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
