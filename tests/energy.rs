//! The bracket of the energy: it holds the exact one whatever the pressure, and the force that the program states with it is proved.

#[path = "random/mod.rs"]
mod random;

use contact_patch::closed_form::Hertz;
use contact_patch::energy::{GapOverlap, Trial, energy_bracket};
use contact_patch::gap::{AnyGap, Cone, Formula, Paraboloid, Polyhedron, Power, Sphere};
use contact_patch::matrix_free::{self, solve_nested};
use contact_patch::{
    Contact, Discrete, EffectiveModulus, ErrorBar, ForceEvidence, Grid, Kernel, Load, Loading, Method, Outputs,
    Settings, geometry::Rect, solve,
};
use random::Random;

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).unwrap()
}

/// A gap at depth 1 that follows a law, its exact force (E* = 1) and k.
fn gaps(random: &mut Random) -> Vec<(&'static str, AnyGap, f64, f64)> {
    let (r, s) = (random.between(0.5, 1.5), random.between(1.0, 4.0));
    let hertz = Hertz::new(unit(), [r * s, r]).unwrap().at_depth(1.0).unwrap().force;
    let slope = 0.5 + random.next();
    let n = 1.0 + 3.0 * random.next();
    // Galin: P = 2 E* n/(n + 1) d a with d = c a^n sqrt(pi) n/2 Gamma(n/2)/Gamma((n + 1)/2).
    let power = contact_patch::closed_form::Power::new(unit(), 1.0, n).unwrap().at_depth(1.0).unwrap().force;
    vec![
        ("paraboloid", AnyGap::from(&Paraboloid::new([r * s, r]).unwrap()), hertz, 2.0),
        ("cone", AnyGap::from(&Cone::with_slope(slope).unwrap()), 2.0 / (std::f64::consts::PI * slope), 1.0),
        ("power", AnyGap::from(&Power::new(1.0, n).unwrap()), power, n),
        // Boundary elements, extrapolated to 1e-7.
        ("pyramid of 4", AnyGap::from(&Polyhedron::pyramid(4, std::f64::consts::FRAC_PI_4).unwrap()), 0.737_616_4, 1.0),
        ("pyramid of 3", AnyGap::from(&Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4).unwrap()), 0.882_412_2, 1.0),
        ("formula", AnyGap::from(&Formula::new(&format!("x^2/(2*{})+y^2/(2*{})", r * s, r)).unwrap()), hertz, 2.0),
    ]
}

/// What the reference values are good to.
const TRUTH: f64 = 3e-7;

#[test]
fn the_exact_energy_lies_in_the_bracket_of_any_pressure() {
    let mut random = Random(20_261_122);
    let (mut finite, mut all, mut narrow) = (0, 0, 0);
    for _ in 0..6 {
        for (name, gap, force, k) in gaps(&mut random) {
            let at = [random.next() - 0.5, random.next() - 0.5];
            let gap = gap.placed(at, 3.0 * random.next()).unwrap();
            let exact = force / (2.0 + 1.0 / k);
            let side = 1.3 * (force.max(1.0)) + random.next();
            let n = 24 + (40.0 * random.next()) as usize;
            let grid = Grid::over(&Rect::around(at, [side; 2]), [n, n + 3]);
            let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
            let good = solve_nested(&problem, &matrix_free::Settings::default()).unwrap();
            let spoilt: Vec<f64> = good.pressure.iter().map(|p| p * (0.8 + 0.4 * random.next())).collect();
            for pressure in [&good.pressure, &spoilt] {
                let trial = Trial { grid: &grid, pressure, displacement: None };
                let bracket = energy_bracket(&GapOverlap::new(&gap, 1.0), &trial);
                let [lower, upper] = bracket.bounds();
                all += 1;
                finite += usize::from(upper < f64::INFINITY);
                narrow += usize::from(upper < 1.02 * lower);
                assert!(
                    lower <= exact * (1.0 + TRUTH) && exact * (1.0 - TRUTH) <= upper,
                    "{name} on {n} cells: [{lower:e}, {upper:e}] and {exact:e}"
                );
                let shares: f64 = bracket.shares.iter().sum();
                assert!(bracket.shares.is_empty() || shares <= bracket.width * (1.0 + 1e-9));
            }
        }
    }
    assert!(2 * finite > all && 4 * narrow > all, "{finite} of {all} bounded, {narrow} to 2 %");
}

#[test]
fn homogeneous_contacts_state_a_proved_error() {
    let mut random = Random(7);
    for round in 0..4 {
        for (name, gap, force, k) in gaps(&mut random) {
            let (length, e_star) = ([1.0, 1e-3, 40.0, 2e-6][round], [1.0, 7e10, 3.0, 1e-4][round]);
            // g = L (x/L)^k is the same gap in other units.
            let scaled = gap.scaled([0.0; 2], 1.0 / length, 1.0 / length).placed([3.0 * length, -length], 0.4).unwrap();
            let contact =
                Contact::new(EffectiveModulus::from_e_star(e_star).unwrap(), scaled, Loading::depth(length)).unwrap();
            let force = force * e_star * length * length;
            let settings = Settings { method: Method::Fft, ..Settings::default() };
            let state = solve(&contact, &settings).remove(0).unwrap_or_else(|e| panic!("{name} {k}: {e}"));
            assert_eq!(state.evidence(), ForceEvidence::Proved, "{name} of degree {k}");
            let bracket = state.bracket.as_ref().unwrap();
            assert!(bracket.lower() <= force * (1.0 + TRUTH) && force * (1.0 - TRUTH) <= bracket.upper(), "{name}");
            assert!((state.force / force - 1.0).abs() <= state.force_error.unwrap() + TRUTH);
            assert!(bracket.contains(state.force) && state.force_error.unwrap() <= settings.tolerance);
            let quick = solve(&contact, &Settings { evidence: ErrorBar::Estimate, ..settings }).remove(0).unwrap();
            assert_eq!(quick.evidence(), ForceEvidence::Estimated);
            assert!(quick.bracket.is_none() && (quick.force / state.force - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn a_prescribed_force_and_a_list_keep_the_proof() {
    let gap = AnyGap::from(&Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4).unwrap());
    for loading in [Loading::force(2.0), Loading::Steps(vec![Load::Depth(0.5), Load::Depth(1.0), Load::Depth(3.0)])] {
        let contact = Contact::new(unit(), gap.clone(), loading).unwrap();
        for state in solve(&contact, &Settings::default()) {
            let state = state.unwrap();
            let exact = 0.882_412_2 * state.depth * state.depth;
            assert_eq!(state.evidence(), ForceEvidence::Proved);
            let bracket = state.bracket.unwrap();
            assert!(bracket.lower() < exact && exact < bracket.upper());
        }
    }
}

#[test]
fn a_ball_has_no_law_and_is_proved_all_the_same() {
    let exact = contact_patch::closed_form::Sphere::new(unit(), 2.0).unwrap();
    let ball = |loading: Loading| {
        let gap = AnyGap::from(&Sphere::new(2.0).unwrap()).placed([0.3, -0.1], 0.7).unwrap();
        let contact = Contact::new(unit(), gap, loading).unwrap();
        solve(&contact, &Settings { method: Method::Fft, ..Settings::default() }).remove(0).unwrap()
    };
    for depth in [0.02, 0.05, 0.1] {
        let (state, truth) = (ball(Loading::depth(depth)), exact.at_depth(depth).unwrap().force);
        assert_eq!(state.evidence(), ForceEvidence::Proved, "{depth}");
        let bracket = state.bracket.as_ref().unwrap();
        assert!(bracket.contains(truth) && bracket.contains(state.force), "{depth}");
        assert!((state.force / truth - 1.0).abs() <= state.force_error.unwrap());
        // Under that force the depth is proved.
        let state = ball(Loading::force(truth));
        assert_eq!(state.evidence(), ForceEvidence::Proved, "{depth}");
        let bounds = state.depth_bracket.unwrap();
        assert!(bounds.lower() <= depth && depth <= bounds.upper().unwrap());
        assert!((state.depth / depth - 1.0).abs() <= state.depth_error.unwrap());
    }
}

/// A paraboloid that is tilted is one beside, deeper: written as a formula its moments are bounded, and the closed form holds them.
#[test]
fn moments_of_a_tilted_gap_are_bounded() {
    let ([r1, r2], tilt, depth, at) = ([1.0, 2.0], [0.03, -0.02], 0.05, [0.2, -0.1]);
    let hertz = Hertz::new(unit(), [r1, r2]).unwrap();
    let gap = AnyGap::from(&Formula::new("x^2/2 + y^2/4").unwrap()).placed(at, 0.0).unwrap();
    let load = Load::Tilted { depth, tilt };
    let contact = Contact::new(unit(), gap, Loading::Single(load)).unwrap();
    let outputs = Outputs { bracket: true, ..Outputs::default() };
    // f = depth + tilt . x - (x - at)^2/(2 R): about at + (R1 ax, R2 ay).
    let place = [at[0] + r1 * tilt[0], at[1] + r2 * tilt[1]];
    let deeper = depth + (0..2).map(|m| tilt[m] * (at[m] + 0.5 * tilt[m] * [r1, r2][m])).sum::<f64>();
    let force = hertz.at_depth(deeper).unwrap().force;
    let exact = [force * place[1], -force * place[0]];
    let mut before = f64::INFINITY;
    for cells in [48, 96] {
        let settings = Settings { method: Method::Fft, cells: Some(cells), outputs, ..Settings::default() };
        let state = solve(&contact, &settings).remove(0).unwrap();
        let bounds = state.moment_bracket.expect("bounded");
        assert!(bounds.contains(exact) && bounds.contains(state.moment.unwrap()), "{cells}: {bounds:?} {exact:?}");
        let width = (0..2).map(|m| bounds.upper()[m] - bounds.lower()[m]).fold(0.0, f64::max);
        assert!(width < 0.02 * force * 0.3 && width < 0.5 * before, "{cells}: {width} {before}");
        before = width;
    }
}

#[test]
fn a_closure_states_an_estimate() {
    let gap = AnyGap::new(|x: f64, y: f64| 0.5 * (x * x + y * y));
    let contact = Contact::new(unit(), gap, Loading::depth(1.0)).unwrap();
    let state = solve(&contact, &Settings { method: Method::Fft, ..Settings::default() }).remove(0).unwrap();
    assert_eq!(state.evidence(), ForceEvidence::Estimated);
    assert!(state.bracket.is_none() && (state.force / (4.0 / 3.0) - 1.0).abs() <= state.force_error.unwrap());
}

/// A tilt along one axis leaves the mirror of the other: the moment about it is 0.
#[test]
fn moments_about_a_mirror_are_known() {
    let gap = AnyGap::from(&Sphere::new(1.0).unwrap());
    let load = Load::Tilted { depth: 0.05, tilt: [0.03, 0.0] };
    let contact = Contact::new(unit(), gap, Loading::Single(load)).unwrap();
    let outputs = Outputs { bracket: true, ..Outputs::default() };
    let settings = Settings { method: Method::Fft, outputs, ..Settings::default() };
    let state = solve(&contact, &settings).remove(0).unwrap();
    let bounds = state.moment_bracket.expect("bounded");
    assert!(bounds.lower()[0] <= 0.0 && bounds.upper()[0] >= 0.0, "{bounds:?}");
    assert!(bounds.upper()[0] - bounds.lower()[0] < 1e-11 * state.force, "{bounds:?}");
    // The ball is lowest at R sin(atan a) beside, and steeper further out: My > -P x.
    let about = -state.force * 0.03f64.atan().sin();
    assert!(about < bounds.lower()[1] && bounds.upper()[1] < 0.95 * about, "{bounds:?} {about}");
    assert!(bounds.contains([0.0, state.moment.unwrap()[1]]), "{bounds:?} {:?}", state.moment);
}
