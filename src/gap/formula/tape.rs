//! A formula as a tape of operations.

use super::functions::{Number, One, Two};

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

    /// Where the operands of each operation begin.
    fn starts(&self) -> Vec<usize> {
        let mut starts: Vec<usize> = Vec::with_capacity(self.ops.len());
        let mut stack: Vec<usize> = Vec::new();
        for (k, op) in self.ops.iter().enumerate() {
            let start = match op {
                Op::Constant(_) | Op::Variable(_) => k,
                Op::Whole(_) | Op::One(_) => stack.pop().unwrap_or(k),
                Op::Two(_) => {
                    stack.pop();
                    stack.pop().unwrap_or(k)
                }
            };
            stack.push(start);
            starts.push(start);
        }
        starts
    }

    /// What it is the least of, as tapes of their own: itself where it is no minimum.
    pub(super) fn minima(&self) -> Vec<Self> {
        let starts = self.starts();
        let (mut parts, mut open) = (Vec::new(), vec![self.ops.len()]);
        while let Some(end) = open.pop() {
            match self.ops[end - 1] {
                Op::Two(Two::Min) => open.extend([end - 1, starts[end - 2]]),
                _ => parts.push(self.term(starts[end - 1], end, 1.0)),
            }
        }
        parts
    }

    /// The terms whose sum it is, as tapes of their own: through sums, differences, and products with a constant. Rounding of products of
    /// constants aside.
    pub(super) fn terms(&self) -> Vec<Self> {
        let starts = self.starts();
        let mut terms = Vec::new();
        let mut open = vec![(self.ops.len(), 1.0)];
        // From the end of an expression, and its factor.
        while let Some((end, factor)) = open.pop() {
            let last = end - 1;
            match self.ops[last] {
                Op::Two(f @ (Two::Add | Two::Subtract)) => {
                    let right = starts[last - 1];
                    open.push((last, if f == Two::Add { factor } else { -factor }));
                    open.push((right, factor));
                }
                Op::One(One::Negate) => open.push((last, -factor)),
                Op::Two(Two::Multiply) if matches!(self.ops[last - 1], Op::Constant(_)) => {
                    let Op::Constant(c) = self.ops[last - 1] else { continue };
                    open.push((last - 1, factor * c));
                }
                Op::Two(Two::Multiply) if matches!(self.ops[starts[last - 1] - 1], Op::Constant(_)) => {
                    let Op::Constant(c) = self.ops[starts[last - 1] - 1] else { continue };
                    open.push((last, factor * c));
                }
                Op::Two(Two::Divide) if matches!(self.ops[last - 1], Op::Constant(_)) => {
                    let Op::Constant(c) = self.ops[last - 1] else { continue };
                    open.push((last - 1, factor / c));
                }
                _ => terms.push(self.term(starts[last], end, factor)),
            }
        }
        terms
    }

    fn term(&self, start: usize, end: usize, factor: f64) -> Self {
        let mut term = Self::default();
        self.ops[start..end].iter().for_each(|op| term.push(*op));
        if factor != 1.0 {
            term.push(Op::Constant(factor));
            term.push(Op::Two(Two::Multiply));
        }
        term
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
