//! What the points of one cell see of all cells: near edges exactly, the rest by interpolation over the cell.

use super::compliance::Around;
use super::gauss::{lagrange, legendre};
use super::interpolation::{BLOCK_NODES, Far, Source};
use super::line_potential::{Field, Lines, Points, Scratch};
use super::mesh::{Bilinear, Mesh, minus, norm};
use super::subcell::{NearEdge, Subcell, near_edges};

/// What a cell sees of the others: near edges one by one, the field of all else by interpolation over the cell.
pub(crate) struct Surroundings<const K: usize> {
    pub near: Vec<NearEdge<K>>,
    pub lines: Lines,
    pub strengths: [Vec<f64>; K],
    pub far: [Far; K],
    /// Nodes of the block along both directions.
    count: [usize; 2],
    /// Displacement and slope of what is not near, at the nodes of the block: the index of t runs slower.
    block: Box<[Field; K]>,
    /// The size of the slope in the cell: the largest strength at its corners.
    pub scale: [f64; K],
}

/// A cell is far when its distance is more than this many times its thickness, and its field is smooth on the cell.
const FAR: f64 = 4.0;
/// What one source may leave out of the block's interpolation, over the size of the slope.
const BLOCK_SHARE: f64 = 1e-3;
/// What all together may leave out along one direction, where fewer nodes reach it.
const BLOCK_TOTAL: f64 = 0.01;

impl<const K: usize> Surroundings<K> {
    pub fn new(
        mesh: &Mesh,
        lines: &Lines,
        arounds: &[Around],
        cell: usize,
        (pressures, strengths): ([&[f64]; K], [&[f64]; K]),
        scratch: &mut Scratch,
    ) -> Self {
        let corners = mesh.corners(cell);
        let map = Bilinear::new(corners);
        let own = Around::new(&map);
        let half = Subcell { map, range: [[-1.0, 1.0]; 2], sides: [None; 4], nodes: [None; 4] }.half();
        let nodes = mesh.cells[cell];
        let mut scale = [0.0; K];
        for (i, e) in mesh.edges.iter().enumerate() {
            if e.ends.iter().any(|n| nodes.contains(n)) {
                for k in 0..K {
                    scale[k] = f64::max(scale[k], strengths[k][i].abs());
                }
            }
        }
        // No jump at the cell: the size of the slope from afar.
        for k in 0..K {
            if scale[k] > 0.0 {
                continue;
            }
            for (j, other) in arounds.iter().enumerate().filter(|(j, _)| pressures[k][*j] != 0.0) {
                let distance = norm(minus(other.centre, own.centre));
                let area = 4.0 * other.half[0] * other.half[1];
                scale[k] += pressures[k][j].abs() * area / (std::f64::consts::PI * distance * distance);
            }
        }
        let smooth = |strength: [f64; K], source: &Source| {
            let [slope, value] = source.block(half);
            let error = slope + value / (0.3 * half[0].min(half[1]));
            (0..K).all(|k| strength[k].abs() * error <= BLOCK_SHARE * scale[k])
        };
        let mut is_near = vec![false; mesh.loaded];
        let mut far = [Far::ZERO; K];
        for (j, other) in arounds.iter().enumerate() {
            let strength = pressures.map(|p| p[j].abs() * std::f64::consts::FRAC_1_PI);
            if strength.iter().all(|s| *s == 0.0) {
                continue;
            }
            let delta = own.distance_to_hull(&mesh.corners(j)).max(other.distance_to_hull(&corners));
            let source = Source::cell(other.half.map(|h| 2.0 * h), delta);
            if delta > FAR * 2.0 * other.half[1] && smooth(strength, &source) {
                for (far, s) in far.iter_mut().zip(strength) {
                    far.add(s, &source, half);
                }
            } else {
                is_near[j] = true;
            }
        }
        let mut near = near_edges(mesh, lines, pressures, &|j| is_near[j]);
        near.retain(|e| {
            let delta = own.distance_to_hull(&e.ends);
            let source = Source::edge(e, &own, &corners, delta);
            let strength = e.strength.map(f64::abs);
            let keep = !smooth(strength, &source);
            if !keep {
                for (far, s) in far.iter_mut().zip(strength) {
                    far.add(s, &source, half);
                }
            }
            keep
        });
        let subset = lines.subset(near.iter().map(|e| e.edge));
        let near_strengths = std::array::from_fn(|k| near.iter().map(|e| e.strength[k]).collect());
        let mut rest: [Vec<f64>; K] = strengths.map(<[f64]>::to_vec);
        for e in &near {
            for k in 0..K {
                rest[k][e.edge] -= e.strength[k];
                // Exactly zero where both sides are near.
                if rest[k][e.edge].abs() <= 4.0 * f64::EPSILON * e.strength[k].abs() {
                    rest[k][e.edge] = 0.0;
                }
            }
        }
        let decay = 0.3 * half[0].min(half[1]);
        let mut count = [BLOCK_NODES[0]; 2];
        for (far, scale) in far.iter().zip(scale) {
            let least = far.choose(BLOCK_TOTAL * scale, decay);
            count = [count[0].max(least[0]), count[1].max(least[1])];
        }
        for far in &mut far {
            far.set(count);
        }
        let mut points = Points::EMPTY;
        for t in chebyshev(count[1]) {
            for s in chebyshev(count[0]) {
                points.push(map.at(*s, *t));
            }
        }
        let block = lines.fields(std::array::from_fn(|k| rest[k].as_slice()), &points, scratch);
        Self { near, lines: subset, strengths: near_strengths, far, count, block: Box::new(block), scale }
    }
}

/// The `n` Chebyshev nodes.
fn chebyshev(n: usize) -> &'static [f64] {
    static NODES: std::sync::OnceLock<Vec<Vec<f64>>> = std::sync::OnceLock::new();
    let all = NODES.get_or_init(|| {
        (0..=BLOCK_NODES[1])
            .map(|n| (0..n).map(|i| -((2 * i + 1) as f64 * std::f64::consts::PI / (2 * n) as f64).cos()).collect())
            .collect()
    });
    &all[n]
}

/// Adds the interpolant of the block at the nodes of a subcell.
pub(crate) fn add_block<const K: usize>(
    subcell: &Subcell,
    [m, n]: [usize; 2],
    first: usize,
    surroundings: &Surroundings<K>,
    fields: &mut [Field; K],
) {
    let [p, q] = surroundings.count;
    let basis = |k: usize, count: usize| -> Vec<f64> {
        let [a, b] = subcell.range[k];
        let nodes = chebyshev(surroundings.count[k]);
        legendre(count).0.iter().flat_map(|x| lagrange(nodes, a + 0.5 * (1.0 + x) * (b - a))).collect()
    };
    let (bs, bt) = (basis(0, m), basis(1, n));
    for (field, block) in fields.iter_mut().zip(surroundings.block.iter()) {
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
