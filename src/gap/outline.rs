//! Plan-forms with an edge: disc, ellipse, polygon.

use std::f64::consts::PI;

use super::Known;
use crate::error::{InputError, finite, positive};
use crate::numeric::geometry::{self, Rect};

/// More corners than a drawing has; the check for crossings is quadratic in them.
const MOST_CORNERS: usize = 10_000;

/// A polygon whose area is less than this share of its extent squared counts as a line.
const SLIMMEST: f64 = 1e-12;

/// A closed region with an edge: a disc or an ellipse about the origin, or any simple polygon, also re-entrant.
///
/// ```
/// use contact_patch::gap::Outline;
/// let l = Outline::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])?;
/// assert!(l.contains([0.5, 1.5]) && !l.contains([1.5, 1.5]));
/// assert_eq!(l.area(), 3.0);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Outline(Shape);

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Semi-axes along x and y.
    Ellipse([f64; 2]),
    /// Corners, counter-clockwise.
    Polygon(Vec<[f64; 2]>),
}

impl Outline {
    /// The disc of this radius about the origin.
    ///
    /// # Errors
    /// Names `disc` when the radius is not a finite number greater than zero.
    pub fn disc(radius: f64) -> Result<Self, InputError> {
        positive("disc", radius)?;
        Ok(Self(Shape::Ellipse([radius; 2])))
    }

    /// The ellipse with these semi-axes along x and y about the origin.
    ///
    /// # Errors
    /// Names the semi-axis that is not a finite number greater than zero.
    pub fn ellipse(semi_axes: [f64; 2]) -> Result<Self, InputError> {
        positive("ellipse[0]", semi_axes[0])?;
        positive("ellipse[1]", semi_axes[1])?;
        Ok(Self(Shape::Ellipse(semi_axes)))
    }

    /// The polygon with these corners, in either sense of turn; the first may be repeated at the end.
    ///
    /// # Errors
    /// Names the corner that is not finite or repeats the one before it, the edge that meets another one, and says
    /// when fewer than three corners are left or they lie on a line. At most 10 000 corners.
    pub fn polygon(corners: &[[f64; 2]]) -> Result<Self, InputError> {
        for (k, corner) in corners.iter().enumerate() {
            for (m, &value) in corner.iter().enumerate() {
                finite(&format!("polygon[{k}][{m}]"), value)?;
            }
        }
        let mut corners = corners.to_vec();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if !(3..=MOST_CORNERS).contains(&corners.len()) {
            let given = format!("{} different corners", corners.len());
            return Err(InputError::new("polygon", given, format!("3 to {MOST_CORNERS} corners [x, y]")));
        }
        let unit = unit_square(&corners);
        if let Some(k) = (0..unit.len()).find(|&k| unit[k] == unit[(k + 1) % unit.len()]) {
            let next = (k + 1) % unit.len();
            return Err(InputError::new(
                format!("polygon[{next}]"),
                format!("{:?}", corners[next]),
                "a corner different from the one before it",
            ));
        }
        if let Some((k, m)) = crossing(&unit) {
            return Err(InputError::new(
                format!("polygon[{k}]"),
                format!("the edge from {:?}, which meets the edge from polygon[{m}] {:?}", corners[k], corners[m]),
                "edges that meet only at their common corners",
            ));
        }
        let area = geometry::area(&unit);
        if area.abs() < SLIMMEST {
            return Err(InputError::new("polygon", "corners on a line", "corners around an area"));
        }
        if area < 0.0 {
            corners.reverse();
        }
        Ok(Self(Shape::Polygon(corners)))
    }

    /// Corners of a polygon, counter-clockwise; empty for an ellipse.
    #[must_use]
    pub fn corners(&self) -> &[[f64; 2]] {
        match &self.0 {
            Shape::Polygon(corners) => corners,
            Shape::Ellipse(_) => &[],
        }
    }

    /// Semi-axes along x and y of an ellipse (equal for a disc); `None` for a polygon.
    #[must_use]
    pub fn semi_axes(&self) -> Option<[f64; 2]> {
        match self.0 {
            Shape::Ellipse(axes) => Some(axes),
            Shape::Polygon(_) => None,
        }
    }

    /// The mirrors that are left of a gap which ends here and whose centre is then this one.
    pub(super) fn mirrors_of(&self, known: &Known, centre: [f64; 2]) -> [bool; 2] {
        let own = self.mirrors(known.centre);
        [0, 1].map(|m| centre[m] == known.centre[m] && known.mirrors[m] && own[m])
    }

    /// Whether it is its own image in the lines x = c (the first) and y = c through a point.
    fn mirrors(&self, centre: [f64; 2]) -> [bool; 2] {
        [0, 1].map(|m| match &self.0 {
            Shape::Ellipse(_) => centre[m] == 0.0,
            Shape::Polygon(corners) => {
                let image = |corner: [f64; 2]| {
                    let mut image = corner;
                    image[m] = 2.0 * centre[m] - corner[m];
                    image
                };
                let n = corners.len();
                // Mirrored, they come in the opposite order.
                (0..n).any(|first| (0..n).all(|k| image(corners[k]) == corners[(first + n - k) % n]))
            }
        })
    }

    /// Whether the point lies inside or on the edge.
    #[must_use]
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        match &self.0 {
            Shape::Ellipse([a, b]) => (x / a).hypot(y / b) <= 1.0,
            Shape::Polygon(corners) => {
                let mut inside = false;
                for ([ax, ay], [bx, by]) in edges(corners) {
                    let cross = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
                    let between = |a: f64, b: f64, v: f64| a.min(b) <= v && v <= a.max(b);
                    if cross == 0.0 && between(ax, bx, x) && between(ay, by, y) {
                        return true;
                    }
                    // A ray to the right crosses the edge: upward with the point on its left, or downward on its right.
                    if (ay > y) != (by > y) && (cross > 0.0) == (by > ay) {
                        inside = !inside;
                    }
                }
                inside
            }
        }
    }

    /// Whether the whole rectangle lies inside. A rectangle that only rounding pushes over the edge (1e-9 of its
    /// sides) still does: cells that were fitted to the outline keep their material.
    #[must_use]
    pub fn covers(&self, cell: &Rect) -> bool {
        let cell = cell.scaled(1.0 - 1e-9);
        if !cell.corners().iter().all(|&c| self.contains(c)) {
            return false;
        }
        edges(self.corners()).all(|(a, b)| !passes_through(&cell, a, b))
    }

    /// Whether no point of the rectangle lies inside. May say no where the rectangle is near, never yes where it is not.
    #[must_use]
    pub(super) fn misses(&self, rect: &Rect) -> bool {
        let rect = rect.scaled(1.0 + 1e-9);
        match &self.0 {
            Shape::Ellipse([a, b]) => {
                let nearest = [0, 1].map(|m| 0.0_f64.max(rect.min[m]).min(rect.max[m]));
                (nearest[0] / a).hypot(nearest[1] / b) > 1.0
            }
            Shape::Polygon(corners) => {
                !rect.corners().iter().any(|&c| self.contains(c))
                    && !edges(corners).any(|(a, b)| rect.contains(a) || passes_through(&rect, a, b))
            }
        }
    }

    /// Area.
    #[must_use]
    pub fn area(&self) -> f64 {
        match &self.0 {
            Shape::Ellipse([a, b]) => PI * a * b,
            Shape::Polygon(corners) => geometry::area(corners),
        }
    }

    /// Centroid of the area.
    #[must_use]
    pub fn centroid(&self) -> [f64; 2] {
        match &self.0 {
            Shape::Ellipse(_) => [0.0; 2],
            Shape::Polygon(corners) => geometry::centroid(corners),
        }
    }

    /// The angle of the longest side of a polygon, radians counter-clockwise from x; 0 for an ellipse.
    #[must_use]
    pub fn longest_side(&self) -> f64 {
        let along = |(a, b): ([f64; 2], [f64; 2])| [b[0] - a[0], b[1] - a[1]];
        let length = |v: &[f64; 2]| v[0].hypot(v[1]);
        // The first of several that differ by rounding.
        let sides = edges(self.corners()).map(along);
        let longest = sides.reduce(|a, b| if length(&b) > length(&a) * (1.0 + 1e-9) { b } else { a });
        longest.map_or(0.0, |[x, y]| y.atan2(x))
    }

    /// A point inside: the centroid if that is, else the middle of the longest chord along x among those half-way
    /// between the heights of neighbouring corners.
    #[must_use]
    pub fn inner_point(&self) -> [f64; 2] {
        let centroid = self.centroid();
        if self.contains(centroid) {
            return centroid;
        }
        let mut heights: Vec<f64> = self.corners().iter().map(|c| c[1]).collect();
        heights.sort_by(f64::total_cmp);
        let mut longest = (0.0, centroid);
        for pair in heights.windows(2).filter(|pair| pair[0] < pair[1]) {
            let y = 0.5 * (pair[0] + pair[1]);
            let mut crossings: Vec<f64> = edges(self.corners())
                .filter(|(a, b)| (a[1] > y) != (b[1] > y))
                .map(|(a, b)| a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])))
                .collect();
            crossings.sort_by(f64::total_cmp);
            for chord in crossings.chunks_exact(2) {
                if chord[1] - chord[0] > longest.0 {
                    longest = (chord[1] - chord[0], [0.5 * (chord[0] + chord[1]), y]);
                }
            }
        }
        longest.1
    }

    /// The smallest rectangle around it.
    #[must_use]
    pub fn bounds(&self) -> Rect {
        match &self.0 {
            Shape::Ellipse(axes) => Rect::around([0.0; 2], *axes),
            Shape::Polygon(corners) => {
                Rect::holding(corners.iter().copied()).unwrap_or(Rect::around([0.0; 2], [0.0; 2]))
            }
        }
    }

    /// Appends the distances r > 0 at which the ray `from + r direction` (a unit vector) crosses the edge.
    pub fn crossings(&self, from: [f64; 2], direction: [f64; 2], at: &mut Vec<f64>) {
        match &self.0 {
            Shape::Ellipse([a, b]) => {
                // |p + r q| = 1 where the ellipse is the unit circle.
                let (p, q) = ([from[0] / a, from[1] / b], [direction[0] / a, direction[1] / b]);
                at.extend(circle_crossings(p, q).into_iter().flatten().filter(|&r| r > 0.0));
            }
            Shape::Polygon(corners) => {
                for (a, b) in edges(corners) {
                    let (e, f) = ([b[0] - a[0], b[1] - a[1]], [a[0] - from[0], a[1] - from[1]]);
                    let across = direction[0] * e[1] - direction[1] * e[0];
                    let r = (f[0] * e[1] - f[1] * e[0]) / across;
                    let t = (f[0] * direction[1] - f[1] * direction[0]) / across;
                    if (0.0..=1.0).contains(&t) && r > 0.0 && r.is_finite() {
                        at.push(r);
                    }
                }
            }
        }
    }

    /// Appends the directions in which the corners lie, seen from `from`.
    pub fn corner_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        let seen = self.corners().iter().map(|c| [c[0] - from[0], c[1] - from[1]]).filter(|d| *d != [0.0; 2]);
        angles.extend(seen.map(|[dx, dy]| dy.atan2(dx)));
    }
}

/// Where |p + r q| = 1, smaller r first; nothing without a crossing. The product of the roots keeps both accurate.
pub(super) fn circle_crossings(p: [f64; 2], q: [f64; 2]) -> [Option<f64>; 2] {
    let [a, half_b] = [q[0] * q[0] + q[1] * q[1], p[0] * q[0] + p[1] * q[1]];
    let norm = p[0].hypot(p[1]);
    let c = (norm - 1.0) * (norm + 1.0);
    // a - (p x q)^2 is half_b^2 - a c without its cancellation.
    let cross = p[0] * q[1] - p[1] * q[0];
    let discriminant = a - cross * cross;
    if !(discriminant > 0.0 && a > 0.0) {
        return [None; 2];
    }
    let far = -half_b - discriminant.sqrt().copysign(half_b);
    if far == 0.0 {
        return [None; 2];
    }
    let (s, t) = (far / a, c / far);
    [Some(s.min(t)), Some(s.max(t))]
}

fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// The corners moved and scaled into the unit square, where nothing overflows.
fn unit_square(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let largest = corners.iter().flatten().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let small: Vec<[f64; 2]> = corners.iter().map(|c| c.map(|v| v / largest)).collect();
    let Some(rect) = Rect::holding(small.iter().copied()) else { return small };
    let side = rect.longer_side().max(f64::MIN_POSITIVE);
    small.iter().map(|c| [(c[0] - rect.min[0]) / side, (c[1] - rect.min[1]) / side]).collect()
}

/// The first two edges that meet elsewhere than at a corner they share.
fn crossing(corners: &[[f64; 2]]) -> Option<(usize, usize)> {
    let n = corners.len();
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let on = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        turn(a, b, c) == 0.0 && (0..2).all(|m| a[m].min(b[m]) <= c[m] && c[m] <= a[m].max(b[m]))
    };
    for k in 0..n {
        let (a, b) = (corners[k], corners[(k + 1) % n]);
        // The next edge turns straight back onto this one.
        let after = corners[(k + 2) % n];
        if on(a, b, after) || on(b, after, a) {
            return Some((k, (k + 1) % n));
        }
        for m in k + 2..n {
            if (m + 1) % n == k {
                continue;
            }
            let (c, d) = (corners[m], corners[(m + 1) % n]);
            let apart = (0..2).any(|i| a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i]));
            if apart {
                continue;
            }
            let proper =
                (turn(a, b, c) > 0.0) != (turn(a, b, d) > 0.0) && (turn(c, d, a) > 0.0) != (turn(c, d, b) > 0.0);
            if proper || on(a, b, c) || on(a, b, d) || on(c, d, a) || on(c, d, b) {
                return Some((k, m));
            }
        }
    }
    None
}

/// Whether the segment runs through the inside of the rectangle (Liang & Barsky 1984).
fn passes_through(rect: &Rect, a: [f64; 2], b: [f64; 2]) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for m in 0..2 {
        let d = b[m] - a[m];
        if d == 0.0 {
            if a[m] <= rect.min[m] || a[m] >= rect.max[m] {
                return false;
            }
            continue;
        }
        let (s, t) = ((rect.min[m] - a[m]) / d, (rect.max[m] - a[m]) / d);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    enter < leave
}

#[cfg(test)]
mod tests {
    use super::*;

    const L: [[f64; 2]; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

    #[test]
    fn polygon_knows_inside_from_outside_and_keeps_its_edge() {
        let clockwise: Vec<_> = L.iter().rev().copied().collect();
        for outline in [Outline::polygon(&L).unwrap(), Outline::polygon(&clockwise).unwrap()] {
            for on in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.5], [2.0, 1.0], [1.5, 1.0]] {
                assert!(outline.contains(on), "{on:?}");
            }
            for out in [[1.5, 1.5], [-1e-12, 1.0], [2.0 + 1e-12, 0.5], [1.0, 2.1], [-1.0, 0.0], [3.0, 1.0]] {
                assert!(!outline.contains(out), "{out:?}");
            }
            assert_eq!(outline.area(), 3.0);
            let [x, y] = outline.centroid();
            assert!((x - 5.0 / 6.0).abs() < 1e-15 && (y - 5.0 / 6.0).abs() < 1e-15);
        }
    }

    #[test]
    fn covers_only_what_lies_wholly_inside() {
        let u = Outline::polygon(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ])
        .unwrap();
        // All four corners inside, the notch between them.
        assert!(!u.covers(&Rect { min: [0.5, 0.5], max: [2.5, 1.5] }));
        assert!(u.covers(&Rect { min: [0.0, 0.0], max: [3.0, 1.0] }));
        assert!(u.covers(&Rect { min: [2.0, 1.0], max: [3.0, 2.0] }));
        assert!(!u.covers(&Rect { min: [1.9, 1.0], max: [3.0, 2.0] }));
        assert!(u.contains(u.inner_point()));
        let disc = Outline::disc(1.0).unwrap();
        assert!(disc.covers(&Rect::around([0.0; 2], [0.7; 2])));
        assert!(!disc.covers(&Rect::around([0.0; 2], [0.8; 2])));
    }

    #[test]
    fn what_is_not_an_outline_is_named() {
        let path = |corners: &[[f64; 2]]| Outline::polygon(corners).unwrap_err().path;
        assert_eq!(path(&[[0.0, 0.0], [1.0, 0.0]]), "polygon");
        assert_eq!(path(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), "polygon");
        assert_eq!(path(&[[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]]), "polygon[2][0]");
        assert_eq!(path(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), "polygon[0]");
        assert!(path(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).starts_with("polygon"));
        assert!(path(&[[0.0, 0.0], [1.0, 0.1], [3.0, 0.3], [7.0, 0.7]]).starts_with("polygon"));
        assert_eq!(path(&[[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), "polygon[1]");
        // A spike, and a corner that touches an edge.
        assert_eq!(path(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), "polygon[0]");
        assert_eq!(path(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), "polygon[0]");
        assert_eq!(Outline::ellipse([1.0, 0.0]).unwrap_err().path, "ellipse[1]");
        assert_eq!(Outline::disc(f64::INFINITY).unwrap_err().path, "disc");
        for scale in [1e-300, 1e300] {
            assert!(Outline::polygon(&L.map(|c| c.map(|v| 0.5 * scale * v))).is_ok());
        }
    }

    #[test]
    fn a_ray_leaves_an_ellipse_at_its_edge() {
        let ellipse = Outline::ellipse([3.0, 0.5]).unwrap();
        for k in 0..20 {
            let (sin, cos) = (0.1 + f64::from(k)).sin_cos();
            let mut at = Vec::new();
            ellipse.crossings([1.0, -0.2], [cos, sin], &mut at);
            assert_eq!(at.len(), 1);
            let (x, y) = (1.0 + at[0] * cos, -0.2 + at[0] * sin);
            assert!(((x / 3.0).hypot(y / 0.5) - 1.0).abs() < 1e-13);
        }
    }
}
