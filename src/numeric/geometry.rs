//! Plane vocabulary: rectangles and polygons.

/// A rectangle with sides along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Lower left corner.
    pub min: [f64; 2],
    /// Upper right corner.
    pub max: [f64; 2],
}

impl Rect {
    /// The rectangle with this centre and these half sides.
    #[must_use]
    pub fn around(centre: [f64; 2], half: [f64; 2]) -> Self {
        Self { min: [centre[0] - half[0], centre[1] - half[1]], max: [centre[0] + half[0], centre[1] + half[1]] }
    }

    /// Centre.
    #[must_use]
    pub fn centre(&self) -> [f64; 2] {
        [0.5 * (self.min[0] + self.max[0]), 0.5 * (self.min[1] + self.max[1])]
    }

    /// Lengths of the two sides.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    /// Length of the longer side.
    #[must_use]
    pub fn longer_side(&self) -> f64 {
        let [w, h] = self.size();
        w.max(h)
    }

    /// The four corners, counter-clockwise.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 4] {
        [self.min, [self.max[0], self.min[1]], self.max, [self.min[0], self.max[1]]]
    }

    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])],
            max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])],
        }
    }

    /// What both have in common, if anything.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let min = [self.min[0].max(other.min[0]), self.min[1].max(other.min[1])];
        let max = [self.max[0].min(other.max[0]), self.max[1].min(other.max[1])];
        (min[0] <= max[0] && min[1] <= max[1]).then_some(Self { min, max })
    }

    /// The smallest rectangle that holds all points; `None` without points.
    pub fn holding(points: impl IntoIterator<Item = [f64; 2]>) -> Option<Self> {
        points.into_iter().map(|p| Self { min: p, max: p }).reduce(|a, b| a.union(&b))
    }

    /// The same centre, sides times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let [w, h] = self.size();
        Self::around(self.centre(), [0.5 * factor * w, 0.5 * factor * h])
    }

    /// Whether the point lies inside or on the border.
    #[must_use]
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (self.min[0]..=self.max[0]).contains(&x) && (self.min[1]..=self.max[1]).contains(&y)
    }
}

/// What is left of a convex polygon where a x + b y + c <= 0; empty when nothing is.
pub(crate) fn clip(polygon: &[[f64; 2]], a: f64, b: f64, c: f64) -> Vec<[f64; 2]> {
    let side = |p: &[f64; 2]| a * p[0] + b * p[1] + c;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = &polygon[(k + 1) % polygon.len()];
        let (sp, sq) = (side(p), side(q));
        if sp <= 0.0 {
            kept.push(*p);
        }
        if (sp < 0.0 && sq > 0.0) || (sp > 0.0 && sq < 0.0) {
            let t = sp / (sp - sq);
            kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
        }
    }
    kept
}

/// Signed area of a polygon, positive when counter-clockwise.
#[must_use]
pub fn area(polygon: &[[f64; 2]]) -> f64 {
    edges_about_first(polygon).map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0])).sum()
}

/// Centroid of the area of a polygon; of its corners when it has no area.
#[must_use]
pub fn centroid(polygon: &[[f64; 2]]) -> [f64; 2] {
    let twice = 2.0 * area(polygon);
    let base = polygon[0];
    if twice == 0.0 {
        let n = polygon.len() as f64;
        return [0, 1].map(|m| polygon.iter().map(|p| p[m] / n).sum::<f64>());
    }
    let mut moment = [0.0; 2];
    for (p, q) in edges_about_first(polygon) {
        let cross = p[0] * q[1] - p[1] * q[0];
        moment[0] += cross * (p[0] + q[0]);
        moment[1] += cross * (p[1] + q[1]);
    }
    [base[0] + moment[0] / (3.0 * twice), base[1] + moment[1] / (3.0 * twice)]
}

/// Integrals of x^2, x y and y^2 over a counter-clockwise polygon, x and y measured from `about`.
#[must_use]
pub fn second_moments(polygon: &[[f64; 2]], about: [f64; 2]) -> [f64; 3] {
    let from = |p: &[f64; 2]| [p[0] - about[0], p[1] - about[1]];
    let mut sums = [0.0; 3];
    for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (p, q) = (from(p), from(q));
        let cross = p[0] * q[1] - p[1] * q[0];
        sums[0] += cross * (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]) / 12.0;
        sums[1] += cross * (p[0] * q[1] + 2.0 * (p[0] * p[1] + q[0] * q[1]) + q[0] * p[1]) / 24.0;
        sums[2] += cross * (p[1] * p[1] + p[1] * q[1] + q[1] * q[1]) / 12.0;
    }
    sums
}

/// Edges relative to the first corner, so that a polygon far from the origin loses no digits.
fn edges_about_first(polygon: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    let base = polygon.first().copied().unwrap_or_default();
    let from_base = move |p: &[f64; 2]| [p[0] - base[0], p[1] - base[1]];
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(move |(p, q)| (from_base(p), from_base(q)))
}

/// a x b.
#[inline(always)]
pub(crate) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// a - b.
#[inline(always)]
pub(crate) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

/// The scalar product.
#[inline(always)]
pub(crate) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The length.
#[inline(always)]
pub(crate) fn norm(a: [f64; 2]) -> f64 {
    dot(a, a).sqrt()
}

/// How far two points are from each other.
pub(crate) fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    (p[0] - q[0]).hypot(p[1] - q[1])
}

/// The largest distance of points from one; 0 without points.
pub(crate) fn farthest<'a>(points: impl IntoIterator<Item = &'a [f64; 2]>, from: [f64; 2]) -> f64 {
    points.into_iter().map(|p| distance(*p, from)).fold(0.0, f64::max)
}

/// Where two lines a x + b y + c = 0 meet, each in units of its own so that nothing overflows; not a number where they do not.
pub(crate) fn meeting(lines: [[f64; 3]; 2]) -> [f64; 2] {
    let [p, q] = lines.map(|line| line.map(|v| v / line[0].abs().max(line[1].abs())));
    let det = cross([p[0], p[1]], [q[0], q[1]]);
    [(q[2] * p[1] - p[2] * q[1]) / det, (p[2] * q[0] - q[2] * p[0]) / det]
}

/// Twice the area of a triangle, positive where p lies left of the way from a to b.
pub(crate) fn left_of(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    cross([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]])
}

/// Distance of a point from a segment.
pub(crate) fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let v = minus(b, a);
    let length = dot(v, v);
    let t = if length > 0.0 { (dot(minus(p, a), v) / length).clamp(0.0, 1.0) } else { 0.0 };
    norm(minus(p, [a[0] + t * v[0], a[1] + t * v[1]]))
}

/// The area that a polygon, counter-clockwise, shares with the disc of radius `r` about the origin: side by side, the triangle
/// with the origin cut by the circle.
pub(crate) fn disc_in_polygon(corners: &[[f64; 2]], r: f64) -> f64 {
    let sector = |p: [f64; 2], q: [f64; 2]| 0.5 * r * r * cross(p, q).atan2(dot(p, q));
    let side = |p: [f64; 2], q: [f64; 2]| {
        let d = minus(q, p);
        let (a, b, c) = (dot(d, d), dot(p, d), dot(p, p) - r * r);
        let root = (b * b - a * c).max(0.0).sqrt();
        let (enter, leave) = ((-b - root) / a, (-b + root) / a);
        if root == 0.0 || enter >= 1.0 || leave <= 0.0 {
            return sector(p, q);
        }
        let at = |t: f64| [p[0] + t * d[0], p[1] + t * d[1]];
        let (u, v) = (at(enter.max(0.0)), at(leave.min(1.0)));
        sector(p, u) + 0.5 * cross(u, v) + sector(v, q)
    };
    (0..corners.len()).map(|k| side(corners[k], corners[(k + 1) % corners.len()])).sum()
}

/// Corners of the convex hull of points, counter-clockwise (Andrew 1979); of points on a line its ends.
pub(crate) fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while chain.len() > 1 && left_of(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0 {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}
