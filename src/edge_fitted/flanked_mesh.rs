//! The mesh of a flat with flanks: cells of the flat, rows of cells up its flanks to where the contact ends, and around them, to where the
//! bodies overlap no more, cells without pressure on which only signs are asked for.

use super::flanked::Flat;
use super::flanked_ends::Ends;
use super::kites::convex;
use super::mesh::{Bilinear, Mesh, Point, minus, norm};
use super::rectilinear::split;

/// Lines of the mesh.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    /// From the middle of the flat to its sides, -1 to 1.
    pub inside: Vec<f64>,
    /// From the sides to the end of the contact, 0 to 1.
    pub rows: Vec<f64>,
    /// From there to a level line, 0 to 1; the first of these rows may be in contact where there is more than one.
    pub around: Vec<f64>,
    /// Heights from that line on, up to 1.
    pub beyond: Vec<f64>,
}

/// A mesh with the overlap on it.
pub(super) struct Flanked {
    pub mesh: Mesh,
    /// By cell: the overlap as value + slope . x, and what that leaves out of the slope and of the value.
    pub planes: Vec<([f64; 3], [f64; 2])>,
    /// Heights of the nodes.
    pub heights: Vec<f64>,
    pub flanks: Vec<Flank>,
}

/// One flank.
pub(super) struct Flank {
    /// Shares of its side, and where contact is supposed to end there, as heights.
    pub shares: Vec<f64>,
    pub ends: Vec<f64>,
    /// The nodes of each line along it, from the side outwards, and the cells between two of them.
    pub lines: Vec<Vec<usize>>,
    pub cells: Vec<Vec<usize>>,
}

/// Parts of each half of a side where only signs are asked for.
const PARTS: f64 = 2.0;

impl Flanked {
    pub fn new(flat: &Flat, lines: &Lines, ends: &Ends) -> Option<Self> {
        let count = flat.corners.len();
        let inner = convex(flat.corners, &lines.inside, f64::INFINITY)?;
        let (mut index, mut cells) = (inner.index, inner.cells);
        let flat_cells = cells.len();
        let mut heights = vec![0.0; index.nodes.len()];
        let mut node = |k: usize, share: f64, height: f64| {
            let place = moved(flat, k, share, height);
            let node = index.get(place);
            if node == heights.len() {
                heights.push(height);
            }
            node
        };
        let level = lines.beyond[0];
        let within = lines.rows.len() - 1;
        // With one row more: the end is known to a cell.
        let loaded_rows = within + usize::from(lines.around.len() > 2);
        let mut free: Vec<([usize; 4], Option<usize>)> = Vec::new();
        let (mut owners, mut flanks) = (vec![None; flat_cells], Vec::new());
        for k in 0..count {
            let shares = shares(flat, k, &inner.sides[k], &inner.nodes);
            let own: Vec<f64> = shares.iter().map(|share| ends.at(k, *share).min(level)).collect();
            let height = |line: usize, end: f64| match lines.rows.get(line) {
                Some(part) => part * end,
                None => end + lines.around[line - within] * (level - end),
            };
            let mut all = vec![inner.sides[k].clone()];
            let mut rows = Vec::new();
            for row in 0..within + lines.around.len() - 1 {
                let next: Vec<usize> =
                    shares.iter().zip(&own).map(|(share, end)| node(k, *share, height(row + 1, *end))).collect();
                let below = &all[row];
                let row_cells = (0..next.len() - 1).map(|j| [below[j], next[j], next[j + 1], below[j + 1]]);
                if row < loaded_rows {
                    rows.push((cells.len()..cells.len() + next.len() - 1).collect());
                    cells.extend(row_cells);
                } else {
                    free.extend(row_cells.map(|cell| (cell, Some(k))));
                }
                owners.resize(cells.len(), Some(k));
                all.push(next);
            }
            flanks.push(Flank { shares, ends: own, lines: all, cells: rows });
        }
        let shares = split(&[0.0, 0.5, 1.0], 0.5 / PARTS);
        for k in 0..count {
            for pair in lines.beyond.windows(2) {
                for part in shares.windows(2) {
                    let corners = [(part[0], pair[0]), (part[0], pair[1]), (part[1], pair[1]), (part[1], pair[0])];
                    free.push((corners.map(|(share, height)| node(k, share, height)), Some(k)));
                }
            }
        }
        let (free, free_owners): (Vec<_>, Vec<_>) = free.into_iter().unzip();
        owners.extend(free_owners);
        let mesh = Mesh::new(index.nodes, cells, free);
        let planes = (0..mesh.cells.len())
            .map(|cell| {
                let plane = owners[cell].map_or([1.0, 0.0, 0.0], |k: usize| {
                    let [a, b, c] = flat.sides[k];
                    [1.0 - c, -a, -b]
                });
                let off = mesh.cells[cell].iter().map(|&n| off(mesh.nodes[n], heights[n], plane)).fold(0.0, f64::max);
                let map = Bilinear::new(mesh.corners(cell));
                let [u, v] = map.along.map(norm);
                // Bilinear functions within `off` at the corners.
                let thickness = 0.25 * map.area() / u.max(v);
                (plane, [4.0 * off / thickness, off])
            })
            .collect();
        Some(Self { mesh, planes, heights, flanks })
    }

    /// By how much the gap of all planes may differ from that of the mesh where it counts: nowhere lower, and no higher either at the nodes
    /// of the cells that are `near`.
    pub fn off_from(&self, planes: &[[f64; 3]], near: &[bool]) -> f64 {
        let mut both = vec![false; self.heights.len()];
        for (cell, _) in self.mesh.cells.iter().zip(near).filter(|(_, on)| **on) {
            cell.iter().for_each(|&n| both[n] = true);
        }
        let own = self.planes.iter().map(|(_, rests)| rests[1]).fold(0.0, f64::max);
        let at = |n: usize| {
            let ([x, y], height) = (self.mesh.nodes[n], self.heights[n]);
            let gap = planes.iter().map(|[a, b, c]| a * x + b * y + c).fold(0.0, f64::max);
            if both[n] { (gap - height).abs() } else { (height - gap).max(0.0) }
        };
        own + (0..self.heights.len()).map(at).fold(0.0, f64::max)
    }
}

/// The point at a share of side k, moved up its flank: from the nearer end, so that mirrored sides have mirrored points.
fn moved(flat: &Flat, k: usize, share: f64, height: f64) -> Point {
    let next = (k + 1) % flat.corners.len();
    let end = |k: usize| [0, 1].map(|m| flat.corners[k][m] + height * flat.drift[k][m]);
    let (a, b) = (end(k), end(next));
    [0, 1].map(|m| if share <= 0.5 { a[m] + share * (b[m] - a[m]) } else { b[m] + (1.0 - share) * (a[m] - b[m]) })
}

/// Shares of side k at which its nodes lie.
fn shares(flat: &Flat, k: usize, side: &[usize], nodes: &[Point]) -> Vec<f64> {
    let (a, b) = (flat.corners[k], flat.corners[(k + 1) % flat.corners.len()]);
    let length = norm(minus(b, a));
    let share = |&n: &usize| {
        let (from, to) = (norm(minus(nodes[n], a)), norm(minus(b, nodes[n])));
        if from <= to { from / length } else { 1.0 - to / length }
    };
    side.iter().map(share).collect()
}

/// By how much a plane differs from the overlap at a point of this height, rounding included.
fn off([x, y]: Point, height: f64, [c, a, b]: [f64; 3]) -> f64 {
    let size = c.abs() + 1.0 + (a * x).abs() + (b * y).abs();
    (c + a * x + b * y - (1.0 - height)).abs() + 8.0 * f64::EPSILON * size
}
