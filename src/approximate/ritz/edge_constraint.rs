//! Ellipses that end at an edge of the punch: beyond it there is no material, or the gap rises at once out of reach.
//!
//! The force of a flat punch grows with the ellipse until it meets the edge, so the maximum lies on the constraint. The edge
//! is traced by rays from the centre of the ellipse, in the coordinates that make it the unit disc; its points p must stay
//! outside. To first order in a step (v, S) of these coordinates
//!
//! ```text
//! p^ . v + |p| p^T S p^ <= |p| - 1,    p^ = p/|p|
//! ```
//!
//! and a step maximises g . x - kappa x^2/2 under these (sequential quadratic programming, with a logarithmic barrier for
//! the inner programme: five unknowns). The points lie dense enough to carry the curvature of the edge, and after each
//! step the ellipse is shrunk until it lies inside again. A local maximum for plan-forms that are not convex.
//! Flat punches and formulas with a region have no answer without it: log P is not stationary at an edge.

use std::f64::consts::{SQRT_2, TAU};

use nalgebra::{SMatrix, SVector, Vector2};

use super::coordinates::{Ellipse, Step};
use super::disc::Disc;
use super::diverged;
use crate::approximate::fabrikant::ScaledOverlap;
use crate::gap::Gap;
use crate::numeric::scalar::{TO_THE_LAST_DIGIT, bisected, maximum};
use crate::solution::Unsolved;

/// Rays that trace the edge.
const RAYS: usize = 120;
/// Points of the edge further away than this, in radii of the ellipse, are left out.
const FAR: f64 = 4.0;
/// Steps before giving up.
const MOST_STEPS: usize = 60;
/// Curvature of the model: that of log P near Hertz's ellipse.
const KAPPA: f64 = 1.5;
/// How far the starting point of the barrier lies inside.
const INSIDE: f64 = 0.05;

/// The edges of the punch around an overlap.
pub(super) struct EdgeConstraint<'a> {
    overlap: &'a ScaledOverlap,
    reach: f64,
    kinks: Vec<f64>,
}

impl<'a> EdgeConstraint<'a> {
    /// `None` when there is no edge in sight at which the bodies overlap.
    pub fn of(overlap: &'a ScaledOverlap, reach: f64) -> Option<Self> {
        let mut edges = Self { overlap, reach: 1.01 * reach, kinks: Vec::new() };
        let circle = Ellipse { c: Vector2::zeros(), m: nalgebra::Matrix2::identity() };
        let met = (0..RAYS).any(|k| edges.edge(&circle, TAU * k as f64 / RAYS as f64, f64::INFINITY).is_finite());
        met.then_some(edges)
    }

    /// Distance of the edge in this direction, in radii of the ellipse; infinite when there is none before `far`.
    fn edge(&mut self, e: &Ellipse, psi: f64, far: f64) -> f64 {
        let (sin, cos) = psi.sin_cos();
        let ray = e.m * Vector2::new(cos, sin);
        let length = ray.norm();
        let direction: [f64; 2] = (ray / length).into();
        let overlap = |r: f64| self.overlap.at((e.c + ray * (r / length)).into());
        let far = (far * length).min(self.reach + e.c.norm());
        self.kinks.clear();
        self.overlap.gap.ray_kinks(e.c.into(), direction, &mut self.kinks);
        self.kinks.sort_unstable_by(f64::total_cmp);
        for &k in self.kinks.iter().take_while(|&&k| k < far) {
            // An edge: overlap up to it, and hardly beyond it none.
            if overlap(k * (1.0 - 1e-9)) > 0.0 && !(overlap(k * BEYOND) > 0.0) {
                return k / length;
            }
        }
        // Edges that the gap does not name.
        const SCAN: usize = 24;
        let place = |n: usize| far * n as f64 / SCAN as f64;
        let Some(n) = (1..=SCAN).find(|&n| !overlap(place(n)).is_finite()) else { return f64::INFINITY };
        let low = bisected(|r| overlap(r).is_finite(), [place(n - 1), place(n)], TO_THE_LAST_DIGIT)[0];
        if overlap(low) > 0.0 { low / length } else { f64::INFINITY }
    }

    /// Directions and distances of the edge, the nearest places between the rays included.
    fn trace(&mut self, e: &Ellipse, edge: &mut Vec<[f64; 2]>) {
        edge.clear();
        for k in 0..RAYS {
            let psi = TAU * k as f64 / RAYS as f64;
            edge.push([psi, self.edge(e, psi, FAR)]);
        }
        for k in 0..RAYS {
            let [before, here, after] = [RAYS - 1, 0, 1].map(|m| edge[(k + m) % RAYS][1]);
            if !(here < 1.5 && here <= before && here <= after) {
                continue;
            }
            let step = TAU / RAYS as f64;
            let nearest = maximum(|psi| -self.edge(e, psi, FAR), edge[k][0] - step, edge[k][0] + step, 2);
            edge.push([nearest.at, -nearest.value]);
        }
    }

    /// The ellipse shrunk about its centre until it lies inside; `edge` is what stands around it.
    fn inside(e: &Ellipse, edge: &mut [[f64; 2]]) -> Ellipse {
        let nearest = edge.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        let factor = if nearest < 1.0 { nearest * (1.0 - 4.0 * f64::EPSILON) } else { 1.0 };
        edge.iter_mut().for_each(|p| p[1] /= factor);
        Ellipse { c: e.c, m: e.m * factor }
    }

    /// The best ellipse inside the edges, how much more the model promises, and the steps taken.
    pub fn maximise(
        &mut self,
        disc: &mut Disc,
        circles: bool,
        tolerance: f64,
    ) -> Result<(Ellipse, f64, usize), Unsolved> {
        let nothing = || diverged("no ellipse inside the edge of the punch carries load");
        let mut edge = Vec::new();
        let mut e = Ellipse { c: Vector2::zeros(), m: nalgebra::Matrix2::identity() * 0.5 };
        self.trace(&e, &mut edge);
        e = Self::inside(&e, &mut edge);
        let (mut force, mut gradient, _) = disc.force_and_gradient(&e, circles).ok_or_else(nothing)?;
        let mut promise = f64::INFINITY;
        for steps in 0..MOST_STEPS {
            if disc.out_of_budget() {
                break;
            }
            let step = inner_step(&gradient, &edge, circles);
            promise = gradient.dot(&step);
            if promise <= 0.01 * tolerance.min(1e-6) {
                return Ok((e, promise.max(0.0), steps));
            }
            let mut share = 1.0;
            let better = (0..12).find_map(|_| {
                let mut next = e.moved(&(step * share));
                share *= 0.5;
                self.trace(&next, &mut edge);
                next = Self::inside(&next, &mut edge);
                disc.force_and_gradient(&next, circles).filter(|found| found.0 > force).map(|found| (next, found))
            });
            match better {
                Some((next, (f, g, _))) => (e, force, gradient) = (next, f, g),
                None => return Ok((e, promise, steps)),
            }
        }
        Ok((e, promise, MOST_STEPS))
    }
}

/// A kink counts as an edge when the overlap is gone at so many times its distance.
const BEYOND: f64 = 1.02;

/// Maximises g . x - kappa x^2/2 over the steps that keep the points of the edge outside, by Newton's method on a
/// logarithmic barrier that is taken away.
fn inner_step(gradient: &Step, edge: &[[f64; 2]], circles: bool) -> Step {
    let basis = if circles {
        let both = 1.0 / SQRT_2;
        vec![Step::x(), Step::y(), Step::new(0.0, 0.0, both, both, 0.0)]
    } else {
        (0..5).map(|k| Step::ith(k, 1.0)).collect()
    };
    let rows: Vec<(Step, f64)> = edge
        .iter()
        .filter(|p| p[1].is_finite())
        .map(|&[psi, rho]| {
            let (sin, cos) = psi.sin_cos();
            let row = Step::new(cos, sin, rho * cos * cos, rho * sin * sin, SQRT_2 * rho * cos * sin);
            let mut within = Step::zeros();
            basis.iter().for_each(|b| within += b * b.dot(&row));
            (within, rho - 1.0)
        })
        .collect();
    let mut g = Step::zeros();
    basis.iter().for_each(|b| g += b * b.dot(gradient));
    let mut x = Step::new(0.0, 0.0, -INSIDE, -INSIDE, 0.0);
    // Far places left out must not be run into.
    const MOST: f64 = 0.5;
    let allowed = |x: &Step| rows.iter().all(|(a, b)| b - a.dot(x) > 0.0) && x.amax() < MOST;
    let mut mu = 1e-2;
    while mu > 1e-15 {
        for _ in 0..6 {
            let mut slope: SVector<f64, 5> = g - x * KAPPA;
            let mut hessian = SMatrix::<f64, 5, 5>::identity() * KAPPA;
            for (a, b) in &rows {
                let s = b - a.dot(&x);
                slope -= a * (mu / s);
                hessian += a * a.transpose() * (mu / (s * s));
            }
            for m in 0..5 {
                let (low, high) = (MOST + x[m], MOST - x[m]);
                slope[m] += mu / low - mu / high;
                hessian[(m, m)] += mu / (low * low) + mu / (high * high);
            }
            let Some(newton) = hessian.cholesky().map(|c| c.solve(&slope)) else { return x };
            let mut share = 1.0;
            while share > 1e-6 && !allowed(&(x + newton * share)) {
                share *= 0.7;
            }
            if share <= 1e-6 {
                break;
            }
            x += newton * share;
            if newton.norm() < 1e-3 * mu.sqrt() {
                break;
            }
        }
        mu *= 0.2;
    }
    x
}
