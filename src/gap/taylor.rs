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
        Cubic { middle: self, third: [Interval::ZERO; 4] }
    }

    /// Bounds of the slopes over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn slopes(&self, [w, h]: [f64; 2]) -> [Interval; 2] {
        let [x, y] = half_sides([w, h]);
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
        let [x, y] = half_sides([w, h]);
        let [gx, gy] = [0, 1].map(|m| self.gradient[m] - Interval::point(slope[m]));
        let [xx, xy, yy] = self.hessian;
        let half = Interval::point(0.5);
        let all = self.value + along(gx, half * xx, x) + along(gy, half * yy, y) + xy * (x * y);
        [all.lo, all.hi]
    }
}

/// g(x) = value + gradient . v + v . H v/2 + T[v, v, v]/6 with v measured from the middle of a rectangle, H there within the Hessian of
/// `middle` and, for every point of the rectangle, some T within `third`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic {
    /// The gap, its slopes and its second derivatives in the middle.
    pub middle: Taylor,
    /// Third derivatives xxx, xxy, xyy, yyy over the whole rectangle.
    pub third: [Interval; 4],
}

impl Cubic {
    /// When everything in it is finite.
    #[must_use]
    pub fn finite(self) -> Option<Self> {
        let third = self.third.iter().all(|i| i.defined && i.lo.is_finite() && i.hi.is_finite());
        self.middle.finite().filter(|_| third).map(|middle| Self { middle, ..self })
    }

    /// The sum of two gaps.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let third = [0, 1, 2, 3].map(|m| self.third[m] + other.third[m]);
        Self { middle: self.middle.plus(&other.middle), third }
    }

    /// The second derivatives at (x, y) from the middle.
    fn hessian_at(&self, [x, y]: [Interval; 2]) -> [Interval; 3] {
        let t = &self.third;
        [0, 1, 2].map(|m| self.middle.hessian[m] + t[m] * x + t[m + 1] * y)
    }

    /// The same to second order over the rectangle, whose sides are w and h.
    #[must_use]
    pub fn taylor(&self, [w, h]: [f64; 2]) -> Taylor {
        let sides = half_sides([w, h]);
        Taylor { hessian: self.hessian_at(sides), ..self.middle }
    }

    /// The same about a point at (x, y) from the middle, for a part of the rectangle that has it in its own middle.
    #[must_use]
    pub fn moved(&self, [x, y]: [f64; 2]) -> Self {
        let [x, y] = [x, y].map(|v| Interval::new(v.next_down(), v.next_up()));
        let (half, third) = (Interval::point(0.5), Interval::point(1.0) / Interval::point(3.0));
        let Taylor { value, gradient, hessian } = self.middle;
        let [xxx, xxy, xyy, yyy] = self.third;
        // H v, and T[v, v]/2.
        let times = |[xx, xy, yy]: [Interval; 3]| [xx * x + xy * y, xy * x + yy * y];
        let by_h = times(hessian);
        let by_t = times([xxx * x + xxy * y, xxy * x + xyy * y, xyy * x + yyy * y]).map(|slope| half * slope);
        let rise = [0, 1].map(|m| gradient[m] + half * by_h[m] + third * by_t[m]);
        let middle = Taylor {
            value: value + x * rise[0] + y * rise[1],
            gradient: [0, 1].map(|m| gradient[m] + by_h[m] + by_t[m]),
            hessian: self.hessian_at([x, y]),
        };
        Self { middle, third: self.third }
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
        let ([xx, _, yy], part) = (self.middle.hessian, Interval::point(1.0) / Interval::point(24.0));
        self.middle.value + part * (xx * w2 + yy * h2) + Interval::new(-cubic, cubic)
    }
}

/// Half the sides of a rectangle, either way from its middle.
pub(crate) fn half_sides(size: [f64; 2]) -> [Interval; 2] {
    size.map(|side| Interval::new((-0.5 * side).next_down(), (0.5 * side).next_up()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{AnyGap, Cone, Formula, Gap, Paraboloid, Power, Sphere, Sum};
    use crate::numeric::geometry::Rect;

    /// Centres and half sides: about the origin, with it, away from it.
    const RECTANGLES: [([f64; 2], [f64; 2]); 4] = [
        ([0.0; 2], [0.1, 0.07]),
        ([0.05, -0.03], [0.06, 0.05]),
        ([0.4, 0.3], [0.02, 0.03]),
        ([0.4, 0.3], [0.03, 0.04]),
    ];

    /// 20 x 20 points of a rectangle.
    fn points(c: [f64; 2], half: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(move |k| {
            let at = |m: usize, n: usize| c[m] + half[m] * ((n as f64 + 0.5) / 10.0 - 1.0);
            [at(0, k % 20), at(1, k / 20)]
        })
    }

    #[test]
    fn third_derivatives_hold() {
        let formulas = [
            ("x^2/0.3 + y^2/0.7 + 0.05*cos(9*x)*cos(7*y + 0.4)", true),
            ("exp(x*y) + sinh(x) - cosh(y - 0.3*x) + tanh(x + 2*y)", true),
            ("abs(x)^3 + abs(y)^3.5 + (x - 2*y)^5", true),
            ("r^3 + r^4 + 0.2*hypot(x, y)^3.4", true),
            ("sqrt(2 + x - y) + cbrt(3 + x*y) + (2 + x)^1.7*(3 - y)", true),
            ("(1 + x^2)^(2 + y) + 1/(2 + x + y^2)", true),
            ("ln(2 + x*y) + log10(3 - x) + log2(2 + y)", true),
            ("asin(x - y) + acos(0.5*x*y) + atan(3*x + y^2) + tan(x - 0.5*y)", true),
            ("hypot(x, 2*y) + atan2(x, y)/5 + theta*r", false),
            ("abs(x)*y^2 + max(x, y) + min(x + 1, y)", false),
        ];
        let formulas = formulas
            .map(|(text, everywhere)| (text.to_owned(), AnyGap::from(&Formula::new(text).unwrap()), everywhere));
        let sphere = AnyGap::from(&Sphere::new(0.9).unwrap());
        let power = |exponent: f64| AnyGap::from(&Power::new(0.7, exponent).unwrap());
        let round = AnyGap::from(&Paraboloid::new([0.4, 0.7]).unwrap());
        let kinds = [
            ("sphere", sphere.clone(), true),
            ("cone", AnyGap::from(&Cone::with_slope(0.3).unwrap()), false),
            ("power 1.5", power(1.5), false),
            ("power 2", power(2.0), true),
            ("power 3.4", power(3.4), true),
            ("sum", AnyGap::new(Sum::new(vec![sphere, power(4.0), round]).unwrap()), true),
        ];
        let kinds = kinds.map(|(name, gap, everywhere)| (name.to_owned(), gap, everywhere));
        for (text, gap, everywhere) in formulas.into_iter().chain(kinds) {
            for gap in [gap.clone(), gap.placed([0.02, -0.05], 0.7).unwrap().tilted([0.1, -0.2])] {
                for (c, half) in RECTANGLES {
                    let rect = Rect::around(c, half);
                    let Some(cubic) = gap.cubic(&rect) else {
                        assert!(!everywhere, "{text} at {c:?}");
                        continue;
                    };
                    let parts = |v: [f64; 2]| cubic.moved(v);
                    let taylor = cubic.taylor(rect.size());
                    let [low, high] = taylor.bounds(rect.size(), [0.0; 2]);
                    let (mean, mut sum) = (cubic.mean(rect.size()), 0.0);
                    for [x, y] in points(c, half) {
                        let g = gap.gap(x, y);
                        sum += g / 400.0;
                        let room = 1e-13 * (1.0 + g.abs());
                        assert!(low - room <= g && g <= high + room, "{text} at {x} {y}");
                        let here = parts([x - c[0], y - c[1]]).middle;
                        assert!(here.value.lo - room <= g && g <= here.value.hi + room, "{text} at {x} {y}: {here:?}");
                        let own = gap.gradient(x, y).unwrap();
                        for m in 0..2 {
                            let [lo, hi] = [here.gradient[m].lo - 1e-12, here.gradient[m].hi + 1e-12];
                            assert!(lo <= own[m] && own[m] <= hi, "{text} at {x} {y}: {own:?} {here:?}");
                        }
                    }
                    // Midpoints miss of the mean h^2/24 of the second derivatives.
                    let missed =
                        (0..2).map(|m| taylor.hessian[2 * m].magnitude() * (half[m] / 10.0).powi(2) / 6.0).sum::<f64>();
                    assert!(mean.lo - missed <= sum && sum <= mean.hi + missed, "{text}: {mean:?} {sum}");
                }
                // Close to a point third derivatives are known as well as second ones are by differences.
                let at = [0.41, 0.33];
                let Some(cubic) = gap.cubic(&Rect::around(at, [1e-6; 2])) else { continue };
                let beside = |x: f64, y: f64| {
                    let taylor = gap.taylor(&Rect::around([at[0] + x, at[1] + y], [1e-9; 2])).unwrap();
                    taylor.hessian.map(Interval::middle)
                };
                let e = 1e-4;
                let (along, across) =
                    (beside(e, 0.0).into_iter().zip(beside(-e, 0.0)), beside(0.0, e).into_iter().zip(beside(0.0, -e)));
                let along: Vec<f64> = along.map(|(a, b)| (a - b) / (2.0 * e)).collect();
                let across: Vec<f64> = across.map(|(a, b)| (a - b) / (2.0 * e)).collect();
                let size = 1.0 + cubic.third.map(Interval::magnitude).into_iter().fold(0.0, f64::max);
                for (t, d) in cubic.third.iter().zip([along[0], along[1], along[2], across[2]]) {
                    assert!((t.middle() - d).abs() < 1e-4 * size, "{text}: {cubic:?} {along:?} {across:?}");
                }
                assert!((across[0] - along[1]).abs() < 1e-4 * size && (across[1] - along[2]).abs() < 1e-4 * size);
            }
        }
    }
}
