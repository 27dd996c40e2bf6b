//! Numbers side by side, so that each operation of a tape is looked up once for all of them.

use super::functions::{Number, One, Two};
use crate::numeric::real::Real;

/// As many as the points of a 3 x 3 rule.
pub(super) const LANES: usize = 9;

#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes(pub [f64; LANES]);

impl Lanes {
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn with(self, b: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], b.0[k])))
    }
}

impl Number for Lanes {
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }

    fn one(self, f: One) -> Self {
        match f {
            One::Negate => self.each(|v| -v),
            One::Abs => self.each(f64::abs),
            One::Sqrt => self.each(f64::sqrt),
            _ => self.each(|v| v.one(f)),
        }
    }

    fn two(self, b: Self, f: Two) -> Self {
        match f {
            Two::Add => self.with(b, |v, w| v + w),
            Two::Subtract => self.with(b, |v, w| v - w),
            Two::Multiply => self.with(b, |v, w| v * w),
            Two::Divide => self.with(b, |v, w| v / w),
            _ => self.with(b, |v, w| v.two(w, f)),
        }
    }

    fn whole(self, n: i32) -> Self {
        match n {
            2 => self.each(|v| v * v),
            _ => self.each(|v| Real::powi(v, n)),
        }
    }
}
