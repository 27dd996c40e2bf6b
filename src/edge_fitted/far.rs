//! What is far from a cell: bounds of its derivatives there, and of what interpolation over the cell leaves out
//! (`interpolation` has the inequalities).

use super::compliance::Around;
use super::gauss::{B, NODES};
use super::interpolation::{CHOICES, distance_from_line};
use super::mesh::{Point, dot};
use super::subcell::{NearEdge, corner_coordinates};

/// Nodes of a block (a whole cell) along each direction, at least and at most: the field of what is not near is
/// interpolated from them.
pub(crate) const BLOCK_NODES: [usize; 2] = [3, 8];

/// sup of the monic Chebyshev polynomial of degree `n` on [-1, 1].
fn chebyshev_size(n: usize) -> f64 {
    0.5f64.powi(n as i32 - 1)
}

/// A bound of the Lebesgue constant of up to 8 Chebyshev nodes: 2/pi ln 8 + 1 (Rivlin 1974).
const CHEBYSHEV_LEBESGUE: f64 = 2.33;

/// Sums over what is not near a cell: by direction, the coefficients of h^m in the bounds on a subcell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Far {
    pub slope: [[f64; CHOICES]; 2],
    pub value: [[f64; CHOICES]; 2],
    /// What the interpolation of slope and value over the whole cell leaves out, at most: set by [`Far::choose`].
    pub block: [f64; 2],
    /// The same by direction, for 3 to 8 nodes.
    orders: [[[f64; ORDERS]; 2]; 2],
    /// Sum of all strengths, for the rounding.
    pub strength: f64,
}

impl Far {
    pub const ZERO: Self = Self {
        slope: [[0.0; CHOICES]; 2],
        value: [[0.0; CHOICES]; 2],
        block: [0.0; 2],
        orders: [[[0.0; ORDERS]; 2]; 2],
        strength: 0.0,
    };

    /// Adds `strength` times a source with these bounds, on a cell of half lengths `half`.
    pub fn add(&mut self, strength: f64, source: &Source, half: [f64; 2]) {
        self.add_derivatives(strength, source, half);
        self.strength += strength;
    }

    /// The same without its strength.
    pub fn add_derivatives(&mut self, strength: f64, source: &Source, half: [f64; 2]) {
        for k in 0..2 {
            for i in 0..CHOICES {
                self.slope[k][i] += strength * source.slope[k][i + NODES[0]];
                self.value[k][i] += strength * source.value[k][i + NODES[0]];
            }
        }
        for k in 0..2 {
            let mut power = half[k] * half[k];
            for m in BLOCK_NODES[0]..ORDERS {
                power *= half[k];
                let factor = strength * power * chebyshev_size(m);
                self.orders[0][k][m] += factor * source.slope[k][m];
                self.orders[1][k][m] += factor * source.value[k][m];
            }
        }
    }

    /// The least numbers of nodes along both directions that leave out no more than `allowed` of the slope, the value over
    /// `decay` added; the most where none do.
    pub fn choose(&self, allowed: f64, decay: f64) -> [usize; 2] {
        least_nodes(allowed, |k, m| self.orders[0][k][m] + self.orders[1][k][m] / decay)
    }

    /// Takes the bounds for these numbers of nodes, at which slope and value are known within `nodal`.
    pub fn set(&mut self, count: [usize; 2], nodal: [f64; 2]) {
        self.block = [0, 1].map(|q| {
            let left_out = self.orders[q][0][count[0]] + CHEBYSHEV_LEBESGUE * self.orders[q][1][count[1]];
            left_out + CHEBYSHEV_LEBESGUE.powi(2) * nodal[q]
        });
    }
}

/// The highest derivative that is bounded.
const ORDERS: usize = BLOCK_NODES[1] + 1;

/// |d^m|/m! of slope and displacement of a source of strength 1 at the points of a cell, along its two directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    slope: [[f64; ORDERS]; 2],
    value: [[f64; ORDERS]; 2],
}

impl Source {
    /// A cell of pressure pi within a rectangle `length` x `thickness`, `delta` away.
    pub fn cell([length, thickness]: [f64; 2], delta: f64) -> Self {
        let (mut slope, mut value) = ([0.0; ORDERS], [0.0; ORDERS]);
        let mut power = thickness / delta;
        for m in 1..ORDERS {
            power /= delta;
            // power = thickness/delta^(m+1).
            value[m] = power * length.min(2.0 * B[m] * delta);
            slope[m] = (m + 1) as f64 * power / delta * length.min(2.0 * B[m + 1] * delta);
        }
        Self { slope: [slope; 2], value: [value; 2] }
    }

    /// A single edge, `delta` away, seen from a cell.
    pub fn edge<const K: usize>(e: &NearEdge<K>, around: &Around, corners: &[Point; 4], delta: f64) -> Self {
        let (d, a) = corner_coordinates(corners, e);
        let line = distance_from_line(&d);
        let beside = a.iter().all(|x| *x > e.length) || a.iter().all(|x| *x < 0.0);
        let r = e.ends.map(|p| around.distance(p));
        let local = e.ends.map(|p| around.local(p));
        let normal = e.normal();
        let across = [-around.axis[1], around.axis[0]];
        let mut source = Self { slope: [[0.0; ORDERS]; 2], value: [[0.0; ORDERS]; 2] };
        for k in 0..2 {
            let along = around.swapped != (k == 0);
            let lean = dot(normal, if along { around.axis } else { across }).abs();
            // The directions of a cell turn by no more than its skewness.
            let lean = lean + around.turn;
            // |s . v|/r at most.
            let sideways = [0, 1].map(|i| {
                let [u, v] = [0, 1].map(|k| local[i][k].abs() + around.half[k]);
                let off = if along { v } else { u };
                ((off + around.turn * (u + v)) / r[i]).min(1.0)
            });
            let logarithmic = if beside {
                0.0
            } else if line > 0.0 {
                lean / line
            } else {
                f64::INFINITY
            };
            let (inverse, of_ends) = (1.0 / delta, r.map(f64::recip));
            let (mut plain_power, mut end_powers, mut line_power) = (1.0, [1.0; 2], 1.0);
            for m in 1..ORDERS {
                plain_power *= inverse;
                line_power *= logarithmic;
                end_powers = [0, 1].map(|i| end_powers[i] * of_ends[i]);
                let plain = (e.length * inverse).min(2.0 * B[m]) * plain_power;
                let structured = B[m] * (end_powers[0] + end_powers[1]) + 2.0 / m as f64 * line_power;
                source.slope[k][m] = plain.min(structured);
            }
            end_powers = [1.0; 2];
            for m in 2..ORDERS {
                end_powers = [0, 1].map(|i| end_powers[i] * of_ends[i]);
                let ends = sideways[0] * end_powers[0] + sideways[1] * end_powers[1];
                source.value[k][m] = (lean.min(1.0) * source.slope[k][m - 1] + ends) / m as f64;
            }
        }
        source
    }

    pub const ZERO: Self = Self { slope: [[0.0; ORDERS]; 2], value: [[0.0; ORDERS]; 2] };

    /// Adds `strength` times another one.
    pub fn add(&mut self, strength: f64, other: &Self) {
        for k in 0..2 {
            for m in 0..ORDERS {
                self.slope[k][m] += strength * other.slope[k][m];
                self.value[k][m] += strength * other.value[k][m];
            }
        }
    }
}

/// What interpolation of a source at this many nodes leaves out over a rectangle of half lengths `half`, at most: of slope and value.
pub(crate) fn left_out(source: &Source, half: [f64; 2], [m, n]: [usize; 2]) -> [f64; 2] {
    let factors = [along(half[0], m), CHEBYSHEV_LEBESGUE * along(half[1], n)];
    let sup = |terms: &[[f64; ORDERS]; 2]| factors[0] * terms[0][m] + factors[1] * terms[1][n];
    [sup(&source.slope), sup(&source.value)]
}

/// What `m` nodes leave out along one direction, over |d^m|/m!.
fn along(half: f64, m: usize) -> f64 {
    chebyshev_size(m) * half.powi(m as i32)
}

/// The least numbers of nodes along both directions that leave out no more than `allowed` of the slope, the value over `decay` added; the
/// most where none do.
pub(crate) fn enough_nodes(source: &Source, half: [f64; 2], allowed: f64, decay: f64) -> [usize; 2] {
    least_nodes(allowed, |k, m| along(half[k], m) * (source.slope[k][m] + source.value[k][m] / decay))
}

/// The same of what is left out along direction k by m nodes.
fn least_nodes(allowed: f64, left: impl Fn(usize, usize) -> f64) -> [usize; 2] {
    [0, 1].map(|k| (BLOCK_NODES[0]..ORDERS).find(|&m| left(k, m) <= allowed).unwrap_or(BLOCK_NODES[1]))
}

/// Numbers of nodes that are enough for every one of some.
pub(crate) fn for_all(counts: impl Iterator<Item = [usize; 2]>) -> [usize; 2] {
    counts.fold([BLOCK_NODES[0]; 2], |[p, q], [m, n]| [p.max(m), q.max(n)])
}
