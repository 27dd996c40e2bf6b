//! Laws of the certified bracket: it contains the force, whatever pressure it is made from.

mod random;

use contact_patch::bracket::{self, BracketSettings, Evidence, ForceBracket};
use contact_patch::gap::{
    AnyGap, Cone, Flat, Minimum, Outline, Paraboloid, Place, Polyhedron, Power, Reach, Revolved, Sphere,
};
use contact_patch::geometry::Rect;
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, check, matrix_free};
use random::Random;

const FRAC_PI_4: f64 = std::f64::consts::FRAC_PI_4;

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).expect("a modulus")
}

fn solved(gap: impl Into<AnyGap>, depth: f64, grid: Grid, kernel: Kernel) -> Pressure {
    let gap = &gap.into();
    let problem = Discrete::sample(gap, depth, grid, kernel);
    let solution = matrix_free::solve(&problem, None, &matrix_free::Settings::default()).expect("a solution");
    Pressure { grid, values: solution.pressure }
}

/// Cells over the whole of {f > 0}.
fn over(gap: impl Into<AnyGap>, depth: f64, cells: usize) -> Grid {
    let gap = &gap.into();
    let Reach::Within(rect) = contact_patch::overlap::extent(gap, depth) else { panic!("bounded") };
    Grid::over(&rect, [cells, cells])
}

fn certify(gap: impl Into<AnyGap>, depth: f64, pressure: &Pressure) -> ForceBracket {
    let gap = &gap.into();
    bracket::certify(gap, unit(), depth, pressure, &BracketSettings::default()).expect("a bracket")
}

fn assert_holds(bracket: &ForceBracket, force: f64, doubt: f64, what: &str) {
    assert!(bracket.lower() <= bracket.upper(), "{what}: inverted");
    assert!(
        bracket.lower() <= force * (1.0 + doubt) && force * (1.0 - doubt) <= bracket.upper(),
        "{what}: {force} is not in [{}, {}]",
        bracket.lower(),
        bracket.upper()
    );
}

/// Gap, depth, force for E* = 1: the closed forms (Hertz, Love, Sneddon, Galin; Boussinesq), to all digits.
fn closed_forms() -> Vec<(&'static str, AnyGap, f64, f64)> {
    let flat_cone = Revolved::new(vec![[0.0, 0.0], [1.0, 0.0], [5.0, 4.0]]).unwrap();
    vec![
        ("paraboloid", AnyGap::new(Paraboloid::new([1.0, 1.0]).unwrap()), 1.0, 4.0 / 3.0),
        // A = 1/4, B = 1.
        ("elliptic paraboloid", AnyGap::new(Paraboloid::new([2.0, 0.5]).unwrap()), 1.0, 1.386_405_372_704_954_3),
        ("cone", AnyGap::new(Cone::with_slope(1.0).unwrap()), 1.0, std::f64::consts::FRAC_2_PI),
        ("power 0.5", AnyGap::new(Power::new(1.0, 0.5).unwrap()), 1.0, 0.387_868_304_544_894_7),
        ("power 1.5", AnyGap::new(Power::new(1.0, 1.5).unwrap()), 1.0, 0.811_799_236_221_529_8),
        ("power 4", AnyGap::new(Power::new(1.0, 4.0).unwrap()), 1.0, 1.252_067_664_058_63),
        ("sphere", AnyGap::new(Sphere::new(1.0).unwrap()), 0.274_653_072_167_027_42, 0.186_632_680_417_568_56),
        ("flat-ended cone", AnyGap::new(flat_cone), 0.472_669_632_766_567, 0.978_194_165_538_807_7),
        ("flat disc", AnyGap::new(Flat::new(Outline::disc(1.0).unwrap())), 1.0, 2.0),
        ("flat ellipse", AnyGap::new(Flat::new(Outline::ellipse([1.0, 0.5]).unwrap())), 1.0, 1.456_791_031_046_907),
    ]
}

#[test]
fn closed_forms_lie_in_the_proved_bracket_on_every_grid() {
    for (name, gap, depth, force) in closed_forms() {
        for (turn, cells, kernel) in [
            (0.0, 12, Kernel::Galerkin),
            (0.0, 25, Kernel::Collocation),
            (0.3, 25, Kernel::Galerkin),
            (0.7, 40, Kernel::Collocation),
            (1.2, 64, Kernel::Galerkin),
        ] {
            let placed = gap.clone().placed([0.0137 * turn, -0.021], turn).unwrap();
            let pressure = solved(&placed, depth, over(&placed, depth, cells), kernel);
            let bracket = certify(&placed, depth, &pressure);
            assert_eq!(bracket.evidence(), Evidence::Proved, "{name}");
            assert_holds(&bracket, force, 1e-14, &format!("{name}, {cells} cells, turned by {turn}"));
        }
    }
}

#[test]
fn the_sharp_bracket_is_narrower_and_holds() {
    for (name, gap, depth, force) in closed_forms() {
        let placed = gap.placed([0.01, 0.02], 0.4).unwrap();
        let pressure = solved(&placed, depth, over(&placed, depth, 33), Kernel::Galerkin);
        let plain = certify(&placed, depth, &pressure);
        let sharp = bracket::sharp(&placed, unit(), depth, &pressure, &BracketSettings::default()).unwrap();
        assert_holds(&sharp, force, 1e-14, name);
        assert!(sharp.lower() >= plain.lower() && sharp.upper() <= plain.upper(), "{name}");
    }
}

/// Converged forces of pyramids (Galerkin, extrapolated) and of flat polygons of unit side (graded meshes, extrapolated).
#[test]
fn pyramids_and_flat_polygons_lie_in_the_bracket() {
    let regular = |n: usize| -> Vec<[f64; 2]> {
        let radius = 0.5 / (std::f64::consts::PI / n as f64).sin();
        (0..n)
            .map(|k| (std::f64::consts::TAU * k as f64 / n as f64).sin_cos())
            .map(|(s, c)| [radius * c, radius * s])
            .collect()
    };
    let flat = |corners: &[[f64; 2]]| AnyGap::new(Flat::new(Outline::polygon(corners).unwrap()));
    let l = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
    let pyramid = |n| AnyGap::new(Polyhedron::pyramid(n, FRAC_PI_4).unwrap());
    for (name, gap, force, doubt) in [
        ("3 faces", pyramid(3), 0.882_412, 3e-6),
        ("4 faces", pyramid(4), 0.737_616, 3e-6),
        ("6 faces", pyramid(6), 0.673_297, 3e-6),
        ("triangle", flat(&regular(3)), 0.788_116, 1e-6),
        ("square", flat(&regular(4)), 1.152_298, 1e-6),
        ("hexagon", flat(&regular(6)), 1.829_117, 1e-6),
        ("L", flat(&l), 2.071_13, 4e-5),
    ] {
        for (turn, cells) in [(0.0, 31), (0.2, 48)] {
            let placed = gap.clone().placed([0.003, 0.001], turn).unwrap();
            let pressure = solved(&placed, 1.0, over(&placed, 1.0, cells), Kernel::Galerkin);
            assert_holds(&certify(&placed, 1.0, &pressure), force, doubt, name);
            let sharp = bracket::sharp(&placed, unit(), 1.0, &pressure, &BracketSettings::default()).unwrap();
            assert_holds(&sharp, force, doubt, name);
        }
    }
}

/// A gap of a kind drawn by lot, some of them closures of which nothing is known but values.
fn random_gap(random: &mut Random) -> AnyGap {
    match (random.next() * 4.0) as usize {
        0 => {
            let n = 3 + (random.next() * 5.0) as usize;
            let planes = (0..n)
                .map(|k| {
                    let angle = std::f64::consts::TAU * (k as f64 + random.between(-0.2, 0.2)) / n as f64;
                    let slope = random.between(0.6, 1.5);
                    [slope * angle.cos(), slope * angle.sin(), -random.between(0.0, 0.2)]
                })
                .collect();
            AnyGap::new(Polyhedron::new(planes).unwrap())
        }
        1 => {
            let tip = |random: &mut Random| {
                let bowl = Paraboloid::new([random.between(0.2, 1.0), random.between(0.2, 1.0)]).unwrap();
                let at = [random.between(-0.4, 0.4), random.between(-0.4, 0.4)];
                bowl.placed(at, random.between(0.0, 3.0)).unwrap()
            };
            AnyGap::new(Minimum::new(vec![tip(random), tip(random)]).unwrap())
        }
        2 => AnyGap::new(Power::new(random.between(0.5, 2.0), random.between(0.8, 5.0)).unwrap()),
        _ => {
            let (a, b, c) = (random.between(0.4, 1.5), random.between(0.4, 1.5), random.between(0.0, 0.15));
            let (k, l, s) = (random.between(2.0, 7.0), random.between(0.0, 6.0), random.between(-0.3, 0.3));
            AnyGap::new(move |x: f64, y: f64| a * x * x + b * y * y + s * x * y + c * (k * x + l).cos() * (k * y).sin())
        }
    }
}

/// Brackets from a grid against the force on one 8 times finer. `doubt`: its own error, relative; from ridges and tips.
fn random_gaps(count: u64, from: u64) {
    let (mut widest, mut narrowest) = (0.0_f64, f64::INFINITY);
    for seed in from..from + count {
        let mut random = Random(seed);
        let gap = random_gap(&mut random);
        let depth = random.between(0.3, 1.0);
        let coarse = over(&gap, depth, 24);
        let fine = over(&gap, depth, 192);
        let force = solved(&gap, depth, fine, Kernel::Galerkin).force();
        let bracket = certify(&gap, depth, &solved(&gap, depth, coarse, Kernel::Galerkin));
        assert_holds(&bracket, force, 3e-4, &format!("seed {seed}"));
        let sharp = bracket::sharp(
            &gap,
            unit(),
            depth,
            &solved(&gap, depth, coarse, Kernel::Collocation),
            &BracketSettings { prove: false, ..BracketSettings::default() },
        );
        let sharp = sharp.expect("a bracket");
        assert_holds(&sharp, force, 3e-4, &format!("seed {seed}, sharp"));
        widest = widest.max(sharp.relative_width());
        narrowest = narrowest.min(sharp.relative_width());
    }
    println!("{count} random gaps: sharp widths {narrowest:.1e} to {widest:.1e}");
}

#[test]
fn random_gaps_solved_on_a_finer_grid_lie_in_the_bracket() {
    random_gaps(16, 1);
}

#[test]
#[ignore = "minutes; run by hand"]
fn five_hundred_random_gaps() {
    random_gaps(500, 1000);
}

#[test]
fn a_tampered_pressure_gives_a_wider_bracket_that_holds() {
    for (gap, depth, force, smooth) in [
        (AnyGap::new(Paraboloid::new([1.0, 1.0]).unwrap()), 1.0, 4.0 / 3.0, true),
        (AnyGap::new(Cone::with_slope(1.0).unwrap()), 1.0, std::f64::consts::FRAC_2_PI, true),
        (AnyGap::new(Polyhedron::pyramid(3, FRAC_PI_4).unwrap()), 1.0, 0.882_412, false),
    ] {
        let pressure = solved(&gap, depth, over(&gap, depth, 48), Kernel::Galerkin);
        let plain = certify(&gap, depth, &pressure);
        // One cell well inside the contact, off the ridges.
        let mut raised = pressure.clone();
        let distance = |k: &usize| (pressure.grid.centre_of(*k)[0] + 0.3).hypot(pressure.grid.centre_of(*k)[1] - 0.2);
        let cell = (0..raised.values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        raised.values[cell] *= 1.1;
        let mut holed = pressure.clone();
        for k in 0..holed.values.len() {
            let [x, y] = holed.grid.centre_of(k);
            if x.hypot(y - 0.3) < 0.15 {
                holed.values[k] = 0.0;
            }
        }
        let mut pulled = pressure.clone();
        pulled.values.iter_mut().step_by(7).for_each(|p| *p = -*p);
        for (what, tampered) in [("raised", raised), ("holed", holed), ("pulled", pulled)] {
            let bracket = certify(&gap, depth, &tampered);
            assert_holds(&bracket, force, 3e-6, what);
            // A plain bracket follows the largest violation. On the pyramid the ridges make it, an order above what one cell
            // can: its bracket moves by the force in that cell and no more.
            let felt =
                if smooth || what != "raised" { 0.0 } else { 0.1 * pressure.values[cell] * pressure.grid.cell_area() };
            let ([a, b], [c, d]) = ([plain.lower(), plain.upper()], [bracket.lower(), bracket.upper()]);
            assert!(d - c > b - a - felt, "{what}: [{c}, {d}] is not wider than [{a}, {b}]");
        }
    }
}

#[test]
fn any_pressure_at_all_gives_a_bracket_that_holds() {
    let gap = Cone::with_slope(1.0).unwrap();
    let force = std::f64::consts::FRAC_2_PI;
    let mut random = Random(7);
    for grid in [
        Grid::over(&Rect::around([0.0; 2], [0.3; 2]), [9, 12]),
        Grid::over(&Rect::around([2.0, 2.0], [0.5, 0.4]), [16, 8]),
        Grid::over(&Rect::around([0.1, 0.0], [30.0, 3.0]), [40, 40]),
    ] {
        for scale in [0.0, 1e-3, 1.0, 100.0] {
            let values = (0..grid.len()).map(|_| scale * random.between(-0.5, 1.0)).collect();
            let pressure = Pressure { grid, values };
            assert_holds(&certify(&gap, 1.0, &pressure), force, 0.0, "noise");
            let sampled = BracketSettings { prove: false, per_cell: 3, ..BracketSettings::default() };
            let bracket = bracket::certify(&gap, unit(), 1.0, &pressure, &sampled).unwrap();
            assert_holds(&bracket, force, 0.0, &format!("noise {scale}, sampled {grid:?}"));
        }
    }
}

#[test]
fn units_do_not_matter() {
    let plain = {
        let gap = Paraboloid::new([1.0, 2.0]).unwrap();
        certify(&gap, 1.0, &solved(&gap, 1.0, over(&gap, 1.0, 20), Kernel::Galerkin))
    };
    // Radii in micrometres in metres, steel, depths in nanometres: L = 1e-6, D = 1e-9.
    let gap = Paraboloid::new([1e-3, 2e-3]).unwrap();
    let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
    let grid = over(&gap, 1e-9, 20);
    let mut pressure = solved(&gap, 1e-9, grid, Kernel::Galerkin);
    pressure.values.iter_mut().for_each(|p| *p *= 2e11);
    let bracket = bracket::certify(&gap, modulus, 1e-9, &pressure, &BracketSettings::default()).unwrap();
    let unit = 2e11 * 1e-9 * 1e-6;
    assert!((bracket.lower() / unit / plain.lower() - 1.0).abs() < 1e-8);
    assert!((bracket.upper() / unit / plain.upper() - 1.0).abs() < 1e-8);
}

/// The paper's forces of the 3-faced punch, in its group (twice ours): 1.6960 by Fabrikant's pressure and 1.5396 by the best
/// circle are too low, 1.7725 on 49 x 49 cells is too high.
#[test]
fn the_papers_forces_of_the_three_faced_punch_are_outside() {
    let gap = Polyhedron::pyramid(3, FRAC_PI_4).unwrap();
    let grid = Grid::over(&Rect { min: [-1.7, -1.5], max: [0.9, 1.5] }, [208, 240]);
    let pressure = solved(&gap, 1.0, grid, Kernel::Galerkin);
    let bracket =
        bracket::sharp(&gap, unit(), 1.0, &pressure, &BracketSettings { rounds: 6, ..BracketSettings::default() })
            .unwrap();
    assert_eq!(bracket.evidence(), Evidence::Proved);
    println!("proved: [{:.6}, {:.6}]", 2.0 * bracket.lower(), 2.0 * bracket.upper());
    assert_holds(&bracket, 0.882_412, 3e-6, "3 faces");
    assert!(2.0 * bracket.lower() > 1.6960 && 2.0 * bracket.lower() > 1.5396);
    assert!(2.0 * bracket.upper() < 1.7725);
}

#[test]
fn without_contact_the_force_is_nothing() {
    let gap = Sphere::new(1.0).unwrap();
    let grid = Grid::over(&Rect::around([0.0; 2], [1.0; 2]), [8, 8]);
    let bracket = certify(&gap, -0.1, &Pressure { grid, values: vec![1.0; 64] });
    assert_eq!((bracket.lower(), bracket.upper()), (0.0, 0.0));
}

#[test]
fn the_checker_accepts_what_is_true_and_refuses_what_is_not() {
    let gap = Polyhedron::pyramid(4, FRAC_PI_4).unwrap().placed([0.1, 0.0], 0.2).unwrap();
    let pressure = solved(&gap, 1.0, over(&gap, 1.0, 32), Kernel::Galerkin);
    for bracket in [
        certify(&gap, 1.0, &pressure),
        bracket::sharp(&gap, unit(), 1.0, &pressure, &BracketSettings::default()).unwrap(),
    ] {
        let verified = check::bracket(&gap, unit(), 1.0, &bracket);
        assert!(verified.accepted(), "{verified:?}");
        let claim = |side: &bracket::Side, pressure| check::Claim {
            force: side.force(),
            repair: side.repair(),
            proved: true,
            pressure,
        };
        let (above, below) = (bracket.upper_side(), bracket.lower_side());
        let (q, m) = (above.pressure().unwrap(), below.pressure().unwrap());
        let (upper, lower) = (claim(above, q), claim(below, m));
        let refused = |upper: &check::Claim, lower: &check::Claim| {
            let found = check::bounds(&gap, unit(), 1.0, upper, lower);
            assert!(!found.accepted(), "{found:?}");
        };
        // Bounds shifted inwards, with and without a repair that fits the shift.
        refused(&check::Claim { force: 0.999 * upper.force, ..upper }, &lower);
        refused(&upper, &check::Claim { force: 1.001 * lower.force, ..lower });
        let none = bracket::Repair::default();
        refused(&check::Claim { force: 0.98 * q.force(), repair: none, ..upper }, &lower);
        // Pressures that prove less, with the bounds that follow from them.
        let times = |p: &Pressure, by: f64| Pressure { values: p.values.iter().map(|p| by * p).collect(), ..p.clone() };
        let (weak, strong) = (times(q, 0.9), times(m, 1.1));
        refused(&check::Claim { force: weak.force(), repair: none, pressure: &weak, ..upper }, &lower);
        refused(&upper, &check::Claim { force: strong.force(), repair: none, pressure: &strong, ..lower });
        // Another gap.
        let other = Polyhedron::pyramid(4, 0.7).unwrap();
        assert!(!check::bounds(&other, unit(), 1.0, &upper, &lower).accepted());
    }
}

#[test]
fn brackets_without_a_grid_hold() {
    for (name, gap, depth, force) in closed_forms() {
        for turn in [0.0, 0.9] {
            let placed = gap.clone().placed([0.3 * turn, 0.1], turn).unwrap();
            let bracket = bracket::approximate(&placed, unit(), depth).unwrap();
            assert_holds(&bracket, force, 1e-12, name);
            assert_eq!(bracket.upper_side().evidence(), Evidence::Proved, "{name}");
            assert!(bracket.relative_width() < 1.2, "{name}: {bracket:?}");
        }
    }
    // Where the ellipse is exact from below and a paraboloid from above.
    let bowl = Paraboloid::new([2.0, 0.5]).unwrap().placed([1.0, 2.0], 0.5).unwrap();
    assert!(bracket::approximate(&bowl, unit(), 1.0).unwrap().relative_width() < 1e-2);
    for n in [3, 4, 6] {
        let gap = Polyhedron::pyramid(n, FRAC_PI_4).unwrap();
        let force = [0.882_412, 0.737_616, 0.673_297][[3, 4, 6].iter().position(|&m| m == n).unwrap()];
        let bracket = bracket::approximate(&gap, unit(), 1.0).unwrap();
        println!("{n} faces: [{}, {}]", bracket.lower(), bracket.upper());
        assert_holds(&bracket, force, 3e-6, "pyramid");
    }
}

#[test]
fn random_gaps_lie_in_the_bracket_without_a_grid() {
    for seed in 50..62 {
        let mut random = Random(seed);
        let gap = random_gap(&mut random);
        let depth = random.between(0.3, 1.0);
        let force = solved(&gap, depth, over(&gap, depth, 96), Kernel::Galerkin).force();
        let bracket = bracket::approximate(&gap, unit(), depth).unwrap();
        assert_holds(&bracket, force, 2e-3, &format!("seed {seed}"));
    }
}

#[test]
fn the_depth_under_a_force_lies_in_its_bracket() {
    for (name, gap, depth, force) in closed_forms() {
        let near = 1.002 * depth;
        let bracket = certify(&gap, near, &solved(&gap, near, over(&gap, near, 33), Kernel::Galerkin));
        let found = bracket::DepthBracket::under(&gap, near, force, &bracket);
        let upper = found.upper().unwrap();
        assert_eq!(found.evidence(), Evidence::Proved, "{name}");
        assert!(found.lower() <= depth * (1.0 + 1e-13) && depth * (1.0 - 1e-13) <= upper, "{name}: {found:?} {depth}");
        assert!(upper - found.lower() <= 2.0 * bracket.relative_width() * near, "{name}: {found:?}");
    }
}
