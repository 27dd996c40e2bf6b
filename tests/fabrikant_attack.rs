//! The stationary boundary of random gaps: an answer that satisfies equation (15) by a quadrature of its own, or a verdict.

use std::f64::consts::{FRAC_PI_2, TAU};

use contact_patch::Verdict;
use contact_patch::fabrikant::{self, Approximation, Settings};
use contact_patch::gap::{AnyGap, Cone, Gap, Paraboloid, Polyhedron};
use contact_patch::{EffectiveModulus, ritz};

struct Random(u64);

impl Random {
    /// Uniform in [-1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in its logarithm, in [a, b).
    fn between(&mut self, a: f64, b: f64) -> f64 {
        a * (b / a).powf(0.5 * (self.next() + 1.0))
    }

    fn below(&mut self, n: usize) -> usize {
        (0.5 * (self.next() + 1.0) * n as f64) as usize
    }
}

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).unwrap()
}

/// A regular pyramid of slope 1.
fn faces(n: usize) -> Vec<[f64; 3]> {
    (0..n).map(|k| TAU * k as f64 / n as f64).map(|t| [t.cos(), t.sin(), 0.0]).collect()
}

/// G(a) of equation (12) at one angle, by Simpson's rule on t between the kinks, and G_a by differences of it.
struct Ray<'a> {
    gap: &'a dyn Gap,
    centre: [f64; 2],
    depth: f64,
    angle: f64,
    kinks: Vec<f64>,
}

impl<'a> Ray<'a> {
    fn new(gap: &'a dyn Gap, centre: [f64; 2], depth: f64, angle: f64) -> Self {
        let (mut kinks, (sin, cos)) = (Vec::new(), angle.sin_cos());
        gap.ray_kinks(centre, [cos, sin], &mut kinks);
        kinks.sort_by(f64::total_cmp);
        Self { gap, centre, depth, angle, kinks }
    }

    fn g(&self, a: f64) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        let f = |t: f64| {
            let r = a * t.sin();
            (self.depth - self.gap.gap(self.centre[0] + r * cos, self.centre[1] + r * sin)) * t.sin()
        };
        let mut ends = vec![0.0];
        ends.extend(self.kinks.iter().filter(|&&k| k < a).map(|k| (k / a).asin()));
        ends.push(FRAC_PI_2);
        let steps = 200;
        let panel = |w: &[f64]| {
            let h = (w[1] - w[0]) / f64::from(steps);
            let weight = |k: i32| if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            (0..=steps).map(|k| weight(k) * f(w[0] + h * f64::from(k))).sum::<f64>() * h / 3.0
        };
        a * a * ends.windows(2).map(panel).sum::<f64>()
    }
}

/// Equation (15) and the local maximum by means of nothing but the gap and the boundary that came out: on every ray G - D a is
/// less on both sides, and its sum over the angle is zero (D = P/2E*).
fn check(what: &str, gap: &dyn Gap, depth: f64, found: &Approximation) {
    assert!((found.force / 2.0 / found.d - 1.0).abs() < 1e-14, "{what}");
    // What the solver stops at for a tolerance of 1e-6.
    assert!(found.residual <= 1e-5, "{what}: {}", found.residual);
    let (centre, outline) = (found.boundary.centre, &found.boundary.outline);
    // The trapezoid rule over the outline's own points: good to the square of their distance.
    let (mut sum, mut all) = (0.0, 0.0);
    for (k, &[angle, a]) in outline.iter().enumerate() {
        let [before, after] = [outline.len() - 1, 1].map(|m| outline[(k + m) % outline.len()][0]);
        let weight = 0.5 * (after - before).rem_euclid(TAU);
        let ray = Ray::new(gap, centre, depth, angle);
        let gain = |a: f64| ray.g(a) - found.d * a;
        let here = gain(a);
        sum += weight * here;
        all += weight * found.d * a;
        if k % 7 == 0 {
            for share in [1e-2, 1e-3] {
                assert!(
                    gain(a * (1.0 + share)) < here && gain(a * (1.0 - share)) < here,
                    "{what}: {angle} {a} {share}"
                );
            }
        }
    }
    assert!(sum.abs() < 2e-4 * all, "{what}: {}", sum / all);
}

#[test]
fn disturbed_pyramids_have_their_boundary() {
    let mut random = Random(11);
    let settings = Settings { boundary_points: 360, ..Settings::with_tolerance(1e-6) };
    let mut answers = 0;
    for case in 0..150 {
        let n = 3 + random.below(8);
        let size = random.between(1e-7, 0.1);
        let mut planes = faces(n);
        match case % 3 {
            0 => planes[random.below(n)][2] += size,
            1 => planes.iter_mut().for_each(|p| p[2] += size * random.next()),
            _ => planes.iter_mut().flatten().for_each(|v| *v += size * random.next()),
        }
        let (gap, what) = (Polyhedron::new(planes).unwrap(), format!("{case}: {n} faces, {size:.1e}"));
        match fabrikant::stationary(&gap, unit(), 1.0, &settings) {
            Ok(found) => {
                answers += 1;
                check(&what, &gap, 1.0, &found);
                let ellipse = ritz::ellipse(&gap, unit(), 1.0, &settings).unwrap();
                assert!(found.force > ellipse.force * (1.0 - 1e-6), "{what}");
            }
            // Three faces all but reach the end of the admissible interval: little is enough to push them over it.
            Err(error) => {
                assert_eq!(error.verdict(), Some(Verdict::NoStationaryBoundary), "{what}: {error}");
                assert!(n == 3 || size > 0.02, "{what}: {error}");
            }
        }
    }
    assert!(answers > 130, "{answers}");
}

#[test]
fn blunt_pyramids_have_their_boundary_at_every_depth() {
    let settings = Settings { boundary_points: 720, ..Settings::with_tolerance(1e-6) };
    let mut random = Random(5);
    for case in 0..80 {
        let n = 3 + case % 8;
        let depth = random.between(1e-3, 1e3);
        let gap = Polyhedron::truncated_pyramid(n, 0.4, 1.0).unwrap();
        let found = fabrikant::stationary(&gap, unit(), depth, &settings).map_err(|e| format!("{n} {depth}: {e}"));
        check(&format!("{n} faces at {depth}"), &gap, depth, &found.unwrap());
    }
    // Where a ray has two maxima, one at the edge of the flat and one beyond.
    let gap = Polyhedron::truncated_pyramid(4, 22f64.to_radians(), 1e-6).unwrap();
    for k in -10..=10 {
        let depth = 2e-6 * (1.0 + 5e-4 * f64::from(k));
        let found = fabrikant::stationary(&gap, unit(), depth, &settings).unwrap();
        check(&format!("worn Vickers pyramid at {depth:e}"), &gap, depth, &found);
    }
}

/// Whatever the planes: an answer or a verdict about the boundary, never a limit of iterations.
#[test]
fn planes_at_random_get_an_answer_or_a_verdict() {
    let mut random = Random(3);
    let settings = Settings { boundary_points: 360, ..Settings::with_tolerance(1e-6) };
    let mut answers = 0;
    for case in 0..200 {
        let n = 3 + random.below(8);
        let planes = (0..n).map(|_| [random.next(), random.next(), 0.3 * random.next()]).collect();
        let gap = Polyhedron::new(planes).unwrap();
        let [x, y] = gap.describe().centre;
        let depth = gap.gap(x, y) + random.between(0.01, 100.0);
        match fabrikant::stationary(&gap, unit(), depth, &settings) {
            Ok(found) => {
                answers += 1;
                check(&format!("{case}"), &gap, depth, &found);
            }
            Err(error) => assert!(
                matches!(
                    error.verdict(),
                    Some(Verdict::NoStationaryBoundary | Verdict::Unbounded | Verdict::NotStarShaped)
                ),
                "{case}: {error}"
            ),
        }
    }
    assert!(answers > 3, "{answers}");
}

/// A tilted cone has its apex off the centre: force by the fft method 0.64321 for the first, and 0.25 % off is the method's error.
#[test]
fn tilted_cones_have_their_boundary() {
    let settings = Settings::with_tolerance(1e-5);
    let cone = AnyGap::new(Cone::with_slope(1.0).unwrap());
    for (tilt, fft) in [([0.1, 0.05], Some(0.643_208)), ([0.02, 0.0], None), ([0.0, 0.2], None), ([0.3, 0.1], None)] {
        let gap = cone.clone().tilted(tilt);
        let found = fabrikant::stationary(&gap, unit(), 1.0, &settings).map_err(|e| format!("{tilt:?}: {e}")).unwrap();
        // The force at most falls short of the level cone's by the error of the method: a tilt adds overlap as it takes away.
        assert!(found.force > 0.99 * 2.0 / std::f64::consts::PI, "{tilt:?}: {}", found.force);
        assert!(fft.is_none_or(|fft| (found.force / fft - 1.0).abs() < 2.5e-3), "{tilt:?}: {}", found.force);
    }
}

/// A ridge that the gap does not tell about.
#[test]
fn hidden_ridges_are_found() {
    let settings = Settings::with_tolerance(1e-5);
    let told = AnyGap::new(Paraboloid::new([1.0, 1.0]).unwrap());
    for (slope, off) in [(0.5, 0.0), (1.0, 0.1), (0.3, -0.2)] {
        let hidden = move |x: f64, y: f64| 0.5 * (x * x + y * y) + slope * (x - off).abs() * 0.3;
        let planes = vec![[0.3 * slope, 0.0, -0.3 * slope * off], [-0.3 * slope, 0.0, 0.3 * slope * off]];
        let ridge = AnyGap::new(Polyhedron::new(planes).unwrap());
        let sum = contact_patch::gap::Sum::new(vec![told.clone(), ridge]).unwrap();
        let [a, b] =
            [AnyGap::from(&hidden), AnyGap::from(&sum)].map(|gap| fabrikant::stationary(&gap, unit(), 1.0, &settings));
        let (a, b) = (a.unwrap().force, b.unwrap().force);
        assert!((a / b - 1.0).abs() < 2e-5, "{slope} {off}: {a} {b}");
    }
}
