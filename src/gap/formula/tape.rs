//! A formula as a tape of operations, run on numbers or intervals, alone or with their derivatives.

use crate::numeric::derivatives::{Chain, Dual, Jet, Real};

/// Operands that can wait at once; enough for any formula a person writes.
pub(super) const STACK: usize = 48;

/// Operands that wait at once in most formulas.
const FEW: usize = 5;

/// One operation, in reverse Polish order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Op {
    Constant(f64),
    /// Index into x, y, r, theta.
    Variable(usize),
    /// Power with a small whole exponent.
    Whole(i32),
    One(One),
    Two(Two),
}

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
            Self::Hypot => [v / v.hypot(w), w / v.hypot(w)],
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

/// A tape is run on quantities with derivatives in the same way to first and to second order.
macro_rules! with_derivatives {
    ($quantity:ident) => {
        impl<T: Real> Number for $quantity<T> {
            fn constant(value: f64) -> Self {
                Chain::constant(value)
            }

            fn one(self, f: One) -> Self {
                let v = self.value;
                match f {
                    One::Negate => self.minus(),
                    _ => self.chain(f.value(v), || f.slope(v), || f.curvature(v)),
                }
            }

            fn two(self, b: Self, f: Two) -> Self {
                let (v, w) = (self.value, b.value);
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
                self.chain2(b, value, || f.slopes(v, w), || f.curvatures(v, w))
            }

            fn whole(self, n: i32) -> Self {
                let v = self.value;
                let c = f64::from(n);
                let power = |k: i32, c: f64| if c == 0.0 { T::from(0.0) } else { T::from(c) * v.powi(k) };
                self.chain(v.powi(n), || power(n - 1, c), || power(n - 2, c * (c - 1.0)))
            }
        }
    };
}

with_derivatives!(Dual);
with_derivatives!(Jet);

/// A checked sequence of operations that leaves one number.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tape {
    ops: Vec<Op>,
    /// Numbers on the stack now, and the most there have been.
    height: usize,
    highest: usize,
}

impl Tape {
    /// Appends an operation; constants are folded at once.
    pub(super) fn push(&mut self, op: Op) {
        let taken = match op {
            Op::Constant(_) | Op::Variable(_) => 0,
            Op::Whole(_) | Op::One(_) => 1,
            Op::Two(_) => 2,
        };
        debug_assert!(self.height >= taken, "operands come before their operation");
        self.height = self.height + 1 - taken;
        self.highest = self.highest.max(self.height);
        let kept = self.ops.len() - taken;
        let op = match (op, &self.ops[kept..]) {
            (Op::One(f), &[Op::Constant(a)]) => Op::Constant(a.one(f)),
            (Op::Whole(n), &[Op::Constant(a)]) => Op::Constant(a.whole(n)),
            (Op::Two(f), &[Op::Constant(a), Op::Constant(b)]) => Op::Constant(a.two(b, f)),
            // Whole powers by multiplication.
            (Op::Two(Two::Power), &[.., Op::Constant(n)]) if n.fract() == 0.0 && n.abs() <= 16.0 => {
                self.ops.pop();
                self.ops.push(Op::Whole(n as i32));
                return;
            }
            (op, _) => {
                self.ops.push(op);
                return;
            }
        };
        self.ops.truncate(kept);
        self.ops.push(op);
    }

    pub(super) fn ops(&self) -> &[Op] {
        &self.ops
    }

    /// Whether it needs no more room than there is.
    pub(super) fn fits(&self) -> bool {
        self.highest <= STACK
    }

    /// Whether a variable is used.
    pub(super) fn uses(&self, variable: usize) -> bool {
        self.ops.contains(&Op::Variable(variable))
    }

    /// Whether a step towards the value made an infinite number of finite ones without a division by zero or a logarithm of it: the
    /// value is then beyond the range of numbers, or not to be told.
    pub(super) fn overflows(&self, variables: [f64; 4]) -> bool {
        let mut stack: Vec<f64> = Vec::new();
        for &op in &self.ops {
            let (value, too_large) = match op {
                Op::Constant(c) => (c, false),
                Op::Variable(k) => (variables[k], false),
                Op::Whole(n) => {
                    let a = stack.pop().unwrap_or(f64::NAN);
                    (a.whole(n), a.is_finite() && a != 0.0)
                }
                Op::One(f) => {
                    let a = stack.pop().unwrap_or(f64::NAN);
                    (a.one(f), a.is_finite() && matches!(f, One::Exp | One::Sinh | One::Cosh))
                }
                Op::Two(f) => {
                    let (b, a) = (stack.pop().unwrap_or(f64::NAN), stack.pop().unwrap_or(f64::NAN));
                    let zero = (f == Two::Divide && b == 0.0) || (f == Two::Power && a == 0.0);
                    (a.two(b, f), a.is_finite() && b.is_finite() && !zero)
                }
            };
            if value.is_infinite() && too_large {
                return true;
            }
            stack.push(value);
        }
        false
    }

    /// The value for these x, y, r, theta.
    pub(super) fn run<T: Number>(&self, variables: [T; 4]) -> T {
        // Most formulas wait for few operands; the room for all is not laid out for them.
        if self.highest <= FEW { self.run_in::<T, FEW>(variables) } else { self.run_in::<T, STACK>(variables) }
    }

    fn run_in<T: Number, const ROOM: usize>(&self, variables: [T; 4]) -> T {
        let mut stack = [T::constant(0.0); ROOM];
        let mut top = 0;
        for &op in &self.ops {
            match op {
                Op::Constant(value) => {
                    stack[top] = T::constant(value);
                    top += 1;
                }
                Op::Variable(k) => {
                    stack[top] = variables[k];
                    top += 1;
                }
                Op::Whole(n) => stack[top - 1] = stack[top - 1].whole(n),
                Op::One(f) => stack[top - 1] = stack[top - 1].one(f),
                Op::Two(f) => {
                    top -= 1;
                    stack[top - 1] = stack[top - 1].two(stack[top], f);
                }
            }
        }
        stack[0]
    }
}
