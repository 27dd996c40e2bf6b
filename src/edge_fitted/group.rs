//! Cells that lie together see what is far from all of them through one interpolation over a rectangle around them.

use super::block::{Block, points};
use super::compliance::Around;
use super::far::{BLOCK_NODES, Source, enough_nodes, for_all, left_out};
use super::line_potential::{Field, Lines, Points, Scratch};
use super::mesh::{Bilinear, Mesh, Point, minus, norm};
use super::subcell::{NearEdge, near_edges};
use super::surroundings::{BLOCK_SHARE, FAR};

/// Pressures on a mesh, and what is known of them once.
pub(crate) struct Sources<'a, const K: usize> {
    pub mesh: &'a Mesh,
    pub lines: &'a Lines,
    pub pressures: [&'a [f64]; K],
    /// Of all edges.
    pub strengths: [&'a [f64]; K],
    pub arounds: Vec<Around>,
    /// The size of the slope in every cell: the largest strength at its corners.
    scales: Vec<[f64; K]>,
    /// Cells on which signs have to be shown.
    pub signs: Vec<bool>,
}

/// Of the largest strength: less is the rounding of pressures that are odd about the cell.
const NO_JUMP: f64 = 1e-9;

/// The least and the largest of the factors.
const ALLOWED: [f64; 2] = [0.5, 4.0];

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
        let largest = at_node.each_ref().map(|of_nodes| of_nodes.iter().fold(0.0, |a: f64, b| a.max(*b)));
        let signs = vec![false; mesh.cells.len()];
        let mut sources = Self { mesh, lines, pressures, strengths, arounds, scales: Vec::new(), signs };
        let scale = |cell: usize, k: usize| {
            let scale = mesh.cells[cell].iter().map(|&n| at_node[k][n]).fold(0.0, f64::max);
            let jumps = scale > NO_JUMP * largest[k];
            if jumps { scale } else { scale.max(sources.scale_from_afar(k, cell)) }
        };
        sources.scales = (0..mesh.cells.len()).map(|cell| std::array::from_fn(|k| scale(cell, k))).collect();
        sources
    }

    /// |p|/pi of a loaded cell.
    pub fn strength(&self, cell: usize) -> [f64; K] {
        self.pressures.map(|p| p[cell].abs() * std::f64::consts::FRAC_1_PI)
    }

    /// What counts as small on a cell, over what counts as small elsewhere.
    pub fn share(&self, cell: usize) -> f64 {
        if self.signs[cell] { OF_SIGNS } else { 1.0 }
    }

    /// The size of the slope in a cell, times its share.
    pub fn scale(&self, cell: usize) -> [f64; K] {
        self.scales[cell].map(|scale| self.share(cell) * scale)
    }

    /// By what factor more may be left out on each cell than on one that leaves as much of the energy as the others do: what is left of a
    /// cell goes with the square of the slope, its area and l0 (`decay`), and cells that leave little need not be known as well.
    pub fn allowances(&self, decay: &[f64]) -> Vec<f64> {
        let cells = 0..self.mesh.cells.len();
        let left = |cell: usize| {
            let l0 = 0.25 * self.mesh.cells[cell].iter().map(|&n| decay[n]).sum::<f64>();
            let size = Bilinear::new(self.mesh.corners(cell)).area() * l0;
            self.scales[cell].map(|scale| scale.powi(2) * size)
        };
        let left: Vec<[f64; K]> = cells.map(left).collect();
        let mean: [f64; K] = std::array::from_fn(|k| left.iter().map(|l| l[k]).sum::<f64>() / left.len() as f64);
        let most = |left: [f64; K]| left.iter().zip(mean).map(|(l, mean)| l / mean).fold(0.0, f64::max);
        left.into_iter().map(|left| most(left).powf(-0.5).clamp(ALLOWED[0], ALLOWED[1])).collect()
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

/// Cells of groups of groups at most: what is far from those many is summed once for all of them.
const WIDE: usize = 128;

/// What all that is far may leave out of the interpolation over a group along one direction, where fewer nodes reach it, over the size of
/// the slope.
const TOTAL: f64 = 3e-3;

/// Cells, and what is far from all of them.
pub(crate) struct Group<'a, const K: usize> {
    /// The larger one that it is a part of.
    outer: Option<&'a Self>,
    /// Loaded cells that are not far.
    pub close: Vec<usize>,
    /// Their edges, with the strengths of these cells only.
    pub edges: Vec<NearEdge<K>>,
    pub lines: Lines,
    /// Derivatives of all that is far, at most, and its strength.
    pub far: [(Source, f64); K],
    /// What the interpolation leaves out of its slope and displacement.
    pub left_out: [[f64; 2]; K],
    /// What is far from this group, and not from the larger one, over a rectangle around it.
    block: Option<(Bilinear, Block<K>)>,
}

/// Cells by groups, and those by groups of groups.
pub(crate) fn groups(mesh: &Mesh, cells: Vec<usize>) -> Vec<Vec<Vec<usize>>> {
    parts(mesh, cells, WIDE).into_iter().map(|wide| parts(mesh, wide, CELLS)).collect()
}

/// Parts of at most so many cells: halves of halves along the longer side of what their centres lie in.
fn parts(mesh: &Mesh, cells: Vec<usize>, most: usize) -> Vec<Vec<usize>> {
    let mut parts = Vec::new();
    let mut stack = vec![cells];
    while let Some(mut cells) = stack.pop() {
        if cells.len() <= most {
            parts.push(cells);
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
    parts.retain(|cells| !cells.is_empty());
    parts
}

impl<'a, const K: usize> Group<'a, K> {
    /// All cells, to which everything is close.
    pub fn of_all(sources: &Sources<K>) -> Self {
        let Sources { mesh, lines, pressures, .. } = sources;
        let close = (0..mesh.loaded).filter(|&j| sources.strength(j).iter().any(|s| *s != 0.0)).collect();
        let edges = near_edges(mesh, lines, 0..mesh.edges.len(), *pressures, &|_| true);
        let lines = lines.subset(edges.iter().map(|e| e.edge));
        let (far, left_out) = ([(Source::ZERO, 0.0); K], [[0.0; 2]; K]);
        Self { outer: None, close, edges, lines, far, left_out, block: None }
    }

    /// Of at least one cell, a part of a larger group.
    pub fn within(outer: &'a Self, sources: &Sources<K>, cells: &[usize], scratch: &mut Scratch) -> Self {
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
        let most = [BLOCK_NODES[1]; 2];
        let (mut close, mut is_close) = (Vec::new(), vec![false; mesh.loaded]);
        let mut own_far = [(Source::ZERO, 0.0); K];
        let box_corners = map.corners();
        for &j in &outer.close {
            let other = &sources.arounds[j];
            let strength = sources.strength(j);
            let delta = own.distance_to_hull(&mesh.corners(j)).max(other.distance_to_hull(&box_corners));
            let is_far = delta > FAR * 2.0 * other.half[1] && {
                let source = Source::cell(other.half.map(|h| 2.0 * h), delta);
                let [slope, value] = left_out(&source, half, most);
                let error = slope + value / decay;
                let smooth = (0..K).all(|k| strength[k] * error <= BLOCK_SHARE * scale[k]);
                if smooth {
                    for ((sum, total), s) in own_far.iter_mut().zip(strength) {
                        sum.add(s, &source);
                        *total += s;
                    }
                }
                smooth
            };
            if !is_far {
                close.push(j);
                is_close[j] = true;
            }
        }
        let candidates = outer.edges.iter().map(|e| e.edge);
        let edges = near_edges(mesh, sources.lines, candidates, sources.pressures, &|j| is_close[j]);
        let lines = sources.lines.subset(edges.iter().map(|e| e.edge));
        let enough = |((sum, _), scale): (&(Source, f64), f64)| enough_nodes(sum, half, TOTAL * scale, decay);
        let count = for_all(own_far.iter().zip(scale).map(enough));
        let some = own_far.iter().any(|(_, total)| *total > 0.0);
        let block = some.then(|| {
            let rest = outer.without(&edges);
            let points = points(&map, count);
            let fields = outer.lines.fields(std::array::from_fn(|k| rest[k].as_slice()), &points, scratch);
            (map, Block::new(count, fields))
        });
        let (mut far, mut off) = (outer.far, outer.left_out);
        for k in 0..K {
            let (sum, total) = own_far[k];
            far[k].0.add(1.0, &sum);
            far[k].1 += total;
            let own = left_out(&sum, half, count);
            off[k] = [0, 1].map(|q| off[k][q] + own[q]);
        }
        Self { outer: Some(outer), close, edges, lines, far, left_out: off, block }
    }

    /// The strengths of its edges without those of some of them. Both lists follow the order of the mesh.
    pub fn without(&self, some: &[NearEdge<K>]) -> [Vec<f64>; K] {
        let mut rest: [Vec<f64>; K] = std::array::from_fn(|k| self.edges.iter().map(|e| e.strength[k]).collect());
        let mut left = some.iter().peekable();
        for (i, e) in self.edges.iter().enumerate() {
            if let Some(near) = left.next_if(|near| near.edge == e.edge) {
                (0..K).for_each(|k| near.take_off(k, &mut rest[k][i]));
            }
        }
        rest
    }

    /// Adds the field of what is far to that at some points of a cell.
    pub fn add_far(&self, points: &Points, fields: &mut [Field; K]) {
        if let Some((map, block)) = &self.block {
            let local = |p: Point| {
                // A rectangle: both directions are at right angles.
                let v = [p[0] - map.centre[0], p[1] - map.centre[1]];
                map.along.map(|a| (v[0] * a[0] + v[1] * a[1]) / (a[0] * a[0] + a[1] * a[1]))
            };
            for i in 0..points.len {
                block.add_at(local([points.x[i], points.y[i]]), i, fields);
            }
        }
        if let Some(outer) = self.outer {
            outer.add_far(points, fields);
        }
    }
}
