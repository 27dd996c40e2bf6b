//! Axisymmetric gaps whose contact is no disc: rings, rims, dished punches, toroids, any number of annuli.
//!
//! One unknown a ring, graded to the edges of the material; the same theorem and the same brackets as on plane cells
//! (`state`), with all integrals along one radius.

mod disc;
mod norm;
mod overlap;
mod rings;
mod target;

pub(crate) use overlap::{RadialBounds, RadialJet};

use super::Limits;
use super::active_set::{factor, solve, solve_on};
use super::rectilinear::{graded, graded_both};
use norm::{RadialNorm, RadialRequest};
use rings::Rings;

/// Radii between which f may be positive, and at which ends the material ends there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    /// Inner and outer radius.
    pub radii: [f64; 2],
    /// The material ends at the inner, the outer radius.
    pub edges: [bool; 2],
}

/// What is known of the gap besides its overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Law {
    /// f is constant where there is material: P d = 2 U with d = f.
    Flat,
    /// f = depth - gap with a gap that is nowhere negative: P >= 2 U/depth.
    Depth(f64),
    /// Nothing.
    Any,
}

/// What is proved of an annular contact, E* = 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Annular {
    /// The force.
    pub force: [f64; 2],
    /// The stored energy.
    pub energy: [f64; 2],
    /// The stiffness of the computed contact rings as a flat punch: dP/dd there.
    pub stiffness: f64,
    /// The computed force.
    pub computed: f64,
    /// Inner and outer radius and pressure of each ring in contact.
    pub rings: Vec<([f64; 2], f64)>,
    /// Whether the bounds of the force are proved; estimates else.
    pub proved: bool,
    /// Rings of the last mesh.
    pub unknowns: usize,
}

/// Rings per half span of the first mesh.
const FIRST: usize = 6;

/// Solves on rings of rising number until the half width of the force is within the tolerance; `spans` cover f > 0, by rising
/// radius. None where nothing touches or a bound failed.
#[must_use]
pub(crate) fn annular(f: &dyn RadialBounds, spans: &[Span], law: Law, limits: &Limits) -> Option<Annular> {
    let mut before = limits.deadline.remaining();
    let mut n = FIRST;
    // The last mesh: its rings to a half span and the width of its bounds.
    let mut last: Option<(usize, f64)> = None;
    // Of all meshes: rings to a half span and the computed force.
    let mut forces: Vec<(usize, f64)> = Vec::new();
    let mut best: Option<Annular> = None;
    let mut contact: Vec<[f64; 2]> = Vec::new();
    loop {
        if contact.is_empty() {
            // Where the contact ends is not known yet: even rings first.
            contact = touching(&mesh(spans, &[], f.nodes(), 4 * n), f)?;
        }
        let rings = mesh(spans, &contact, f.nodes(), n);
        contact = touching(&rings, f)?;
        let Some(found) = bracket(&rings, f, law) else { return best };
        let own = half_width(found.force);
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].min(b[1])];
        let found = match &best {
            Some(b) => Annular { force: join(found.force, b.force), energy: join(found.energy, b.energy), ..found },
            None => found,
        };
        let width = half_width(found.force);
        let (unknowns, computed) = (found.unknowns, found.computed);
        forces.push((n, computed));
        let estimate = left_of(&forces);
        best = Some(found);
        if width <= limits.tolerance {
            return best;
        }
        let order = last
            .filter(|(_, before)| *before > own && own.is_finite())
            .map_or(2.0, |(coarser, before)| ((before / own).ln() / (n as f64 / coarser as f64).ln()).clamp(1.0, 3.0));
        let factor = if width.is_finite() { (width / limits.tolerance).powf(1.0 / order) } else { 2.0 };
        let wanted = (n as f64 * factor).ceil();
        let next = (wanted as usize).clamp(n + 2 + n / 8, 2 * n);
        let growth = next as f64 / n as f64;
        let too_many = |most: usize, growth: f64| unknowns as f64 * growth > most as f64;
        let too_long = (before - limits.deadline.remaining()) * growth.powi(2) > limits.deadline.remaining();
        // A proof that is far is left, once what it would prove is known.
        let far = !limits.proof || too_many(limits.worth, wanted / n as f64) || too_long;
        if far && estimate <= limits.tolerance {
            return best.map(|best| best.estimated(estimate));
        }
        if too_many(limits.unknowns, growth) || too_long {
            return best;
        }
        last = Some((n, own));
        (n, before) = (next, limits.deadline.remaining());
    }
}

/// Half the width of bounds, relative.
fn half_width([low, high]: [f64; 2]) -> f64 {
    (high - low) / (high + low)
}

/// What is left of a force, relative, by what the last two steps from mesh to mesh leave of it: second order beside free ends, third at
/// edges, the slower one; a step may be small by where the contact ends between rings.
fn left_of(forces: &[(usize, f64)]) -> f64 {
    let Some((n, last)) = forces.last() else { return f64::INFINITY };
    let left = |pair: &[(usize, f64)]| {
        let [(coarse, before), (fine, after)] = [pair[0], pair[1]];
        let ratio = |a: usize, b: usize| (a as f64 / b as f64).powi(2);
        (after - before).abs() / (ratio(fine, coarse) - 1.0) * ratio(fine, *n)
    };
    let steps: Vec<f64> = forces.windows(2).rev().take(2).map(left).collect();
    if steps.len() < 2 { f64::INFINITY } else { SAFE * steps.into_iter().fold(0.0, f64::max) / last }
}

/// Room for steps that are no power of the rings.
const SAFE: f64 = 1.5;

impl Annular {
    /// The computed force with this relative error, as far as the bounds let it be.
    fn estimated(mut self, error: f64) -> Self {
        let [low, high] = self.force;
        self.force = [(self.computed * (1.0 - error)).max(low), (self.computed * (1.0 + error)).min(high)];
        self.proved = false;
        self
    }
}

/// The rings of the spans: graded to the edges of the material and, in the last contact, to kinks; beside a free end of it finer, and
/// coarser away from it.
fn mesh(spans: &[Span], contact: &[[f64; 2]], kinks: &[f64], n: usize) -> Rings {
    let (mut rings, mut loaded) = (Vec::new(), Vec::new());
    for (index, span) in spans.iter().enumerate() {
        let [a, b] = span.radii;
        // The fades of neighbours do not meet.
        let before = if index > 0 { 0.5 * (a - spans[index - 1].radii[1]) } else { a };
        let beyond = spans.get(index + 1).map_or(f64::INFINITY, |next| 0.5 * (next.radii[0] - b));
        let inside: Vec<[f64; 2]> = contact.iter().copied().filter(|c| c[1] > a && c[0] < b).collect();
        let mut nodes = vec![a];
        if span.edges == [true, true] && inside.is_empty() {
            nodes = graded_both(a, b, n, 4.0);
        } else if inside.is_empty() {
            // The last one ends where the span does, to the last digit: the material may end there.
            let even = (1..2 * n).map(|i| a + (b - a) * i as f64 / (2 * n) as f64).chain([b]);
            nodes.extend(even.chain(kinks.iter().copied().filter(|k| *k > a && *k < b)));
            nodes.sort_by(f64::total_cmp);
            nodes.dedup();
        }
        for (k, c) in inside.iter().enumerate() {
            let edge = |high: bool| {
                let (end, limit) = if high { (c[1], b) } else { (c[0], a) };
                span.edges[usize::from(high)] && end == limit
            };
            let apart = APART * (c[1] - c[0]);
            let at_kink = |r: f64| kinks.iter().any(|k| (k - r).abs() <= apart);
            let inner = kinks.iter().copied().filter(|k| *k > c[0] + apart && *k < c[1] - apart);
            let cuts: Vec<f64> = std::iter::once(c[0]).chain(inner).chain([c[1]]).collect();
            let long = |k: usize| k.checked_add(1).and_then(|m| Some(cuts.get(m)? - cuts[k])).unwrap_or(0.0);
            let mut own = vec![c[0]];
            for (k, pair) in cuts.windows(2).enumerate() {
                let exponent = |high: bool| {
                    let (outermost, beside) =
                        if high { (k + 2 == cuts.len(), long(k + 1)) } else { (k == 0, long(k.wrapping_sub(1))) };
                    let steep = if outermost {
                        edge(high) || at_kink(pair[usize::from(high)])
                    } else {
                        beside < SHORT * long(k)
                    };
                    if steep { 4.0 } else { 2.0 }
                };
                let middle = 0.5 * (pair[0] + pair[1]);
                let mut low = graded(middle, pair[0], n, exponent(false));
                low.reverse();
                own.extend(low.into_iter().skip(1));
                own.extend(graded(middle, pair[1], n, exponent(true)).into_iter().skip(1));
            }
            // From what is there to the contact: rings that grow away from it.
            let from = *nodes.last().unwrap_or(&a);
            if own[0] > from {
                let outer = away(own[0], from, own[1] - own[0]);
                nodes.extend(outer.into_iter().rev().skip(1));
                nodes.push(own[0]);
            }
            let last = own[own.len() - 1];
            let step = last - own[own.len() - 2];
            nodes.extend(own.into_iter().skip(1));
            let until = inside.get(k + 1).map_or(b, |next| 0.5 * (c[1] + next[0]));
            if until > last {
                nodes.extend(away(last, until, step));
            }
        }
        if span.edges[0] || a > 0.0 {
            let width = (nodes[1] - nodes[0]).min(before);
            if width > 0.0 {
                rings.push([a - width, a]);
                loaded.push(false);
            }
        }
        for pair in nodes.windows(2) {
            rings.push([pair[0], pair[1]]);
            loaded.push(true);
        }
        let last = nodes.len() - 1;
        rings.push([nodes[last], nodes[last] + (nodes[last] - nodes[last - 1]).min(beyond)]);
        loaded.push(false);
    }
    Rings::new(rings, loaded)
}

/// Distance of a kink from the end of a contact, over the width of that, below which they are one.
const APART: f64 = 1e-6;

/// A part of a contact, over its neighbour, at which that ends as at an edge: pressure grows towards a corner that it passes by little.
const SHORT: f64 = 0.2;

/// Nodes after `from` up to `to`, steps growing by a half from `step`.
fn away(from: f64, to: f64, step: f64) -> Vec<f64> {
    let sign = (to - from).signum();
    let (mut nodes, mut at, mut step) = (Vec::new(), from, step);
    while (to - at) * sign > 1.5 * step {
        at += sign * step;
        nodes.push(at);
        step *= 1.5;
    }
    nodes.push(to);
    nodes
}

/// The integrals of f over the rings; zero beside the spans.
fn loads(rings: &Rings, f: &dyn RadialBounds) -> Vec<[f64; 2]> {
    rings
        .rings
        .iter()
        .zip(&rings.loaded)
        .map(|(r, loaded)| if *loaded { integral(f, *r, 12) } else { [-1.0; 2] })
        .collect()
}

/// Distance of the bounds of an integral of f, over what it is: what they leave is part of the bounds of the energy.
const CLOSE: f64 = 1e-7;

/// Bounds of int f 2 pi r dr over [a, b].
fn integral(f: &dyn RadialBounds, [a, b]: [f64; 2], depth: u32) -> [f64; 2] {
    let (c, h) = (0.5 * (a + b), 0.5 * (b - a));
    let area = 2.0 * std::f64::consts::PI * 2.0 * h * c;
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

/// The intervals in contact.
fn touching(rings: &Rings, f: &dyn RadialBounds) -> Option<Vec<[f64; 2]>> {
    let rhs: Vec<f64> = loads(rings, f).iter().map(|l| 0.5 * (l[0] + l[1])).collect();
    let p = solve(&rings.compliance(), &rhs);
    let mut list: Vec<[f64; 2]> = Vec::new();
    for ([a, b], p) in rings.rings.iter().zip(&p) {
        if *p > 0.0 {
            match list.last_mut() {
                Some(last) if last[1] == *a => last[1] = *b,
                _ => list.push([*a, *b]),
            }
        }
    }
    (!list.is_empty()).then_some(list)
}

/// How many times the first tau of (5) is worth a second.
const LARGER: f64 = 20.0;

/// The brackets on one mesh: (1), (4) and (5) of `state`.
fn bracket(rings: &Rings, f: &dyn RadialBounds, law: Law) -> Option<Annular> {
    let loads = loads(rings, f);
    let s = rings.compliance();
    let rhs: Vec<f64> = loads.iter().map(|l| 0.5 * (l[0] + l[1])).collect();
    let p = &solve(&s, &rhs);
    let contact: Vec<bool> = p.iter().map(|v| *v > 0.0).collect();
    let l = factor(&s, &contact)?;
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
        for (q, f) in q.iter().zip(&loads) {
            let (a, b) = (q * f[0], q * f[1]);
            sum = [sum[0] + a.min(b), sum[1] + a.max(b)];
        }
        sum
    };
    let dot = |q: &[f64]| q.iter().zip(&rings.areas).map(|(q, a)| q * a).sum::<f64>();
    // <f, p> - <p, S p>/2 is known between bounds: the energy is above the lower one, and gamma above the upper one at most.
    let (given, taken) = (work(p), product(p, &of_p));
    let [low, high] = [given[0] - 0.5 * taken[1], given[1] - 0.5 * taken[0]].map(|u| (u, 1e-12 * u.abs()));
    let (low, high) = (low.0 - low.1, high.0 + high.1);
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
        let mut force = [computed + residual(&m)[0] - (of_p.faded.bound() * of_m.faded.bound()).sqrt(), f64::INFINITY];
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
                if kept.contains(&true) { solve_on(&factor(&s, &kept)?, &kept, &rest) } else { vec![0.0; p.len()] };
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
    })
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// f = c0 + c1 r + c2 r^2.
    pub struct Quadratic(pub [f64; 3]);

    impl RadialBounds for Quadratic {
        fn value(&self, r: f64) -> f64 {
            let [a, b, c] = self.0;
            a + r * (b + r * c)
        }

        fn bounds(&self, [a, b]: [f64; 2]) -> [f64; 2] {
            let [_, b1, c] = self.0;
            let mut values = vec![self.value(a), self.value(b)];
            let top = -0.5 * b1 / c;
            if c != 0.0 && top > a && top < b {
                values.push(self.value(top));
            }
            let size = 1e-15 * self.0.iter().map(|v| v.abs()).sum::<f64>();
            [
                values.iter().copied().fold(f64::INFINITY, f64::min) - size,
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max) + size,
            ]
        }

        fn jet(&self, [a, b]: [f64; 2]) -> Option<RadialJet> {
            let r = 0.5 * (a + b);
            let (v, s, c) = (self.value(r), self.0[1] + 2.0 * self.0[2] * r, 2.0 * self.0[2]);
            let e = 1e-15 * self.0.iter().map(|v| v.abs()).sum::<f64>();
            Some(RadialJet { value: [v - e, v + e], slope: [s - e, s + e], curvature: [c, c] })
        }
    }

    fn met(a: &Annular) -> bool {
        a.proved && a.force[1] - a.force[0] <= 1e-3 * (a.force[0] + a.force[1])
    }

    /// Nystroem method with a split logarithm, twelve digits.
    #[test]
    fn flat_annuli() {
        for (inner, exact) in
            [(0.1, 0.999_864_355_578), (0.5, 0.981_017_896_923), (0.9, 0.821_029_779_368), (0.99, 0.608_763_092_119)]
        {
            let span = Span { radii: [inner, 1.0], edges: [true, true] };
            let a = annular(&Quadratic([1.0, 0.0, 0.0]), &[span], Law::Flat, &Limits::default()).unwrap();
            assert!(met(&a) && a.force[0] <= 2.0 * exact && a.force[1] >= 2.0 * exact);
        }
    }

    #[test]
    fn flat_disc_and_sphere() {
        let span = Span { radii: [0.0, 1.0], edges: [false, true] };
        let a = annular(&Quadratic([1.0, 0.0, 0.0]), &[span], Law::Flat, &Limits::default()).unwrap();
        assert!(met(&a) && a.force[0] <= 2.0 && a.force[1] >= 2.0);
        let span = Span { radii: [0.0, 1.0], edges: [false, false] };
        let a = annular(&Quadratic([1.0, 0.0, -1.0]), &[span], Law::Depth(1.0), &Limits::default()).unwrap();
        let exact = 4.0 / 3.0 / 2f64.sqrt();
        assert!(a.force[0] <= exact && a.force[1] >= exact);
    }

    /// Dished punch and toroid of the stress scenes: rings refined by an independent program, 1e-5.
    #[test]
    fn dished_and_toroid() {
        // 0.001 (1 - r^2) at depth 5e-4, in units of the depth: f = 1 - 2 (1 - r^2).
        let span = Span { radii: [0.5f64.sqrt(), 1.0], edges: [false, true] };
        let a = annular(&Quadratic([-1.0, 0.0, 2.0]), &[span], Law::Depth(1.0), &Limits::default()).unwrap();
        let exact = 6.81695e-4 / 5e-4;
        assert!(a.force[0] <= exact * (1.0 + 2e-5) && a.force[1] >= exact * (1.0 - 2e-5));
        // s191: (r - R)^2/(2 rho), depth d, in units of R and d.
        let (radius, rho, depth) = (0.0025732_f64, 0.00023975_f64, 1.1789e-5_f64);
        let c = radius * radius / (2.0 * rho * depth);
        let half = (2.0 * rho * depth).sqrt() / radius;
        let span = Span { radii: [1.0 - half, 1.0 + half], edges: [false, false] };
        let a = annular(&Quadratic([1.0 - c, 2.0 * c, -c]), &[span], Law::Depth(1.0), &Limits::default()).unwrap();
        let e_star = 1.0 / ((1.0 - 0.25) / (2.0 * 75485000.0) + (1.0 - 0.01) / 1e12);
        let exact = 7.69139 / (e_star * radius * depth);
        assert!(a.force[0] <= exact * (1.0 + 2e-5) && a.force[1] >= exact * (1.0 - 2e-5));
    }

    /// f = 0.6 - (1 + cos pi r) - 0.045 r^2, which no polynomial of second degree is.
    struct Wave;

    impl RadialBounds for Wave {
        fn value(&self, r: f64) -> f64 {
            0.6 - (1.0 + (PI * r).cos()) - 0.045 * r * r
        }

        fn bounds(&self, [a, b]: [f64; 2]) -> [f64; 2] {
            let h = 0.5 * (b - a);
            let (value, slope) = (self.value(0.5 * (a + b)), (PI + 0.09 * b) * h);
            [value - slope, value + slope]
        }

        fn jet(&self, [a, b]: [f64; 2]) -> Option<RadialJet> {
            let (r, h) = (0.5 * (a + b), 0.5 * (b - a));
            let around = |v: f64, by: f64| [v - by, v + by];
            Some(RadialJet {
                value: around(self.value(r), 1e-14),
                slope: around(PI * (PI * r).sin() - 0.09 * r, 1e-14),
                curvature: around(PI * PI * (PI * r).cos() - 0.09, PI.powi(3) * h),
            })
        }
    }

    #[test]
    fn rings_end_where_their_span_does() {
        // 48 parts of the width add up to another radius.
        let end = 0.999_999_999_999_99_f64;
        assert!(end * 48.0 / 48.0 != end);
        let span = Span { radii: [0.0, end], edges: [false, true] };
        let found = annular(&Quadratic([0.008, 0.0, 1.0]), &[span], Law::Any, &Limits::default()).unwrap();
        assert!(met(&found) && found.rings.last().unwrap().0[1] == end, "{:?}", found.force);
    }

    #[test]
    fn bounds_of_an_energy_hold_those_of_finer_rings() {
        let root = |from: f64, to: f64| crate::numeric::scalar::root(|r| Wave.value(r), from, to).unwrap().at;
        let span = |radii: [f64; 2]| Span { radii, edges: [false; 2] };
        let waves = [span([root(0.1, 1.0), root(1.0, 2.0)]), span([root(2.0, 3.0), root(3.0, 4.0)])];
        let toroid = [span([0.8, 1.2])];
        let both: [(&dyn RadialBounds, &[Span]); 2] = [(&Wave, &waves), (&Quadratic([-24.0, 50.0, -25.0]), &toroid)];
        for (f, spans) in both {
            let on = |n: usize| {
                let contact = touching(&mesh(spans, &[], &[], 4 * n), f).unwrap();
                bracket(&mesh(spans, &contact, &[], n), f, Law::Any).unwrap()
            };
            let fine = on(60);
            for n in [6, 8, 12, 18, 27] {
                let coarse = on(n);
                for [a, b] in [[coarse.energy, fine.energy], [coarse.force, fine.force]] {
                    assert!(a[0] <= b[0] && b[1] <= a[1], "{n}: {a:?} does not hold {b:?}");
                }
            }
        }
    }
}
