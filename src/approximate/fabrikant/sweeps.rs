//! Dinkelbach's algorithm on one layout of rays: D from the boundary, the boundary from D.

use std::f64::consts::TAU;

use super::power_law_model::PowerLawModel;
use super::ray_fan::{CHECKED, Ray, RayFan, radius_in};
use crate::solution::{Unsolved, Verdict};

/// Sweeps over all rays before giving up.
const MOST_SWEEPS: usize = 80;
/// Sweeps after which a ray that has not converged is solved by itself, with a bracket.
const PATIENT_SWEEPS: usize = 12;

/// Share of D by which the largest G_a is too low for rounding to explain.
pub(crate) const LOW: f64 = 1e-3;

/// What the sweeps found on the present layout.
pub(crate) struct Found {
    /// D = N/L.
    pub d: f64,
    /// Largest |G_a - D|/D over the rays that are free.
    pub residual: f64,
    /// The ray on which D is closest to the largest G_a, and the margin: largest/D - 1.
    pub tightest: (f64, f64),
}

impl RayFan<'_> {
    /// Dinkelbach's algorithm on the present layout and centre.
    pub(crate) fn iterate(&mut self, residual_allowed: f64) -> Result<Found, Unsolved> {
        let mut d = 0.0f64;
        for sweep in 0..MOST_SWEEPS {
            self.measure_all();
            let quotient = self.quotient();
            let change = ((quotient - d) / quotient).abs();
            if quotient > 0.0 && quotient.is_finite() {
                d = quotient;
            } else {
                // Much too far out: D > 0 brings the boundary back.
                d *= 0.5;
            }
            // Roots for a D that is still to move need not be closer than that.
            let within = (0.01 * change).clamp(0.01 * residual_allowed, 1e-3);
            let found = self.residuals(d);
            if sweep > 0 && found.residual <= residual_allowed && d > 0.0 && self.on_material() {
                return Ok(found);
            }
            if let Some(spent) = self.out_of_budget() {
                return self.not_converged(found, &format!("{spent} evaluations of the gap"));
            }
            let aim = self.next_quotient(if sweep == 0 { 0.0 } else { d.max(0.0) });
            let bound = if sweep == 0 { 1e3 } else { 4.0 };
            for k in 0..self.rays.len() {
                if k % CHECKED == 0 && self.overlap.deadline.has_passed() {
                    break;
                }
                let ray = self.rays[k];
                let y = match PowerLawModel::through(&ray, self.f0) {
                    Some(hump) => hump.root(aim).unwrap_or(hump.top[0]),
                    // The model has no maximum: outwards, until it has one or the material ends.
                    None if ray.along.g_aa >= 0.0 || ray.along.g_a > d => 2.0,
                    None => 0.7,
                };
                let next = (ray.a * y.max(1.0 / bound).min(bound)).min(ray.limit);
                let kinked = self.line(&ray).kinks.first().is_some_and(|&kink| kink < next.max(ray.a));
                if (kinked && d > 0.0) || sweep > PATIENT_SWEEPS {
                    if (ray.along.g_a - d).abs() > 0.1 * residual_allowed * d {
                        self.rays[k] = self.outer_root(ray, d, within);
                    }
                    self.rays[k].measured = true;
                } else {
                    self.rays[k].a = next;
                }
                if self.rays[k].a > 1e15 {
                    return Err(self.endless(&ray));
                }
            }
        }
        let found = self.residuals(d);
        self.not_converged(found, &format!("{MOST_SWEEPS} sweeps"))
    }

    /// The verdict when the boundary has not converged: that the largest G_a is too low on some ray, if it is; else how far
    /// equation (15) is from holding.
    fn not_converged(&self, found: Found, after: &str) -> Result<Found, Unsolved> {
        if found.tightest.1 < -LOW {
            return Ok(found);
        }
        let off = |r: &Ray| if r.at_edge() { 0.0 } else { (r.along.g_a - found.d).abs() };
        let worst = self.rays.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
        let reason = format!(
            "the boundary has not settled after {after}: G_a (equation 15) is still {:.2e} of D off in the direction of {:.4} degrees",
            worst.map_or(f64::NAN, off) / found.d,
            worst.map_or(f64::NAN, |r| r.node.angle.to_degrees().rem_euclid(360.0)),
        );
        Err(Unsolved::new(Verdict::IterationLimit, reason))
    }

    /// The D that the models of all rays together lead to: Dinkelbach without evaluating the gap. (Without it a 2:1 paraboloid takes
    /// 1.33 times the instructions, a quartic formula 1.07 times.)
    fn next_quotient(&self, start: f64) -> f64 {
        let mut d = start;
        for _ in 0..30 {
            let (mut n, mut l) = (0.0, 0.0_f64);
            for ray in &self.rays {
                let (a, gain) = match PowerLawModel::through(ray, self.f0).filter(|_| ray.position.inner == 0) {
                    Some(hump) => {
                        let y = hump.root(d).unwrap_or(hump.top[0]).min(ray.limit / ray.a);
                        (ray.a * y, hump.gain(y))
                    }
                    None => (ray.a, 0.0),
                };
                n += ray.node.fine * (ray.along.g + gain);
                l += ray.node.fine * a;
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
        let degrees = ray.node.angle.to_degrees().rem_euclid(360.0);
        Unsolved::new(Verdict::Unbounded, format!("the contact does not end in the direction of {degrees:.4} degrees"))
    }

    /// How well G_a = D holds, and the ray with the lowest maximum of G_a.
    fn residuals(&self, d: f64) -> Found {
        let mut found = Found { d, residual: 0.0, tightest: (0.0, f64::INFINITY) };
        for ray in &self.rays {
            let off = ray.along.g_a - d;
            if ray.at_edge() && off >= 0.0 {
                continue;
            }
            if ray.stuck && off < 0.0 {
                let margin = self.margin(ray, d);
                if margin < found.tightest.1 {
                    found.tightest = (ray.node.angle, margin);
                }
                // Higher elsewhere on the ray: the search has found another maximum.
                if margin > 0.0 {
                    found.residual = found.residual.max(off.abs() / d);
                }
                continue;
            }
            // Beyond a kink the maximum is worth its evaluations only once the boundary is found.
            let margin = if ray.position.inner > 0 { f64::INFINITY } else { self.margin(ray, d) };
            if margin < found.tightest.1 {
                found.tightest = (ray.node.angle, margin);
            }
            // At a maximum that is too low, the equation is G_aa = 0.
            let residual = if margin < 0.0 && off < 0.0 { ray.along.g_aa * ray.a } else { off };
            found.residual = found.residual.max(residual.abs() / d);
        }
        found
    }

    /// The largest G_a on this ray over D, less one.
    fn margin(&self, ray: &Ray, d: f64) -> f64 {
        match PowerLawModel::through(ray, self.f0) {
            _ if ray.stuck => ray.along.g_a / d - 1.0,
            _ if ray.position.inner > 0 => self.highest_seen(ray, d) / d - 1.0,
            Some(hump) => hump.top[1].max(if ray.along.g_aa <= 0.0 { ray.along.g_a } else { f64::MIN }) / d - 1.0,
            None => f64::INFINITY,
        }
    }

    /// The tightest direction, also between the rays: where the margins of neighbours point to a lower one in between,
    /// it is computed. Returns (angle, margin).
    pub(crate) fn tightest(&mut self, d: f64) -> (f64, f64) {
        let (n, period) = (self.rays.len(), self.sectors.period());
        let free = |r: &Ray| !(r.at_edge() && r.along.g_a >= d);
        let margins: Vec<f64> =
            self.rays.iter().map(|r| if free(r) { self.margin(r, d) } else { f64::INFINITY }).collect();
        let mut best = (0.0, f64::INFINITY);
        for k in 0..n {
            let (before, after) = ((k + n - 1) % n, (k + 1) % n);
            if margins[k] < best.1 {
                best = (self.rays[k].node.angle, margins[k]);
            }
            let [m0, m1, m2] = [margins[before], margins[k], margins[after]];
            if !(m1 <= m0 && m1 <= m2 && m0.is_finite() && m2.is_finite()) {
                continue;
            }
            let turn =
                |from: usize, to: usize| (self.rays[to].node.angle - self.rays[from].node.angle).rem_euclid(period);
            let (h0, h2) = (turn(before, k), turn(k, after));
            let (s0, s2) = ((m1 - m0) / h0, (m2 - m1) / h2);
            let bend = (s2 - s0) / (h0 + h2);
            let slope = (s0 * h2 + s2 * h0) / (h0 + h2);
            let shift = if bend > 0.0 { (-0.5 * slope / bend).max(-h0).min(h2) } else { 0.0 };
            let drop = 0.25 * slope * slope / bend;
            if bend > 0.0 && drop > 1e-3 * m1.abs() && m1 - 4.0 * drop < best.1 {
                let angle = self.rays[k].node.angle + shift;
                let ray = self.extra_ray(angle, self.rays[k].a);
                let ray = self.outer_root(ray, d, 1e-12);
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
        let (outline, turns, period) = (self.outline(), self.sectors.turns(), self.sectors.period());
        let turned = |[angle, a]: [f64; 2], turns| (0..turns).map(move |k| [angle + period * k as f64, a]);
        let mut all: Vec<_> = outline.iter().flat_map(|&point| turned(point, turns)).collect();
        // Those of one period, where it holds a whole number of them.
        let copies = if count.is_multiple_of(turns) { turns } else { 1 };
        for k in 0..count / copies {
            let angle = TAU * k as f64 / count as f64;
            let ray = self.extra_ray(angle, radius_in(&outline, angle, period));
            let ray = self.outer_root(ray, d, 1e-12);
            all.extend(turned([angle, self.other_root(&ray, d).unwrap_or(ray).a], copies));
        }
        all.sort_by(|p, q| p[0].total_cmp(&q[0]));
        all.dedup_by(|b, a| b[0] - a[0] < 1e-12);
        while all.len() > 1 && all[0][0] + TAU - all[all.len() - 1][0] < 1e-12 {
            all.pop();
        }
        all
    }
}
