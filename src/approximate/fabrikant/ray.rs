//! The inner integral of equation (12) along one ray, and its derivatives with respect to a.
//!
//! With r = a sin t the square-root singularity of the flat-punch pressure is gone,
//!
//! ```text
//! G(a)    = a^2 int_0^{pi/2} f(a sin t) sin t dt            (the paper's integral, f = d - g)
//!         = a^2 f(0) - a^3 int g_r cos^2 t dt               (by parts)
//! G_a(a)  = 2 a f(0) - a^2 int g_r (1 + cos^2 t) dt         (left side of equation 15)
//! G_aa(a) = 2 f(0) - 2 a int g_r (1 + cos^2 t) dt + a int (g_r - g_r(a)) (1/cos^2 t + cos 2t) dt
//! ```
//!
//! so that the slope g_r of the gap along the ray is all that is needed. Where the slope jumps (the kinks of a
//! polyhedron) the integrals are split; on each piece a polyhedron has a constant slope, and Gauss-Legendre is exact to
//! rounding from eight nodes.

use std::f64::consts::FRAC_PI_2;

use super::radial::{RadialPosition, RadialRule};
use crate::clock::Deadline;
use crate::gap::{AnyGap, Gap};
use crate::overlap::Units;

/// The overlap f = level - gap in the units of the solver.
pub(crate) struct ScaledOverlap {
    /// The gap in these units.
    pub gap: AnyGap,
    /// Its units.
    pub units: Units,
    /// The depth, in units of depth: 1 when the gap is zero at its centre.
    pub level: f64,
    has_gradient: bool,
    has_planes: bool,
    /// When to stop evaluating it.
    pub deadline: Deadline,
}

impl ScaledOverlap {
    /// The overlap of a gap, seen in these units, at a depth in the same units.
    pub fn new(gap: impl Into<AnyGap>, units: Units, level: f64) -> Self {
        let gap = &gap.into();
        let gap = gap.scaled(units.origin, units.length, units.height);
        let [x, y] = gap.known().centre;
        let has_gradient = gap.gradient(x, y).is_some();
        let has_planes = has_gradient && gap.ridges().is_some();
        Self { has_gradient, has_planes, gap, units, level, deadline: Deadline::NEVER }
    }

    /// The overlap at depth 1 in the gap's own units.
    #[cfg(test)]
    pub fn unscaled(gap: impl Into<AnyGap>) -> Self {
        let gap = &gap.into();
        Self::new(gap, Units { origin: [0.0; 2], length: 1.0, height: 1.0 }, 1.0)
    }

    /// Whether the gap is plane between its kinks.
    pub fn has_planes(&self) -> bool {
        self.has_planes
    }

    pub fn has_gradient(&self) -> bool {
        self.has_gradient
    }

    pub fn at(&self, p: [f64; 2]) -> f64 {
        self.level - self.gap.gap(p[0], p[1])
    }

    /// The gradient of the gap; by central differences of step `h` where the gap does not know it.
    pub fn slope(&self, p: [f64; 2], h: f64) -> [f64; 2] {
        if self.has_gradient
            && let Some(slope) = self.gap.gradient(p[0], p[1])
        {
            return slope;
        }
        let g = |x, y| self.gap.gap(x, y);
        [(g(p[0] + h, p[1]) - g(p[0] - h, p[1])) / (2.0 * h), (g(p[0], p[1] + h) - g(p[0], p[1] - h)) / (2.0 * h)]
    }

    /// Slope of the gap along a ray, at distance r.
    pub(super) fn slope_along(&self, c: [f64; 2], e: [f64; 2], r: f64, h: f64) -> f64 {
        let at = |r: f64| [c[0] + r * e[0], c[1] + r * e[1]];
        if self.has_gradient
            && let [x, y] = at(r)
            && let Some(slope) = self.gap.gradient(x, y)
        {
            return slope[0] * e[0] + slope[1] * e[1];
        }
        let g = |r: f64| {
            let [x, y] = at(r);
            self.gap.gap(x, y)
        };
        // Backwards at the end of the ray: there may be no material beyond it.
        (g(r + h) - g(r - h)) / (2.0 * h)
    }
}

/// Step of the central differences, relative to the length of the ray: truncation and rounding both near 1e-10.
pub(crate) const DIFFERENCE_STEP: f64 = 6e-6;

/// How far from a kink, relative to its distance, the slope on one side of it is read: more than the rounding of points.
const ASIDE: f64 = 1e-11;

/// G and its derivatives at one a.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Along {
    pub g: f64,
    pub g_a: f64,
    pub g_aa: f64,
}

/// A ray from `centre`: unit direction and the kinks of the gap along it, ascending.
#[derive(Clone, Copy)]
pub(crate) struct RayLine<'a> {
    pub centre: [f64; 2],
    pub direction: [f64; 2],
    pub kinks: &'a [f64],
    /// For a gap made of planes: the slope along the ray on the first piece, and its jumps at the kinks.
    pub planes: Option<(f64, &'a [f64])>,
}

impl RayLine<'_> {
    /// Appends the jumps at the kinks of a gap made of planes, and returns the slope on the first piece.
    pub fn read_planes(&self, f: &ScaledOverlap, jumps: &mut Vec<f64>) -> f64 {
        let slope = |piece: usize| {
            let from = if piece > 0 { self.kinks[piece - 1] } else { 0.0 };
            let to = self.kinks.get(piece).copied().unwrap_or(if from > 0.0 { 3.0 * from } else { 1.0 });
            f.slope_along(self.centre, self.direction, 0.5 * (from + to), 0.0)
        };
        let first = slope(0);
        let mut last = first;
        for kink in 0..self.kinks.len() {
            let next = slope(kink + 1);
            jumps.push(next - last);
            last = next;
        }
        first
    }

    pub fn at(&self, r: f64) -> [f64; 2] {
        [self.centre[0] + r * self.direction[0], self.centre[1] + r * self.direction[1]]
    }

    /// Slope of the gap at distance r, from within the piece beyond `piece` kinks.
    fn slope(&self, f: &ScaledOverlap, piece: usize, r: f64, h: f64) -> f64 {
        let aside = if f.has_gradient { ASIDE } else { 2.0 * DIFFERENCE_STEP };
        let low = if piece > 0 { self.kinks[piece - 1] * (1.0 + aside) } else { 0.0 };
        let high = self.kinks.get(piece).map_or(f64::INFINITY, |k| k * (1.0 - aside));
        let r = if low <= high { r.max(low).min(high) } else { 0.5 * (self.kinks[piece - 1] + self.kinks[piece]) };
        f.slope_along(self.centre, self.direction, r, h)
    }

    /// G, G_a and G_aa. Not finite where the ray leaves the material before.
    ///
    /// The jumps J of the slope enter G_aa in closed form: int (1/cos^2 t + cos 2t) dt up to the kink is
    /// cot(phi) + sin(2 phi)/2, and what is left of g_r - g_r(a) goes to zero at the end of the ray.
    pub fn along(&self, f: &ScaledOverlap, f0: f64, position: &RadialPosition, rule: &RadialRule) -> Along {
        let a = position.a;
        if let Some(planes) = self.planes {
            return self.along_planes(planes, f0, position);
        }
        let h = DIFFERENCE_STEP * a;
        let back = if f.has_gradient { 1.0 } else { 1.0 - DIFFERENCE_STEP };
        let mut end = self.slope(f, position.inner, a * back, h);
        let (mut cos2, mut one_plus, mut curving, mut value) = (0.0, 0.0, 0.0, 0.0);
        // Pieces are visited outwards: begin with the end slope brought to the innermost piece.
        let mut jumps = 0.0;
        let jump = |kink: usize| {
            let k = self.kinks[kink];
            self.slope(f, kink + 1, k, h) - self.slope(f, kink, k, h)
        };
        for kink in 0..position.inner {
            let j = jump(kink);
            let (sin, cos) = position.phi_of(self.kinks, kink).sin_cos();
            jumps += j * (cos / sin + sin * cos);
            end -= j;
        }
        let mut last = 0;
        rule.visit_pieces(self.kinks, position, |piece, n| {
            if piece != last {
                end += jump(last);
                last = piece;
            }
            let g_r = if position.inner == 0 {
                f.slope_along(self.centre, self.direction, a * n.sin, h)
            } else {
                self.slope(f, piece, a * n.sin, h)
            };
            let cc = n.cos * n.cos;
            cos2 += n.weight * g_r * cc;
            one_plus += n.weight * g_r * (1.0 + cc);
            curving += n.weight * (g_r - end) * (1.0 / cc + 2.0 * cc - 1.0);
            if !f.has_gradient {
                value += n.weight * n.sin * f.at(self.at(a * n.sin));
            }
        });
        Along {
            // Differences lose digits that the values still have, and G is where they count.
            g: if f.has_gradient { a * a * (f0 - a * cos2) } else { a * a * value },
            g_a: a * (2.0 * f0 - a * one_plus),
            g_aa: 2.0 * f0 - 2.0 * a * one_plus + a * (curving - jumps),
        }
    }

    /// G, G_a and G_aa over planes: nothing is left to integrate.
    ///
    /// Beyond a kink at t = pi/2 - phi the slope is larger by J: int sin^2 = (phi - sin phi cos phi)/2 over [0, phi], and so on.
    fn along_planes(&self, (first, jumps): (f64, &[f64]), f0: f64, position: &RadialPosition) -> Along {
        let a = position.a;
        let (mut cos2, mut one_plus, mut singular) = (first * 0.5 * FRAC_PI_2, first * 1.5 * FRAC_PI_2, 0.0);
        for (kink, j) in jumps.iter().enumerate().take(position.inner) {
            let phi = position.phi_of(self.kinks, kink);
            let (sin, cos) = phi.sin_cos();
            cos2 += j * 0.5 * (phi - sin * cos);
            one_plus += j * 0.5 * (3.0 * phi - sin * cos);
            singular += j * (cos / sin + sin * cos);
        }
        Along {
            g: a * a * (f0 - a * cos2),
            g_a: a * (2.0 * f0 - a * one_plus),
            g_aa: 2.0 * f0 - 2.0 * a * one_plus - a * singular,
        }
    }

    /// G alone.
    pub fn g(&self, f: &ScaledOverlap, f0: f64, position: &RadialPosition, rule: &RadialRule) -> f64 {
        let (a, mut sum) = (position.a, 0.0);
        if let Some(planes) = self.planes {
            return self.along_planes(planes, f0, position).g;
        }
        if f.has_gradient {
            rule.visit_pieces(self.kinks, position, |piece, n| {
                sum += n.weight * n.cos * n.cos * self.slope(f, piece, a * n.sin, 0.0);
            });
            a * a * (f0 - a * sum)
        } else {
            rule.visit_pieces(self.kinks, position, |_, n| sum += n.weight * n.sin * f.at(self.at(a * n.sin)));
            a * a * sum
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Polyhedron, Power};

    fn overlap(gap: impl Into<AnyGap>) -> ScaledOverlap {
        ScaledOverlap::unscaled(gap.into())
    }

    /// c r^n has G = a^2 - c a^(n+2) m with m = int sin^(n+1).
    #[test]
    fn a_power_law_has_its_closed_form() {
        let half_beta =
            [(1.0, std::f64::consts::FRAC_PI_4), (2.0, 2.0 / 3.0), (3.0, 3.0 * std::f64::consts::PI / 16.0)];
        for (n, m) in half_beta {
            let gap = Power::new(0.7, n).unwrap();
            let line = RayLine { centre: [0.0; 2], direction: [0.6, 0.8], kinks: &[], planes: None };
            let a = 0.9f64;
            let along = line.along(&overlap(&gap), 1.0, &RadialPosition::at(&[], a), RadialRule::level(2).unwrap());
            let c = 0.7 * m;
            assert!((along.g - (a * a - c * a.powf(n + 2.0))).abs() < 1e-14);
            assert!((along.g_a - (2.0 * a - c * (n + 2.0) * a.powf(n + 1.0))).abs() < 1e-14);
            assert!((along.g_aa - (2.0 - c * (n + 2.0) * (n + 1.0) * a.powf(n))).abs() < 1e-12);
            let values_only = move |x: f64, y: f64| 0.7 * x.hypot(y).powf(n);
            let by_differences =
                line.along(&overlap(&values_only), 1.0, &RadialPosition::at(&[], a), RadialRule::level(2).unwrap());
            assert!((by_differences.g_a - along.g_a).abs() < 1e-8);
            assert!((by_differences.g - along.g).abs() < 1e-14);
        }
    }

    #[test]
    fn derivatives_are_those_of_g_across_a_kink() {
        let blunt = Polyhedron::truncated_pyramid(4, 0.7, 0.3).unwrap();
        let f = overlap(&blunt);
        let mut kinks = Vec::new();
        let e = [0.3f64.cos(), 0.3f64.sin()];
        blunt.ray_kinks([0.0; 2], e, &mut kinks);
        let line = RayLine { centre: [0.0; 2], direction: e, kinks: &kinks, planes: None };
        let mut jumps = Vec::new();
        let first = line.read_planes(&f, &mut jumps);
        let exact = RayLine { planes: Some((first, &jumps)), ..line };
        let rule = RadialRule::level(2).unwrap();
        for a in [0.2, 0.35, 0.6] {
            let (here, closed) = [line, exact].map(|l| l.along(&f, 1.0, &RadialPosition::at(&kinks, a), rule)).into();
            assert!((here.g - closed.g).abs() < 1e-14 && (here.g_a - closed.g_a).abs() < 1e-14, "{a}");
            assert!((here.g_aa - closed.g_aa).abs() < 1e-12, "{a}: {} {}", here.g_aa, closed.g_aa);
            let along = |a: f64| line.along(&f, 1.0, &RadialPosition::at(&kinks, a), rule);
            let (h, here) = (1e-5, along(a));
            let (up, down) = (along(a + h), along(a - h));
            assert!(((up.g - down.g) / (2.0 * h) - here.g_a).abs() < 1e-8, "{a}");
            assert!(((up.g_a - down.g_a) / (2.0 * h) - here.g_aa).abs() < 1e-6, "{a}");
        }
    }
}
