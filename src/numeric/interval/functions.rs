//! Functions of intervals.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Interval;

/// Relative widening of a function of the mathematical library.
const LIBRARY: f64 = 8.0 * f64::EPSILON;

impl Interval {
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
