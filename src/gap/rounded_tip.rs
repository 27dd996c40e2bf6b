//! A pyramid or a cone whose tip is round: parabolic with the radius of curvature R, as far as its slopes are less than those of the faces.
//!
//! The sharp body is the highest of the planes s . x, s within S: the polygon of the slopes of a pyramid's faces, the disc of a cone's.
//! Rounded, it is its lower envelope by paraboloids of radius R,
//!
//! ```text
//! g(x) = min over y of [max over s in S of s . y + |x - y|^2/(2 R)] = s . x - R |s|^2/2,   s the point of S nearest to x/R
//! ```
//!
//! (Moreau 1965): |x|^2/(2 R) over R S, cylinders of radius R across the edges of a pyramid, planes lowered by R |s|^2/2 beyond. It is
//! convex, smooth to the first derivative, and the second ones lie between 0 and 1/R.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::cone::slope_of;
use super::radial::{self, Profile, distances};
use super::radial::{disc, rising};
use super::ridges::unit;
use super::{Gap, Generatrix, Growth, Known, Material, Reach, Taylor};
use crate::error::{InputError, positive};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// A pyramid or a cone with a round tip; the gap is 0 at its lowest point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundedTip {
    /// Faces of the pyramid, the first one along +x; `None`: a cone.
    faces: Option<usize>,
    /// Slope of a face.
    slope: f64,
    /// R.
    radius: f64,
    /// Distance of the edges of S from the origin, and half their length.
    edge: [f64; 2],
}

/// Where the slope s nearest to x/R lies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    /// Inside of S: the tip.
    Cap,
    /// On the edge of S behind corner k: across the edge between two faces.
    Edge(usize),
    /// At corner k of S: on a face.
    Face(usize),
}

/// A point beside the edge of S behind a corner: which edge, its normal n outwards, and the point along n and across it.
struct Beside {
    edge: usize,
    normal: [f64; 2],
    out: f64,
    across: f64,
}

impl RoundedTip {
    /// A regular pyramid as [`super::Polyhedron::pyramid`] with a tip of this radius of curvature.
    ///
    /// # Errors
    /// When there are fewer than two faces or more than 100 000, the inclination (radians) is not in (0, pi/2), or the radius not a finite
    /// number greater than zero.
    pub fn pyramid(faces: usize, inclination: f64, radius: f64) -> Result<Self, InputError> {
        if !(2..=100_000).contains(&faces) {
            return Err(InputError::new("faces", faces, "a whole number from 2 to 100000"));
        }
        let (slope, (sin, cos)) = (slope_of(inclination)?, unit(1, 2 * faces));
        // A wedge: S is a line through the origin.
        let edge = [if faces == 2 { 0.0 } else { slope * cos }, slope * sin];
        Ok(Self { faces: Some(faces), slope, radius: positive("radius", radius)?, edge })
    }

    /// A cone with a tip of this radius of curvature: a parabola that the straight flank touches at the radius R tan(inclination).
    ///
    /// # Errors
    /// When the inclination (radians) is not in (0, pi/2), or the radius not a finite number greater than zero.
    pub fn cone(inclination: f64, radius: f64) -> Result<Self, InputError> {
        Ok(Self { faces: None, slope: slope_of(inclination)?, radius: positive("radius", radius)?, edge: [0.0; 2] })
    }

    /// Number of faces; `None` for a cone.
    #[must_use]
    pub fn faces(&self) -> Option<usize> {
        self.faces
    }

    /// Radius of curvature of the tip.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    fn beside(faces: usize, x: f64, y: f64) -> Beside {
        let edge = ((y.atan2(x) / TAU).rem_euclid(1.0) * faces as f64) as usize % faces;
        let (sin, cos) = unit(2 * edge + 1, 2 * faces);
        Beside { edge, normal: [cos, sin], out: cos * x + sin * y, across: cos * y - sin * x }
    }

    fn part(&self, faces: usize, point: &Beside) -> Part {
        let [near, half] = self.edge.map(|length| length * self.radius);
        if point.out <= near {
            Part::Cap
        } else if point.across.abs() <= half {
            Part::Edge(point.edge)
        } else {
            Part::Face((point.edge + usize::from(point.across > 0.0)) % faces)
        }
    }

    /// The gap and its slopes.
    fn at(&self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let Some(faces) = self.faces else {
            let (r, t) = (x.hypot(y), self.slope);
            if r <= self.radius * t {
                return (0.5 * r * (r / self.radius), [x / self.radius, y / self.radius]);
            }
            return (t * (r - 0.5 * self.radius * t), [t * (x / r), t * (y / r)]);
        };
        let point = Self::beside(faces, x, y);
        let Beside { normal: [nx, ny], out, across, .. } = point;
        let ([near, half], radius) = (self.edge, self.radius);
        let along = |out: f64, across: f64| [nx * out - ny * across, ny * out + nx * across];
        match self.part(faces, &point) {
            Part::Cap => (0.5 * (x * (x / radius) + y * (y / radius)), [x / radius, y / radius]),
            Part::Edge(_) => {
                let rise = near * (out - 0.5 * radius * near) + 0.5 * across * (across / radius);
                (rise, along(near, across / radius))
            }
            Part::Face(_) => {
                let rise = near * out + half * across.abs() - 0.5 * radius * (self.slope * self.slope);
                (rise, along(near, half.copysign(across)))
            }
        }
    }

    /// What rounding may do to this value at a point.
    fn rounding(&self, x: f64, y: f64, value: f64) -> f64 {
        16.0 * f64::EPSILON * (self.slope * x.hypot(y)).min(value + self.radius * self.slope * self.slope)
    }

    /// Second derivatives xx, xy, yy of the part in which a rectangle lies; `None` where it lies in several. Each part is convex.
    fn curvatures(&self, faces: usize, rect: &Rect) -> Option<[f64; 3]> {
        let part = |[x, y]: [f64; 2]| self.part(faces, &Self::beside(faces, x, y));
        let [first, others @ ..] = rect.corners().map(part);
        if others.iter().any(|other| *other != first) {
            return None;
        }
        let bend = self.radius.recip();
        Some(match first {
            Part::Cap => [bend, 0.0, bend],
            Part::Face(_) => [0.0; 3],
            Part::Edge(k) => {
                let (sin, cos) = unit(2 * k + 1, 2 * faces);
                [bend * sin * sin, -bend * sin * cos, bend * cos * cos]
            }
        })
    }

    /// Of a cone, over a set of radii.
    fn profile(&self, r: Interval) -> Profile {
        let [t, radius, half] = [self.slope, self.radius, 0.5].map(Interval::point);
        let cap = self.radius * self.slope;
        let value = |r: f64| {
            let inner = Interval::point(r);
            if r <= cap { half * inner * inner / radius } else { t * (inner - half * radius * t) }
        };
        let bend = Interval::point(1.0) / radius;
        let flank = t / r;
        Profile {
            value: Interval { lo: value(r.lo).lo.max(0.0), ..value(r.hi) },
            slope_over_r: if r.hi <= cap {
                bend
            } else if r.lo > cap {
                flank
            } else {
                Interval::new((t / Interval::point(r.hi)).lo.min(bend.lo), bend.hi)
            },
            curvature: if r.hi <= cap {
                bend
            } else if r.lo > cap {
                Interval::ZERO
            } else {
                Interval::new(0.0, bend.hi)
            },
        }
    }

    /// How far {g < d} extends along an axis, of which the sharp body {P < 1} is reached to h: that of the sets {P < d - q} enlarged by
    /// sqrt(2 R q), q between 0 and d, is largest at q = R/(2 h^2).
    fn extent(&self, depth: f64, h: f64) -> f64 {
        let round = 0.5 * (self.radius / h) / h;
        if depth <= round { (2.0 * self.radius).sqrt() * depth.sqrt() } else { h * depth + 0.5 * self.radius / h }
    }
}

/// Room for the rounding of an extent.
const ROUNDING: f64 = 1.0 + 1e-14;

/// More faces than this grow outwards like a cone between two.
const MANY: usize = 64;

impl Gap for RoundedTip {
    fn gap(&self, x: f64, y: f64) -> f64 {
        self.at(x, y).0
    }

    fn gradient(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        Some(self.at(x, y).1)
    }

    fn describe(&self) -> Known {
        match self.faces {
            None => rising(Generatrix::RoundedCone { radius: self.radius, slope: self.slope, lowest: 0.0 }),
            Some(faces) => Known {
                floor: 0.0,
                material: Material::Everywhere,
                // The first face looks along +x.
                mirrors: [faces.is_multiple_of(2), true],
                ..Known::nothing()
            },
        }
    }

    fn reach(&self, depth: f64) -> Reach {
        let Some(faces) = self.faces else { return disc(self.extent(depth.max(0.0), self.slope.recip())) };
        if !(depth > 0.0) {
            return Reach::Nowhere;
        }
        if faces == 2 {
            return Reach::Unbounded { from: [0.0; 2], along: FRAC_PI_2 };
        }
        // The corners of {P < 1} lie between those of S.
        let corner = 1.0 / self.edge[0];
        let corners = (0..faces).map(|k| {
            let (sin, cos) = unit(2 * k + 1, 2 * faces);
            [corner * cos, corner * sin]
        });
        let Some(sharp) = Rect::holding(corners) else { return Reach::Unknown };
        let side = |m: usize| [-sharp.min[m], sharp.max[m]].map(|h| self.extent(depth, h) * ROUNDING);
        let ([west, east], [south, north]) = (side(0), side(1));
        if [west, east, south, north].iter().all(|side| side.is_finite()) {
            Reach::Within(Rect { min: [-west, -south], max: [east, north] })
        } else {
            Reach::Unbounded { from: [0.0; 2], along: 0.0 }
        }
    }

    fn bounds(&self, rect: &Rect, slope: [f64; 2]) -> Option<[f64; 2]> {
        let own = self.taylor(rect)?;
        let [low, high] = own.bounds(rect.size(), slope);
        // It lies above each of its tangent planes, and below each of its tangent paraboloids.
        let bend = Interval::point(self.radius.recip().next_up());
        let plane = Taylor { hessian: [Interval::ZERO; 3], ..own };
        let bowl = Taylor { hessian: [bend, Interval::ZERO, bend], ..own };
        let ([under, _], [_, over]) = (plane.bounds(rect.size(), slope), bowl.bounds(rect.size(), slope));
        let [lowest, highest] = match self.faces {
            None => radial::bounds(rect, slope, self.profile(distances(rect)).value, || None),
            Some(_) => [f64::NEG_INFINITY, f64::INFINITY],
        };
        Some([low.max(under).max(lowest), high.min(over).min(highest)])
    }

    fn taylor(&self, rect: &Rect) -> Option<Taylor> {
        let Some(faces) = self.faces else { return radial::taylor(rect, |r| self.profile(r)) };
        let [x, y] = rect.centre();
        let (value, slope) = self.at(x, y);
        let within = |value: f64, by: f64| Interval::new((value - by).next_down(), (value + by).next_up());
        let bend = (self.radius.recip() * (1.0 + 8.0 * f64::EPSILON)).next_up();
        let hessian = match self.curvatures(faces, rect) {
            Some(own) => own.map(|own| within(own, 8.0 * f64::EPSILON * bend)),
            None => [Interval::new(0.0, bend), Interval::new(-0.5 * bend, 0.5 * bend), Interval::new(0.0, bend)],
        };
        Taylor {
            value: within(value, self.rounding(x, y, value)),
            gradient: slope.map(|slope| within(slope, 16.0 * f64::EPSILON * self.slope)),
            hessian,
        }
        .finite()
    }

    fn growth(&self, sector: Interval, from: f64) -> Option<Growth> {
        let slope = Interval::point(self.slope);
        let rise = match self.faces {
            None => slope,
            Some(faces) if faces > MANY => slope * Interval::new(unit(1, 2 * faces).1, 1.0),
            Some(faces) => {
                let (cos, sin) = (sector.cos(), sector.sin());
                let along = |k: usize| {
                    let (s, c) = unit(k, faces);
                    slope * (Interval::point(c) * cos + Interval::point(s) * sin)
                };
                // The directions of the faces are rounded.
                (0..faces).map(along).reduce(Interval::max)? * Interval::new(1.0 - 1e-14, 1.0 + 1e-14)
            }
        };
        // Lower than the sharp body by at most R |s|^2/2.
        let lowered = -(Interval::point(0.5 * self.radius) * slope * slope);
        let lowered = Interval::new(lowered.lo, 0.0);
        Some(Growth::power(1.0, rise, from).plus(&Growth::power(0.0, lowered, 0.0)))
    }

    fn mean(&self, cell: &Rect) -> f64 {
        let ([x, y], [w, h]) = (cell.centre(), cell.size());
        match self.faces.and_then(|faces| self.curvatures(faces, cell)) {
            Some([xx, _, yy]) => self.gap(x, y) + (xx * w * w + yy * h * h) / 24.0,
            None => super::mean::by_quadrature(|x, y| self.gap(x, y), cell),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Cone, Polyhedron};

    fn points() -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(|k| [2.0 * (1.7 * f64::from(k)).sin(), 2.0 * (0.9 * f64::from(k)).cos()])
    }

    /// The envelope as it is defined, by looks over S.
    fn envelope(faces: usize, slope: f64, radius: f64, [x, y]: [f64; 2]) -> f64 {
        const LOOKS: u32 = 60;
        let corner = |k: usize| {
            let (sin, cos) = unit(k % faces, faces);
            [slope * cos, slope * sin]
        };
        let mut highest = f64::NEG_INFINITY;
        for k in 0..faces {
            let (a, b) = (corner(k), corner(k + 1));
            for (i, j) in (0..=LOOKS).flat_map(|i| (0..=LOOKS - i).map(move |j| (i, j))) {
                let [u, v] = [i, j].map(|i| f64::from(i) / f64::from(LOOKS));
                let s = [0, 1].map(|m| u * a[m] + v * b[m]);
                highest = highest.max(s[0] * x + s[1] * y - 0.5 * radius * (s[0] * s[0] + s[1] * s[1]));
            }
        }
        highest
    }

    #[test]
    fn it_is_the_envelope_by_paraboloids() {
        for faces in [2, 3, 4, 5, 8] {
            let tip = RoundedTip::pyramid(faces, 0.4, 1.3).unwrap();
            for p in points() {
                let (own, looked) = (tip.gap(p[0], p[1]), envelope(faces, 0.4f64.tan(), 1.3, p));
                assert!(looked <= own + 1e-14 && own - looked < 3e-5, "{faces} faces at {p:?}: {own} {looked}");
            }
        }
    }

    #[test]
    fn far_out_it_is_the_sharp_body_lowered() {
        let lowered = 0.5 * 0.01 * 0.3f64.tan().powi(2);
        let (tip, sharp) = (RoundedTip::pyramid(3, 0.3, 0.01).unwrap(), Polyhedron::pyramid(3, 0.3).unwrap());
        assert!((tip.gap(1.0, 0.2) - sharp.gap(1.0, 0.2) + lowered).abs() < 1e-15);
        let (tip, sharp) = (RoundedTip::cone(0.3, 0.01).unwrap(), Cone::new(0.3).unwrap());
        assert!((tip.gap(1.0, 0.2) - sharp.gap(1.0, 0.2) + lowered).abs() < 1e-15);
    }

    #[test]
    fn many_faces_are_a_cone() {
        let (many, cone) = (RoundedTip::pyramid(3000, 0.3, 1.5).unwrap(), RoundedTip::cone(0.3, 1.5).unwrap());
        for [x, y] in points() {
            assert!((many.gap(x, y) - cone.gap(x, y)).abs() < 1e-6);
        }
    }

    #[test]
    fn the_reach_touches_the_contact() {
        for (faces, depth) in [(3, 0.01), (3, 0.4), (4, 0.05), (5, 0.3), (7, 1.0)] {
            let tip = RoundedTip::pyramid(faces, 0.5, 0.7).unwrap();
            let Reach::Within(rect) = tip.reach(depth) else { panic!("bounded") };
            for m in 0..2 {
                for side in [rect.min[m], rect.max[m]] {
                    let lowest = |share: f64| {
                        (-4000..=4000)
                            .map(|k| 2.0 * rect.longer_side() * f64::from(k) / 4000.0)
                            .map(|t| if m == 0 { tip.gap(share * side, t) } else { tip.gap(t, share * side) })
                            .fold(f64::INFINITY, f64::min)
                    };
                    assert!(lowest(1.0) >= depth && lowest(0.999) < depth, "{faces} faces, side {side} of {m}");
                }
            }
        }
    }
}
