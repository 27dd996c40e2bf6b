//! What gaps claim of themselves, held against their values: every kind, in sums and minima, placed, turned, tilted, in other units.
#![cfg(feature = "formula")]

mod random;

use contact_patch::gap::{
    Along, AnyGap, Cone, Degree, Flat, Formula, Gap, Generatrix, HeightMap, Heights, Interpolation, Line, Material,
    Minimum, Outline, Paraboloid, Polyhedron, Power, Profile, Reach, Revolved, Sphere, SplineMap, Sum, Surface, Zero,
};
use contact_patch::geometry::Rect;
use contact_patch::numeric::Interval;
use random::Random;

/// One gap of a kind drawn by lot, of size 1.
fn leaf(random: &mut Random) -> AnyGap {
    let formulas = [
        "x^2/2 + 0.1*abs(y)^3",
        "x^2 + x*y + 2*y^2 - 0.3*x + 0.1",
        "0.3*sqrt(x^2 + y^2) + y^2/4",
        "r^1.7*(1 + 0.2*cos(3*theta))",
        "(abs(x)^2.5 + 3*abs(y)^2.5)^0.8",
        "x^2/2 + y^2/6 + 0.05*cos(7*x)*cos(5*y)",
        "1.3 - sqrt(1.69 - r^2)",
        "max(0.4*x, -0.3*x + 0.2*y, -0.5*y)",
        "cosh(x) - 1 + abs(y)",
        "exp(x^2 + y^2) - 1",
        "r^2/(1 + r^2)",
        "min((x-0.5)^2 + y^2, (x+0.6)^2 + 2*y^2)",
        "x^4 + 2*x^2*y^2 + y^4 + 0.2",
        "abs(x)^1.5 + 2*y^2 + 0.3*x*y",
        "(x-0.2)^2/3 + (y+0.1)^4",
        "atan(r)^2 + 0.1*x",
    ];
    let corners = [[-0.7, -0.5], [0.8, -0.4], [0.6, 0.7], [0.1, 0.1], [-0.6, 0.5]];
    let outline = |random: &mut Random| match random.below(3) {
        0 => Outline::disc(random.between(0.3, 1.2)).unwrap(),
        1 => Outline::ellipse([random.between(0.3, 1.2), random.between(0.2, 0.9)]).unwrap(),
        _ => Outline::polygon(&corners).unwrap(),
    };
    match random.below(16) {
        0 => AnyGap::new(Paraboloid::new([random.between(0.2, 3.0), random.between(0.2, 3.0)]).unwrap()),
        1 => AnyGap::new(Paraboloid::new([random.between(0.2, 3.0), f64::INFINITY]).unwrap()),
        2 => AnyGap::new(Sphere::new(random.between(0.5, 3.0)).unwrap()),
        3 => AnyGap::new(Cone::with_slope(random.between(0.1, 2.0)).unwrap()),
        4 => AnyGap::new(Power::new(random.between(0.3, 2.0), random.between(0.4, 5.0)).unwrap()),
        5 => AnyGap::new(Polyhedron::pyramid(2 + random.below(90), random.between(0.1, 1.2)).unwrap()),
        6 => {
            let flat = random.between(0.1, 0.6);
            AnyGap::new(Polyhedron::truncated_pyramid(3 + random.below(5), random.between(0.1, 1.2), flat).unwrap())
        }
        7 => {
            let plane = |random: &mut Random| [(); 3].map(|()| random.between(-1.0, 1.0));
            let mut planes: Vec<[f64; 3]> = (0..2 + random.below(6)).map(|_| plane(random)).collect();
            planes.push([0.5, -1.0, 0.1]);
            AnyGap::new(Polyhedron::new(planes).unwrap())
        }
        8 => AnyGap::new(Flat::new(outline(random))),
        9 => {
            let mut points = vec![[if random.below(3) == 0 { 0.2 } else { 0.0 }, random.between(-0.1, 0.1)]];
            for k in 1..6 {
                points.push([0.3 * f64::from(k), random.between(-0.1, 0.5)]);
            }
            AnyGap::new(Revolved::new(points).unwrap())
        }
        10 => AnyGap::new(Formula::within(formulas[random.below(formulas.len())], outline(random)).unwrap()),
        11 => {
            let values = (0..12 * 9).map(|_| if random.below(25) == 0 { f64::NAN } else { random.between(0.0, 0.4) });
            let heights = Heights::new(values.collect(), [12, 9], [0.17, 0.21]).unwrap();
            if random.below(2) == 0 {
                return AnyGap::new(SplineMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap());
            }
            AnyGap::new(HeightMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap())
        }
        12 => profile(random),
        13 => {
            let wave = random.between(1.0, 4.0);
            let height = |k: usize| {
                let [x, y] = [0.17 * (k % 14) as f64 - 1.1, 0.21 * (k / 14) as f64 - 1.1];
                0.3 * x * x + 0.4 * y * y + 0.05 * (wave * x + y).sin()
            };
            let heights = Heights::new((0..14 * 11).map(height).collect(), [14, 11], [0.17, 0.21]).unwrap();
            let heights = if random.below(2) == 0 { heights.smoothed(0.01).unwrap() } else { heights };
            AnyGap::new(SplineMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap())
        }
        _ => AnyGap::new(Formula::new(formulas[random.below(formulas.len())]).unwrap()),
    }
}

/// A profile, rough or smooth, straight or rolled.
fn profile(random: &mut Random) -> AnyGap {
    let n = 3 + random.below(100);
    let mut y = -1.0;
    let mut point = |k: usize, random: &mut Random| {
        y += random.between(0.3, 1.7) * 2.0 / n as f64;
        [y, 0.3 * y * y + random.between(0.0, if k.is_multiple_of(2) { 0.1 } else { 0.01 })]
    };
    let line = Line::new((0..n).map(|k| point(k, random)).collect()).unwrap();
    let along = if random.below(2) == 0 { Along::X } else { Along::Y };
    let between = if random.below(3) == 0 { Interpolation::Linear } else { Interpolation::Cubic };
    let line = if n > 20 && random.below(2) == 0 { line.smoothed(0.03, Surface::Upper).unwrap() } else { line };
    let profile = Profile::new(&line, along, Surface::Upper, Zero::FirstTouch, between).unwrap();
    AnyGap::new(if random.below(4) == 0 { profile } else { profile.rolling(random.between(0.3, 2.0)).unwrap() })
}

/// A gap of leaves in sums and minima, each put somewhere.
fn nested(random: &mut Random, deeper: usize) -> AnyGap {
    let gap = match if deeper == 0 { 0 } else { random.below(5) } {
        1 => AnyGap::new(Sum::new((0..1 + random.below(2)).map(|_| nested(random, deeper - 1)).collect()).unwrap()),
        2 => AnyGap::new(Minimum::new((0..1 + random.below(3)).map(|_| nested(random, deeper - 1)).collect()).unwrap()),
        _ => leaf(random),
    };
    match random.below(6) {
        0 => gap.placed([random.between(-1.0, 1.0), random.between(-1.0, 1.0)], random.between(0.0, 6.0)).unwrap(),
        1 => gap.placed([0.4, -0.3], std::f64::consts::FRAC_PI_2).unwrap(),
        2 => gap.tilted([random.between(-0.2, 0.2), random.between(-0.2, 0.2)]),
        3 => gap.scaled([random.between(-0.3, 0.3), 0.2], random.between(0.5, 2.0), random.between(0.5, 2.0)),
        _ => gap,
    }
}

fn gaps() -> impl Iterator<Item = (usize, AnyGap, Random)> {
    (0..900).map(|seed| {
        let mut random = Random(20_262_211 + seed as u64);
        let gap = nested(&mut random, 3);
        (seed, gap, random)
    })
}

fn somewhere(random: &mut Random, size: f64) -> [f64; 2] {
    [random.between(-size, size), random.between(-size, size)]
}

/// Room for rounding of a value of this size.
fn rounding(value: f64) -> f64 {
    1e-12 * (1.0 + value.abs())
}

#[test]
fn no_value_lies_below_the_floor_or_outside_of_the_material() {
    for (seed, gap, mut random) in gaps() {
        for _ in 0..400 {
            let p = somewhere(&mut random, 3.0);
            let value = gap.gap(p[0], p[1]);
            assert!(!value.is_nan(), "{seed}: NaN at {p:?}");
            assert!(value >= gap.known().floor - rounding(value), "{seed}: {value} at {p:?}, {}", gap.known().floor);
            if let Material::Within(rect) = gap.known().material {
                assert!(rect.contains(p) || value == f64::INFINITY, "{seed}: {p:?} {rect:?}");
            }
        }
    }
}

#[test]
fn laws_forms_axes_and_mirrors_hold() {
    let (mut laws, mut forms, mut axes, mut mirrors) = (0, 0, 0, 0);
    for (seed, gap, mut random) in gaps() {
        let known = gap.known();
        let c = known.centre;
        let at = |p: [f64; 2]| gap.gap(p[0], p[1]);
        let near = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-10 * (1.0 + a.abs() + b.abs());
        for _ in 0..60 {
            let p = somewhere(&mut random, 2.0);
            let v = [p[0] - c[0], p[1] - c[1]];
            if let Some(law) = known.law {
                laws += 1;
                let s = random.between(0.1, 3.0);
                let (far, here) = (at([c[0] + s * v[0], c[1] + s * v[1]]) - law.lowest, at(p) - law.lowest);
                match law.degree {
                    Degree::Power(k) => assert!(near(far, s.powf(k) * here), "{seed}: {far} {here} s = {s}, k = {k}"),
                    Degree::Flat => assert!(here.abs() < 1e-12 || here == f64::INFINITY, "{seed}: {here}"),
                }
            }
            if let Some(q) = known.quadratic {
                forms += 1;
                assert!(near(q.about(p).value, at(p)), "{seed}: {} {}", q.about(p).value, at(p));
            }
            if let Some(axis) = known.axis {
                axes += 1;
                let r = (p[0] - axis.at[0]).hypot(p[1] - axis.at[1]);
                // The rim of a body is sharp: rounding decides there.
                let along = at([axis.at[0] + r, axis.at[1]]);
                assert!(near(along, at(p)) || along.is_infinite() != at(p).is_infinite(), "{seed}: {along} {}", at(p));
                if let Generatrix::Power { coefficient, exponent, lowest } = axis.generatrix {
                    assert!(near(lowest + coefficient * r.powf(exponent), at(p)), "{seed}");
                }
                if let Generatrix::Sphere { radius, lowest } = axis.generatrix
                    && r < radius
                {
                    let height = lowest + radius - (radius * radius - r * r).sqrt();
                    assert!(near(height, at(p)), "{seed}: {height} {}", at(p));
                }
            }
            for m in (0..2).filter(|&m| known.mirrors[m]) {
                mirrors += 1;
                let mut image = p;
                image[m] = 2.0 * c[m] - p[m];
                let (a, b) = (at(p), at(image));
                assert!(near(a, b) || a.is_infinite() != b.is_infinite(), "{seed}: mirror {m}: {a} {b}");
            }
        }
        if let Some(face) = &known.face {
            let (sin, cos) = face.turn.sin_cos();
            for _ in 0..60 {
                let [u, v] = somewhere(&mut random, 1.5);
                let [dx, dy] = [cos * u - sin * v, sin * u + cos * v];
                let value = at([face.at[0] + dx, face.at[1] + dy]);
                if face.outline.contains([u, v]) == value.is_finite() && value.is_finite() {
                    assert!(near(value, face.value + face.slope[0] * dx + face.slope[1] * dy), "{seed}: {value}");
                }
            }
        }
    }
    assert!(laws > 5000 && forms > 3000 && axes > 2000 && mirrors > 5000, "{laws} {forms} {axes} {mirrors}");
}

#[test]
fn reach_and_components_hold_every_point_below_the_depth() {
    let (mut within, mut several, mut unbounded, mut nowhere, mut unknown) = (0, 0, 0, 0, 0);
    for (seed, gap, mut random) in gaps() {
        let floor = gap.known().floor.max(-1.0);
        for _ in 0..3 {
            let depth = floor + random.between(0.0, 1.0).powi(3);
            let reach = gap.reach(depth);
            let components = gap.components(depth);
            match reach {
                Reach::Within(rect) => {
                    within += 1;
                    assert!(rect.size().iter().all(|s| s.is_finite()), "{seed}: {rect:?}");
                }
                Reach::Nowhere => nowhere += 1,
                Reach::Unbounded { from, along } => {
                    unbounded += 1;
                    for far in [0.0, 0.3, 7.0, 1e3, 1e7] {
                        let far = far * from[0].hypot(from[1]).max(1.0);
                        let value = gap.gap(from[0] + far * along.cos(), from[1] + far * along.sin());
                        // Rounding of the place, times the slope there.
                        let room = 1e-12 * (1.0 + far);
                        assert!(
                            !(value >= depth + room),
                            "{seed}: {value} at {far} from {from:?} along {along}, {depth}"
                        );
                    }
                }
                Reach::Unknown => unknown += 1,
            }
            several += usize::from(components.as_ref().is_some_and(|c| c.len() > 1));
            for k in 0..600 {
                let p = somewhere(&mut random, if k % 2 == 0 { 1.0 } else { 4.0 });
                if !(gap.gap(p[0], p[1]) < depth) {
                    continue;
                }
                match reach {
                    Reach::Within(rect) => assert!(rect.contains(p), "{seed}: {p:?} outside of {rect:?} at {depth}"),
                    Reach::Nowhere => panic!("{seed}: {p:?} is below {depth}"),
                    _ => {}
                }
                if let Some(components) = &components {
                    assert!(components.iter().any(|c| c.contains(p)), "{seed}: {p:?} in none of {components:?}");
                }
            }
        }
    }
    println!("within {within}, several {several}, unbounded {unbounded}, nowhere {nowhere}, unknown {unknown}");
    assert!(within > 1500 && several > 100 && unbounded > 100, "{within} {several} {unbounded}");
    // What is written down is known: no named kind has to be searched but for a few.
    assert!(unknown * 10 < within, "{unknown}");
}

#[test]
fn bounds_taylor_forms_and_means_hold() {
    let (mut smooth, mut tight, mut sloped) = (0, 0, 0);
    for (seed, gap, mut random) in gaps() {
        for _ in 0..12 {
            let c = somewhere(&mut random, 1.2);
            let half = [0.4 * random.between(0.0, 1.0).powi(3) + 1e-6, 0.4 * random.between(0.0, 1.0).powi(3) + 1e-6];
            let rect = Rect::around(c, half);
            let c = rect.centre();
            let slope = somewhere(&mut random, 1.0);
            let taylor = gap.taylor(&rect);
            let slopes = gap.slopes(&rect);
            let restricted = gap.restricted(&rect);
            let bounds = gap.bounds(&rect, slope).unwrap_or_else(|| panic!("{seed}: no bounds"));
            let mean = gap.mean_bounds(&rect).unwrap_or_else(|| panic!("{seed}: no bounds of the mean"));
            let (n, mut sum) = (12, 0.0);
            let mut values = Vec::with_capacity(n * n);
            for k in 0..n * n {
                let [s, t] = [k % n, k / n].map(|i| (i as f64 + 0.5) / n as f64);
                let p = [rect.min[0] + s * rect.size()[0], rect.min[1] + t * rect.size()[1]];
                let (x, y) = (p[0] - c[0], p[1] - c[1]);
                let value = gap.gap(p[0], p[1]);
                sum += value / (n * n) as f64;
                values.push(value);
                let less = value - slope[0] * x - slope[1] * y;
                let room = rounding(value);
                assert!(bounds[0] <= less + room && less <= bounds[1] + room, "{seed}: {bounds:?} {less} {rect:?}");
                if let Some(t) = taylor {
                    smooth += 1;
                    let h = Interval::point(0.5);
                    let [x, y] = [x, y].map(Interval::point);
                    let [xx, xy, yy] = t.hessian;
                    let form = t.value + t.gradient[0] * x + t.gradient[1] * y;
                    let form = form + h * xx * x.powi(2) + xy * x * y + h * yy * y.powi(2);
                    assert!(form.lo <= value + room && value <= form.hi + room, "{seed}: {form:?} {value} {rect:?}");
                }
                if let Some(simpler) = &restricted {
                    let same = simpler.gap(p[0], p[1]);
                    assert!(same == value || (same - value).abs() <= room, "{seed}: {same} {value}");
                }
            }
            // Over a chord the slope takes its mean somewhere.
            if let Some(slopes) = slopes {
                for k in 0..n * n {
                    let chords = [(k % n > 0, 1), (k >= n, n)];
                    for (m, (_, step)) in chords.into_iter().enumerate().filter(|(_, (inside, _))| *inside) {
                        sloped += 1;
                        let length = rect.size()[m] / n as f64;
                        let steep = (values[k] - values[k - step]) / length;
                        let room = 2.0 * rounding(values[k].abs().max(values[k - step].abs())) / length;
                        let held = slopes[m].lo <= steep + room && steep <= slopes[m].hi + room;
                        assert!(held, "{seed}: {slopes:?} {steep} {rect:?}");
                    }
                }
            }
            // The mean of the midpoints is inside the hull of the values, and close to the mean where the gap is smooth.
            if let Some(t) = taylor {
                let curved = t.hessian.iter().map(|h| h.magnitude()).sum::<f64>() * (half[0] + half[1]).powi(2);
                let room = curved / (n * n) as f64 + rounding(sum);
                assert!(mean[0] - room <= sum && sum <= mean[1] + room, "{seed}: {mean:?} {sum} {rect:?}");
                tight += usize::from(mean[1] - mean[0] <= 1e-3 * curved + rounding(sum));
            }
            if sum.is_finite() {
                let own = gap.mean(&rect);
                let room = 1e-6 * (1.0 + sum.abs());
                let held = own == f64::INFINITY || (mean[0] - room <= own && own <= mean[1] + room);
                assert!(held, "{seed}: {mean:?} {own} {rect:?}");
            }
        }
    }
    assert!(smooth > 100_000 && tight > 1000 && sloped > 200_000, "{smooth} {tight} {sloped}");
}

#[test]
fn growth_holds_along_rays() {
    let mut known = 0;
    for (seed, gap, mut random) in gaps() {
        for _ in 0..10 {
            let middle = random.between(-3.0, 3.0);
            let half = random.between(0.0, 0.2).powi(2);
            let from = 10f64.powf(random.between(-1.0, 3.0));
            let Some(growth) = gap.growth(Interval::new(middle - half, middle + half), from) else { continue };
            known += 1;
            let range = growth.range();
            for _ in 0..20 {
                let (angle, r) = (middle + random.between(-half, half), from * random.between(0.0, 3.0).exp());
                let value = gap.gap(r * angle.cos(), r * angle.sin());
                if value.is_finite() {
                    let room = 1e-9 * (1.0 + value.abs());
                    assert!(range.lo <= value + room && value <= range.hi + room, "{seed}: {range:?} {value}");
                }
            }
        }
    }
    assert!(known > 2000, "{known}");
}
