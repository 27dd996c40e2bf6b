//! Force over overlap from values and exact slopes: once differentiable, increasing and convex like the law itself.
//!
//! Between two knots with secant D and slopes K0 < D < K1 the rational cubic of Delbourgo & Gregory (SIAM J. Sci. Stat.
//! Comput. 6, 967, 1985), with t = (s - s0)/h:
//!
//!   P = [(1-t)^3 P0 + t (1-t)^2 (r P0 + h K0) + t^2 (1-t) (r P1 - h K1) + t^3 P1] / [1 + (r - 3) t (1-t)],
//!   r = 1 + (K1 - D)/(D - K0) + (D - K0)/(K1 - D),
//!
//! which is convex, of fourth order, and exact for quadratics. Before the first knot P = P0 (s/s0)^m, m = K0 s0/P0 >= 1.

use crate::numeric::scalar::root;

/// A knot: overlap, force, stiffness, and r of the interval that begins here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Overlap s = depth less the depth of first touch.
    pub overlap: f64,
    /// Force.
    pub force: f64,
    /// dP/ds.
    pub stiffness: f64,
    /// r; 3 in the last knot, which begins no interval.
    pub shape: f64,
}

impl Knot {
    /// d ln P/d ln s.
    fn exponent(&self) -> f64 {
        self.stiffness * self.overlap / self.force
    }

    /// The power law that continues value and slope here: force and its first two derivatives.
    fn power(&self, s: f64) -> [f64; 3] {
        let m = self.exponent();
        let ratio = s / self.overlap;
        let stiffness = self.stiffness * ratio.powf(m - 1.0);
        [self.force * ratio.powf(m), stiffness, (m - 1.0) * stiffness / s]
    }

    /// Its inverse.
    fn overlap_by_power(&self, force: f64) -> f64 {
        self.overlap * (force / self.force).powf(1.0 / self.exponent())
    }
}

/// What a curve says at depths beyond its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beyond {
    /// Nothing: `None`, NaN in exports.
    #[default]
    Refuse,
    /// The power law that continues force and stiffness: P ~ s^m, m = K s/P at the end of the range.
    Power,
    /// The tangent: the stiffness stays.
    Tangent,
}

impl Beyond {
    /// The word on the command line and in exports.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Refuse => "refuse",
            Self::Power => "power",
            Self::Tangent => "tangent",
        }
    }
}

/// The interpolant.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    pub knots: Vec<Knot>,
}

impl Spline {
    /// Through (overlap, force, stiffness), overlaps ascending and greater than zero, forces greater than zero. Values that
    /// contradict convexity, as errors of a solver can, are left out; slopes are moved between their secants.
    pub fn new(samples: &[[f64; 3]]) -> Self {
        let mut kept: Vec<[f64; 3]> = Vec::with_capacity(samples.len());
        let secant = |a: &[f64; 3], b: &[f64; 3]| (b[1] - a[1]) / (b[0] - a[0]);
        for &sample in samples {
            // The hull from below of what came so far; the first touch belongs to it.
            while let Some(last) = kept.last() {
                let before = kept.len().checked_sub(2).map_or([0.0; 3], |k| kept[k]);
                if secant(&before, last) < secant(last, &sample) || kept.len() == 1 && is_proportional(last, &sample) {
                    break;
                }
                kept.pop();
            }
            kept.push(sample);
        }
        let n = kept.len();
        let slopes: Vec<f64> = (0..n)
            .map(|k| {
                let below = secant(&k.checked_sub(1).map_or([0.0; 3], |k| kept[k]), &kept[k]);
                let above = kept.get(k + 1).map_or(f64::INFINITY, |next| secant(&kept[k], next));
                kept[k][2].max(below.min(above)).min(above)
            })
            .collect();
        let knots = (0..n)
            .map(|k| {
                let shape = kept.get(k + 1).map_or(3.0, |next| {
                    let d = secant(&kept[k], next);
                    let (low, high) = (d - slopes[k], slopes[k + 1] - d);
                    // A straight piece: any shape gives it.
                    if low.min(high) <= 1e-9 * d { straight(low, high, d) } else { 1.0 + high / low + low / high }
                });
                Knot { overlap: kept[k][0], force: kept[k][1], stiffness: slopes[k], shape }
            })
            .collect();
        Self { knots }
    }

    /// Force, stiffness and d2P/ds2, with this continuation beyond the last knot; `None` where that refuses.
    pub fn at(&self, s: f64, beyond: Beyond) -> Option<[f64; 3]> {
        let (first, last) = (self.knots.first()?, self.knots.last()?);
        if s.is_nan() {
            return None;
        }
        if s <= 0.0 {
            return Some([0.0; 3]);
        }
        if s > last.overlap {
            return match beyond {
                Beyond::Refuse => None,
                Beyond::Power => Some(last.power(s)),
                Beyond::Tangent => Some([last.force + last.stiffness * (s - last.overlap), last.stiffness, 0.0]),
            };
        }
        if s <= first.overlap {
            return Some(first.power(s));
        }
        let k = self.knots.partition_point(|knot| knot.overlap < s).min(self.knots.len() - 1) - 1;
        let ([a, b], h) = ([self.knots[k], self.knots[k + 1]], self.knots[k + 1].overlap - self.knots[k].overlap);
        let t = (s - a.overlap) / h;
        let u = 1.0 - t;
        let (p, q) = (a.shape * a.force + h * a.stiffness, a.shape * b.force - h * b.stiffness);
        let above = u * u * u * a.force + t * u * u * p + t * t * u * q + t * t * t * b.force;
        let below = 1.0 + (a.shape - 3.0) * t * u;
        let d_above = 3.0 * (t * t * b.force - u * u * a.force) + (u - 2.0 * t) * u * p + (2.0 * u - t) * t * q;
        let d_below = (a.shape - 3.0) * (u - t);
        let dd_above = 6.0 * (u * a.force + t * b.force) + (6.0 * t - 4.0) * p + (6.0 * u - 4.0) * q;
        let dd_below = -2.0 * (a.shape - 3.0);
        let force = above / below;
        let slope = (d_above - force * d_below) / below;
        let curvature = (dd_above - 2.0 * slope * d_below - force * dd_below) / below;
        Some([force, slope / h, curvature / (h * h)])
    }

    /// The overlap at this force: the inverse; `None` for a pull, and where there is no continuation beyond the last knot.
    pub fn overlap_at(&self, force: f64, beyond: Beyond) -> Option<f64> {
        let (first, last) = (self.knots.first()?, self.knots.last()?);
        if force.is_nan() || force < 0.0 {
            return None;
        }
        if force > last.force {
            return match beyond {
                Beyond::Refuse => None,
                Beyond::Power => Some(last.overlap_by_power(force)),
                Beyond::Tangent => Some(last.overlap + (force - last.force) / last.stiffness),
            };
        }
        if force <= first.force {
            return Some(first.overlap_by_power(force));
        }
        let k = self.knots.partition_point(|knot| knot.force < force).min(self.knots.len() - 1) - 1;
        let [low, high] = [k, k + 1].map(|k| self.knots[k].overlap);
        let excess = |s: f64| self.at(s, beyond).map_or(f64::NAN, |[there, ..]| there - force);
        // Rounding may hide the root beside a knot.
        let end = if excess(low) < 0.0 { high } else { low };
        Some(root(excess, low, high).map_or(end, |found| found.at))
    }
}

/// A flat punch: force proportional to overlap, up to rounding.
fn is_proportional(a: &[f64; 3], b: &[f64; 3]) -> bool {
    (a[1] / a[0] - b[1] / b[0]).abs() <= 1e-9 * b[1] / b[0]
}

/// r where a slope all but equals the secant: 3 on a straight piece, large next to a kink.
fn straight(low: f64, high: f64, secant: f64) -> f64 {
    if low.max(high) <= 1e-9 * secant { 3.0 } else { (low.max(high) / (1e-9 * secant)).max(3.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn powers(m: f64, n: usize) -> Spline {
        let knot = |k: usize| {
            let s = 1.3f64.powi(k as i32);
            [s, s.powf(m), m * s.powf(m - 1.0)]
        };
        Spline::new(&(0..n).map(knot).collect::<Vec<_>>())
    }

    #[test]
    fn quadratics_and_lines_are_exact() {
        for m in [1.0, 2.0] {
            let spline = powers(m, 8);
            for k in 0..100 {
                let s = 0.1 + 0.06 * k as f64;
                let [p, slope, _] = spline.at(s, Beyond::Refuse).unwrap();
                assert!((p - s.powf(m)).abs() < 1e-13 * p.max(1.0), "s^{m} at {s}: {p}");
                assert!((slope - m * s.powf(m - 1.0)).abs() < 1e-12 * slope, "slope of s^{m} at {s}");
            }
        }
    }

    #[test]
    fn slope_is_the_derivative_and_never_falls() {
        let spline = powers(1.5, 8);
        let p_bend = |p: [f64; 3]| p[2];
        let mut before = 0.0;
        for k in 1..200 {
            let s = 0.03 * k as f64;
            let [p, slope, _] = spline.at(s, Beyond::Refuse).unwrap();
            let e = 1e-5 * s;
            let at = |s: f64| spline.at(s, Beyond::Refuse).unwrap();
            let central = (at(s + e)[0] - at(s - e)[0]) / (2.0 * e);
            // Not across a knot, where the second derivative jumps.
            let between = spline.knots.iter().all(|knot| (knot.overlap - s).abs() > 2.0 * e);
            let bend = (at(s + e)[1] - at(s - e)[1]) / (2.0 * e);
            assert!(!between || (p_bend(at(s)) - bend).abs() < 1e-4 * bend, "{bend} at {s}");
            assert!((slope - central).abs() < 1e-6 * slope && slope >= before);
            assert!((p - s.powf(1.5)).abs() < 2e-5 * p);
            before = slope;
            assert!((spline.overlap_at(p, Beyond::Refuse).unwrap() - s).abs() < 1e-13 * s);
        }
        assert_eq!(spline.at(1e3, Beyond::Refuse), None);
        assert_eq!(spline.overlap_at(-1.0, Beyond::Power), None);
    }

    #[test]
    fn continuations_keep_value_and_slope_and_have_an_inverse() {
        let spline = powers(1.7, 8);
        let end = spline.knots.last().unwrap().overlap;
        let here = spline.at(end, Beyond::Refuse).unwrap();
        for beyond in [Beyond::Power, Beyond::Tangent] {
            let after = spline.at(end * (1.0 + 1e-12), beyond).unwrap();
            assert!((after[0] / here[0] - 1.0).abs() < 1e-11 && (after[1] / here[1] - 1.0).abs() < 1e-11);
            for s in [1.1 * end, 7.0 * end] {
                let [p, slope, bend] = spline.at(s, beyond).unwrap();
                let e = 1e-5 * s;
                let (low, high) = (spline.at(s - e, beyond).unwrap(), spline.at(s + e, beyond).unwrap());
                assert!(((high[0] - low[0]) / (2.0 * e) / slope - 1.0).abs() < 1e-8);
                assert!(((high[1] - low[1]) / (2.0 * e) - bend).abs() < 1e-6 * slope / s);
                assert!((spline.overlap_at(p, beyond).unwrap() / s - 1.0).abs() < 1e-12);
            }
        }
        let law = spline.at(10.0 * end, Beyond::Power).unwrap();
        assert!((law[0] / (10.0 * end).powf(1.7) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn noise_is_made_convex() {
        let noisy = [[1.0, 1.0, 1.0], [2.0, 2.9, 2.5], [3.0, 4.7, 2.4], [4.0, 8.0, 4.0]];
        let spline = Spline::new(&noisy);
        let slopes: Vec<f64> = (1..=400).map(|k| spline.at(0.01 * k as f64, Beyond::Refuse).unwrap()[1]).collect();
        assert!(slopes.windows(2).all(|w| w[1] >= w[0] - 1e-9));
    }
}
