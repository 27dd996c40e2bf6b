//! Interval arithmetic: the set of values of an expression over a set of points, enclosed.
//!
//! +, -, *, / and the square root round to nearest, so the neighbouring floats enclose the exact result (IEEE 754). Other functions
//! come from the system's mathematical library, whose largest known error is 4 units in the last place (glibc manual, "Known Maximum
//! Errors in Math Functions"); results are widened by 8.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Relative widening of a function of the mathematical library.
const LIBRARY: f64 = 8.0 * f64::EPSILON;

/// All values that a quantity takes over a set of points lie in [lo, hi]; empty (lo > hi) where it has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Least value, or less.
    pub lo: f64,
    /// Greatest value, or more.
    pub hi: f64,
    /// Whether the quantity is known to have a finite value at every point.
    pub defined: bool,
}

impl Interval {
    /// Anything, or nothing at all.
    pub const UNKNOWN: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY, defined: false };
    /// No value anywhere.
    pub const EMPTY: Self = Self { lo: f64::INFINITY, hi: f64::NEG_INFINITY, defined: false };
    /// Zero.
    pub const ZERO: Self = Self::point(0.0);

    /// Values from `lo` to `hi`; infinite ends stand for values without limit.
    #[must_use]
    pub const fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi, defined: true }
    }

    /// One value.
    #[must_use]
    pub const fn point(value: f64) -> Self {
        Self { lo: value, hi: value, defined: value.is_finite() }
    }

    /// Whether no point has a value.
    #[must_use]
    pub fn is_empty(self) -> bool {
        !(self.lo <= self.hi)
    }

    /// Whether the value 0 cannot be excluded.
    #[must_use]
    pub fn has_zero(self) -> bool {
        self.lo <= 0.0 && 0.0 <= self.hi
    }

    /// Greatest distance from 0.
    #[must_use]
    pub fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// hi - lo, rounded up.
    #[must_use]
    pub fn width(self) -> f64 {
        (self.hi - self.lo).next_up()
    }

    /// A value in the middle; finite when one end is.
    #[must_use]
    pub fn middle(self) -> f64 {
        match (self.lo.is_finite(), self.hi.is_finite()) {
            (true, true) => 0.5 * self.lo + 0.5 * self.hi,
            (true, false) => self.lo,
            (false, true) => self.hi,
            (false, false) => 0.0,
        }
    }

    /// The values of both sets of points together.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return Self { defined: false, ..other };
        }
        if other.is_empty() {
            return Self { defined: false, ..self };
        }
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi), defined: self.defined && other.defined }
    }

    /// What both allow, for the same points.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.min(other.hi), defined: self.defined || other.defined }
    }

    /// With ends one float further out. An end that overflowed leaves the value undefined.
    fn outward(lo: f64, hi: f64, defined: bool) -> Self {
        if lo.is_nan() || hi.is_nan() {
            return Self::UNKNOWN;
        }
        Self { lo: lo.next_down(), hi: hi.next_up(), defined }
    }

    /// With ends further out by what the mathematical library may err.
    fn of_library(lo: f64, hi: f64, defined: bool) -> Self {
        if lo.is_nan() || hi.is_nan() {
            return Self::UNKNOWN;
        }
        Self { lo: below(lo, LIBRARY), hi: above(hi, LIBRARY), defined }
    }

    /// A rising function of the library.
    fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        Self::of_library(f(self.lo), f(self.hi), self.defined)
    }

    /// The part of the points at which lo <= value <= hi.
    fn where_within(self, lo: f64, hi: f64) -> Self {
        let whole = self.lo >= lo && self.hi <= hi;
        Self { lo: self.lo.max(lo), hi: self.hi.min(hi), defined: self.defined && whole }
    }

    /// |a|.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.is_empty() || self.lo >= 0.0 {
            self
        } else if self.hi <= 0.0 {
            -self
        } else {
            Self { lo: 0.0, hi: self.magnitude(), defined: self.defined }
        }
    }

    /// -1, 0 or 1.
    #[must_use]
    pub fn sign(self) -> Self {
        if self.is_empty() {
            return self;
        }
        let of = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        Self { lo: of(self.lo), hi: of(self.hi), defined: self.defined }
    }

    /// a^n.
    #[must_use]
    pub fn powi(self, n: i32) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        if n == 0 {
            return Self { defined: self.defined, ..Self::point(1.0) };
        }
        if n == 1 {
            return self;
        }
        if n < 0 {
            return Self::point(1.0) / self.powi(-n);
        }
        let base = if n % 2 == 0 { self.abs() } else { self };
        if n == 2 {
            let square = Self::outward(base.lo * base.lo, base.hi * base.hi, self.defined);
            return Self { lo: square.lo.max(0.0), ..square };
        }
        // By squaring: at most 2 log2(n) roundings of half a unit each.
        let slack = 4.0 * f64::EPSILON * f64::from(n);
        let (lo, hi) = (below(base.lo.powi(n), slack), above(base.hi.powi(n), slack));
        // The sign of a power is exact.
        let least = if base.lo >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
        let most = if base.hi <= 0.0 { 0.0 } else { f64::INFINITY };
        Self { lo: lo.max(least), hi: hi.min(most), defined: self.defined }
    }

    /// a^b as the mathematical library has it: for a < 0 only whole b give a value.
    #[must_use]
    pub fn powf(self, b: Self) -> Self {
        if self.is_empty() || b.is_empty() {
            return Self::EMPTY;
        }
        if b.lo == b.hi && b.lo.fract() == 0.0 && b.lo.abs() <= 64.0 {
            return Self { defined: self.defined && b.defined, ..self.powi(b.lo as i32) };
        }
        let whole_exponent = b.lo == b.hi && b.lo.fract() == 0.0;
        if self.lo < 0.0 && (whole_exponent || b.lo != b.hi) {
            return Self::UNKNOWN;
        }
        let base = self.where_within(0.0, f64::INFINITY);
        if base.is_empty() {
            return Self::EMPTY;
        }
        // On a >= 0 the power is monotone in either variable while the other is held: its extremes lie in corners.
        let corners = [base.lo.powf(b.lo), base.lo.powf(b.hi), base.hi.powf(b.lo), base.hi.powf(b.hi)];
        if corners.iter().any(|c| c.is_nan()) {
            return Self::UNKNOWN;
        }
        let lo = corners.into_iter().fold(f64::INFINITY, f64::min);
        let hi = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let defined = base.defined && b.defined && !(base.lo == 0.0 && b.lo <= 0.0);
        let wide = Self::of_library(lo, hi, defined);
        Self { lo: wide.lo.max(0.0), ..wide }
    }

    /// Square root; no value below 0.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let base = self.where_within(0.0, f64::INFINITY);
        if base.is_empty() {
            return Self::EMPTY;
        }
        let root = Self::outward(base.lo.sqrt(), base.hi.sqrt(), base.defined);
        Self { lo: root.lo.max(0.0), ..root }
    }

    /// Cube root.
    #[must_use]
    pub fn cbrt(self) -> Self {
        self.rising(f64::cbrt)
    }

    /// e^a.
    #[must_use]
    pub fn exp(self) -> Self {
        let e = self.rising(f64::exp);
        Self { lo: if e.is_empty() { e.lo } else { e.lo.max(0.0) }, ..e }
    }

    /// A logarithm; no value at 0 and below.
    fn logarithm(self, f: impl Fn(f64) -> f64) -> Self {
        let base = self.where_within(0.0, f64::INFINITY);
        if base.is_empty() {
            return Self::EMPTY;
        }
        let defined = base.defined && base.lo > 0.0;
        Self { defined, ..base.rising(f) }
    }

    /// Natural logarithm.
    #[must_use]
    pub fn ln(self) -> Self {
        self.logarithm(f64::ln)
    }

    /// Decimal logarithm.
    #[must_use]
    pub fn log10(self) -> Self {
        self.logarithm(f64::log10)
    }

    /// Logarithm to base 2.
    #[must_use]
    pub fn log2(self) -> Self {
        self.logarithm(f64::log2)
    }

    /// Sine: 1 at pi/2 + 2 pi k, -1 at -pi/2 + 2 pi k.
    #[must_use]
    pub fn sin(self) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let all = Self { lo: -1.0, hi: 1.0, defined: self.defined };
        // Beyond this, the phase of an end is not known to a small part of a turn.
        if !(self.magnitude() < 1e12 && self.hi - self.lo < TAU) {
            return all;
        }
        // Whether a + 2 pi k lies within, with room for rounding of the phase.
        let slack = 1e-15 * self.magnitude() + 1e-15;
        let passes = |a: f64| {
            let k = ((self.lo - slack - a) / TAU).ceil();
            a + TAU * k <= self.hi + 2.0 * slack
        };
        let (a, b) = (self.lo.sin(), self.hi.sin());
        let hi = if passes(FRAC_PI_2) { 1.0 } else { a.max(b) };
        let lo = if passes(-FRAC_PI_2) { -1.0 } else { a.min(b) };
        let wide = Self::of_library(lo, hi, self.defined);
        Self { lo: wide.lo.max(-1.0), hi: wide.hi.min(1.0), ..wide }
    }

    /// Cosine.
    #[must_use]
    pub fn cos(self) -> Self {
        (self + Self::new(FRAC_PI_2.next_down(), FRAC_PI_2.next_up())).sin()
    }

    /// Tangent.
    #[must_use]
    pub fn tan(self) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        // One branch: both ends between the same two poles, with room for rounding.
        let branch = |v: f64| ((v + FRAC_PI_2) / PI).floor();
        let near_pole = |v: f64| {
            let from = (v + FRAC_PI_2).rem_euclid(PI);
            from.min(PI - from) < 1e-9
        };
        let one = self.magnitude() < 1e6
            && self.hi - self.lo < PI
            && branch(self.lo) == branch(self.hi)
            && !near_pole(self.lo)
            && !near_pole(self.hi);
        if one { self.rising(f64::tan) } else { Self::UNKNOWN }
    }

    /// Arc sine; a value only within [-1, 1].
    #[must_use]
    pub fn asin(self) -> Self {
        self.where_within(-1.0, 1.0).rising(f64::asin)
    }

    /// Arc cosine; a value only within [-1, 1].
    #[must_use]
    pub fn acos(self) -> Self {
        let base = self.where_within(-1.0, 1.0);
        if base.is_empty() {
            return Self::EMPTY;
        }
        Self::of_library(base.hi.acos(), base.lo.acos(), base.defined)
    }

    /// Arc tangent.
    #[must_use]
    pub fn atan(self) -> Self {
        self.rising(f64::atan)
    }

    /// Hyperbolic sine.
    #[must_use]
    pub fn sinh(self) -> Self {
        self.rising(f64::sinh)
    }

    /// Hyperbolic cosine.
    #[must_use]
    pub fn cosh(self) -> Self {
        let c = self.abs().rising(f64::cosh);
        Self { lo: if c.is_empty() { c.lo } else { c.lo.max(1.0) }, ..c }
    }

    /// Hyperbolic tangent.
    #[must_use]
    pub fn tanh(self) -> Self {
        self.rising(f64::tanh)
    }

    /// The largest whole number not above.
    #[must_use]
    pub fn floor(self) -> Self {
        Self { lo: self.lo.floor(), hi: self.hi.floor(), ..self }
    }

    /// The smallest whole number not below.
    #[must_use]
    pub fn ceil(self) -> Self {
        Self { lo: self.lo.ceil(), hi: self.hi.ceil(), ..self }
    }

    /// The lesser of the two; no value where either has none.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        self.pairwise(other, f64::min)
    }

    /// The greater of the two; no value where either has none.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        self.pairwise(other, f64::max)
    }

    fn pairwise(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        Self { lo: f(self.lo, other.lo), hi: f(self.hi, other.hi), defined: self.defined && other.defined }
    }

    /// sqrt(a^2 + b^2).
    #[must_use]
    pub fn hypot(self, other: Self) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        let (a, b) = (self.abs(), other.abs());
        let r = Self::of_library(a.lo.hypot(b.lo), a.hi.hypot(b.hi), a.defined && b.defined);
        Self { lo: r.lo.max(0.0), ..r }
    }

    /// The angle of the point (other, self).
    #[must_use]
    pub fn atan2(self, other: Self) -> Self {
        let (y, x) = (self, other);
        if y.is_empty() || x.is_empty() {
            return Self::EMPTY;
        }
        let defined = y.defined && x.defined;
        // The cut along negative x: all angles.
        if x.lo <= 0.0 && y.has_zero() {
            return Self { lo: -PI.next_up(), hi: PI.next_up(), defined };
        }
        let corners = [y.lo.atan2(x.lo), y.lo.atan2(x.hi), y.hi.atan2(x.lo), y.hi.atan2(x.hi)];
        let lo = corners.into_iter().fold(f64::INFINITY, f64::min);
        let hi = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Self::of_library(lo, hi, defined)
    }
}

/// A number less than a result that may be off by this share of it; what overflowed is larger than any number.
fn below(value: f64, share: f64) -> f64 {
    match value {
        f64::INFINITY => f64::MAX,
        f64::NEG_INFINITY => value,
        _ => (value - share * value.abs()).next_down(),
    }
}

/// A number greater than a result that may be off by this share of it.
fn above(value: f64, share: f64) -> f64 {
    -below(-value, share)
}

impl From<f64> for Interval {
    fn from(value: f64) -> Self {
        Self::point(value)
    }
}

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
        let mut corners = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if corners.iter().any(|c| c.is_nan()) {
            corners = [
                times(self.lo, other.lo),
                times(self.lo, other.hi),
                times(self.hi, other.lo),
                times(self.hi, other.hi),
            ];
        }
        let [a, b, c, d] = corners;
        let (lo, hi) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of [0, 1) that fill it evenly.
    fn even(n: usize) -> f64 {
        (0.618_033_988_749_894_8 * (n as f64 + 0.5)).fract()
    }

    #[test]
    fn every_function_holds_its_values() {
        type Pair = (fn(f64) -> f64, fn(Interval) -> Interval, &'static str);
        let functions: [Pair; 20] = [
            (f64::abs, Interval::abs, "abs"),
            (f64::sqrt, Interval::sqrt, "sqrt"),
            (f64::cbrt, Interval::cbrt, "cbrt"),
            (f64::exp, Interval::exp, "exp"),
            (f64::ln, Interval::ln, "ln"),
            (f64::log10, Interval::log10, "log10"),
            (f64::log2, Interval::log2, "log2"),
            (f64::sin, Interval::sin, "sin"),
            (f64::cos, Interval::cos, "cos"),
            (f64::tan, Interval::tan, "tan"),
            (f64::asin, Interval::asin, "asin"),
            (f64::acos, Interval::acos, "acos"),
            (f64::atan, Interval::atan, "atan"),
            (f64::sinh, Interval::sinh, "sinh"),
            (f64::cosh, Interval::cosh, "cosh"),
            (f64::tanh, Interval::tanh, "tanh"),
            (f64::floor, Interval::floor, "floor"),
            (|v| v.powi(3), |v| v.powi(3), "cube"),
            (|v| v.powi(-2), |v| v.powi(-2), "inverse square"),
            (|v| v.powf(1.7), |v| v.powf(Interval::point(1.7)), "power"),
        ];
        for (f, enclosed, name) in functions {
            for k in 0..400 {
                let middle = 20.0 * (even(k) - 0.5);
                let half = 4.0 * even(3 * k + 1).powi(4);
                let set = Interval::new(middle - half, middle + half);
                let values = enclosed(set);
                let mut all = true;
                for n in 0..=40 {
                    let v = (set.lo + (set.hi - set.lo) * f64::from(n) / 40.0).min(set.hi);
                    let value = f(v);
                    all &= value.is_finite();
                    if value.is_finite() {
                        assert!(values.lo <= value && value <= values.hi, "{name} at {v}: {value} {values:?}");
                    }
                }
                assert!(all || !values.defined, "{name} over {set:?} is not defined everywhere");
            }
        }
    }

    #[test]
    fn operations_hold_their_values() {
        type Pair = (fn(f64, f64) -> f64, fn(Interval, Interval) -> Interval, &'static str);
        let operations: [Pair; 9] = [
            (|a, b| a + b, |a, b| a + b, "+"),
            (|a, b| a - b, |a, b| a - b, "-"),
            (|a, b| a * b, |a, b| a * b, "*"),
            (|a, b| a / b, |a, b| a / b, "/"),
            (f64::min, Interval::min, "min"),
            (f64::max, Interval::max, "max"),
            (f64::hypot, Interval::hypot, "hypot"),
            (f64::atan2, Interval::atan2, "atan2"),
            (f64::powf, Interval::powf, "power"),
        ];
        for (f, enclosed, name) in operations {
            for k in 0..400 {
                let of = |n: usize| {
                    let middle = 6.0 * (even(n) - 0.5);
                    let half = 3.0 * even(7 * n + 2).powi(3);
                    Interval::new(middle - half, middle + half)
                };
                let (a, b) = (of(k), of(k + 1000));
                let values = enclosed(a, b);
                for n in 0..=144 {
                    let at = |s: Interval, t: i32| (s.lo + (s.hi - s.lo) * f64::from(t) / 12.0).min(s.hi);
                    let value = f(at(a, n % 13), at(b, n / 13));
                    if value.is_finite() {
                        assert!(values.lo <= value && value <= values.hi, "{name} {a:?} {b:?}: {value} {values:?}");
                    } else {
                        assert!(!values.defined, "{name} {a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_has_no_value_is_told() {
        assert!(Interval::new(-2.0, -1.0).sqrt().is_empty());
        let part = Interval::new(-1.0, 4.0).sqrt();
        assert!(!part.defined && part.lo == 0.0 && part.hi >= 2.0);
        assert!((Interval::point(1.0) / Interval::ZERO).is_empty());
        assert!(!(Interval::point(1.0) / Interval::new(0.0, 1.0)).defined);
        let overflow = Interval::point(1e200) * Interval::point(1e200);
        assert_eq!(overflow.hi, f64::INFINITY);
        let line = Interval::new(3.0, f64::INFINITY);
        assert!(line.powi(2).lo > 8.9 && (line * line).lo > 8.9);
        assert_eq!((line * Interval::ZERO).hi, 0.0);
    }
}
