//! The integrand of (2) on one subcell (`residual_norm`), from interpolants and what they leave out.

use super::bilinear::{CORNERS, bilinear, gradient_range, weighted_gradient};
use super::gauss::{LANES, LOGARITHMIC_SLACK, NODES, Rule};
use super::mesh::{Bilinear, Point, norm};
use crate::numeric::simd::{Kernel, vectorised};

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

/// f and the interpolant of u on one subcell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interpolant {
    /// f at the corners, and its slope.
    pub overlap: [f64; 4],
    pub slope: Point,
    /// u and both slopes at the nodes, less their singular parts.
    pub nodal: [[f64; 25]; 3],
    /// The factors of ln s and ln t that were taken off the slope, with the opposite sign.
    pub jumps: [[f64; 2]; 2],
}

impl Interpolant {
    /// Of the sum of two residuals.
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |a: &[f64; 2], b: &[f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            overlap: std::array::from_fn(|i| self.overlap[i] + other.overlap[i]),
            slope: sum(&self.slope, &other.slope),
            nodal: std::array::from_fn(|q| std::array::from_fn(|i| self.nodal[q][i] + other.nodal[q][i])),
            jumps: std::array::from_fn(|k| sum(&self.jumps[k], &other.jumps[k])),
        }
    }
}

/// The interpolants on one subcell, ready to be squared.
pub(crate) struct Integrand<'a> {
    pub map: &'a Bilinear,
    pub interpolant: &'a Interpolant,
    pub decay: [f64; 4],
    pub rules: [&'static Rule; 2],
    pub count: [usize; 2],
    /// What slope and value leave out, mean squares.
    pub left_out: [f64; 2],
}

impl Integrand<'_> {
    /// The sums of (2) for chi (f - u), chi bilinear with these values at the corners.
    pub fn sums(&self, chi: &[f64; 4]) -> Sums {
        let Self { map, decay, left_out: [slope_rest, value_rest], .. } = *self;
        let steep = gradient_range(map, &decay)
            .map_or(f64::INFINITY, |g| g.iter().map(|c| c[0].abs().max(c[1].abs()).powi(2)).sum::<f64>());
        let (fade, fade_spread) = match gradient_range(map, chi) {
            Some(g) => (g.map(|c| 0.5 * (c[0] + c[1])), norm(g.map(|c| 0.5 * (c[1] - c[0])))),
            None => ([0.0; 2], f64::INFINITY),
        };
        let Squares { alpha, beta, square } = vectorised(Sum { integrand: self, chi, fade, steep });
        let [rs, rt] = self.rules;
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

/// Sums over the points of the rules: the two of (2), and that of the square of f - u.
struct Squares {
    alpha: f64,
    beta: f64,
    square: f64,
}

struct Sum<'a> {
    integrand: &'a Integrand<'a>,
    chi: &'a [f64; 4],
    /// The gradient of chi, in the middle of its range.
    fade: Point,
    /// |grad l0|^2 at most.
    steep: f64,
}

impl Kernel for Sum<'_> {
    type Output = Squares;

    #[inline(always)]
    fn run(self) -> Squares {
        let Self { chi, fade, steep, .. } = self;
        let Integrand { map, interpolant, ref decay, rules: [rs, rt], count: [m, n], .. } = *self.integrand;
        let Interpolant { overlap, slope, nodal, jumps } = interpolant;
        let inverse = decay.map(|l| 1.0 / l);
        let (mut alpha, mut beta, mut square) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for row in &rt.lanes {
            for q in (0..LANES).filter(|&q| row.weights[q] > 0.0) {
                let (t, log_t, weight_t) = (row.points[q], row.logarithm[q], row.weights[q]);
                // Interpolants along the line t.
                let mut line = [[0.0; NODES[1]]; 3];
                for (out, values) in line.iter_mut().zip(nodal) {
                    for (j, basis) in row.lagrange.iter().enumerate().take(n) {
                        for (i, r) in out.iter_mut().enumerate().take(m) {
                            *r += basis[q] * values[j * m + i];
                        }
                    }
                }
                let [u, ux, uy] = &line;
                for some in &rs.lanes {
                    for l in 0..LANES {
                        let s = some.points[l];
                        let at = |row: &[f64; NODES[1]]| {
                            let b = &some.lagrange;
                            b[0][l] * row[0] + b[1][l] * row[1] + b[2][l] * row[2] + b[3][l] * row[3] + b[4][l] * row[4]
                        };
                        let logs = [some.logarithm[l], log_t];
                        let du = [
                            at(ux) - jumps[0][0] * logs[0] - jumps[1][0] * logs[1],
                            at(uy) - jumps[0][1] * logs[0] - jumps[1][1] * logs[1],
                        ];
                        let rest = bilinear(overlap, s, t) - at(u);
                        let c = bilinear(chi, s, t);
                        let w = c * rest;
                        let dw = [c * (slope[0] - du[0]) + rest * fade[0], c * (slope[1] - du[1]) + rest * fade[1]];
                        let j = map.jacobian(s, t);
                        let weight = some.weights[l] * weight_t;
                        let jl = weighted_gradient(map, decay, s, t);
                        let inv = bilinear(&inverse, s, t);
                        let squares = dw[0] * dw[0] + dw[1] * dw[1];
                        let cross = w * (dw[0] * jl[0] + dw[1] * jl[1]);
                        alpha[l] +=
                            weight * (j * bilinear(decay, s, t) * squares + cross + 0.5 * j * w * w * steep * inv);
                        beta[l] += weight * j * w * w * inv;
                        square[l] += weight * j * rest * rest;
                    }
                }
            }
        }
        let [alpha, beta, square] = [alpha, beta, square].map(|lanes| lanes.iter().sum());
        Squares { alpha, beta, square }
    }
}
