//! Meshes of polygons cut into convex pieces: one quadrilateral block at each corner, graded to its two sides.
//!
//! The block at corner V has the corners O, M, V, M': O inside the polygon, M and M' on the sides that meet at V. The bilinear
//! map takes (1, 1) to V, so that both families of lines are graded to the sides at V with the exponent of `graded`. Two
//! blocks that share O - M share its nodes.

use std::collections::HashMap;

use super::bilinear::CORNERS;
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use super::rectilinear::split;

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
struct NodeIndex {
    nodes: Vec<Point>,
    places: HashMap<[i64; 2], usize>,
    tolerance: f64,
}

impl NodeIndex {
    fn get(&mut self, p: Point) -> usize {
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

/// The mesh of convex pieces that share whole sides, counter-clockwise, with `n` x `n` cells at each corner of each, and more where
/// they would be longer than about `most`.
pub(crate) fn mesh(pieces: &[Vec<Point>], n: usize, beta: f64, most: f64) -> Option<Mesh> {
    let extent = pieces.iter().flatten().map(|p| norm(*p)).fold(0.0, f64::max);
    let mut index = NodeIndex { nodes: Vec::new(), places: HashMap::new(), tolerance: 1e-12 * extent };
    let grade: Vec<f64> = (0..=n).map(|i| 1.0 - 2.0 * ((n - i) as f64 / n as f64).powf(beta)).collect();
    // No block is longer than the longest way from a corner to the centre of its piece.
    let longest = pieces.iter().filter_map(|piece| inner_circle(piece).map(|(o, _)| (o, piece)));
    let longest = longest.flat_map(|(o, piece)| piece.iter().map(move |p| norm(minus(*p, o)))).fold(0.0, f64::max);
    let grade = split(&grade, 2.0 * most / longest);
    let n = grade.len() - 1;
    let mut cells = Vec::new();
    for (own, piece) in pieces.iter().enumerate() {
        let count = piece.len();
        let (centre, _) = inner_circle(piece)?;
        let feet: Vec<Point> = (0..count)
            .map(|i| {
                let (a, b) = (piece[i], piece[(i + 1) % count]);
                let shared = pieces
                    .iter()
                    .enumerate()
                    .any(|(k, q)| k != own && (0..q.len()).any(|j| q[j] == b && q[(j + 1) % q.len()] == a));
                let v = minus(b, a);
                // The foot of the perpendicular, kept away from the corners; the middle where two pieces meet.
                let t = if shared { 0.5 } else { (dot(minus(centre, a), v) / dot(v, v)).clamp(0.15, 0.85) };
                [a[0] + t * v[0], a[1] + t * v[1]]
            })
            .collect();
        // The blocks are convex where the centre lies inside the polygon of the feet, as their mean does.
        let block = |o: Point, i: usize| Bilinear::new([o, feet[(i + count - 1) % count], piece[i], feet[i]]);
        let convex = |o: Point| {
            (0..count).all(|i| CORNERS.iter().all(|c| block(o, i).jacobian(c[0], c[1]) > 0.05 * block(o, i).area()))
        };
        let mean = [0, 1].map(|k| feet.iter().map(|f| f[k]).sum::<f64>() / count as f64);
        let centre = if convex(centre) { centre } else { mean };
        for i in 0..count {
            let before = (i + count - 1) % count;
            let map = Bilinear::new([centre, feet[before], piece[i], feet[i]]);
            if CORNERS.iter().any(|c| !(map.jacobian(c[0], c[1]) > 0.0)) {
                return None;
            }
            let place = |k: usize, j: usize| match (k, j) {
                _ if k == n && j == n => piece[i],
                // On the sides exactly.
                _ if k == n => between(feet[before], piece[i], grade[j]),
                _ if j == n => between(feet[i], piece[i], grade[k]),
                _ => map.at(grade[k], grade[j]),
            };
            for j in 0..n {
                for k in 0..n {
                    cells.push([(k, j), (k + 1, j), (k + 1, j + 1), (k, j + 1)].map(|(k, j)| index.get(place(k, j))));
                }
            }
        }
    }
    let bare = Mesh::new(index.nodes, cells.clone(), Vec::new());
    let (nodes, strip) = strip(&bare)?;
    Some(Mesh::new(nodes, cells, strip))
}

/// The point at `s` in [-1, 1] between a and b.
fn between(a: Point, b: Point, s: f64) -> Point {
    [0, 1].map(|k| 0.5 * ((1.0 - s) * a[k] + (1.0 + s) * b[k]))
}

/// The nodes of a mesh with those of a strip around it, and the cells of the strip: as thick as the cells at the edge, one
/// more cell at each outer corner, mitred at inner ones.
fn strip(mesh: &Mesh) -> Option<(Vec<Point>, Vec<[usize; 4]>)> {
    let mut nodes = mesh.nodes.clone();
    // The boundary edge that leaves each node with the material on the left, and the one that arrives.
    let (mut leaving, mut arriving) = (HashMap::new(), HashMap::new());
    let mut thickness = vec![f64::INFINITY; nodes.len()];
    for (e, edge) in mesh.edges.iter().enumerate() {
        let ([a, b], cell) = match edge.sides {
            [Some(c), None] => (edge.ends, c),
            [None, Some(c)] => ([edge.ends[1], edge.ends[0]], c),
            _ => continue,
        };
        if leaving.insert(a, (b, e)).is_some() || arriving.insert(b, a).is_some() {
            return None;
        }
        let map = Bilinear::new(mesh.corners(cell));
        let height = map.area() / norm(minus(nodes[b], nodes[a]));
        for n in [a, b] {
            thickness[n] = thickness[n].min(height);
        }
    }
    let mut outer: HashMap<usize, [usize; 2]> = HashMap::new();
    let mut cells = Vec::new();
    let mut order: Vec<usize> = leaving.keys().copied().collect();
    order.sort_unstable();
    for &n in &order {
        let unit = |v: Point| v.map(|c| c / norm(v));
        let into = unit(minus(nodes[n], nodes[*arriving.get(&n)?]));
        let out = unit(minus(nodes[leaving[&n].0], nodes[n]));
        // Outward normals, to the right of the boundary.
        let (p, q) = ([into[1], -into[0]], [out[1], -out[0]]);
        let at = |v: Point, factor: f64| [0, 1].map(|k| mesh.nodes[n][k] + factor * thickness[n] * v[k]);
        let mut push = |p: Point| {
            nodes.push(p);
            nodes.len() - 1
        };
        let turn = cross(into, out);
        let mitre = [0, 1].map(|k| (p[k] + q[k]) / (1.0 + dot(p, q)).max(0.5));
        if turn > 1e-6 {
            let (first, middle, last) = (push(at(p, 1.0)), push(at(mitre, 1.0)), push(at(q, 1.0)));
            cells.push([n, first, middle, last]);
            outer.insert(n, [first, last]);
        } else {
            let only = push(at(mitre, 1.0));
            outer.insert(n, [only, only]);
        }
    }
    for &a in &order {
        let b = leaving[&a].0;
        // Counter-clockwise: along the boundary on its outer side.
        cells.push([a, outer[&a][1], outer[&b][0], b]);
    }
    Some((nodes, cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_fitted::polygon::{cleaned, convex_pieces, double_area};

    fn check(pieces: &[Vec<Point>], area: f64, n: usize, length: f64) {
        let mesh = mesh(pieces, n, 4.0, f64::INFINITY).unwrap();
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
        for p in [vec![[0.0, 0.0], [2.0, 0.1], [0.4, 1.1]], star] {
            let length = (0..p.len()).map(|i| norm(minus(p[i], p[(i + 1) % p.len()]))).sum();
            let pieces: Vec<_> = convex_pieces(&p).unwrap().iter().map(|q| cleaned(q)).collect();
            check(&pieces, 0.5 * double_area(&p), 5, length);
        }
    }
}
