//! Parts of a cell on which displacement and slope are interpolated, and where they touch edges and nodes.

use super::compliance::Around;
use super::gauss::Touch;
use super::line_potential::{Lines, abscissa};
use super::mesh::{Bilinear, Mesh, Point, cross, dot, minus, norm};
use crate::numeric::geometry::distance_to_segment;

/// Part of the reference square of a cell. Side k runs from corner k to k + 1; corners (-,-), (+,-), (+,+), (-,+).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Subcell {
    pub map: Bilinear,
    /// Its ranges of s and t in the cell.
    pub range: [[f64; 2]; 2],
    /// Edges under the sides, where pressure jumps.
    pub sides: [Option<usize>; 4],
    /// Mesh nodes at the corners.
    pub nodes: [Option<usize>; 4],
}

impl Subcell {
    /// In direction 0 (s) or 1 (t): which end lies on an edge, and that edge.
    pub fn touch(&self, direction: usize) -> (Touch, Option<usize>) {
        let [low, high] = if direction == 0 { [3, 1] } else { [0, 2] };
        match (self.sides[low], self.sides[high]) {
            (Some(e), _) => (Touch::Low, Some(e)),
            (None, Some(e)) => (Touch::High, Some(e)),
            _ => (Touch::None, None),
        }
    }

    /// The mesh node at a corner.
    pub fn node(&self) -> Option<usize> {
        self.nodes.iter().flatten().next().copied()
    }

    /// Half lengths along s and t, at most.
    pub fn half(&self) -> [f64; 2] {
        [norm(self.map.ds(-1.0)).max(norm(self.map.ds(1.0))), norm(self.map.dt(-1.0)).max(norm(self.map.dt(1.0)))]
    }

    /// The halves along direction `k`.
    pub fn halves(&self, k: usize) -> [Self; 2] {
        [self.part(k, -1.0, 0.0), self.part(k, 0.0, 1.0)]
    }

    /// Four parts, none of which has two opposite sides or two corners of it.
    pub fn quarters(&self) -> [Self; 4] {
        let [low, high] = self.halves(0).map(|half| half.halves(1));
        [low[0], low[1], high[0], high[1]]
    }

    /// The part over [`low`, `high`] of direction `k`, in its own reference coordinates.
    pub fn part(&self, k: usize, low: f64, high: f64) -> Self {
        let full = [-1.0, 1.0];
        let ranges = if k == 0 { [[low, high], full] } else { [full, [low, high]] };
        let mut part = *self;
        part.map = self.map.part(ranges[0], ranges[1]);
        let [a, b] = self.range[k];
        part.range[k] = [low, high].map(|x| a + 0.5 * (1.0 + x) * (b - a));
        // Sides and corners that are cut off.
        let (first, last, low_corners, high_corners) =
            if k == 0 { (3, 1, [0, 3], [1, 2]) } else { (0, 2, [0, 1], [3, 2]) };
        if low > -1.0 {
            part.sides[first] = None;
            for c in low_corners {
                part.nodes[c] = None;
            }
        }
        if high < 1.0 {
            part.sides[last] = None;
            for c in high_corners {
                part.nodes[c] = None;
            }
        }
        part
    }
}

/// An edge near a cell, with the strengths of `K` pressures: those of its near sides only.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearEdge<const K: usize> {
    pub edge: usize,
    pub nodes: [usize; 2],
    pub ends: [Point; 2],
    pub direction: Point,
    pub length: f64,
    pub strength: [f64; K],
}

impl<const K: usize> NearEdge<K> {
    /// The normal to the left.
    #[inline(always)]
    pub fn normal(&self) -> Point {
        [-self.direction[1], self.direction[0]]
    }

    /// Takes its strength off a sum that has it.
    pub fn take_off(&self, k: usize, sum: &mut f64) {
        *sum -= self.strength[k];
        // Exactly zero where nothing else is in it.
        if sum.abs() <= 4.0 * f64::EPSILON * self.strength[k].abs() {
            *sum = 0.0;
        }
    }
}

/// The logarithm at a node that an edge of it leaves when the edge's other singular parts are taken off, on a subcell with
/// that node at a corner.
///
/// With rho = |x - node|, a = (x - node) . tau along the edge away from the node, d the distance from its line:
///
/// ```text
/// L = ln(r_far + length - a) - ln(rho - a) = ln(r_far + length - a) - 2 ln d + ln(rho + a)
/// ```
///
/// psi = ln(rho + a) for an edge under a side of the subcell, -ln(rho - a) for the others. It is replaced by a constant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeLogarithm {
    /// Away from the node.
    pub direction: Point,
    /// Under a side of the subcell.
    pub own: bool,
    /// The constant.
    pub constant: f64,
}

impl NodeLogarithm {
    /// psi less its constant at `v` = x - node.
    #[inline(always)]
    pub fn value(&self, v: Point) -> f64 {
        let (rho, a) = (norm(v), dot(v, self.direction));
        let d = cross(self.direction, v);
        // rho + a and rho - a without cancellation.
        let sum = if a >= 0.0 { rho + a } else { d * d / (rho - a) };
        let difference = if a <= 0.0 { rho - a } else { d * d / (rho + a) };
        (if self.own { sum.ln() } else { -difference.ln() }) - self.constant
    }
}

/// The fan of directions in which a subcell lies, seen from a node at its corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fan {
    node: Point,
    /// Unit vectors of the two sides at the node, counter-clockwise.
    sides: [Point; 2],
    /// Least and greatest distance of points of the outer sides of all scaled copies.
    reach: [f64; 2],
    /// sqrt(greatest/mean Jacobian)/2, the deviation of ln max(t1, t2) from its mean -1/2.
    deviation: f64,
}

impl Fan {
    pub fn new(subcell: &Subcell) -> Option<Self> {
        let k = subcell.nodes.iter().position(Option::is_some)?;
        let c = subcell.map.corners();
        let node = c[k];
        let (e1, e2, e3) = (minus(c[(k + 1) % 4], node), minus(c[(k + 3) % 4], node), minus(c[(k + 2) % 4], node));
        let sum = [e1[0] + e2[0], e1[1] + e2[1]];
        let greatest = [e1, e2, e3, sum].iter().map(|v| norm(*v)).fold(0.0, f64::max);
        let mut least = f64::INFINITY;
        for (a, b) in [(e1, e3), (e1, sum), (e2, e3), (e2, sum), (e3, sum)] {
            least = least.min(distance_to_segment([0.0; 2], a, b));
        }
        let map = &subcell.map;
        let j = [map.jacobian(-1.0, -1.0), map.jacobian(1.0, -1.0), map.jacobian(1.0, 1.0), map.jacobian(-1.0, 1.0)];
        let mean = 0.25 * j.iter().sum::<f64>();
        let deviation = 0.5 * (j.iter().fold(0.0, |m: f64, x| m.max(*x)) / mean).sqrt();
        Some(Self { node, sides: [e1, e2].map(|v| v.map(|c| c / norm(v))), reach: [least, greatest], deviation })
    }

    /// The logarithm of an edge from the node along `direction`, and a bound of its root mean square about its constant.
    pub fn logarithm(&self, direction: Point, own: bool) -> (NodeLogarithm, f64) {
        let cosines = self.sides.map(|s| dot(s, direction).clamp(-1.0, 1.0));
        let (mut low, mut high) = (cosines[0].min(cosines[1]), cosines[0].max(cosines[1]));
        // The opposite direction inside the fan.
        let opposite = direction.map(|c| -c);
        if cross(self.sides[0], opposite) > 0.0 && cross(opposite, self.sides[1]) > 0.0 {
            low = -1.0;
        }
        if own {
            high = 1.0;
        }
        let range = if own { [(1.0 + low).ln(), (1.0 + high).ln()] } else { [-(1.0 - low).ln(), -(1.0 - high).ln()] };
        let scale = [self.reach[0].ln(), self.reach[1].ln()];
        let radial = -0.5 + 0.5 * (scale[0] + scale[1]);
        let constant = 0.5 * (range[0] + range[1]) + if own { radial } else { -radial };
        let spread = self.deviation + 0.5 * (scale[1] - scale[0]) + 0.5 * (range[1] - range[0]).abs();
        (NodeLogarithm { direction, own, constant }, spread)
    }

    pub fn node(&self) -> Point {
        self.node
    }

    /// sup over the fan of |ln(rho + x . tau) - ln(rho - x . other)|, `other` nearly opposite to `tau`.
    pub fn difference(&self, tau: Point, other: Point) -> f64 {
        let sum = norm([tau[0] + other[0], tau[1] + other[1]]);
        let least =
            self.sides.iter().map(|s| (1.0 + dot(*s, tau)).min(1.0 - dot(*s, other))).fold(f64::INFINITY, f64::min);
        if least > 2.0 * sum { sum / (least - sum) } else { f64::INFINITY }
    }
}

/// A convex quadrilateral with the outward normals of its sides: lower bounds of distances from it, by separating lines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hull {
    pub around: Around,
    /// Outward unit normals and offsets; a side without length has a zero normal.
    pub sides: [(Point, f64); 4],
}

impl Hull {
    pub fn new(map: &Bilinear) -> Self {
        let c = map.corners();
        let sides = [0, 1, 2, 3].map(|k| {
            let (a, b) = (c[k], c[(k + 1) % 4]);
            let v = minus(b, a);
            let length = norm(v);
            if length == 0.0 {
                return ([0.0; 2], 0.0);
            }
            let n = [v[1] / length, -v[0] / length];
            // The larger offset of both ends: rounding.
            (n, dot(n, a).max(dot(n, b)))
        });
        Self { around: Around::new(map), sides }
    }

    /// Of a point.
    #[inline(always)]
    pub fn distance(&self, p: Point) -> f64 {
        self.sides.iter().map(|(n, c)| dot(*n, p) - c).fold(self.around.distance(p), f64::max)
    }
}

/// Signed distances and abscissae of the corners of a subcell from a near edge.
pub(crate) fn corner_coordinates<const K: usize>(corners: &[Point; 4], e: &NearEdge<K>) -> ([f64; 4], [f64; 4]) {
    (corners.map(|c| cross(e.direction, minus(c, e.ends[0]))), corners.map(|c| abscissa(c, e.ends[0], e.direction)))
}

/// Some edges of a mesh as near edges, with strengths of pressures that count on cells with `near` only.
pub(crate) fn near_edges<const K: usize>(
    mesh: &Mesh,
    lines: &Lines,
    edges: impl Iterator<Item = usize>,
    pressures: [&[f64]; K],
    near: &dyn Fn(usize) -> bool,
) -> Vec<NearEdge<K>> {
    let mut list = Vec::new();
    for i in edges {
        let edge = &mesh.edges[i];
        let sides = edge.sides.map(|s| s.filter(|&c| near(c)));
        if sides == [None, None] {
            continue;
        }
        let strength = pressures
            .map(|p| (sides[0].map_or(0.0, |c| p[c]) - sides[1].map_or(0.0, |c| p[c])) * std::f64::consts::FRAC_1_PI);
        if strength.iter().all(|c| *c == 0.0) {
            continue;
        }
        let (ends, direction, length) = lines.geometry(i);
        list.push(NearEdge { edge: i, nodes: edge.ends, ends, direction, length, strength });
    }
    list
}
