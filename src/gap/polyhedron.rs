//! Polyhedral punches: the gap is the highest of several planes.

use std::f64::consts::TAU;

use super::analytic::slope_of;
use super::ridges::{corner_window, face_polygon, unit};
use super::{Gap, Reach, Ridges, mean};
use crate::error::{InputError, finite, positive};
use crate::geometry::{Rect, centroid, clip};

/// g = max over k of (slope_x x + slope_y y + offset): a convex polyhedron, blunt or pointed, regular or not.
///
/// The paper's punches (equations 16 and 25) are [`Polyhedron::pyramid`].
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron {
    planes: Vec<[f64; 3]>,
    apex: [f64; 2],
    /// Number of faces and slope of a pyramid, pointed or blunt: the first planes are its faces in order.
    fan: Option<(usize, f64)>,
    /// Inradius of the flat tip of a pyramid.
    flat: f64,
    /// Holds every corner with room to spare.
    window: Rect,
    ridges: Ridges,
}

impl Polyhedron {
    /// Planes as `[slope_x, slope_y, offset]`, at least one.
    ///
    /// # Errors
    /// Names the plane with a number that is not finite, or the empty list.
    pub fn new(planes: Vec<[f64; 3]>) -> Result<Self, InputError> {
        if planes.is_empty() {
            return Err(InputError::new("planes", "an empty list", "at least one plane [slope_x, slope_y, offset]"));
        }
        for (k, plane) in planes.iter().enumerate() {
            for (m, &value) in plane.iter().enumerate() {
                finite(&format!("planes[{k}][{m}]"), value)?;
            }
        }
        let window = corner_window(&planes);
        let ridges = Ridges::of(&planes, &window);
        let apex = lowest_point(&planes, &ridges, &window);
        Ok(Self { planes, apex, fan: None, flat: 0.0, window, ridges })
    }

    /// A regular pyramid of `faces` >= 2 faces, each inclined by `inclination` (radians, in (0, pi/2)); the first face
    /// looks along +x: g = tan(inclination) max over k of (x cos(2 pi k/faces) + y sin(2 pi k/faces)).
    /// Two faces make a wedge.
    ///
    /// # Errors
    /// When there are fewer than two faces or more than 100 000, or the inclination is out of range.
    pub fn pyramid(faces: usize, inclination: f64) -> Result<Self, InputError> {
        if !(2..=100_000).contains(&faces) {
            return Err(InputError::new("faces", faces, "a whole number from 2 to 100000"));
        }
        let slope = slope_of(inclination)?;
        let planes = (0..faces)
            .map(|k| {
                let (sin, cos) = unit(k, faces);
                [slope * cos, slope * sin, 0.0]
            })
            .collect();
        Ok(Self::of_fan(planes, faces, slope, 0.0))
    }

    fn of_fan(planes: Vec<[f64; 3]>, faces: usize, slope: f64, flat: f64) -> Self {
        let ridges = Ridges::of_fan(faces, slope, flat);
        let room = if flat > 0.0 { 4.0 * flat / (0.5 * TAU / faces as f64).cos() } else { 4.0 };
        let window = Rect::around([0.0; 2], [room; 2]);
        Self { planes, apex: [0.0; 2], fan: Some((faces, slope)), flat, window, ridges }
    }

    /// A pyramid whose tip is cut off so that a flat polygon of this inradius is left; the gap is zero on the flat.
    ///
    /// # Errors
    /// As [`Polyhedron::pyramid`]; names `flat` when it is not a finite number greater than zero.
    pub fn truncated_pyramid(faces: usize, inclination: f64, flat: f64) -> Result<Self, InputError> {
        let pointed = Self::pyramid(faces, inclination)?;
        let flat = positive("flat", flat)?;
        let slope = slope_of(inclination)?;
        if faces == 2 {
            let [a, b] = [slope, -slope].map(|s| [s, 0.0, -slope * flat]);
            return Self::new(vec![a, b, [0.0; 3]]);
        }
        let mut planes = pointed.planes;
        for plane in &mut planes {
            plane[2] = -slope * flat;
        }
        planes.push([0.0; 3]);
        Ok(Self::of_fan(planes, faces, slope, flat))
    }

    /// The planes, `[slope_x, slope_y, offset]`.
    #[must_use]
    pub fn planes(&self) -> &[[f64; 3]] {
        &self.planes
    }

    /// Number of faces and their slope, when this is a regular pointed pyramid.
    #[must_use]
    pub fn regular(&self) -> Option<(usize, f64)> {
        self.fan.filter(|_| self.flat == 0.0)
    }

    /// The highest plane, behind its height.
    #[inline]
    fn highest(&self, x: f64, y: f64) -> (f64, &[f64; 3]) {
        let at = |p| -> (f64, &[f64; 3]) {
            let [a, b, c]: &[f64; 3] = p;
            (a * x + b * y + c, p)
        };
        let higher = |top: (f64, _), here: (f64, _)| if here.0 > top.0 { here } else { top };
        // With few faces it is quicker to look at them all.
        if let Some((faces, _)) = self.fan.filter(|&(faces, _)| faces > 12) {
            // The face whose sector holds the point; neighbours guard against rounding.
            let k = (y.atan2(x) / TAU * faces as f64).round() as i64;
            let face = |k: i64| &self.planes[k.rem_euclid(faces as i64) as usize];
            let others = [face(k - 1), face(k + 1)].into_iter().chain(&self.planes[faces..]);
            return others.map(at).fold(at(face(k)), higher);
        }
        let (first, others) = self.planes.split_first().expect("at least one plane");
        others.iter().map(at).fold(at(first), higher)
    }
}

/// Where the surface is lowest; the middle of the flat if it is lowest on one.
fn lowest_point(planes: &[[f64; 3]], ridges: &Ridges, window: &Rect) -> [f64; 2] {
    if let Some(k) = planes.iter().position(|p| p[0] == 0.0 && p[1] == 0.0) {
        let flat = face_polygon(planes, k, window);
        if flat.len() >= 3 {
            return centroid(&flat);
        }
    }
    let height = |p: &[f64; 2]| planes.iter().map(|q| q[0] * p[0] + q[1] * p[1] + q[2]).fold(f64::MIN, f64::max);
    ridges.corners.iter().copied().min_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or([0.0; 2])
}

impl Gap for Polyhedron {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.highest(x, y).0
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let p = self.highest(x, y).1;
        Some([p[0], p[1]])
    }

    fn range(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let (c, [w, h]) = (rect.centre(), rect.size());
        // A plane over the rectangle: its value in the middle, and half its variation.
        let plane = |p: &[f64; 3]| {
            let half = 0.5 * ((p[0] - slope[0]).abs() * w + (p[1] - slope[1]).abs() * h);
            (p[0] * c[0] + p[1] * c[1] + p[2], half)
        };
        let mut bounds = [f64::NEG_INFINITY; 2];
        // The three highest in the middle, highest first.
        let mut top: [Option<(f64, &[f64; 3])>; 3] = [None; 3];
        for p in &self.planes {
            let (middle, half) = plane(p);
            bounds = [bounds[0].max(middle - half), bounds[1].max(middle + half)];
            let mut carried = Some((middle, p));
            for place in &mut top {
                if carried.is_some_and(|c| place.is_none_or(|t| c.0 > t.0)) {
                    std::mem::swap(place, &mut carried);
                }
            }
        }
        // Across ridges and at corners: the highest plane is nowhere below any mean of planes.
        let top: Vec<&[f64; 3]> = top.into_iter().flatten().map(|t| t.1).collect();
        let mut mean = |weights: [f64; 3]| {
            let mut p = [0.0; 3];
            for (w, q) in weights.iter().zip(&top) {
                (0..3).for_each(|m| p[m] += w * q[m]);
            }
            let (middle, half) = plane(&p);
            bounds[0] = bounds[0].max(middle - half);
        };
        if top.len() >= 2 {
            [0.25, 0.5, 0.75].into_iter().for_each(|t| mean([t, 1.0 - t, 0.0]));
        }
        if top.len() == 3 {
            let third = 1.0 / 3.0;
            for weights in [[third, third, 1.0 - 2.0 * third], [0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5]]
            {
                mean(weights);
            }
        }
        Some(bounds)
    }

    fn homogeneous(&self) -> Option<f64> {
        self.regular().map(|_| 1.0)
    }

    fn mirrors(&self) -> [bool; 2] {
        // The first face looks along +x.
        self.fan.map_or([false; 2], |(faces, _)| [faces.is_multiple_of(2), true])
    }

    fn reach(&self, depth: f64) -> Reach {
        if let Some((faces, slope)) = self.fan {
            if depth <= 0.0 {
                return Reach::Nowhere;
            }
            if faces == 2 {
                return Reach::Unbounded;
            }
            let ridge = (depth / slope + self.flat) / (0.5 * TAU / faces as f64).cos();
            if self.flat > 0.0 {
                let corner = |k: usize| {
                    let (sin, cos) = unit(2 * k + 1, 2 * faces);
                    [ridge * cos, ridge * sin]
                };
                return Rect::holding((0..faces).map(corner))
                    .map_or(Reach::Nowhere, |rect| Reach::Within(rect.scaled(1.0 + 1e-9)));
            }
            return Reach::Within(Rect::around([0.0; 2], [ridge; 2]));
        }
        let steepest = self.planes.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
        let window = self.window;
        let margin =
            if steepest > 0.0 { 1e6 * (depth - self.gap(self.apex[0], self.apex[1])).abs() / steepest } else { 0.0 };
        let window = Rect::around(window.centre(), [0.5 * window.size()[0] + margin, 0.5 * window.size()[1] + margin]);
        let mut region = window.corners().to_vec();
        for [a, b, c] in &self.planes {
            if !region.is_empty() {
                region = clip(&region, *a, *b, c - depth);
            }
        }
        let inner = window.scaled(1.0 - 1e-9);
        if region.iter().any(|&p| !inner.contains(p)) {
            return Reach::Unbounded;
        }
        match Rect::holding(region) {
            Some(rect) => Reach::Within(rect.scaled(1.0 + 1e-9)),
            None => Reach::Nowhere,
        }
    }

    fn mean(&self, cell: &Rect) -> f64 {
        if self.planes.len() <= mean::MOST_PLANES {
            return mean::of_planes(&self.planes, cell);
        }
        // The region of one plane is convex: highest at the corners, highest throughout.
        let [x, y] = cell.centre();
        let (height, top) = self.highest(x, y);
        if cell.corners().iter().all(|c| self.gap(c[0], c[1]) <= top[0] * c[0] + top[1] * c[1] + top[2]) {
            return height;
        }
        mean::by_quadrature(|x, y| self.gap(x, y), cell)
    }

    fn planes(&self) -> Option<&[[f64; 3]]> {
        Some(&self.planes)
    }

    fn ray_kinks(&self, from: [f64; 2], direction: [f64; 2], kinks: &mut Vec<f64>) {
        // Along the ray each plane is a line h + s r; walk their upper envelope outwards.
        let line = |p: &[f64; 3]| (p[0] * from[0] + p[1] * from[1] + p[2], p[0] * direction[0] + p[1] * direction[1]);
        if self.regular().is_some() && from == [0.0; 2] {
            return;
        }
        let highest_first = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
        let Some(mut top) = self.planes.iter().map(line).max_by(highest_first) else { return };
        let mut r = 0.0;
        loop {
            // The next line to overtake the present one.
            let overtaking =
                self.planes.iter().map(line).filter(|l| l.1 > top.1).map(|l| ((top.0 - l.0) / (l.1 - top.1), l));
            let Some((at, next)) = overtaking.min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.1.total_cmp(&a.1.1))) else {
                return;
            };
            if at > r {
                kinks.push(at);
                r = at;
            }
            top = next;
        }
    }

    fn kink_directions(&self, from: [f64; 2], angles: &mut Vec<f64>) {
        if self.regular().is_some() && from != [0.0; 2] {
            // The apex alone: far ridges are seen in their own directions.
            angles.push((-from[1]).atan2(-from[0]));
        }
        if let Some((faces, _)) = self.regular() {
            angles.extend((0..faces).map(|k| TAU * (k as f64 + 0.5) / faces as f64));
            return;
        }
        let size = self.window.size()[0];
        let mut see = |[x, y]: [f64; 2]| {
            let (dx, dy) = (x - from[0], y - from[1]);
            if dx.hypot(dy) > 1e-12 * size {
                angles.push(dy.atan2(dx));
            }
        };
        self.ridges.corners.iter().for_each(|&corner| see(corner));
        // Far out on those that do not end.
        for ridge in &self.ridges.all {
            for (end, sense) in ridge.ends.iter().zip([-size, size]) {
                if end.is_none() {
                    see([0, 1].map(|m| ridge.point[m] + sense * ridge.direction[m]));
                }
            }
        }
    }

    fn ridges(&self) -> Option<Ridges> {
        Some(self.ridges.clone())
    }

    fn centre(&self) -> [f64; 2] {
        self.apex
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pyramid_is_the_maximum_over_its_faces() {
        for faces in [2, 3, 4, 5, 7, 12, 1000] {
            let punch = Polyhedron::pyramid(faces, 0.3).unwrap();
            for k in 0..50 {
                let (x, y) = ((1.7 * k as f64).sin(), (0.9 * k as f64).cos());
                let brute = (0..faces)
                    .map(|m| TAU * m as f64 / faces as f64)
                    .map(|a| 0.3f64.tan() * (x * a.cos() + y * a.sin()))
                    .fold(f64::MIN, f64::max);
                assert!((punch.gap(x, y) - brute).abs() < 1e-14, "{faces} faces at {x}, {y}");
            }
        }
    }

    #[test]
    fn mean_over_a_ridge_is_the_exact_volume() {
        let wedge = Polyhedron::new(vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).unwrap();
        let cell = Rect { min: [-0.25, 3.0], max: [0.75, 5.0] };
        assert!((wedge.mean(&cell) - (0.25 * 0.125 + 0.75 * 0.375)).abs() < 1e-15);
    }

    #[test]
    fn reach_of_a_wedge_is_unbounded_and_of_a_truncated_pyramid_its_rim() {
        assert_eq!(Polyhedron::pyramid(2, 0.5).unwrap().reach(1.0), Reach::Unbounded);
        let blunt = Polyhedron::truncated_pyramid(4, 0.25 * std::f64::consts::PI, 2.0).unwrap();
        let Reach::Within(rect) = blunt.reach(1.0) else { panic!("bounded") };
        assert!((rect.max[0] - 3.0).abs() < 1e-6 && (rect.min[1] + 3.0).abs() < 1e-6);
        assert_eq!(blunt.reach(-1.0), Reach::Nowhere);
    }

    #[test]
    fn kinks_along_a_ray_are_where_the_slope_jumps() {
        let blunt = Polyhedron::truncated_pyramid(4, 0.25 * std::f64::consts::PI, 2.0).unwrap();
        let mut kinks = Vec::new();
        blunt.ray_kinks([0.0, 0.0], [1.0, 0.0], &mut kinks);
        assert_eq!(kinks.len(), 1);
        assert!((kinks[0] - 2.0).abs() < 1e-15);
    }
}
