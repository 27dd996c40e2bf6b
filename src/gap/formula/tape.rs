//! A formula as a tape of operations, run on numbers or on numbers with their gradient.

/// Operands that can wait at once; enough for any formula a person writes.
pub(super) const STACK: usize = 48;

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
    fn value(self) -> f64;
    /// A function of this number: its value, and its slope where that is needed.
    fn chain(self, value: f64, slope: impl FnOnce() -> f64) -> Self;
    /// A function of two numbers: its value, and its two partial derivatives where they are needed.
    fn chain2(self, other: Self, value: f64, slopes: impl FnOnce() -> [f64; 2]) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn chain(self, value: f64, _: impl FnOnce() -> f64) -> Self {
        value
    }

    fn chain2(self, _: Self, value: f64, _: impl FnOnce() -> [f64; 2]) -> Self {
        value
    }
}

/// A number and its derivatives with respect to x and y (forward differentiation, Wengert 1964).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dual {
    pub value: f64,
    pub gradient: [f64; 2],
}

impl Number for Dual {
    fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; 2] }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn chain(self, value: f64, slope: impl FnOnce() -> f64) -> Self {
        let slope = slope();
        Self { value, gradient: self.gradient.map(|g| times(slope, g)) }
    }

    fn chain2(self, other: Self, value: f64, slopes: impl FnOnce() -> [f64; 2]) -> Self {
        let [a, b] = slopes();
        let [s, o] = [self.gradient, other.gradient];
        Self { value, gradient: [0, 1].map(|m| times(a, s[m]) + times(b, o[m])) }
    }
}

/// What does not change has no share, however steep the function: x^y at constant y asks for ln x, which may not exist.
fn times(slope: f64, change: f64) -> f64 {
    if change == 0.0 && !slope.is_infinite() { 0.0 } else { slope * change }
}

impl One {
    fn apply<T: Number>(self, a: T) -> T {
        let v = a.value();
        match self {
            Self::Negate => a.chain(-v, || -1.0),
            Self::Abs => a.chain(v.abs(), || 1f64.copysign(v)),
            Self::Sign => a.chain(if v == 0.0 { 0.0 } else { v.signum() }, || 0.0),
            Self::Sqrt => a.chain(v.sqrt(), || 0.5 / v.sqrt()),
            Self::Cbrt => a.chain(v.cbrt(), || 1.0 / (3.0 * v.cbrt().powi(2))),
            Self::Exp => a.chain(v.exp(), || v.exp()),
            Self::Ln => a.chain(v.ln(), || 1.0 / v),
            Self::Log10 => a.chain(v.log10(), || std::f64::consts::LOG10_E / v),
            Self::Log2 => a.chain(v.log2(), || std::f64::consts::LOG2_E / v),
            Self::Sin => a.chain(v.sin(), || v.cos()),
            Self::Cos => a.chain(v.cos(), || -v.sin()),
            Self::Tan => a.chain(v.tan(), || 1.0 + v.tan().powi(2)),
            Self::Asin => a.chain(v.asin(), || 1.0 / ((1.0 - v) * (1.0 + v)).sqrt()),
            Self::Acos => a.chain(v.acos(), || -1.0 / ((1.0 - v) * (1.0 + v)).sqrt()),
            Self::Atan => a.chain(v.atan(), || 1.0 / (1.0 + v * v)),
            Self::Sinh => a.chain(v.sinh(), || v.cosh()),
            Self::Cosh => a.chain(v.cosh(), || v.sinh()),
            Self::Tanh => a.chain(v.tanh(), || 1.0 - v.tanh().powi(2)),
            Self::Floor => a.chain(v.floor(), || 0.0),
            Self::Ceil => a.chain(v.ceil(), || 0.0),
        }
    }
}

impl Two {
    fn apply<T: Number>(self, a: T, b: T) -> T {
        let (v, w) = (a.value(), b.value());
        let chosen = |first: bool| if first { [1.0, 0.0] } else { [0.0, 1.0] };
        // Unlike f64::min and max, NaN stays NaN: what has no value has no material.
        let undefined = v.is_nan() || w.is_nan();
        match self {
            Self::Add => a.chain2(b, v + w, || [1.0, 1.0]),
            Self::Subtract => a.chain2(b, v - w, || [1.0, -1.0]),
            Self::Multiply => a.chain2(b, v * w, || [w, v]),
            Self::Divide => a.chain2(b, v / w, || [1.0 / w, -v / w / w]),
            Self::Power => a.chain2(b, v.powf(w), || {
                let rise = if w == 0.0 { 0.0 } else { w * v.powf(w - 1.0) };
                [rise, if v == 0.0 && w > 0.0 { 0.0 } else { v.powf(w) * v.ln() }]
            }),
            Self::Min => a.chain2(b, if undefined { f64::NAN } else { v.min(w) }, || chosen(v <= w)),
            Self::Max => a.chain2(b, if undefined { f64::NAN } else { v.max(w) }, || chosen(v >= w)),
            Self::Atan2 => a.chain2(b, v.atan2(w), || [w / (v * v + w * w), -v / (v * v + w * w)]),
            Self::Hypot => a.chain2(b, v.hypot(w), || [v / v.hypot(w), w / v.hypot(w)]),
        }
    }
}

fn whole<T: Number>(a: T, n: i32) -> T {
    let v = a.value();
    a.chain(v.powi(n), || if n == 0 { 0.0 } else { f64::from(n) * v.powi(n - 1) })
}

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
            (Op::One(f), &[Op::Constant(a)]) => Op::Constant(f.apply(a)),
            (Op::Whole(n), &[Op::Constant(a)]) => Op::Constant(whole(a, n)),
            (Op::Two(f), &[Op::Constant(a), Op::Constant(b)]) => Op::Constant(f.apply(a, b)),
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

    /// The value for these x, y, r, theta.
    pub(super) fn run<T: Number>(&self, variables: [T; 4]) -> T {
        let mut stack = [T::constant(0.0); STACK];
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
                Op::Whole(n) => stack[top - 1] = whole(stack[top - 1], n),
                Op::One(f) => stack[top - 1] = f.apply(stack[top - 1]),
                Op::Two(f) => {
                    top -= 1;
                    stack[top - 1] = f.apply(stack[top - 1], stack[top]);
                }
            }
        }
        stack[0]
    }
}
