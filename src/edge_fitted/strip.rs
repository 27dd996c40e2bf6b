//! The strip of cells around a mesh over which w is continued and faded: thinner than the cells at the outline, and more so where
//! the outline faces itself.
//!
//! Where strips overlap nothing, w fades alone; where they do, the bound holds all the same as long as no cell is turned
//! over: the largest of the Phi of `residual_norm` at a point, all of one sign, is an extension of w too, and its Dirichlet
//! integral is at most their sum.

use std::collections::HashMap;

use super::bilinear::CORNERS;
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};

/// Thickness over that of the cells at the outline: w grows beyond it, and fades the more steeply the thinner the strip; about the best for
/// flat polygons.
pub(super) const STRIP: f64 = 0.6;
/// Of its distance from what it faces, a node of the outline leaves this to its strip,
const OWN: f64 = 0.4;
/// and each end of an edge at most this to that of the edge, over the weight of the end at the place nearest to the node.
const ENDS: f64 = 0.25;
/// Sides at less than this angle do not face each other.
const STRAIGHT: f64 = 1e-6;

/// The nodes of a mesh with those of the strip, and its cells: one more at each outer corner, mitred at inner ones. `None` where
/// the outline touches itself or is too sharp for them.
pub(crate) fn strip(mesh: &Mesh) -> Option<(Vec<Point>, Vec<[usize; 4]>)> {
    let outline = Outline::new(mesh)?;
    let thickness = outline.thickness(mesh);
    let mut nodes = mesh.nodes.clone();
    let mut outer: HashMap<usize, [usize; 2]> = HashMap::new();
    let mut cells = Vec::new();
    for side in &outline.sides {
        let n = side.start;
        let Side { normal: q, direction: out, .. } = *side;
        let Side { normal: p, direction: into, .. } = outline.sides[side.before];
        let at = |v: Point, factor: f64| [0, 1].map(|k| mesh.nodes[n][k] + factor * thickness[n] * v[k]);
        let mut push = |p: Point| {
            nodes.push(p);
            nodes.len() - 1
        };
        let mitre = [0, 1].map(|k| (p[k] + q[k]) / (1.0 + dot(p, q)).max(0.5));
        if cross(into, out) > 1e-6 {
            let (first, middle, last) = (push(at(p, 1.0)), push(at(mitre, 1.0)), push(at(q, 1.0)));
            cells.push([n, first, middle, last]);
            outer.insert(n, [first, last]);
        } else {
            let only = push(at(mitre, 1.0));
            outer.insert(n, [only, only]);
        }
    }
    // Counter-clockwise: along the outline on its outer side.
    cells.extend(outline.sides.iter().map(|s| [s.start, outer[&s.start][1], outer[&s.end][0], s.end]));
    let upright = |cell: &[usize; 4]| {
        let map = Bilinear::new(cell.map(|n| nodes[n]));
        CORNERS.iter().all(|c| map.jacobian(c[0], c[1]) > 0.0)
    };
    cells.iter().all(upright).then_some((nodes, cells))
}

/// An edge with material on its left alone.
struct Side {
    start: usize,
    end: usize,
    direction: Point,
    /// Outwards.
    normal: Point,
    length: f64,
    cell: usize,
    /// The side that ends where this one starts.
    before: usize,
}

/// The sides of a mesh, by the nodes that they start at.
struct Outline {
    sides: Vec<Side>,
}

impl Outline {
    /// `None` where a node starts two sides.
    fn new(mesh: &Mesh) -> Option<Self> {
        let mut sides = Vec::new();
        for edge in &mesh.edges {
            let ([start, end], cell) = match edge.sides {
                [Some(c), None] => (edge.ends, c),
                [None, Some(c)] => ([edge.ends[1], edge.ends[0]], c),
                _ => continue,
            };
            let v = minus(mesh.nodes[end], mesh.nodes[start]);
            let length = norm(v);
            let direction = v.map(|c| c / length);
            // To the right.
            let normal = [direction[1], -direction[0]];
            sides.push(Side { start, end, direction, normal, length, cell, before: usize::MAX });
        }
        sides.sort_unstable_by_key(|side| side.start);
        if sides.windows(2).any(|pair| pair[0].start == pair[1].start) {
            return None;
        }
        for k in 0..sides.len() {
            let next = sides.binary_search_by_key(&sides[k].end, |side| side.start).ok()?;
            sides[next].before = k;
        }
        sides.iter().all(|side| side.before != usize::MAX).then_some(Self { sides })
    }

    /// Of the strip at every node of the outline.
    fn thickness(&self, mesh: &Mesh) -> Vec<f64> {
        let mut thickness = vec![f64::INFINITY; mesh.nodes.len()];
        for side in &self.sides {
            let height = STRIP * Bilinear::new(mesh.corners(side.cell)).area() / side.length;
            for n in [side.start, side.end] {
                thickness[n] = thickness[n].min(height);
            }
        }
        for side in &self.sides {
            let n = side.start;
            let at = mesh.nodes[n];
            let around = [self.sides[side.before].normal, side.normal];
            let inner = cross(self.sides[side.before].direction, side.direction) < 0.0;
            for other in &self.sides {
                let from = minus(at, mesh.nodes[other.start]);
                if dot(from, other.normal) <= STRAIGHT * norm(from) || other.start == n || other.end == n {
                    continue;
                }
                let Some(t) = faced(at, around, inner, mesh.nodes[other.start], mesh.nodes[other.end]) else {
                    continue;
                };
                let distance = norm([0, 1].map(|k| from[k] - t * other.length * other.direction[k]));
                thickness[n] = thickness[n].min(OWN * distance);
                for (end, weight) in [(other.start, 1.0 - t), (other.end, t)] {
                    if weight > 0.0 {
                        thickness[end] = thickness[end].min(ENDS * distance / weight);
                    }
                }
            }
        }
        thickness
    }
}

/// Where on the segment from `a` to `b`, 0 to 1, lies what is nearest to a node of the outline at `from` of all that the strip at the
/// node may come to: outside of both sides at an inner corner, of one of them at an outer one.
fn faced(from: Point, normals: [Point; 2], inner: bool, a: Point, b: Point) -> Option<f64> {
    let outside = |normal: Point| {
        let (low, high) = (dot(normal, minus(a, from)), dot(normal, minus(b, from)));
        match (low > 0.0, high > 0.0) {
            (true, true) => Some([0.0, 1.0]),
            (true, false) => Some([0.0, low / (low - high)]),
            (false, true) => Some([low / (low - high), 1.0]),
            (false, false) => None,
        }
    };
    let v = minus(b, a);
    let nearest = dot(minus(from, a), v) / dot(v, v);
    let [first, second] = normals.map(outside);
    if inner {
        let ([a, b], [c, d]) = (first?, second?);
        let (low, high) = (a.max(c), b.min(d));
        return (low <= high).then(|| nearest.clamp(low, high));
    }
    let places = [first, second].into_iter().flatten().map(|[low, high]| nearest.clamp(low, high));
    places.min_by(|s, t| (s - nearest).abs().total_cmp(&(t - nearest).abs()))
}

#[cfg(test)]
mod tests {
    use super::super::outline::Outline;
    use super::*;
    use crate::numeric::geometry::{area, clip};

    /// The area that two convex cells share.
    fn shared(a: &[Point; 4], b: &[Point; 4]) -> f64 {
        let within = |left: Vec<Point>, k: usize| {
            let (p, v) = (b[k], minus(b[(k + 1) % 4], b[k]));
            clip(&left, v[1], -v[0], cross(v, p))
        };
        area(&(0..4).fold(a.to_vec(), within))
    }

    /// No cell lies on another one, nor is turned over.
    fn check(corners: &[Point]) -> bool {
        let Some(mesh) = Outline::polygon(corners).and_then(|outline| outline.mesh(4)) else { return false };
        let mesh = mesh.mesh;
        for i in mesh.loaded..mesh.cells.len() {
            let own = mesh.corners(i);
            assert!(area(&own) > 0.0, "{corners:?}: {own:?}");
            for j in 0..i {
                let other = mesh.corners(j);
                let least = area(&own).min(area(&other));
                assert!(shared(&own, &other) <= 1e-9 * least, "{corners:?}: {own:?} {other:?}");
            }
        }
        true
    }

    /// Sides whose cells are of very different lengths meet in a notch of 45 degrees: strips lay on the material and were turned over, and
    /// a bound over them was sought without end.
    #[test]
    fn a_sharp_notch_has_a_strip() {
        let corners = [
            [0.0, 0.0],
            [1.4536, 1.8227],
            [-0.4620, 2.0243],
            [-2.5950, 1.2497],
            [-4.5048, -2.1694],
            [-0.3004, -1.3161],
            [-0.1629, 0.2042],
        ];
        assert!(check(&corners));
    }

    /// Stars with notches and spikes of all sharpness.
    #[test]
    fn no_strip_lies_on_anything() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 9_007_199_254_740_992.0
        };
        let mut meshes = 0;
        for _ in 0..60 {
            let count = 4 + (8.0 * random()) as usize;
            let corners: Vec<Point> = (0..count)
                .map(|k| {
                    let (s, c) = (std::f64::consts::TAU * (k as f64 + 0.8 * random()) / count as f64).sin_cos();
                    let r = 0.1 + 0.9 * random() * random();
                    [r * c, r * s]
                })
                .collect();
            meshes += usize::from(check(&corners));
        }
        assert!(meshes > 40, "{meshes}");
    }
}
