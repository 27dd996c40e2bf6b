//! A formula as a polynomial.

use super::{Node, ROUNDING};
use crate::gap::formula::functions::{Number, One, Two};

/// Largest total degree of a polynomial that is written out.
const LARGEST_DEGREE: usize = 12;

/// A polynomial in x and y: the coefficient of x^i y^j stands at row j, column i.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polynomial(Vec<Vec<f64>>);

impl Polynomial {
    fn constant(c: f64) -> Self {
        Self(vec![vec![c]])
    }

    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.0.get(j).and_then(|row| row.get(i)).copied().unwrap_or(0.0)
    }

    /// The largest i + j with a coefficient.
    pub fn degree(&self) -> usize {
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
    pub fn of(node: Node, of: &[Self], about: [f64; 2]) -> Option<Self> {
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
    pub fn is_radial(&self) -> bool {
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
