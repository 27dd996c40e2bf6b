//! A gap over a rectangle to second order.

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
