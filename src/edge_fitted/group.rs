//! Cells that lie together see what is far from all of them through one interpolation over a rectangle around them.

use super::compliance::Around;
use super::far::{BLOCK_NODES, Source, left_out};
use super::line_potential::{Field, Lines, Points, Scratch};
use super::mesh::{Bilinear, Mesh, Point, minus, norm};
use super::subcell::{NearEdge, near_edges};
use super::surroundings::{BLOCK_SHARE, FAR, block_field, chebyshev_points};

/// Pressures on a mesh, and what is known of them once.
pub(crate) struct Sources<'a, const K: usize> {
    pub mesh: &'a Mesh,
    pub lines: &'a Lines,
    pub pressures: [&'a [f64]; K],
    /// Of all edges.
    pub strengths: [&'a [f64]; K],
    pub arounds: Vec<Around>,
    /// The largest strength of the edges at every node.
    at_node: [Vec<f64>; K],
    /// Cells on which signs have to be shown.
    pub signs: Vec<bool>,
}

/// What may be left out where signs are shown, over what may be elsewhere.
const OF_SIGNS: f64 = 0.02;

impl<'a, const K: usize> Sources<'a, K> {
    pub fn new(mesh: &'a Mesh, lines: &'a Lines, pressures: [&'a [f64]; K], strengths: [&'a [f64]; K]) -> Self {
        let arounds = (0..mesh.loaded).map(|i| Around::new(&Bilinear::new(mesh.corners(i)))).collect();
        let at_node = strengths.map(|strengths| {
            let mut largest = vec![0.0; mesh.nodes.len()];
            for (edge, c) in mesh.edges.iter().zip(strengths) {
                for &n in &edge.ends {
                    largest[n] = f64::max(largest[n], c.abs());
                }
            }
            largest
        });
        Self { mesh, lines, pressures, strengths, arounds, at_node, signs: vec![false; mesh.cells.len()] }
    }

    /// |p|/pi of a loaded cell.
    pub fn strength(&self, cell: usize) -> [f64; K] {
        self.pressures.map(|p| p[cell].abs() * std::f64::consts::FRAC_1_PI)
    }

    /// What counts as small on a cell, over what counts as small elsewhere.
    pub fn share(&self, cell: usize) -> f64 {
        if self.signs[cell] { OF_SIGNS } else { 1.0 }
    }

    /// The size of the slope in a cell: the largest strength at its corners.
    pub fn scale(&self, cell: usize) -> [f64; K] {
        let nodes = self.mesh.cells[cell];
        let share = self.share(cell);
        std::array::from_fn(|k| {
            let scale = share * nodes.iter().map(|&n| self.at_node[k][n]).fold(0.0, f64::max);
            if scale > 0.0 { scale } else { share * self.scale_from_afar(k, cell) }
        })
    }

    /// No jump at the cell: what the others make there, each as a line as long as it is: area/(r (r^2 + a^2)^(1/2)).
    fn scale_from_afar(&self, k: usize, cell: usize) -> f64 {
        let own = Around::new(&Bilinear::new(self.mesh.corners(cell)));
        let others = self.arounds.iter().zip(self.pressures[k]).filter(|(_, p)| **p != 0.0);
        others
            .map(|(other, p)| {
                let area = 4.0 * other.half[0] * other.half[1];
                let r = norm(minus(other.centre, own.centre));
                p.abs() * area / (std::f64::consts::PI * r * r.hypot(other.half[0]))
            })
            .sum()
    }
}

/// Cells of a group at most.
const CELLS: usize = 16;
/// Cells, and what is far from all of them.
pub(crate) struct Group<const K: usize> {
    map: Bilinear,
    /// Loaded cells that are not far.
    pub close: Vec<usize>,
    /// Their edges, with the strengths of these cells only.
    pub edges: Vec<NearEdge<K>>,
    pub lines: Lines,
    /// Derivatives of all that is far, at most, and its strength.
    pub far: [(Source, f64); K],
    /// What the interpolation leaves out of its slope and displacement.
    pub left_out: [[f64; 2]; K],
    /// At the nodes.
    block: Option<Box<[Field; K]>>,
}

/// Cells by groups: halves of halves along the longer side of what their centres lie in.
pub(crate) fn groups(mesh: &Mesh, cells: Vec<usize>) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    let mut stack = vec![cells];
    while let Some(mut cells) = stack.pop() {
        if cells.len() <= CELLS {
            groups.push(cells);
            continue;
        }
        let centre = |cell: usize| Bilinear::new(mesh.corners(cell)).centre;
        let extent = |k: usize| {
            let range = cells.iter().map(|c| centre(*c)[k]);
            range.clone().fold(f64::NEG_INFINITY, f64::max) - range.fold(f64::INFINITY, f64::min)
        };
        let k = usize::from(extent(1) > extent(0));
        cells.sort_by(|a, b| centre(*a)[k].total_cmp(&centre(*b)[k]));
        let rest = cells.split_off(cells.len() / 2);
        stack.extend([cells, rest]);
    }
    groups
}

impl<const K: usize> Group<K> {
    /// Of at least one cell.
    pub fn new(sources: &Sources<K>, cells: &[usize], scratch: &mut Scratch) -> Self {
        let mesh = sources.mesh;
        let corners: Vec<Point> = cells.iter().flat_map(|c| mesh.corners(*c)).collect();
        let arounds: Vec<Around> = cells.iter().map(|c| Around::new(&Bilinear::new(mesh.corners(*c)))).collect();
        let longest = arounds.iter().fold(&arounds[0], |a, b| if b.half[0] > a.half[0] { b } else { a });
        let own = longest.over(&corners);
        let map = Bilinear::new(own.corners());
        let half = own.half;
        // The displacement counts over the thickness of the thinnest cell.
        let decay = arounds.iter().map(|a| 0.3 * a.half[0].min(a.half[1])).fold(f64::INFINITY, f64::min);
        let scales: Vec<[f64; K]> = cells.iter().map(|c| sources.scale(*c)).collect();
        let scale: [f64; K] = std::array::from_fn(|k| scales.iter().map(|s| s[k]).fold(f64::INFINITY, f64::min));
        let mut close = Vec::new();
        let mut far = [(Source::ZERO, 0.0); K];
        let box_corners = map.corners();
        for (j, other) in sources.arounds.iter().enumerate() {
            let strength = sources.strength(j);
            if strength.iter().all(|s| *s == 0.0) {
                continue;
            }
            let delta = own.distance_to_hull(&mesh.corners(j)).max(other.distance_to_hull(&box_corners));
            let is_far = delta > FAR * 2.0 * other.half[1] && {
                let source = Source::cell(other.half.map(|h| 2.0 * h), delta);
                let [slope, value] = left_out(&source, half);
                let error = slope + value / decay;
                let smooth = (0..K).all(|k| strength[k] * error <= BLOCK_SHARE * scale[k]);
                if smooth {
                    for ((sum, total), s) in far.iter_mut().zip(strength) {
                        sum.add(s, &source);
                        *total += s;
                    }
                }
                smooth
            };
            if !is_far {
                close.push(j);
            }
        }
        let mut is_close = vec![false; mesh.loaded];
        close.iter().for_each(|&j| is_close[j] = true);
        let edges = near_edges(mesh, sources.lines, 0..mesh.edges.len(), sources.pressures, &|j| is_close[j]);
        let lines = sources.lines.subset(edges.iter().map(|e| e.edge));
        let some = far.iter().any(|(_, total)| *total > 0.0);
        let block = some.then(|| {
            let mut rest: [Vec<f64>; K] = sources.strengths.map(<[f64]>::to_vec);
            for e in &edges {
                for k in 0..K {
                    e.take_off(k, &mut rest[k][e.edge]);
                }
            }
            let points = chebyshev_points(&map, [BLOCK_NODES[1]; 2]);
            Box::new(sources.lines.fields(std::array::from_fn(|k| rest[k].as_slice()), &points, scratch))
        });
        let left_out = far.map(|(sum, _)| left_out(&sum, half));
        Self { map, close, edges, lines, far, left_out, block }
    }

    /// Adds the field of what is far to that at some points of a cell.
    pub fn add_far(&self, points: &Points, fields: &mut [Field; K]) {
        let Some(block) = &self.block else { return };
        let local = |p: Point| {
            // A rectangle: both directions are at right angles.
            let v = [p[0] - self.map.centre[0], p[1] - self.map.centre[1]];
            self.map.along.map(|a| (v[0] * a[0] + v[1] * a[1]) / (a[0] * a[0] + a[1] * a[1]))
        };
        for i in 0..points.len {
            block_field(block, local([points.x[i], points.y[i]]), i, fields);
        }
    }
}
