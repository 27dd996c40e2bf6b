//! What a formula is, read from the tree of its operations: its degree, its polynomial, whether it depends on the distance alone,
//! its mirrors.
//!
//! The variables may be moved: a formula in (x - a) and (y - b) alone is one about the point (a, b).

mod homogeneous;
mod parity;
mod polynomial;
mod radial;
mod recurrence;

use std::f64::consts::FRAC_PI_2;

use self::homogeneous::homogeneous;
use self::parity::{Parity, parity};
use self::polynomial::Polynomial;
use self::radial::{Radial, radial};
use self::recurrence::{Recurrence, recurrence};
use super::functions::{Number, One, Two};
use super::tape::{Op, Tape};
use super::{R, THETA};
use crate::gap::{Degree, Generatrix, Law, Quadratic};

/// Coefficients that differ by rounding alone are equal.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// An operation and its operands, which come before it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Node {
    Constant(f64),
    Variable(usize),
    Whole(usize, i32),
    One(One, usize),
    Two(Two, usize, usize),
}

/// A formula as a tree; the last node is its value.
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// The point that x and y are counted from.
    about: [f64; 2],
}

impl Tree {
    /// The tree of a tape, about the point that its variables are counted from.
    pub fn new(tape: &Tape) -> Self {
        let mut nodes: Vec<Node> = Vec::new();
        let mut stack = Vec::new();
        for &op in tape.ops() {
            // Even powers of r are polynomials in x and y.
            if let (Op::Whole(n), Some(&last)) = (op, stack.last())
                && n % 2 == 0
                && nodes[last] == Node::Variable(R)
            {
                stack.pop();
                nodes.pop();
                let first = nodes.len();
                nodes.extend([Node::Variable(0), Node::Whole(first, 2), Node::Variable(1), Node::Whole(first + 2, 2)]);
                nodes.extend([Node::Two(Two::Add, first + 1, first + 3), Node::Whole(first + 4, n / 2)]);
                stack.push(first + 5);
                continue;
            }
            let mut take = || stack.pop().unwrap_or_default();
            let node = match op {
                Op::Constant(c) => Node::Constant(c),
                Op::Variable(k) => Node::Variable(k),
                Op::Whole(n) => Node::Whole(take(), n),
                Op::One(f) => Node::One(f, take()),
                Op::Two(f) => {
                    let b = take();
                    Node::Two(f, take(), b)
                }
            };
            nodes.push(node);
            stack.push(nodes.len() - 1);
        }
        let mut tree = Self { nodes, about: [0.0; 2] };
        tree.move_variables();
        tree
    }

    pub fn about(&self) -> [f64; 2] {
        self.about
    }

    /// Where every x stands in x - a with one and the same a (and y in y - b), x becomes the distance from a.
    fn move_variables(&mut self) {
        if self.nodes.iter().any(|n| matches!(n, Node::Variable(R | THETA))) {
            return;
        }
        for axis in 0..2 {
            let uses = self.nodes.iter().filter(|&&n| n == Node::Variable(axis)).count();
            let is_variable = |k: usize| self.nodes[k] == Node::Variable(axis);
            let constant = |k: usize| match self.nodes[k] {
                Node::Constant(c) => Some(c),
                _ => None,
            };
            // (node, a, whether it is a - x)
            let moved: Vec<(usize, f64, bool)> = (0..self.nodes.len())
                .filter_map(|k| match self.nodes[k] {
                    Node::Two(Two::Subtract, a, b) if is_variable(a) => constant(b).map(|c| (k, c, false)),
                    Node::Two(Two::Subtract, a, b) if is_variable(b) => constant(a).map(|c| (k, c, true)),
                    Node::Two(Two::Add, a, b) if is_variable(a) => constant(b).map(|c| (k, -c, false)),
                    Node::Two(Two::Add, a, b) if is_variable(b) => constant(a).map(|c| (k, -c, false)),
                    _ => None,
                })
                .collect();
            let Some(&(_, point, _)) = moved.first() else { continue };
            if moved.len() != uses || moved.iter().any(|m| m.1 != point) {
                continue;
            }
            self.about[axis] = point;
            for (k, _, reversed) in moved {
                let (Node::Two(_, a, b), variable) = (self.nodes[k], Node::Variable(axis)) else { continue };
                let operand = if self.nodes[a] == variable { a } else { b };
                self.nodes[k] = if reversed { Node::One(One::Negate, operand) } else { Node::Whole(operand, 1) };
            }
        }
    }

    /// The value of each node by a rule for nodes from those of their operands; `None` where the rule has none.
    fn each<T: Clone>(&self, rule: impl Fn(Node, &[T]) -> Option<T>) -> Option<T> {
        let mut values: Vec<T> = Vec::with_capacity(self.nodes.len());
        for &node in &self.nodes {
            let value = rule(node, &values)?;
            values.push(value);
        }
        values.pop()
    }

    /// The law of a formula that is a constant and a homogeneous function of one degree k > 0.
    pub fn law(&self) -> Option<Law> {
        let form = self.each(homogeneous)?;
        form.degree.filter(|&k| k > 0.0).map(|k| Law { degree: Degree::Power(k), lowest: form.constant })
    }

    /// The formula as a quadratic form, about a point near its lowest one so that no digit is lost.
    pub fn quadratic(&self) -> Option<Quadratic> {
        let about = |point: [f64; 2]| {
            let polynomial = self.each(|node, of: &[Polynomial]| Polynomial::of(node, of, point))?;
            (polynomial.degree() <= 2).then(|| Quadratic {
                about: [0, 1].map(|m| self.about[m] + point[m]),
                value: polynomial.at(0, 0),
                gradient: [polynomial.at(1, 0), polynomial.at(0, 1)],
                hessian: [2.0 * polynomial.at(2, 0), polynomial.at(1, 1), 2.0 * polynomial.at(0, 2)],
            })
        };
        let first = about([0.0; 2])?;
        match first.lowest() {
            Some(low) if low != self.about => about([0, 1].map(|m| low[m] - self.about[m])),
            _ => Some(first),
        }
    }

    /// Whether the formula depends on the distance from [`Tree::about`] alone, and how.
    pub fn generatrix(&self) -> Option<Generatrix> {
        self.each(|node, of: &[Radial]| radial(node, of)).filter(|value| value.radial)?;
        if let Some((radius, lowest)) = self.sphere() {
            return Some(Generatrix::Sphere { radius, lowest });
        }
        match self.law() {
            Some(Law { degree: Degree::Power(exponent), lowest }) => {
                let coefficient = self.value([1.0, 0.0]) - lowest;
                let power = coefficient > 0.0 && coefficient.is_finite();
                Some(if power { Generatrix::Power { coefficient, exponent, lowest } } else { Generatrix::General })
            }
            _ => Some(Generatrix::General),
        }
    }

    /// The value at a point counted from [`Tree::about`].
    fn value(&self, [x, y]: [f64; 2]) -> f64 {
        let rule = |node: Node, of: &[f64]| {
            Some(match node {
                Node::Constant(c) => c,
                Node::Variable(0) => x,
                Node::Variable(1) => y,
                Node::Variable(R) => x.hypot(y),
                Node::Variable(_) => y.atan2(x),
                Node::Whole(a, n) => of[a].whole(n),
                Node::One(f, a) => of[a].one(f),
                Node::Two(f, a, b) => of[a].two(of[b], f),
            })
        };
        self.each(rule).unwrap_or(f64::NAN)
    }

    /// R and g0 of g0 + R - sqrt(R^2 - r^2).
    fn sphere(&self) -> Option<(f64, f64)> {
        let Node::Two(Two::Subtract, a, b) = *self.nodes.last()? else { return None };
        let (Node::Constant(top), Node::One(One::Sqrt, inside)) = (self.nodes[a], self.nodes[b]) else { return None };
        let under_root = Self { nodes: self.nodes[..=inside].to_vec(), about: self.about };
        let square = under_root.each(|node, of: &[Polynomial]| Polynomial::of(node, of, [0.0; 2]))?;
        let minus_one = |v: f64| (v + 1.0).abs() <= ROUNDING;
        let round = square.degree() == 2
            && minus_one(square.at(2, 0))
            && minus_one(square.at(0, 2))
            && [[1, 0], [0, 1], [1, 1]].iter().all(|&[i, j]| square.at(i, j) == 0.0);
        let radius = square.at(0, 0).sqrt();
        let lowest = if (top - radius).abs() <= ROUNDING * radius { 0.0 } else { top - radius };
        (round && radius > 0.0 && radius.is_finite()).then_some((radius, lowest))
    }

    /// The direction, that of x or of y, along which the formula comes back to each of its values.
    pub fn recurs_along(&self) -> Option<f64> {
        let recurs = |axis: usize| self.each(|node, of| recurrence(node, of, axis)) == Some(Recurrence::Recurrent);
        [0.0, FRAC_PI_2].into_iter().enumerate().find(|(axis, _)| recurs(*axis)).map(|(_, along)| along)
    }

    /// Whether the formula is its own image in x = a and in y = b with (a, b) = [`Tree::about`].
    pub fn mirrors(&self) -> [bool; 2] {
        [0, 1].map(|axis| self.each(|node, of: &[Parity]| Some(parity(node, of, axis))) == Some(Parity::Even))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::formula::parse;

    fn tree(text: &str) -> Tree {
        Tree::new(&parse::parse(text).unwrap())
    }

    #[test]
    fn laws_are_read_from_the_tree() {
        for (text, wanted) in [
            ("x^2/2 + y^2/6", Some((2.0, 0.0))),
            ("(abs(x)^3.73 + 17.44*abs(y)^3.73)^0.77", Some((3.73 * 0.77, 0.0))),
            ("hypot(x, 2*y) + max(x, y, -x-y)", Some((1.0, 0.0))),
            ("r^1.7*(1 + 0.2*cos(3*theta)) + 0.5", Some((1.7, 0.5))),
            ("2*(x-1)^2 + 3*(y+2)^2", Some((2.0, 0.0))),
            ("sqrt(x^4 + y^4)", Some((2.0, 0.0))),
            ("x^2*y^2/r^2 + x*y", Some((2.0, 0.0))),
            ("x^2/2 + abs(y)^3", None),
            ("r^2/(1 + r^2)", None),
            ("exp(x) + y", None),
            ("(x-1)^2 + x*y", None),
        ] {
            let law = tree(text).law().map(|l| (1.0 / l.degree.inverse(), l.lowest));
            let same = match (law, wanted) {
                (Some(a), Some(b)) => (a.0 - b.0).abs() < 1e-14 && a.1 == b.1,
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(same, "{text}: {law:?} {wanted:?}");
        }
    }

    #[test]
    fn quadratic_forms_keep_their_digits_far_from_the_origin() {
        for text in ["(x-1e5)^2/2 + 3*(y+2e5)^2", "x^2/2 - 1e5*x + 5e9 + 3*y^2 + 1.2e6*y + 1.2e11"] {
            let q = tree(text).quadratic().unwrap();
            let [x, y] = q.lowest().unwrap();
            assert!((x - 1e5).abs() < 1e-9 && (y + 2e5).abs() < 1e-9, "{text}: {x} {y}");
            assert_eq!(q.hessian, [1.0, 0.0, 6.0]);
        }
        let turned = tree("x^2 + x*y + y^2 + 0.1").quadratic().unwrap();
        assert_eq!((turned.value, turned.hessian), (0.1, [2.0, 1.0, 2.0]));
        assert_eq!(tree("r^2/2").quadratic().unwrap().hessian, [1.0, 0.0, 1.0]);
        assert!(tree("x^2 + y^4").quadratic().is_none());
        assert!(tree("x^2 + abs(y)^2").quadratic().is_none());
    }

    #[test]
    fn revolution_is_read_from_the_tree() {
        for (text, wanted) in [
            ("x^2 + y^2", true),
            ("(x-1)^2 + (y-2)^2 + 3*((x-1)^2 + (y-2)^2)^2", true),
            ("sqrt(x*x + y*y)/3", true),
            ("hypot(x, -y)", true),
            ("1 - sqrt(1 - x^2 - y^2)", true),
            ("exp(r) - 1", true),
            ("r^2/(1+r^2)", true),
            ("hypot(x, 2*y)", false),
            ("x^2 + 1.0001*y^2", false),
            ("theta^2 + r^2", false),
            ("abs(x) + abs(y)", false),
            ("x^4 + 2*x^2*y^2 + y^4", true),
            ("x^4 + y^4", false),
        ] {
            assert_eq!(tree(text).generatrix().is_some(), wanted, "{text}");
        }
        let ball = tree("0.02 - sqrt(0.02^2 - x^2 - y^2)").generatrix();
        assert!(matches!(ball, Some(Generatrix::Sphere { radius, lowest: 0.0 }) if (radius - 0.02).abs() < 1e-16));
        let cone = tree("0.3*r").generatrix();
        assert_eq!(cone, Some(Generatrix::Power { coefficient: 0.3, exponent: 1.0, lowest: 0.0 }));
    }

    #[test]
    fn waves_without_end_come_back() {
        for (text, wanted) in [
            ("x^2 + 1 - cos(3*y)", Some(FRAC_PI_2)),
            ("cosh(x) - exp(sin(y - 2*x^2)/3) + abs(cos(pi*y))", Some(FRAC_PI_2)),
            ("sin(x + y)^2 + max(0, cos(2*x - y))", Some(0.0)),
            ("x^2 + y^2 + 0.1*cos(9*y)", None),
            ("x^2 + sin(y^2)", None),
            ("x^2 + floor(sin(y))", None),
            ("x^2 + cos(3*theta)", None),
            ("x^2 + y*cos(y)", None),
            ("x^2", None),
        ] {
            assert_eq!(tree(text).recurs_along(), wanted, "{text}");
        }
    }

    #[test]
    fn mirrors_are_read_from_the_tree() {
        for (text, wanted) in [
            ("x^2/2 + 0.1*abs(y)^3", [true, true]),
            ("max(x, -x/2 + y, -x/2 - y)", [false, false]),
            ("x^3 + y^2", [false, true]),
            ("r^2*(1 + 0.2*cos(3*theta))", [false, true]),
            ("(x-1)^2 + (y-1)^4", [true, true]),
            ("x*y + r", [false, false]),
        ] {
            assert_eq!(tree(text).mirrors(), wanted, "{text}");
        }
    }
}
