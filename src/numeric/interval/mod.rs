//! Interval arithmetic: the set of values of an expression over a set of points, enclosed.
//!
//! +, -, *, / and the square root round to nearest, so the neighbouring floats enclose the exact result (IEEE 754). Other functions
//! come from the system's mathematical library, whose largest known error is 4 units in the last place (glibc manual, "Known Maximum
//! Errors in Math Functions"); results are widened by 8.

mod arithmetic;
mod functions;

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

    /// a/b for b >= 0, known to lie in `all` wherever it has a value.
    #[must_use]
    pub fn quotient_within(self, b: Self, all: Self) -> Self {
        if b.lo > 0.0 { (self / b).intersection(all) } else { all }
    }

    /// With ends one float further out. An end that overflowed leaves the value undefined.
    fn outward(lo: f64, hi: f64, defined: bool) -> Self {
        if lo.is_nan() || hi.is_nan() {
            return Self::UNKNOWN;
        }
        Self { lo: lo.next_down(), hi: hi.next_up(), defined }
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
