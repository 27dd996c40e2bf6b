//! Measured surfaces and lines: smooth bodies met from their samples, and what the samples leave open.

use contact_patch::gap::{
    Along, AnyGap, Gap, HeightMap, Heights, Interpolation, Line, Profile, SplineMap, Sum, Surface, Zero,
};
use contact_patch::geometry::Rect;
use contact_patch::{Contact, EffectiveModulus, Loading, Settings, Solution, Unsolved, Verdict, solve};

/// Noise of standard deviation 1 that is the same every time.
fn noise(seed: usize) -> f64 {
    let part = |m: usize| {
        let v = ((12 * seed + m) as f64 * 12.9898).sin() * 43_758.545_3;
        v - v.floor()
    };
    (0..12).map(part).sum::<f64>() - 6.0
}

/// A true ball of radius r, sampled at steps h over +-half, its lowest point off the nodes, with noise s.
fn ball(r: f64, h: f64, half: f64, s: f64) -> Heights {
    let n = 2 * (half / h).round() as usize + 1;
    let z = |k: usize| {
        let x = ((k % n) as f64 - 0.5 * (n - 1) as f64 + 0.31) * h;
        let y = ((k / n) as f64 - 0.5 * (n - 1) as f64 - 0.2) * h;
        (x * x + y * y) / (r + (r * r - x * x - y * y).sqrt()) + s * noise(k)
    };
    Heights::new((0..n * n).map(z).collect(), [n, n], [h, h]).unwrap()
}

fn solved(gap: impl Into<AnyGap>, depth: f64, tolerance: f64, bracket: bool) -> Result<Solution, Unsolved> {
    let gap: AnyGap = gap.into();
    let contact = Contact::new(EffectiveModulus::from_e_star(1e11).unwrap(), gap, Loading::depth(depth)).unwrap();
    let mut settings = Settings { tolerance, ..Settings::default() };
    settings.outputs.bracket = bracket;
    solve(&contact, &settings).remove(0)
}

#[test]
fn a_ball_is_met_from_its_samples_within_what_is_stated() {
    // Contacts of 30 um, 8 to 30 steps; the ball of Hertz is the same one to second order.
    for r in [2e-3_f64, 8e-3, 32e-3] {
        for h in [1e-6, 2e-6, 4e-6] {
            let depth = 9e-10 / r;
            // Paraboloids, as Hertz has them: x^2 + y^2 over 2 r.
            let z = |k: usize, n: usize| {
                let x = ((k % n) as f64 - 0.5 * (n - 1) as f64 + 0.31) * h;
                let y = ((k / n) as f64 - 0.5 * (n - 1) as f64 - 0.2) * h;
                (x * x + y * y) / (2.0 * r)
            };
            let n = 2 * (6e-5 / h).round() as usize + 1;
            let heights = Heights::new((0..n * n).map(|k| z(k, n)).collect(), [n, n], [h, h]).unwrap();
            let map = SplineMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap();
            let state = solved(&map, depth, 1e-3, true).unwrap();
            let hertz = 4.0 / 3.0 * 1e11 * r.sqrt() * depth.powf(1.5);
            let off = (state.force / hertz - 1.0).abs();
            let stated = state.force_error.unwrap();
            assert!(off <= stated && stated < 1e-3, "{r} {h}: {off:e} {stated:e}");
            let bracket = state.bracket.as_ref().unwrap();
            assert!(bracket.contains(hertz) && bracket.relative_width() < 2e-3, "{r} {h}");
            let peak = 2e11 / std::f64::consts::PI * (depth / r).sqrt();
            assert!((state.pressure.max.unwrap() / peak - 1.0).abs() < 2e-3, "{r} {h}");
            // The facets through the same heights are another body.
            let facets = HeightMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap();
            let [off, faceted] = [solved(&map, depth, 1e-4, false), solved(&facets, depth, 1e-4, false)]
                .map(|state| (state.unwrap().force / hertz - 1.0).abs());
            assert!(faceted > 2.0 * off, "{r} {h}: {faceted:e} {off:e}");
        }
    }
}

#[test]
fn what_lies_between_samples_is_within_what_is_said_of_them() {
    // Bodies of known shape, from rough to smooth, sampled from coarse to fine.
    type Shape = fn(f64, f64) -> f64;
    let shapes: [(Shape, &str); 4] = [
        (|x, y| 1.5 - (2.25 - x * x - y * y).sqrt(), "ball"),
        (|x, y| 0.3 * x * x + 0.2 * y * y + 0.02 * (9.0 * x + 4.0 * y).sin(), "wave"),
        (|x, y| (x * x + y * y).powf(0.75), "power 1.5"),
        (|x, y| 0.4 * x.hypot(y), "cone"),
    ];
    for (shape, name) in shapes {
        for n in [11, 21, 41, 81] {
            let h = 2.0 / (n - 1) as f64;
            // Off the nodes, as a measurement would have it.
            let place = |k: usize| [-1.0 + h * (k % n) as f64 + 0.3 * h, -1.0 + h * (k / n) as f64 - 0.21 * h];
            let heights = (0..n * n).map(place).map(|[x, y]| shape(x, y)).collect();
            let heights = Heights::new(heights, [n, n], [h, h]).unwrap().at(place(0)).unwrap();
            let map = SplineMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap();
            let rect = Rect::around([0.0; 2], [0.6; 2]);
            let mut off = 0.0_f64;
            for k in 0..200 * 200 {
                let [x, y] = [k % 200, k / 200].map(|i| -0.6 + 1.2 * (i as f64 + 0.5) / 200.0);
                off = off.max((map.gap(x, y) - shape(x, y)).abs());
            }
            let said = map.sampling_error(&rect);
            assert!(off <= said, "{name} {n}: off by {off:e}, said {said:e}");
            assert!(said <= 300.0 * off + 1e-12, "{name} {n}: off by {off:e}, said {said:e}");
        }
    }
}

#[test]
fn a_cone_is_met_from_its_samples_although_none_shows_its_tip() {
    // P = 2/pi E* d^2/s. Its tip, blunted between samples, carries little: 1e-3 from 41 x 41 of them.
    let (s, depth) = (0.2_f64, 4e-7_f64);
    for (n, at) in [(41, [0.31, -0.2]), (64, [0.5, 0.5]), (81, [0.1, 0.45])] {
        let h = 2.4 * depth / s / (n - 1) as f64;
        let r = |k: usize| {
            let [x, y] = [k % n, k / n].map(|i| i as f64 - 0.5 * (n - 1) as f64);
            h * (x + at[0]).hypot(y + at[1])
        };
        let heights = Heights::new((0..n * n).map(|k| s * r(k)).collect(), [n, n], [h, h]).unwrap();
        let map = SplineMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap();
        let state = solved(&map, depth, 1e-3, false).unwrap();
        let off = (state.force / (2.0 / std::f64::consts::PI * 1e11 * depth * depth / s) - 1.0).abs();
        assert!(off <= state.force_error.unwrap(), "{n}: off by {off:e}, said {:?}", state.force_error);
        assert!(state.map_error.unwrap() > 0.0, "{n}");
    }
}

/// Where depths are counted from first touch, the samples say where that is: a tip between them is lower, that of a smooth body is not.
#[test]
fn first_touch_between_the_samples_is_within_what_is_said_of_it() {
    let tip = |height: &dyn Fn(f64, f64) -> f64, [a, b]: [f64; 2]| {
        let n = 41;
        let z = |k: usize| height((k % n) as f64 - 20.0 + a, (k / n) as f64 - 20.0 + b);
        let heights = Heights::new((0..n * n).map(z).collect(), [n, n], [1.0, 1.0]).unwrap();
        let map = SplineMap::new(&heights, Surface::Upper, Zero::FirstTouch).unwrap();
        let state = match solved(&map, 10.0, 1e-3, false) {
            Ok(state) => state,
            Err(e) => *e.best.unwrap(),
        };
        (state.force, state.force_error.unwrap(), state.map_error.unwrap())
    };
    for at in [[0.0, 0.0], [0.5, 0.5], [0.31, -0.2], [0.5, 0.0]] {
        // tan(alpha) = 1; P = 2/pi E* d^2 cot(alpha).
        let (force, stated, _) = tip(&|x, y| x.hypot(y), at);
        let sneddon = 2.0 / std::f64::consts::PI * 1e11 * 100.0;
        assert!((force / sneddon - 1.0).abs() <= stated, "{at:?}: {force:e} {sneddon:e} {stated:e}");
        let (force, stated, open) = tip(&|x, y| (x * x + y * y) / 15.0, at);
        let hertz = 4.0 / 3.0 * 1e11 * 7.5_f64.sqrt() * 10.0_f64.powf(1.5);
        assert!(
            (force / hertz - 1.0).abs() <= stated && open < 1e-6,
            "{at:?}: {force:e} {hertz:e} {stated:e} {open:e}"
        );
    }
    // The edge of a profile, rolled: of two planes with a slope of 1 in 10.
    let edge = |at: f64| {
        let points: Vec<[f64; 2]> = (0..61).map(|k| k as f64 - 30.0 + at).map(|y| [y, 0.1 * y.abs()]).collect();
        let line = Line::new(points).unwrap();
        let profile = Profile::new(&line, Along::X, Surface::Upper, Zero::FirstTouch, Interpolation::Cubic);
        match solved(AnyGap::new(profile.unwrap().rolling(50.0).unwrap()), 1.0, 1e-3, false) {
            Ok(state) => (state.force, state.force_error.unwrap()),
            Err(e) => e.best.map(|best| (best.force, best.force_error.unwrap())).unwrap(),
        }
    };
    let (true_one, own) = edge(0.0);
    for at in [0.5, 0.3] {
        let (force, stated) = edge(at);
        assert!((force / true_one - 1.0).abs() <= stated + own, "{at}: {force:e} {true_one:e} {stated:e} {own:e}");
    }
}

#[test]
fn every_second_sample_of_a_rough_surface_is_off_by_what_is_said() {
    let (n, h) = (97, 1e-6);
    for seed in 0..4 {
        let wave = |q: usize| {
            let a = 3.0 * noise(100 * seed + q);
            let k = 2.0 * std::f64::consts::PI / (n as f64 * h) * (2.0 + 0.2 * q as f64);
            (k * a.cos(), k * a.sin(), 5.0 * noise(100 * seed + q + 50), 1e-8 * noise(900 + q))
        };
        let waves: Vec<_> = (0..24).map(wave).collect();
        let z = |i: usize, j: usize| {
            let [x, y] = [i, j].map(|i| i as f64 * h);
            waves.iter().map(|(kx, ky, phase, a)| a * (kx * x + ky * y + phase).cos()).sum::<f64>()
        };
        let sampled = |every: usize| {
            let m = (n - 1) / every + 1;
            let z = (0..m * m).map(|k| z(every * (k % m), every * (k / m))).collect();
            let heights = Heights::new(z, [m, m], [every as f64 * h; 2]).unwrap();
            SplineMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap()
        };
        let [all, second] = [1, 2].map(sampled);
        let depth = all.describe().floor + 4e-8;
        let best = |map: SplineMap| match solved(&map, depth, 1e-2, false) {
            Ok(state) => state,
            Err(unsolved) => *unsolved.best.unwrap(),
        };
        let [all, second] = [all, second].map(best);
        let off = (all.force / second.force - 1.0).abs();
        let [own, said] = [&all, &second].map(|state| state.force_error.unwrap());
        assert!(off <= said + own, "{seed}: off by {off:e}, said {said:e} and {own:e}");
        assert!(all.map_error.unwrap() < second.map_error.unwrap(), "{seed}");
        assert!(said < 0.05, "{seed}: {said:e}");
    }
}

#[test]
fn noise_is_taken_out_and_what_is_left_of_it_is_stated() {
    let (r, s, depth) = (8e-3_f64, 1e-8, 4e-7_f64);
    let hertz = 4.0 / 3.0 * 1e11 * r.sqrt() * depth.powf(1.5);
    let heights = ball(r, 2e-6, 1e-4, s);
    let rough = SplineMap::new(&heights, Surface::Upper, Zero::AsIs).unwrap();
    let smooth = SplineMap::new(&heights.clone().smoothed(s).unwrap(), Surface::Upper, Zero::AsIs).unwrap();
    let best = |gap: &SplineMap| match solved(gap, depth, 1e-2, false) {
        Ok(state) => (state, None),
        Err(e) => (*e.best.clone().unwrap(), Some(e.verdict)),
    };
    let ((rough, verdict), (smooth, _)) = (best(&rough), best(&smooth));
    // The rough one says that its samples do not tell.
    assert_eq!(verdict, Some(Verdict::ToleranceNotReached));
    let off = |state: &Solution| (state.force / hertz - 1.0).abs();
    let stated = |state: &Solution| state.force_error.unwrap();
    assert!(rough.patch.regions > 3 && smooth.patch.regions == 1, "{} {}", rough.patch.regions, smooth.patch.regions);
    assert!(off(&rough) <= stated(&rough), "{:e} {:e}", off(&rough), stated(&rough));
    assert!(
        off(&smooth) <= stated(&smooth) && stated(&smooth) < 0.3 * stated(&rough),
        "{:e} {:e}",
        off(&smooth),
        stated(&smooth)
    );
    let peak = 2e11 / std::f64::consts::PI * (depth / r).sqrt();
    assert!((smooth.pressure.max.unwrap() / peak - 1.0).abs() < 0.03, "{:e}", smooth.pressure.max.unwrap() / peak);
}

#[test]
fn a_roller_from_its_profile_is_that_of_hertz() {
    // A crown of radius 0.3 across a roller of 0.05, both ways round.
    let points = || (0..=80).map(|k| 1e-4 * (f64::from(k) - 39.7)).map(|y| [y, y * y / 0.6]).collect();
    let exact = contact_patch::gap::Paraboloid::new([0.05, 0.3]).unwrap();
    let depth = 2e-6;
    let hertz = solved(&exact, depth, 1e-3, false).unwrap();
    for along in [Along::X, Along::Y] {
        let line = Line::new(points()).unwrap();
        let profile = Profile::new(&line, along, Surface::Upper, Zero::FirstTouch, Interpolation::Cubic).unwrap();
        // Alone it has no end.
        assert_eq!(solved(&profile, depth, 1e-3, false).unwrap_err().verdict, Verdict::Unbounded);
        let state = solved(&profile.rolling(0.05).unwrap(), depth, 1e-3, false).unwrap();
        assert!((state.force / hertz.force - 1.0).abs() <= state.force_error.unwrap(), "{along:?}");
    }
    // Two straight profiles across one another are crossed cylinders.
    let cylinder = |r: f64| {
        Line::new((0..=80).map(|k| 1e-4 * (f64::from(k) - 39.7)).map(|y| [y, y * y / (2.0 * r)]).collect()).unwrap()
    };
    let straight = |r: f64, along: Along| {
        AnyGap::new(Profile::new(&cylinder(r), along, Surface::Upper, Zero::FirstTouch, Interpolation::Cubic).unwrap())
    };
    let crossed = Sum::new(vec![straight(0.3, Along::X), straight(0.05, Along::Y)]).unwrap();
    let state = solved(&crossed, depth, 1e-3, false).unwrap();
    assert!((state.force / hertz.force - 1.0).abs() <= state.force_error.unwrap());
}

/// The rail's head and the wheel of data/scenes/profiles, without noise: points and angles along arcs that touch one another, mm.
#[cfg(feature = "scene")]
mod drawn {
    fn arc([y, z, from]: [f64; 3], to: f64, radius: f64) -> Vec<[f64; 3]> {
        let side = (to - from).signum();
        let n = ((to - from).abs() * radius / 0.25).round().max(2.0) as usize;
        let at = |k: usize| {
            let a = from + (to - from) * k as f64 / n as f64;
            [y + side * radius * (a.sin() - from.sin()), z - side * radius * (a.cos() - from.cos()), a]
        };
        (1..=n).map(at).collect()
    }

    fn metres(line: &[[f64; 3]]) -> Vec<[f64; 2]> {
        line.iter().map(|p| [1e-3 * p[0], 1e-3 * p[1]]).collect()
    }

    pub fn rail() -> Vec<[f64; 2]> {
        let mut half = vec![[0.0; 3]];
        for (width, radius) in [(10.26, 300.0), (15.09, 80.0)] {
            let last = half[half.len() - 1];
            half.extend(arc(last, (last[2].sin() - width / radius).asin(), radius));
        }
        half.extend(arc(half[half.len() - 1], -1.3, 13.0));
        let other: Vec<[f64; 3]> = half[1..].iter().rev().map(|[y, z, a]| [-y, *z, -a]).collect();
        metres(&[other, half].concat())
    }

    pub fn wheel() -> Vec<[f64; 2]> {
        let tread = 0.05f64.atan();
        let mut line: Vec<[f64; 3]> =
            (0..301).map(|k| 0.25 * f64::from(k) - 50.0).map(|y| [y, -y / 20.0, -tread]).collect();
        line.extend(arc(line[line.len() - 1], -70f64.to_radians(), 14.0));
        metres(&line)
    }
}

#[cfg(feature = "scene")]
#[test]
fn a_wheel_on_a_rail_is_read_back_from_what_was_measured() {
    use contact_patch::Scene;
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes");
    let scene = Scene::from_file(&folder.join("wheel_on_rail.json")).unwrap();
    let measured = solve(&scene.contact, &scene.settings).remove(0).unwrap();
    // The same without noise, from its drawing.
    let part = |points: Vec<[f64; 2]>, surface: Surface, turn: f64| {
        let line = Line::new(points).unwrap().turned(turn).unwrap().between([-0.02, 0.024]).unwrap();
        Profile::new(&line, Along::X, surface, Zero::AsIs, Interpolation::Cubic).unwrap()
    };
    let wheel = part(drawn::wheel(), Surface::Upper, 0.0).rolling(0.46).unwrap();
    let rail = part(drawn::rail(), Surface::Lower, (-1.4321f64).to_radians());
    let sum = Sum::new(vec![AnyGap::new(wheel), AnyGap::new(rail)]).unwrap();
    let contact = Contact::new(scene.contact.modulus(), sum, Loading::force(80_000.0)).unwrap();
    let drawn = solve(&contact, &Settings { tolerance: 1e-2, ..Settings::default() }).remove(0).unwrap();
    assert_eq!((measured.patch.regions, drawn.patch.regions), (1, 1));
    let off = |a: f64, b: f64| (a / b - 1.0).abs();
    assert!(off(measured.pressure.max.unwrap(), drawn.pressure.max.unwrap()) < 0.03);
    assert!(off(measured.patch.area, drawn.patch.area) < 0.03);
    // What noise is left may move the peak by more than the grid does: that is stated.
    let peaks = [&measured, &drawn].map(|state| state.pressure.max_error.unwrap());
    assert!(off(measured.pressure.max.unwrap(), drawn.pressure.max.unwrap()) <= peaks[0] + peaks[1], "{peaks:?}");
    // The stated errors, under a force those of the depth, hold the drawn one.
    let stated = |state: &Solution| state.depth_error.unwrap() * state.depth.abs();
    let (apart, stated) = ((measured.depth - drawn.depth).abs(), stated(&measured) + stated(&drawn));
    assert!(apart <= stated, "{apart:e} {stated:e}");
}

#[cfg(feature = "scene")]
#[test]
fn files_of_profilers_are_read_as_another_program_reads_them() {
    let maps = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/maps");
    // First heights, one inside and the number of holes, as surfalize 0.19 reads the same file (in um).
    let heights = Heights::read(&maps.join("noisy_ball.x3p"), None, None).unwrap();
    assert_eq!((heights.shape(), heights.spacing()), ([61, 61], [4e-6, 4e-6]));
    let z = heights.values();
    for (node, um) in [(0, 2.8902046), (1, 2.77282167), (2, 2.69649049), (5 * 61 + 7, 1.8407515832826729)] {
        assert!((1e6 * z[node] - um).abs() < 1e-8, "{node}: {}", z[node]);
    }
    assert_eq!(z.iter().filter(|z| z.is_nan()).count(), 21);
    let heights = Heights::read(&maps.join("ball.sdf"), None, None).unwrap();
    assert_eq!((heights.shape(), heights.spacing()), ([61, 61], [4e-6, 4e-6]));
    assert!((heights.values()[0] - 2.88e-6).abs() < 1e-18 && heights.values()[30 * 61 + 30] == 0.0);
    // Another spacing than that of the file is refused.
    let other = Heights::read(&maps.join("ball.sdf"), None, Some([5e-6, 4e-6])).unwrap_err();
    assert_eq!(other.path, "spacing[0]");
}

#[cfg(feature = "scene")]
#[test]
fn units_of_files_and_scenes_are_turned_into_one_another() {
    use contact_patch::Scene;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let points: String = (-20..=20).map(|k| f64::from(k) * 0.5).map(|y| format!("{y}; {}\n", y * y / 600.0)).collect();
    at("crown.txt", &points);
    at("crown.whl", &format!("Units=mm\n\n{points}"));
    let sdf = "aISO-1.0\nNumPoints = 3\nNumProfiles = 3\nXscale = 1e-6\nYscale = 1e-6\nZscale = 1e-9\n*\n3 2 3\n1 0 1\n3 2 3\n*\n";
    at("map.sdf", sdf);
    let gap = |gap: &str, x: f64, y: f64| {
        let scene = format!(r#"{{"effective_modulus": 1.0, "loading": {{"depth": -1.0}}, "gap": {{{gap}}}}}"#);
        at("scene.json", &scene);
        Scene::from_file(&folder.path().join("scene.json"))
            .unwrap_or_else(|e| panic!("{gap}: {e}"))
            .contact
            .gap()
            .gap(x, y)
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs(), "{a:e} {b:e}");
    // 6 mm off the middle of a crown of radius 300 mm.
    near(gap(r#""kind": "profile", "along": "x", "file": "crown.txt", "unit": "mm""#, 0.0, 6e-3), 6e-5);
    near(gap(r#""kind": "profile", "along": "x", "file": "crown.whl""#, 0.0, 6e-3), 6e-5);
    near(gap(r#""kind": "profile", "along": "x", "file": "crown.txt""#, 0.0, 6.0), 6e-2);
    near(gap(r#""kind": "profile", "along": "x", "file": "crown.whl", "scene_unit": "mm""#, 0.0, 6.0), 6e-2);
    // A node of the map, in metres and in micrometres.
    near(
        gap(r#""kind": "height_map", "surface": "upper", "file": "map.sdf", "interpolation": "linear""#, 1e-6, 1e-6),
        3e-9,
    );
    let um =
        r#""kind": "height_map", "surface": "upper", "file": "map.sdf", "interpolation": "linear", "scene_unit": "um""#;
    near(gap(um, 1.0, 1.0), 3e-3);
}
