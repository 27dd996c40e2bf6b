//! Gaps of every kind through one call: the same gap written in different ways, measured maps, flat plan-forms, several tips.
#![cfg(feature = "formula")]

use std::f64::consts::PI;

use approx::assert_relative_eq;
use contact_patch::closed_form::{Hertz, Quadratic};
use contact_patch::gap::{
    AnyGap, Cone, Flat, Formula, Gap, HeightMap, Heights, Minimum, Outline, Paraboloid, Place, Polyhedron, Power,
    Sphere, Sum, Surface, Zero,
};
use contact_patch::{Contact, EffectiveModulus, Loading, Method, Outputs, Settings, Solution, Unsolved, plan, solve};

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).unwrap()
}

fn contact(gap: impl Gap + 'static, depth: f64) -> Contact {
    Contact::new(unit(), gap, Loading::depth(depth)).unwrap()
}

fn solved(gap: impl Gap + 'static, depth: f64, settings: &Settings) -> Solution {
    solve(&contact(gap, depth), settings).remove(0).or_else(Unsolved::accept_best).unwrap()
}

#[test]
fn a_formula_is_taken_for_what_it_is() {
    let settings = Settings::default();
    let pairs: Vec<(AnyGap, &str, f64)> = vec![
        (AnyGap::new(Paraboloid::new([2.0, 0.5]).unwrap()), "x^2/4 + y^2", 0.3),
        (AnyGap::new(Sphere::new(2.0).unwrap()), "2 - sqrt(4 - r^2)", 0.2),
        (AnyGap::new(Cone::with_slope(0.4).unwrap()), "0.4*sqrt(x^2 + y^2)", 0.1),
        (AnyGap::new(Power::new(3.0, 2.5).unwrap()), "3*r^2.5", 0.2),
        (
            AnyGap::new(Polyhedron::new(vec![[1.0, 0.0, 0.0], [-1.0, 0.5, 0.0], [-0.5, -2.0, 0.0]]).unwrap()),
            "max(x, max(-x + 0.5*y, -0.5*x - 2*y))",
            0.2,
        ),
        (Paraboloid::new([3.0, 1.0]).unwrap().placed([0.5, 0.2], 0.0).unwrap(), "(x - 0.5)^2/6 + (y - 0.2)^2/2", 0.1),
    ];
    for (named, expression, depth) in pairs {
        let written = Formula::new(expression).unwrap();
        let plans =
            [&named, &AnyGap::new(written.clone())].map(|gap| plan(&contact(gap.clone(), depth), &settings).unwrap());
        assert_eq!(plans[0].method, plans[1].method, "{expression}");
        let (a, b) = (solved(named, depth, &settings), solved(written, depth, &settings));
        assert_relative_eq!(a.force, b.force, max_relative = 1e-9);
        assert_relative_eq!(a.stiffness, b.stiffness, max_relative = 1e-9);
    }
}

#[test]
fn crossed_cylinders_are_an_elliptic_contact() {
    let cylinder = |radius: f64| Paraboloid::new([radius, f64::INFINITY]).unwrap();
    for angle in [90.0f64, 60.0, 10.0] {
        let turned = cylinder(0.05).placed([0.0; 2], angle.to_radians()).unwrap();
        let both = Sum::new(vec![AnyGap::new(cylinder(0.02)), AnyGap::new(turned)]).unwrap();
        let solution = solved(both, 1e-6, &Settings::default());
        assert_eq!(solution.method, Method::ClosedForm);
        let form = Quadratic::of_body([0.02, f64::INFINITY], 0.0)
            .plus(Quadratic::of_body([0.05, f64::INFINITY], angle.to_radians()));
        let hertz = Hertz::of_quadratic(unit(), form).unwrap().at_depth(1e-6).unwrap();
        assert_relative_eq!(solution.force, hertz.force, max_relative = 1e-9);
        assert_relative_eq!(solution.patch.area, hertz.patch.area(), max_relative = 1e-9);
    }
}

#[test]
fn two_tips_carry_less_than_each_alone() {
    let tip = |x: f64| Paraboloid::new([1.0, 1.0]).unwrap().placed([x, 0.0], 0.0).unwrap();
    let alone = solved(tip(0.0), 0.01, &Settings::default()).force;
    let mut before = 0.0;
    for half in [0.15, 0.3, 1.0] {
        let both = Minimum::new(vec![AnyGap::new(tip(-half)), AnyGap::new(tip(half))]).unwrap();
        let pair = solved(both, 0.01, &Settings::default());
        assert_eq!(pair.patch.regions, 2, "tips {half} from the middle");
        assert!(pair.force < 2.0 * alone && pair.force > before, "{} of {}", pair.force, 2.0 * alone);
        before = pair.force;
    }
    assert!(before > 1.9 * alone);
}

/// Capacity table: P/(E* d) of a unit square and of an equilateral triangle of side 1, six digits.
const FLAT: [(f64, &[[f64; 2]]); 2] = [
    (1.152298, &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    (0.788116, &[[0.0, 0.0], [1.0, 0.0], [0.5, 0.866_025_403_784_438_6]]),
];

#[test]
fn tips_a_thousand_radii_apart_feel_one_another_as_point_loads() {
    // Each tip: P = 4/3 sqrt(R) (d - P/(pi s))^(3/2) with the other's displacement as of a point load, s apart.
    let settings = Settings { tolerance: 1e-3, ..Settings::default() };
    let d = 0.01;
    for s in [2.0f64, 1000.0] {
        let one = |d: f64| 4.0 / 3.0 * d.powf(1.5);
        let each = (0..50).fold(one(d), |p, _| one(d - p / (PI * s)));
        // dP/dd of both: k (1 - dP/dd/(pi s)) each, k = 2 a.
        let k = 2.0 * (d - each / (PI * s)).sqrt();
        let stiffness = 2.0 * k / (1.0 + k / (PI * s));
        let tip = |x: f64| Paraboloid::new([1.0, 1.0]).unwrap().placed([x, 0.3], 0.0).unwrap();
        let named: AnyGap = AnyGap::new(Minimum::new(vec![tip(-0.5 * s), tip(0.5 * s)]).unwrap());
        let values = Formula::new(&format!("min((x - {0})^2, (x + {0})^2)/2 + (y - 0.3)^2/2", 0.5 * s)).unwrap();
        for gap in [named, AnyGap::new(values)] {
            let pair = solved(gap, d, &settings);
            assert_relative_eq!(pair.force, 2.0 * each, max_relative = 5e-4);
            assert_relative_eq!(pair.stiffness, stiffness, max_relative = 3e-3);
            assert_eq!(pair.patch.regions, 2);
            assert!(pair.residuals.unwrap().worst() < 1e-6, "{:?}", pair.residuals);
        }
    }
}

#[test]
fn contacts_on_grids_of_their_own_keep_the_laws_of_one() {
    let tip = |gap: AnyGap, at: [f64; 2]| gap.placed(at, 0.3).unwrap();
    let cone = || AnyGap::new(Cone::with_slope(0.3).unwrap());
    let pyramid = || AnyGap::new(Polyhedron::pyramid(3, 0.2).unwrap());
    let gap = || Minimum::new(vec![tip(cone(), [-1.0, 0.0]), tip(pyramid(), [1.0, 2.0])]).unwrap();
    let at = |d: f64| solved(gap(), d, &Settings { tolerance: 2e-4, outputs: fields(), ..Settings::default() });
    let (below, state, above) = (at(0.096), at(0.1), at(0.104));
    // P = dU/dd and k = dP/dd over four per cent either way; the field carries the force and its moments.
    assert_relative_eq!((above.energy.unwrap() - below.energy.unwrap()) / 8e-3, state.force, max_relative = 2e-3);
    assert_relative_eq!((above.force - below.force) / 8e-3, state.stiffness, max_relative = 5e-3);
    let field = state.pressure.field.as_ref().unwrap();
    assert_relative_eq!(field.force(), state.force, max_relative = 1e-3);
    let lever: f64 = (0..field.grid.len()).map(|k| field.values[k] * field.grid.centre_of(k)[1]).sum();
    assert_relative_eq!(lever * field.grid.cell_area(), state.moment.unwrap()[0], max_relative = 1e-3);
}

fn fields() -> Outputs {
    Outputs { pressure: true, ..Outputs::default() }
}

#[test]
fn flat_square_and_triangle_converge_with_first_order() {
    for (stiffness, corners) in FLAT {
        let grids = [128, 256, 512].map(|cells| {
            let flat = Flat::new(Outline::polygon(corners).unwrap());
            solved(flat, 1.0, &Settings { method: Method::Fft, cells: Some(cells), ..Settings::default() }).force
        });
        let (first, second) = (grids[1] - grids[0], grids[2] - grids[1]);
        let order = (first / second).log2();
        assert!((0.75..1.3).contains(&order), "order {order} from {grids:?}");
        let limit = grids[2] + second / (first / second - 1.0);
        assert_relative_eq!(limit, stiffness, max_relative = 2e-4);
    }
}

#[test]
fn a_map_of_a_smooth_body_gives_its_force() {
    let bodies: [(AnyGap, f64); 3] = [
        (AnyGap::new(Paraboloid::new([1.0, 2.0]).unwrap()), 0.2),
        (AnyGap::new(Cone::with_slope(0.5).unwrap()), 0.2),
        (AnyGap::new(Polyhedron::pyramid(4, PI / 8.0).unwrap()), 0.2),
    ];
    for (body, depth) in bodies {
        let (n, half) = (257, 1.0);
        let spacing = 2.0 * half / (n - 1) as f64;
        let at = |k: usize| -half + spacing * k as f64;
        let values = (0..n * n).map(|k| body.gap(at(k % n), at(k / n))).collect();
        let heights = Heights::new(values, [n, n], [spacing; 2]).unwrap();
        let map = HeightMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap();
        let (measured, exact) = (solved(map, depth, &Settings::default()), solved(body, depth, &Settings::default()));
        assert_relative_eq!(measured.force, exact.force, max_relative = 2e-3);
    }
}

#[test]
fn a_map_with_a_hole_beside_the_contact_is_no_matter_and_in_it_is() {
    let (n, spacing) = (129, 1.0 / 64.0);
    let at = |k: usize| (k as f64 - 64.0) * spacing;
    let of = |hole: [f64; 2]| {
        let value = |k: usize| {
            let (x, y) = (at(k % n), at(k / n));
            if (x - hole[0]).hypot(y - hole[1]) < 0.1 { f64::NAN } else { 0.5 * (x * x + y * y) }
        };
        let heights = Heights::new((0..n * n).map(value).collect(), [n, n], [spacing; 2]).unwrap();
        let map = HeightMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap();
        solved(map, 0.1, &Settings::default()).force
    };
    let hertz = 4.0 / 3.0 * 0.1f64.powf(1.5);
    assert_relative_eq!(of([0.8, 0.8]), hertz, max_relative = 2e-3);
    assert!(of([0.15, 0.0]) < 0.995 * hertz);
}

#[test]
fn a_tilted_paraboloid_is_one_moved() {
    // depth + ax x - x^2/2R1 is deepest at x = ax R1, by ax^2 R1/2.
    let body = || Paraboloid::new([2.0, 0.7]).unwrap();
    let tilt = [0.03, -0.05];
    let load = contact_patch::Load::Tilted { depth: 0.01, tilt };
    let contact = Contact::new(unit(), body(), Loading::Single(load)).unwrap();
    for method in [Method::Auto, Method::Fft] {
        let settings = Settings { method, ..Settings::default() };
        let tilted = solve(&contact, &settings).remove(0).unwrap();
        let deeper = 0.01 + 0.5 * (2.0 * tilt[0] * tilt[0] + 0.7 * tilt[1] * tilt[1]);
        let upright = solved(body(), deeper, &Settings::default());
        assert_relative_eq!(tilted.force, upright.force, max_relative = 1e-3);
        let [mx, my] = tilted.moment.unwrap();
        assert_relative_eq!(-my / tilted.force, 2.0 * tilt[0], max_relative = 1e-3);
        assert_relative_eq!(mx / tilted.force, 0.7 * tilt[1], max_relative = 1e-3);
    }
}

#[test]
fn a_force_finds_its_depth_for_every_kind() {
    let gaps: Vec<AnyGap> = vec![
        AnyGap::new(Paraboloid::new([1.0, 3.0]).unwrap()),
        AnyGap::new(Cone::with_slope(0.3).unwrap()),
        AnyGap::new(Polyhedron::truncated_pyramid(4, 0.4, 0.5).unwrap()),
        AnyGap::new(Formula::new("x^4 + y^2 + 0.1*x^2").unwrap()),
        AnyGap::new(Flat::new(Outline::disc(0.7).unwrap())),
        AnyGap::new(Sphere::new(3.0).unwrap()),
    ];
    for gap in gaps {
        for force in [1e-3, 0.3] {
            let loaded = Contact::new(unit(), gap.clone(), Loading::force(force)).unwrap();
            let by_force = solve(&loaded, &Settings::default()).remove(0).unwrap();
            assert_eq!(by_force.force, force);
            let by_depth = solved(gap.clone(), by_force.depth, &Settings::default());
            assert_relative_eq!(by_depth.force, force, max_relative = 2e-3);
        }
    }
}
