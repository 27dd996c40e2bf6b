//! Tips that are round: closed forms, limits, and bounds by the sharp bodies.

use contact_patch::closed_form::RoundedCone;
use contact_patch::gap::{AnyGap, Gap, Paraboloid, Polyhedron, RoundedTip};
use contact_patch::{Contact, EffectiveModulus, Loading, Method, Settings, Solution, solve};

const SLOPE: f64 = 0.3;
const RADIUS: f64 = 0.8;

fn at(gap: impl Gap + 'static, depth: f64, method: Method) -> Solution {
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    let contact = Contact::new(modulus, gap, Loading::depth(depth)).unwrap();
    solve(&contact, &Settings { method, ..Settings::default() }).remove(0).unwrap()
}

fn cone() -> AnyGap {
    AnyGap::new(RoundedTip::cone(SLOPE.atan(), RADIUS).unwrap())
}

#[test]
fn a_rounded_cone_has_a_closed_form() {
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    let form = RoundedCone::new(modulus, RADIUS, SLOPE).unwrap();
    // Hertz while the contact ends on the tip: d <= R t^2.
    for depth in [0.01, 0.05, RADIUS * SLOPE * SLOPE, 0.1, 1.0, 30.0] {
        let (truth, found) = (form.at_depth(depth).unwrap().force, at(cone(), depth, Method::Auto));
        assert_eq!(found.method, Method::ClosedForm);
        assert!((found.force / truth - 1.0).abs() < 1e-12, "{depth}: {} {truth}", found.force);
        let grid = at(cone(), depth, Method::Fft);
        assert!((grid.force / truth - 1.0).abs() <= grid.force_error.unwrap(), "{depth}: {} {truth}", grid.force);
        assert!(grid.pressure.singular.is_none() && found.pressure.singular.is_none());
        // Moved, seen in other units.
        let moved = at(cone().placed([3.0, -1.0], 0.4).unwrap(), depth, Method::Auto);
        assert!((moved.force / truth - 1.0).abs() < 1e-12 && moved.method == Method::ClosedForm);
        let scaled = at(cone().scaled([0.0; 2], 2.0, 0.5), depth, Method::Auto);
        let unscaled = at(cone(), 0.5 * depth, Method::Auto);
        // Forces are E* length depth.
        assert!((2.0 * 0.5 * scaled.force / unscaled.force - 1.0).abs() < 1e-12, "{} {}", scaled.force, unscaled.force);
    }
}

#[test]
fn rounded_pyramids_lie_between_the_sharp_one_and_the_one_lowered() {
    for (faces, depth) in [(3, 0.02), (3, 0.3), (4, 0.05), (4, 1.0), (6, 0.2)] {
        let round = RoundedTip::pyramid(faces, SLOPE.atan(), RADIUS).unwrap();
        let sharp = |depth: f64| at(Polyhedron::pyramid(faces, SLOPE.atan()).unwrap(), depth, Method::Auto);
        let lowered = 0.5 * RADIUS * SLOPE * SLOPE;
        let found = at(round, depth, Method::Auto);
        let [error, off] = [found.force_error.unwrap(), 2e-3];
        // g of the sharp body less R t^2/2 <= g <= g of the sharp body, and g <= |x|^2/(2 R).
        let low = sharp(depth).force.max(at(Paraboloid::new([RADIUS; 2]).unwrap(), depth, Method::Auto).force);
        assert!(found.force >= low * (1.0 - error - off), "{faces}, {depth}: {} below {low}", found.force);
        let high = sharp(depth + lowered).force;
        assert!(found.force <= high * (1.0 + error + off), "{faces}, {depth}: {} above {high}", found.force);
        assert!(found.pressure.singular.is_none() && found.pressure.max.is_some(), "{faces}, {depth}");
        // The law of Barber: the stiffness is the slope of the force.
        let step = 0.02 * depth;
        let slope =
            (at(round, depth + step, Method::Auto).force - at(round, depth - step, Method::Auto).force) / (2.0 * step);
        assert!((slope / found.stiffness - 1.0).abs() < 0.05 + found.stiffness_error.unwrap(), "{faces}, {depth}");
    }
}

#[test]
fn its_bounds_hold_on_a_grid() {
    let round = RoundedTip::pyramid(3, SLOPE.atan(), RADIUS).unwrap();
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    let contact = Contact::new(modulus, round, Loading::depth(0.1)).unwrap();
    let mut settings = Settings { method: Method::Fft, cells: Some(64), tolerance: 0.5, ..Settings::default() };
    settings.outputs.bracket = true;
    let coarse = solve(&contact, &settings).remove(0).unwrap();
    let bracket = coarse.bracket.unwrap();
    let fine = at(round, 0.1, Method::Auto);
    assert!(bracket.lower() <= fine.force && fine.force <= bracket.upper(), "{bracket:?} {}", fine.force);
    assert!(round.gap(0.0, 0.0) == 0.0);
}
