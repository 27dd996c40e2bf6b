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
