//! The degree of a formula that is a constant and a homogeneous function.

use super::Node;
use crate::gap::formula::THETA;
use crate::gap::formula::functions::{Number, One, Two};

/// A constant and a homogeneous function; the degree is `None` where the function is zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Homogeneous {
    pub constant: f64,
    pub degree: Option<f64>,
}

impl Homogeneous {
    fn pure(degree: f64) -> Option<Self> {
        Some(Self { constant: 0.0, degree: Some(degree) })
    }

    /// The degree of what has no constant beside it; a number is of degree 0, and 0 of any.
    fn alone(self) -> Option<f64> {
        match self.degree {
            Some(k) if self.constant == 0.0 => Some(k),
            None => Some(0.0),
            Some(_) => None,
        }
    }

    fn is_zero(self) -> bool {
        self.degree.is_none() && self.constant == 0.0
    }
}

/// The rule of a node.
pub(super) fn homogeneous(node: Node, of: &[Homogeneous]) -> Option<Homogeneous> {
    // The degree that two share, a zero having any.
    let common = |a: Homogeneous, b: Homogeneous| match (a.is_zero(), b.is_zero()) {
        (true, _) => b.alone(),
        (_, true) => a.alone(),
        _ => a.alone().zip(b.alone()).filter(|(j, k)| j == k).map(|(k, _)| k),
    };
    let number = |constant: f64| Some(Homogeneous { constant, degree: None });
    match node {
        Node::Constant(c) => number(c),
        Node::Variable(THETA) => Homogeneous::pure(0.0),
        Node::Variable(_) => Homogeneous::pure(1.0),
        Node::Whole(a, 1) => Some(of[a]),
        Node::Whole(a, n) if of[a].degree.is_none() => number(of[a].constant.whole(n)),
        Node::Whole(a, n) => Homogeneous::pure(of[a].alone()? * f64::from(n)),
        Node::One(f, a) if of[a].degree.is_none() => number(of[a].constant.one(f)),
        Node::One(One::Negate, a) => Some(Homogeneous { constant: -of[a].constant, ..of[a] }),
        Node::One(f, a) => {
            let k = of[a].alone()?;
            match f {
                One::Abs => Homogeneous::pure(k),
                One::Sqrt => Homogeneous::pure(0.5 * k),
                One::Cbrt => Homogeneous::pure(k / 3.0),
                One::Sign => Homogeneous::pure(0.0),
                _ if k == 0.0 => Homogeneous::pure(0.0),
                _ => None,
            }
        }
        Node::Two(f, a, b) => {
            let (p, q) = (of[a], of[b]);
            if p.degree.is_none() && q.degree.is_none() {
                return number(p.constant.two(q.constant, f));
            }
            match f {
                Two::Add | Two::Subtract => {
                    let sign = if f == Two::Add { 1.0 } else { -1.0 };
                    let degree = match (p.degree, q.degree) {
                        (Some(j), Some(k)) if j != k => return None,
                        (j, k) => j.or(k),
                    };
                    // A constant is of degree 0 itself.
                    let constant = if degree == Some(0.0) { 0.0 } else { p.constant + sign * q.constant };
                    Some(Homogeneous { constant, degree })
                }
                Two::Multiply => match (p.degree, q.degree) {
                    (None, _) => Some(Homogeneous { constant: p.constant * q.constant, ..q }),
                    (_, None) => Some(Homogeneous { constant: p.constant * q.constant, ..p }),
                    _ => Homogeneous::pure(p.alone()? + q.alone()?),
                },
                Two::Divide if q.degree.is_none() => Some(Homogeneous { constant: p.constant / q.constant, ..p }),
                Two::Divide => Homogeneous::pure(p.alone()? - q.alone()?),
                Two::Power if q.degree.is_none() => Homogeneous::pure(p.alone()? * q.constant),
                Two::Power => {
                    (p.alone()? == 0.0 && q.alone()? == 0.0).then_some(()).and_then(|()| Homogeneous::pure(0.0))
                }
                Two::Min | Two::Max | Two::Hypot => Homogeneous::pure(common(p, q)?),
                Two::Atan2 => common(p, q).and_then(|_| Homogeneous::pure(0.0)),
            }
        }
    }
}
