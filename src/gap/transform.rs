//! A gap moved, turned, scaled and tilted: one map of the plane and one of the heights.

use nalgebra::{Matrix2, Rotation2, Vector2};

use super::{Axis, Crown, Cubic, Degree, Face, Generatrix, Growth, Known, Law, Material, Quadratic, Reach, Taylor};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Room for rounding on the way from one frame to another, relative to the coordinates.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A point x of the outer frame is p = R^-1 (scale x + offset) in the gap's own; the gap there is g(p)/per - plane . (x, 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    turn: Rotation2<f64>,
    scale: f64,
    offset: Vector2<f64>,
    per: f64,
    plane: [f64; 3],
}

impl Transform {
    pub fn identity() -> Self {
        Self { turn: Rotation2::identity(), scale: 1.0, offset: Vector2::zeros(), per: 1.0, plane: [0.0; 3] }
    }

    pub fn is_identity(&self) -> bool {
        *self == Self::identity()
    }

    /// Only moved: rectangles stay rectangles and planes stay planes.
    pub fn is_upright(&self) -> bool {
        self.turn.matrix().iter().any(|&entry| entry == 0.0)
    }

    pub fn is_tilted(&self) -> bool {
        self.plane[0] != 0.0 || self.plane[1] != 0.0
    }

    /// Put with its origin at `at` and turned about it.
    pub fn place(at: [f64; 2], turn: Rotation2<f64>) -> Self {
        Self { turn, offset: -Vector2::from(at), ..Self::identity() }
    }

    /// Under a body tilted by these slopes.
    pub fn tilt([a, b]: [f64; 2]) -> Self {
        Self { plane: [a, b, 0.0], ..Self::identity() }
    }

    /// In units of `length` from `origin`, and of `depth` along the normal.
    pub fn units(origin: [f64; 2], length: f64, depth: f64) -> Self {
        Self { scale: length, offset: Vector2::from(origin), per: depth, ..Self::identity() }
    }

    /// First `inner`, then this.
    pub fn after(&self, inner: &Self) -> Self {
        let [a, b, c] = inner.plane;
        let slope = self.turn * Vector2::new(a, b);
        Self {
            turn: there_and_back(self.turn.matrix() * inner.turn.matrix()),
            scale: inner.scale * self.scale,
            offset: inner.scale * self.offset + self.turn * inner.offset,
            per: inner.per * self.per,
            plane: [
                slope.x * self.scale / self.per + self.plane[0],
                slope.y * self.scale / self.per + self.plane[1],
                (slope.dot(&self.offset) + c) / self.per + self.plane[2],
            ],
        }
    }

    /// The outer point before it is turned: where planes are turned but not moved.
    pub fn unturned(&self, p: [f64; 2]) -> [f64; 2] {
        (self.scale * Vector2::from(p) + self.offset).into()
    }

    pub fn inward(&self, p: [f64; 2]) -> [f64; 2] {
        (self.turn.inverse() * Vector2::from(self.unturned(p))).into()
    }

    pub fn outward(&self, p: [f64; 2]) -> [f64; 2] {
        ((self.turn * Vector2::from(p) - self.offset) / self.scale).into()
    }

    /// A direction of the outer frame in the gap's own.
    pub fn direction_inward(&self, v: [f64; 2]) -> [f64; 2] {
        (self.turn.inverse() * Vector2::from(v)).into()
    }

    pub fn direction_outward(&self, v: [f64; 2]) -> [f64; 2] {
        (self.turn * Vector2::from(v)).into()
    }

    pub fn angle(&self) -> f64 {
        self.turn.angle()
    }

    /// Lengths along the surface: one of the gap's own in the outer frame.
    pub fn length_outward(&self, length: f64) -> f64 {
        length / self.scale
    }

    /// A height of the gap's own, seen at an outer point.
    pub fn height_outward(&self, height: f64, [x, y]: [f64; 2]) -> f64 {
        let own = if self.per == 1.0 { height } else { height / self.per };
        if self.plane == [0.0; 3] { own } else { own - (self.plane[0] * x + self.plane[1] * y + self.plane[2]) }
    }

    /// A difference of heights of the gap's own, seen from outside: times this.
    pub fn height_scale(&self) -> f64 {
        1.0 / self.per
    }

    /// The depth in the gap's own frame at which the untilted gap is below it.
    pub fn depth_inward(&self, depth: f64) -> f64 {
        self.per * (depth + self.plane[2])
    }

    /// The rise of the tilted body at an outer point.
    pub fn rise(&self, [x, y]: [f64; 2]) -> f64 {
        self.plane[0] * x + self.plane[1] * y
    }

    pub fn gradient_outward(&self, gradient: [f64; 2]) -> [f64; 2] {
        let g = self.turn * Vector2::from(gradient) * (self.scale / self.per);
        [g.x - self.plane[0], g.y - self.plane[1]]
    }

    /// Jumps of slopes, which no tilt changes.
    pub fn jump_outward(&self, jump: [f64; 2]) -> [f64; 2] {
        (self.turn * Vector2::from(jump) * (self.scale / self.per)).into()
    }

    /// A slope of the outer frame, tilt added, in the gap's own.
    pub fn slope_inward(&self, slope: [f64; 2]) -> [f64; 2] {
        let s = Vector2::new(slope[0] + self.plane[0], slope[1] + self.plane[1]) * (self.per / self.scale);
        (self.turn.inverse() * s).into()
    }

    fn size(&self, rect: &Rect) -> f64 {
        let far = rect.corners().into_iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
        (self.scale * far).max(self.offset.amax())
    }

    /// By how much rounding may move a point of the rectangle on its way into the gap's own frame.
    pub fn rounding(&self, rect: &Rect) -> f64 {
        ROUNDING * self.size(rect)
    }

    /// The rectangle of the gap's own frame around an outer one, with room for rounding.
    pub fn rect_inward(&self, rect: &Rect) -> Rect {
        let margin = self.rounding(rect);
        let [a, b, c, d] = rect.corners().map(|c| self.inward(c));
        let held = [b, c, d].into_iter().fold(Rect { min: a, max: a }, |r, p| r.union(&Rect { min: p, max: p }));
        Rect { min: held.min.map(|v| v - margin), max: held.max.map(|v| v + margin) }
    }

    /// The outer rectangle around one of the gap's own, with room for rounding.
    pub fn rect_outward(&self, rect: &Rect) -> Rect {
        let [a, b, c, d] = rect.corners().map(|c| self.outward(c));
        let held = [b, c, d].into_iter().fold(Rect { min: a, max: a }, |r, p| r.union(&Rect { min: p, max: p }));
        if self.is_identity() {
            return *rect;
        }
        let margin = ROUNDING * self.size(&held) / self.scale;
        Rect { min: held.min.map(|v| v - margin), max: held.max.map(|v| v + margin) }
    }

    /// Bounds of g - slope . (x - c) over an outer rectangle, from those of the gap's own around it, less `slope` of its own there.
    pub fn bounds_outward(&self, [low, high]: [f64; 2], slope: [f64; 2], rect: &Rect) -> [f64; 2] {
        let plane = self.plane_at(rect.centre());
        // The middle of the rectangle is moved by rounding, too.
        let moved = (slope[0].abs() + slope[1].abs()) * self.rounding(rect);
        let [low, high] = [low - moved, high + moved];
        let bound = |v: f64| Interval { defined: true, lo: v, hi: v } / Interval::point(self.per) - plane;
        [if low.is_finite() { bound(low).lo } else { low }, if high.is_finite() { bound(high).hi } else { high }]
    }

    fn plane_at(&self, [x, y]: [f64; 2]) -> Interval {
        let [a, b, c] = self.plane.map(Interval::point);
        a * Interval::point(x) + b * Interval::point(y) + c
    }

    /// A Taylor form of the gap's own over the rectangle around an outer one, in the outer frame.
    pub fn taylor_outward(&self, own: &Taylor, rect: &Rect) -> Option<Taylor> {
        let m = self.turn.matrix();
        let (c, s) = (Interval::point(m[(0, 0)]), Interval::point(m[(1, 0)]));
        let (per, scale) = (Interval::point(self.per), Interval::point(self.scale));
        let steep = scale / per;
        let ([gx, gy], [xx, xy, yy]) = (own.gradient, own.hessian);
        // The middle of the rectangle is moved by rounding.
        let moved = self.rounding(rect);
        let off = (gx.magnitude() + gy.magnitude()) * moved;
        let steeper = (xx.magnitude() + xy.magnitude() + yy.magnitude()) * moved;
        let (off, steeper) = (Interval::new(-off, off), Interval::new(-steeper, steeper));
        let (gx, gy) = (gx + steeper, gy + steeper);
        let two = Interval::point(2.0);
        let curved = steep * scale;
        let value = (own.value + off) / per - self.plane_at(rect.centre());
        if self.turn == Rotation2::identity() {
            let [a, b, _] = self.plane.map(Interval::point);
            let (gradient, hessian) = ([steep * gx - a, steep * gy - b], [xx, xy, yy].map(|v| curved * v));
            return Taylor { value, gradient, hessian }.finite();
        }
        Taylor {
            value,
            gradient: [
                steep * (c * gx - s * gy) - Interval::point(self.plane[0]),
                steep * (s * gx + c * gy) - Interval::point(self.plane[1]),
            ],
            hessian: [
                curved * (c.powi(2) * xx - two * c * s * xy + s.powi(2) * yy),
                curved * (c * s * (xx - yy) + (c.powi(2) - s.powi(2)) * xy),
                curved * (s.powi(2) * xx + two * c * s * xy + c.powi(2) * yy),
            ],
        }
        .finite()
    }

    /// The same to third order: third derivatives turn as a tensor.
    pub fn cubic_outward(&self, own: &Cubic, rect: &Rect) -> Option<Cubic> {
        let m = self.turn.matrix();
        let (c, s) = (Interval::point(m[(0, 0)]), Interval::point(m[(1, 0)]));
        // What rounding of the middle changes second derivatives by.
        let moved = self.rounding(rect);
        let off = own.third.iter().map(|t| t.magnitude()).sum::<f64>() * moved;
        let hessian = own.middle.hessian.map(|h| h + Interval::new(-off, off));
        let middle = self.taylor_outward(&Taylor { hessian, ..own.middle }, rect)?;
        let steep = Interval::point(self.scale).powi(3) / Interval::point(self.per);
        let (two, three) = (Interval::point(2.0), Interval::point(3.0));
        let (c2, s2) = (c.powi(2), s.powi(2));
        let (c3, s3, c2s, cs2) = (c * c2, s * s2, c2 * s, c * s2);
        let [xxx, xxy, xyy, yyy] = own.third;
        // T[v, v, v] for v = R^-1 (x, y).
        let third = [
            c3 * xxx - three * (c2s * xxy - cs2 * xyy) - s3 * yyy,
            c2s * xxx + (c3 - two * cs2) * xxy + (s3 - two * c2s) * xyy + cs2 * yyy,
            cs2 * xxx + (two * c2s - s3) * xxy + (c3 - two * cs2) * xyy - c2s * yyy,
            s3 * xxx + three * (cs2 * xxy + c2s * xyy) + c3 * yyy,
        ];
        Cubic { middle, third: third.map(|t| steep * t) }.finite()
    }

    /// Bounds of the gap's own slopes in the outer frame.
    pub fn slopes_outward(&self, [gx, gy]: [Interval; 2]) -> [Interval; 2] {
        let m = self.turn.matrix();
        let (c, s) = (Interval::point(m[(0, 0)]), Interval::point(m[(1, 0)]));
        let steep = Interval::point(self.scale) / Interval::point(self.per);
        [
            steep * (c * gx - s * gy) - Interval::point(self.plane[0]),
            steep * (s * gx + c * gy) - Interval::point(self.plane[1]),
        ]
    }

    /// Growth about the outer origin from that about the gap's own: the ray of a direction, seen from there, lies in a slightly wider
    /// sector at a slightly different distance.
    pub fn growth_outward(
        &self,
        sector: Interval,
        from: f64,
        own: impl FnOnce(Interval, f64) -> Option<Growth>,
    ) -> Option<Growth> {
        let aside = self.offset.norm() / self.scale;
        if !(from > 2.0 * aside) {
            return None;
        }
        let share = (aside / from).next_up();
        let angle = (share.asin() + 1e-15).next_up();
        let turn = Interval::point(self.turn.angle());
        let seen = sector - turn + Interval::new(-angle, angle);
        let distance = Interval::point(self.scale) * Interval::new(1.0 - share, 1.0 + share);
        let growth = own(seen, (self.scale * from * (1.0 - share)).next_down())?;
        let growth = growth.stretched(distance, from).times(Interval::point(1.0) / Interval::point(self.per));
        let [a, b, c] = self.plane;
        if self.plane == [0.0; 3] {
            return Some(growth);
        }
        let rise = Interval::point(a) * sector.cos() + Interval::point(b) * sector.sin();
        Some(growth.plus(&Growth::power(1.0, -rise, from)).plus(&Growth::constant(-c)))
    }

    /// What is known in the outer frame.
    pub fn known_outward(&self, own: &Known) -> Known {
        let centre = self.outward(own.centre);
        let tilted = self.is_tilted();
        // Planes and cones stay homogeneous under a tilt; a flat becomes a wedge.
        let linear = |law: &Law| law.degree == Degree::Power(1.0);
        let law = own.law.filter(|law| !tilted || linear(law));
        let law = law.map(|law| Law { lowest: self.height_outward(law.lowest, centre), ..law });
        let quadratic = own.quadratic.map(|q| self.quadratic_outward(&q));
        let floor = if self.per == 1.0 && self.plane == [0.0; 3] {
            own.floor
        } else if tilted {
            quadratic.map_or(f64::NEG_INFINITY, |q| q.floor())
        } else {
            let floor = Interval { lo: own.floor, hi: own.floor, defined: true } / Interval::point(self.per);
            (floor - Interval::point(self.plane[2])).lo
        };
        let mirrors = match (self.turn.matrix()[(1, 0)] == 0.0, self.turn.matrix()[(0, 0)] == 0.0) {
            (true, _) => own.mirrors,
            (_, true) => [own.mirrors[1], own.mirrors[0]],
            _ => [false; 2],
        };
        Known {
            centre,
            reference: self.outward(own.reference),
            tips: own.tips.iter().map(|&tip| self.outward(tip)).collect(),
            floor,
            law,
            quadratic,
            axis: own.axis.filter(|_| !tilted).map(|axis| self.axis_outward(axis)),
            face: own.face.as_ref().filter(|_| self.scale == 1.0).map(|face| self.face_outward(face)),
            crown: own.crown.as_ref().filter(|_| self.scale == 1.0).map(|crown| self.crown_outward(crown)),
            material: match own.material {
                Material::Within(rect) => {
                    Material::Within(self.within_ends(own.ends.as_deref(), self.rect_outward(&rect)))
                }
                other => other,
            },
            mirrors: [0, 1].map(|m| mirrors[m] && self.plane[m] == 0.0),
            recurs_along: own.recurs_along.filter(|_| !tilted).map(|along| along + self.angle()),
            ends: own.ends.as_ref().map(|corners| corners.iter().map(|&corner| self.outward(corner)).collect()),
            drawn_along: own.drawn_along + self.angle(),
        }
    }

    fn quadratic_outward(&self, q: &Quadratic) -> Quadratic {
        let about = self.outward(q.about);
        let m = self.turn.matrix();
        let hessian = Matrix2::new(q.hessian[0], q.hessian[1], q.hessian[1], q.hessian[2]);
        let h = m * hessian * m.transpose() * (self.scale * self.scale / self.per);
        let hessian = if self.turn == Rotation2::identity() {
            q.hessian.map(|h| h * (self.scale * self.scale / self.per))
        } else {
            [h[(0, 0)], h[(0, 1)], h[(1, 1)]]
        };
        Quadratic {
            about,
            value: self.height_outward(q.value, about),
            gradient: self.gradient_outward(q.gradient),
            hessian,
        }
    }

    fn axis_outward(&self, axis: Axis) -> Axis {
        let at = self.outward(axis.at);
        let height = |lowest: f64| self.height_outward(lowest, at);
        let generatrix = match axis.generatrix {
            Generatrix::Power { coefficient, exponent, lowest } => Generatrix::Power {
                coefficient: coefficient * self.scale.powf(exponent) / self.per,
                exponent,
                lowest: height(lowest),
            },
            // A sphere in other units of length and height is a spheroid.
            Generatrix::Sphere { radius, lowest } if self.scale == 1.0 && self.per == 1.0 => {
                Generatrix::Sphere { radius, lowest: height(lowest) }
            }
            Generatrix::RoundedCone { radius, slope, lowest } => Generatrix::RoundedCone {
                radius: radius / self.scale / self.scale * self.per,
                slope: slope * self.scale / self.per,
                lowest: height(lowest),
            },
            _ => Generatrix::General,
        };
        Axis { at, generatrix }
    }

    fn face_outward(&self, face: &Face) -> Face {
        let at = self.outward(face.at);
        Face {
            outline: face.outline.clone(),
            at,
            turn: face.turn + self.turn.angle(),
            value: self.height_outward(face.value, at),
            slope: self.gradient_outward(face.slope),
        }
    }

    fn crown_outward(&self, crown: &Crown) -> Crown {
        Crown {
            outline: crown.outline.clone(),
            at: self.outward(crown.at),
            turn: crown.turn + self.turn.angle(),
            form: self.quadratic_outward(&crown.form),
        }
    }

    /// The part of an outer rectangle in which a gap that ends at a polygon of its own has material: the box around a turned box is
    /// larger than that around the polygon.
    pub fn within_ends(&self, ends: Option<&[[f64; 2]]>, rect: Rect) -> Rect {
        if self.is_upright() {
            return rect;
        }
        let held = ends.and_then(|corners| Rect::holding(corners.iter().map(|&corner| self.outward(corner))));
        held.and_then(|held| held.intersection(&rect)).unwrap_or(rect)
    }

    /// The reach in the outer frame of an untilted gap.
    pub fn reach_outward(&self, reach: Reach) -> Reach {
        match reach {
            Reach::Within(rect) => Reach::Within(self.rect_outward(&rect)),
            Reach::Unbounded { from, along } => {
                Reach::Unbounded { from: self.outward(from), along: along + self.turn.angle() }
            }
            other => other,
        }
    }
}

/// The rotation of a product, exact where only rounding keeps it from a multiple of 90 degrees.
fn there_and_back(product: Matrix2<f64>) -> Rotation2<f64> {
    let exact = product.map(|entry| if entry.abs() < 1e-15 { 0.0 } else { entry });
    let quarter = exact.iter().any(|entry| *entry == 0.0);
    Rotation2::from_matrix_unchecked(if quarter { exact.map(|entry| entry.round()) } else { product })
}

/// A rotation whose sine and cosine are exact at multiples of 90 degrees, so that symmetry survives.
pub(super) fn quarter_exact(angle: f64) -> Rotation2<f64> {
    let quarters = angle / std::f64::consts::FRAC_PI_2;
    if (quarters - quarters.round()).abs() > 1e-14 * quarters.abs().max(1.0) {
        return Rotation2::new(angle);
    }
    let (sin, cos) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.round().rem_euclid(4.0) as usize % 4];
    Rotation2::from_matrix_unchecked(Matrix2::new(cos, -sin, sin, cos))
}
