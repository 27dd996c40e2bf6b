//! The compliance matrix of the orbits of cells: pair integrals with a bound of their error.

use super::Means;
use super::line_potential::{Lines, Points, Scratch};
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use super::pair_integral::{Integral, polygons, rectangles};
use super::symmetry::Orbits;
use crate::numeric::simd::{self, wide};
use crate::threads::all;

/// <p, S p> of symmetric pressures is sum over a, b of p_a p_b `matrix[a][b]`, E* = 1; each entry is within `error[a][b]`.
#[derive(Debug, Clone)]
pub(crate) struct Compliance {
    /// Orbits of loaded cells.
    pub n: usize,
    /// Row by row, n x n, symmetric.
    pub matrix: Vec<f64>,
    /// Bounds of the errors, row by row.
    pub error: Vec<f64>,
    /// That may factor it.
    pub threads: usize,
}

/// The rectangle with sides along and across the first direction of a cell, around its corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Around {
    pub centre: Point,
    pub axis: Point,
    pub half: Point,
    /// The axis is the second direction of the cell.
    pub swapped: bool,
    /// Sine of the largest angle between a direction of the cell and the axis, or the normal of it.
    pub turn: f64,
}

impl Around {
    pub fn new(map: &Bilinear) -> Self {
        // The longer of the two directions.
        let [a, b] = map.along;
        let swapped = dot(a, a) < dot(b, b);
        let along = if swapped { b } else { a };
        let length = norm(along);
        let axis = along.map(|c| c / length);
        let mut turn: f64 = 0.0;
        for side in [-1.0, 1.0] {
            for (v, long) in [(map.ds(side), !swapped), (map.dt(side), swapped)] {
                let off = if long { cross(axis, v) } else { dot(axis, v) };
                turn = turn.max(off.abs() / norm(v));
            }
        }
        Self { centre: map.centre, axis, half: [0.0; 2], swapped, turn }.over(&map.corners())
    }

    /// The rectangle with the same axis around other points.
    pub fn over(&self, points: &[Point]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            for (k, c) in self.local(*p).into_iter().enumerate() {
                low[k] = low[k].min(c);
                high[k] = high[k].max(c);
            }
        }
        let centre = self.outer([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]);
        Self { centre, half: [0, 1].map(|k| 0.5 * (high[k] - low[k])), ..*self }
    }

    /// A point given along and across.
    fn outer(&self, [u, v]: Point) -> Point {
        let [x, y] = self.axis;
        [self.centre[0] + u * x - v * y, self.centre[1] + u * y + v * x]
    }

    /// Its corners, counter-clockwise.
    pub fn corners(&self) -> [Point; 4] {
        let [a, b] = self.half;
        [[-a, -b], [a, -b], [a, b], [-a, b]].map(|p| self.outer(p))
    }

    /// Along and across.
    #[inline(always)]
    pub fn local(&self, p: Point) -> Point {
        let v = minus(p, self.centre);
        [dot(self.axis, v), cross(self.axis, v)]
    }

    /// The distance of a point; zero inside.
    #[inline(always)]
    pub fn distance(&self, p: Point) -> f64 {
        let [u, v] = self.local(p);
        norm([(u.abs() - self.half[0]).max(0.0), (v.abs() - self.half[1]).max(0.0)])
    }

    /// A lower bound of the distance of the convex hull of points.
    #[inline(always)]
    pub fn distance_to_hull(&self, points: &[Point]) -> f64 {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            let q = self.local(*p);
            for k in 0..2 {
                low[k] = low[k].min(q[k]);
                high[k] = high[k].max(q[k]);
            }
        }
        norm([0, 1].map(|k| (low[k] - self.half[k]).max(-high[k] - self.half[k]).max(0.0)))
    }
}

/// What the assembly knows of a cell.
struct Shape {
    map: Bilinear,
    around: Around,
    corners: [Point; 4],
    /// Half lengths along s and t, at most.
    half: [f64; 2],
    /// Variation of the Jacobian over its mean.
    skew: f64,
    radius: f64,
    /// Opposite corners, for a rectangle along the axes.
    rectangle: Option<[Point; 2]>,
}

impl Shape {
    fn new(corners: [Point; 4]) -> Self {
        let map = Bilinear::new(corners);
        let half = [norm(map.ds(-1.0)).max(norm(map.ds(1.0))), norm(map.dt(-1.0)).max(norm(map.dt(1.0)))];
        let j0 = cross(map.along[0], map.along[1]);
        let skew = (cross(map.along[0], map.twist).abs() + cross(map.twist, map.along[1]).abs()) / j0;
        let [a, b, c, d] = corners;
        let straight = a[1] == b[1] && c[1] == d[1] && a[0] == d[0] && b[0] == c[0];
        let radius = corners.iter().map(|p| norm(minus(*p, map.centre))).fold(0.0, f64::max);
        Self { map, around: Around::new(&map), corners, half, skew, radius, rectangle: straight.then_some([a, c]) }
    }

    fn size(&self) -> f64 {
        2.0 * self.half[0].max(self.half[1])
    }

    fn distance(&self, other: &Self) -> f64 {
        let circles = norm(minus(self.map.centre, other.map.centre)) - self.radius - other.radius;
        circles.max(self.around.distance_to_hull(&other.corners)).max(other.around.distance_to_hull(&self.corners))
    }
}

/// Rows of pairs that are kept at once.
const ROWS: usize = 512;

/// Far pairs lie further apart than this many sizes of the smaller cell.
const FAR: f64 = 3.0;

/// The factor of the remainder of the Gauss rule with 3 nodes: 2^7 (3!)^4/(7 (6!)^3) sup f^(6) against the mean 2 f, with
/// |d^6/ds^6 1/r| <= 6!/r^7.
const GAUSS_3: f64 = 64.0 * 1296.0 / (7.0 * 720.0 * 720.0);

impl Compliance {
    /// `None` once the time is used up.
    pub fn new(mesh: &Mesh, lines: &Lines, orbits: &Orbits, means: Means) -> Option<Self> {
        let n = orbits.loaded;
        let (mut matrix, mut error) = (vec![0.0; n * n], vec![0.0; n * n]);
        pairs(mesh, lines, orbits, means, |a, j, Integral { value, error: bound }| {
            let (b, weight) = (orbits.orbit[j], orbits.size[a] as f64 * std::f64::consts::FRAC_1_PI);
            matrix[a * n + b] += weight * value;
            error[a * n + b] += weight * bound;
        })?;
        for a in 0..n {
            for b in 0..a {
                matrix[b * n + a] = matrix[a * n + b];
                error[b * n + a] = error[a * n + b];
            }
        }
        Some(Self { n, matrix, error, threads: means.threads })
    }

    /// The same of every cell by itself: the orbits only save integrals.
    pub fn of_cells(mesh: &Mesh, lines: &Lines, orbits: &Orbits, means: Means) -> Option<Self> {
        let n = mesh.loaded;
        let (mut matrix, mut error) = (vec![0.0; n * n], vec![0.0; n * n]);
        pairs(mesh, lines, orbits, means, |a, j, integral| {
            let [value, bound] = [integral.value, integral.error].map(|v| v * std::f64::consts::FRAC_1_PI);
            for image in &orbits.images {
                let (i, j) = (image[orbits.representatives[a]], image[j]);
                for at in [i * n + j, j * n + i] {
                    (matrix[at], error[at]) = (value, bound);
                }
            }
        })?;
        Some(Self { n, matrix, error, threads: means.threads })
    }

    /// S p of the orbits, weighted by area and orbit size.
    pub fn product(&self, p: &[f64]) -> Vec<f64> {
        self.rows(&self.matrix, p)
    }

    /// What each entry of S q may be off, for entries of q that are known to their sizes alone.
    pub fn off(&self, q: &[f64]) -> Vec<f64> {
        self.rows(&self.error, &q.iter().map(|q| q.abs()).collect::<Vec<f64>>())
    }

    /// sum over a, b of |p_a q_b| error: what <p, S q> may be off.
    pub fn uncertainty(&self, p: &[f64], q: &[f64]) -> f64 {
        known_to(p, &self.off(q))
    }

    fn rows(&self, of: &[f64], p: &[f64]) -> Vec<f64> {
        // As of what is cut off a pressure where that needs no cut.
        if p.iter().all(|p| *p == 0.0) {
            return vec![0.0; self.n];
        }
        wide(|| of.chunks_exact(self.n).map(|row| simd::dot(row, p)).collect())
    }
}

/// What <p, u> may be off, where each entry of u may be off by `off`.
pub(super) fn known_to(p: &[f64], off: &[f64]) -> f64 {
    p.iter().zip(off).map(|(p, off)| p.abs() * off).sum()
}

/// int int 1/r over the representative of orbit a and cell j, for every pair but for the symmetries and the order; `None` once the time is
/// used up.
fn pairs(
    mesh: &Mesh,
    lines: &Lines,
    orbits: &Orbits,
    means: Means,
    mut add: impl FnMut(usize, usize, Integral),
) -> Option<()> {
    let (n, loaded) = (orbits.loaded, mesh.loaded);
    let shapes: Vec<Shape> = (0..loaded).map(|i| Shape::new(mesh.corners(i))).collect();
    let gauss = gauss_rows(mesh, lines, orbits, &shapes, means)?;
    let carriers = orbits.carriers();
    // inverse[g][i]: the cell that element g takes to cell i.
    let inverse: Vec<Vec<usize>> = orbits
        .images
        .iter()
        .map(|image| {
            let mut inverse = vec![0; image.len()];
            for (i, &j) in image.iter().enumerate() {
                inverse[j] = i;
            }
            inverse
        })
        .collect();
    let row = |&a: &usize| -> Option<Vec<(usize, Integral)>> {
        if means.deadline.has_passed() {
            return None;
        }
        let i = orbits.representatives[a];
        let own = &shapes[i];
        let before = shapes.iter().enumerate().filter(|(j, _)| orbits.orbit[*j] <= a);
        let integral = |(j, other): (usize, &Shape)| {
            let b = orbits.orbit[j];
            let distance = own.distance(other);
            let integral = if distance > FAR * own.size().min(other.size()) {
                let own_smaller = own.size() <= other.size();
                let value = if own_smaller { gauss[a][j] } else { gauss[b][inverse[carriers[j]][i]] };
                let carrier = if own_smaller { own } else { other };
                Integral { value, error: value * relative_error(carrier, distance) }
            } else {
                match (own.rectangle, other.rectangle) {
                    (Some(p), Some(q)) => rectangles(p, q),
                    _ => polygons(&own.corners, &other.corners),
                }
            };
            (j, integral)
        };
        Some(before.map(integral).collect())
    };
    let every: Vec<usize> = (0..n).collect();
    for some in every.chunks(ROWS) {
        for (a, row) in some.iter().zip(all(some, means.of(n), row)?) {
            row.into_iter().for_each(|(j, integral)| add(*a, j, integral));
        }
    }
    Some(())
}

/// Relative remainder of the 3 x 3 Gauss rule on a cell, for the potential of another one at least `distance` away: with
/// V = int 1/r, |d^k V| <= k! V/distance^k, and V varies over the cell by at most 1 + size/distance.
fn relative_error(carrier: &Shape, distance: f64) -> f64 {
    let variation = (1.0 + 2.0 * carrier.radius / distance) * (1.0 + carrier.skew);
    let direction = |h: f64| {
        let q = h / distance;
        q.powi(6) + carrier.skew * q.powi(5)
    };
    GAUSS_3 * variation * (direction(carrier.half[0]) + direction(carrier.half[1])) + 1e-13
}

/// Row a: the 3 x 3 Gauss sums over representative a of the potentials int 1/r of all cells that are at least as large; a pair takes
/// the sum over its smaller one.
fn gauss_rows(mesh: &Mesh, lines: &Lines, orbits: &Orbits, shapes: &[Shape], means: Means) -> Option<Vec<Vec<f64>>> {
    const PER_BATCH: usize = 7;
    /// Batches of one thread at a time, which share its buffers.
    const PART: usize = 8;
    let loaded = mesh.loaded;
    // Large cells first, so that those at least as large as some cell, and their edges, come before the others.
    let mut cells: Vec<usize> = (0..loaded).collect();
    cells.sort_by(|&a, &b| shapes[b].size().total_cmp(&shapes[a].size()));
    let mut place = vec![usize::MAX; mesh.edges.len()];
    let mut edges = Vec::with_capacity(mesh.edges.len());
    // Of each cell: how many edges it needs.
    let mut needed = Vec::with_capacity(loaded);
    for &cell in &cells {
        for (edge, _) in mesh.cell_edges[cell].iter().flatten() {
            if place[*edge] == usize::MAX {
                place[*edge] = edges.len();
                edges.push(*edge);
            }
        }
        needed.push(edges.len());
    }
    let ordered = lines.subset(edges.into_iter());
    let mut reps: Vec<usize> = (0..orbits.loaded).collect();
    reps.sort_by(|&a, &b| {
        let size = |orbit: usize| shapes[orbits.representatives[orbit]].size();
        size(b).total_cmp(&size(a))
    });
    let some = |reps: &&[usize]| {
        let (mut scratch, mut rows) = (Scratch::default(), Vec::with_capacity(reps.len()));
        for batch in reps.chunks(PER_BATCH) {
            if means.deadline.has_passed() {
                return None;
            }
            let mut points = Points::EMPTY;
            let mut weights = Vec::with_capacity(9 * PER_BATCH);
            let mut smallest = f64::INFINITY;
            for &orbit in batch {
                let shape = &shapes[orbits.representatives[orbit]];
                smallest = smallest.min(shape.size());
                for (point, weight) in shape.map.gauss() {
                    points.push(point);
                    weights.push(weight);
                }
            }
            // Images of one cell differ by rounding.
            let larger = cells.partition_point(|&j| shapes[j].size() >= smallest * (1.0 - 1e-9));
            ordered.moments(&points, larger.checked_sub(1).map_or(0, |last| needed[last]), &mut scratch);
            let mut own = vec![vec![0.0; loaded]; batch.len()];
            for &j in &cells[..larger] {
                for (c, row) in own.iter_mut().enumerate() {
                    for (edge, sign) in mesh.cell_edges[j].iter().flatten() {
                        let products = &scratch.products[place[*edge]];
                        let part: f64 = (9 * c..9 * c + 9).map(|k| weights[k] * products[k]).sum();
                        row[j] += sign * part;
                    }
                }
            }
            rows.extend(own);
        }
        Some(rows)
    };
    let parts: Vec<&[usize]> = reps.chunks(PART * PER_BATCH).collect();
    let mut rows = vec![Vec::new(); orbits.loaded];
    for (&orbit, row) in reps.iter().zip(all(&parts, means.of(orbits.loaded), some)?.into_iter().flatten()) {
        rows[orbit] = row;
    }
    Some(rows)
}
