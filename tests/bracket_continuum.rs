//! What a bracket rests on, at points that it never looked at and by a sum of its own; and what happens when the pressure is
//! spoilt.

mod random;

use contact_patch::bracket::{self, BracketSettings, Evidence, ForceBracket};
use contact_patch::gap::{
    AnyGap, Cone, Flat, Gap, HeightMap, Heights, Minimum, Outline, Paraboloid, Place, Polyhedron, Power, Reach,
    Revolved, Sum, Surface, Zero,
};
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, matrix_free};
use random::Random;

const FRAC_PI_4: f64 = std::f64::consts::FRAC_PI_4;

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).expect("a modulus")
}

fn solved(gap: impl Into<AnyGap>, depth: f64, cells: usize) -> Pressure {
    let gap = &gap.into();
    let Reach::Within(rect) = contact_patch::overlap::extent(gap, depth) else { panic!("bounded") };
    let grid = Grid::over(&rect, [cells, cells]);
    let problem = Discrete::sample(gap, depth, grid, Kernel::Galerkin);
    let solution = matrix_free::solve_nested(&problem, &matrix_free::Settings::default()).expect("a solution");
    Pressure { grid, values: solution.pressure }
}

/// Displacement by a pressure, cell by cell: the integral of 1/r over a rectangle by its corners, x ln(y + r) + y ln(x + r).
fn displacement(pressure: &Pressure, [x, y]: [f64; 2]) -> f64 {
    let [a, b] = pressure.grid.spacing.map(|h| 0.5 * h);
    let corner = |u: f64, v: f64| {
        let r = u.hypot(v);
        // ln(v + r) = 2 ln|u| - ln(r - v) where v is negative.
        let log = |v: f64, u: f64| match v {
            v if v >= 0.0 => (v + r).ln(),
            _ => 2.0 * u.abs().ln() - (r - v).ln(),
        };
        let term = |u: f64, v: f64| if u == 0.0 { 0.0 } else { u * log(v, u) };
        term(u, v) + term(v, u)
    };
    let loaded = (0..pressure.values.len()).filter(|&k| pressure.values[k] > 0.0);
    let sum: f64 = loaded
        .map(|k| {
            let c = pressure.grid.centre_of(k);
            let (dx, dy) = (x - c[0], y - c[1]);
            let of_cell =
                corner(dx + a, dy + b) - corner(dx - a, dy + b) - corner(dx + a, dy - b) + corner(dx - a, dy - b);
            pressure.values[k] * of_cell
        })
        .sum();
    sum / std::f64::consts::PI
}

fn bowl(radii: [f64; 2], at: [f64; 2], turn: f64) -> AnyGap {
    Paraboloid::new(radii).unwrap().placed(at, turn).unwrap()
}

/// Points all over, in and around loaded cells, along their borders and at their corners, and on lines through the middle.
fn points(pressure: &Pressure, lines: &[f64], centre: [f64; 2], random: &mut Random) -> Vec<[f64; 2]> {
    let grid = &pressure.grid;
    let extent = grid.extent();
    let mut all: Vec<[f64; 2]> = (0..60)
        .map(|_| [random.between(extent.min[0], extent.max[0]), random.between(extent.min[1], extent.max[1])])
        .collect();
    let [nx, ny] = grid.shape;
    let loaded = |i: usize, j: usize| pressure.values[j * nx + i] > 0.0;
    for j in 1..ny - 1 {
        for i in 1..nx - 1 {
            let around = [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)];
            if around.iter().any(|&(a, b)| loaded(a, b))
                && (!loaded(i, j) || !around.iter().all(|&(a, b)| loaded(a, b)))
            {
                let c = grid.centre(i, j);
                let mut at = |s: f64, t: f64| all.push([c[0] + s * grid.spacing[0], c[1] + t * grid.spacing[1]]);
                at(random.between(-0.5, 0.5), random.between(-0.5, 0.5));
                at(0.5 - 1e-9, random.between(-0.5, 0.5));
                at(-0.5 + 1e-9, -0.5 + 1e-9);
            }
        }
    }
    let size = 0.5 * extent.size()[0].max(extent.size()[1]);
    for angle in lines {
        all.extend((0..80).map(|_| {
            let r = random.between(0.0, 1.0) * size;
            [centre[0] + r * angle.cos(), centre[1] + r * angle.sin()]
        }));
    }
    all
}

#[test]
fn no_point_of_the_plane_breaks_the_conditions_of_a_proved_bracket() {
    let third = std::f64::consts::TAU / 3.0;
    let triangle = [[-0.6, -0.5], [0.7, -0.3], [0.0, 0.6]];
    let pyramid = Polyhedron::pyramid(3, FRAC_PI_4).unwrap().placed([0.02, -0.01], 0.3).unwrap();
    let ridges: Vec<f64> = (0..3).map(|k| 0.3 + (f64::from(k) + 0.5) * third).collect();
    let mut random = Random(11);
    for (name, gap, lines) in [
        ("cone", Cone::with_slope(1.0).unwrap().placed([0.01, 0.02], 0.0).unwrap(), vec![0.4]),
        ("paraboloid", bowl([1.0, 0.4], [0.03, -0.02], 0.5), vec![0.5]),
        ("3 faces", pyramid, ridges),
        ("triangle", AnyGap::new(Flat::new(Outline::polygon(&triangle).unwrap())), vec![]),
        (
            "two tips",
            AnyGap::new(
                Minimum::new(vec![bowl([0.3, 0.5], [-0.3, 0.0], 0.2), bowl([0.4, 0.3], [0.4, 0.1], 0.0)]).unwrap(),
            ),
            vec![],
        ),
        ("power 0.7", AnyGap::new(Power::new(1.0, 0.7).unwrap()), vec![1.1]),
    ] {
        let pressure = solved(&gap, 1.0, 36);
        let settings = BracketSettings::default();
        for bracket in [
            bracket::certify(&gap, unit(), 1.0, &pressure, &settings).unwrap(),
            bracket::sharp(&gap, unit(), 1.0, &pressure, &settings).unwrap(),
        ] {
            assert_eq!(bracket.evidence(), Evidence::Proved, "{name}");
            let (above, below) = (bracket.upper_side(), bracket.lower_side());
            let (q, m) = (above.pressure().unwrap(), below.pressure().unwrap());
            let mut closest = [f64::INFINITY; 2];
            for at in points(q, &lines, gap.known().centre, &mut random) {
                let short = 1.0 - gap.gap(at[0], at[1]) - displacement(q, at);
                assert!(
                    short <= above.violation() + 1e-9,
                    "{name}: S q < f by {short} at {at:?}, {}",
                    above.violation()
                );
                closest[0] = closest[0].min(above.violation() - short);
            }
            let [nx, ny] = m.grid.shape;
            for at in points(m, &lines, gap.known().centre, &mut random) {
                let place = [0, 1].map(|k| ((at[k] - m.grid.origin[k]) / m.grid.spacing[k]).floor());
                let inside = place[0] >= 0.0 && place[1] >= 0.0 && place[0] < nx as f64 && place[1] < ny as f64;
                if !inside || m.values[place[1] as usize * nx + place[0] as usize] <= 0.0 {
                    continue;
                }
                let long = displacement(m, at) - 1.0 + gap.gap(at[0], at[1]);
                assert!(long <= below.violation() + 1e-9, "{name}: S q > f by {long} at {at:?}, {}", below.violation());
                closest[1] = closest[1].min(below.violation() - long);
            }
            println!("{name}: room {:.1e} above, {:.1e} below", closest[0], closest[1]);
        }
    }
}

fn holds(bracket: &ForceBracket, force: f64, doubt: f64, what: &str) {
    assert!(bracket.lower() <= bracket.upper(), "{what}: inverted");
    let (low, high) = (bracket.lower(), bracket.upper());
    assert!(low <= force * (1.0 + doubt) && force * (1.0 - doubt) <= high, "{what}: {force} is not in [{low}, {high}]");
}

/// Gap and depth; forces come from a grid 8 times finer.
fn all_sorts() -> Vec<(&'static str, AnyGap, f64)> {
    let cone = AnyGap::new(Cone::with_slope(0.5).unwrap());
    let planes = vec![[1.0, 0.1, 0.0], [-0.4, 0.9, 0.0], [-0.5, -0.8, -0.05], [0.1, 0.0, -0.02]];
    let generatrix = vec![[0.0, 0.0], [0.3, 0.02], [0.6, 0.2], [3.0, 4.0]];
    let map = |i: usize, j: usize| {
        let (x, y) = (0.1 * i as f64 - 1.5, 0.1 * j as f64 - 1.5);
        0.5 * (x * x + 0.7 * y * y) + 0.02 * (7.0 * x).sin() * (5.0 * y).cos()
    };
    let heights = Heights::new((0..961).map(|k| map(k % 31, k / 31)).collect(), [31, 31], [0.1, 0.1]).unwrap();
    let map = HeightMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap();
    vec![
        ("sum", AnyGap::new(Sum::new(vec![cone.clone(), bowl([1.0, 2.0], [0.1, 0.0], 0.3)]).unwrap()), 0.6),
        (
            "tips far apart",
            AnyGap::new(Minimum::new(vec![bowl([0.3; 2], [-2.0, 0.0], 0.0), bowl([0.5; 2], [2.0, 0.3], 0.0)]).unwrap()),
            0.3,
        ),
        ("formula", AnyGap::new(|x: f64, y: f64| 0.5 * x * x + y.abs().powi(3) + 0.2 * (x - y).abs()), 0.5),
        ("height map", AnyGap::new(map), 0.3),
        ("revolved", AnyGap::new(Revolved::new(generatrix).unwrap()), 0.4),
        ("polyhedron", AnyGap::new(Polyhedron::new(planes).unwrap()), 0.5),
        ("tilted", bowl([1.0, 0.6], [0.0; 2], 0.0).tilted([0.2, -0.1]), 0.4),
        ("flat", AnyGap::new(Flat::new(Outline::disc(0.8).unwrap())), 1.0),
    ]
}

#[test]
fn a_spoilt_pressure_never_gives_a_bracket_that_does_not_hold() {
    for (name, gap, depth) in all_sorts() {
        let fine = solved(&gap, depth, 256).force();
        // The finer solution's own error: 0.7 % where the pressure is singular, else from ridges and the grid.
        let doubt = if name == "flat" { 7e-3 } else { 5e-4 };
        let pressure = solved(&gap, depth, 32);
        let [nx, ny] = pressure.grid.shape;
        let plain = bracket::certify(&gap, unit(), depth, &pressure, &BracketSettings::default()).unwrap();
        holds(&plain, fine, doubt, name);
        let loaded: Vec<usize> = (0..nx * ny).filter(|&k| pressure.values[k] > 0.0).collect();
        let strongest =
            loaded.iter().copied().max_by(|&a, &b| pressure.values[a].total_cmp(&pressure.values[b])).unwrap();
        let inner = |k: usize| [k - 1, k + 1, k - nx, k + nx].iter().all(|&n| pressure.values[n] > 0.0);
        let changed = |change: &dyn Fn(&mut Vec<f64>)| {
            let mut values = pressure.values.clone();
            change(&mut values);
            Pressure { grid: pressure.grid, values }
        };
        let spoilt = [
            ("raised", changed(&|v| v[loaded[loaded.len() / 2]] *= 1.1)),
            ("holed", changed(&|v| [0, 1, nx, nx + 1].iter().for_each(|o| v[strongest + o] = 0.0))),
            ("shifted", changed(&|v| v.rotate_right(1))),
            ("halved", changed(&|v| v.iter_mut().for_each(|p| *p *= 0.5))),
            ("doubled", changed(&|v| v.iter_mut().for_each(|p| *p *= 2.0))),
            ("a little more", changed(&|v| v.iter_mut().for_each(|p| *p *= 1.02))),
            (
                "without its rim",
                changed(&|v| {
                    loaded.iter().filter(|&&k| k < nx || k + nx >= nx * ny || !inner(k)).for_each(|&k| v[k] = 0.0)
                }),
            ),
        ];
        for (what, pressure) in spoilt {
            for prove in [true, false] {
                let settings = BracketSettings { prove, ..BracketSettings::default() };
                let bracket = bracket::certify(&gap, unit(), depth, &pressure, &settings).unwrap();
                holds(&bracket, fine, doubt, &format!("{name}, {what}, prove {prove}"));
                if what == "holed" || what == "shifted" {
                    let width = |b: &ForceBracket| b.upper() - b.lower();
                    assert!(!prove || width(&bracket) > width(&plain), "{name}, {what}: {bracket:?} is not wider");
                }
            }
            let sharp = bracket::sharp(&gap, unit(), depth, &pressure, &BracketSettings::default()).unwrap();
            holds(&sharp, fine, doubt, &format!("{name}, {what}, sharp"));
        }
    }
}
