//! What a formula is, read from the tree of its operations: its degree, its polynomial, whether it depends on the distance alone,
//! its mirrors.
//!
//! The variables may be moved: a formula in (x - a) and (y - b) alone is one about the point (a, b).

use super::tape::{One, Op, Tape, Two};
use super::{R, THETA};
use crate::gap::{Degree, Generatrix, Law, Quadratic};

/// Largest total degree of a polynomial that is written out.
const LARGEST_DEGREE: usize = 12;

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
        use super::tape::Number;
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

    /// Whether the formula is its own image in x = a and in y = b with (a, b) = [`Tree::about`].
    pub fn mirrors(&self) -> [bool; 2] {
        [0, 1].map(|axis| self.each(|node, of: &[Parity]| Some(parity(node, of, axis))) == Some(Parity::Even))
    }
}

/// A constant and a homogeneous function; the degree is `None` where the function is zero.
#[derive(Debug, Clone, Copy)]
struct Homogeneous {
    constant: f64,
    degree: Option<f64>,
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

fn homogeneous(node: Node, of: &[Homogeneous]) -> Option<Homogeneous> {
    use super::tape::Number;
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

/// A polynomial in x and y: the coefficient of x^i y^j stands at row j, column i.
#[derive(Debug, Clone, PartialEq)]
struct Polynomial(Vec<Vec<f64>>);

impl Polynomial {
    fn constant(c: f64) -> Self {
        Self(vec![vec![c]])
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.0.get(j).and_then(|row| row.get(i)).copied().unwrap_or(0.0)
    }

    /// The largest i + j with a coefficient.
    fn degree(&self) -> usize {
        let rows = self.0.iter().enumerate();
        let terms =
            rows.flat_map(|(j, row)| row.iter().enumerate().filter(|(_, c)| **c != 0.0).map(move |(i, _)| i + j));
        terms.max().unwrap_or(0)
    }

    fn is_constant(&self) -> Option<f64> {
        (self.degree() == 0).then(|| self.at(0, 0))
    }

    fn combine(&self, other: &Self, sign: f64) -> Self {
        let rows = self.0.len().max(other.0.len());
        let width = |p: &Self, j: usize| p.0.get(j).map_or(0, Vec::len);
        let row = |j: usize| {
            (0..width(self, j).max(width(other, j))).map(|i| self.at(i, j) + sign * other.at(i, j)).collect()
        };
        Self((0..rows).map(row).collect())
    }

    fn times(&self, other: &Self) -> Option<Self> {
        let degree = self.degree() + other.degree();
        if degree > LARGEST_DEGREE {
            return None;
        }
        let mut product = vec![vec![0.0; degree + 1]; degree + 1];
        for (j, row) in self.0.iter().enumerate() {
            for (i, c) in row.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                for (n, other_row) in other.0.iter().enumerate() {
                    for (m, d) in other_row.iter().enumerate().filter(|(_, d)| **d != 0.0) {
                        product[j + n][i + m] += c * d;
                    }
                }
            }
        }
        Some(Self(product))
    }

    fn power(&self, n: i32) -> Option<Self> {
        let n = usize::try_from(n).ok()?;
        if n * self.degree() > LARGEST_DEGREE {
            return None;
        }
        (0..n).try_fold(Self::constant(1.0), |power, _| power.times(self))
    }

    /// The polynomial of a node, x and y counted from `about`.
    fn of(node: Node, of: &[Self], about: [f64; 2]) -> Option<Self> {
        use super::tape::Number;
        let number = |f: &dyn Fn(f64) -> f64, a: usize| of[a].is_constant().map(|c| Self::constant(f(c)));
        match node {
            Node::Constant(c) => Some(Self::constant(c)),
            Node::Variable(0) => Some(Self(vec![vec![about[0], 1.0]])),
            Node::Variable(1) => Some(Self(vec![vec![about[1]], vec![1.0]])),
            Node::Variable(_) => None,
            Node::Whole(a, n) => number(&|c| c.whole(n), a).or_else(|| of[a].power(n)),
            Node::One(One::Negate, a) => Some(Self::constant(0.0).combine(&of[a], -1.0)),
            Node::One(f, a) => number(&|c| c.one(f), a),
            Node::Two(Two::Add, a, b) => Some(of[a].combine(&of[b], 1.0)),
            Node::Two(Two::Subtract, a, b) => Some(of[a].combine(&of[b], -1.0)),
            Node::Two(Two::Multiply, a, b) => of[a].times(&of[b]),
            Node::Two(Two::Divide, a, b) => {
                let c = of[b].is_constant()?;
                Some(Self(of[a].0.iter().map(|row| row.iter().map(|v| v / c).collect()).collect()))
            }
            Node::Two(f, a, b) => {
                let (a, b) = (of[a].is_constant()?, of[b].is_constant()?);
                Some(Self::constant(a.two(b, f)))
            }
        }
    }

    /// Whether it is a polynomial in x^2 + y^2.
    fn is_radial(&self) -> bool {
        // (x^2 + y^2)^m = sum of binomials (m over n) x^(2m - 2n) y^(2n).
        let largest = self.0.iter().flatten().fold(0.0_f64, |m, c| m.max(c.abs()));
        let mut rest = self.clone();
        for m in 0..=LARGEST_DEGREE / 2 {
            let c = rest.at(2 * m, 0);
            if c == 0.0 {
                continue;
            }
            let square = Self(vec![vec![0.0, 0.0, 1.0], vec![], vec![1.0]]);
            let Some(power) = square.power(m as i32) else { return false };
            rest = rest.combine(&power.times(&Self::constant(c)).unwrap_or(power), -1.0);
        }
        rest.0.iter().flatten().all(|c| c.abs() <= ROUNDING * largest)
    }
}

/// A node as a polynomial, and whether its value depends on the distance alone.
#[derive(Debug, Clone)]
struct Radial {
    polynomial: Option<Polynomial>,
    radial: bool,
}

/// `None` where neither is known: nothing above can depend on the distance alone then.
fn radial(node: Node, of: &[Radial]) -> Option<Radial> {
    let operands: Option<Vec<&Polynomial>> = match node {
        Node::Constant(_) | Node::Variable(_) => Some(Vec::new()),
        Node::Whole(a, _) | Node::One(_, a) => of[a].polynomial.as_ref().map(|p| vec![p]),
        Node::Two(_, a, b) => of[a].polynomial.as_ref().zip(of[b].polynomial.as_ref()).map(|(p, q)| vec![p, q]),
    };
    // The rule for polynomials looks operands up by their place.
    let renamed = match node {
        Node::Whole(_, n) => Node::Whole(0, n),
        Node::One(f, _) => Node::One(f, 0),
        Node::Two(f, ..) => Node::Two(f, 0, 1),
        leaf => leaf,
    };
    let polynomial =
        operands.and_then(|p| Polynomial::of(renamed, &p.into_iter().cloned().collect::<Vec<_>>(), [0.0; 2]));
    let own = match node {
        Node::Constant(_) | Node::Variable(R) => true,
        Node::Variable(_) => false,
        Node::Whole(a, _) | Node::One(_, a) => of[a].radial,
        Node::Two(f, a, b) => {
            let is = |p: &Option<Polynomial>, i, j| p.as_ref().is_some_and(|p| p.degree() == 1 && p.at(i, j) != 0.0);
            let length = f == Two::Hypot && length(&of[a].polynomial, &of[b].polynomial, &is);
            (of[a].radial && of[b].radial) || length
        }
    };
    let radial = own || polynomial.as_ref().is_some_and(Polynomial::is_radial);
    (radial || polynomial.is_some()).then_some(Radial { polynomial, radial })
}

/// Whether hypot of the two is a multiple of the distance: c x and +-c y.
fn length(
    a: &Option<Polynomial>,
    b: &Option<Polynomial>,
    is: &dyn Fn(&Option<Polynomial>, usize, usize) -> bool,
) -> bool {
    let (Some(p), Some(q)) = (a, b) else { return false };
    let alone = |p: &Polynomial, i, j| p.at(0, 0) == 0.0 && p.at(j, i) == 0.0 && p.at(i, j) != 0.0;
    let (along, across) = if is(a, 1, 0) { (p.at(1, 0), q.at(0, 1)) } else { (p.at(0, 1), q.at(1, 0)) };
    let each = (alone(p, 1, 0) && alone(q, 0, 1)) || (alone(p, 0, 1) && alone(q, 1, 0));
    each && along.abs() == across.abs()
}

/// How a value changes when x (or y) changes its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Parity {
    Even,
    Odd,
    Neither,
}

fn parity(node: Node, of: &[Parity], axis: usize) -> Parity {
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
