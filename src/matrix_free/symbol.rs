//! The transform of an even kernel.

use rustfft::num_complex::Complex;

use super::lanes::GROUP;
use super::operator::Scratch;
use super::real::Real;

/// Pairs of columns of a symbol that are transformed together: their rows then share cache lines.
const PAIRS: usize = 8;

/// The transform of an even kernel: real and even, so a quarter of it. Column k holds its rows next to each other.
pub(super) struct Symbol {
    /// Lengths of the whole transform.
    pub(super) length: [usize; 2],
    /// The fields have a mirror at the lower edge of their rows and are held by their upper half.
    pub(super) mirrored: bool,
    pub(super) values: Vec<f64>,
}

impl Symbol {
    /// The transform, for fields that are not mirrored, of the kernel whose row j, offsets i = 0..=length_x/2, is what `fill`
    /// puts in place of zeros.
    pub(super) fn of(length: [usize; 2], scratch: &Scratch, fill: impl Fn(usize, &mut [f64]) + Sync + Send) -> Self {
        let [mx, my] = length;
        let zero = Complex::default();
        let along = f64::with_planners(mx, |real, _| real.plan_fft_forward(mx));
        let across = f64::with_planners(my, |_, complex| complex.plan_fft_forward(my));
        let (columns, half) = (mx / 2 + 1, my / 2 + 1);
        // Rows of the kernel, extended evenly: their transforms are real.
        let mut rows = vec![0.0; half * columns];
        scratch.each(rows.chunks_mut(GROUP * columns).enumerate(), |(group, rows)| {
            let (mut row, mut spectrum) = (vec![0.0; mx], vec![zero; columns]);
            let mut room = vec![zero; along.get_scratch_len()];
            for (j, to) in rows.chunks_exact_mut(columns).enumerate() {
                row.fill(0.0);
                fill(group * GROUP + j, &mut row[..columns]);
                for i in columns..mx {
                    row[i] = row[mx - i];
                }
                if row[0] != 0.0 {
                    let done = along.process_with_scratch(&mut row, &mut spectrum, &mut room);
                    debug_assert!(done.is_ok());
                    for (to, from) in to.iter_mut().zip(&spectrum) {
                        *to = from.re;
                    }
                }
            }
        });
        // Two real even columns make one complex transform.
        let mut values = vec![0.0; columns * half];
        scratch.each(values.chunks_mut(2 * PAIRS * half).enumerate(), |(group, values)| {
            let first = 2 * PAIRS * group;
            let mut work = vec![zero; (values.len() / half).div_ceil(2) * my];
            let mut room = vec![zero; across.get_inplace_scratch_len()];
            for (j, row) in rows.chunks_exact(columns).enumerate() {
                for (pair, column) in row[first..].chunks(2).zip(work.chunks_exact_mut(my)) {
                    let value = Complex { re: pair[0], im: pair.get(1).copied().unwrap_or(0.0) };
                    column[j] = value;
                    column[(my - j) % my] = value;
                }
            }
            for (column, pair) in work.chunks_exact_mut(my).zip(values.chunks_mut(2 * half)) {
                across.process_with_scratch(column, &mut room);
                let (first, second) = pair.split_at_mut(half);
                first.iter_mut().zip(&*column).for_each(|(to, from)| *to = from.re);
                second.iter_mut().zip(&*column).for_each(|(to, from)| *to = from.im);
            }
        });
        Self { length, mirrored: false, values }
    }

    /// The kernel that has this symbol.
    pub(super) fn kernel(&self) -> Kernel {
        let [mx, my] = self.length;
        let points = (mx * my) as f64;
        let back = Self::of(self.length, &Scratch::new(), |l, row| {
            for (to, from) in row.iter_mut().zip(self.values.iter().skip(l).step_by(my / 2 + 1)) {
                *to = from / points;
            }
        });
        Kernel(back)
    }

    /// The largest magnitude: the 2-norm of the convolution, or a bound of it.
    pub(super) fn norm(&self) -> f64 {
        self.values.iter().fold(0.0, |m: f64, s| m.max(s.abs()))
    }
}

/// An even kernel, over a period in each direction.
pub(super) struct Kernel(Symbol);

impl Kernel {
    /// At these offsets, less than a period.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        let [mx, my] = self.0.length;
        self.0.values[i.min(mx - i) * (my / 2 + 1) + j.min(my - j)]
    }
}
