//! The transform of an even kernel.

use rustfft::num_complex::Complex;

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
    pub(super) fn of(length: [usize; 2], fill: impl Fn(usize, &mut [f64])) -> Self {
        let [mx, my] = length;
        let zero = Complex::default();
        let along = f64::with_planners(mx, |real, _| real.plan_fft_forward(mx));
        let across = f64::with_planners(my, |_, complex| complex.plan_fft_forward(my));
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
        let mut work = vec![zero; PAIRS * my];
        for first in (0..columns).step_by(2 * PAIRS) {
            let pairs = (columns - first).div_ceil(2).min(PAIRS);
            for j in 0..half {
                let row = &rows[j * columns..(j + 1) * columns][first..];
                for (pair, column) in row.chunks(2).zip(work.chunks_exact_mut(my)) {
                    let value = Complex { re: pair[0], im: pair.get(1).copied().unwrap_or(0.0) };
                    column[j] = value;
                    column[(my - j) % my] = value;
                }
            }
            for (c, column) in work.chunks_exact_mut(my).enumerate().take(pairs) {
                across.process_with_scratch(column, &mut scratch);
                let k = first + 2 * c;
                for (l, value) in column[..half].iter().enumerate() {
                    values[k * half + l] = value.re;
                    if k + 1 < columns {
                        values[(k + 1) * half + l] = value.im;
                    }
                }
            }
        }
        Self { length, mirrored: false, values }
    }

    /// The kernel that has this symbol.
    pub(super) fn kernel(&self) -> Kernel {
        let [mx, my] = self.length;
        let points = (mx * my) as f64;
        let back = Self::of(self.length, |l, row| {
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
