//! Displacement and slope of cells under constant pressure, as sums over straight edges.
//!
//! With E* = 1, L(x) = int over an edge of ds/|x - y| and d(x) the signed distance from its line (positive to the left),
//! pressures p left and q right of it:
//!
//! ```text
//! u = 1/pi sum over edges of (p - q) d L,      grad u = 1/pi sum of (p - q) n L,      n = grad d
//! ```
//!
//! since int over a polygon of 1/|x - y| = sum d L and its gradient is the integral of n/|x - y| along the boundary.
//! L = asinh(a1/|d|) - asinh(a2/|d|), a1 and a2 the coordinates of x along the edge from its ends, is one logarithm of
//! r + |a| at both ends, without cancellation; away from the edge L = 2 artanh(length/(r1 + r2)), r1 and r2 the distances from its ends.

use super::mesh::{Mesh, Point, dot, minus, norm};
use crate::numeric::simd::{Kernel, ln_ratio, twice_artanh, vectorised};

/// Points that are evaluated together.
pub(crate) const BATCH: usize = 64;

/// One edge: its nodes, first point, direction and length.
#[derive(Debug, Clone, Copy)]
struct Line {
    nodes: [usize; 2],
    start: Point,
    direction: Point,
    length: f64,
}

impl Line {
    /// Whether r1 + r2 is at least [`AFAR`] times the length at every point of a group, no further than `size` from the first one.
    #[inline(always)]
    fn is_far(&self, radii: &[[f64; BATCH]], first: usize, size: f64) -> bool {
        radii[self.nodes[0]][first] + radii[self.nodes[1]][first] - 2.0 * size >= AFAR * self.length
    }
}

/// The edges of a mesh.
#[derive(Debug, Clone)]
pub(crate) struct Lines {
    nodes: Vec<Point>,
    lines: Vec<Line>,
}

/// Displacement and slope of one pressure at the points of a batch.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub u: [f64; BATCH],
    pub slope: [[f64; BATCH]; 2],
}

impl Field {
    pub const ZERO: Self = Self { u: [0.0; BATCH], slope: [[0.0; BATCH]; 2] };
}

/// Points of one vector operation, at most.
const LANES: usize = 8;

/// r1 + r2 over the length from which L is taken as 2 artanh: up to a third.
const AFAR: f64 = 3.0;

/// Stands for d^2 of a point on an edge, where d L is zero.
const SMALLEST: f64 = 1e-280;

/// Those of a batch that begin with `first`.
#[inline(always)]
fn group(all: &[f64; BATCH], first: usize) -> [f64; LANES] {
    std::array::from_fn(|i| all[first + i])
}

/// Up to [`BATCH`] points; those not filled repeat the last one.
#[derive(Debug, Clone)]
pub(crate) struct Points {
    pub x: [f64; BATCH],
    pub y: [f64; BATCH],
    pub len: usize,
}

impl Points {
    pub const EMPTY: Self = Self { x: [0.0; BATCH], y: [0.0; BATCH], len: 0 };

    /// Groups of [`LANES`] that hold a point.
    #[inline(always)]
    fn lanes(&self) -> usize {
        self.len.div_ceil(LANES).min(BATCH / LANES)
    }

    /// The largest distance of a point from the first one of its group.
    #[inline(always)]
    fn reach(&self, first: usize) -> f64 {
        let mut largest = 0.0_f64;
        for i in first + 1..first + LANES {
            let (dx, dy) = (self.x[i] - self.x[first], self.y[i] - self.y[first]);
            largest = largest.max(dx * dx + dy * dy);
        }
        largest.sqrt()
    }

    pub fn push(&mut self, p: Point) {
        if self.len < BATCH {
            // The rest of its group repeats it.
            for i in self.len..(self.len / LANES + 1) * LANES {
                self.x[i] = p[0];
                self.y[i] = p[1];
            }
            self.len += 1;
        }
    }
}

impl Lines {
    pub fn new(mesh: &Mesh) -> Self {
        let lines = mesh
            .edges
            .iter()
            .map(|edge| {
                let [a, b] = edge.ends.map(|n| mesh.nodes[n]);
                let v = minus(b, a);
                let length = norm(v);
                Line { nodes: edge.ends, start: a, direction: v.map(|c| c / length), length }
            })
            .collect();
        Self { nodes: mesh.nodes.clone(), lines }
    }

    /// Some of the edges in another order, with their own nodes only, as the edges need them.
    pub fn subset(&self, edges: impl Iterator<Item = usize>) -> Self {
        let mut subset = Self { nodes: Vec::new(), lines: Vec::new() };
        let mut index = std::collections::HashMap::new();
        for e in edges {
            let mut line = self.lines[e];
            line.nodes = line.nodes.map(|n| {
                *index.entry(n).or_insert_with(|| {
                    subset.nodes.push(self.nodes[n]);
                    subset.nodes.len() - 1
                })
            });
            subset.lines.push(line);
        }
        subset
    }

    /// The strengths (p - q)/pi of all edges.
    pub fn strengths(mesh: &Mesh, pressure: &[f64]) -> Vec<f64> {
        let p = |side: Option<usize>| side.map_or(0.0, |i| pressure[i]);
        mesh.edges.iter().map(|e| (p(e.sides[0]) - p(e.sides[1])) * std::f64::consts::FRAC_1_PI).collect()
    }

    /// The normal (to the left) of an edge.
    pub fn normal(&self, edge: usize) -> Point {
        let [x, y] = self.lines[edge].direction;
        [-y, x]
    }

    /// Distances of the points from some nodes.
    #[inline(always)]
    fn radii(nodes: &[Point], points: &Points, radii: &mut Vec<[f64; BATCH]>) {
        radii.resize(nodes.len(), [0.0; BATCH]);
        for (node, r) in nodes.iter().zip(radii.iter_mut()) {
            for c in 0..points.lanes() {
                for i in LANES * c..LANES * (c + 1) {
                    let (dx, dy) = (points.x[i] - node[0], points.y[i] - node[1]);
                    r[i] = (dx * dx + dy * dy).sqrt();
                }
            }
        }
    }

    /// L and d of one line at a group of points.
    #[inline(always)]
    fn potential(line: &Line, points: &Points, radii: &[[f64; BATCH]], first: usize) -> [[f64; LANES]; 2] {
        let (r1, r2) = (group(&radii[line.nodes[0]], first), group(&radii[line.nodes[1]], first));
        let (x, y, [tx, ty]) = (group(&points.x, first), group(&points.y, first), line.direction);
        let (mut l, mut d) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (dx, dy) = (x[i] - line.start[0], y[i] - line.start[1]);
            let a1 = dx * tx + dy * ty;
            let a2 = a1 - line.length;
            let s = tx * dy - ty * dx;
            let (b1, b2) = (r1[i] + a1.abs(), r2[i] + a2.abs());
            // Beyond the second end b1/b2, beyond the first b2/b1, between them b1 b2/d^2.
            let above = if a1 >= 0.0 { b1 } else { 1.0 } * if a2 <= 0.0 { b2 } else { 1.0 };
            let below = if a1 < 0.0 { b1 } else { 1.0 } * if a2 > 0.0 { b2 } else { 1.0 };
            let between = if a1 >= 0.0 && a2 <= 0.0 { (s * s).max(SMALLEST) } else { 1.0 };
            l[i] = ln_ratio(above, below * between);
            d[i] = s;
        }
        [l, d]
    }

    /// The same where r1 + r2 is at least [`AFAR`] times the length.
    #[inline(always)]
    fn potential_from_afar(line: &Line, points: &Points, radii: &[[f64; BATCH]], first: usize) -> [[f64; LANES]; 2] {
        let (r1, r2) = (group(&radii[line.nodes[0]], first), group(&radii[line.nodes[1]], first));
        let (x, y, [tx, ty]) = (group(&points.x, first), group(&points.y, first), line.direction);
        let (mut l, mut d) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            l[i] = twice_artanh(line.length / (r1[i] + r2[i]));
            d[i] = tx * (y[i] - line.start[1]) - ty * (x[i] - line.start[0]);
        }
        [l, d]
    }

    /// Adds the fields of `K` pressures, given by the strengths of the edges.
    pub fn fields<const K: usize>(&self, strengths: [&[f64]; K], points: &Points, scratch: &mut Scratch) -> [Field; K] {
        let mut fields = [const { Field::ZERO }; K];
        vectorised(Accumulate { lines: self, strengths, points, scratch, fields: &mut fields });
        fields
    }

    #[inline(always)]
    fn accumulate<const K: usize>(
        &self,
        strengths: [&[f64]; K],
        points: &Points,
        scratch: &mut Scratch,
        fields: &mut [Field; K],
    ) {
        Self::radii(&self.nodes, points, &mut scratch.radii);
        for first in (0..LANES * points.lanes()).step_by(LANES) {
            let mut sums = [[[0.0; LANES]; 3]; K];
            // No point of the group is further from the first one.
            let size = points.reach(first);
            scratch.near.clear();
            for (e, line) in self.lines.iter().enumerate() {
                if strengths.iter().all(|c| c[e] == 0.0) {
                    continue;
                }
                if !line.is_far(&scratch.radii, first, size) {
                    scratch.near.push(e);
                } else {
                    let of_edge = Self::potential_from_afar(line, points, &scratch.radii, first);
                    Self::add(line.direction, strengths, e, of_edge, &mut sums);
                }
            }
            for &e in &scratch.near {
                let line = &self.lines[e];
                let of_edge = Self::potential(line, points, &scratch.radii, first);
                Self::add(line.direction, strengths, e, of_edge, &mut sums);
            }
            for (field, [u, x, y]) in fields.iter_mut().zip(&sums) {
                field.u[first..first + LANES].copy_from_slice(u);
                field.slope[0][first..first + LANES].copy_from_slice(x);
                field.slope[1][first..first + LANES].copy_from_slice(y);
            }
        }
    }

    /// Adds displacement and slope of edge `e`.
    #[inline(always)]
    fn add<const K: usize>(
        [tx, ty]: Point,
        strengths: [&[f64]; K],
        e: usize,
        [l, d]: [[f64; LANES]; 2],
        sums: &mut [[[f64; LANES]; 3]; K],
    ) {
        for (sums, c) in sums.iter_mut().zip(strengths) {
            let (c, cx, cy) = (c[e], -c[e] * ty, c[e] * tx);
            for i in 0..LANES {
                sums[0][i] += c * (d[i] * l[i]);
                sums[1][i] += cx * l[i];
                sums[2][i] += cy * l[i];
            }
        }
    }

    /// d L of the first `count` edges at every point of the batch, edge by edge.
    pub fn moments(&self, points: &Points, count: usize, scratch: &mut Scratch) {
        vectorised(Store { lines: self, points, count, scratch });
    }

    #[inline(always)]
    fn store(&self, points: &Points, count: usize, scratch: &mut Scratch) {
        let lines = &self.lines[..count];
        // A subset numbers its nodes as its edges need them.
        let nodes = lines.iter().flat_map(|line| line.nodes).max().map_or(0, |last| last + 1);
        Self::radii(&self.nodes[..nodes], points, &mut scratch.radii);
        scratch.products.resize(count, [0.0; BATCH]);
        for first in (0..LANES * points.lanes()).step_by(LANES) {
            let size = points.reach(first);
            for (line, out) in lines.iter().zip(scratch.products.iter_mut()) {
                let [l, d] = if line.is_far(&scratch.radii, first, size) {
                    Self::potential_from_afar(line, points, &scratch.radii, first)
                } else {
                    Self::potential(line, points, &scratch.radii, first)
                };
                for i in 0..LANES {
                    out[first + i] = d[i] * l[i];
                }
            }
        }
    }

    /// L of one edge at a point.
    #[cfg(test)]
    pub fn single(&self, edge: usize, p: Point) -> f64 {
        let line = &self.lines[edge];
        let a1 = dot(minus(p, line.start), line.direction);
        let s = super::mesh::cross(line.direction, minus(p, line.start)).abs();
        (a1 / s).asinh() - ((a1 - line.length) / s).asinh()
    }

    /// Ends and direction of an edge.
    pub fn geometry(&self, edge: usize) -> ([Point; 2], Point, f64) {
        let line = &self.lines[edge];
        (line.nodes.map(|n| self.nodes[n]), line.direction, line.length)
    }
}

struct Accumulate<'a, const K: usize> {
    lines: &'a Lines,
    strengths: [&'a [f64]; K],
    points: &'a Points,
    scratch: &'a mut Scratch,
    fields: &'a mut [Field; K],
}

impl<const K: usize> Kernel for Accumulate<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.lines.accumulate(self.strengths, self.points, self.scratch, self.fields);
    }
}

struct Store<'a> {
    lines: &'a Lines,
    points: &'a Points,
    count: usize,
    scratch: &'a mut Scratch,
}

impl Kernel for Store<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.lines.store(self.points, self.count, self.scratch);
    }
}

/// Buffers of one evaluation.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    radii: Vec<[f64; BATCH]>,
    /// Edges near a group of points.
    near: Vec<usize>,
    /// What [`Lines::moments`] leaves.
    pub products: Vec<[f64; BATCH]>,
}

/// Coordinate of a point along a line.
#[inline(always)]
pub(crate) fn abscissa(p: Point, a: Point, direction: Point) -> f64 {
    dot(minus(p, a), direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        Mesh::new(vec![[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]], vec![[0, 1, 2, 3]], vec![])
    }

    #[test]
    fn love_s_square() {
        // Centre of a square of side 2: int 1/r = 8 asinh(1).
        let mesh = square();
        let lines = Lines::new(&mesh);
        let strength = Lines::strengths(&mesh, &[1.0]);
        let mut points = Points::EMPTY;
        let places = [[0.0, 0.0], [0.3, -0.7], [1.0 + 1e-9, 0.2], [5.0, 3.0], [0.5, -30.0], [1.5, 1.0]];
        for p in places {
            points.push(p);
        }
        let [field] = lines.fields([&strength], &points, &mut Scratch::default());
        assert!((field.u[0] - 8.0 * 1f64.asinh() / std::f64::consts::PI).abs() < 1e-15);
        let love = |x: f64, y: f64| {
            let f = |u: f64, v: f64| u * (v / u.abs()).asinh() + v * (u / v.abs()).asinh();
            let g = |u: f64, v: f64| if u == 0.0 || v == 0.0 { 0.0 } else { f(u, v) };
            (g(x + 1.0, y + 1.0) - g(x - 1.0, y + 1.0) - g(x + 1.0, y - 1.0) + g(x - 1.0, y - 1.0))
                / std::f64::consts::PI
        };
        for (i, p) in places.iter().enumerate() {
            assert!((field.u[i] - love(p[0], p[1])).abs() < 2e-14, "{p:?} {} {}", field.u[i], love(p[0], p[1]));
            let h = 1e-5;
            if i != 2 {
                let dx = (love(p[0] + h, p[1]) - love(p[0] - h, p[1])) / (2.0 * h);
                assert!((field.slope[0][i] - dx).abs() < 1e-8);
            }
        }
        assert!((lines.single(0, [0.0, 0.0]) - 2.0 * 1f64.asinh()).abs() < 1e-15);
    }
}
