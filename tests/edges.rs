//! Punches whose edges lie anyhow between the cells: the limit of many grids, and its error, against what is known.
#![cfg(feature = "scene")]

use contact_patch::gap::{AnyGap, Flat, Formula, Gap, Minimum, Outline, Paraboloid, Place, Sum};
use contact_patch::{Contact, EffectiveModulus, Kernel, Load, Loading, Method, Settings, Solution, Unsolved, solve};

/// Force of a flat square of half side 1 at depth 1, E* = 1 (data/reference: flat polygons).
const SQUARE: f64 = 2.304_596;

fn square(turn: f64) -> impl Gap + 'static {
    let outline = Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap();
    Flat::new(outline).placed([0.3, -0.2], turn).unwrap()
}

fn by_fft(gap: impl Gap + 'static, load: Load) -> Result<Solution, Unsolved> {
    solved(gap, load, Settings { method: Method::Fft, ..Settings::default() })
}

fn solved(gap: impl Gap + 'static, load: Load, settings: Settings) -> Result<Solution, Unsolved> {
    let contact = Contact::new(EffectiveModulus::from_e_star(1.0).unwrap(), gap, Loading::Single(load)).unwrap();
    solve(&contact, &settings).remove(0)
}

fn within_its_error(state: &Solution, force: f64) {
    let (off, said) = ((state.force / force - 1.0).abs(), state.force_error.unwrap());
    assert!(off <= said && said <= 1e-3, "off {off:e}, said {said:e}");
}

#[test]
fn a_square_turned_against_the_grid_has_the_force_of_one_that_is_not() {
    for turn in [0.01, 0.2, 0.5, 0.7] {
        let state = by_fft(square(turn), Load::Depth(1.0)).unwrap();
        within_its_error(&state, SQUARE);
        // So few cells that no single grid of theirs comes near.
        assert!(state.cost.unknowns < 200_000, "{}", state.cost.unknowns);
        assert!((state.patch.area / 4.0 - 1.0).abs() < 3e-3, "area {}", state.patch.area);
    }
}

#[test]
fn a_square_that_is_nearly_along_the_cells_is_not_taken_for_one_that_is() {
    // Values at centres: every cell of the border counts as whole while up to half of it lies outside.
    for turn in [0.0, 2e-5, 3e-4, 2e-3, 0.01] {
        for kernel in [Kernel::Collocation, Kernel::Galerkin] {
            let settings = Settings { method: Method::Fft, kernel, ..Settings::default() };
            within_its_error(&solved(square(turn), Load::Depth(1.0), settings).unwrap(), SQUARE);
        }
    }
}

#[test]
fn a_force_on_edges_gives_the_depth_that_has_it() {
    // A paraboloid of radius R = 4 that ends at a = 0.6: from d0 = a^2/R on P = 2 (a d - a^3/(3 R)), below as Hertz.
    let gap = || {
        let disc = Flat::new(Outline::disc(0.6).unwrap()).placed([0.05, -0.3], 0.0).unwrap();
        let round = Paraboloid::new([4.0, 4.0]).unwrap().placed([0.05, -0.3], 0.0).unwrap();
        contact_patch::gap::Sum::new(vec![AnyGap::new(disc), AnyGap::new(round)]).unwrap()
    };
    let pressed = by_fft(gap(), Load::Depth(1.0)).unwrap();
    within_its_error(&pressed, 1.164);
    let state = by_fft(gap(), Load::Force(1.164)).unwrap();
    assert!((state.depth - 1.0).abs() < 1e-3, "{}", state.depth);
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 3e-3, "{a} and {b}");
    for state in [&pressed, &state] {
        assert!(state.remarks.iter().any(|r| r.contains("the limit of")), "{:?}", state.remarks);
        close(state.stiffness, 1.2);
        close(state.energy.unwrap(), 0.002_592 + 0.562_38);
        close(state.patch.area, 0.36 * std::f64::consts::PI);
    }
}

#[test]
fn flat_ellipses_anywhere_on_the_grid_have_their_closed_form() {
    // 2 E* agm(a, b) d.
    for (axes, agm, turn) in [([1.0, 1.0], 1.0, 0.3), ([1.0, 0.3], 0.597_767_1, 0.4), ([0.5, 2.0], 1.121_514_3, 1.2)] {
        let ellipse = Flat::new(Outline::ellipse(axes).unwrap()).placed([0.1, 0.2], turn).unwrap();
        within_its_error(&by_fft(ellipse, Load::Depth(0.7)).unwrap(), 2.0 * agm * 0.7);
    }
}

#[test]
fn a_step_of_the_gap_is_an_edge() {
    // A disc that stands above a wide bowl which the depth does not reach: the disc alone.
    let disc = || AnyGap::new(Flat::new(Outline::disc(0.6).unwrap()));
    let bowl = Paraboloid::new([4.0, 4.0]).unwrap().placed([0.05, 0.0], 0.0).unwrap();
    let raised = contact_patch::gap::Sum::new(vec![AnyGap::new(bowl), AnyGap::new(|_: f64, _: f64| 0.9)]).unwrap();
    let both = Minimum::new(vec![disc(), AnyGap::new(raised)]).unwrap();
    let alone = by_fft(disc(), Load::Depth(1.0)).unwrap();
    let state = by_fft(both, Load::Depth(1.0)).unwrap();
    within_its_error(&alone, 1.2);
    assert!((state.force / alone.force - 1.0).abs() < 2e-3, "{} and {}", state.force, alone.force);
}

#[test]
fn prescribed_grids_state_what_steps_and_edges_cost_them() {
    // Discs of radius 0.6, one above a bowl that the depth does not reach, one that leans: 2 E* a d either way.
    let above = || {
        let disc = AnyGap::new(Flat::new(Outline::disc(0.6).unwrap()));
        let bowl = AnyGap::new(|x: f64, y: f64| 0.9 + 0.125 * ((x - 0.05).powi(2) + y * y));
        AnyGap::new(Minimum::new(vec![disc, bowl]).unwrap())
    };
    let leaning = || AnyGap::new(Flat::new(Outline::disc(0.6).unwrap())).tilted([0.2, 0.1]);
    for (name, gap) in [("above", above()), ("leaning", leaning())] {
        for cells in (20..120).step_by(7) {
            let settings = Settings { method: Method::Fft, cells: Some(cells), ..Settings::default() };
            let state = solved(gap.clone(), Load::Depth(1.0), settings).or_else(Unsolved::accept_best).unwrap();
            let (off, said) = ((state.force / 1.2 - 1.0).abs(), state.force_error.unwrap());
            assert!(off <= said && said < 5.0 / cells as f64, "{name}, {cells} cells: off {off:e}, said {said:e}");
        }
    }
}

#[test]
fn a_tilt_about_the_middle_of_a_square_changes_no_force_but_turns_it_back() {
    // f = d + t (x - c): by symmetry P as without the tilt, and int p (x - c) = K t with one K for all directions.
    let (d, centre) = (1.0, [0.3, -0.2]);
    let mut turning = Vec::new();
    for tilt in [[0.3, 0.0], [0.1, 0.25]] {
        let depth = d - tilt[0] * centre[0] - tilt[1] * centre[1];
        let state = by_fft(square(0.5), Load::Tilted { depth, tilt }).unwrap();
        within_its_error(&state, SQUARE);
        let [mx, my] = state.moment.unwrap();
        let about = [-my - state.force * centre[0], mx - state.force * centre[1]];
        let k = state.stiffness_matrix.unwrap();
        assert!((k[0][0] / SQUARE - 1.0).abs() < 2e-3, "{k:?}");
        let own = [0, 1].map(|i| k[i + 1][i + 1] - k[0][0] * centre[i] * centre[i]);
        for i in 0..2 {
            assert!((own[i] / own[0] - 1.0).abs() < 3e-3, "{own:?}");
            assert!((about[i] - own[0] * tilt[i]).abs() < 3e-3 * own[0] * 0.3, "{about:?} for {tilt:?}, {own:?}");
        }
        turning.push(own[0]);
    }
    assert!((turning[0] / turning[1] - 1.0).abs() < 3e-3, "{turning:?}");
    // Given back as a force and moments, the same depth and tilt.
    let tilt = [0.1, 0.25];
    let depth = d - tilt[0] * centre[0] - tilt[1] * centre[1];
    let pressed = by_fft(square(0.5), Load::Tilted { depth, tilt }).unwrap();
    let load = Load::ForceMoment { force: pressed.force, moment: pressed.moment.unwrap() };
    let state = by_fft(square(0.5), load).unwrap();
    assert!((state.depth / depth - 1.0).abs() < 3e-3, "{} and {depth}", state.depth);
    assert!((0..2).all(|m| (state.tilt[m] - tilt[m]).abs() < 3e-3), "{:?}", state.tilt);
}

#[test]
fn half_lifted_a_tilted_square_leaves_one_edge() {
    // Neither homogeneous nor whole: two resolutions of the same law agree within what they say.
    let gap = || AnyGap::new(square(0.4)).tilted([1.5, 0.2]);
    let settings = |tolerance| Settings { method: Method::Fft, tolerance, ..Settings::default() };
    let run = |tolerance| {
        let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
        let contact = Contact::new(modulus, gap(), Loading::depth(0.1)).unwrap();
        solve(&contact, &settings(tolerance)).remove(0).unwrap()
    };
    let (rough, fine) = (run(5e-3), run(1e-3));
    let allowed = rough.force_error.unwrap() + fine.force_error.unwrap();
    assert!((rough.force / fine.force - 1.0).abs() <= allowed, "{} and {}, {allowed:e}", rough.force, fine.force);
    assert!(fine.patch.area < 3.0, "{}", fine.patch.area);
}

#[test]
fn an_end_of_the_material_beyond_the_contact_changes_nothing() {
    let square = || Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap();
    let outlines = [square(), Outline::disc(0.9).unwrap(), Outline::ellipse([1.0, 0.7]).unwrap()];
    // Forms, powers, planes, one of revolution without a power, and one without any law but its mirrors.
    let expressions = [
        "x^2/2 + y^2/8",
        "x^2/2 + y^2/8 + x*y/10",
        "0.3*r",
        "0.2*r^3",
        "max(abs(x), 2*abs(y))",
        "x^4 + y^4",
        "1 - sqrt(1 - r^2) + 0.1*r^2",
    ];
    let set = |gap: Formula| gap.placed([3.0, -2.0], 0.6).unwrap();
    let at = |gap: AnyGap, depth: f64| solved(gap, Load::Depth(depth), Settings::default()).unwrap();
    for expression in expressions {
        let whole = || set(Formula::new(expression).unwrap());
        for outline in &outlines {
            let ended = || set(Formula::within(expression, outline.clone()).unwrap());
            let (free, inside) = (at(whole(), 0.01), at(ended(), 0.01));
            assert!((free.force / inside.force - 1.0).abs() < 1e-12, "{expression} {outline:?}");
            assert_eq!(free.method, inside.method, "{expression} {outline:?}");
            assert!(inside.touches_edge.is_none() && inside.force_error <= free.force_error);
            // With another body, or as the one of two tips that reaches so deep.
            let round = || Paraboloid::new([5.0, 5.0]).unwrap().placed([3.0, -2.0], 0.0).unwrap();
            let both = |gap: AnyGap| AnyGap::new(Sum::new(vec![gap, round()]).unwrap());
            let (free, inside) = (at(both(whole()), 0.01), at(both(ended()), 0.01));
            let error = free.force_error.unwrap() + inside.force_error.unwrap();
            assert!((free.force / inside.force - 1.0).abs() <= error, "{expression} {outline:?}");
            let raised = || Formula::new("0.5 + r^2").unwrap().placed([3.0, -2.0], 0.0).unwrap();
            let tips = AnyGap::new(Minimum::new(vec![ended(), raised()]).unwrap());
            assert!((at(whole(), 0.01).force / at(tips, 0.01).force - 1.0).abs() < 1e-12, "{expression} {outline:?}");
        }
    }
}

#[test]
fn an_end_of_the_material_that_the_contact_reaches_counts() {
    let form = "x^2/8 + y^2/2";
    let force = |outline: Option<[f64; 2]>| {
        let gap = match outline {
            Some(axes) => Formula::within(form, Outline::ellipse(axes).unwrap()).unwrap(),
            None => Formula::new(form).unwrap(),
        };
        solved(AnyGap::from(&gap), Load::Depth(0.2), Settings::default()).unwrap()
    };
    let free = force(None);
    let [a, b] = free.patch.semi_axes.unwrap();
    // Beyond the contact, inside of where the bodies overlap.
    let near = force(Some([1.01 * a, 1.01 * b]));
    assert!(1.01 * a < (8.0f64 * 0.2).sqrt() && near.force == free.force && near.method == Method::ClosedForm);
    let cut = force(Some([0.97 * a, 0.97 * b]));
    assert!(cut.method != Method::ClosedForm && cut.touches_edge.is_some());
    assert!(cut.force * (1.0 - cut.force_error.unwrap()) < free.force, "{} {}", cut.force, free.force);
}
