//! Numbers, and intervals that enclose them: what functions and their derivatives are worked out on.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Interval;

/// What derivatives can be carried over: numbers, or intervals that enclose them.
pub(crate) trait Real:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn abs(self) -> Self;
    fn sign(self) -> Self;
    fn sqrt(self) -> Self;
    fn cbrt(self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn log10(self) -> Self;
    fn log2(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn tan(self) -> Self;
    fn asin(self) -> Self;
    fn acos(self) -> Self;
    fn atan(self) -> Self;
    fn sinh(self) -> Self;
    fn cosh(self) -> Self;
    fn tanh(self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    fn powi(self, n: i32) -> Self;
    fn powf(self, exponent: Self) -> Self;
    fn hypot(self, other: Self) -> Self;
    /// a/r, |a| <= r.
    fn share_of(self, r: Self) -> Self;
    fn atan2(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    /// The slope of |a|: that of the right side at 0.
    fn slope_of_abs(self) -> Self;
    /// 0, or anything where `self` may be 0: the derivative of what jumps there.
    fn flat_but_at_zero(self) -> Self;
    /// 0, or anything where `self` may pass a whole number.
    fn flat_but_at_whole(self) -> Self;
    /// Which of two is the lesser: `None` when that changes within the set.
    fn is_below(self, other: Self) -> Option<bool>;
    /// What holds both.
    fn hull(self, other: Self) -> Self;
    /// Anything.
    fn unknown() -> Self;
    /// Whether this is 0 throughout.
    fn is_zero(self) -> bool;
}

macro_rules! same {
    ($of:ty: $($name:ident),*) => { $(fn $name(self) -> Self { <$of>::$name(self) })* };
}

impl Real for f64 {
    same!(f64: abs, sqrt, cbrt, exp, ln, log10, log2, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, floor, ceil);

    fn sign(self) -> Self {
        if self == 0.0 { 0.0 } else { self.signum() }
    }

    fn powi(self, n: i32) -> Self {
        f64::powi(self, n)
    }

    fn powf(self, exponent: Self) -> Self {
        f64::powf(self, exponent)
    }

    fn hypot(self, other: Self) -> Self {
        f64::hypot(self, other)
    }

    fn share_of(self, r: Self) -> Self {
        self / r
    }

    fn atan2(self, other: Self) -> Self {
        f64::atan2(self, other)
    }

    // Unlike f64::min and max, NaN stays NaN: what has no value has no material.
    fn min(self, other: Self) -> Self {
        if self.is_nan() || other.is_nan() { f64::NAN } else { f64::min(self, other) }
    }

    fn max(self, other: Self) -> Self {
        if self.is_nan() || other.is_nan() { f64::NAN } else { f64::max(self, other) }
    }

    fn slope_of_abs(self) -> Self {
        1f64.copysign(self)
    }

    fn flat_but_at_zero(self) -> Self {
        0.0
    }

    fn flat_but_at_whole(self) -> Self {
        0.0
    }

    fn is_below(self, other: Self) -> Option<bool> {
        Some(self <= other)
    }

    fn hull(self, _: Self) -> Self {
        self
    }

    fn unknown() -> Self {
        f64::NAN
    }

    fn is_zero(self) -> bool {
        self == 0.0
    }
}

impl Real for Interval {
    same!(Interval: abs, sign, sqrt, cbrt, exp, ln, log10, log2, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, floor, ceil);

    fn powi(self, n: i32) -> Self {
        Interval::powi(self, n)
    }

    fn powf(self, exponent: Self) -> Self {
        Interval::powf(self, exponent)
    }

    fn hypot(self, other: Self) -> Self {
        Interval::hypot(self, other)
    }

    fn share_of(self, r: Self) -> Self {
        if self.is_empty() || r.is_empty() {
            return Self::EMPTY;
        }
        let all = Self::new(if self.lo >= 0.0 { 0.0 } else { -1.0 }, if self.hi <= 0.0 { 0.0 } else { 1.0 });
        Self { defined: self.defined && r.defined, ..self.quotient_within(r, all) }
    }

    fn atan2(self, other: Self) -> Self {
        Interval::atan2(self, other)
    }

    fn min(self, other: Self) -> Self {
        Interval::min(self, other)
    }

    fn max(self, other: Self) -> Self {
        Interval::max(self, other)
    }

    fn slope_of_abs(self) -> Self {
        if self.lo >= 0.0 {
            Self::point(1.0)
        } else if self.hi <= 0.0 {
            Self::point(-1.0)
        } else {
            Self::new(-1.0, 1.0)
        }
    }

    fn flat_but_at_zero(self) -> Self {
        if self.lo < 0.0 && self.hi > 0.0 { Self::UNKNOWN } else { Self::ZERO }
    }

    fn flat_but_at_whole(self) -> Self {
        if self.lo.floor() == self.hi.floor() { Self::ZERO } else { Self::UNKNOWN }
    }

    fn is_below(self, other: Self) -> Option<bool> {
        if self.hi <= other.lo {
            Some(true)
        } else if other.hi <= self.lo {
            Some(false)
        } else {
            None
        }
    }

    fn hull(self, other: Self) -> Self {
        self.union(other)
    }

    fn unknown() -> Self {
        Self::UNKNOWN
    }

    fn is_zero(self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }
}
