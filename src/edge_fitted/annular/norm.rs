//! The sums of (2) over rings, everything along one radius.
//!
//! With |d^m| of the potential of a circle line bounded by chords of that circle, of radius a, at the radius rho:
//!
//! ```text
//! |d^m/drho^m du/drho|/m! <= sqrt(a/rho) B_m/delta^m,      delta the distance from the circle,
//! ```
//!
//! subintervals shrink towards every circle, so that no logarithm needs to be taken off; the last ones, 3e-5 of a ring, are
//! bounded whole.

use std::f64::consts::PI;

use super::super::gauss::{B, kappa, lagrange, legendre};
use super::super::integrand::Sums;
use super::disc::disc;
use super::overlap::RadialBounds;
use super::rings::Rings;
use super::target::RadialTarget;

/// Nodes of a subinterval.
const NODES: usize = 5;
/// Points of the quadrature of squares: exact for the fourth-degree interpolants, a quadratic f, the fade and the weights.
const POINTS: usize = 9;
/// The part of a ring that the innermost subinterval covers.
const INNERMOST: f64 = 3e-5;

/// What is asked of a pressure on the rings.
pub(crate) struct RadialRequest<'a> {
    pub pressure: &'a [f64],
    /// f; None: the constant 1.
    pub overlap: Option<&'a dyn RadialBounds>,
    /// Rings with w = f - u; it fades over half of the next ones.
    pub full: &'a [bool],
    /// Beyond them also bound w = max(f - u, chi (f - u)) where f > 0.
    pub admissible: bool,
}

/// What is known of a pressure.
#[derive(Debug, Clone)]
pub(crate) struct RadialNorm {
    pub faded: Sums,
    pub added: Sums,
    /// Integrals of u over the rings: middle and bound of the error.
    pub displaced: Vec<[f64; 2]>,
    /// An upper bound of u - f over the full rings.
    pub above: f64,
    /// Upper bounds of f - u over the others.
    pub highest: Vec<f64>,
    pub sampled: bool,
}

/// l0 at the ends of the rings: the thinner of the two that meet.
fn decay(rings: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let width = |i: usize| rings[i][1] - rings[i][0];
    (0..rings.len())
        .map(|i| {
            let low = if i > 0 && rings[i - 1][1] == rings[i][0] { width(i - 1).min(width(i)) } else { width(i) };
            let high = if i + 1 < rings.len() && rings[i + 1][0] == rings[i][1] {
                width(i + 1).min(width(i))
            } else {
                width(i)
            };
            [low, high]
        })
        .collect()
}

/// Distances from the low end of subintervals of a ring of this width: shrinking by half towards both ends.
fn subintervals(width: f64) -> Vec<[f64; 2]> {
    let mut cuts = vec![0.5];
    while cuts[cuts.len() - 1] > INNERMOST {
        cuts.push(0.5 * cuts[cuts.len() - 1]);
    }
    cuts.push(0.0);
    cuts.windows(2).map(|c| [c[1] * width, c[0] * width]).collect()
}

impl Rings {
    /// The sums of (2), the integrals of u, and the ranges of f - u.
    pub fn norm(&self, request: &RadialRequest) -> RadialNorm {
        let n = self.rings.len();
        let jumps = self.jumps(request.pressure);
        let decay = decay(&self.rings);
        let mut norm = RadialNorm {
            faded: Sums::default(),
            added: Sums::default(),
            displaced: vec![[0.0; 2]; n],
            above: 0.0,
            highest: vec![f64::NEG_INFINITY; n],
            sampled: false,
        };
        for i in 0..n {
            let [a, b] = self.rings[i];
            let full = request.full[i];
            let meets = |j: Option<usize>, end: bool| {
                j.and_then(|j| self.rings.get(j).map(|r| (j, r)))
                    .is_some_and(|(j, r)| request.full[j] && if end { r[0] == b } else { r[1] == a })
            };
            // chi at both ends; in the middle it is 0 unless the ring is full.
            let ends = [full || meets(i.checked_sub(1), false), full || meets(Some(i + 1), true)];
            let overlaps = request.overlap.is_none_or(|f| f.bounds([a, b])[1] > 0.0);
            let open = request.admissible && !full && self.loaded[i] && overlaps;
            if !full && !ends[0] && !ends[1] && !open {
                continue;
            }
            let width = b - a;
            for high in [false, true] {
                let chi_end = if ends[usize::from(high)] { 1.0 } else { 0.0 };
                let chi_middle = if full { 1.0 } else { 0.0 };
                let mut pieces: Vec<([f64; 2], u32)> = subintervals(width).into_iter().map(|p| (p, 0)).collect();
                while let Some((piece, depth)) = pieces.pop() {
                    let fade = piece.map(|s| chi_end + (chi_middle - chi_end) * 2.0 * s / width);
                    let l = piece.map(|s| {
                        let s = if high { width - s } else { s };
                        decay[i][0] + (decay[i][1] - decay[i][0]) * s / width
                    });
                    let part = Part { ring: [a, b], high, piece, jumps: &jumps };
                    let share = part.share(request.overlap, fade, l);
                    norm.sampled |= share.sampled;
                    let unsure = open && share.range[1] >= 0.0;
                    if unsure && depth < 5 && fade == [0.0; 2] && piece[0] > 0.0 {
                        let middle = 0.5 * (piece[0] + piece[1]);
                        pieces.push(([piece[0], middle], depth + 1));
                        pieces.push(([middle, piece[1]], depth + 1));
                        continue;
                    }
                    norm.faded.add(1.0, &share.faded);
                    if unsure {
                        norm.added.add(1.0, &share.whole);
                    }
                    norm.displaced[i][0] += share.displaced[0];
                    norm.displaced[i][1] += share.displaced[1];
                    norm.highest[i] = norm.highest[i].max(share.range[1]);
                    if full {
                        norm.above = norm.above.max(-share.range[0]);
                    }
                }
            }
        }
        norm
    }
}

/// Part of a ring, by the distances from its low or its high end.
struct Part<'a> {
    ring: [f64; 2],
    high: bool,
    piece: [f64; 2],
    jumps: &'a [(f64, f64)],
}

/// Its contributions.
struct Share {
    faded: Sums,
    whole: Sums,
    displaced: [f64; 2],
    range: [f64; 2],
    sampled: bool,
}

/// Lebesgue constant of five Gauss nodes.
const LEBESGUE: f64 = 3.33;

impl Part<'_> {
    /// The radius at a distance from the end.
    fn radius(&self, s: f64) -> f64 {
        if self.high { self.ring[1] - s } else { self.ring[0] + s }
    }

    /// u and u' at a distance from the end.
    fn fields(&self, s: f64) -> [f64; 2] {
        let rho = self.radius(s);
        let width = self.ring[1] - self.ring[0];
        let mut sum = [0.0; 2];
        for &(a, jump) in self.jumps {
            let beyond = match (self.high, a == self.ring[0], a == self.ring[1]) {
                (false, true, _) => s,
                (false, _, true) => s - width,
                (true, true, _) => width - s,
                (true, _, true) => -s,
                _ => rho - a,
            };
            let [u, slope] = disc(rho, a, beyond);
            sum = [sum[0] + jump * u, sum[1] + jump * slope];
        }
        sum
    }

    /// Bounds of what interpolation of u' and u leaves out (mean squares), and of the Gauss sum of u.
    fn errors(&self) -> [f64; 3] {
        let [s0, s1] = self.piece;
        let h = 0.5 * (s1 - s0);
        let (r0, r1) = (self.radius(s0).min(self.radius(s1)), self.radius(s0).max(self.radius(s1)));
        let width = self.ring[1] - self.ring[0];
        let mut errors = [0.0; 3];
        for &(a, jump) in self.jumps {
            let at_end = a == if self.high { self.ring[1] } else { self.ring[0] };
            let other_end = a == if self.high { self.ring[0] } else { self.ring[1] };
            let delta = if at_end {
                s0
            } else if other_end {
                width - s1
            } else if a < r0 {
                r0 - a
            } else {
                a - r1
            };
            // On the axis itself the circle is 'a' away everywhere.
            let factor = if r0 > 0.25 * a { (a / r0).sqrt() * B[NODES] } else { 2.0 * a / delta };
            let size = jump.abs() * factor;
            let q = h / delta;
            errors[0] += kappa(NODES) * size * q.powi(NODES as i32);
            errors[1] += kappa(NODES) / NODES as f64 * h * size * q.powi(NODES as i32 - 1);
            // The remainder of the Gauss sum: kappa_m^2 h^(2m) sup |u^(2m)|/(2m)! per length, B_m falls with m.
            let order = 2 * NODES as i32;
            // (rho u)^(2m) = rho u^(2m) + 2 m u^(2m-1).
            let weighted = 1.0 + 1.2 * delta / r1;
            errors[2] += kappa(NODES).powi(2) / order as f64 * h * size * q.powi(order - 1) * weighted;
            // Rounding.
            errors[0] += jump.abs() * 1e-14 * (40.0 + r1 / delta.max(0.05 * h));
            errors[1] += jump.abs() * 1e-14 * a.max(r1);
        }
        errors[2] += self.jumps.iter().map(|j| j.1.abs() * 1e-14 * j.0.max(r1)).sum::<f64>();
        errors
    }

    fn share(&self, overlap: Option<&dyn RadialBounds>, fade: [f64; 2], l: [f64; 2]) -> Share {
        let [s0, s1] = self.piece;
        let (middle, h) = (0.5 * (s0 + s1), 0.5 * (s1 - s0));
        let ends = [self.radius(s0), self.radius(s1)];
        let interval = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let target = RadialTarget::new(overlap, interval);
        if s0 == 0.0 {
            return self.innermost(&target, fade, l);
        }
        let sign = if self.high { -1.0 } else { 1.0 };
        let x = &legendre(NODES).0;
        let fields: Vec<[f64; 2]> = x.iter().map(|x| self.fields(middle + h * x)).collect();
        let [slope_error, value_error, sum_error] = self.errors();
        let (slope_rest, value_rest) = (slope_error + target.slope_slack, value_error + target.value_slack);
        // f - u at the nodes, and its range.
        let nodes = x.iter().zip(&fields).map(|(x, f)| target.at(self.radius(middle + h * x))[0] - f[0]);
        let (low, high) = nodes.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let reach = LEBESGUE * 0.5 * (high - low) + ((2 * NODES + 1) as f64).sqrt() * value_error + target.value_slack;
        let range = [0.5 * (low + high) - reach, 0.5 * (low + high) + reach];
        let steep = (l[1] - l[0]) / (2.0 * h) * sign;
        let slant = (fade[1] - fade[0]) / (2.0 * h) * sign;
        let (mut faded, mut whole) = (Sums::default(), Sums::default());
        let mut displaced = 0.0;
        let (q, w) = legendre(POINTS);
        for (q, w) in q.iter().zip(w) {
            let s = middle + h * q;
            let rho = self.radius(s);
            let basis = lagrange(x, *q);
            let [u, du] = [0, 1].map(|c| basis.iter().zip(&fields).map(|(b, f)| b * f[c]).sum::<f64>());
            let [f, df] = target.at(rho);
            let (rest, drest) = (f - u, df - du);
            let t = 0.5 * (1.0 + q);
            let length = l[0] + t * (l[1] - l[0]);
            // 1/l is convex: its chord lies above.
            let inverse = (1.0 - t) / l[0] + t / l[1];
            let chi = fade[0] + t * (fade[1] - fade[0]);
            let weight = 2.0 * PI * rho * h * w;
            displaced += weight * u;
            let add = |sums: &mut Sums, w: f64, dw: f64| {
                sums.alpha += weight * (length * dw * dw + w * dw * steep + 0.5 * w * w * steep * steep * inverse);
                sums.beta += weight * w * w * inverse;
            };
            add(&mut faded, chi * rest, chi * drest + slant * rest);
            add(&mut whole, rest, drest);
        }
        let area = 2.0 * PI * interval[1] * 2.0 * h;
        let rest = |sums: &mut Sums, top: f64, slant: f64| {
            let e1 = (top * slope_rest + slant.abs() * value_rest) * area.sqrt();
            let e0 = top * value_rest * area.sqrt();
            let (low, high) = (l[0].min(l[1]), l[0].max(l[1]));
            sums.alpha_rest = (high.sqrt() * e1 + steep.abs() / (2.0 * low).sqrt() * e0).powi(2);
            sums.beta_rest = e0 * e0 / low;
        };
        rest(&mut faded, fade[0].max(fade[1]), slant);
        rest(&mut whole, 1.0, 0.0);
        Share {
            faded,
            whole,
            displaced: [displaced, sum_error * area + 1e-14 * displaced.abs()],
            range,
            sampled: target.sampled,
        }
    }

    /// The part that reaches the circle at the end: u by its value a little inside, u' by its logarithm.
    fn innermost(&self, target: &RadialTarget, fade: [f64; 2], l: [f64; 2]) -> Share {
        let size = self.piece[1];
        let rho = self.radius(size);
        let [u, _] = self.fields(size);
        let end = self.radius(0.0);
        let width = self.ring[1] - self.ring[0];
        // |u' of the others at `size`| + their variation + |jump| 4/pi (K + 1) of the circle at the end, with
        // K <= ln(4/k') + 1 and k'^2 >= delta/max: a bound A + B ln(size/s).
        let (mut others, mut variation, mut own, mut factor) = (0.0, 0.0, 0.0, 0.0);
        for &(a, jump) in self.jumps {
            let large = a.max(rho).max(end);
            if a == end {
                let ratio = (large / rho.min(end).max(0.5 * size)).max(1.0);
                own += jump.abs() * 4.0 / PI * (0.5 * (16.0 * large / size).ln() + 2.0) * ratio;
                factor += jump.abs() * 4.0 / PI * ratio;
            } else {
                let other_end = a == self.ring[0] || a == self.ring[1];
                let beyond = match (other_end, self.high) {
                    (true, true) => width - size,
                    (true, false) => size - width,
                    _ => rho - a,
                };
                others += jump * disc(rho, a, beyond)[1];
                let delta = (beyond.abs() - size).max(f64::MIN_POSITIVE);
                let near = rho.min(end);
                let kernel = if near > 0.25 * a { (a / near).sqrt() * B[1] } else { 2.0 * a / delta };
                variation += jump.abs() * (size * kernel / delta + 1e-14 * (40.0 + rho / delta));
            }
        }
        let constant = others.abs() + variation + own;
        // Mean square of A + B ln(size/s) over the interval, and the integral of it.
        let square = constant * constant + 2.0 * constant * factor + 2.0 * factor * factor;
        let drop = size * (constant + factor);
        let rest = target.at(0.5 * (rho + end))[0] - u;
        let value = rest.abs() + drop + size * target.slope.abs() + target.value_slack;
        let area = 2.0 * PI * rho.max(end) * size;
        let slope = square.sqrt() + target.slope.abs() + target.slope_slack;
        let steep = (l[1] - l[0]).abs() / size;
        let (low, high) = (l[0].min(l[1]), l[0].max(l[1]));
        let sums = |top: f64, slant: f64| {
            let (e1, e0) = ((top * slope + slant * value) * area.sqrt(), top * value * area.sqrt());
            Sums {
                alpha_rest: (high.sqrt() * e1 + steep / (2.0 * low).sqrt() * e0).powi(2),
                beta_rest: e0 * e0 / low,
                ..Sums::default()
            }
        };
        let slant = (fade[1] - fade[0]).abs() / size;
        let spread = drop + size * target.slope.abs() + target.value_slack;
        Share {
            faded: sums(fade[0].max(fade[1]), slant),
            whole: sums(1.0, 0.0),
            displaced: [u * area, area * (drop + u.abs() * size / rho.min(end).max(size) + 1e-14 * u.abs())],
            range: [rest - spread, rest + spread],
            sampled: target.sampled,
        }
    }
}
