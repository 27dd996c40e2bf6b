//! Room for the passes of a convolution, and their work shared out among threads.

use std::ops::Range;

use rustfft::num_complex::Complex;

use super::symbol::Real;

/// Columns transformed together: their rows then share cache lines.
pub(super) const BLOCK: usize = 8;

/// Rows handed over together: what passes between rows and columns then comes in pieces of several cache lines.
pub(super) const GROUP: usize = 4;

/// Room between columns side by side, in numbers: lengths that are powers of two would share their place in the cache.
pub(super) const ASIDE: usize = 8;

/// Room for the transforms of a [`super::convolution::Convolution`], grown as needed, kept from product to product.
#[derive(Debug)]
pub(super) struct Room<T> {
    /// Blocks of columns; in each, rows of [`BLOCK`] numbers.
    pub(super) blocks: Vec<Complex<T>>,
    pub(super) lanes: Vec<Lane<T>>,
}

/// Room that one thread needs.
#[derive(Debug, Default)]
pub(super) struct Lane<T> {
    pub(super) row: Vec<T>,
    pub(super) spectrum: Vec<Complex<T>>,
    pub(super) columns: Vec<Complex<T>>,
    pub(super) fft: Vec<Complex<T>>,
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

/// Calls `work` for groups of `rows` with their places in all blocks, the groups shared out among the lanes: with the lane, the
/// rows, the parts of the blocks that the lane may write to and where in them the rows begin.
pub(super) fn share_rows<T: Real>(
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
