//! Closed forms against reference values made elsewhere, and the laws that every one of them obeys.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use approx::assert_relative_eq;
use contact_patch::closed_form::{
    ClosedForm, Cone, FlatEndedCone, FlatPunch, Hertz, Power, Quadratic, RoundedCone, Sneddon, Sphere,
};
use contact_patch::quadrature::{adaptive, from_zero};
use contact_patch::{EffectiveModulus, Verdict};
use proptest::prelude::*;
use serde_json::Value;

/// Asked of every closed form.
const CLOSED: f64 = 1e-13;
/// Asked of every force and depth by quadrature.
const QUADRATURE: f64 = 1e-11;

fn modulus(e_star: f64) -> EffectiveModulus {
    EffectiveModulus::from_e_star(e_star).unwrap()
}

fn unit() -> EffectiveModulus {
    modulus(1.0)
}

fn table(name: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../data/reference/closed_forms.json")).unwrap();
    all[name]["rows"].as_array().unwrap().clone()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap()
}

fn radius(contact: &ClosedForm) -> f64 {
    assert!(contact.patch.is_disc());
    contact.patch.semi_axes[0]
}

#[test]
fn hertz_at_any_axis_ratio() {
    for row in table("hertz") {
        let hertz = Hertz::new(unit(), [0.5 / number(&row, "ratio"), 0.5]).unwrap();
        assert_relative_eq!(hertz.axis_ratio(), number(&row, "k"), max_relative = CLOSED);
        for contact in [hertz.at_depth(1.0).unwrap(), hertz.at_force(number(&row, "force")).unwrap()] {
            let [a, b] = contact.patch.semi_axes;
            assert_relative_eq!(contact.depth, 1.0, max_relative = CLOSED);
            assert_relative_eq!(a, number(&row, "a"), max_relative = CLOSED);
            assert_relative_eq!(b, number(&row, "b"), max_relative = CLOSED);
            assert_relative_eq!(contact.force, number(&row, "force"), max_relative = CLOSED);
            assert_relative_eq!(contact.max_pressure().unwrap(), number(&row, "peak"), max_relative = CLOSED);
        }
    }
}

#[test]
fn hertz_inverse_table() {
    for row in table("hertz_inverse") {
        let hertz = Hertz::new(unit(), [1.0, number(&row, "ratio")]).unwrap();
        assert_relative_eq!(hertz.axis_ratio(), number(&row, "k"), max_relative = CLOSED);
    }
}

/// A kink that nobody named costs accuracy, and the error says so.
#[test]
fn sneddon_reports_its_error() {
    let exact = RoundedCone::new(unit(), 1.0, 1.0).unwrap();
    for unnamed in [0.7, 1.5, 40.0] {
        let found = Sneddon::new(unit(), |r: f64| r.min(1.0), &[], f64::INFINITY).unwrap().at_depth(unnamed).unwrap();
        let off = (found.force / exact.at_depth(unnamed).unwrap().force - 1.0).abs();
        assert!(off <= found.error && found.error < 1e-9, "{unnamed}: off {off:e}, said {:e}", found.error);
    }
}

#[test]
fn power_laws() {
    for row in table("power") {
        let n = number(&row, "exponent");
        let law = Power::new(unit(), 1.0, n).unwrap();
        // 1/n powers of a rounding: at n = 0.05 the problem itself amplifies it twentyfold.
        for contact in [law.at_depth(1.0).unwrap(), law.at_force(number(&row, "force")).unwrap()] {
            assert_relative_eq!(contact.depth, 1.0, max_relative = CLOSED);
            assert_relative_eq!(radius(&contact), number(&row, "a"), max_relative = CLOSED);
            assert_relative_eq!(contact.force, number(&row, "force"), max_relative = CLOSED);
        }
        let slope = move |r: f64| n * r.powf(n - 1.0);
        let by_slope = Sneddon::new(unit(), slope, &[], f64::INFINITY).unwrap();
        for contact in [by_slope.at_depth(1.0).unwrap(), by_slope.at_force(number(&row, "force")).unwrap()] {
            assert_relative_eq!(contact.depth, 1.0, max_relative = QUADRATURE);
            assert_relative_eq!(contact.force, number(&row, "force"), max_relative = QUADRATURE);
            assert_relative_eq!(radius(&contact), number(&row, "a"), max_relative = QUADRATURE);
        }
        if n >= 0.5 {
            let by_gap = Sneddon::of_gap(unit(), move |r| r.powf(n), &[], f64::INFINITY).unwrap();
            assert_relative_eq!(by_gap.at_depth(1.0).unwrap().force, number(&row, "force"), max_relative = QUADRATURE);
        }
    }
}

#[test]
fn power_law_pressure() {
    for row in table("power_pressure") {
        let contact = Power::new(unit(), 1.0, number(&row, "exponent")).unwrap().at_depth(1.0).unwrap();
        let p = contact.pressure(0.0, number(&row, "at") * radius(&contact));
        assert_relative_eq!(p, number(&row, "pressure"), max_relative = 2e-12);
    }
}

/// Depth, force, energy and two pressures of one row, by depth and by force.
fn check_row(row: &Value, at_depth: &ClosedForm, at_force: &ClosedForm, tolerance: f64, on_pressure: f64) {
    for contact in [at_depth, at_force] {
        assert_relative_eq!(radius(contact), number(row, "a"), max_relative = tolerance);
        assert_relative_eq!(contact.depth, number(row, "depth"), max_relative = tolerance);
        assert_relative_eq!(contact.force, number(row, "force"), max_relative = tolerance);
        assert_relative_eq!(contact.energy(), number(row, "energy"), max_relative = on_pressure);
        for pair in row["pressures"].as_array().unwrap() {
            let r = pair[0].as_f64().unwrap() * number(row, "a");
            assert_relative_eq!(contact.pressure(r, 0.0), pair[1].as_f64().unwrap(), max_relative = on_pressure);
        }
    }
}

#[test]
fn sphere() {
    let sphere = Sphere::new(unit(), 1.0).unwrap();
    let by_slope = Sneddon::new(unit(), |r| r / ((1.0 - r) * (1.0 + r)).sqrt(), &[], 1.0).unwrap();
    for row in table("sphere") {
        let (d, p) = (number(&row, "depth"), number(&row, "force"));
        check_row(&row, &sphere.at_depth(d).unwrap(), &sphere.at_force(p).unwrap(), CLOSED, 1e-11);
        check_row(&row, &by_slope.at_depth(d).unwrap(), &by_slope.at_force(p).unwrap(), QUADRATURE, 1e-7);
    }
}

/// (a/R)^3 may be below the range of numbers: Hertz to the last digits. It may be above it where the whole sphere is in contact: P = 2 E* R d.
#[test]
fn spheres_however_large_or_small() {
    for (radius, depth) in [(1.0, 1e-100), (1e80, 1e-60), (1e160, 3.7e-54), (1e-100, 1e-140)] {
        let sphere = Sphere::new(unit(), radius).unwrap();
        let found = sphere.at_depth(depth).unwrap();
        assert_relative_eq!(found.force, 4.0 / 3.0 * radius.sqrt() * depth.sqrt() * depth, max_relative = CLOSED);
        assert_relative_eq!(found.energy(), 0.4 * found.force * depth, max_relative = CLOSED);
        assert_relative_eq!(sphere.at_force(found.force).unwrap().depth, depth, max_relative = CLOSED);
    }
    for radius in [1e-3, 1e-60, 1e-110, 1e-150] {
        let sphere = Sphere::new(unit(), radius).unwrap();
        let found = sphere.at_depth(1.0).unwrap();
        assert_relative_eq!(found.force, 2.0 * radius, max_relative = radius + CLOSED);
        assert_relative_eq!(sphere.at_force(found.force).unwrap().depth, 1.0, max_relative = CLOSED);
    }
}

#[test]
fn flat_ended_cone() {
    let cone = FlatEndedCone::new(unit(), 1.0, 1.0).unwrap();
    let by_slope = Sneddon::new(unit(), |r| if r < 1.0 { 0.0 } else { 1.0 }, &[1.0], f64::INFINITY).unwrap();
    for row in table("flat_ended_cone") {
        let (d, p) = (number(&row, "depth"), number(&row, "force"));
        check_row(&row, &cone.at_depth(d).unwrap(), &cone.at_force(p).unwrap(), CLOSED, 1e-10);
        check_row(&row, &by_slope.at_depth(d).unwrap(), &by_slope.at_force(p).unwrap(), QUADRATURE, 1e-6);
    }
    // Touching with the flat only: 2 E* b d.
    assert_relative_eq!(cone.at_depth(1e-12).unwrap().force, 2e-12, max_relative = 1e-11);
    assert_relative_eq!(by_slope.at_depth(1e-12).unwrap().force, 2e-12, max_relative = 1e-11);
}

/// By quadrature as by formula, to the sides of a corner where the pressure has no bound.
#[test]
fn pressures_beside_a_corner() {
    let slope = |r: f64| if r < 1.0 { 0.0 } else { 1.0 };
    let by_slope = Sneddon::new(unit(), slope, &[1.0], f64::INFINITY).unwrap();
    for depth in [0.05, 0.4, 3.0] {
        let exact = FlatEndedCone::new(unit(), 1.0, 1.0).unwrap().at_depth(depth).unwrap();
        let found = by_slope.at_depth(depth).unwrap();
        let rim = exact.patch.semi_axes[0];
        let within = [1.0, 0.9, 0.5, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10].map(|h| 1.0 - h);
        for r in within.into_iter().chain([1.0001, 1.01, 0.5 * (1.0 + rim)]).filter(|r| *r < rim) {
            assert_relative_eq!(found.pressure(r, 0.0), exact.pressure(r, 0.0), max_relative = 1e-9);
        }
    }
}

#[test]
fn rounded_cone() {
    let cone = RoundedCone::new(unit(), 1.0, 1.0).unwrap();
    let by_slope = Sneddon::new(unit(), |r: f64| r.min(1.0), &[1.0], f64::INFINITY).unwrap();
    for row in table("rounded_cone") {
        let (d, p) = (number(&row, "depth"), number(&row, "force"));
        check_row(&row, &cone.at_depth(d).unwrap(), &cone.at_force(p).unwrap(), CLOSED, 1e-10);
        check_row(&row, &by_slope.at_depth(d).unwrap(), &by_slope.at_force(p).unwrap(), QUADRATURE, 1e-6);
    }
    let at_corner = cone.at_depth(1.0).unwrap();
    assert_relative_eq!(at_corner.force, 4.0 / 3.0, max_relative = CLOSED);
    assert_relative_eq!(cone.at_depth(1.0 + 1e-12).unwrap().force, at_corner.force, max_relative = 1e-11);
}

#[test]
fn flat_ellipse() {
    for row in table("flat_ellipse") {
        let k = number(&row, "k");
        for axes in [[2.0, 2.0 * k], [2.0 * k, 2.0]] {
            let contact = FlatPunch::ellipse(unit(), axes).unwrap().at_depth(1.0).unwrap();
            assert_relative_eq!(contact.force, 2.0 * number(&row, "force"), max_relative = CLOSED);
            assert!(contact.max_pressure().is_none());
            assert_relative_eq!(contact.pressure(0.0, 0.0), 0.5 * contact.mean_pressure(), max_relative = CLOSED);
        }
    }
}

/// One contact of every form, as functions of depth and of force.
type Form = (&'static str, Box<dyn Fn(f64) -> ClosedForm>, Box<dyn Fn(f64) -> ClosedForm>);

fn forms(e_star: f64, length: f64) -> Vec<Form> {
    let m = modulus(e_star);
    macro_rules! form {
        ($name:literal, $form:expr) => {{
            let (one, two) = ($form, $form);
            let by_depth: Box<dyn Fn(f64) -> ClosedForm> = Box::new(move |d| one.at_depth(d).unwrap());
            let by_force: Box<dyn Fn(f64) -> ClosedForm> = Box::new(move |p| two.at_force(p).unwrap());
            ($name, by_depth, by_force)
        }};
    }
    let l = length;
    vec![
        form!("circular", Hertz::circular(m, 2.0 * l).unwrap()),
        form!("elliptic", Hertz::new(m, [2.0 * l, 0.1 * l]).unwrap()),
        form!("sphere", Sphere::new(m, l).unwrap()),
        form!("cone", Cone::with_slope(m, 0.4).unwrap()),
        form!("power 0.6", Power::new(m, 0.3 * l.powf(0.4), 0.6).unwrap()),
        form!("power 3.5", Power::new(m, 0.3 * l.powf(-2.5), 3.5).unwrap()),
        form!("flat-ended", FlatEndedCone::new(m, 0.5 * l, 0.3).unwrap()),
        form!("rounded", RoundedCone::new(m, 0.5 * l, 0.3).unwrap()),
        form!("disc", FlatPunch::disc(m, l).unwrap()),
        form!("ellipse", FlatPunch::ellipse(m, [0.2 * l, l]).unwrap()),
        form!("sneddon", Sneddon::new(m, move |r| (r / l) + (r / l).powi(3), &[], f64::INFINITY).unwrap()),
    ]
}

#[test]
fn stiffness_and_energy_are_derivatives() {
    for (name, at_depth, at_force) in forms(3.0, 1.0) {
        for d in [1e-3, 0.05, 0.4] {
            let contact = at_depth(d);
            // Fourth-order difference: truncation about h^4, rounding about 1e-15/h.
            let h = 1e-3 * d;
            let four = |f: &dyn Fn(&ClosedForm) -> f64| {
                let f = |s: f64| f(&at_depth(d + s * h));
                (8.0 * (f(1.0) - f(-1.0)) - (f(2.0) - f(-2.0))) / (12.0 * h)
            };
            let stiffness = four(&|c| c.force);
            assert!(
                (stiffness / contact.stiffness - 1.0).abs() < 3e-9,
                "{name} {d}: {stiffness} {}",
                contact.stiffness
            );
            let force = four(&|c| c.energy());
            assert!((force / contact.force - 1.0).abs() < 3e-9, "{name} {d}: {force} {}", contact.force);
            let matrix = contact.stiffness_with_tilt();
            assert!((matrix[(0, 0)] / contact.stiffness - 1.0).abs() < 1e-13, "{name}");
            let back = at_force(contact.force);
            assert!((back.depth / d - 1.0).abs() < 1e-12, "{name} {d}: back {}", back.depth);
            assert!((back.energy() / contact.energy() - 1.0).abs() < 1e-10, "{name} {d}");
        }
    }
}

#[test]
fn pressure_adds_up_to_the_force() {
    for (name, at_depth, _) in forms(3.0, 1.0) {
        for d in [0.01, 0.3] {
            let contact = at_depth(d);
            let [a, b] = contact.patch.semi_axes;
            let turn = contact.patch.orientation;
            // Along one axis, rho = sin t; every closed form is a function of rho only.
            let integrand = |t: f64| {
                let x = a * t.sin();
                contact.pressure(x * turn.cos(), x * turn.sin()) * t.sin() * t.cos()
            };
            let corner = [(0.5 / a).min(1.0).asin(), (0.15 / a).min(1.0).asin()];
            let first = corner[1].min(0.5);
            let sum =
                from_zero(integrand, first, 1e-9).value + adaptive(integrand, first, FRAC_PI_2, &corner, 1e-9).value;
            let force = TAU * a * b * sum;
            assert!((force / contact.force - 1.0).abs() < 1e-6, "{name} {d}: {force} {}", contact.force);
            if let Some(peak) = contact.max_pressure() {
                let p = contact.pressure(0.0, 0.0);
                assert!(peak >= p * (1.0 - 1e-9) && peak >= contact.mean_pressure(), "{name} {d}: {peak} {p}");
            }
            assert!(contact.pressure(1.001 * a, 1.001 * a) == 0.0);
        }
    }
}

#[test]
fn more_depth_is_more_of_everything() {
    for (name, at_depth, _) in forms(1.0, 1.0) {
        let mut before = at_depth(1e-4);
        for k in 1..40 {
            let here = at_depth(1e-4 * 1.3f64.powi(k));
            assert!(here.force > before.force && here.energy() > before.energy(), "{name} {k}");
            assert!(here.stiffness >= before.stiffness * (1.0 - 1e-14), "{name} {k}");
            before = here;
        }
    }
}

/// A change of units changes nothing: E* -> e E*, lengths -> l times. Powers of two keep every rounding the same, others
/// cost a few roundings.
#[test]
fn units_do_not_matter() {
    for (e, l) in [(1e15, 1e-6), (1e-12, 1e6), (2f64.powi(40), 2f64.powi(-20))] {
        for ((name, one, _), (_, other, other_force)) in forms(1.0, 1.0).into_iter().zip(forms(e, l)) {
            for d in [1e-6, 0.3] {
                let (one, other) = (one(d), other(d * l));
                let off = |p: f64, q: f64| (p / q - 1.0).abs();
                assert!(off(other.force, one.force * e * l * l) < 1e-11, "{name} force");
                assert!(off(other.stiffness, one.stiffness * e * l) < 1e-11, "{name} stiffness");
                assert!(off(other.energy(), one.energy() * e * l * l * l) < 1e-9, "{name} energy");
                let x = 0.3 * one.patch.semi_axes[1];
                assert!(off(other.pressure(x * l, x * l), one.pressure(x, x) * e) < 1e-6, "{name} pressure");
                assert!(off(other_force(other.force).depth, d * l) < 1e-10, "{name} back");
            }
        }
    }
}

#[test]
fn extremes_stay_finite() {
    for e in [1e-12, 1e15] {
        for r in [1e-6, 1e6] {
            for d in [1e-12, 1e6] {
                let m = modulus(e);
                let sneddon = Sneddon::new(m, move |x| x / r, &[], f64::INFINITY).unwrap();
                let contacts = [
                    Hertz::new(m, [r, 1e-6]).unwrap().at_depth(d).unwrap(),
                    Sphere::new(m, r).unwrap().at_depth(d).unwrap(),
                    FlatEndedCone::new(m, r, 1e-3).unwrap().at_depth(d).unwrap(),
                    RoundedCone::new(m, r, 1e3).unwrap().at_depth(d).unwrap(),
                    FlatPunch::disc(m, r).unwrap().at_depth(d).unwrap(),
                    sneddon.at_depth(d).unwrap(),
                ];
                for (k, c) in contacts.iter().enumerate() {
                    let all = [c.force, c.depth, c.stiffness, c.energy(), c.mean_pressure(), c.patch.area()];
                    assert!(all.iter().all(|v| v.is_finite() && *v > 0.0), "{k} {e} {r} {d}: {all:?}");
                    assert!(c.max_pressure().is_none_or(|p| p.is_finite() && p > 0.0), "{k} {e} {r} {d}");
                }
                let hertz = Hertz::circular(m, r).unwrap().at_depth(d).unwrap();
                assert_relative_eq!(contacts[5].force, hertz.force, max_relative = QUADRATURE);
            }
        }
    }
}

#[test]
fn sphere_is_softer_than_its_parabola() {
    // The sphere's gap is larger, so its force is smaller; at small depth they meet. At a = 0.3: -0.93 %.
    for d in [1e-9, 1e-3, 0.092_855_881_260_933_51, 1.0] {
        let sphere = Sphere::new(unit(), 1.0).unwrap().at_depth(d).unwrap().force;
        let parabola = Hertz::circular(unit(), 1.0).unwrap().at_depth(d).unwrap().force;
        assert!(sphere < parabola);
        assert!(sphere > parabola * (1.0 - 0.15 * d));
    }
}

#[test]
fn flat_punch_with_a_tilt() {
    let k = 0.3;
    let punch = FlatPunch::ellipse(unit(), [1.0, k]).unwrap();
    let contact = punch.at_tilted_depth(1.0, [0.2, 0.1]).unwrap();
    // Moments of the pressure over the ellipse, against the stiffness and the line of action.
    let moment = |weight: &dyn Fn(f64, f64) -> f64| {
        let n = 64;
        let ring = |t: f64| {
            let rho = t.sin();
            let mean = (0..n)
                .map(|j| {
                    let (sin, cos) = (TAU * j as f64 / n as f64).sin_cos();
                    let (x, y) = (rho * cos, k * rho * sin);
                    contact.pressure(x, y) * weight(x, y)
                })
                .sum::<f64>()
                / n as f64;
            mean * t.sin() * t.cos()
        };
        TAU * k * adaptive(ring, 0.0, FRAC_PI_2, &[], 1e-10).value
    };
    let full = contact.stiffness_with_tilt() * nalgebra::Vector3::new(1.0, 0.2, 0.1);
    let measured = [moment(&|_, _| 1.0), moment(&|x, _| x), moment(&|_, y| y)];
    let [x, y] = contact.line_of_action();
    for (found, expected) in measured.iter().zip([full[0], full[1], full[2]]) {
        assert_relative_eq!(*found, expected, max_relative = 1e-8);
    }
    assert_relative_eq!(x, full[1] / full[0], max_relative = 1e-13);
    assert_relative_eq!(y, full[2] / full[0], max_relative = 1e-13);
    let back = punch.at_force_through(contact.force, [x, y]).unwrap();
    assert_relative_eq!(back.tilt[0], 0.2, max_relative = 1e-13);
    assert_relative_eq!(back.depth, 1.0, max_relative = 1e-13);
    // The core of a disc reaches to a third of its radius.
    let disc = FlatPunch::disc(unit(), 3.0).unwrap();
    assert!(disc.at_force_through(1.0, [0.7, 0.7]).is_ok());
    assert_eq!(disc.at_force_through(1.0, [0.72, 0.72]).unwrap_err().verdict, Verdict::NoClosedForm);
}

/// The displacement of the tilted elliptic punch, by quadrature of p/r in polar coordinates about an inner point, is
/// d + tilt . (x, y): an independent check of the two rotational stiffnesses.
#[test]
fn tilted_ellipse_displaces_a_plane() {
    let (a, b) = (1.0, 0.4);
    let contact = FlatPunch::ellipse(unit(), [a, b]).unwrap().at_tilted_depth(1.0, [0.3, 0.4]).unwrap();
    for [x, y] in [[0.0, 0.0], [0.3, 0.1], [-0.5, 0.05]] {
        let n = 96;
        let along = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            // 1 - rho^2 along the ray: c - 2 h r - m r^2; r = middle + half sin t takes the edge singularity away.
            let (m, h) = ((cos / a).powi(2) + (sin / b).powi(2), x * cos / a / a + y * sin / b / b);
            let c = 1.0 - (x / a).powi(2) - (y / b).powi(2);
            let (middle, half) = (-h / m, (h * h + m * c).sqrt() / m);
            let integrand = |t: f64| {
                let r = middle + half * t.sin();
                contact.pressure(x + r * cos, y + r * sin) * half * t.cos()
            };
            adaptive(integrand, (-middle / half).asin(), FRAC_PI_2, &[], 1e-8).value
        };
        let u = (0..n).map(|j| along(TAU * j as f64 / n as f64)).sum::<f64>() * TAU / n as f64 / PI;
        assert_relative_eq!(u, 1.0 + 0.3 * x + 0.4 * y, max_relative = 1e-6);
    }
}

#[test]
fn tilted_hertz_is_a_moved_apex() {
    let gap = Quadratic { xx: 0.7, xy: 0.5, yy: 1.1 };
    let hertz = Hertz::of_quadratic(unit(), gap).unwrap();
    let (d, tilt) = (0.3, [0.2, -0.1]);
    let contact = hertz.at_tilted_depth(d, tilt).unwrap();
    let [x, y] = contact.patch.centre;
    // The apex is where f is stationary, and f there is the depth of the upright contact.
    assert_relative_eq!(2.0 * gap.xx * x + gap.xy * y, tilt[0], max_relative = 1e-13);
    assert_relative_eq!(gap.xy * x + 2.0 * gap.yy * y, tilt[1], max_relative = 1e-13);
    let deepest = d + tilt[0] * x + tilt[1] * y - gap.gap(x, y);
    assert_relative_eq!(contact.force, hertz.at_depth(deepest).unwrap().force, max_relative = 1e-13);
    assert!(hertz.at_tilted_depth(-1.0, tilt).is_err());
}

/// A placed contact carries at the moved point what the original carries at the point itself.
#[test]
fn placing_moves_the_pressure() {
    let contact = Hertz::new(unit(), [3.0, 0.5]).unwrap().at_tilted_depth(0.2, [0.05, 0.1]).unwrap();
    let (at, angle) = ([2.0, -1.0], 0.7f64);
    let moved = contact.clone().placed(at, angle);
    let (sin, cos) = angle.sin_cos();
    for [x, y] in [[0.1, 0.05], [0.5, 0.1], [-0.3, 0.0]] {
        let there = moved.pressure(at[0] + cos * x - sin * y, at[1] + sin * x + cos * y);
        assert_relative_eq!(there, contact.pressure(x, y), max_relative = 1e-12);
        assert!(there > 0.0);
    }
    for point in moved.patch.boundary(12) {
        assert!(moved.patch.inside(point).abs() < 1e-14);
    }
}

#[test]
fn sneddon_knows_what_is_not_a_disc() {
    let ring = Sneddon::new(unit(), |r| 8.0 * r * (r * r - 1.0), &[], f64::INFINITY).unwrap();
    for d in [1e-3, 0.1, 1.0] {
        assert_eq!(ring.at_depth(d).unwrap_err().verdict, Verdict::NoClosedForm, "{d}");
    }
    // Pressed hard enough the hollow closes: g = 2 r^4 - 4 r^2, D = 16/3 s^4 - 8 s^2 falls at first, yet p > 0 all over.
    let pressed = ring.at_depth(400.0).unwrap();
    assert!(pressed.pressure(0.0, 0.0) > 0.0);
    assert_relative_eq!(ring.at_force(pressed.force).unwrap().depth, 400.0, max_relative = 1e-10);
    // A second step further out that touches before the first contact reaches it.
    let step = |r: f64| {
        if r < 1.0 {
            r
        } else if r < 1.5 {
            -1.0
        } else {
            r
        }
    };
    let stepped = Sneddon::new(unit(), step, &[1.0, 1.5], f64::INFINITY).unwrap();
    assert!(stepped.at_depth(0.05).is_ok());
    assert_eq!(stepped.at_depth(0.9).unwrap_err().verdict, Verdict::NoClosedForm);
    // A plane has no end; a slope that is not a number is refused.
    let plane = Sneddon::new(unit(), |_| 0.0, &[], f64::INFINITY).unwrap();
    assert_eq!(plane.at_depth(1.0).unwrap_err().verdict, Verdict::Unbounded);
    let nan = Sneddon::new(unit(), |_| f64::NAN, &[], f64::INFINITY).unwrap();
    assert_eq!(nan.at_depth(1.0).unwrap_err().verdict, Verdict::NotApplicable);
    assert_eq!(plane.at_depth(f64::NAN).unwrap_err().verdict, Verdict::NotApplicable);
}

#[test]
fn sneddon_with_a_sharp_rim() {
    // A paraboloid cut off at r = 1: from d = 1 on, a flat punch on top of it.
    let cut = Sneddon::new(unit(), |r| r, &[], 1.0).unwrap();
    assert_relative_eq!(cut.at_depth(0.5).unwrap().force, 4.0 / 3.0 * 0.5f64.powf(1.5), max_relative = QUADRATURE);
    let full = cut.at_depth(3.0).unwrap();
    assert_relative_eq!(full.force, 4.0 / 3.0 + 2.0 * 2.0, max_relative = QUADRATURE);
    assert!(full.max_pressure().is_none());
    assert_relative_eq!(cut.at_force(full.force).unwrap().depth, 3.0, max_relative = QUADRATURE);
    let p = 2.0 / PI * 0.75f64.sqrt() + 2.0 / PI / 0.75f64.sqrt();
    assert_relative_eq!(full.pressure(0.5, 0.0), p, max_relative = 1e-8);
    // A flat disc is the limit without a paraboloid.
    let disc = Sneddon::new(unit(), |_| 0.0, &[], 2.0).unwrap().at_depth(1.0).unwrap();
    assert_relative_eq!(disc.force, 4.0, max_relative = QUADRATURE);
}

#[test]
fn bad_input_is_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Hertz::new(unit(), [1.0, bad]).is_err());
        assert!(Sphere::new(unit(), bad).is_err());
        assert!(Power::new(unit(), bad, 1.0).is_err() && Power::new(unit(), 1.0, bad).is_err());
        assert!(Cone::with_slope(unit(), bad).is_err());
        assert!(FlatEndedCone::new(unit(), bad, 1.0).is_err() && RoundedCone::new(unit(), 1.0, bad).is_err());
        assert!(FlatPunch::ellipse(unit(), [1.0, bad]).is_err());
        assert!(Sneddon::new(unit(), |r| r, &[bad], 1.0).is_err());
        for (name, at_depth, at_force) in [Hertz::circular(unit(), 1.0).unwrap()].map(|h| ("h", h, h)) {
            assert!(at_depth.at_depth(bad).is_err() && at_force.at_force(bad).is_err(), "{name}");
        }
    }
    assert!(Hertz::of_quadratic(unit(), Quadratic { xx: 1.0, xy: 0.0, yy: 0.0 }).is_err());
    assert!(Hertz::of_quadratic(unit(), Quadratic { xx: 1.0, xy: 3.0, yy: 1.0 }).is_err());
}

proptest! {
    /// Turning the body turns the contact and changes nothing else, at any ratio of the curvatures.
    #[test]
    fn hertz_turns_with_the_body(log_ratio in -6.0..0.0f64, angle in -3.0..3.0f64, log_d in -9.0..3.0f64) {
        let (ratio, d) = (10f64.powf(log_ratio), 10f64.powf(log_d));
        let upright = Hertz::new(unit(), [1.0 / ratio, 1.0]).unwrap().at_depth(d).unwrap();
        let turned = Quadratic::of_body([1.0 / ratio, 1.0], angle);
        let turned = Hertz::of_quadratic(unit(), turned).unwrap().at_depth(d).unwrap();
        // The smaller curvature of a turned form is known to a rounding of the larger one.
        let tolerance = 1e-14 + 4e-16 / ratio;
        prop_assert!((turned.force / upright.force - 1.0).abs() < tolerance, "{} {}", turned.force, upright.force);
        if ratio < 0.999 {
            let off = (turned.patch.orientation - angle).rem_euclid(PI);
            prop_assert!(off.min(PI - off) < 1e-12 / (1.0 - ratio), "{off}");
        }
        // Homogeneous of degree two.
        let deeper = Hertz::new(unit(), [1.0 / ratio, 1.0]).unwrap().at_depth(4.0 * d).unwrap();
        prop_assert!((deeper.force / upright.force - 8.0).abs() < 1e-13);
    }

    /// Continuous through A = B, and monotone: blunter is stiffer.
    #[test]
    fn hertz_is_smooth_at_the_circle(log_off in -16.0..-2.0f64) {
        let off = 10f64.powf(log_off);
        let circle = Hertz::circular(unit(), 1.0).unwrap().at_depth(1.0).unwrap();
        let near = Hertz::new(unit(), [1.0 + off, 1.0]).unwrap().at_depth(1.0).unwrap();
        let share = near.force / circle.force - 1.0;
        // P ~ (R1 R2)^(1/4) near the circle.
        prop_assert!((share - 0.25 * off).abs() < 0.2 * off * off + 1e-14, "{share} {off}");
    }

    /// Power laws of any exponent: P ~ d^(1 + 1/n), and force gives back the depth.
    #[test]
    fn power_laws_scale(n in 0.05..200.0f64, log_d in -6.0..3.0f64) {
        let law = Power::new(unit(), 1.0, n).unwrap();
        let d = 10f64.powf(log_d);
        let (one, two) = (law.at_depth(d).unwrap(), law.at_depth(2.0 * d).unwrap());
        prop_assert!((two.force / one.force / 2f64.powf(1.0 + 1.0 / n) - 1.0).abs() < 1e-13);
        prop_assert!((law.at_force(one.force).unwrap().depth / d - 1.0).abs() < 1e-13);
    }
}
