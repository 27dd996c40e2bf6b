//! The stationary boundary: G_a(a(theta), theta) = D for every theta (equation 15).
//!
//! D need not be searched for. At a stationary point of P(A) = 2E* N/L, with N the integral of G and L that of a, the
//! constant is the quotient itself, D = N/L = P/(2E*). That makes the method Dinkelbach's algorithm for a quotient: given
//! D, solve for a(theta) ray by ray; set D to N/L; it converges quadratically, from below.
//!
//! Of the roots of G_a = D the one wanted has G_aa < 0 and is connected to the axisymmetric solution: the outer side of
//! the hump of G_a along the ray. The second variation of P is (2E*/L) int G_aa (da)^2, so there it is a strict local
//! maximum. (The global maximum is meaningless: a sliver along one direction.) When D exceeds the top of the hump on some
//! ray there is no stationary boundary; since N/L of any boundary on the branch is at most the D sought, that is a proof
//! up to the quadrature, and the verdict names the ray.
//!
//! Departures from the paper: D by the quotient, not by a search for the largest P; the centre, which the flat-punch
//! pressure wants at the centroid of the region, is moved until it is.

use nalgebra::{Matrix2, Vector2};

use crate::error::{Unsolved, Verdict};
use crate::fabrikant::star::{Ray, Star, radius_in};

/// Sweeps over all rays before giving up.
const MOST_SWEEPS: usize = 80;
/// Sweeps after which a ray that has not settled is solved by itself, safely.
const PATIENT_SWEEPS: usize = 12;
/// Moves of the centre before giving up.
const MOST_MOVES: usize = 40;

/// What the sweeps found on the present layout.
pub(crate) struct Found {
    /// D = N/L.
    pub d: f64,
    /// Largest |G_a - D|/D over the rays that are free.
    pub residual: f64,
    /// The ray on which D lies closest to the top of the hump, and by how much: top/D - 1.
    pub tightest: (f64, f64),
}

/// G_a along a ray as 2 f0 x - C x^m, which is exact for gaps that are homogeneous about the centre: T = C a^m and m from
/// G_a and G_aa at a.
#[derive(Clone, Copy)]
struct Hump {
    a: f64,
    linear: f64,
    t: f64,
    m: f64,
    /// Top of the hump: place (in units of a) and height.
    top: [f64; 2],
}

impl Hump {
    fn through(ray: &Ray, f0: f64) -> Option<Self> {
        let (a, linear) = (ray.a, 2.0 * f0 * ray.a);
        let t = linear - ray.along.g_a;
        let m = (linear - ray.along.g_aa * a) / t;
        if !(t > 1e-14 * linear && m > 1.02 && m < 1e4) {
            return None;
        }
        let y = if (m - 2.0).abs() < 1e-9 { 0.5 * linear / t } else { (linear / (m * t)).powf(1.0 / (m - 1.0)) };
        Some(Self { a, linear, t, m, top: [y, linear * y * (1.0 - 1.0 / m)] })
    }

    /// The outer root of the model, in units of a; `None` when D lies above the hump.
    fn root(&self, d: f64) -> Option<f64> {
        let Self { linear, t, m, .. } = *self;
        if d > self.top[1] {
            return None;
        }
        if (m - 2.0).abs() < 1e-9 {
            let half = 0.5 * linear;
            return Some((half + (half * half - t * d).max(0.0).sqrt()) / t);
        }
        // From the root for D = 0 Newton comes down monotonically: the model is concave there.
        let mut y = self.top[0] * m.powf(1.0 / (m - 1.0));
        for _ in 0..60 {
            let power = t * y.powf(m - 1.0);
            let step = (y * (linear - power) - d) / (linear - m * power);
            y -= step;
            if !(step > 1e-15 * y) {
                break;
            }
        }
        Some(y.max(self.top[0]))
    }

    /// G at y a, less G at a.
    fn gain(&self, y: f64) -> f64 {
        self.a * (0.5 * self.linear * (y * y - 1.0) - self.t * (y.powf(self.m + 1.0) - 1.0) / (self.m + 1.0))
    }

    fn gain_conical(&self, y: f64) -> f64 {
        if (self.m - 2.0).abs() < 1e-9 {
            self.a * (0.5 * self.linear * (y * y - 1.0) - self.t * (y * y * y - 1.0) / 3.0)
        } else {
            self.gain(y)
        }
    }
}

impl Star<'_> {
    /// Dinkelbach's algorithm on the present layout and centre.
    pub(crate) fn settle(&mut self, residual_allowed: f64) -> Result<Found, Unsolved> {
        let mut d = 0.0f64;
        for sweep in 0..MOST_SWEEPS {
            self.measure_all();
            let quotient = self.quotient();
            if quotient.is_finite() {
                d = quotient;
            }
            let found = self.judge(d);
            if sweep > 0 && found.residual <= residual_allowed && d > 0.0 && self.on_material() {
                return Ok(found);
            }
            let aim = self.aim(if sweep == 0 { 0.0 } else { d.max(0.0) });
            let bound = if sweep == 0 { 1e3 } else { 4.0 };
            for k in 0..self.rays.len() {
                let ray = self.rays[k];
                if sweep > PATIENT_SWEEPS {
                    if (ray.along.g_a - d).abs() > 0.1 * residual_allowed * d {
                        self.rays[k] = self.solve_ray(ray, d);
                    }
                    continue;
                }
                let y = match Hump::through(&ray, self.f0) {
                    Some(hump) => hump.root(aim).unwrap_or(hump.top[0]),
                    // No hump in sight: outwards, until it comes or the material ends.
                    None if ray.along.g_aa >= 0.0 || ray.along.g_a > d => 2.0,
                    None => 0.7,
                };
                self.rays[k].a = (ray.a * y.clamp(1.0 / bound, bound)).min(ray.limit);
                if self.rays[k].a > 1e15 {
                    return Err(self.endless(&ray));
                }
            }
        }
        Err(Unsolved::new(Verdict::IterationLimit, format!("the boundary did not settle in {MOST_SWEEPS} sweeps")))
    }

    /// The D that the models of all rays together lead to: Dinkelbach without evaluating the gap.
    fn aim(&self, start: f64) -> f64 {
        let mut d = start;
        for _ in 0..30 {
            let (mut n, mut l) = (0.0, 0.0);
            for ray in &self.rays {
                let (a, gain) = match Hump::through(ray, self.f0) {
                    Some(hump) => {
                        let y = hump.root(d).unwrap_or(hump.top[0]).min(ray.limit / ray.a);
                        (ray.a * y, hump.gain_conical(y))
                    }
                    None => (ray.a, 0.0),
                };
                n += ray.spoke.fine * (ray.along.g + gain);
                l += ray.spoke.fine * a;
            }
            let next = (n / l).max(0.0);
            let done = (next - d).abs() <= 1e-14 * next;
            d = next;
            if done {
                break;
            }
        }
        d
    }

    fn endless(&self, ray: &Ray) -> Unsolved {
        let degrees = ray.spoke.angle.to_degrees();
        Unsolved::new(Verdict::Unbounded, format!("the contact does not end in the direction of {degrees:.4} degrees"))
    }

    /// How well G_a = D holds, and where the hump is lowest.
    fn judge(&self, d: f64) -> Found {
        let mut found = Found { d, residual: 0.0, tightest: (0.0, f64::INFINITY) };
        for ray in &self.rays {
            let off = ray.along.g_a - d;
            if ray.at_edge() && off >= 0.0 {
                continue;
            }
            if ray.stuck && off < 0.0 {
                if off / d < found.tightest.1 {
                    found.tightest = (ray.spoke.angle, off / d);
                }
                continue;
            }
            let margin = self.margin(ray, d);
            if margin < found.tightest.1 {
                found.tightest = (ray.spoke.angle, margin);
            }
            // On top of a hump that is too low, G_aa = 0 is all there is to settle.
            let residual = if margin < 0.0 && off < 0.0 { ray.along.g_aa * ray.a } else { off };
            found.residual = found.residual.max(residual.abs() / d);
        }
        found
    }

    /// Top of the hump of G_a on this ray, over D, less one.
    fn margin(&self, ray: &Ray, d: f64) -> f64 {
        match Hump::through(ray, self.f0) {
            _ if ray.stuck => ray.along.g_a / d - 1.0,
            Some(hump) => hump.top[1].max(if ray.along.g_aa <= 0.0 { ray.along.g_a } else { f64::MIN }) / d - 1.0,
            None => f64::INFINITY,
        }
    }

    /// The outer root of G_a = D on one ray by Newton within a bracket, or the top of the hump when D lies above it.
    pub(crate) fn solve_ray(&self, ray: Ray, d: f64) -> Ray {
        // A point belongs to the outer side of the root when G_a is below D and falling.
        let (mut lo, mut hi) = (0.0, f64::INFINITY);
        let mut ray = self.measure(ray);
        ray.stuck = false;
        for _ in 0..200 {
            let along = ray.along;
            if ray.at_edge() && along.g_a >= d {
                return ray;
            }
            if along.g_aa < 0.0 && along.g_a < d {
                hi = ray.a;
            } else {
                lo = ray.a;
            }
            if along.g_aa < 0.0 && (along.g_a - d).abs() <= 1e-15 * d {
                return ray;
            }
            let newton = ray.a - (along.g_a - d) / along.g_aa;
            let next = if along.g_aa < 0.0 && newton > lo && newton < hi && newton < 2.0 * ray.a {
                newton
            } else if hi.is_finite() {
                0.5 * (lo + hi)
            } else {
                2.0 * lo
            };
            if (next - ray.a).abs() <= 4.0 * f64::EPSILON * ray.a
                || (hi.is_finite() && hi - lo <= 4.0 * f64::EPSILON * hi)
            {
                // The bracket has closed on the top of a hump (smooth, or the point of a kink) that is too low.
                ray.stuck = along.g_a < d * (1.0 - 1e-9);
                return ray;
            }
            ray.a = next;
            ray = self.measure(ray);
        }
        ray
    }

    /// Moves the centre to the centroid of the settled region until the two agree (Broyden's method; the step that the
    /// plain iteration takes is right to a fifth for a paraboloid, whose region moves back by 3 pi/8 of the shift).
    /// Returns the number of moves.
    pub(crate) fn centre(
        &mut self,
        allowed: f64,
        mut settle: impl FnMut(&mut Self) -> Result<Found, Unsolved>,
    ) -> Result<(Found, usize), Unsolved> {
        let mut inverse = Matrix2::identity() * (8.0 / (3.0 * std::f64::consts::PI));
        let mut last: Option<(Vector2<f64>, Vector2<f64>)> = None;
        for moves in 0..MOST_MOVES {
            let found = settle(self)?;
            let (off, area) = self.centroid_and_area();
            let off = Vector2::from(off);
            let size = area.sqrt();
            if off.norm() <= allowed * size || (moves + 1 == MOST_MOVES && found.tightest.1 < -1e-9) {
                return Ok((found, moves));
            }
            if let Some((step, previous)) = last {
                // Good Broyden on off(c) = 0, kept while it helps.
                let change = previous - off;
                let image = inverse * change;
                let scale = step.dot(&image);
                if scale.abs() > 0.05 * step.norm_squared() {
                    inverse += (step - image) * (step.transpose() * inverse) / scale;
                }
            }
            let mut step = inverse * off;
            if step.norm() > 0.5 * size {
                step *= 0.5 * size / step.norm();
            }
            last = Some((step, off));
            let centre = Vector2::from(self.centre) + step;
            self.move_to(centre.into());
            if !(self.f0 > 0.0) {
                return Err(Unsolved::new(
                    Verdict::NotStarShaped,
                    "the centroid of the region lies where the bodies do not overlap: the contact is not one star-shaped patch",
                ));
            }
        }
        Err(Unsolved::new(
            Verdict::IterationLimit,
            format!("the centre did not reach the centroid in {MOST_MOVES} moves"),
        ))
    }

    /// The tightest direction, also between the rays: where the margins of neighbours point to a lower one in between,
    /// it is computed. Returns (angle, margin).
    pub(crate) fn tightest(&mut self, d: f64) -> (f64, f64) {
        let n = self.rays.len();
        let free = |r: &Ray| !(r.at_edge() && r.along.g_a >= d);
        let margins: Vec<f64> =
            self.rays.iter().map(|r| if free(r) { self.margin(r, d) } else { f64::INFINITY }).collect();
        let mut best = (0.0, f64::INFINITY);
        for k in 0..n {
            let (before, after) = ((k + n - 1) % n, (k + 1) % n);
            if margins[k] < best.1 {
                best = (self.rays[k].spoke.angle, margins[k]);
            }
            let [m0, m1, m2] = [margins[before], margins[k], margins[after]];
            if !(m1 <= m0 && m1 <= m2 && m0.is_finite() && m2.is_finite()) {
                continue;
            }
            let turn = |from: usize, to: usize| {
                (self.rays[to].spoke.angle - self.rays[from].spoke.angle).rem_euclid(std::f64::consts::TAU)
            };
            let (h0, h2) = (turn(before, k), turn(k, after));
            let (s0, s2) = ((m1 - m0) / h0, (m2 - m1) / h2);
            let bend = (s2 - s0) / (h0 + h2);
            let slope = (s0 * h2 + s2 * h0) / (h0 + h2);
            let shift = if bend > 0.0 { (-0.5 * slope / bend).clamp(-h0, h2) } else { 0.0 };
            let drop = 0.25 * slope * slope / bend;
            if bend > 0.0 && drop > 1e-3 * m1.abs() && m1 - 4.0 * drop < best.1 {
                let angle = self.rays[k].spoke.angle + shift;
                let ray = self.extra_ray(angle, self.rays[k].a);
                let ray = self.solve_ray(ray, d);
                let margin = self.margin(&ray, d);
                if margin < best.1 {
                    best = (angle, margin);
                }
            }
        }
        best
    }

    /// The boundary at `count` equal angles besides the rays of the rule, each solved.
    pub(crate) fn trace(&mut self, count: usize, d: f64) -> Vec<[f64; 2]> {
        let outline = self.outline();
        let mut all = outline.clone();
        for k in 0..count {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            let ray = self.extra_ray(angle, radius_in(&outline, angle));
            all.push([angle, self.solve_ray(ray, d).a]);
        }
        all.sort_by(|p, q| p[0].total_cmp(&q[0]));
        all.dedup_by(|b, a| b[0] - a[0] < 1e-12);
        all
    }
}
