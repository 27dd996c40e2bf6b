//! Numbers of twice the precision, for differences that cancel.
//!
//! A value is hi + lo with |lo| <= ulp(hi)/2, about 32 digits (Dekker, Numer. Math. 18 (1971) 224; Hida, Li & Bailey 2001).
//! Only what [`super::love`] needs, for finite values well inside the range of `f64`.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// ln 2 = LN_2.hi + LN_2.lo.
const LN_2: DoubleDouble = DoubleDouble { hi: std::f64::consts::LN_2, lo: 2.319_046_813_846_299_6e-17 };

/// Terms of the series of atanh: with |z| < 0.0217 the next is below 1e-34.
const ATANH_TERMS: u32 = 10;

/// a + b without error; |a| >= |b|.
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

/// a + b without error (Knuth).
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    let v = hi - a;
    DoubleDouble { hi, lo: (a - (hi - v)) + (b - v) }
}

/// Halves of 26 bits (Veltkamp).
fn split(a: f64) -> (f64, f64) {
    let t = 134_217_729.0 * a;
    let high = t - (t - a);
    (high, a - high)
}

/// a b without error (Dekker).
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let hi = a * b;
    let ((a1, a2), (b1, b2)) = (split(a), split(b));
    DoubleDouble { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl DoubleDouble {
    /// a b, exactly.
    pub(super) fn product(a: f64, b: f64) -> Self {
        two_product(a, b)
    }

    /// Rounded to an `f64`.
    pub(super) fn round(self) -> f64 {
        self.hi + self.lo
    }

    /// Whether it is zero.
    pub(super) fn is_zero(self) -> bool {
        self.hi == 0.0
    }

    /// Magnitude.
    pub(super) fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Square root of a number that is not negative (Karp).
    pub(super) fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Self::from(0.0);
        }
        let inverse = 1.0 / self.hi.sqrt();
        let root = self.hi * inverse;
        let rest = (self - two_product(root, root)).hi * (0.5 * inverse);
        two_sum(root, rest)
    }

    /// Natural logarithm of a positive number: ln x = k ln 2 + 8 ln m, m the eighth root of what is left, and
    /// ln m = 2 atanh((m - 1)/(m + 1)).
    pub(super) fn ln(self) -> Self {
        let k = (self.hi * std::f64::consts::FRAC_1_SQRT_2).log2().ceil();
        let scale = (-k).exp2();
        let m = Self { hi: self.hi * scale, lo: self.lo * scale }.sqrt().sqrt().sqrt();
        let z = (m - Self::from(1.0)) / (m + Self::from(1.0));
        let z2 = z * z;
        let mut series = Self::from(0.0);
        for n in (0..ATANH_TERMS).rev() {
            series = series * z2 + Self::from(1.0) / Self::from(f64::from(2 * n + 1));
        }
        LN_2 * Self::from(k) + Self::from(16.0) * z * series
    }
}

impl From<f64> for DoubleDouble {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (s, t) = (two_sum(self.hi, b.hi), two_sum(self.lo, b.lo));
        let s = quick_two_sum(s.hi, s.lo + t.hi);
        quick_two_sum(s.hi, s.lo + t.lo)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        quick_two_sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let q1 = self.hi / b.hi;
        let r = self - b * Self::from(q1);
        let q2 = r.hi / b.hi;
        let q3 = (r - b * Self::from(q2)).hi / b.hi;
        quick_two_sum(q1, q2) + Self::from(q3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: DoubleDouble, b: DoubleDouble) -> bool {
        (a - b).round().abs() <= 1e-30 * (1.0 + b.round().abs())
    }

    #[test]
    fn square_root_and_quotient_undo_the_product() {
        for x in [1e-6, 0.3, 2.0, 7.7e5] {
            let x = DoubleDouble::from(x) / DoubleDouble::from(3.0);
            assert!(close(x.sqrt() * x.sqrt(), x));
            assert!(close(x * x / x, x));
        }
    }

    #[test]
    fn logarithm_of_a_product_is_the_sum() {
        for (a, b) in [(3.0, 5.0), (1e-4, 1e7), (1.0 + 1e-9, 1.5), (0.7, 0.8)] {
            let (a, b) = (DoubleDouble::from(a), DoubleDouble::from(b));
            assert!(close((a * b).ln(), a.ln() + b.ln()));
        }
        assert!(close(DoubleDouble::from(2.0).ln(), LN_2));
        assert!(DoubleDouble::from(1.0).ln().round().abs() < 1e-31);
    }
}
