//! The transform of one row of a convolution, there and back.
//!
//! Padded with zeros from L to 2L points a cyclic convolution is half a cyclic one plus half a negacyclic one over L points:
//! the even frequencies of the padded transform and the odd ones. Neither meets a zero of the padding (Bowman & Roberts, SIAM J.
//! Sci. Comput. 33 (2011) 386). Of real numbers x_j,
//!
//!   X_2k      is their transform over L points,
//!   X_(4k+1)  the transform over L/2 points of  (x_j - i x_(j+L/2)) w_j,   w_j = exp(-i pi j/L),
//!
//! and the other odd frequencies are conjugates of these. Back, with y and h the transforms of the two,
//!
//!   x_j = y_j + 2 Re (h_j / w_j),   x_(j+L/2) = y_(j+L/2) - 2 Im (h_j / w_j).

use std::sync::Arc;

use realfft::{ComplexToReal, RealToComplex};
use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::real::Real;

/// Transforms of real rows over L points, or over 2L with zeros behind.
#[derive(Clone)]
pub(super) struct Rows<T> {
    length: usize,
    forward: Arc<dyn RealToComplex<T>>,
    inverse: Arc<dyn ComplexToReal<T>>,
    odd: Option<Odd<T>>,
}

/// The odd frequencies of the padded transform.
#[derive(Clone)]
struct Odd<T> {
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
    /// w_j of the module's header.
    twiddles: Vec<Complex<T>>,
}

impl<T: Real> Rows<T> {
    /// Over `length` points, an even number; `split`: over twice as many, the second half zero.
    pub(super) fn new(length: usize, split: bool) -> Self {
        T::with_planners(|real, complex| Self {
            length,
            forward: real.plan_fft_forward(length),
            inverse: real.plan_fft_inverse(length),
            odd: split.then(|| Odd {
                forward: complex.plan_fft_forward(length / 2),
                inverse: complex.plan_fft_inverse(length / 2),
                twiddles: (0..length / 2).map(|j| T::turn(-(j as f64) / length as f64)).collect(),
            }),
        })
    }

    /// Frequencies of a row, in the order in which they stand in a spectrum.
    pub(super) fn frequencies(&self) -> impl Iterator<Item = usize> {
        let (odd, whole) = (self.odd_columns(), 2 * self.length);
        let step = if odd == 0 { 1 } else { 2 };
        (0..=self.length / 2).map(move |k| step * k).chain((0..odd).map(move |k| (4 * k + 1).min(whole - 4 * k - 1)))
    }

    fn odd_columns(&self) -> usize {
        self.odd.as_ref().map_or(0, |odd| odd.twiddles.len())
    }

    /// Numbers of a spectrum.
    pub(super) fn columns(&self) -> usize {
        self.length / 2 + 1 + self.odd_columns()
    }

    /// Room that [`Self::there`] and [`Self::back`] need: points of a row, and scratch.
    pub(super) fn room(&self) -> [usize; 2] {
        let odd = self
            .odd
            .as_ref()
            .map_or(0, |odd| odd.forward.get_inplace_scratch_len().max(odd.inverse.get_inplace_scratch_len()));
        [self.length, odd.max(self.forward.get_scratch_len()).max(self.inverse.get_scratch_len())]
    }

    /// The spectrum of `x` with zeros behind it.
    pub(super) fn there(&self, x: &[T], spectrum: &mut [Complex<T>], row: &mut [T], fft: &mut [Complex<T>]) {
        row[..x.len()].copy_from_slice(x);
        row[x.len()..].fill(T::of(0.0));
        let (even, spectrum) = spectrum.split_at_mut(self.length / 2 + 1);
        if let Some(odd) = &self.odd {
            let (low, high) = row.split_at(self.length / 2);
            for (((to, a), b), w) in spectrum.iter_mut().zip(low).zip(high).zip(&odd.twiddles) {
                *to = Complex { re: *a * w.re + *b * w.im, im: *a * w.im - *b * w.re };
            }
            odd.forward.process_with_scratch(spectrum, fft);
        }
        let done = self.forward.process_with_scratch(row, even, fft);
        debug_assert!(done.is_ok());
    }

    /// The beginning of the row that has this spectrum, which is lost, times the number of points.
    pub(super) fn back(&self, spectrum: &mut [Complex<T>], x: &mut [T], row: &mut [T], fft: &mut [Complex<T>]) {
        let half = self.length / 2;
        let (even, spectrum) = spectrum.split_at_mut(half + 1);
        // Zero up to rounding; the transform wants it exactly.
        (even[0].im, even[half].im) = (T::of(0.0), T::of(0.0));
        let done = self.inverse.process_with_scratch(even, row, fft);
        debug_assert!(done.is_ok());
        if let Some(odd) = &self.odd {
            odd.inverse.process_with_scratch(spectrum, fft);
            let (low, high) = x.split_at_mut(half.min(x.len()));
            let parts = || spectrum.iter().zip(&odd.twiddles);
            for ((x, y), (h, w)) in low.iter_mut().zip(&*row).zip(parts()) {
                let re = h.re * w.re + h.im * w.im;
                *x = *y + re + re;
            }
            for ((x, y), (h, w)) in high.iter_mut().zip(&row[half..]).zip(parts()) {
                let im = h.im * w.re - h.re * w.im;
                *x = *y - im - im;
            }
        } else {
            x.copy_from_slice(&row[..x.len()]);
        }
    }
}
