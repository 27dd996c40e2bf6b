//! Gaps that are smooth functions of the distance from the origin: bounds, Taylor form and growth from those of one variable.

use super::{Axis, Cubic, Generatrix, Growth, Known, Material, Reach, Taylor};
use crate::numeric::Interval;
use crate::numeric::geometry::Rect;

/// Room for the rounding of a radius.
const ROUNDING: f64 = 1.0 + 1e-14;

/// A radius beyond the range of numbers is none.
pub(super) fn disc(radius: f64) -> Reach {
    if radius == f64::INFINITY {
        Reach::Unbounded { from: [0.0; 2], along: 0.0 }
    } else if radius > 0.0 {
        Reach::Within(Rect::around([0.0; 2], [radius * ROUNDING; 2]))
    } else {
        Reach::Nowhere
    }
}

/// What bodies of revolution about the origin that rise from 0 there have in common.
pub(super) fn rising(generatrix: Generatrix) -> Known {
    Known {
        floor: 0.0,
        axis: Some(Axis { at: [0.0; 2], generatrix }),
        material: Material::Everywhere,
        mirrors: [true; 2],
        ..Known::nothing()
    }
}

/// The sides of a rectangle as intervals.
pub(super) fn sides(rect: &Rect) -> [Interval; 2] {
    [0, 1].map(|m| Interval::new(rect.min[m], rect.max[m]))
}

/// Distances of the points of a rectangle from the origin.
pub(super) fn distances(rect: &Rect) -> Interval {
    let [x, y] = sides(rect);
    x.hypot(y)
}

/// A function of r over a set of radii.
pub(super) struct Profile {
    /// g.
    pub value: Interval,
    /// g'/r.
    pub slope_over_r: Interval,
    /// g''.
    pub curvature: Interval,
}

/// The Taylor form over a rectangle of g(r), given as a function of a set of radii.
pub(super) fn taylor(rect: &Rect, g: impl Fn(Interval) -> Profile) -> Option<Taylor> {
    let c = rect.centre().map(Interval::point);
    let (here, all) = (g(c[0].hypot(c[1])), g(distances(rect)));
    let [x, y] = sides(rect);
    // H = q I + (g'' - q) n n', q = g'/r, n the unit vector outwards.
    let r2 = x.powi(2) + y.powi(2);
    let unit = Interval::new(0.0, 1.0);
    let share = |product: Interval, least: f64| {
        let quotient = if r2.hi > 0.0 { product / r2 } else { Interval::UNKNOWN };
        Interval { lo: quotient.lo.max(least), hi: quotient.hi.min(1.0), defined: true }
    };
    let (q, d) = (all.slope_over_r, all.curvature - all.slope_over_r);
    let (nxx, nyy) = (share(x.powi(2), 0.0), share(y.powi(2), 0.0));
    let nxy = if r2.lo > 0.0 { share(x * y, -1.0) } else { unit * Interval::new(-0.5, 0.5) };
    let nxy = Interval { lo: nxy.lo.max(-0.5), hi: nxy.hi.min(0.5), defined: true };
    Taylor {
        value: here.value,
        gradient: c.map(|c| here.slope_over_r * c),
        hessian: [q + d * nxx, d * nxy, q + d * nyy],
    }
    .finite()
}

/// The same to third order, with g''' and s = (g'' - g'/r)/r over a set of radii. The third derivatives are
///
/// ```text
/// s (n_i d_jk + n_j d_ik + n_k d_ij - 3 n_i n_j n_k) + g''' n_i n_j n_k,     d_ij = 1 for i = j, else 0.
/// ```
pub(super) fn cubic(
    rect: &Rect,
    g: impl Fn(Interval) -> Profile,
    thirds: impl Fn(Interval) -> [Interval; 2],
) -> Option<Cubic> {
    let c = rect.centre();
    let middle = taylor(&Rect { min: c, max: c }, g)?;
    let r = distances(rect);
    let [along, across] = thirds(r);
    let [x, y] = sides(rect).map(|v| share(v, r));
    let (one, three) = (Interval::point(1.0), Interval::point(3.0));
    // n_x (3 s (1 - n_x^2) + g''' n_x^2), n_y (s (1 - 3 n_x^2) + g''' n_x^2) and so on.
    let alone = |n: Interval| n * (across * three * (one - n.powi(2)) + along * n.powi(2));
    let mixed = |n: Interval, m: Interval| m * (across * (one - three * n.powi(2)) + along * n.powi(2));
    Cubic { middle, third: [alone(x), mixed(x, y), mixed(y, x), alone(y)] }.finite()
}

/// x/r: between -1 and 1, on one side of 0 where x is.
fn share(x: Interval, r: Interval) -> Interval {
    let quotient = if r.lo > 0.0 { x / r } else { Interval::new(-1.0, 1.0) };
    let (low, high) = (if x.lo >= 0.0 { 0.0 } else { -1.0 }, if x.hi <= 0.0 { 0.0 } else { 1.0 });
    Interval { lo: quotient.lo.max(low), hi: quotient.hi.min(high), defined: true }
}

/// Bounds of the slopes of g(r) over a rectangle, from those of g'(r).
pub(super) fn slopes(rect: &Rect, slope: Interval) -> Option<[Interval; 2]> {
    let (sides, r) = (sides(rect), distances(rect));
    let finite = slope.defined && slope.lo.is_finite() && slope.hi.is_finite();
    finite.then(|| sides.map(|x| slope * share(x, r)))
}

/// Bounds of g - slope . (x - c) over a rectangle: from the Taylor form where there is one, and from the values of g(r).
pub(super) fn bounds(
    rect: &Rect,
    slope: [f64; 2],
    value: Interval,
    taylor: impl FnOnce() -> Option<Taylor>,
) -> [f64; 2] {
    let [w, h] = rect.size();
    let half = (0.5 * (slope[0].abs() * w + slope[1].abs() * h)).next_up();
    let high = if value.defined { value.hi + half } else { f64::INFINITY };
    let low = if value.is_empty() { f64::INFINITY } else { value.lo - half };
    // The values of a rising g(r) themselves are as close as can be.
    if slope == [0.0; 2] {
        return [low, high];
    }
    match taylor().map(|t| t.bounds([w, h], slope)) {
        Some([a, b]) => [low.max(a), high.min(b)],
        None => [low, high],
    }
}

/// c r^n, whatever the sector.
pub(super) fn power(coefficient: f64, exponent: f64, from: f64) -> Growth {
    Growth::power(exponent, Interval::point(coefficient), from)
}
