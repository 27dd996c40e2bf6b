//! The integrand of (2) on one subcell (`residual_norm`), from interpolants and what they leave out.

use super::bilinear::{CORNERS, bilinear, gradient_range, weighted_gradient};
use super::gauss::{LOGARITHMIC_SLACK, Rule};
use super::mesh::{Bilinear, Point, dot, norm};

/// The two sums of (2), and the same sums of what interpolation leaves out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    pub alpha: f64,
    pub beta: f64,
    pub alpha_rest: f64,
    pub beta_rest: f64,
}

impl Sums {
    /// The bound of a(w, w), the least over c: l = c l0.
    pub fn bound(&self) -> f64 {
        if self.alpha == 0.0 && self.alpha_rest == 0.0 {
            return 0.0;
        }
        let c = ((self.beta + self.beta_rest) / (self.alpha + self.alpha_rest)).sqrt();
        let main = c * self.alpha + self.beta / c;
        let rest = c * self.alpha_rest + self.beta_rest / c;
        // The last factor covers the rounding of the sums.
        0.25 * (main.sqrt() + rest.sqrt()).powi(2) * (1.0 + 1e-11)
    }

    /// Adds `size` times other sums.
    pub fn add(&mut self, size: f64, other: &Self) {
        self.alpha += size * other.alpha;
        self.beta += size * other.beta;
        self.alpha_rest += size * other.alpha_rest;
        self.beta_rest += size * other.beta_rest;
    }
}

/// The interpolants on one subcell, ready to be squared.
pub(crate) struct Integrand<'a> {
    pub map: &'a Bilinear,
    /// f at the corners, and its slope.
    pub overlap: [f64; 4],
    pub slope: Point,
    pub decay: [f64; 4],
    pub rules: [&'static Rule; 2],
    pub count: [usize; 2],
    /// u and both slopes at the nodes, less their singular parts.
    pub nodal: &'a [[f64; 25]; 3],
    /// The factors of ln s and ln t that were taken off the slope, with the opposite sign.
    pub jumps: [[f64; 2]; 2],
    /// What slope and value leave out, mean squares.
    pub left_out: [f64; 2],
}

impl Integrand<'_> {
    /// The sums of (2) for chi (f - u), chi bilinear with these values at the corners.
    pub fn sums(&self, chi: &[f64; 4]) -> Sums {
        let Self { map, decay, count: [m, n], nodal, jumps, left_out: [slope_rest, value_rest], .. } = *self;
        let inverse = decay.map(|l| 1.0 / l);
        let steep = gradient_range(map, &decay)
            .map_or(f64::INFINITY, |g| g.iter().map(|c| c[0].abs().max(c[1].abs()).powi(2)).sum::<f64>());
        let (fade, fade_spread) = match gradient_range(map, chi) {
            Some(g) => (g.map(|c| 0.5 * (c[0] + c[1])), norm(g.map(|c| 0.5 * (c[1] - c[0])))),
            None => ([0.0; 2], f64::INFINITY),
        };
        let (mut alpha, mut beta, mut square) = (0.0, 0.0, 0.0);
        let [rs, rt] = self.rules;
        for (q, &t) in rt.points.iter().enumerate() {
            // Interpolants along the line t.
            let mut line = [[0.0; 5]; 3];
            for (row, values) in line.iter_mut().zip(nodal) {
                for (i, r) in row.iter_mut().enumerate().take(m) {
                    *r = (0..n).map(|j| rt.lagrange[q * n + j] * values[j * m + i]).sum();
                }
            }
            for (r, &s) in rs.points.iter().enumerate() {
                let basis = &rs.lagrange[r * m..(r + 1) * m];
                let at = |row: &[f64; 5]| basis.iter().zip(row).map(|(b, v)| b * v).sum::<f64>();
                let logs = [rs.logarithm[r], rt.logarithm[q]];
                let slope = [0, 1].map(|c| at(&line[1 + c]) - jumps[0][c] * logs[0] - jumps[1][c] * logs[1]);
                let rest = bilinear(&self.overlap, s, t) - at(&line[0]);
                let drest = [0, 1].map(|c| self.slope[c] - slope[c]);
                let c = bilinear(chi, s, t);
                let w = c * rest;
                let dw = [c * drest[0] + rest * fade[0], c * drest[1] + rest * fade[1]];
                let j = map.jacobian(s, t);
                let weight = rs.weights[r] * rt.weights[q];
                let jl = weighted_gradient(map, &decay, s, t);
                let inv = bilinear(&inverse, s, t);
                alpha += weight
                    * (j * bilinear(&decay, s, t) * dot(dw, dw) + w * dot(dw, jl) + 0.5 * j * w * w * steep * inv);
                beta += weight * j * w * w * inv;
                square += weight * j * rest * rest;
            }
        }
        let slack = if rs.logarithmic || rt.logarithmic { 1.0 + 2.5 * LOGARITHMIC_SLACK } else { 1.0 };
        // The parts left out.
        let area = 4.0 * CORNERS.iter().map(|c| map.jacobian(c[0], c[1])).fold(0.0, f64::max);
        let top = chi.iter().fold(0.0, |a: f64, b| a.max(*b));
        let mut e1 = (top * slope_rest + norm(fade) * value_rest) * area.sqrt();
        let e0 = top * value_rest * area.sqrt();
        if fade_spread > 0.0 {
            e1 += fade_spread * (square.sqrt() + value_rest * area.sqrt());
        }
        let (low, high) =
            (decay.iter().fold(f64::INFINITY, |a, b| a.min(*b)), decay.iter().fold(0.0, |a: f64, b| a.max(*b)));
        Sums {
            alpha: slack * alpha,
            beta: slack * beta,
            alpha_rest: (high.sqrt() * e1 + (0.5 * steep / low).sqrt() * e0).powi(2),
            beta_rest: e0 * e0 / low,
        }
    }
}
