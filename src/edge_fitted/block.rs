//! The field of what is far from a quadrilateral, interpolated from Chebyshev points of it.

use std::sync::OnceLock;

use super::far::BLOCK_NODES;
use super::gauss::{lagrange, legendre};
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
        let (bs, bt) = (lagrange(chebyshev(p), s), lagrange(chebyshev(q), t));
        let at = |values: &[f64]| -> f64 {
            bt.iter()
                .zip(values.chunks_exact(p))
                .map(|(b, row)| b * row.iter().zip(&bs).map(|(v, b)| v * b).sum::<f64>())
                .sum()
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
        let basis = |k: usize, count: usize| -> Vec<f64> {
            let [a, b] = subcell.range[k];
            let nodes = chebyshev(self.count[k]);
            legendre(count).0.iter().flat_map(|x| lagrange(nodes, a + 0.5 * (1.0 + x) * (b - a))).collect()
        };
        let (bs, bt) = (basis(0, m), basis(1, n));
        for (field, block) in fields.iter_mut().zip(self.fields.iter()) {
            let [dx, dy] = &mut field.slope;
            for (out, values) in [(&mut field.u, &block.u), (dx, &block.slope[0]), (dy, &block.slope[1])] {
                for j in 0..n {
                    let mut line = [0.0; BLOCK_NODES[1]];
                    for (i, v) in line.iter_mut().enumerate().take(p) {
                        *v = (0..q).map(|l| bt[j * q + l] * values[l * p + i]).sum::<f64>();
                    }
                    for i in 0..m {
                        let row = &bs[i * p..(i + 1) * p];
                        out[first + j * m + i] += row.iter().zip(&line).map(|(b, v)| b * v).sum::<f64>();
                    }
                }
            }
        }
    }
}

/// The Chebyshev points of a quadrilateral.
pub(crate) fn points(map: &Bilinear, count: [usize; 2]) -> Points {
    let mut points = Points::EMPTY;
    for t in chebyshev(count[1]) {
        for s in chebyshev(count[0]) {
            points.push(map.at(*s, *t));
        }
    }
    points
}

/// The `n` Chebyshev nodes.
fn chebyshev(n: usize) -> &'static [f64] {
    static NODES: OnceLock<Vec<Vec<f64>>> = OnceLock::new();
    let all = NODES.get_or_init(|| {
        (0..=BLOCK_NODES[1])
            .map(|n| (0..n).map(|i| -((2 * i + 1) as f64 * std::f64::consts::PI / (2 * n) as f64).cos()).collect())
            .collect()
    });
    &all[n]
}
