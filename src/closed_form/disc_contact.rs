//! A contact of a body of revolution on a disc: whether it is one, its pressure, its energy; D and d as in [`super::sneddon`].

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use super::Revolution;
use super::generatrix::Generatrix;
use super::interpolated::Interpolated;
use crate::numeric::quadrature::{adaptive, from_zero};
use crate::numeric::scalar::maximum;

/// Points at which the conditions of a disc are looked at.
const LOOKS: usize = 96;

/// Relative error of a pressure: the quadrature's tolerance and the slope of an interpolant; 2e-8 at most in 250 contacts drawn by lot.
const PRESSURE: f64 = 3e-8;

/// Radii at which the largest pressure is looked for, and halvings of the first of them around the axis.
const PEAK_LOOKS: usize = 24;
const PEAK_HALVINGS: i32 = 8;

/// What pressures around the axis may differ by from that on it.
const PEAK_ROUNDING: f64 = 1e-10;

/// A contact of a body of revolution on a disc, if it is one.
#[derive(Debug)]
pub(super) struct DiscContact {
    pub generatrix: Arc<Generatrix>,
    /// Radius.
    pub a: f64,
    pub depth: f64,
    /// d - D(a): not zero only where the rim is sharp.
    pub edge: f64,
    /// D within the contact, once a pressure was asked for: each takes hundreds of its values.
    within: OnceLock<Interpolated>,
}

impl DiscContact {
    pub fn new(generatrix: Arc<Generatrix>, a: f64, depth: f64, edge: f64) -> Self {
        Self { generatrix, a, depth, edge, within: OnceLock::new() }
    }

    fn within(&self) -> &Interpolated {
        let g = &self.generatrix;
        self.within.get_or_init(|| Interpolated::new(|s| g.abel(s).value, &g.kinks, self.a, 0.1 * g.tolerance()))
    }

    /// Why the contact is not a disc, if it is not.
    pub fn is_disc(&self) -> Result<(), String> {
        let (g, a, d) = (&self.generatrix, self.a, self.depth);
        let slack = 1e-9 * d;
        let mut radii: Vec<f64> = (1..=LOOKS).map(|k| a * k as f64 / LOOKS as f64).collect();
        radii.extend((1..=8).map(|k| a / LOOKS as f64 * 0.25f64.powi(k)));
        for &b in &g.kinks {
            radii.extend([1e-6, 1e-4, 1e-2].iter().flat_map(|h| [b * (1.0 - h), b, b * (1.0 + h)]).filter(|&r| r < a));
        }
        radii.sort_by(f64::total_cmp);
        let mut before = 0.0;
        let grows = radii.iter().all(|&s| {
            let here = g.abel(s).value;
            let grows = here >= before - slack;
            before = here;
            grows
        });
        if !grows {
            let tension = |&&r: &&f64| !(self.pressure_to(r, 1e-7) >= -1e-6 * d / a);
            if let Some(r) = radii.iter().filter(|&&r| r < a).find(tension) {
                return Err(format!("the contact is not a disc: at r = {r:e} its pressure would be negative"));
            }
        }
        // Outside, up to where the overlap ends, or the gap reaches the depth: no point there can touch any more.
        let mut r = a;
        let mut checked = vec![];
        for k in 0.. {
            r *= 1.0 + 0.01 * f64::from(k.min(100));
            if r > g.radius.min(g.overlap) || (k > 0 && g.overlap == f64::INFINITY && g.gap(r) >= d) {
                break;
            }
            if k > 400 {
                return Err("the contact is not a disc: the gap stays below the depth far outside".to_owned());
            }
            checked.push(r);
        }
        checked.extend(g.kinks.iter().flat_map(|b| [*b, b * 1.0001]).filter(|&b| b > a && b < r.min(g.radius)));
        if g.overlap < f64::INFINITY {
            checked.retain(|&r| g.gap(r) < d);
        }
        let closed = |r: f64| {
            // r^2 - s^2 = (r sin t)^2: h = (2/pi) int (D(s) - d) dt.
            let end = ((r - a) * (r + a)).sqrt().atan2(a);
            let opening = adaptive(|t| g.abel(r * t.cos()).value - d, 0.0, end, &[], 1e-6);
            opening.value < -1e-7 * d
        };
        // D >= d beyond is enough; only where it is not, the opening itself is looked at.
        if checked.iter().all(|&r| g.abel(r).value >= d - slack) {
            return Ok(());
        }
        if let Some(r) = checked.iter().find(|&&r| closed(r)) {
            return Err(format!("the contact is not a disc of radius {a:e}: it would touch again at r = {r:e}"));
        }
        Ok(())
    }

    /// p/E* with s^2 = r^2 + w^2, W^2 = a^2 - r^2: by the slope of what interpolates D,
    /// p = (E*/pi) [(d - D(a))/W + int_0^W D'(s)/s dw], and where nothing does without it,
    /// p = (E*/pi) [(d - D(r))/W + int_0^W (D(s) - D(r))/w^2 dw].
    fn pressure_to(&self, r: f64, tolerance: f64) -> f64 {
        let (g, a) = (&self.generatrix, self.a);
        let width = ((a - r) * (a + r)).max(0.0).sqrt();
        if width == 0.0 {
            return if self.edge > 0.0 { f64::INFINITY } else { 0.0 };
        }
        let within = self.within();
        let (at_rim, integral) = if within.covers_from(r, a) {
            let share = |place: Place| {
                let from =
                    |b: f64| if b == place.kink { place.past } else { (place.w.powi(2) + (r - b) * (r + b)).sqrt() };
                within.slope_over_radius(r.hypot(place.w), from).unwrap_or(f64::NAN)
            };
            (self.edge, self.across(r, width, share, tolerance))
        } else {
            let here = if r > 0.0 { g.abel(r).value } else { 0.0 };
            let share = |Place { w, .. }: Place| (g.abel(r.hypot(w)).value - here) / w / w;
            (self.depth - here, self.across(r, width, share, tolerance))
        };
        (at_rim / width + integral) / PI
    }

    /// int_0^W of a share of the pressure, smooth but for the kinks.
    fn across(&self, r: f64, width: f64, share: impl Fn(Place) -> f64, tolerance: f64) -> f64 {
        let (g, a) = (&self.generatrix, self.a);
        // Where w passes a kink, and which; r itself is none.
        let kinks = g.kinks.iter().filter(|&&b| b > r && b < a).map(|&b| (((b - r) * (b + r)).sqrt(), b));
        let mut ends: Vec<(f64, f64)> = kinks.chain([(r, 0.0)]).filter(|&(w, _)| w > 0.0 && w < width).collect();
        ends.sort_by(|p, q| p.0.total_cmp(&q.0));
        ends.push((width, 0.0));
        let plain = |w: f64| share(Place { w, kink: 0.0, past: 0.0 });
        let first = ends[0].0;
        let inner = if r > 0.0 {
            adaptive(plain, 0.0, first, &[], tolerance).value
        } else {
            from_zero(plain, first, 0.1 * tolerance).value
        };
        // Past a kink b, D goes like (s - b)^(1/2): smooth in v, w = w_b + v^2.
        let past = |pair: &[(f64, f64)]| {
            let ((from, kink), (to, _)) = (pair[0], pair[1]);
            let at = |v: f64| Place { w: from + v * v, kink, past: v * (v * v + 2.0 * from).sqrt() };
            adaptive(|v| 2.0 * v * share(at(v)), 0.0, (to - from).sqrt(), &[], tolerance).value
        };
        inner + ends.windows(2).map(past).sum::<f64>()
    }
}

/// A place w along the line on which a pressure is integrated, and past which kink b, (s^2 - b^2)^(1/2), to all its digits.
#[derive(Clone, Copy)]
struct Place {
    w: f64,
    kink: f64,
    past: f64,
}

impl Revolution for DiscContact {
    /// To [`PRESSURE`] of the mean pressure.
    fn pressure(&self, r: f64) -> f64 {
        self.pressure_to(r, 1e-9)
    }

    fn rough_pressure(&self, r: f64) -> f64 {
        self.pressure_to(r, 1e-4)
    }

    /// int_0^a q^2 ds/P.
    fn energy_over_force(&self, force: f64) -> f64 {
        let (g, d, a) = (&self.generatrix, self.depth, self.a);
        let q2 = |s: f64| (1.0 - g.abel(s).value / d).powi(2);
        let mut ends: Vec<f64> = g.kinks.iter().copied().filter(|&b| b < a).collect();
        ends.push(a);
        let first = from_zero(q2, ends[0], 1e-11).value;
        // Past a kink b, D goes like (s - b)^(1/2): smooth in w, s^2 = b^2 + w^2.
        let past = |b: f64, end: f64| {
            let share = |w: f64| q2(b.hypot(w)) * w / b.hypot(w);
            adaptive(share, 0.0, ((end - b) * (end + b)).sqrt(), &[], 1e-11).value
        };
        let sum = first + ends.windows(2).map(|pair| past(pair[0], pair[1])).sum::<f64>();
        d * (d / force * sum)
    }

    fn peak_error(&self) -> f64 {
        PRESSURE
    }

    fn peak(&self) -> Option<f64> {
        let (g, a) = (&self.generatrix, self.a);
        if self.edge > 0.0 {
            return None;
        }
        // At the axis g grows like r^m; the pressure there is finite only for m > 1.
        let first = g.kinks.first().copied().unwrap_or(a).min(a);
        let (near, far) = (g.gap(1e-5 * first), g.gap(1e-3 * first));
        let sharp_tip = near > 0.0 && (far / near).ln() < 1.001 * 100f64.ln();
        let steepest = g.slope_beside(a, -1.0).abs();
        let corner = |&b: &f64| (g.slope_beside(b, 1.0) - g.slope_beside(b, -1.0)).abs() > 1e-3 * steepest;
        if sharp_tip || g.kinks.iter().filter(|&&b| b < a).any(corner) {
            return None;
        }
        // Roughly where, then how much.
        let at = |k: usize| a * k as f64 / PEAK_LOOKS as f64;
        let rough: Vec<f64> = (0..=PEAK_LOOKS).map(|k| self.rough_pressure(at(k))).collect();
        let highest = (0..=PEAK_LOOKS).max_by(|&k, &m| rough[k].total_cmp(&rough[m])).unwrap_or(0);
        if highest == 0 {
            let on_axis = self.pressure(0.0);
            let around = (0..PEAK_HALVINGS).map(|k| self.pressure(at(1) * 0.5f64.powi(k))).fold(on_axis, f64::max);
            // Around a smooth top values differ by rounding only.
            if around <= on_axis * (1.0 + PEAK_ROUNDING) {
                return Some(around);
            }
        }
        let ends = [highest.saturating_sub(2), (highest + 2).min(PEAK_LOOKS)];
        Some(maximum(|r| self.pressure(r), at(ends[0]), at(ends[1]), ends[1] - ends[0]).value)
    }
}
