//! Sums, products and quotients of intervals.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Interval;

impl Neg for Interval {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo, defined: self.defined }
    }
}

impl Add for Interval {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        let defined = self.defined && other.defined;
        // 0 moves nothing: integers and planes through the origin keep their digits.
        if other.lo == 0.0 && other.hi == 0.0 {
            return Self { defined, ..self };
        }
        if self.lo == 0.0 && self.hi == 0.0 {
            return Self { defined, ..other };
        }
        let sum = Self::outward(self.lo + other.lo, self.hi + other.hi, defined);
        // So is that of a sum of numbers of one sign.
        let least = if self.lo >= 0.0 && other.lo >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
        let most = if self.hi <= 0.0 && other.hi <= 0.0 { 0.0 } else { f64::INFINITY };
        Self { lo: sum.lo.max(least), hi: sum.hi.min(most), ..sum }
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

/// 0 times anything is 0: an infinite end stands for finite values without limit.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Mul for Interval {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        let defined = self.defined && other.defined;
        for (one, factor) in [(self, other), (other, self)] {
            if factor.lo == 1.0 && factor.hi == 1.0 {
                return Self { defined, ..one };
            }
            if factor.lo == 0.0 && factor.hi == 0.0 {
                return Self { defined, ..Self::ZERO };
            }
        }
        let corners = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        let [a, b, c, d] = if corners.iter().any(|c| c.is_nan()) {
            [times(self.lo, other.lo), times(self.lo, other.hi), times(self.hi, other.lo), times(self.hi, other.hi)]
        } else {
            corners
        };
        // None of them is NaN, which f64::min and max have to look for.
        let (least, most) = (|a: f64, b: f64| if a < b { a } else { b }, |a: f64, b: f64| if a > b { a } else { b });
        let (lo, hi) = (least(least(a, b), least(c, d)), most(most(a, b), most(c, d)));
        let product = Self::outward(lo, hi, defined);
        // The sign of a product is exact.
        let positive = (self.lo >= 0.0 && other.lo >= 0.0) || (self.hi <= 0.0 && other.hi <= 0.0);
        let negative = (self.lo >= 0.0 && other.hi <= 0.0) || (self.hi <= 0.0 && other.lo >= 0.0);
        Self {
            lo: if positive { product.lo.max(0.0) } else { product.lo },
            hi: if negative { product.hi.min(0.0) } else { product.hi },
            ..product
        }
    }
}

impl Div for Interval {
    type Output = Self;

    /// No value where the divisor is 0.
    #[inline]
    fn div(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() || (other.lo == 0.0 && other.hi == 0.0) {
            return Self::EMPTY;
        }
        let defined = self.defined && other.defined && !other.has_zero();
        if other.lo == other.hi && other.lo > 0.0 && other.lo.is_finite() {
            let quotient = Self::outward(self.lo / other.lo, self.hi / other.lo, defined);
            // The sign of a quotient is exact.
            let least = if self.lo >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
            let most = if self.hi <= 0.0 { 0.0 } else { f64::INFINITY };
            return Self { lo: quotient.lo.max(least), hi: quotient.hi.min(most), ..quotient };
        }
        if other.lo < 0.0 && other.hi > 0.0 {
            return Self { defined, ..Self::UNKNOWN };
        }
        let inverse = |v: f64, side: f64| if v == 0.0 { side * f64::INFINITY } else { 1.0 / v };
        // On one side of 0 the inverse falls.
        let side = if other.lo >= 0.0 { 1.0 } else { -1.0 };
        let reciprocal = Self::outward(inverse(other.hi, side), inverse(other.lo, side), defined);
        let reciprocal = if side > 0.0 {
            Self { lo: reciprocal.lo.max(0.0), ..reciprocal }
        } else {
            Self { hi: reciprocal.hi.min(0.0), ..reciprocal }
        };
        if self.lo == self.hi && other.lo == other.hi {
            return Self::outward(self.lo / other.lo, self.lo / other.lo, defined);
        }
        Self { defined, ..self * reciprocal }
    }
}
