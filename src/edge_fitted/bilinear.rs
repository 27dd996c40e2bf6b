//! Functions that are bilinear in the coordinates of a cell.

use super::mesh::{Bilinear, Point};

/// The value at (s, t) of the bilinear function with these corner values.
#[inline(always)]
pub(crate) fn bilinear(c: &[f64; 4], s: f64, t: f64) -> f64 {
    0.25 * ((1.0 - t) * ((1.0 - s) * c[0] + (1.0 + s) * c[1]) + (1.0 + t) * ((1.0 - s) * c[3] + (1.0 + s) * c[2]))
}

/// Its values at the corners of a part.
pub(crate) fn restrict(c: &[f64; 4], range: &[[f64; 2]; 2]) -> [f64; 4] {
    let [s, t] = range;
    [bilinear(c, s[0], t[0]), bilinear(c, s[1], t[0]), bilinear(c, s[1], t[1]), bilinear(c, s[0], t[1])]
}

/// The derivatives along s and t of a bilinear function.
#[inline(always)]
pub(crate) fn derivatives(c: &[f64; 4], s: f64, t: f64) -> [f64; 2] {
    [
        0.25 * ((1.0 - t) * (c[1] - c[0]) + (1.0 + t) * (c[2] - c[3])),
        0.25 * ((1.0 - s) * (c[3] - c[0]) + (1.0 + s) * (c[2] - c[1])),
    ]
}

/// J grad of a bilinear function: bilinear too.
#[inline(always)]
pub(crate) fn weighted_gradient(map: &Bilinear, c: &[f64; 4], s: f64, t: f64) -> Point {
    let [ds, dt] = derivatives(c, s, t);
    let (xs, xt) = (map.ds(t), map.dt(s));
    [ds * xt[1] - dt * xs[1], -ds * xt[0] + dt * xs[0]]
}

/// The corners of the reference square.
pub(crate) const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// The range of each component of the gradient of a bilinear function: along the lines of the map it is a quotient of
/// linear functions, monotonic, so the extremes are at the corners. None where the map is singular at a corner.
pub(crate) fn gradient_range(map: &Bilinear, c: &[f64; 4]) -> Option<[[f64; 2]; 2]> {
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for [s, t] in CORNERS {
        let j = map.jacobian(s, t);
        let g = weighted_gradient(map, c, s, t);
        for k in 0..2 {
            let v = if g[k] == 0.0 { 0.0 } else { g[k] / j };
            if !v.is_finite() {
                return None;
            }
            range[k] = [range[k][0].min(v), range[k][1].max(v)];
        }
    }
    Some(range)
}
