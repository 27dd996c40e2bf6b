//! The mirrors of a formula.

use super::Node;
use crate::gap::formula::functions::{One, Two};
use crate::gap::formula::{R, THETA};

/// How a value changes when x (or y) changes its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parity {
    Even,
    Odd,
    Neither,
}

/// The rule of a node.
pub(super) fn parity(node: Node, of: &[Parity], axis: usize) -> Parity {
    use Parity::{Even, Neither, Odd};
    let product = |a: Parity, b: Parity| match (a, b) {
        (Neither, _) | (_, Neither) => Neither,
        (a, b) if a == b => Even,
        _ => Odd,
    };
    match node {
        Node::Constant(_) | Node::Variable(R) => Even,
        // atan2(y, x): odd in y.
        Node::Variable(THETA) => {
            if axis == 1 {
                Odd
            } else {
                Neither
            }
        }
        Node::Variable(k) => {
            if k == axis {
                Odd
            } else {
                Even
            }
        }
        Node::Whole(a, n) => match of[a] {
            Odd if n % 2 == 0 => Even,
            same => same,
        },
        Node::One(f, a) => match (of[a], f) {
            (Odd, One::Abs | One::Cos | One::Cosh) => Even,
            (
                Odd,
                One::Negate
                | One::Sign
                | One::Cbrt
                | One::Sin
                | One::Tan
                | One::Asin
                | One::Atan
                | One::Sinh
                | One::Tanh,
            ) => Odd,
            (Even, _) => Even,
            _ => Neither,
        },
        Node::Two(f, a, b) => match f {
            Two::Add | Two::Subtract => {
                if of[a] == of[b] {
                    of[a]
                } else {
                    Neither
                }
            }
            Two::Multiply | Two::Divide => product(of[a], of[b]),
            Two::Hypot => {
                if of[a] == Neither || of[b] == Neither {
                    Neither
                } else {
                    Even
                }
            }
            Two::Atan2 if of[a] == Odd && of[b] == Even => Odd,
            _ => {
                if of[a] == Even && of[b] == Even {
                    Even
                } else {
                    Neither
                }
            }
        },
    }
}
