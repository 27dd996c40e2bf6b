//! Formulas that come back to each of their values, again and again, along x or y: rows of contacts without end.
//!
//! Where y stands in sines, cosines and tangents of linear functions of it alone, the formula is for every x a function of points on a torus
//! that move with y along a straight line, which comes as near to every point of it as one likes, again and again (Poincare 1890). Where the
//! formula is continuous it falls below any depth that it is below once.

use super::Node;
use crate::gap::formula::functions::{One, Two};
use crate::gap::formula::{R, THETA};

/// How a value depends on one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Recurrence {
    /// Not at all.
    Constant,
    Linear,
    /// A continuous function of points on a torus.
    Recurrent,
}

/// The rule of a node; `None` where it may be anything else.
pub(super) fn recurrence(node: Node, of: &[Recurrence], axis: usize) -> Option<Recurrence> {
    use Recurrence::{Constant, Linear, Recurrent};
    Some(match node {
        Node::Constant(_) => Constant,
        Node::Variable(R | THETA) => return None,
        Node::Variable(k) => {
            if k == axis {
                Linear
            } else {
                Constant
            }
        }
        Node::Whole(a, n) => match of[a] {
            Linear if n != 1 => return None,
            same => same,
        },
        Node::One(f, a) => match (of[a], f) {
            (Constant, _) => Constant,
            (Linear, One::Negate) => Linear,
            (Linear, One::Sin | One::Cos | One::Tan) => Recurrent,
            (Linear, _) | (Recurrent, One::Sign | One::Floor | One::Ceil) => return None,
            (Recurrent, _) => Recurrent,
        },
        Node::Two(f, a, b) => match (of[a], of[b]) {
            (Constant, Constant) => Constant,
            (Linear, Constant | Linear) | (Constant, Linear) if matches!(f, Two::Add | Two::Subtract) => Linear,
            (Linear, Constant) if matches!(f, Two::Multiply | Two::Divide) => Linear,
            (Constant, Linear) if f == Two::Multiply => Linear,
            (Linear, _) | (_, Linear) => return None,
            _ if f == Two::Atan2 => return None,
            _ => Recurrent,
        },
    })
}
