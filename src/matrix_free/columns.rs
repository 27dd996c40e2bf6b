//! One column of a convolution: its transform, times the symbol, and back.
//!
//! As for the rows, the even and the odd frequencies of a padded column are two transforms over L points: of x_j and of x_j w_j,
//! w_j = exp(-i pi j/L); back, the sum of the first and of the second over w_j.
//!
//! Where the column has a mirror at its lower end and its upper half stands for both, x_j is even about j = -1/2. With S_l
//! the symbol over 2K points, the product is diagonal in the cosine transform of K points (DCT-II), which is a transform of
//! K points of v_j = x_2j, v_(K-1-j) = x_(2j+1) (Makhoul, IEEE Trans. ASSP 28 (1980) 27). In terms of V
//!
//!   V'_l = s_l V_l + d_l t_l V_(K-l),   s, d = (S_l +- S_(K-l))/2,   t_l = exp(i pi l/K):
//!
//! half the rows, columns of half the length. Padded to K = 2L points, the even l are those of a DCT-II over L points, the odd l
//! those of a DCT-IV: the same v over L points, times w_j and with the sign of x_(2j+1) changed.

use std::ops::Range;
use std::sync::Arc;

use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::lanes::{Lines, apart};
use super::symbol::Real;

/// Products of columns with a symbol over L points, or over 2L with zeros behind.
#[derive(Clone)]
pub(super) struct Columns<T> {
    length: usize,
    mirrored: bool,
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
    /// w_j of the module's header, with their sign where there is a mirror; empty without padding.
    twiddles: Vec<Complex<T>>,
    /// t_l of the even l and of the odd ones; empty without a mirror.
    turns: [Vec<Complex<T>>; 2],
}

/// The frequencies of one transform that belong together: l and L - l of the even ones, l and L - 1 - l of the odd ones.
struct Pairs {
    /// Where they begin: the even frequency 0 stands alone.
    first: usize,
    count: usize,
    /// Numbers of the symbol that one transform needs, pairs and singles.
    numbers: usize,
}

impl<T: Real> Columns<T> {
    /// Over `length` points; `padded`: over twice as many, the second half zero; `mirrored`: the upper half of twice as many rows.
    pub(super) fn new(length: usize, padded: bool, mirrored: bool) -> Self {
        let (forward, inverse) =
            T::with_planners(|_, complex| (complex.plan_fft_forward(length), complex.plan_fft_inverse(length)));
        let ends = if padded { length } else { 0 };
        let twiddles = (0..ends).map(|j| {
            let w = T::turn(-(j as f64) / length as f64);
            if mirrored && j >= length.div_ceil(2) { -w } else { w }
        });
        let turns = [0, 1].map(|odd| {
            let ends = if mirrored { length } else { 0 };
            (0..ends).map(|k| T::turn((2 * k + odd) as f64 / (2 * length) as f64)).collect()
        });
        Self { length, mirrored, forward, inverse, twiddles: twiddles.collect(), turns }
    }

    fn padded(&self) -> bool {
        !self.twiddles.is_empty()
    }

    fn pairs(&self, odd: usize) -> Pairs {
        let first = 1 - odd;
        Pairs { first, count: (self.length - first) / 2, numbers: (self.length - first).div_ceil(2) + first }
    }

    /// Numbers of the symbol that a column needs.
    pub(super) fn numbers(&self) -> usize {
        let classes = if self.padded() { 2 } else { 1 };
        let each = if self.mirrored { 2 } else { 1 };
        (0..classes).map(|odd| each * self.pairs(odd).numbers).sum()
    }

    /// Appends the symbol of a column, S_l for all l up to half its period, as [`Self::product`] wants it: S_l of the even
    /// and of the odd l, or s_l and d_l where there is a mirror; times `norm`.
    pub(super) fn arrange(&self, symbol: &[f64], norm: f64, to: &mut Vec<T>) {
        let classes = if self.padded() { 2 } else { 1 };
        for odd in 0..classes {
            for l in (0..self.pairs(odd).numbers).map(|k| classes * k + odd) {
                let at = norm * symbol[l];
                if !self.mirrored {
                    to.push(T::of(at));
                } else if l == 0 {
                    to.extend([T::of(at), T::of(0.0)]);
                } else {
                    let image = norm * symbol[classes * self.length - l];
                    to.extend([T::of(0.5 * (at + image)), T::of(0.5 * (at - image))]);
                }
            }
        }
    }

    /// Numbers that a column must have room for.
    pub(super) fn height(&self) -> usize {
        self.length
    }

    /// Puts the rows `wanted` of the product in place of the rows `given` of the column. The other rows are lost.
    pub(super) fn product(
        &self,
        column: &mut [Complex<T>],
        symbol: &[T],
        given: &Range<usize>,
        wanted: &Range<usize>,
        room: &mut Lines<Complex<T>>,
        fft: &mut Lines<Complex<T>>,
    ) {
        let pitch = apart(self.length);
        let (odd, spread) = room.of(2 * pitch).split_at_mut(pitch);
        let (odd, spread) = (&mut odd[..self.length], &mut spread[..self.length]);
        let fft = fft.of(self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len()));
        if self.mirrored {
            self.lay(column, given, spread);
            self.multiply(spread, odd, symbol, 0..self.length, fft);
            self.take(spread, wanted, column);
        } else {
            let column = &mut column[..self.length];
            column[..given.start].fill(Complex::default());
            column[given.end..].fill(Complex::default());
            self.multiply(column, odd, symbol, wanted.clone(), fft);
        }
    }

    /// The product in the places `wanted` of a column that is laid out for its transform.
    fn multiply(
        &self,
        even: &mut [Complex<T>],
        odd: &mut [Complex<T>],
        symbol: &[T],
        wanted: Range<usize>,
        fft: &mut [Complex<T>],
    ) {
        for ((to, x), w) in odd.iter_mut().zip(&*even).zip(&self.twiddles) {
            *to = x * w;
        }
        self.forward.process_with_scratch(even, fft);
        let symbol = self.scale(even, symbol, 0);
        self.inverse.process_with_scratch(even, fft);
        if self.padded() {
            self.forward.process_with_scratch(odd, fft);
            self.scale(odd, symbol, 1);
            self.inverse.process_with_scratch(odd, fft);
            let (even, odd) = (&mut even[wanted.clone()], &odd[wanted.clone()]);
            for ((x, y), w) in even.iter_mut().zip(odd).zip(&self.twiddles[wanted]) {
                *x = *x + y * w.conj();
            }
        }
    }

    /// Rows of a column with a mirror in their places, zeros elsewhere.
    fn lay(&self, column: &[Complex<T>], given: &Range<usize>, spread: &mut [Complex<T>]) {
        let (my, zero, rows) = (self.length, Complex::default(), &column[..given.end]);
        let (even, odd) = (given.start.next_multiple_of(2), given.start | 1);
        spread[..even / 2].fill(zero);
        spread[given.end.div_ceil(2)..my - given.end / 2].fill(zero);
        spread[my - odd / 2..].fill(zero);
        let from = |first: usize| rows[first.min(rows.len())..].iter().step_by(2);
        for (to, from) in spread[even / 2..].iter_mut().zip(from(even)) {
            *to = *from;
        }
        for (to, from) in spread[..my - odd / 2].iter_mut().rev().zip(from(odd)) {
            *to = *from;
        }
    }

    /// The way back of [`Self::lay`].
    fn take(&self, spread: &[Complex<T>], wanted: &Range<usize>, column: &mut [Complex<T>]) {
        let (even, odd) = (wanted.start.next_multiple_of(2), wanted.start | 1);
        let rows = &mut column[..wanted.end];
        let end = rows.len();
        for (from, to) in spread[even / 2..].iter().zip(rows[even.min(end)..].iter_mut().step_by(2)) {
            *to = *from;
        }
        for (from, to) in spread[..self.length - odd / 2].iter().rev().zip(rows[odd.min(end)..].iter_mut().step_by(2)) {
            *to = *from;
        }
    }

    /// Frequencies, even or odd, times their symbol, which is the beginning of `symbol`; gives back the rest of it.
    fn scale<'a>(&self, column: &mut [Complex<T>], symbol: &'a [T], odd: usize) -> &'a [T] {
        let Pairs { first, count, numbers } = self.pairs(odd);
        if !self.mirrored {
            let (symbol, rest) = symbol.split_at(numbers);
            let (low, high) = column.split_at_mut(numbers);
            for (value, s) in low.iter_mut().zip(symbol) {
                *value = *value * *s;
            }
            for (value, s) in high.iter_mut().zip(symbol[first..first + count].iter().rev()) {
                *value = *value * *s;
            }
            return rest;
        }
        let (symbol, rest) = symbol.split_at(2 * numbers);
        let (low, high) = column.split_at_mut(self.length - count);
        if first == 1 {
            low[0] = low[0] * symbol[0];
        }
        if low.len() > first + count {
            low[first + count] = low[first + count] * symbol[2 * (first + count)];
        }
        let (low, pairs, turns) = (&mut low[first..], &symbol[2 * first..], &self.turns[odd][first..]);
        for (((a, b), sd), t) in low.iter_mut().zip(high.iter_mut().rev()).zip(pairs.chunks_exact(2)).zip(turns) {
            let (old_a, old_b) = (*a, *b);
            *a = old_a * sd[0] + t * old_b * sd[1];
            *b = old_b * sd[0] + t.conj() * old_a * sd[1];
        }
        rest
    }
}
