//! Meshes of polygons cut into convex pieces: one quadrilateral block at each corner, graded to its two sides where they are edges or meet
//! in a sharp corner.
//!
//! The block at corner V has the corners O, M, V, M': O inside the polygon, M and M' on the sides that meet at V. The bilinear
//! map takes (1, 1) to V, so that both families of lines are graded to the sides at V with the exponent of `graded`. Two
//! blocks that share O - M share its nodes.

use std::collections::HashMap;

use super::bilinear::CORNERS;
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use super::rectilinear::{Grading, graded, split};
use super::strip::strip;
use crate::numeric::geometry::centroid;

/// Centre and radius of the largest circle in a convex polygon, counter-clockwise: all sides move inwards alike, the side that
/// vanishes first is left out, until three are left. `None` where the polygon has no inside.
pub(crate) fn inner_circle(corners: &[Point]) -> Option<(Point, f64)> {
    let n = corners.len();
    let mut sides: Vec<(Point, f64)> = (0..n)
        .map(|i| {
            let v = minus(corners[(i + 1) % n], corners[i]);
            let normal = [-v[1] / norm(v), v[0] / norm(v)];
            (normal, dot(normal, corners[i]))
        })
        .collect();
    // m . p - r = c for three sides.
    let touching = |rows: [(Point, f64); 3]| {
        let (u, v) = (minus(rows[1].0, rows[0].0), minus(rows[2].0, rows[0].0));
        let det = cross(u, v);
        let (a, b) = (rows[1].1 - rows[0].1, rows[2].1 - rows[0].1);
        let p = [(a * v[1] - b * u[1]) / det, (u[0] * b - v[0] * a) / det];
        let r = dot(rows[0].0, p) - rows[0].1;
        (det.abs() > 1e-12 && r > 0.0).then_some((p, r))
    };
    loop {
        let count = sides.len();
        let around = |i: usize| touching([sides[(i + count - 1) % count], sides[i], sides[(i + 1) % count]]);
        let first = (0..count).filter_map(|i| around(i).map(|c| (i, c))).min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let (side, circle) = first?;
        if count == 3 {
            return Some(circle);
        }
        sides.remove(side);
    }
}

/// Nodes found again by their place.
pub(crate) struct NodeIndex {
    pub nodes: Vec<Point>,
    places: HashMap<[i64; 2], usize>,
    tolerance: f64,
}

impl NodeIndex {
    /// Of a mesh about as large as these points are far from the origin.
    fn new<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let extent = points.map(|p| norm(*p)).fold(0.0, f64::max);
        Self { nodes: Vec::new(), places: HashMap::new(), tolerance: 1e-12 * extent }
    }

    pub fn get(&mut self, p: Point) -> usize {
        let key = p.map(|c| (c / self.tolerance).round() as i64);
        for dx in -1..=1 {
            for dy in -1..=1 {
                if let Some(&n) = self.places.get(&[key[0] + dx, key[1] + dy]) {
                    return n;
                }
            }
        }
        self.nodes.push(p);
        self.places.insert(key, self.nodes.len() - 1);
        self.nodes.len() - 1
    }
}

/// A convex piece: its corners, the middle that its blocks meet in, a point on every side, and which sides it shares.
struct Piece {
    corners: Vec<Point>,
    middle: Point,
    feet: Vec<Point>,
    /// The piece and its side on the other side.
    across: Vec<Option<(usize, usize)>>,
}

impl Piece {
    fn new(all: &[Vec<Point>], own: usize) -> Option<Self> {
        let corners = all[own].clone();
        let count = corners.len();
        // In a slender triangle the largest circle lies at one end: from the centroid cells reach the sharpest corner in fewer steps.
        let centre = if count == 3 && all.len() == 1 { centroid(&corners) } else { inner_circle(&corners)?.0 };
        let shared = |a: Point, b: Point| {
            let others = all.iter().enumerate().filter(|(k, _)| *k != own);
            others
                .flat_map(|(k, q)| (0..q.len()).map(move |j| (k, j, q)))
                .find_map(|(k, j, q)| (q[j] == b && q[(j + 1) % q.len()] == a).then_some((k, j)))
        };
        let across: Vec<_> = (0..count).map(|i| shared(corners[i], corners[(i + 1) % count])).collect();
        let foot = |i: usize| {
            let (a, b) = (corners[i], corners[(i + 1) % count]);
            let v = minus(b, a);
            // The foot of the perpendicular, kept away from the corners; the middle where two pieces meet.
            let t = if across[i].is_some() { 0.5 } else { (dot(minus(centre, a), v) / dot(v, v)).clamp(0.15, 0.85) };
            [a[0] + t * v[0], a[1] + t * v[1]]
        };
        let feet: Vec<Point> = (0..count).map(foot).collect();
        let mut piece = Self { corners, middle: centre, feet, across };
        // The blocks are convex where the centre lies inside the polygon of the feet, as their mean does.
        let convex = |piece: &Self| {
            let room = |i: usize| {
                let block = piece.block(i);
                CORNERS.iter().all(|c| block.jacobian(c[0], c[1]) > 0.05 * block.area())
            };
            (0..count).all(room)
        };
        // The largest circle in a short part of a band touches the sides that it shares, and lies anywhere between the edges.
        if !convex(&piece) || piece.band().is_some() {
            piece.middle = [0, 1].map(|k| piece.feet.iter().map(|f| f[k]).sum::<f64>() / count as f64);
        }
        let positive = |i: usize| CORNERS.iter().all(|c| piece.block(i).jacobian(c[0], c[1]) > 0.0);
        (0..count).all(positive).then_some(piece)
    }

    fn before(&self, i: usize) -> usize {
        (i + self.corners.len() - 1) % self.corners.len()
    }

    fn after(&self, i: usize) -> usize {
        (i + 1) % self.corners.len()
    }

    /// Of side i.
    fn length(&self, i: usize) -> f64 {
        norm(minus(self.corners[self.after(i)], self.corners[i]))
    }

    /// Half the width between its edges.
    fn half_width(&self) -> f64 {
        let edges = (0..self.feet.len()).filter(|&i| self.across[i].is_none());
        edges.map(|i| norm(minus(self.feet[i], self.middle))).fold(0.0, f64::max)
    }

    /// The first of two opposite sides that it shares, where the other two are edges: a part of a band.
    fn band(&self) -> Option<usize> {
        let shared: Vec<bool> = self.across.iter().map(Option::is_some).collect();
        match shared.as_slice() {
            [true, false, true, false] => Some(0),
            [false, true, false, true] => Some(1),
            _ => None,
        }
    }

    /// The block at corner i.
    fn block(&self, i: usize) -> Bilinear {
        Bilinear::new([self.middle, self.feet[self.before(i)], self.corners[i], self.feet[i]])
    }
}

/// The nodes along the line from the middle of a piece to the foot on a side: the blocks on both sides of it have them, on the half sides
/// opposite to it too, and through these the pieces beyond.
struct Class {
    /// The longest line with these nodes.
    longest: f64,
    /// The least half width of the pieces.
    radius: f64,
    /// Towards an edge of the material, or a corner that it turns sharply at.
    graded: bool,
}

/// The classes of the lines to every foot of every piece, and the class of each.
fn classes(pieces: &[Piece], outline: &[Point]) -> (Vec<Class>, Vec<Vec<usize>>) {
    let mut parent: Vec<usize> = (0..pieces.iter().map(|p| p.corners.len()).sum()).collect();
    let first: Vec<usize> = pieces
        .iter()
        .scan(0, |sum, piece| {
            *sum += piece.corners.len();
            Some(*sum - piece.corners.len())
        })
        .collect();
    fn root(parent: &mut [usize], mut k: usize) -> usize {
        while parent[k] != k {
            parent[k] = parent[parent[k]];
            k = parent[k];
        }
        k
    }
    for (p, piece) in pieces.iter().enumerate() {
        for (e, other) in piece.across.iter().enumerate() {
            let Some((q, f)) = *other else { continue };
            for (own, theirs) in [(piece.before(e), pieces[q].after(f)), (piece.after(e), pieces[q].before(f))] {
                let (a, b) = (root(&mut parent, first[p] + own), root(&mut parent, first[q] + theirs));
                parent[a] = b;
            }
        }
    }
    let n = outline.len();
    let sharp = |p: Point| {
        outline.iter().position(|q| *q == p).is_none_or(|i| {
            let (u, v) = (minus(p, outline[(i + n - 1) % n]), minus(outline[(i + 1) % n], p));
            cross(u, v).atan2(dot(u, v)).abs() > SHARP
        })
    };
    let class: Vec<Vec<usize>> = pieces
        .iter()
        .enumerate()
        .map(|(p, piece)| (0..piece.corners.len()).map(|i| root(&mut parent, first[p] + i)).collect())
        .collect();
    let mut all: Vec<Class> =
        parent.iter().map(|_| Class { longest: 0.0, radius: f64::INFINITY, graded: false }).collect();
    for (piece, class) in pieces.iter().zip(&class) {
        for (i, foot) in piece.feet.iter().enumerate() {
            let (start, end) = (piece.corners[i], piece.corners[piece.after(i)]);
            let own = &mut all[class[i]];
            let opposite = [(piece.feet[piece.before(i)], start), (piece.feet[piece.after(i)], end)];
            for (a, b) in opposite.into_iter().chain([(piece.middle, *foot)]) {
                own.longest = own.longest.max(norm(minus(a, b)));
            }
            if piece.half_width() > 0.0 {
                own.radius = own.radius.min(piece.half_width());
            }
            own.graded |= piece.across[i].is_none() || sharp(start) || sharp(end);
        }
    }
    (all, class)
}

/// Turn of the outline at a corner, radians, below which it is taken for a part of a curve that needs no grading towards it.
const SHARP: f64 = 0.4;

/// Cells along a curve are at most this times the half width of what it bounds, over n.
const ALONG: f64 = 16.0;

/// The mesh of convex pieces of an outline that share whole sides, all counter-clockwise, with `n` x `n` cells at each corner of each, fewer
/// along curves and more where they would be longer than about `most`.
pub(super) fn mesh(outline: &[Point], pieces: &[Vec<Point>], n: usize, most: f64, grading: Grading) -> Option<Mesh> {
    // Where pieces meet in re-entrant corners it takes as many along short lines.
    let alike = pieces.len() > 1;
    let graded = |share: f64| graded(-1.0, 1.0, if alike { n } else { (grading.count)(n, share) }, grading.beta);
    let mut index = NodeIndex::new(pieces.iter().flatten());
    let mut cells = Vec::new();
    let pieces: Vec<Piece> = (0..pieces.len()).map(|own| Piece::new(pieces, own)).collect::<Option<_>>()?;
    fill(outline, &pieces, &graded, n, most, &mut index, &mut cells);
    let bare = Mesh::new(index.nodes, cells.clone(), Vec::new());
    let (nodes, strip) = strip(&bare)?;
    Some(Mesh::new(nodes, cells, strip))
}

/// A convex polygon in cells, and the nodes on each of its sides from corner to corner.
pub(crate) struct Convex {
    pub index: NodeIndex,
    pub cells: Vec<[usize; 4]>,
    pub sides: Vec<Vec<usize>>,
    /// The places of these nodes.
    pub nodes: Vec<Point>,
}

/// The cells of a convex polygon, counter-clockwise: `graded` from the middle to its sides, -1 to 1, and none longer than about `most`.
pub(crate) fn convex(corners: &[Point], graded: &[f64], most: f64) -> Option<Convex> {
    let mut index = NodeIndex::new(corners.iter());
    let mut cells = Vec::new();
    let pieces = [Piece::new(&[corners.to_vec()], 0)?];
    let n = graded.len() - 1;
    let lines = fill(corners, &pieces, &|_| graded.to_vec(), n, most, &mut index, &mut cells);
    let piece = &pieces[0];
    let sides = (0..corners.len())
        .map(|k| {
            let after = piece.after(k);
            let half = |grades: &[f64], corner: Point, index: &mut NodeIndex| -> Vec<usize> {
                grades.iter().map(|s| index.get(between(piece.feet[k], corner, *s))).collect()
            };
            let mut side = half(&lines[0][piece.before(k)], corners[k], &mut index);
            side.reverse();
            side.extend(half(&lines[0][after], corners[after], &mut index).into_iter().skip(1));
            side
        })
        .collect();
    Some(Convex { nodes: index.nodes.clone(), index, cells, sides })
}

/// Adds the cells of pieces of an outline, `graded` along a line to an edge by its share of the longest one, and returns the nodes along the line from the middle of every piece to each of its feet.
fn fill(
    outline: &[Point],
    pieces: &[Piece],
    graded: &dyn Fn(f64) -> Vec<f64>,
    n: usize,
    most: f64,
    index: &mut NodeIndex,
    cells: &mut Vec<[usize; 4]>,
) -> Vec<Vec<Vec<f64>>> {
    let (all, class) = classes(pieces, outline);
    let whole = all.iter().filter(|class| class.graded).map(|class| class.longest).fold(0.0, f64::max);
    let grades: Vec<Vec<f64>> = all
        .iter()
        .map(|class| {
            let longest = 2.0 * most / class.longest;
            if class.graded {
                split(&graded(class.longest / whole), longest)
            } else {
                split(&[-1.0, 1.0], longest.min(2.0 * ALONG * class.radius / (n as f64 * class.longest)))
            }
        })
        .collect();
    for (piece, class) in pieces.iter().zip(&class) {
        if let Some(e) = piece.band()
            && [e, e + 2].iter().all(|&i| !all[class[i]].graded && grades[class[i]].len() == 2)
            && [e + 1, e + 3].iter().all(|&i| piece.length(i % 4) <= most)
        {
            band(piece, e, [&grades[class[(e + 3) % 4]], &grades[class[e + 1]]], index, cells);
            continue;
        }
        for i in 0..piece.corners.len() {
            let before = piece.before(i);
            let map = piece.block(i);
            let (along, up) = (&grades[class[before]], &grades[class[i]]);
            let place = |k: usize, j: usize| match (k + 1 == along.len(), j + 1 == up.len()) {
                (true, true) => piece.corners[i],
                // On the sides exactly.
                (true, false) => between(piece.feet[before], piece.corners[i], up[j]),
                (false, true) => between(piece.feet[i], piece.corners[i], along[k]),
                (false, false) => map.at(along[k], up[j]),
            };
            for j in 0..up.len() - 1 {
                for k in 0..along.len() - 1 {
                    cells.push([(k, j), (k + 1, j), (k + 1, j + 1), (k, j + 1)].map(|(k, j)| index.get(place(k, j))));
                }
            }
        }
    }
    class.iter().map(|class| class.iter().map(|&c| grades[c].clone()).collect()).collect()
}

/// A part of a band that is one cell long: the nodes on its shared sides `e` and `e` + 2 alone, by the grades towards the edge before the
/// first of them and towards that after it.
fn band(piece: &Piece, e: usize, [low, high]: [&[f64]; 2], index: &mut NodeIndex, cells: &mut Vec<[usize; 4]>) {
    let corner = |k: usize| piece.corners[(e + k) % 4];
    let mut line = |a: Point, foot: Point, b: Point| -> Vec<usize> {
        let lower = low.iter().rev().map(|s| between(foot, a, *s));
        let upper = high.iter().skip(1).map(|s| between(foot, b, *s));
        lower.chain(upper).map(|p| index.get(p)).collect()
    };
    // From the edge before side e to that after it.
    let (first, second) = (line(corner(0), piece.feet[e], corner(1)), line(corner(3), piece.feet[e + 2], corner(2)));
    for k in 0..first.len() - 1 {
        cells.push([first[k], first[k + 1], second[k + 1], second[k]]);
    }
}

/// The point at `s` in [-1, 1] between a and b.
fn between(a: Point, b: Point, s: f64) -> Point {
    [0, 1].map(|k| 0.5 * ((1.0 - s) * a[k] + (1.0 + s) * b[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_fitted::polygon::{cleaned, convex_cuts};
    use crate::numeric::geometry::area;

    fn check(outline: &[Point], pieces: &[Vec<Point>], area: f64, n: usize, length: f64) {
        let mesh = mesh(outline, pieces, n, f64::INFINITY, Grading { beta: 4.0, count: |n, _| n }).unwrap();
        let sum: f64 = (0..mesh.loaded).map(|i| Bilinear::new(mesh.corners(i)).area()).sum();
        assert!((sum - area).abs() < 1e-12 * area);
        // Only the outline has cells on one side only.
        let outer: f64 = mesh
            .edges
            .iter()
            .filter(|e| e.sides.contains(&None))
            .map(|e| norm(minus(mesh.nodes[e.ends[0]], mesh.nodes[e.ends[1]])))
            .sum();
        assert!((outer - length).abs() < 1e-11 * length, "{outer} {length}");
        for i in 0..mesh.cells.len() {
            let map = Bilinear::new(mesh.corners(i));
            assert!(CORNERS.iter().all(|c| map.jacobian(c[0], c[1]) > 0.0), "{i} {:?}", mesh.corners(i));
        }
    }

    #[test]
    fn areas_and_outlines() {
        let star: Vec<Point> = (0..10)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / 10.0).sin_cos();
                let r = if k % 2 == 0 { 1.0 } else { 0.382 };
                [r * c, r * s]
            })
            .collect();
        let turn = |k: usize, r: f64| {
            let (s, c) = (0.09 * k as f64).sin_cos();
            [r * c, r * s]
        };
        let bow: Vec<Point> = (0..30).map(|k| turn(k, 1.0)).chain((0..30).rev().map(|k| turn(k, 0.8))).collect();
        for p in [vec![[0.0, 0.0], [2.0, 0.1], [0.4, 1.1]], star, bow] {
            let length = (0..p.len()).map(|i| norm(minus(p[i], p[(i + 1) % p.len()]))).sum();
            let pieces: Vec<_> = convex_cuts(&p)[0].iter().map(|q| cleaned(q)).collect();
            check(&p, &pieces, area(&p), 5, length);
        }
    }
}
