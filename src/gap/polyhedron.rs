//! Polyhedral punches: the gap is the highest of several planes.

use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_2, TAU};

use super::cone::slope_of;
use super::envelope::{Lowest, least_rise};
use super::fan::Fan;
use super::ridges::corner_window;
use super::{
    AnyGap, Cubic, Degree, Gap, Growth, Known, Law, Material, Quadratic, Reach, Ridges, Taylor, mean, radial, range,
};
use crate::error::{InputError, finite, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// g = max over k of (slope_x x + slope_y y + offset): a convex polyhedron, blunt or pointed, regular or not.
///
/// The paper's punches (equations 16 and 25) are [`Polyhedron::pyramid`].
#[derive(Debug, Clone, PartialEq)]
pub struct Polyhedron {
    planes: Vec<[f64; 3]>,
    lowest: Lowest,
    /// Of a regular pyramid, pointed or blunt: the first planes are its faces in order.
    fan: Option<Fan>,
    /// Angle of a direction in which the highest plane does not rise: the gap stays as low as it is there.
    level_direction: Option<f64>,
    /// Least slope of the highest plane along any ray, far out.
    rise: f64,
    /// Holds every corner with room to spare.
    window: Rect,
    ridges: Ridges,
}

/// More planes than this are looked at only where they matter.
const MANY: usize = 64;

/// Roundings of a height where planes meet: of its products and sums, and of the point.
const ROUNDINGS: f64 = 4.0;

/// More planes than this are refused: finding where they meet takes the square of their number.
const MOST_PLANES: usize = 2000;

impl Polyhedron {
    /// Planes as `[slope_x, slope_y, offset]`, at least one.
    ///
    /// # Errors
    /// Names the plane with a number that is not finite, or the empty list.
    pub fn new(planes: Vec<[f64; 3]>) -> Result<Self, InputError> {
        if planes.is_empty() {
            return Err(InputError::new("planes", "an empty list", "at least one plane [slope_x, slope_y, offset]"));
        }
        if planes.len() > MOST_PLANES {
            let given = format!("{} planes", planes.len());
            return Err(InputError::new("planes", given, format!("at most {MOST_PLANES} planes")));
        }
        for (k, plane) in planes.iter().enumerate() {
            for (m, &value) in plane.iter().enumerate() {
                finite(&format!("planes[{k}][{m}]"), value)?;
            }
        }
        let window = corner_window(&planes);
        let ridges = Ridges::of(&planes, &window);
        let (rise, level_direction) = least_rise(&planes);
        let lowest = Lowest::of(&planes, rise, level_direction);
        Ok(Self { planes, lowest, fan: None, level_direction, rise, window, ridges })
    }

    /// Only some of the planes, without what the approximate methods ask for.
    fn few(planes: Vec<[f64; 3]>) -> Self {
        let (rise, level_direction) = least_rise(&planes);
        let lowest = Lowest::of(&planes, rise, level_direction);
        let window = Rect::around(lowest.point, [0.0; 2]);
        Self { planes, lowest, fan: None, level_direction, rise, window, ridges: Ridges::default() }
    }

    /// A regular pyramid of `faces` >= 2 faces, each inclined by `inclination` (radians, in (0, pi/2)); the first face
    /// looks along +x: g = tan(inclination) max over k of (x cos(2 pi k/faces) + y sin(2 pi k/faces)).
    /// Two faces make a wedge.
    ///
    /// # Errors
    /// When there are fewer than two faces or more than 100 000, or the inclination is out of range.
    pub fn pyramid(faces: usize, inclination: f64) -> Result<Self, InputError> {
        Ok(Self::of_fan(Fan { faces, slope: slope_of_faces(faces, inclination)?, flat: 0.0 }))
    }

    fn of_fan(fan: Fan) -> Self {
        let mut planes = fan.planes();
        if fan.flat > 0.0 {
            planes.push([0.0; 3]);
        }
        Self {
            planes,
            lowest: Lowest::AT_ORIGIN,
            fan: Some(fan),
            level_direction: (fan.faces == 2).then_some(FRAC_PI_2),
            rise: fan.rise(),
            window: fan.window(),
            ridges: Ridges::of_fan(fan.faces, fan.slope, fan.flat),
        }
    }

    /// The planes that can be the highest over a rectangle, where there are many: of a fan, those of its sector.
    fn near(&self, rect: &Rect) -> Cow<'_, [[f64; 3]]> {
        let sector = self.fan.filter(|fan| fan.faces > MANY).and_then(|fan| Some((fan.faces, fan.over(rect)?)));
        sector.map_or(Cow::Borrowed(&self.planes), |(faces, sector)| {
            let others = self.planes[faces..].iter().copied();
            Cow::Owned(sector.map(|k| self.planes[k]).chain(others).collect())
        })
    }

    /// A pyramid whose tip is cut off so that a flat polygon of this inradius is left; the gap is zero on the flat.
    ///
    /// # Errors
    /// As [`Polyhedron::pyramid`]; names `flat` when it is not a finite number greater than zero.
    pub fn truncated_pyramid(faces: usize, inclination: f64, flat: f64) -> Result<Self, InputError> {
        let slope = slope_of_faces(faces, inclination)?;
        let flat = positive("flat", flat)?;
        if faces == 2 {
            let [a, b] = [slope, -slope].map(|s| [s, 0.0, -slope * flat]);
            return Self::new(vec![a, b, [0.0; 3]]);
        }
        Ok(Self::of_fan(Fan { faces, slope, flat }))
    }

    /// The planes, `[slope_x, slope_y, offset]`.
    #[must_use]
    pub fn planes(&self) -> &[[f64; 3]] {
        &self.planes
    }

    /// Number of faces and their slope, when this is a regular pointed pyramid.
    #[must_use]
    pub fn regular(&self) -> Option<(usize, f64)> {
        self.fan.filter(|fan| fan.flat == 0.0).map(|fan| (fan.faces, fan.slope))
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
        if let Some(fan) = self.fan.filter(|fan| fan.faces > 12) {
            let [own, before, after] = fan.at([x, y]).map(|k| &self.planes[k]);
            let others = [before, after].into_iter().chain(&self.planes[fan.faces..]);
            return others.map(at).fold(at(own), higher);
        }
        let (first, others) = self.planes.split_first().expect("at least one plane");
        others.iter().map(at).fold(at(first), higher)
    }
}

/// The slope of so many faces of a regular pyramid.
fn slope_of_faces(faces: usize, inclination: f64) -> Result<f64, InputError> {
    if !(2..=100_000).contains(&faces) {
        return Err(InputError::new("faces", faces, "a whole number from 2 to 100000"));
    }
    slope_of(inclination)
}

impl Gap for Polyhedron {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.highest(x, y).0
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let p = self.highest(x, y).1;
        Some([p[0], p[1]])
    }

    fn describe(&self) -> Known {
        let pointed = self.regular().map(|_| Law { degree: Degree::Power(1.0), lowest: 0.0 });
        // Planes that all pass through one point, to the rounding of their heights there, are homogeneous about it.
        let [x, y] = self.lowest.point;
        let height = |[a, b, c]: &[f64; 3]| a * x + b * y + c;
        let rounding = |[a, b, c]: &[f64; 3]| ROUNDINGS * f64::EPSILON * ((a * x).abs() + (b * y).abs() + c.abs());
        let meeting = || {
            let (first, lowest) = (&self.planes[0], height(&self.planes[0]));
            let through = |p: &[f64; 3]| (height(p) - lowest).abs() <= rounding(p) + rounding(first);
            self.planes.iter().all(through).then_some(Law { degree: Degree::Power(1.0), lowest })
        };
        let flat = (self.planes.len() == 1).then(|| Quadratic {
            about: [0.0; 2],
            value: self.planes[0][2],
            gradient: [self.planes[0][0], self.planes[0][1]],
            hessian: [0.0; 3],
        });
        Known {
            centre: self.lowest.point,
            floor: self.lowest.floor,
            law: pointed.or_else(|| meeting().filter(|_| self.planes.len() > 1)),
            quadratic: flat,
            material: Material::Everywhere,
            // The first face looks along +x.
            mirrors: self.fan.map_or([false; 2], |fan| [fan.faces.is_multiple_of(2), true]),
            ..Known::nothing()
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        if let Some(fan) = self.fan {
            return fan.reach(depth);
        }
        if depth <= self.lowest.floor {
            return Reach::Nowhere;
        }
        if let Some(along) = self.level_direction {
            // A corner below the depth, and everything beyond it in the level direction.
            let [x, y] = self.lowest.point;
            return if self.gap(x, y) < depth { Reach::Unbounded { from: [x, y], along } } else { Reach::Unknown };
        }
        Reach::Within(self.lowest.below(&self.planes, self.rise, depth).0)
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        Some(range::of_planes(&self.near(rect), rect, slope))
    }

    fn cubic(&self, rect: &Rect) -> Option<Cubic> {
        self.taylor(rect).map(Taylor::cubic)
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let ([x, y], [w, h]) = (rect.centre(), rect.size());
        let top = self.highest(x, y).1;
        let (far_x, far_y) = (x.abs() + w, y.abs() + h);
        let size = |p: &[f64; 3]| p[0].abs() * far_x + p[1].abs() * far_y + p[2].abs();
        // The most by which another plane rises above the highest of the centre, anywhere in the rectangle. Twelve roundings at most, each
        // of a number below the sum of both sizes.
        let over = |p: &[f64; 3]| {
            let [a, b, c] = [0, 1, 2].map(|k| p[k] - top[k]);
            let rise = a * x + b * y + c + 0.5 * (a.abs() * w + b.abs() * h);
            rise + 8.0 * f64::EPSILON * (size(p) + size(top)) <= 0.0
        };
        if !self.near(rect).iter().all(|p| p == top || over(p)) {
            return None;
        }
        let [x, y] = rect.centre().map(Interval::point);
        let [a, b, c] = top.map(Interval::point);
        Taylor { value: a * x + b * y + c, gradient: [a, b], hessian: [Interval::ZERO; 3] }.finite()
    }

    fn slopes(&self, rect: &Rect) -> Option<[Interval; 2]> {
        let own = self.bounds(rect, [0.0; 2])?[0];
        let near = self.near(rect);
        // A plane that lies below the lowest point of the gap all over the rectangle is nowhere the highest.
        let [x, y] = radial::sides(rect);
        let highest = |p: &[f64; 3]| {
            let [a, b, c] = p.map(Interval::point);
            (a * x + b * y + c).hi >= own
        };
        let slopes = near.iter().filter(|p| highest(p)).map(|p| [p[0], p[1]].map(Interval::point));
        slopes.reduce(|a, b| [a[0].union(b[0]), a[1].union(b[1])])
    }

    fn mean_bounds(&self, rect: &Rect) -> Option<[f64; 2]> {
        if self.planes.len() <= mean::MOST_PLANES {
            return Some(mean::of_planes_enclosed(&self.planes, rect));
        }
        super::enclosure::mean(self, rect)
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        if self.planes.len() > MANY {
            return None;
        }
        let (cos, sin) = (sector.cos(), sector.sin());
        let plane = |p: &[f64; 3]| {
            let rise = Interval::point(p[0]) * cos + Interval::point(p[1]) * sin;
            Growth::power(1.0, rise, from).plus(&Growth::constant(p[2]))
        };
        self.planes.iter().map(plane).reduce(|a, b| a.greater(&b))
    }

    fn restricted(&self, rect: &Rect) -> Option<AnyGap> {
        if self.fan.is_some() || self.planes.len() <= MANY {
            return None;
        }
        let kept = range::highest_somewhere(&self.planes, rect);
        (2 * kept.len() <= self.planes.len()).then(|| Self::few(kept).into_any())
    }

    fn is_composed(&self) -> bool {
        self.fan.is_none() && self.planes.len() > MANY
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

    fn planes(&self) -> Option<Vec<[f64; 3]>> {
        (self.planes.len() <= MANY).then(|| self.planes.clone())
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
    fn planes_that_meet_in_one_point_but_for_rounding_are_homogeneous_about_it() {
        let faces = |at: [f64; 2], turned: f64, off: f64| {
            let plane = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / 5.0 + turned).sin_cos();
                [0.3 * cos, 0.2 * sin, 0.01 - 0.3 * cos * at[0] - 0.2 * sin * at[1] + if k == 1 { off } else { 0.0 }]
            };
            Polyhedron::new((0..5).map(plane).collect()).unwrap().describe()
        };
        for (at, turned) in [([0.0; 2], 0.0), ([0.1234, -0.311], 0.3), ([1e3, 700.0], 1.1)] {
            let known = faces(at, turned, 0.0);
            let law = known.law.unwrap();
            assert!(law.degree == Degree::Power(1.0) && (law.lowest - 0.01).abs() <= 1e-15 * (1.0 + at[0]));
            assert!((0..2).all(|m| (known.centre[m] - at[m]).abs() <= 1e-14 * (1.0 + at[m].abs())));
            // One that passes beside it is none of them.
            assert!(faces(at, turned, 1e-11).law.is_none(), "{at:?}");
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
        assert!(matches!(Polyhedron::pyramid(2, 0.5).unwrap().reach(1.0), Reach::Unbounded { .. }));
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
