//! Convex quadrilateral cells with shared nodes, the edges between them, and a strip of cells beyond the outline.

use std::collections::HashMap;

use super::gauss::legendre;
pub(crate) use crate::numeric::geometry::{cross, dot, minus, norm};

/// A point of the plane.
pub(crate) type Point = [f64; 2];

/// A straight edge of the loaded cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Edge {
    /// Its nodes.
    pub ends: [usize; 2],
    /// The loaded cells left and right of it, seen from the first node to the second.
    pub sides: [Option<usize>; 2],
}

/// Quadrilateral cells. The map of a cell takes (-1,-1), (1,-1), (1,1), (-1,1) bilinearly to its nodes, counter-clockwise;
/// nodes may coincide (triangles). Two cells share a whole edge, a node, or nothing.
#[derive(Debug, Clone)]
pub(crate) struct Mesh {
    pub(crate) nodes: Vec<Point>,
    /// The first `loaded` may carry pressure; the others are the strip beyond the outline.
    pub(crate) cells: Vec<[usize; 4]>,
    pub(crate) loaded: usize,
    pub(crate) edges: Vec<Edge>,
    /// Of each loaded cell: the edge on side k (nodes k to k + 1) and +1 where the cell is left of it, -1 where right;
    /// None where the side has no length.
    pub(crate) cell_edges: Vec<[Option<(usize, f64)>; 4]>,
    /// Edges by their nodes in rising order.
    known: HashMap<[usize; 2], usize>,
}

impl Mesh {
    pub(crate) fn new(nodes: Vec<Point>, loaded: Vec<[usize; 4]>, strip: Vec<[usize; 4]>) -> Self {
        let mut edges: Vec<Edge> = Vec::new();
        let mut known: HashMap<[usize; 2], usize> = HashMap::new();
        let mut cell_edges = Vec::with_capacity(loaded.len());
        for (i, cell) in loaded.iter().enumerate() {
            cell_edges.push([0, 1, 2, 3].map(|k| {
                let (a, b) = (cell[k], cell[(k + 1) % 4]);
                if a == b {
                    return None;
                }
                let edge = *known.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    edges.push(Edge { ends: [a, b], sides: [None; 2] });
                    edges.len() - 1
                });
                let left = edges[edge].ends[0] == a;
                edges[edge].sides[usize::from(!left)] = Some(i);
                Some((edge, if left { 1.0 } else { -1.0 }))
            }));
        }
        let count = loaded.len();
        let cells = loaded.into_iter().chain(strip).collect();
        Self { nodes, cells, loaded: count, edges, cell_edges, known }
    }

    /// Some of the loaded cells, by their corners, without a strip; `None` where there are none.
    pub(crate) fn with(&self, kept: impl Fn(&[Point; 4]) -> bool) -> Option<Self> {
        let cells: Vec<[usize; 4]> =
            (0..self.loaded).filter(|&cell| kept(&self.corners(cell))).map(|cell| self.cells[cell]).collect();
        (!cells.is_empty()).then(|| Self::new(self.nodes.clone(), cells, Vec::new()))
    }

    /// The edge between two nodes.
    pub(crate) fn edge_between(&self, a: usize, b: usize) -> Option<usize> {
        self.known.get(&[a.min(b), a.max(b)]).copied()
    }

    /// Corners of a cell.
    pub(crate) fn corners(&self, cell: usize) -> [Point; 4] {
        self.cells[cell].map(|n| self.nodes[n])
    }

    /// The integrals of 1, x and y over each loaded cell.
    pub(crate) fn weights(&self) -> [Vec<f64>; 3] {
        let own: Vec<[f64; 3]> = (0..self.loaded).map(|k| Bilinear::new(self.corners(k)).moments()).collect();
        [0, 1, 2].map(|i| own.iter().map(|moments| moments[i]).collect())
    }

    /// The largest extent along an axis.
    pub(crate) fn extent(&self) -> f64 {
        let range = |k: usize| {
            let low = self.nodes.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
            let high = self.nodes.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
            high - low
        };
        range(0).max(range(1))
    }
}

/// A bilinear quadrilateral: x(s, t) = centre + s along[0] + t along[1] + s t twist, s and t in [-1, 1].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bilinear {
    pub centre: Point,
    pub along: [Point; 2],
    pub twist: Point,
}

impl Bilinear {
    pub fn new(c: [Point; 4]) -> Self {
        let mix = |w: [f64; 4]| [0, 1].map(|k| 0.25 * (0..4).map(|i| w[i] * c[i][k]).sum::<f64>());
        Self {
            centre: mix([1.0, 1.0, 1.0, 1.0]),
            along: [mix([-1.0, 1.0, 1.0, -1.0]), mix([-1.0, -1.0, 1.0, 1.0])],
            twist: mix([1.0, -1.0, 1.0, -1.0]),
        }
    }

    #[inline(always)]
    pub fn at(&self, s: f64, t: f64) -> Point {
        [0, 1].map(|k| self.centre[k] + s * self.along[0][k] + t * self.along[1][k] + s * t * self.twist[k])
    }

    /// dx/ds at t.
    #[inline(always)]
    pub fn ds(&self, t: f64) -> Point {
        [0, 1].map(|k| self.along[0][k] + t * self.twist[k])
    }

    /// dx/dt at s.
    #[inline(always)]
    pub fn dt(&self, s: f64) -> Point {
        [0, 1].map(|k| self.along[1][k] + s * self.twist[k])
    }

    /// The determinant, linear in s and t.
    #[inline(always)]
    pub fn jacobian(&self, s: f64, t: f64) -> f64 {
        cross(self.ds(t), self.dt(s))
    }

    /// Points and weights of an integral over the cell: 3 x 3 of Gauss.
    pub fn gauss(&self) -> impl Iterator<Item = (Point, f64)> {
        let (x, w) = legendre(3);
        let rows = x.iter().zip(w);
        let node = |s: f64, ws: f64, t: f64, wt: f64| (self.at(s, t), ws * wt * self.jacobian(s, t));
        rows.flat_map(move |(s, ws)| x.iter().zip(w).map(move |(t, wt)| node(*s, *ws, *t, *wt)))
    }

    /// The part over [s0, s1] x [t0, t1].
    pub fn part(&self, s: [f64; 2], t: [f64; 2]) -> Self {
        let (sc, sh, tc, th) = (0.5 * (s[0] + s[1]), 0.5 * (s[1] - s[0]), 0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0]));
        Self {
            centre: self.at(sc, tc),
            along: [self.ds(tc).map(|v| sh * v), self.dt(sc).map(|v| th * v)],
            twist: self.twist.map(|v| sh * th * v),
        }
    }

    pub fn corners(&self) -> [Point; 4] {
        [self.at(-1.0, -1.0), self.at(1.0, -1.0), self.at(1.0, 1.0), self.at(-1.0, 1.0)]
    }

    /// The area.
    pub fn area(&self) -> f64 {
        4.0 * cross(self.along[0], self.along[1])
    }

    /// The integrals of 1, x and y: products of a bilinear and a linear function, by the 2 x 2 Gauss rule.
    pub fn moments(&self) -> [f64; 3] {
        let node = 1.0 / 3.0_f64.sqrt();
        let mut sums = [self.area(), 0.0, 0.0];
        for (s, t) in [(-node, -node), (node, -node), (node, node), (-node, node)] {
            let ([x, y], j) = (self.at(s, t), self.jacobian(s, t));
            sums[1] += j * x;
            sums[2] += j * y;
        }
        sums
    }
}
