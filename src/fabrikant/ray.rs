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
use std::sync::OnceLock;

use crate::gap::{Gap, Scaled};

/// The overlap f = level - gap in the units of the solver.
pub(crate) struct Overlap<'a> {
    /// The gap, in units of length and depth.
    pub gap: Scaled<'a>,
    /// The depth, in units of depth: 1 when the gap is zero at its centre.
    pub level: f64,
    has_gradient: bool,
}

impl<'a> Overlap<'a> {
    pub fn new(gap: Scaled<'a>, level: f64) -> Self {
        let [x, y] = gap.centre();
        Self { has_gradient: gap.gradient(x, y).is_some(), gap, level }
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
    fn slope_along(&self, c: [f64; 2], e: [f64; 2], r: f64, h: f64) -> f64 {
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

/// One node of the rule in t on [0, pi/2].
#[derive(Clone, Copy)]
pub(crate) struct RadialNode {
    pub sin: f64,
    pub cos: f64,
    pub weight: f64,
}

/// A rule in t. The finer ones crowd towards t = 0, for gaps whose slope is infinite or jumps there.
pub(crate) struct RadialRule {
    /// Nodes on the whole of [0, pi/2].
    pub whole: Vec<RadialNode>,
    /// The same on [0, 1], crowding at 0: the first piece of a split ray.
    first: Vec<[f64; 2]>,
    /// Gauss-Legendre on [0, 1]: the other pieces.
    plain: Vec<[f64; 2]>,
}

impl RadialRule {
    /// The rules from coarse to fine; each serves as the check of the one before.
    pub fn ladder() -> &'static [RadialRule] {
        static LADDER: OnceLock<Vec<RadialRule>> = OnceLock::new();
        LADDER.get_or_init(|| {
            [(4, 1), (8, 1), (16, 1), (32, 4), (64, 4), (128, 4), (256, 4)].map(|(n, p)| Self::new(n, p)).into()
        })
    }

    fn new(nodes: usize, crowding: i32) -> Self {
        let plain = gauss_legendre(nodes);
        let first: Vec<[f64; 2]> =
            plain.iter().map(|&[x, w]| [x.powi(crowding), w * f64::from(crowding) * x.powi(crowding - 1)]).collect();
        let whole = first
            .iter()
            .map(|&[x, w]| {
                let (sin, cos) = (FRAC_PI_2 * x).sin_cos();
                RadialNode { sin, cos, weight: FRAC_PI_2 * w }
            })
            .collect();
        Self { whole, first, plain }
    }

    /// Calls `visit` at every node of [0, pi/2] split where sin t is one of `kinks`/a (ascending).
    pub fn visit(&self, kinks: &[f64], a: f64, mut visit: impl FnMut(RadialNode)) {
        let stand = Stand::at(kinks, a);
        self.visit_pieces(kinks, &stand, |_, node| visit(node));
    }

    /// Calls `visit` with the piece (the number of kinks below it) and the node. Angles are counted from the end of the
    /// ray, phi = pi/2 - t, so that a piece however thin keeps its digits.
    fn visit_pieces(&self, kinks: &[f64], stand: &Stand, mut visit: impl FnMut(usize, RadialNode)) {
        if stand.inner == 0 {
            self.whole.iter().for_each(|&node| visit(0, node));
            return;
        }
        let mut from = stand.phi_of(kinks, 0);
        let to = FRAC_PI_2 - from;
        for &[x, w] in &self.first {
            let (sin, cos) = (to * x).sin_cos();
            visit(0, RadialNode { sin, cos, weight: to * w });
        }
        for piece in 1..=stand.inner {
            let to = if piece < stand.inner { stand.phi_of(kinks, piece) } else { 0.0 };
            for &[x, w] in &self.plain {
                let (cos, sin) = (from - (from - to) * x).sin_cos();
                visit(piece, RadialNode { sin, cos, weight: (from - to) * w });
            }
            from = to;
        }
    }
}

/// A place on a ray: r = a, beyond the first `inner` kinks. Just past a kink k, where G_a falls with infinite slope
/// (G_a(k) - G_a(a) ~ the jump of the slope times sqrt(a - k)), a itself has too few digits: there the place is the angle
/// phi with a = k/cos(phi), and G_a is smooth in it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Stand {
    pub a: f64,
    /// How many kinks lie below a; a itself may be the next one, and then belongs to the inner side.
    pub inner: usize,
    /// acos(k/a) of the last of these; 0 when there is none.
    pub phi: f64,
}

impl Stand {
    pub fn at(kinks: &[f64], a: f64) -> Self {
        let inner = kinks.partition_point(|&k| k < a);
        let phi = match inner {
            0 => 0.0,
            n => {
                let k = kinks[n - 1] / a;
                ((1.0 - k) * (1.0 + k)).sqrt().atan2(k)
            }
        };
        Self { a, inner, phi }
    }

    /// The place at this angle beyond kink number `kink`.
    pub fn beyond(kinks: &[f64], kink: usize, phi: f64) -> Self {
        Self { a: kinks[kink] / phi.cos(), inner: kink + 1, phi }
    }

    /// acos(k/a) of kink number `kink`, one of the inner ones.
    fn phi_of(&self, kinks: &[f64], kink: usize) -> f64 {
        let last = self.inner - 1;
        if kink == last {
            return self.phi;
        }
        let (sin, cos) = self.phi.sin_cos();
        let ratio = kinks[kink] / kinks[last];
        let below = (kinks[last] - kinks[kink]) / kinks[last] * (1.0 + ratio);
        (sin * sin + cos * cos * below).sqrt().atan2(ratio * cos)
    }
}

/// Nodes and weights of the n-point Gauss-Legendre rule on [0, 1], by Newton on the Legendre recurrence.
pub(crate) fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    let legendre = |x: f64| {
        let (mut p0, mut p1) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
        }
        (p1, n as f64 * (x * p1 - p0) / (x * x - 1.0))
    };
    (0..n)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            for _ in 0..8 {
                let (p, dp) = legendre(x);
                x -= p / dp;
            }
            let (_, dp) = legendre(x);
            [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * dp * dp)]
        })
        .collect()
}

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
}

impl RayLine<'_> {
    pub fn at(&self, r: f64) -> [f64; 2] {
        [self.centre[0] + r * self.direction[0], self.centre[1] + r * self.direction[1]]
    }

    /// Slope of the gap at distance r, from within the piece beyond `piece` kinks.
    fn slope(&self, f: &Overlap, piece: usize, r: f64, h: f64) -> f64 {
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
    pub fn along(&self, f: &Overlap, f0: f64, stand: &Stand, rule: &RadialRule) -> Along {
        let a = stand.a;
        let h = DIFFERENCE_STEP * a;
        let back = if f.has_gradient { 1.0 } else { 1.0 - DIFFERENCE_STEP };
        let mut end = self.slope(f, stand.inner, a * back, h);
        let (mut cos2, mut one_plus, mut curving, mut value) = (0.0, 0.0, 0.0, 0.0);
        // Pieces are visited outwards: begin with the end slope brought to the innermost piece.
        let mut jumps = 0.0;
        let jump = |kink: usize| {
            let k = self.kinks[kink];
            self.slope(f, kink + 1, k, h) - self.slope(f, kink, k, h)
        };
        for kink in 0..stand.inner {
            let j = jump(kink);
            let (sin, cos) = stand.phi_of(self.kinks, kink).sin_cos();
            jumps += j * (cos / sin + sin * cos);
            end -= j;
        }
        let mut last = 0;
        rule.visit_pieces(self.kinks, stand, |piece, n| {
            if piece != last {
                end += jump(last);
                last = piece;
            }
            let g_r = if stand.inner == 0 {
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

    /// G alone.
    pub fn g(&self, f: &Overlap, f0: f64, stand: &Stand, rule: &RadialRule) -> f64 {
        let (a, mut sum) = (stand.a, 0.0);
        if f.has_gradient {
            rule.visit_pieces(self.kinks, stand, |piece, n| {
                sum += n.weight * n.cos * n.cos * self.slope(f, piece, a * n.sin, 0.0);
            });
            a * a * (f0 - a * sum)
        } else {
            rule.visit_pieces(self.kinks, stand, |_, n| sum += n.weight * n.sin * f.at(self.at(a * n.sin)));
            a * a * sum
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Polyhedron, Power};

    fn overlap(gap: &dyn Gap) -> Overlap<'_> {
        Overlap::new(Scaled { gap, origin: [0.0; 2], length: 1.0, depth: 1.0 }, 1.0)
    }

    /// c r^n has G = a^2 - c a^(n+2) m with m = int sin^(n+1).
    #[test]
    fn a_power_law_has_its_closed_form() {
        let half_beta =
            [(1.0, std::f64::consts::FRAC_PI_4), (2.0, 2.0 / 3.0), (3.0, 3.0 * std::f64::consts::PI / 16.0)];
        for (n, m) in half_beta {
            let gap = Power::new(0.7, n).unwrap();
            let line = RayLine { centre: [0.0; 2], direction: [0.6, 0.8], kinks: &[] };
            let a = 0.9f64;
            let along = line.along(&overlap(&gap), 1.0, &Stand::at(&[], a), &RadialRule::ladder()[2]);
            let c = 0.7 * m;
            assert!((along.g - (a * a - c * a.powf(n + 2.0))).abs() < 1e-14);
            assert!((along.g_a - (2.0 * a - c * (n + 2.0) * a.powf(n + 1.0))).abs() < 1e-14);
            assert!((along.g_aa - (2.0 - c * (n + 2.0) * (n + 1.0) * a.powf(n))).abs() < 1e-12);
            let values_only = move |x: f64, y: f64| 0.7 * x.hypot(y).powf(n);
            let by_differences = line.along(&overlap(&values_only), 1.0, &Stand::at(&[], a), &RadialRule::ladder()[2]);
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
        let line = RayLine { centre: [0.0; 2], direction: e, kinks: &kinks };
        let rule = &RadialRule::ladder()[2];
        for a in [0.2, 0.35, 0.6] {
            let along = |a: f64| line.along(&f, 1.0, &Stand::at(&kinks, a), rule);
            let (h, here) = (1e-5, along(a));
            let (up, down) = (along(a + h), along(a - h));
            assert!(((up.g - down.g) / (2.0 * h) - here.g_a).abs() < 1e-8, "{a}");
            assert!(((up.g_a - down.g_a) / (2.0 * h) - here.g_aa).abs() < 1e-6, "{a}");
        }
    }
}
