//! One column of a convolution: its transform, times the symbol, and back.
//!
//! Where the column has a mirror at its lower end and its upper half stands for both, x_j is even about j = -1/2. With S_l
//! the symbol over 2K points, the product is diagonal in the cosine transform of K points (DCT-II), which is a transform of
//! K points of v_j = x_2j, v_(K-1-j) = x_(2j+1) (Makhoul, IEEE Trans. ASSP 28 (1980) 27). In terms of V
//!
//!   V'_l = s_l V_l + c_l V_(K-l),   s_l = (S_l + S_(K-l))/2,   c_l = (S_l - S_(K-l))/2 exp(i pi l/K),   c_(K-l) = conj c_l:
//!
//! half the rows, columns of half the length.

use std::ops::Range;
use std::sync::Arc;

use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::real::Real;

/// Products of columns with a symbol.
#[derive(Clone)]
pub(super) struct Columns<T> {
    length: usize,
    mirrored: bool,
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
}

impl<T: Real> Columns<T> {
    /// Over `length` points; `mirrored`: the upper half of twice as many rows.
    pub(super) fn new(length: usize, mirrored: bool) -> Self {
        let (forward, inverse) =
            T::with_planners(length, |_, complex| (complex.plan_fft_forward(length), complex.plan_fft_inverse(length)));
        Self { length, mirrored, forward, inverse }
    }

    /// Frequencies that have an image, l and `length` - l.
    fn pairs(&self) -> usize {
        (self.length - 1) / 2
    }

    /// Numbers of the symbol that a column needs: for each frequency or pair S_l, or s_l and c_l where there is a mirror.
    pub(super) fn numbers(&self) -> usize {
        (self.length - self.pairs()) * if self.mirrored { 3 } else { 1 }
    }

    /// The symbol of columns, S_l for all l up to half their period, as [`Self::product`] wants it, times `norm`.
    pub(super) fn arrange(&self, symbol: &[&[f64]], norm: f64) -> Vec<T> {
        if !self.mirrored {
            let mut arranged = Vec::with_capacity(symbol.len() * self.numbers());
            symbol.iter().for_each(|symbol| arranged.extend(symbol.iter().map(|s| T::of(norm * s))));
            return arranged;
        }
        let turns: Vec<Complex<f64>> =
            (0..self.length - self.pairs()).map(|l| f64::turn(l as f64 / self.length as f64)).collect();
        let mut arranged = Vec::with_capacity(symbol.len() * self.numbers());
        for symbol in symbol {
            let images = symbol.iter().rev();
            for (l, ((at, image), turn)) in symbol.iter().zip(images).zip(&turns).enumerate() {
                // V_K is V_0.
                let (s, c) =
                    if l == 0 { (*at, Complex::default()) } else { (0.5 * (at + image), turn * (0.5 * (at - image))) };
                arranged.extend([s, c.re, c.im].map(|v| T::of(norm * v)));
            }
        }
        arranged
    }

    /// Workspace that [`Self::product`] needs: points of a column, and scratch.
    pub(super) fn room(&self) -> [usize; 2] {
        let fft = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        [self.length, fft]
    }

    /// Puts the rows from `wanted` on of the product in place of the rows from `given` on of a column, `points` and `fft` being room.
    pub(super) fn product(
        &self,
        column: &mut [Complex<T>],
        symbol: &[T],
        [given, wanted]: [&Range<usize>; 2],
        points: &mut [Complex<T>],
        fft: &mut [Complex<T>],
    ) {
        let base = given.start.min(wanted.start);
        self.lay(&column[given.start - base..given.end - base], given.start, points);
        self.forward.process_with_scratch(points, fft);
        self.scale(points, symbol);
        self.inverse.process_with_scratch(points, fft);
        self.take(points, wanted.start, &mut column[wanted.start - base..wanted.end - base]);
    }

    /// Rows from `first` on in their places, zeros elsewhere.
    fn lay(&self, rows: &[Complex<T>], first: usize, spread: &mut [Complex<T>]) {
        if rows.len() < self.length {
            spread.fill(Complex::default());
        }
        if !self.mirrored {
            spread[first..first + rows.len()].copy_from_slice(rows);
            return;
        }
        let (even, odd) = (first.next_multiple_of(2), first | 1);
        let from = |row: usize| rows[(row - first).min(rows.len())..].iter().step_by(2);
        for (to, from) in spread[even / 2..].iter_mut().zip(from(even)) {
            *to = *from;
        }
        for (to, from) in spread[..self.length - odd / 2].iter_mut().rev().zip(from(odd)) {
            *to = *from;
        }
    }

    /// The way back of [`Self::lay`].
    fn take(&self, spread: &[Complex<T>], first: usize, rows: &mut [Complex<T>]) {
        if !self.mirrored {
            rows.copy_from_slice(&spread[first..first + rows.len()]);
            return;
        }
        let (even, odd, count) = (first.next_multiple_of(2), first | 1, rows.len());
        for (from, to) in spread[even / 2..].iter().zip(rows[(even - first).min(count)..].iter_mut().step_by(2)) {
            *to = *from;
        }
        let odds = rows[(odd - first).min(count)..].iter_mut().step_by(2);
        for (from, to) in spread[..self.length - odd / 2].iter().rev().zip(odds) {
            *to = *from;
        }
    }

    /// Frequencies times their symbol.
    fn scale(&self, column: &mut [Complex<T>], symbol: &[T]) {
        let pairs = self.pairs();
        let (low, high) = column.split_at_mut(self.length - pairs);
        if !self.mirrored {
            for (value, s) in low.iter_mut().zip(symbol) {
                *value = *value * *s;
            }
            for (value, s) in high.iter_mut().zip(symbol[1..=pairs].iter().rev()) {
                *value = *value * *s;
            }
            return;
        }
        // Those that are their own image.
        low[0] = low[0] * symbol[0];
        if let Some(middle) = low.get_mut(pairs + 1) {
            *middle = *middle * symbol[3 * (pairs + 1)];
        }
        let (symbol, _) = symbol[3..].as_chunks();
        for ((a, b), [s, re, im]) in low[1..].iter_mut().zip(high.iter_mut().rev()).zip(symbol) {
            let (old_a, old_b, c) = (*a, *b, Complex { re: *re, im: *im });
            *a = old_a * *s + c * old_b;
            *b = old_b * *s + c.conj() * old_a;
        }
    }
}
