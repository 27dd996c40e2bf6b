//! The field of what is far from a quadrilateral, interpolated from Chebyshev points of it.

use std::sync::OnceLock;

use super::far::BLOCK_NODES;
use super::gauss::{NODES, legendre};
use super::line_potential::{Field, Points};
use super::mesh::{Bilinear, Point};
use super::subcell::Subcell;

/// Displacement and slope of `K` pressures at the nodes.
pub(crate) struct Block<const K: usize> {
    /// Nodes along both directions.
    count: [usize; 2],
    /// At the nodes: the index of t runs slower.
    fields: Box<[Field; K]>,
}

impl<const K: usize> Block<K> {
    /// `fields`: at the [`points`] of this count.
    pub fn new(count: [usize; 2], fields: [Field; K]) -> Self {
        Self { count, fields: Box::new(fields) }
    }

    /// Adds its interpolant at (s, t) to the fields at point `i`.
    pub fn add_at(&self, [s, t]: Point, i: usize, fields: &mut [Field; K]) {
        let [p, q] = self.count;
        let (bs, bt) = (basis(p, s), basis(q, t));
        let at = |values: &[f64]| -> f64 {
            let rows = values.chunks_exact(p).zip(&bt);
            rows.map(|(row, b)| b * row.iter().zip(&bs).map(|(v, b)| v * b).sum::<f64>()).sum()
        };
        for (field, block) in fields.iter_mut().zip(self.fields.iter()) {
            field.u[i] += at(&block.u);
            for (slope, values) in field.slope.iter_mut().zip(&block.slope) {
                slope[i] += at(values);
            }
        }
    }

    /// Adds its interpolant at the `m` x `n` Gauss nodes of a subcell to the fields from point `first` on.
    pub fn add_on(&self, subcell: &Subcell, [m, n]: [usize; 2], first: usize, fields: &mut [Field; K]) {
        let [p, q] = self.count;
        let at_nodes = |k: usize, count: usize| {
            let ([a, b], mut all) = (subcell.range[k], [[0.0; BLOCK_NODES[1]]; NODES[1]]);
            for (all, x) in all.iter_mut().zip(&legendre(count).0) {
                *all = basis(self.count[k], a + 0.5 * (1.0 + x) * (b - a));
            }
            all
        };
        let (bs, bt) = (at_nodes(0, m), at_nodes(1, n));
        for (field, block) in fields.iter_mut().zip(self.fields.iter()) {
            let [dx, dy] = &mut field.slope;
            for (out, values) in [(&mut field.u, &block.u), (dx, &block.slope[0]), (dy, &block.slope[1])] {
                for (j, bt) in bt[..n].iter().enumerate() {
                    let mut line = [0.0; BLOCK_NODES[1]];
                    for (values, b) in values[..p * q].chunks_exact(p).zip(bt) {
                        line.iter_mut().zip(values).for_each(|(sum, v)| *sum += b * v);
                    }
                    for (i, bs) in bs[..m].iter().enumerate() {
                        out[first + j * m + i] += bs[..p].iter().zip(&line).map(|(b, v)| b * v).sum::<f64>();
                    }
                }
            }
        }
    }
}

/// The Chebyshev points of a quadrilateral.
pub(crate) fn points(map: &Bilinear, count: [usize; 2]) -> Points {
    let mut points = Points::EMPTY;
    for (t, _) in chebyshev(count[1]) {
        for (s, _) in chebyshev(count[0]) {
            points.push(map.at(*s, *t));
        }
    }
    points
}

/// Chebyshev nodes, and one over the product of the differences of each from the others.
type Nodes = Vec<(f64, f64)>;

/// The `n` Chebyshev nodes.
fn chebyshev(n: usize) -> &'static Nodes {
    static NODES: OnceLock<Vec<Nodes>> = OnceLock::new();
    let all = NODES.get_or_init(|| {
        let node = |n: usize, i: usize| -((2 * i + 1) as f64 * std::f64::consts::PI / (2 * n) as f64).cos();
        let difference = |n, i, j| if i == j { 1.0 } else { node(n, i) - node(n, j) };
        let weight = |n, i| (0..n).map(|j| difference(n, i, j)).product::<f64>().recip();
        (0..=BLOCK_NODES[1]).map(|n| (0..n).map(|i| (node(n, i), weight(n, i))).collect()).collect()
    });
    &all[n]
}

/// The values at `x` of the Lagrange polynomials of the `n` Chebyshev nodes; zero beyond them.
fn basis(n: usize, x: f64) -> [f64; BLOCK_NODES[1]] {
    let (nodes, mut values) = (chebyshev(n), [0.0; BLOCK_NODES[1]]);
    // Products of the differences from the nodes before, then after.
    let mut before = 1.0;
    for (value, (node, weight)) in values.iter_mut().zip(nodes) {
        *value = before * weight;
        before *= x - node;
    }
    let mut after = 1.0;
    for (value, (node, _)) in values.iter_mut().zip(nodes).rev() {
        *value *= after;
        after *= x - node;
    }
    values
}
