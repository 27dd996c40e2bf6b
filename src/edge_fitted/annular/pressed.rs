//! The pressure on one mesh of rings, and what it proves.

use std::f64::consts::PI;

use super::super::active_set::{factor, solve, solve_on};
use super::super::compliance::Compliance;
use super::norm::{RadialNorm, RadialRequest};
use super::overlap::RadialBounds;
use super::rings::Rings;
use super::{Annular, Errors, Law};

/// Rings with their pressure.
pub(super) struct Pressed {
    rings: Rings,
    /// Bounds of the integrals of f over the rings; negative beside the spans.
    loads: Vec<[f64; 2]>,
    compliance: Compliance,
    pressure: Vec<f64>,
}

/// How many times the first tau of (5) is worth a second.
const LARGER: f64 = 20.0;

impl Pressed {
    pub fn new(rings: Rings, f: &dyn RadialBounds) -> Self {
        let of_ring = |(r, loaded): (&[f64; 2], &bool)| if *loaded { integral(f, *r, 12) } else { [-1.0; 2] };
        let loads: Vec<[f64; 2]> = rings.rings.iter().zip(&rings.loaded).map(of_ring).collect();
        let rhs: Vec<f64> = loads.iter().map(|l| 0.5 * (l[0] + l[1])).collect();
        let compliance = rings.compliance();
        let pressure = solve(&compliance, &rhs);
        Self { rings, loads, compliance, pressure }
    }

    /// The intervals in contact; `None` where there are none.
    pub fn contact(&self) -> Option<Vec<[f64; 2]>> {
        let mut list: Vec<[f64; 2]> = Vec::new();
        for ([a, b], p) in self.rings.rings.iter().zip(&self.pressure) {
            if *p > 0.0 {
                match list.last_mut() {
                    Some(last) if last[1] == *a => last[1] = *b,
                    _ => list.push([*a, *b]),
                }
            }
        }
        (!list.is_empty()).then_some(list)
    }

    /// The brackets on this mesh: (1), (4) and (5) of `state`. `None` where a bound fails.
    pub fn bracket(&self, f: &dyn RadialBounds, law: Law) -> Option<Annular> {
        let Self { rings, loads, compliance: s, pressure: p } = self;
        let contact: Vec<bool> = p.iter().map(|v| *v > 0.0).collect();
        let l = factor(s, &contact)?;
        let m = solve_on(&l, &contact, &rings.areas);
        let request = |pressure, overlap, full, admissible| RadialRequest { pressure, overlap, full, admissible };
        let of_p = rings.norm(&request(p, Some(f), &contact, true));
        if of_p.sampled {
            return None;
        }
        let product = |q: &[f64], norm: &RadialNorm| -> [f64; 2] {
            let mut sum = [0.0; 2];
            for (q, u) in q.iter().zip(&norm.displaced) {
                sum = [sum[0] + q * u[0] - q.abs() * u[1], sum[1] + q * u[0] + q.abs() * u[1]];
            }
            sum
        };
        let work = |q: &[f64]| {
            let mut sum = [0.0; 2];
            for (q, f) in q.iter().zip(loads) {
                let (a, b) = (q * f[0], q * f[1]);
                sum = [sum[0] + a.min(b), sum[1] + a.max(b)];
            }
            sum
        };
        let dot = |q: &[f64]| q.iter().zip(&rings.areas).map(|(q, a)| q * a).sum::<f64>();
        // <f, p> - <p, S p>/2 is known between bounds: the energy is above the lower one, and gamma above the upper one at most.
        let (given, taken) = (work(p), product(p, &of_p));
        let rounded = |u: f64, sense: f64| u + sense * 1e-12 * u.abs();
        let low = rounded(given[0] - 0.5 * taken[1], -1.0);
        let high = rounded(given[1] - 0.5 * taken[0], 1.0);
        let mut admissible = of_p.faded;
        admissible.add(1.0, &of_p.added);
        let gamma = 0.5 * admissible.bound();
        if !(low > 0.0 && gamma > 0.0 && gamma < f64::INFINITY) {
            return None;
        }
        let energy = [low, high + gamma];
        let (computed, stiffness) = (dot(p), dot(&m));
        let force = if law == Law::Flat {
            let depth = f.value(rings.rings[contact.iter().position(|c| *c)?][1]);
            energy.map(|u| 2.0 * u / depth)
        } else {
            let residual = |q: &[f64]| {
                let (w, u) = (work(q), product(q, &of_p));
                [w[0] - u[1], w[1] - u[0]]
            };
            let of_m = rings.norm(&request(&m, None, &contact, false));
            let mut force =
                [computed + residual(&m)[0] - (of_p.faded.bound() * of_m.faded.bound()).sqrt(), f64::INFINITY];
            if let Law::Depth(depth) = law {
                force[0] = force[0].max(2.0 * low / depth);
            }
            let reach: Vec<bool> =
                (0..p.len()).map(|i| contact[i] || (rings.loaded[i] && of_p.highest[i] > -of_p.above)).collect();
            let tau = (of_m.faded.bound() / (2.0 * gamma)).sqrt();
            if !tau.is_finite() {
                return None;
            }
            // With all of m, where p is nowhere much smaller.
            let all = (0..p.len()).filter(|&i| contact[i]).map(|i| m[i] / p[i]).fold(0.0, f64::max);
            for tau in std::iter::once(tau).chain((all > tau && all < LARGER * tau).then_some(all)) {
                let kept: Vec<bool> = (0..p.len()).map(|i| contact[i] && m[i] >= 0.0 && m[i] <= tau * p[i]).collect();
                let fixed: Vec<f64> =
                    (0..p.len()).map(|i| if kept[i] { 0.0 } else { m[i].min(tau * p[i]).max(0.0) }).collect();
                let u = s.product(&fixed);
                let rest: Vec<f64> = rings.areas.iter().zip(&u).map(|(a, u)| a - u).collect();
                let free =
                    if kept.contains(&true) { solve_on(&factor(s, &kept)?, &kept, &rest) } else { vec![0.0; p.len()] };
                let limited: Vec<f64> = (0..p.len()).map(|i| (free[i] + fixed[i]).min(tau * p[i]).max(0.0)).collect();
                let own = RadialRequest { pressure: &limited, overlap: None, full: &reach, admissible: false };
                let a = rings.norm(&own).faded.bound();
                let both = if tau <= (a / (2.0 * gamma)).sqrt() {
                    (2.0 * gamma * a).sqrt()
                } else {
                    tau * gamma + a / (2.0 * tau)
                };
                let shift = residual(&limited);
                force[1] = force[1].min(computed + shift[1] + both);
                force[0] = force[0].max(computed + shift[0] - (2.0 * gamma * a).sqrt());
            }
            let rounding = 1e-11 * computed.abs();
            [force[0] - rounding, force[1] + rounding]
        };
        Some(Annular {
            force,
            energy,
            stiffness,
            computed,
            rings: rings.rings.iter().zip(p).filter(|(_, p)| **p > 0.0).map(|(r, p)| (*r, *p)).collect(),
            proved: true,
            unknowns: rings.rings.len(),
            errors: Errors::default(),
        })
    }

    /// The stiffness of the rings in contact as a flat punch, their area, and the largest pressure.
    fn summary(&self) -> Option<[f64; 3]> {
        let contact: Vec<bool> = self.pressure.iter().map(|p| *p > 0.0).collect();
        let m = solve_on(&factor(&self.compliance, &contact)?, &contact, &self.rings.areas);
        let stiffness = m.iter().zip(&self.rings.areas).map(|(m, area)| m * area).sum();
        let area = self.rings.areas.iter().zip(&contact).filter(|(_, touches)| **touches).map(|(area, _)| area).sum();
        Some([stiffness, area, self.pressure.iter().copied().fold(0.0, f64::max)])
    }

    /// By how much the pressure is less in the rings in contact beside that of the largest one, at most.
    fn drop(&self) -> f64 {
        let p = &self.pressure;
        let Some(k) = (0..p.len()).max_by(|a, b| p[*a].total_cmp(&p[*b])) else { return 0.0 };
        let beside = [k.checked_sub(1), Some(k + 1)].into_iter().flatten().filter_map(|j| p.get(j));
        beside.filter(|other| **other > 0.0).map(|other| p[k] - other).fold(0.0, f64::max)
    }

    /// What is left of them, by what fewer rings make of them; ends that are not those of the material are known to the rings beside them.
    pub fn errors(&self, fewer: &Self) -> Errors {
        let (Some(own), Some(other)) = (self.summary(), fewer.summary()) else { return Errors::default() };
        let change = |k: usize| (own[k] / other[k] - 1.0).abs();
        let ends = self.rings.rings.iter().zip(&self.pressure).zip(&self.rings.areas);
        let touches = |k: usize| self.pressure.get(k).is_some_and(|p| *p > 0.0);
        let open = |k: usize| !touches(k) && self.rings.loaded.get(k).copied().unwrap_or(false);
        let doubt: f64 = ends
            .enumerate()
            .filter(|(k, ((_, p), _))| **p > 0.0 && (open(k + 1) || k.checked_sub(1).is_some_and(open)))
            .map(|(_, (_, area))| area)
            .sum();
        let doubt = doubt / own[1];
        Errors {
            stiffness: Some(change(0) + OF_ENDS * doubt),
            area: Some(change(1) + doubt),
            largest: Some(change(2) + OF_PEAK * self.drop() / own[2]),
        }
    }
}

/// Of the drop beside the largest pressure, what its mean over a ring may leave of its peak: that of a cone.
const OF_PEAK: f64 = 0.75;

/// Share of what the ends leave of the area that the stiffness, of the size of its root, is off by.
const OF_ENDS: f64 = 0.5;

/// Distance of the bounds of an integral of f, over what it is: what they leave is part of the bounds of the energy.
const CLOSE: f64 = 1e-7;

/// Bounds of int f 2 pi r dr over [a, b].
fn integral(f: &dyn RadialBounds, [a, b]: [f64; 2], depth: u32) -> [f64; 2] {
    let (c, h) = (0.5 * (a + b), 0.5 * (b - a));
    let area = 2.0 * PI * 2.0 * h * c;
    let by_jet = f.jet([a, b]).map(|jet| {
        // With x = r - c: means over 2 pi r dr of 1, x, x^2 are 1, h^2/(3 c), h^2/3.
        let (m1, m2) = (h * h / (3.0 * c), h * h / 3.0);
        let low = |v: [f64; 2], k: f64| [v[0] * k, v[1] * k];
        let parts = [jet.value, low(jet.slope, m1), low(jet.curvature, 0.5 * m2)];
        [0, 1].map(|k| area * parts.iter().map(|p| p[k]).sum::<f64>())
    });
    let close = |sum: &[f64; 2]| depth == 0 || sum[1] - sum[0] <= CLOSE * (sum[0].abs() + sum[1].abs());
    let sum = if let Some(sum) = by_jet.filter(close) {
        sum
    } else if depth == 0 {
        f.bounds([a, b]).map(|v| area * v)
    } else {
        let (p, q) = (integral(f, [a, c], depth - 1), integral(f, [c, b], depth - 1));
        [p[0] + q[0], p[1] + q[1]]
    };
    let rounding = 1e-14 * (sum[0].abs() + sum[1].abs());
    [sum[0] - rounding, sum[1] + rounding]
}
