//! The functions of a formula, on numbers or intervals, alone or with their derivatives.

use crate::numeric::derivatives::{Chain, Cube, Dual, Jet, OfOne, OfTwo};
use crate::numeric::real::Real;

/// Functions of one operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum One {
    Negate,
    Abs,
    Sign,
    Sqrt,
    Cbrt,
    Exp,
    Ln,
    Log10,
    Log2,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Floor,
    Ceil,
}

/// Functions of two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Two {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Min,
    Max,
    Atan2,
    Hypot,
}

/// What a tape can be run on.
pub(super) trait Number: Copy {
    fn constant(value: f64) -> Self;
    fn one(self, f: One) -> Self;
    fn two(self, b: Self, f: Two) -> Self;
    fn whole(self, n: i32) -> Self;
}

impl One {
    fn value<T: Real>(self, v: T) -> T {
        match self {
            Self::Negate => -v,
            Self::Abs => v.abs(),
            Self::Sign => v.sign(),
            Self::Sqrt => v.sqrt(),
            Self::Cbrt => v.cbrt(),
            Self::Exp => v.exp(),
            Self::Ln => v.ln(),
            Self::Log10 => v.log10(),
            Self::Log2 => v.log2(),
            Self::Sin => v.sin(),
            Self::Cos => v.cos(),
            Self::Tan => v.tan(),
            Self::Asin => v.asin(),
            Self::Acos => v.acos(),
            Self::Atan => v.atan(),
            Self::Sinh => v.sinh(),
            Self::Cosh => v.cosh(),
            Self::Tanh => v.tanh(),
            Self::Floor => v.floor(),
            Self::Ceil => v.ceil(),
        }
    }

    fn slope<T: Real>(self, v: T) -> T {
        let c = T::from;
        match self {
            Self::Negate => c(-1.0),
            Self::Abs => v.slope_of_abs(),
            Self::Sign => v.flat_but_at_zero(),
            Self::Sqrt => c(0.5) / v.sqrt(),
            Self::Cbrt => c(1.0) / (c(3.0) * v.cbrt().powi(2)),
            Self::Exp => v.exp(),
            Self::Ln => c(1.0) / v,
            Self::Log10 => c(std::f64::consts::LOG10_E) / v,
            Self::Log2 => c(std::f64::consts::LOG2_E) / v,
            Self::Sin => v.cos(),
            Self::Cos => -v.sin(),
            Self::Tan => c(1.0) + v.tan().powi(2),
            Self::Asin => c(1.0) / ((c(1.0) - v) * (c(1.0) + v)).sqrt(),
            Self::Acos => c(-1.0) / ((c(1.0) - v) * (c(1.0) + v)).sqrt(),
            Self::Atan => c(1.0) / (c(1.0) + v.powi(2)),
            Self::Sinh => v.cosh(),
            Self::Cosh => v.sinh(),
            Self::Tanh => c(1.0) - v.tanh().powi(2),
            Self::Floor | Self::Ceil => v.flat_but_at_whole(),
        }
    }

    fn curvature<T: Real>(self, v: T) -> T {
        let c = T::from;
        match self {
            Self::Negate => c(0.0),
            Self::Abs | Self::Sign => v.flat_but_at_zero(),
            Self::Sqrt => c(-0.25) / (v * v.sqrt()),
            Self::Cbrt => c(-2.0) / (c(9.0) * v * v.cbrt().powi(2)),
            Self::Exp => v.exp(),
            Self::Ln => c(-1.0) / v.powi(2),
            Self::Log10 => c(-std::f64::consts::LOG10_E) / v.powi(2),
            Self::Log2 => c(-std::f64::consts::LOG2_E) / v.powi(2),
            Self::Sin => -v.sin(),
            Self::Cos => -v.cos(),
            Self::Tan => c(2.0) * v.tan() * (c(1.0) + v.tan().powi(2)),
            Self::Asin => {
                let s = (c(1.0) - v) * (c(1.0) + v);
                v / (s * s.sqrt())
            }
            Self::Acos => -Self::Asin.curvature(v),
            Self::Atan => c(-2.0) * v / (c(1.0) + v.powi(2)).powi(2),
            Self::Sinh => v.sinh(),
            Self::Cosh => v.cosh(),
            Self::Tanh => c(-2.0) * v.tanh() * (c(1.0) - v.tanh().powi(2)),
            Self::Floor | Self::Ceil => v.flat_but_at_whole(),
        }
    }

    fn third<T: Real>(self, v: T) -> T {
        let c = T::from;
        match self {
            Self::Negate => c(0.0),
            Self::Abs | Self::Sign => v.flat_but_at_zero(),
            Self::Sqrt => c(0.375) / (v.powi(2) * v.sqrt()),
            Self::Cbrt => c(10.0) / (c(27.0) * (v * v.cbrt()).powi(2)),
            Self::Exp => v.exp(),
            Self::Ln => c(2.0) / v.powi(3),
            Self::Log10 => c(2.0 * std::f64::consts::LOG10_E) / v.powi(3),
            Self::Log2 => c(2.0 * std::f64::consts::LOG2_E) / v.powi(3),
            Self::Sin => -v.cos(),
            Self::Cos => v.sin(),
            Self::Tan => {
                let square = v.tan().powi(2);
                c(2.0) * (c(1.0) + square) * (c(1.0) + c(3.0) * square)
            }
            Self::Asin => {
                let s = (c(1.0) - v) * (c(1.0) + v);
                (c(1.0) + c(2.0) * v.powi(2)) / (s.powi(2) * s.sqrt())
            }
            Self::Acos => -Self::Asin.third(v),
            Self::Atan => (c(6.0) * v.powi(2) - c(2.0)) / (c(1.0) + v.powi(2)).powi(3),
            Self::Sinh => v.cosh(),
            Self::Cosh => v.sinh(),
            Self::Tanh => {
                let square = v.tanh().powi(2);
                (c(1.0) - square) * (c(6.0) * square - c(2.0))
            }
            Self::Floor | Self::Ceil => v.flat_but_at_whole(),
        }
    }
}

impl Two {
    fn value<T: Real>(self, v: T, w: T) -> T {
        match self {
            Self::Add => v + w,
            Self::Subtract => v - w,
            Self::Multiply => v * w,
            Self::Divide => v / w,
            Self::Power => v.powf(w),
            Self::Min => v.min(w),
            Self::Max => v.max(w),
            Self::Atan2 => v.atan2(w),
            Self::Hypot => v.hypot(w),
        }
    }

    fn slopes<T: Real>(self, v: T, w: T) -> [T; 2] {
        let c = T::from;
        match self {
            Self::Add => [c(1.0), c(1.0)],
            Self::Subtract => [c(1.0), c(-1.0)],
            Self::Multiply => [w, v],
            Self::Divide => [c(1.0) / w, -v / w.powi(2)],
            Self::Power => [if w.is_zero() { w } else { w * v.powf(w - c(1.0)) }, v.powf(w) * v.ln()],
            Self::Min | Self::Max => {
                // Where it changes which of them it is, [`Number`] takes both.
                let first = v.is_below(w).unwrap_or(true) == (self == Self::Min);
                if first { [c(1.0), c(0.0)] } else { [c(0.0), c(1.0)] }
            }
            Self::Atan2 => {
                let s = v.powi(2) + w.powi(2);
                [w / s, -v / s]
            }
            Self::Hypot => {
                let r = v.hypot(w);
                [v.share_of(r), w.share_of(r)]
            }
        }
    }

    fn curvatures<T: Real>(self, v: T, w: T) -> [T; 3] {
        let c = T::from;
        match self {
            Self::Add | Self::Subtract | Self::Min | Self::Max => [c(0.0); 3],
            Self::Multiply => [c(0.0), c(1.0), c(0.0)],
            Self::Divide => [c(0.0), c(-1.0) / w.powi(2), c(2.0) * v / w.powi(3)],
            Self::Power => {
                let both = v.powf(w - c(1.0)) * (c(1.0) + w * v.ln());
                let first = w * (w - c(1.0)) * v.powf(w - c(2.0));
                [if (w - c(1.0)).is_zero() { c(0.0) } else { first }, both, v.powf(w) * v.ln().powi(2)]
            }
            Self::Atan2 => {
                let s = (v.powi(2) + w.powi(2)).powi(2);
                let mixed = (v.powi(2) - w.powi(2)) / s;
                [c(-2.0) * v * w / s, mixed, c(2.0) * v * w / s]
            }
            Self::Hypot => {
                let r = v.hypot(w).powi(3);
                [w.powi(2) / r, -(v * w) / r, v.powi(2) / r]
            }
        }
    }

    fn thirds<T: Real>(self, v: T, w: T) -> [T; 4] {
        let c = T::from;
        match self {
            Self::Add | Self::Subtract | Self::Multiply | Self::Min | Self::Max => [c(0.0); 4],
            Self::Divide => [c(0.0), c(0.0), c(2.0) / w.powi(3), c(-6.0) * v / w.powi(4)],
            Self::Power => {
                let (less, least) = (w - c(1.0), w - c(2.0));
                let whole = w.is_zero() || less.is_zero() || least.is_zero();
                let first = || w * less * least * v.powf(w - c(3.0));
                let second = v.powf(least) * (c(2.0) * w - c(1.0) + w * less * v.ln());
                let third = v.powf(less) * v.ln() * (c(2.0) + w * v.ln());
                [if whole { c(0.0) } else { first() }, second, third, v.powf(w) * v.ln().powi(3)]
            }
            Self::Atan2 => {
                let s = (v.powi(2) + w.powi(2)).powi(3);
                let first = w * (c(6.0) * v.powi(2) - c(2.0) * w.powi(2)) / s;
                let second = v * (c(6.0) * w.powi(2) - c(2.0) * v.powi(2)) / s;
                // A harmonic function.
                [first, second, -first, -second]
            }
            Self::Hypot => {
                let r = v.hypot(w).powi(5);
                [
                    c(-3.0) * v * w.powi(2) / r,
                    w * (c(2.0) * v.powi(2) - w.powi(2)) / r,
                    v * (c(2.0) * w.powi(2) - v.powi(2)) / r,
                    c(-3.0) * v.powi(2) * w / r,
                ]
            }
        }
    }
}

impl<T: Real> Number for T {
    fn constant(value: f64) -> Self {
        T::from(value)
    }

    fn one(self, f: One) -> Self {
        f.value(self)
    }

    fn two(self, b: Self, f: Two) -> Self {
        f.value(self, b)
    }

    fn whole(self, n: i32) -> Self {
        self.powi(n)
    }
}

/// A function at an operand.
struct At<T>(One, T);

impl<T: Real> OfOne<T> for At<T> {
    fn slope(&self) -> T {
        self.0.slope(self.1)
    }

    fn curvature(&self) -> T {
        self.0.curvature(self.1)
    }

    fn third(&self) -> T {
        self.0.third(self.1)
    }
}

/// A function at two.
struct AtBoth<T>(Two, T, T);

impl<T: Real> OfTwo<T> for AtBoth<T> {
    fn slopes(&self) -> [T; 2] {
        self.0.slopes(self.1, self.2)
    }

    fn curvatures(&self) -> [T; 3] {
        self.0.curvatures(self.1, self.2)
    }

    fn thirds(&self) -> [T; 4] {
        self.0.thirds(self.1, self.2)
    }
}

/// v^n.
struct Whole<T>(T, i32);

impl<T: Real> Whole<T> {
    /// c v^k.
    fn power(&self, k: i32, c: f64) -> T {
        if c == 0.0 { T::from(0.0) } else { T::from(c) * self.0.powi(k) }
    }
}

impl<T: Real> OfOne<T> for Whole<T> {
    fn slope(&self) -> T {
        self.power(self.1 - 1, f64::from(self.1))
    }

    fn curvature(&self) -> T {
        let n = f64::from(self.1);
        self.power(self.1 - 2, n * (n - 1.0))
    }

    fn third(&self) -> T {
        let n = f64::from(self.1);
        self.power(self.1 - 3, n * (n - 1.0) * (n - 2.0))
    }
}

/// A tape is run on quantities with derivatives in the same way to first, second and third order.
macro_rules! with_derivatives {
    ($quantity:ident, $($value:ident).+) => {
        impl<T: Real> Number for $quantity<T> {
            fn constant(value: f64) -> Self {
                Chain::constant(value)
            }

            fn one(self, f: One) -> Self {
                let v = self.$($value).+;
                match f {
                    One::Negate => self.minus(),
                    _ => self.chain(f.value(v), &At(f, v)),
                }
            }

            fn two(self, b: Self, f: Two) -> Self {
                let (v, w) = (self.$($value).+, b.$($value).+);
                match f {
                    Two::Add => return self.plus(b),
                    Two::Subtract => return self.plus(b.minus()),
                    // 0 times what has no bound is not 0 here: that is left to [`Chain::chain2`].
                    Two::Multiply if b.is_constant() && !w.is_zero() => return self.linear(|d| d * w),
                    Two::Multiply if self.is_constant() && !v.is_zero() => return b.linear(|d| v * d),
                    Two::Divide if b.is_constant() => return self.linear(|d| d / w),
                    _ => {}
                }
                let value = f.value(v, w);
                if matches!(f, Two::Min | Two::Max) && v.is_below(w).is_none() {
                    return self.either(b, value);
                }
                self.chain2(b, value, &AtBoth(f, v, w))
            }

            fn whole(self, n: i32) -> Self {
                let v = self.$($value).+;
                self.chain(v.powi(n), &Whole(v, n))
            }
        }
    };
}

with_derivatives!(Dual, value);
with_derivatives!(Jet, value);
with_derivatives!(Cube, jet.value);
