//! A gap over a rectangle to second and to third order.

use crate::numeric::Interval;

/// g(x) = value + gradient . v + v . H v/2 with v measured from the middle of a rectangle and some H within `hessian`, for every point
/// of the rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taylor {
    /// The gap in the middle.
    pub value: Interval,
    /// Its slopes along x and y there.
    pub gradient: [Interval; 2],
    /// Second derivatives xx, xy, yy over the whole rectangle.
    pub hessian: [Interval; 3],
}

impl Taylor {
    /// When everything in it is finite.
    #[must_use]
    pub fn finite(self) -> Option<Self> {
        let finite = |i: &Interval| i.defined && i.lo.is_finite() && i.hi.is_finite();
        let all = finite(&self.value) && self.gradient.iter().all(finite) && self.hessian.iter().all(finite);
        all.then_some(self)
    }

    /// The sum of two gaps.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: [0, 1].map(|m| self.gradient[m] + other.gradient[m]),
            hessian: [0, 1, 2].map(|m| self.hessian[m] + other.hessian[m]),
        }
    }

    /// The same to third order, where second derivatives do not change.
    pub(super) fn cubic(self) -> Cubic {
        let Self { value, gradient, hessian } = self;
        Cubic { value, gradient, hessian, third: [Interval::ZERO; 4] }
    }

    /// Bounds of the slopes over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn slopes(&self, [w, h]: [f64; 2]) -> [Interval; 2] {
        let [x, y] = [w, h].map(|side| Interval::new((-0.5 * side).next_down(), (0.5 * side).next_up()));
        let ([gx, gy], [xx, xy, yy]) = (self.gradient, self.hessian);
        [gx + xx * x + xy * y, gy + xy * x + yy * y]
    }

    /// The same about a point at (x, y) from the middle, for a part of the rectangle that has it in its own middle.
    #[must_use]
    pub fn moved(&self, [x, y]: [f64; 2]) -> Self {
        let ([gx, gy], [xx, xy, yy]) = (self.gradient, self.hessian);
        let [x, y] = [x, y].map(|v| Interval::new(v.next_down(), v.next_up()));
        let half = Interval::point(0.5);
        Self {
            value: self.value + x * (gx + half * (xx * x) + xy * y) + y * (gy + half * (yy * y)),
            gradient: [gx + xx * x + xy * y, gy + xy * x + yy * y],
            hessian: self.hessian,
        }
    }

    /// Bounds of the mean over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn mean(&self, size: [f64; 2]) -> Interval {
        // The mean of (x - c)^2 over an interval of length w is w^2/12, that of (x - c)(y - d) over a rectangle 0 for a constant
        // second derivative and at most w h/16 times half its variation else.
        let [w, h] = size.map(Interval::point);
        let [xx, xy, yy] = self.hessian;
        let twist = (0.5 * xy.width() * (size[0] * size[1] / 16.0).next_up()).next_up();
        let part = Interval::new((1.0f64 / 24.0).next_down(), (1.0f64 / 24.0).next_up());
        self.value + xx * w.powi(2) * part + yy * h.powi(2) * part + Interval::new(-twist, twist)
    }

    /// Bounds of g - slope . (x - c) over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn bounds(&self, [w, h]: [f64; 2], slope: [f64; 2]) -> [f64; 2] {
        let [x, y] = [w, h].map(|side| Interval::new((-0.5 * side).next_down(), (0.5 * side).next_up()));
        let [gx, gy] = [0, 1].map(|m| self.gradient[m] - Interval::point(slope[m]));
        let [xx, xy, yy] = self.hessian;
        let half = Interval::point(0.5);
        let all = self.value + along(gx, half * xx, x) + along(gy, half * yy, y) + xy * (x * y);
        [all.lo, all.hi]
    }
}

/// g(x) = value + gradient . v + v . H v/2 + T[v, v, v]/6 with v measured from the middle of a rectangle, H there within `hessian` and,
/// for every point of the rectangle, some T within `third`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic {
    /// The gap in the middle.
    pub value: Interval,
    /// Its slopes along x and y there.
    pub gradient: [Interval; 2],
    /// Second derivatives xx, xy, yy there.
    pub hessian: [Interval; 3],
    /// Third derivatives xxx, xxy, xyy, yyy over the whole rectangle.
    pub third: [Interval; 4],
}

impl Cubic {
    /// When everything in it is finite.
    #[must_use]
    pub fn finite(self) -> Option<Self> {
        let finite = |i: &Interval| i.defined && i.lo.is_finite() && i.hi.is_finite();
        let lower = finite(&self.value) && self.gradient.iter().all(finite);
        (lower && self.hessian.iter().chain(&self.third).all(finite)).then_some(self)
    }

    /// The sum of two gaps.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: [0, 1].map(|m| self.gradient[m] + other.gradient[m]),
            hessian: [0, 1, 2].map(|m| self.hessian[m] + other.hessian[m]),
            third: [0, 1, 2, 3].map(|m| self.third[m] + other.third[m]),
        }
    }

    /// The second derivatives at (x, y) from the middle.
    fn hessian_at(&self, [x, y]: [Interval; 2]) -> [Interval; 3] {
        let t = &self.third;
        [0, 1, 2].map(|m| self.hessian[m] + t[m] * x + t[m + 1] * y)
    }

    /// The same to second order over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn taylor(&self, [w, h]: [f64; 2]) -> Taylor {
        let sides = [w, h].map(|side| Interval::new((-0.5 * side).next_down(), (0.5 * side).next_up()));
        Taylor { value: self.value, gradient: self.gradient, hessian: self.hessian_at(sides) }
    }

    /// The same about a point at (x, y) from the middle, for a part of the rectangle that has it in its own middle.
    #[must_use]
    pub fn moved(&self, [x, y]: [f64; 2]) -> Self {
        let [x, y] = [x, y].map(|v| Interval::new(v.next_down(), v.next_up()));
        let (half, third) = (Interval::point(0.5), Interval::point(1.0) / Interval::point(3.0));
        // d/dv of the hessian's form: of half of it for slopes, of a sixth for values.
        let [xx, xy, yy] = self.hessian;
        let [ax, ay, ayy, b] = self.third;
        let cubic = [ax * x + ay * y, ay * x + ayy * y, ayy * x + b * y];
        let slope =
            |share: Interval, of: [Interval; 3]| [share * (of[0] * x + of[1] * y), share * (of[1] * x + of[2] * y)];
        let (by_h, by_t) = (slope(Interval::point(1.0), [xx, xy, yy]), slope(half, cubic));
        let gradient = [0, 1].map(|m| self.gradient[m] + by_h[m] + by_t[m]);
        let rise = [0, 1].map(|m| self.gradient[m] + half * by_h[m] + third * by_t[m]);
        Self {
            value: self.value + x * rise[0] + y * rise[1],
            gradient,
            hessian: self.hessian_at([x, y]),
            third: self.third,
        }
    }

    /// Bounds of the mean over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn mean(&self, size: [f64; 2]) -> Interval {
        // Odd powers have no mean for constant third derivatives, and that of |v|^3 otherwise: of x^3 over an interval of length w
        // w^3/32, of x^2 y w^2/12 times h/4.
        let [w, h] = size;
        let off = |t: Interval| 0.5 * t.width();
        let [a, b, c, d] = self.third.map(off);
        let cubic = (a * w * w * w + d * h * h * h) / 192.0 + (b * w + c * h) * w * h / 96.0;
        let cubic = cubic * (1.0 + 32.0 * f64::EPSILON);
        let [w2, h2] = size.map(|side| Interval::point(side).powi(2));
        let ([xx, _, yy], part) = (self.hessian, Interval::point(1.0) / Interval::point(24.0));
        self.value + part * (xx * w2 + yy * h2) + Interval::new(-cubic, cubic)
    }
}

/// Bounds of g v + c v^2 for v in a symmetric interval.
fn along(g: Interval, c: Interval, v: Interval) -> Interval {
    let crude = g * v + c * v.powi(2);
    // c (v + g/2c)^2 - g^2/4c: the lowest value where c > 0, the highest where c < 0.
    let vertex = |c: f64| {
        let c = Interval::point(c);
        -(g.powi(2) / (Interval::point(4.0) * c))
    };
    let lo = if c.lo > 0.0 { vertex(c.lo).lo } else { f64::NEG_INFINITY };
    let hi = if c.hi < 0.0 { vertex(c.hi).hi } else { f64::INFINITY };
    // At an end the linear and the square part take their extremes together.
    Interval { lo: crude.lo.max(lo), hi: crude.hi.min(hi), defined: crude.defined }
}
