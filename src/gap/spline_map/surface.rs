//! The splines of a map: values, slopes and twists at its nodes, and the bicubic polynomial of each cell.

use crate::gap::height_map::{Nodes, ROUNDING as AT_EDGE};
use crate::gap::spline::bernstein::{self, Net, ROUNDING};
use crate::gap::spline::{Ends, runs, slopes};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Parts of cells looked at for the least value.
const BUDGET: usize = 1 << 18;

/// At each node the gap and, in units of the steps, its slopes along x and y and its twist; infinite in holes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Splines {
    pub nodes: Nodes,
    samples: Vec<[f64; 4]>,
}

/// What the ends of a step weigh in a value between them: the first, its slope, the second, its slope.
type Weights = [f64; 4];

/// At s, from 0 to 1 (Hermite).
fn hermite(s: f64) -> Weights {
    let r = 1.0 - s;
    [r * r * (1.0 + 2.0 * s), s * r * r, s * s * (3.0 - 2.0 * s), -s * s * r]
}

/// Of the mean from a to b: two points of Gauss, exact for cubics.
fn mean_of(a: f64, b: f64) -> Weights {
    let (middle, off) = (0.5 * (a + b), 0.5 * (b - a) / 3.0_f64.sqrt());
    let [first, second] = [middle - off, middle + off].map(hermite);
    std::array::from_fn(|n| 0.5 * (first[n] + second[n]))
}

impl Splines {
    /// Splines along rows and columns, each run between holes on its own (de Boor 2001, chapter XVII: tensor products).
    pub fn through(nodes: Nodes, gaps: &[f64], ends: Ends) -> Self {
        let [nx, ny] = nodes.shape;
        let mut samples: Vec<[f64; 4]> = gaps.iter().map(|&g| [g, 0.0, 0.0, 0.0]).collect();
        let mut along = |from: usize, to: usize, m: usize| {
            let (n, stride, lines, next) = if m == 0 { (nx, 1, ny, nx) } else { (ny, nx, nx, 1) };
            for line in 0..lines {
                let at = |k: usize| line * next + k * stride;
                for [first, end] in runs(|k| gaps[at(k)].is_finite(), n) {
                    let knots: Vec<f64> = (first..end).map(|k| k as f64).collect();
                    let values: Vec<f64> = (first..end).map(|k| samples[at(k)][from]).collect();
                    for (k, slope) in slopes(&knots, &values, ends).into_iter().enumerate() {
                        samples[at(first + k)][to] = slope;
                    }
                }
            }
        };
        along(0, 1, 0);
        along(0, 2, 1);
        along(1, 3, 1);
        Self { nodes, samples }
    }

    /// The gap at a node.
    pub fn value(&self, node: usize) -> f64 {
        self.samples[node][0]
    }

    pub fn raise(&mut self, by: f64) {
        self.samples.iter_mut().for_each(|s| s[0] += by);
    }

    /// Bernstein coefficients of cell (i, j); `None` with a hole.
    pub fn net(&self, i: usize, j: usize) -> Option<Net> {
        let [a, b, c, d] = self.corners(i, j)?;
        let edge = |p: [f64; 4], q: [f64; 4], n: usize| bernstein::cubic([p[n], q[n]], [p[n + 1], q[n + 1]]);
        let rise = |p: [f64; 4], q: [f64; 4]| bernstein::cubic([p[2], q[2]], [p[3], q[3]]);
        let (low, high) = (edge(a, b, 0), edge(c, d, 0));
        let (from_low, to_high) = (rise(a, b), rise(c, d));
        let inner = |edge: [f64; 4], rise: [f64; 4], side: f64| std::array::from_fn(|n| edge[n] + side * rise[n] / 3.0);
        Some([low, inner(low, from_low, 1.0), inner(high, to_high, -1.0), high])
    }

    /// The cell with material that holds a point, and the place in it.
    fn locate(&self, [x, y]: [f64; 2]) -> Option<(Net, [f64; 2])> {
        self.nodes
            .holding(1, y)
            .find_map(|(j, t)| self.nodes.holding(0, x).find_map(|(i, s)| self.net(i, j).map(|net| (net, [s, t]))))
    }

    /// The gap; infinite in holes and off the map.
    pub fn at(&self, p: [f64; 2]) -> f64 {
        self.locate(p).map_or(f64::INFINITY, |(net, at)| bernstein::value_of_net(&net, at))
    }

    /// Its slopes.
    pub fn gradient(&self, p: [f64; 2]) -> Option<[f64; 2]> {
        let (net, [s, t]) = self.locate(p)?;
        let [dx, dy] = self.nodes.spacing;
        let other = bernstein::transposed(&net);
        Some([bernstein::slope_of_net(&net, [s, t]) / dx, bernstein::slope_of_net(&other, [t, s]) / dy])
    }

    /// Gap, slopes and twist at the corners of cell (i, j); `None` with a hole.
    fn corners(&self, i: usize, j: usize) -> Option<[[f64; 4]; 4]> {
        let k = j * self.nodes.shape[0] + i;
        let corners = [k, k + 1, k + self.nodes.shape[0], k + self.nodes.shape[0] + 1].map(|k| self.samples[k]);
        corners.iter().all(|s| s[0].is_finite()).then_some(corners)
    }

    /// Sum of the corners of cell (i, j), weighted along x and y; `None` with a hole.
    fn weighted(&self, i: usize, j: usize, along: Weights, across: Weights) -> Option<f64> {
        let [a, b, c, d] = self.corners(i, j)?;
        let edge = |p: [f64; 4], q: [f64; 4], n: usize| {
            along[0] * p[n] + along[1] * p[n + 1] + along[2] * q[n] + along[3] * q[n + 1]
        };
        Some(
            across[0] * edge(a, b, 0)
                + across[1] * edge(a, b, 2)
                + across[2] * edge(c, d, 0)
                + across[3] * edge(c, d, 2),
        )
    }

    /// The gap in cell (i, j) at a place in it; `None` with a hole.
    pub fn inside(&self, i: usize, j: usize, [s, t]: [f64; 2]) -> Option<f64> {
        self.weighted(i, j, hermite(s), hermite(t))
    }

    /// Whether cell (i, j) may hold points below a depth.
    pub fn dips(&self, i: usize, j: usize, depth: f64) -> bool {
        // Coefficients lie no lower than this, with room for rounding.
        let lowest = |s: &[f64; 4]| s[0] - (s[1].abs() + s[2].abs()) / 3.0 - s[3].abs() / 9.0;
        let size = |s: &[f64; 4]| s[0].abs() + s[1].abs() + s[2].abs() + s[3].abs();
        let Some(corners) = self.corners(i, j) else { return false };
        if corners.iter().any(|s| s[0] < depth) {
            return true;
        }
        let largest = corners.iter().map(size).fold(0.0, f64::max);
        if corners.iter().all(|s| lowest(s) - 4.0 * ROUNDING * largest >= depth) {
            return false;
        }
        self.net(i, j).is_some_and(|net| {
            let [low, _] = bernstein::range(net.as_flattened());
            low - ROUNDING * bernstein::largest(net.as_flattened()) < depth
        })
    }

    /// The mean over a rectangle; infinite where a part of it has no material.
    pub fn mean(&self, cell: &Rect) -> f64 {
        let pieces = |m: usize| self.nodes.pieces(m, cell.min[m], cell.max[m]);
        let (Some(columns), Some(rows)) = (pieces(0), pieces(1)) else { return f64::INFINITY };
        let (mut volume, mut area) = (0.0, 0.0);
        for &(j, t0, t1) in &rows {
            let across = mean_of(t0, t1);
            for &(i, s0, s1) in &columns {
                let Some(mean) = self.weighted(i, j, mean_of(s0, s1), across) else { return f64::INFINITY };
                let part = (s1 - s0) * (t1 - t0);
                volume += part * mean;
                area += part;
            }
        }
        if area > 0.0 { volume / area } else { self.at(cell.centre()) }
    }

    /// By how much rounding may move a place in a cell, in steps, and the coefficients of the polynomial there.
    fn moved(&self, m: usize, cell: usize, far: f64) -> f64 {
        let from = self.nodes.origin[m].abs() + cell as f64 * self.nodes.spacing[m];
        (4.0 * f64::EPSILON * (far + from) / self.nodes.spacing[m]).max(4.0 * f64::EPSILON)
    }

    /// Bounds of the gap less slope . (x - c) over the part of a cell that a rectangle with middle c covers; `None` with a hole.
    pub fn over(&self, i: usize, j: usize, [s, t]: [[f64; 2]; 2], slope: [f64; 2], rect: &Rect) -> Option<[f64; 2]> {
        let net = self.net(i, j)?;
        let mut part = bernstein::part_of_net(&net, s, t);
        let ([x, y], c, [dx, dy]) = (self.nodes.node(i, j), rect.centre(), self.nodes.spacing);
        for (row, values) in part.iter_mut().enumerate() {
            for (column, value) in values.iter_mut().enumerate() {
                let along = |[a, b]: [f64; 2], n: usize| a + (b - a) * n as f64 / 3.0;
                *value -= slope[0] * (x + dx * along(s, column) - c[0]) + slope[1] * (y + dy * along(t, row) - c[1]);
            }
        }
        let [low, high] = bernstein::range(part.as_flattened());
        let [least, most] = bernstein::range(net.as_flattened());
        let far = [0, 1].map(|m| rect.min[m].abs().max(rect.max[m].abs()));
        let places = self.moved(0, i, far[0]) + self.moved(1, j, far[1]);
        let steep = (slope[0] * dx).abs() + (slope[1] * dy).abs();
        let size = least.abs().max(most.abs());
        let room = ROUNDING * (size + steep) + places * (6.0 * (most - least) + steep);
        Some([low - room, high + room])
    }

    /// Second derivatives xx, xy, yy over a part of a cell; `None` with a hole.
    pub fn curvatures(&self, i: usize, j: usize, [s, t]: [[f64; 2]; 2]) -> Option<[Interval; 3]> {
        let net = self.net(i, j)?;
        let other = bernstein::transposed(&net);
        let [dx, dy] = self.nodes.spacing.map(Interval::point);
        // Places are wrong by rounding at most.
        let wider = |[a, b]: [f64; 2]| [(a - AT_EDGE).max(0.0), (b + AT_EDGE).min(1.0)];
        let (s, t) = (wider(s), wider(t));
        let size = bernstein::largest(net.as_flattened());
        let enclosed = |[low, high]: [f64; 2]| {
            let room = ROUNDING * (12.0 * size + low.abs().max(high.abs()));
            Interval::new(low - room, high + room)
        };
        Some([
            enclosed(bernstein::curvature_of_net(&net, s, t)) / dx.powi(2),
            enclosed(bernstein::twist_of_net(&net, s, t)) / (dx * dy),
            enclosed(bernstein::curvature_of_net(&other, t, s)) / dy.powi(2),
        ])
    }

    /// Gap and slopes at a point, with what rounding may have done to them.
    pub fn enclosed(&self, p: [f64; 2]) -> Option<[Interval; 3]> {
        let (net, at) = self.locate(p)?;
        let [least, most] = bernstein::range(net.as_flattened());
        let (size, varies) = (least.abs().max(most.abs()), most - least);
        let places = [0, 1].map(|m| self.moved(m, self.nodes.shape[m], p[m].abs())).iter().sum::<f64>();
        let room = ROUNDING * size + 6.0 * places * varies;
        let value = bernstein::value_of_net(&net, at);
        let steep = |net: &Net, at: [f64; 2], step: f64| {
            let slope = bernstein::slope_of_net(net, at);
            let room = 6.0 * ROUNDING * size + 24.0 * places * varies;
            Interval::new(slope - room, slope + room) / Interval::point(step)
        };
        let [dx, dy] = self.nodes.spacing;
        let other = bernstein::transposed(&net);
        Some([Interval::new(value - room, value + room), steep(&net, at, dx), steep(&other, [at[1], at[0]], dy)])
    }

    /// A place where the gap is least, the value there, and a number that it is nowhere less than.
    pub fn least(&self) -> ([f64; 2], f64, f64) {
        let [nx, ny] = self.nodes.shape;
        let place = |i: usize, j: usize, [s, t]: [f64; 2]| {
            let [x, y] = self.nodes.node(i, j);
            [x + s * self.nodes.spacing[0], y + t * self.nodes.spacing[1]]
        };
        let cells = || (0..ny - 1).flat_map(|j| (0..nx - 1).map(move |i| (i, j)));
        let mut best = ([0.0; 2], f64::INFINITY);
        for (i, j) in cells() {
            let Some(net) = self.net(i, j) else { continue };
            for (at, value) in
                [([0.0, 0.0], net[0][0]), ([1.0, 0.0], net[0][3]), ([0.0, 1.0], net[3][0]), ([1.0, 1.0], net[3][3])]
            {
                if value < best.1 {
                    best = (place(i, j, at), value);
                }
            }
        }
        // Level by level: what cannot be less than the best is dropped, the rest is cut into quarters.
        let (mut bound, mut looked) = (f64::INFINITY, 0);
        let mut open: Vec<([usize; 2], [[f64; 2]; 2])> = cells().map(|(i, j)| ([i, j], [[0.0, 1.0]; 2])).collect();
        while !open.is_empty() {
            let mut looks = Vec::with_capacity(open.len());
            for ([i, j], [s, t]) in open {
                let Some(net) = self.net(i, j) else { continue };
                let close = ROUNDING * bernstein::largest(net.as_flattened());
                let [low, _] = bernstein::range(bernstein::part_of_net(&net, s, t).as_flattened());
                let at = [0.5 * (s[0] + s[1]), 0.5 * (t[0] + t[1])];
                let value = bernstein::value_of_net(&net, at);
                if value < best.1 {
                    best = (place(i, j, at), value);
                }
                looks.push(([i, j], [s, t], at, low, close));
            }
            looked += looks.len();
            open = Vec::new();
            for (cell, [s, t], at, low, close) in looks {
                if !(low < best.1 - close) || s[1] - s[0] < 1e-12 || looked > BUDGET.max(8 * nx * ny) {
                    bound = bound.min(low - close);
                    continue;
                }
                for s in [[s[0], at[0]], [at[0], s[1]]] {
                    open.extend([[t[0], at[1]], [at[1], t[1]]].map(|t| (cell, [s, t])));
                }
            }
        }
        (best.0, best.1, bound.min(best.1))
    }
}
