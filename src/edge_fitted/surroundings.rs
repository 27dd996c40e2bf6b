//! What the points of one cell see of all cells: near edges exactly, the rest by interpolation over the cell.

use super::block::{Block, points};
use super::compliance::Around;
use super::edge_lanes::EdgeLanes;
use super::far::{BLOCK_NODES, Far, Source, for_all, left_out};
use super::group::{Group, Sources};
use super::line_potential::{Lines, Scratch};
use super::mesh::Bilinear;
use super::subcell::{NearEdge, Subcell, near_edges};

/// What a cell sees of the others: near edges one by one, the field of all else by interpolation over the cell.
pub(crate) struct Surroundings<const K: usize> {
    pub near: Vec<NearEdge<K>>,
    /// The same side by side.
    pub lanes: EdgeLanes<K>,
    pub lines: Lines,
    pub strengths: [Vec<f64>; K],
    pub far: [Far; K],
    /// What is not near.
    pub block: Block<K>,
    /// The size of the slope in the cell: the largest strength at its corners.
    pub scale: [f64; K],
}

/// A cell is far when its distance is more than this many times its thickness, and its field is smooth on the cell.
pub(crate) const FAR: f64 = 4.0;
/// What one source may leave out of the interpolation over a cell, or over a group of cells, over the size of the slope.
pub(crate) const BLOCK_SHARE: f64 = 3e-3;
/// What all together may leave out along one direction, where fewer nodes reach it.
const BLOCK_TOTAL: f64 = 0.01;

impl<const K: usize> Surroundings<K> {
    /// Of a cell in a group.
    pub fn new(sources: &Sources<K>, group: &Group<K>, cell: usize, scratch: &mut Scratch) -> Self {
        let Sources { mesh, lines, pressures, .. } = sources;
        let corners = mesh.corners(cell);
        let map = Bilinear::new(corners);
        let own = Around::new(&map);
        let half = Subcell { map, range: [[-1.0, 1.0]; 2], sides: [None; 4], nodes: [None; 4] }.half();
        let decay = 0.3 * half[0].min(half[1]);
        let scale = sources.scale(cell);
        let smooth = |strength: [f64; K], source: &Source| {
            let [slope, value] = left_out(source, half, [BLOCK_NODES[1]; 2]);
            let error = slope + value / decay;
            (0..K).all(|k| strength[k].abs() * error <= BLOCK_SHARE * scale[k])
        };
        let mut far = group.far.map(|(sum, strength)| {
            let mut far = Far::ZERO;
            far.add_derivatives(1.0, &sum, half);
            far.strength += strength;
            far
        });
        let mut is_near = vec![false; mesh.loaded];
        for &j in &group.close {
            let other = &sources.arounds[j];
            let strength = sources.strength(j);
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
        let edges = group.edges.iter().map(|e| e.edge);
        let mut near = near_edges(mesh, lines, edges, *pressures, &|j| is_near[j]);
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
        let rest = group.without(&near);
        let count = for_all(far.iter().zip(scale).map(|(far, scale)| far.choose(BLOCK_TOTAL * scale, decay)));
        for (far, nodal) in far.iter_mut().zip(group.left_out) {
            far.set(count, nodal);
        }
        let points = points(&map, count);
        let mut block = group.lines.fields(std::array::from_fn(|k| rest[k].as_slice()), &points, scratch);
        group.add_far(&points, &mut block);
        let lanes = EdgeLanes::of(&near);
        Self {
            near,
            lanes,
            lines: subset,
            strengths: near_strengths,
            far,
            block: Block::new(count, block),
            scale: scale.map(|s| s / sources.share(cell)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::gauss::legendre;
    use super::super::group::groups;
    use super::super::line_potential::{BATCH, Points};
    use super::super::outline::Outline;
    use super::*;

    /// What is near and the block give the whole field within what the block is said to leave out, also where a part of it has
    /// come through the rectangle of a group.
    #[test]
    fn block_is_within_its_bound() {
        let outline =
            Outline::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.1, 0.9], [1.0, 1.0], [0.9, 2.0], [0.0, 1.8]]).unwrap();
        let mesh = outline.mesh(8).unwrap().mesh;
        let lines = Lines::new(&mesh);
        let pressure: Vec<f64> = (0..mesh.loaded).map(|i| 1.0 + 0.5 * (i as f64 * 1.7).sin()).collect();
        let strengths = Lines::strengths(&mesh, &pressure);
        let sources = Sources::new(&mesh, &lines, [&pressure], [&strengths]);
        let mut scratch = Scratch::default();
        let (mut through_groups, mut largest) = (0, 0.0_f64);
        let all = Group::of_all(&sources);
        for wide in groups(&mesh, (0..mesh.cells.len()).collect()) {
            let outer = Group::within(&all, &sources, &wide.concat(), &mut scratch);
            for cells in wide {
                let group = Group::within(&outer, &sources, &cells, &mut scratch);
                through_groups += mesh.loaded - group.close.len();
                for &cell in &cells {
                    let seen = Surroundings::new(&sources, &group, cell, &mut scratch);
                    let map = Bilinear::new(mesh.corners(cell));
                    let whole = Subcell { map, range: [[-1.0, 1.0]; 2], sides: [None; 4], nodes: [None; 4] };
                    let mut points = Points::EMPTY;
                    for t in &legendre(5).0 {
                        for s in &legendre(5).0 {
                            points.push(map.at(*s, *t));
                        }
                    }
                    let mut fields = seen.lines.fields([&seen.strengths[0]], &points, &mut scratch);
                    seen.block.add_on(&whole, [5, 5], 0, &mut fields);
                    let [exact] = lines.fields([&strengths], &points, &mut scratch);
                    let [field] = fields;
                    let [slope, value] = seen.far[0].block;
                    for i in 0..points.len.min(BATCH) {
                        let off = [0, 1].map(|k| field.slope[k][i] - exact.slope[k][i]);
                        let off = off[0].hypot(off[1]);
                        assert!(off <= slope + 1e-12, "cell {cell}: slope off by {off:e}, said {slope:e}");
                        let low = (field.u[i] - exact.u[i]).abs();
                        assert!(low <= value + 1e-12, "cell {cell}: displacement off by {low:e}, said {value:e}");
                        largest = largest.max(off / slope);
                    }
                }
            }
        }
        assert!(through_groups > mesh.loaded, "nothing is far");
        assert!(largest > 1e-4, "the bound says nothing: {largest:e}");
    }
}
