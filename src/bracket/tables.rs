//! What the polynomial of [`super::polynomial`] leaves of the displacement in a cell, by unit pressure on one other cell.
//!
//! With K_j the displacement by cell j and P the polynomial through its values at the centres, e_j = K_j - P K_j is large
//! where cell j is near, and falls with the sixth power of its distance. In the middle cell i of a block B of cells
//!
//!   u = P u + sum over j in B of (q_j - q_i) e_j + q_i e_B + sum over j exterior B of q_j e_j,
//!
//! with e_B that of the block under uniform pressure, which has a repaired form. The tables hold values and slopes of e_j at
//! the points of a lattice, bounds of what e_j does around such a point, and bounds over the whole cell.

use std::f64::consts::FRAC_1_PI;
use std::sync::{Arc, Mutex, PoisonError};

use super::kernel;
use super::polynomial::NODES;
use super::source::Source;
use super::trend::Trend;

/// Half the side of the block B, in longest sides of a cell, less half a cell.
const BLOCK: f64 = 10.0;

/// The same for the block of the cells that count by values and slopes, and for those that count one by one in bounds over a
/// whole cell: in close ones and in rough ones.
const NEAR: f64 = 4.0;
const CLOSE: f64 = 6.0;
const ROUGH: f64 = 2.0;

/// Tiles along a cell over which a bound is put together, and for the cells that touch it.
const TILES: [usize; 2] = [12, 32];

/// Tiles along a sub-square of a cell.
const SUB_TILES: usize = 10;

/// Largest of |s (s^2 - 1)(s^2 - 4)| for |s| <= 1/2, and sum of the weights of the nodes there.
const NODAL: f64 = 1.40625;
const WEIGHTS: f64 = 1.4;

/// Tables that are kept.
const MOST_KEPT: usize = 4;

/// Tables for cells of one aspect ratio, longer side 1, and lattices of S x S points a cell.
#[derive(Debug)]
pub(super) struct Tables {
    h: [f64; 2],
    /// Half sides of B, in cells.
    pub block: [usize; 2],
    pub near: [usize; 2],
    pub per_cell: usize,
    /// Supremum of |e_j| over the cell, j in B, x fastest; 0 in the middle.
    whole: Vec<f64>,
    /// The same for bounds over a whole cell.
    pub close: Weights,
    pub rough: Weights,
    /// Those of the close ones that are not near.
    pub far: Weights,
    /// What jumps that grow steadily do.
    pub trend: Trend,
    /// Supremum of |e_B|.
    pub uniform: f64,
    /// Sum of the suprema of |e_j| over all cells exterior B.
    pub beyond: f64,
    /// Sub-squares with their middle at (k + 1/2)/S of a cell, and with half their sides.
    pub squares: [Squares; 2],
    /// Points at k/S of a cell, its border included.
    pub points: Points,
}

/// Suprema of |e_j| for the cells j of a block about the middle one, and what is left of B.
#[derive(Debug, Default)]
pub(super) struct Weights {
    /// Half sides of the block.
    pub half: [usize; 2],
    /// x fastest.
    pub each: Vec<f64>,
    /// Sum over the rest of B: of the suprema, and of them times the offset along x and y in cells.
    pub rest: [f64; 3],
}

/// A lattice of sub-squares.
#[derive(Debug, Default)]
pub(super) struct Squares {
    /// Half the side of each, in sides of the cell.
    pub half: f64,
    /// Their middles, from the centre of the cell.
    pub at: Vec<[f64; 2]>,
    /// For each square and each cell of the near block, x fastest: e_j, its slopes per side of the cell, and the supremum of its
    /// distance from that plane.
    pub values: Vec<[f64; 4]>,
    /// The same of e_B.
    pub uniform: Vec<[f64; 4]>,
}

/// A lattice of points.
#[derive(Debug, Default)]
pub(super) struct Points {
    /// In sides of the cell from its centre.
    pub at: Vec<[f64; 2]>,
    /// e_j for each cell of the near block and each point.
    pub values: Vec<f64>,
    /// e_B.
    pub uniform: Vec<f64>,
}

/// Half sides of a block in cells.
fn half_sides(h: [f64; 2], longest: f64) -> [usize; 2] {
    h.map(|side| (longest / side).ceil() as usize)
}

impl Tables {
    /// For cells of these sides. The last few are kept: they take as long as a solve on a coarse grid.
    pub fn of(spacing: [f64; 2], per_cell: usize) -> Arc<Self> {
        static KEPT: Mutex<Vec<Arc<Tables>>> = Mutex::new(Vec::new());
        let longer = spacing[0].max(spacing[1]);
        // Grids over a rectangle have sides that differ by rounding: the tables then do by as much.
        let h = spacing.map(|s| if s > longer * (1.0 - 1e-13) { 1.0 } else { s / longer });
        let kept = || KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().iter().find(|t| t.h == h && t.per_cell == per_cell) {
            return known.clone();
        }
        let tables = Arc::new(Self::new(h, per_cell));
        let mut kept = kept();
        if kept.len() >= MOST_KEPT {
            kept.remove(0);
        }
        kept.push(tables.clone());
        tables
    }

    fn new(h: [f64; 2], per_cell: usize) -> Self {
        let (block, near) = (half_sides(h, BLOCK), half_sides(h, NEAR));
        let big = [0, 1].map(|m| (2 * block[m] + 1) as f64 * h[m]);
        let uniform = Source::new(h, big, [0, 0]);
        // Of the block, in the middle cell: u_xx is a sum of four terms v/(u r) of one sign, u_xy of four terms 1/r of
        // alternating sign.
        let [inner, outer] = [0.0, 1.0].map(|side| [0, 1].map(|m| (block[m] as f64 + side) * h[m]));
        let along = |m: usize| FRAC_1_PI * 4.0 * outer[1 - m] / (inner[m] * inner[m].hypot(outer[1 - m])) * h[m] * h[m];
        let mixed = FRAC_1_PI * (2.0 / inner[0].hypot(inner[1]) - 2.0 / outer[0].hypot(outer[1])) * h[0] * h[1];
        let flat = [along(0), mixed, along(1)];

        let cells = |b: [usize; 2]| (2 * b[0] + 1) * (2 * b[1] + 1);
        let mut tables = Self {
            h,
            block,
            near,
            per_cell,
            whole: vec![0.0; cells(block)],
            close: Weights::default(),
            rough: Weights::default(),
            far: Weights::default(),
            trend: Trend::new(h, block),
            uniform: uniform.smooth([0.0; 2], 0.5, 64, flat, [0.0; 3]),
            beyond: beyond(h, block),
            squares: Default::default(),
            points: Points::default(),
        };
        for (level, squares) in tables.squares.iter_mut().enumerate() {
            let n = per_cell << level;
            squares.half = 0.5 / n as f64;
            squares.at = lattice(n, |k| (k as f64 + 0.5) / n as f64 - 0.5);
            squares.values = vec![[0.0; 4]; cells(near) * n * n];
            let of = |at: &[f64; 2]| {
                let plane = uniform.error(*at);
                let [v, s, t] = plane;
                [v, s, t, uniform.smooth(*at, squares.half, 8, flat, plane)]
            };
            squares.uniform = squares.at.iter().map(of).collect();
        }
        let points = &mut tables.points;
        points.at = lattice(per_cell + 1, |k| k as f64 / per_cell as f64 - 0.5);
        points.values = vec![0.0; cells(near) * points.at.len()];
        points.uniform = points.at.iter().map(|at| uniform.error(*at)[0]).collect();
        // One quadrant of sources; the others are its mirror images.
        for b in 0..=block[1] {
            for a in 0..=block[0] {
                if [a, b] != [0, 0] {
                    tables.source([a, b]);
                }
            }
        }
        tables.close = tables.weights(half_sides(h, CLOSE));
        tables.rough = tables.weights(half_sides(h, ROUGH));
        tables.far = tables.weights(half_sides(h, CLOSE));
        let (far, width) = (&mut tables.far, 2 * half_sides(h, CLOSE)[0] + 1);
        for (k, weight) in far.each.iter_mut().enumerate() {
            let at = [k % width, k / width];
            if (0..2).all(|m| at[m].abs_diff(far.half[m]) <= near[m]) {
                *weight = 0.0;
            }
        }
        tables
    }

    fn weights(&self, half: [usize; 2]) -> Weights {
        let mut weights = Weights { half, ..Weights::default() };
        let width = 2 * self.block[0] + 1;
        for (k, &weight) in self.whole.iter().enumerate() {
            let off = [(k % width).abs_diff(self.block[0]), (k / width).abs_diff(self.block[1])];
            if off[0] <= half[0] && off[1] <= half[1] {
                weights.each.push(weight);
            } else {
                let by = [1.0, off[0] as f64, off[1] as f64];
                (0..3).for_each(|m| weights.rest[m] += by[m] * weight);
            }
        }
        weights
    }

    fn source(&mut self, offset: [usize; 2]) {
        let h = self.h;
        let source = Source::new(h, h, offset.map(|o| o as i64));
        let touching = offset[0] <= 1 && offset[1] <= 1;
        let most = if touching { f64::INFINITY } else { kernel::curvature(h, offset) };
        let curvature = [most * h[0] * h[0], 0.0, most * h[1] * h[1]];
        let whole = if touching {
            source.rough([0.0; 2], 0.5, TILES[1], [0.0; 3])
        } else {
            source.smooth([0.0; 2], 0.5, TILES[0], curvature, [0.0; 3])
        };
        let mirrors = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        for [x, y] in mirrors {
            let place = |b: [usize; 2]| {
                let to = |m: usize, sign: f64| (b[m] as i64 + sign as i64 * offset[m] as i64) as usize;
                to(1, y) * (2 * b[0] + 1) + to(0, x)
            };
            self.whole[place(self.block)] = whole;
        }
        if offset[0] > self.near[0] || offset[1] > self.near[1] {
            return;
        }
        let width = 2 * self.near[0] + 1;
        let near = self.near;
        let cells = width * (2 * near[1] + 1);
        let place = |[x, y]: [f64; 2]| {
            let to = |m: usize, sign: f64| (near[m] as i64 + sign as i64 * offset[m] as i64) as usize;
            to(1, y) * width + to(0, x)
        };
        for (level, squares) in self.squares.iter_mut().enumerate() {
            let n = self.per_cell << level;
            for k in 0..n * n {
                let (at, half) = (squares.at[k], squares.half);
                let plane = source.error(at);
                let bend = if touching {
                    source.rough(at, half, SUB_TILES, plane)
                } else {
                    let [a, b] = h;
                    0.5 * most * (a * a + b * b) * half * half + source.polynomial.bend(half)
                };
                for [x, y] in mirrors {
                    let mirror = |k: usize, sign: f64| if sign < 0.0 { n - 1 - k } else { k };
                    let square = mirror(k / n, y) * n + mirror(k % n, x);
                    squares.values[square * cells + place([x, y])] = [plane[0], x * plane[1], y * plane[2], bend];
                }
            }
        }
        let n = self.per_cell;
        let n = n + 1;
        for k in 0..n * n {
            let value = source.error(self.points.at[k])[0];
            for [x, y] in mirrors {
                let mirror = |k: usize, sign: f64| if sign < 0.0 { n - 1 - k } else { k };
                let point = mirror(k / n, y) * n + mirror(k % n, x);
                self.points.values[place([x, y]) * n * n + point] = value;
            }
        }
    }
}

fn lattice(n: usize, place: impl Fn(usize) -> f64) -> Vec<[f64; 2]> {
    (0..n * n).map(|k| [place(k % n), place(k / n)]).collect()
}

/// Sum of bounds of |e_j| over all cells exterior the block: the remainder of interpolation in either direction,
/// NODAL/5! times the fifth derivative, which is at most 5!/r^6 of a unit of load.
fn beyond(h: [f64; 2], block: [usize; 2]) -> f64 {
    let far = half_sides(h, 8.0 * BLOCK);
    let powers = h[0].powi(5) + WEIGHTS * h[1].powi(5);
    let unit = FRAC_1_PI * h[0] * h[1] * NODAL * powers.max(h[1].powi(5) + WEIGHTS * h[0].powi(5));
    // The nodes reach NODES cells from the middle, the load half a cell from its own.
    let close = NODES as f64 + 0.5;
    let mut sum = 0.0;
    for b in 0..=far[1] {
        let y = (b as f64 - close).max(0.0) * h[1];
        for a in 0..=far[0] {
            if a <= block[0] && b <= block[1] {
                continue;
            }
            let x = (a as f64 - close).max(0.0) * h[0];
            let images = if a == 0 || b == 0 { 2.0 } else { 4.0 };
            sum += images * unit / (x * x + y * y).powi(3);
        }
    }
    // Further out: an integral of r^-6 over the plane beyond, with room for the width of the cells.
    let rest = 8.0 * BLOCK - 4.0;
    sum + 2.0 * std::f64::consts::PI * unit / (h[0] * h[1]) / (4.0 * rest.powi(4)) * 1.2
}
