//! Love's potential of a uniformly loaded cell and its slopes, at the points of a tensor lattice.
//!
//! With F(u, v) = u asinh(v/|u|) + v asinh(u/|v|) the displacement by unit pressure on a rectangle, E* = 1, is 1/pi times the
//! second difference of F over its corners (Love, Phil. Trans. R. Soc. A 228 (1929) 377); F_u = asinh(v/|u|).

use std::f64::consts::FRAC_1_PI;

/// F, F_u and F_v for u of one list and v of another, u fastest.
pub(super) struct Corners {
    width: usize,
    values: Vec<[f64; 3]>,
}

impl Corners {
    pub fn new(u: &[f64], v: &[f64]) -> Self {
        let values = v.iter().flat_map(|&v| u.iter().map(move |&u| corner(u, v))).collect();
        Self { width: u.len(), values }
    }

    /// Second difference over u[a0], u[a1], v[b0], v[b1]: displacement, and its slopes along x and y.
    pub fn cell(&self, [a0, a1]: [usize; 2], [b0, b1]: [usize; 2]) -> [f64; 3] {
        let at = |a: usize, b: usize| &self.values[b * self.width + a];
        let (p, q, r, s) = (at(a1, b1), at(a0, b1), at(a1, b0), at(a0, b0));
        [0, 1, 2].map(|k| FRAC_1_PI * ((p[k] - q[k]) - (r[k] - s[k])))
    }
}

/// F and its slopes; a slope that is infinite is given as 0, where no rule has a point.
fn corner(u: f64, v: f64) -> [f64; 3] {
    let r = (u * u + v * v).sqrt();
    // asinh(v/|u|) = sign(v) ln((|v| + r)/|u|).
    let asinh = |v: f64, u: f64| {
        if u == 0.0 || v == 0.0 { 0.0 } else { ((v.abs() + r) / u.abs()).ln().copysign(v) }
    };
    let (along, across) = (asinh(v, u), asinh(u, v));
    [u * along + v * across, along, across]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_corner_of_a_square_are_those_of_love() {
        let c = Corners::new(&[-0.5, 0.5], &[-0.5, 0.5]).cell([0, 1], [0, 1]);
        assert!((c[0] - 4.0 * FRAC_1_PI * 1f64.asinh()).abs() < 1e-15 && c[1].abs() < 1e-15);
        let c = Corners::new(&[0.0, 1.0], &[0.0, 1.0]).cell([0, 1], [0, 1]);
        assert!((c[0] - 2.0 * FRAC_1_PI * 1f64.asinh()).abs() < 1e-15);
    }

    #[test]
    fn slopes_are_those_of_the_displacement() {
        let (a, b, e) = (0.4, 0.7, 1e-5);
        let at = |x: f64, y: f64| Corners::new(&[x - a, x + a], &[y - b, y + b]).cell([0, 1], [0, 1]);
        for (x, y) in [(0.1, 0.2), (0.9, -0.3), (-2.0, 1.1), (0.35, 0.9)] {
            let slope =
                [(at(x + e, y)[0] - at(x - e, y)[0]) / (2.0 * e), (at(x, y + e)[0] - at(x, y - e)[0]) / (2.0 * e)];
            let exact = at(x, y);
            assert!((slope[0] - exact[1]).abs() < 1e-8 && (slope[1] - exact[2]).abs() < 1e-8);
        }
    }
}
