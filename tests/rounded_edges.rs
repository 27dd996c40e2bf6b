//! Flats with rounded or sloping edges, beside sharp ones or not, on lines that lie where the pressure changes: against grids, flats and laws.

#![cfg(feature = "formula")]

use contact_patch::gap::{AnyGap, Flat, Formula, Outline};
use contact_patch::{
    Contact, EffectiveModulus, Load, Loading, Method, Origin, Outputs, Settings, Solution, plan, solve,
};

fn contact(e_star: f64, gap: AnyGap, load: Load) -> Contact {
    Contact::new(EffectiveModulus::from_e_star(e_star).unwrap(), gap, Loading::Single(load)).unwrap()
}

/// By the route that the plan says, on fitted cells.
fn fitted(e_star: f64, gap: AnyGap, load: Load, settings: &Settings) -> Solution {
    let contact = contact(e_star, gap, load);
    let state = solve(&contact, settings).remove(0).unwrap();
    assert_eq!((state.method, state.origin), (Method::EdgeFitted, Origin::EdgeFitted));
    assert_eq!(plan(&contact, settings).unwrap().method, Some(Method::EdgeFitted));
    state
}

fn rectangle([a, b]: [f64; 2]) -> Outline {
    Outline::polygon(&[[-a, -b], [a, -b], [a, b], [-a, b]]).unwrap()
}

fn formula(text: &str) -> AnyGap {
    AnyGap::new(Formula::new(text).unwrap())
}

/// Rounded, each edge for itself and as fillets; one side rounder than the other; sloping or rounded beside sharp edges; dished; with depths.
fn flats() -> Vec<(AnyGap, f64)> {
    let region = || rectangle([1.5, 0.8]);
    let within = |text: &str| AnyGap::new(Formula::within(text, region()).unwrap());
    vec![
        (formula("(max(0, abs(x) - 0.9)^2 + max(0, abs(y) - 0.6)^2)/0.2"), 0.01),
        (formula("hypot(max(0, abs(x) - 0.9), max(0, abs(y) - 0.6))^2/2"), 0.003),
        (formula("max(0, x - 0.9)^2/0.2 + max(0, -x - 0.7)^2 + max(0, abs(y) - 0.6)^2/0.2"), 0.01),
        (formula("(max(0, abs(x) - 0.9)^2 + max(0, abs(y) - 0.6)^2)/0.2 - 2e-3*(x^2 + y^2)"), 0.01),
        (within("max(0, 0.2*abs(x) - 0.1)"), 0.02),
        (within("max(0, abs(x) - 0.5)^2/0.4"), 0.01),
    ]
}

fn agree(a: &Solution, b: &Solution) {
    let near = |name: &str, [x, y]: [f64; 2], [e, g]: [Option<f64>; 2]| {
        let stated = e.unwrap() + g.unwrap();
        assert!((x / y - 1.0).abs() <= stated, "{name}: {x:e} {y:e}, stated {stated:e}");
    };
    near("force", [a.force, b.force], [a.force_error, b.force_error]);
    near("stiffness", [a.stiffness, b.stiffness], [a.stiffness_error, b.stiffness_error]);
    near("energy", [a.energy.unwrap(), b.energy.unwrap()], [a.energy_error, b.energy_error]);
    near("area", [a.patch.area, b.patch.area], [a.area_error, b.area_error]);
}

#[test]
fn grids_and_finer_lines_are_within_the_stated_errors() {
    let outputs = Outputs { patch: true, ..Outputs::default() };
    let settings = Settings { outputs, ..Settings::default() };
    for (gap, depth) in flats() {
        let state = fitted(1.0, gap.clone(), Load::Depth(depth), &settings);
        assert!(state.force_error.unwrap() <= 1e-3);
        agree(&state, &fitted(1.0, gap.clone(), Load::Depth(depth), &Settings { tolerance: 2e-4, ..settings }));
        let uniform = Settings { method: Method::Fft, ..settings };
        let grid = solve(&contact(1.0, gap, Load::Depth(depth)), &uniform).remove(0);
        agree(&state, &grid.unwrap_or_else(|unsolved| *unsolved.best.unwrap()));
    }
}

#[test]
fn place_turn_and_units_change_nothing() {
    for (gap, depth) in flats() {
        let own = fitted(1.0, gap.clone(), Load::Depth(depth), &Settings::default());
        let placed = gap.placed([3.0, -20.0], 0.6).unwrap();
        let there = fitted(2e11, placed, Load::Depth(depth), &Settings::default());
        assert!((there.force / (2e11 * own.force) - 1.0).abs() < 1e-6, "{} {}", there.force / 2e11, own.force);
        assert!((there.stiffness / (2e11 * own.stiffness) - 1.0).abs() < 1e-5);
    }
}

/// Material beyond the flat takes nothing off the force, and the contact lies within the overlap: P of a flat punch of the size of one, and
/// of the other. With small radii all are one.
#[test]
fn a_rounded_flat_lies_between_two_flat_punches() {
    let flat = |half: [f64; 2]| {
        let gap = AnyGap::new(Flat::new(rectangle(half)));
        fitted(1.0, gap, Load::Depth(1e-3), &Settings { tolerance: 1e-4, ..Settings::default() }).force
    };
    for radius in [1e-3_f64, 1e-2, 0.1, 1.0] {
        let gap = formula(&format!("(max(0, abs(x) - 0.9)^2 + max(0, abs(y) - 0.6)^2)/{}", 2.0 * radius));
        let state = fitted(1.0, gap, Load::Depth(1e-3), &Settings::default());
        let (error, reach) = (state.force_error.unwrap() + 1e-4, (2e-3 * radius).sqrt());
        assert!(state.force * (1.0 + error) >= flat([0.9, 0.6]), "{radius}");
        assert!(state.force * (1.0 - error) <= flat([0.9 + reach, 0.6 + reach]), "{radius}");
    }
}

/// P, and the integrals of p x and p y, are the slopes of the energy, and their own slopes are the stiffness matrix.
#[test]
fn a_tilted_flat_keeps_its_laws() {
    let (gap, depth) = flats().swap_remove(0);
    let at = |[depth, x, y]: [f64; 3]| {
        let load = Load::Tilted { depth, tilt: [x, y] };
        solve(&contact(1.0, gap.clone(), load), &Settings::default()).remove(0).unwrap()
    };
    let (place, step) = ([depth, 0.3 * depth, -0.2 * depth], 0.05 * depth);
    let state = at(place);
    let loads = |state: &Solution| {
        let [mx, my] = state.moment.unwrap();
        [state.force, -my, mx]
    };
    let (own, matrix) = (loads(&state), state.stiffness_matrix.unwrap());
    for j in 0..3 {
        let [less, more] = [-step, step].map(|by| {
            let mut there = place;
            there[j] += by;
            at(there)
        });
        let slope = (more.energy.unwrap() - less.energy.unwrap()) / (2.0 * step);
        assert!((slope - own[j]).abs() < 0.01 * state.force, "{j}: {slope:e} {:e}", own[j]);
        for i in 0..3 {
            let slope = (loads(&more)[i] - loads(&less)[i]) / (2.0 * step);
            let scale = (matrix[i][i] * matrix[j][j]).sqrt();
            assert!((slope - matrix[i][j]).abs() < 0.03 * scale, "{i} {j}: {slope:e} {:e}", matrix[i][j]);
        }
    }
}

#[test]
fn a_force_beside_the_middle_is_held_by_what_it_finds() {
    let (gap, depth) = flats().swap_remove(0);
    let force = fitted(1.0, gap.clone(), Load::Depth(depth), &Settings::default()).force;
    let moment = [0.1 * force, -0.05 * force];
    let state = fitted(1.0, gap.clone(), Load::ForceMoment { force, moment }, &Settings::default());
    let held = fitted(1.0, gap, Load::Tilted { depth: state.depth, tilt: state.tilt }, &Settings::default());
    let error = held.force_error.unwrap();
    assert!((held.force / force - 1.0).abs() <= error + 1e-6, "{} {error}", held.force / force);
    let [mx, my] = held.moment.unwrap();
    assert!((mx - moment[0]).hypot(my - moment[1]) < 2e-3 * force);
}
