//! Axisymmetric gaps whose contact is no disc: rings, rims, dished punches, toroids, any number of annuli.
//!
//! One unknown a ring, graded to the edges of the material; the same theorem and the same brackets as on plane cells
//! (`state`), with all integrals along one radius.

mod disc;
mod mesh;
mod norm;
mod overlap;
mod pressed;
mod rings;
mod target;

pub(crate) use overlap::{RadialBounds, RadialJet};

use super::Limits;
use mesh::mesh;
use pressed::Pressed;

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
    /// What else is estimated.
    pub errors: Errors,
}

/// Estimates of relative errors; `None` where nothing tells them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Errors {
    pub stiffness: Option<f64>,
    pub area: Option<f64>,
    /// Of the largest pressure, where that is finite.
    pub largest: Option<f64>,
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
            contact = Pressed::new(mesh(spans, &[], f.nodes(), 4 * n), f).contact()?;
        }
        let pressed = Pressed::new(mesh(spans, &contact, f.nodes(), n), f);
        // What a mesh with fewer rings on the same contact finds tells the other errors.
        let fewer = |contact: &[[f64; 2]]| {
            let coarser = Pressed::new(mesh(spans, contact, f.nodes(), (2 * n).div_ceil(3)), f);
            pressed.errors(&coarser)
        };
        let around = std::mem::replace(&mut contact, pressed.contact()?);
        let Some(found) = pressed.bracket(f, law) else { return best };
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
        let told = |best: Option<Annular>| best.map(|best| Annular { errors: fewer(&around), ..best });
        if width <= limits.tolerance {
            return told(best);
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
            return told(best).map(|best| best.estimated(estimate));
        }
        if too_many(limits.unknowns, growth) || too_long {
            return told(best);
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
        // Radius 1/2 pressed by 1 (Hertz): a = 2^(-1/2), K = 2 a, p_0 = 2 a/(pi R).
        let (radius, largest) = (0.5f64.sqrt(), a.rings.iter().map(|(_, p)| *p).fold(0.0, f64::max));
        let area: f64 = a.rings.iter().map(|([b, c], _)| PI * (c - b) * (c + b)).sum();
        let off = |found: f64, exact: f64| (found / exact - 1.0).abs();
        let Errors { stiffness, area: of_area, largest: of_largest } = a.errors;
        for (off, stated) in [
            (off(a.stiffness, 2.0 * radius), stiffness),
            (off(area, 0.5 * PI), of_area),
            (off(largest, 4.0 * radius / PI), of_largest),
        ] {
            assert!(stated.is_some_and(|stated| off <= stated && stated < 0.02), "{off} {stated:?}");
        }
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
                let contact = Pressed::new(mesh(spans, &[], &[], 4 * n), f).contact().unwrap();
                Pressed::new(mesh(spans, &contact, &[], n), f).bracket(f, Law::Any).unwrap()
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
