//! One column of a convolution: its transform, times the symbol, and back.
//!
//! As for the rows, the even and the odd frequencies of a padded column are two transforms over L points: of x_j and of x_j w_j,
//! w_j = exp(-i pi j/L); back, the sum of the first and of the second over w_j.
//!
//! Where the column has a mirror at its lower end and its upper half stands for both, x_j is even about j = -1/2. With S_l
//! the symbol over 2K points, the product is diagonal in the cosine transform of K points (DCT-II), which is a transform of
//! K points of v_j = x_2j, v_(K-1-j) = x_(2j+1) (Makhoul, IEEE Trans. ASSP 28 (1980) 27). In terms of V
//!
//!   V'_l = s_l V_l + c_l V_(K-l),   s_l = (S_l + S_(K-l))/2,   c_l = (S_l - S_(K-l))/2 exp(i pi l/K),   c_(K-l) = conj c_l:
//!
//! half the rows, columns of half the length. Padded to K = 2L points, the even l are those of a DCT-II over L points, the odd l
//! those of a DCT-IV: the same v over L points, times w_j and with the sign of x_(2j+1) changed.

use std::ops::Range;
use std::sync::Arc;

use rustfft::Fft;
use rustfft::num_complex::Complex;

use super::real::Real;

/// Products of columns with a symbol over L points, or over 2L with zeros behind.
#[derive(Clone)]
pub(super) struct Columns<T> {
    length: usize,
    mirrored: bool,
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
    /// w_j of the module's header, with their sign where there is a mirror; empty where it is not split.
    twiddles: Vec<Complex<T>>,
}

impl<T: Real> Columns<T> {
    /// Over `length` points; `split`: over twice as many, the second half zero; `mirrored`: the upper half of twice as many rows.
    pub(super) fn new(length: usize, split: bool, mirrored: bool) -> Self {
        let (forward, inverse) =
            T::with_planners(|_, complex| (complex.plan_fft_forward(length), complex.plan_fft_inverse(length)));
        let ends = if split { length } else { 0 };
        let twiddles = (0..ends).map(|j| {
            let w = T::turn(-(j as f64) / length as f64);
            if mirrored && j >= length.div_ceil(2) { -w } else { w }
        });
        Self { length, mirrored, forward, inverse, twiddles: twiddles.collect() }
    }

    fn split(&self) -> bool {
        !self.twiddles.is_empty()
    }

    /// Transforms of a column: of the even frequencies, and of the odd ones where it is split.
    fn classes(&self) -> usize {
        if self.split() { 2 } else { 1 }
    }

    /// The frequencies of one transform that belong together, l and L - l of the even ones, l and L - 1 - l of the odd ones: the
    /// first that is not its own image, and how many pairs. The others of L stand alone.
    fn pairs(&self, odd: usize) -> (usize, usize) {
        let first = 1 - odd;
        (first, (self.length - first) / 2)
    }

    /// Numbers of the symbol for a frequency or a pair.
    fn each(&self) -> usize {
        if self.mirrored { 3 } else { 1 }
    }

    /// Numbers of the symbol that a column needs.
    pub(super) fn numbers(&self) -> usize {
        (0..self.classes()).map(|odd| self.each() * (self.length - self.pairs(odd).1)).sum()
    }

    /// The symbol of columns, S_l for all l up to half their period, as [`Self::product`] wants it: of each S_l of the even
    /// and of the odd l, or s_l and c_l where there is a mirror; times `norm`.
    pub(super) fn arrange<'a>(&self, symbol: impl Iterator<Item = &'a [f64]>, norm: f64, columns: usize) -> Vec<T> {
        let (classes, points) = (self.classes(), self.classes() * self.length);
        let turns: Vec<Complex<f64>> =
            (0..if self.mirrored { points } else { 0 }).map(|l| f64::turn(l as f64 / points as f64)).collect();
        let mut arranged = vec![T::of(0.0); columns * self.numbers()];
        let mut rest = &mut arranged[..];
        for (symbol, odd) in symbol.flat_map(|symbol| (0..classes).map(move |odd| (symbol, odd))) {
            let here = rest.split_off_mut(..self.each() * (self.length - self.pairs(odd).1)).unwrap_or_default();
            let at = symbol[odd..].iter().step_by(classes).map(|s| norm * s);
            if !self.mirrored {
                here.iter_mut().zip(at).for_each(|(to, at)| *to = T::of(at));
                continue;
            }
            let images = symbol[..=points - odd].iter().rev().step_by(classes).map(|s| norm * s);
            let turns = turns[odd..].iter().step_by(classes);
            for (to, ((at, image), turn)) in here.as_chunks_mut().0.iter_mut().zip(at.zip(images).zip(turns)) {
                let c = turn * (0.5 * (at - image));
                *to = [0.5 * (at + image), c.re, c.im].map(T::of);
            }
            if odd == 0 {
                // V_K is V_0.
                here[..3].copy_from_slice(&[norm * symbol[0], 0.0, 0.0].map(T::of));
            }
        }
        arranged
    }

    /// Room that [`Self::product`] needs: points of a column, and scratch.
    pub(super) fn room(&self) -> [usize; 2] {
        let fft = self.forward.get_inplace_scratch_len().max(self.inverse.get_inplace_scratch_len());
        [self.classes() * self.length, fft]
    }

    /// Puts the rows `wanted` of the product in place of the rows `given` of a column, whose first number is in row `base`.
    #[expect(clippy::too_many_arguments, reason = "a column, its symbol, where they lie, and room")]
    pub(super) fn product(
        &self,
        column: &mut [Complex<T>],
        symbol: &[T],
        given: &Range<usize>,
        wanted: &Range<usize>,
        base: usize,
        both: &mut [Complex<T>],
        fft: &mut [Complex<T>],
    ) {
        let (even, odd) = both.split_at_mut(self.length);
        let rows = &column[given.start - base..given.end - base];
        // Where the rows lie in the column.
        let places = if self.mirrored { 0..self.length } else { given.clone() };
        self.lay(rows, given.start, even);
        if self.split() {
            odd[..places.start].fill(Complex::default());
            odd[places.end..].fill(Complex::default());
            for ((to, x), w) in odd[places.clone()].iter_mut().zip(&even[places.clone()]).zip(&self.twiddles[places]) {
                *to = x * w;
            }
        }
        self.forward.process_with_scratch(both, fft);
        let mut symbol = symbol;
        for (class, part) in both.chunks_exact_mut(self.length).enumerate() {
            symbol = self.scale(part, symbol, class);
        }
        self.inverse.process_with_scratch(both, fft);
        let (even, odd) = both.split_at_mut(self.length);
        let rows = &mut column[wanted.start - base..wanted.end - base];
        if self.split() && !self.mirrored {
            // Both at once, on the way out.
            let (even, odd) = (&even[wanted.clone()], &odd[wanted.clone()]);
            for (((to, x), y), w) in rows.iter_mut().zip(even).zip(odd).zip(&self.twiddles[wanted.clone()]) {
                *to = x + *y * w.conj();
            }
        } else {
            for ((x, y), w) in even.iter_mut().zip(odd).zip(&self.twiddles) {
                *x = *x + *y * w.conj();
            }
            self.take(even, wanted.start, rows);
        }
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

    /// Frequencies, even or odd, times their symbol, which is the beginning of `symbol`; gives back the rest of it.
    fn scale<'a>(&self, column: &mut [Complex<T>], symbol: &'a [T], odd: usize) -> &'a [T] {
        let (first, count) = self.pairs(odd);
        let (low, high) = column.split_at_mut(self.length - count);
        let (symbol, rest) = symbol.split_at(self.each() * low.len());
        if !self.mirrored {
            for (value, s) in low.iter_mut().zip(symbol) {
                *value = *value * *s;
            }
            for (value, s) in high.iter_mut().zip(symbol[first..first + count].iter().rev()) {
                *value = *value * *s;
            }
            return rest;
        }
        if first == 1 {
            low[0] = low[0] * symbol[0];
        }
        if low.len() > first + count {
            low[first + count] = low[first + count] * symbol[3 * (first + count)];
        }
        let (pairs, _) = symbol[3 * first..].as_chunks();
        for ((a, b), [s, re, im]) in low[first..].iter_mut().zip(high.iter_mut().rev()).zip(pairs) {
            let (old_a, old_b, c) = (*a, *b, Complex { re: *re, im: *im });
            *a = old_a * *s + c * old_b;
            *b = old_b * *s + c.conj() * old_a;
        }
        rest
    }
}
