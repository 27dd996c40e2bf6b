//! The error that a grid states holds: against closed forms, whatever the tolerance, the kernel, the place and the turn.

mod random;

use contact_patch::gap::{AnyGap, Cone, Flat, Outline, Paraboloid, Place, Polyhedron, Power, Sphere, Sum};
use contact_patch::{Contact, EffectiveModulus, Kernel, Loading, Method, Settings, solve};
use random::Random;

/// A gap with a closed form, by lot, and what it is called.
fn closed(random: &mut Random) -> (AnyGap, &'static str) {
    match (random.next() * 5.0) as u32 {
        0 => (AnyGap::new(Cone::with_slope(random.between(0.2, 2.5)).unwrap()), "cone"),
        1 => (AnyGap::new(Power::new(random.between(0.2, 2.0), random.between(0.7, 8.0)).unwrap()), "power"),
        2 => (AnyGap::new(Sphere::new(5.0).unwrap()), "sphere"),
        _ => (AnyGap::new(Paraboloid::new([1.0, 10f64.powf(random.between(0.0, 2.3))]).unwrap()), "paraboloid"),
    }
}

fn force(gap: &AnyGap, depth: f64, settings: &Settings) -> (f64, f64) {
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    let contact = Contact::new(modulus, gap.clone(), Loading::depth(depth)).unwrap();
    let state = solve(&contact, settings).remove(0).unwrap();
    (state.force, state.force_error.unwrap())
}

#[test]
fn of_two_hundred_closed_forms() {
    let mut random = Random(20_261_121);
    for n in 0..200 {
        let (gap, name) = closed(&mut random);
        let at = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
        let gap = gap.placed(at, random.between(0.0, 6.3)).unwrap();
        let depth = 10f64.powf(random.between(-2.0, -0.5));
        let kernel = if random.next() < 0.3 { Kernel::Collocation } else { Kernel::Galerkin };
        let tolerance = 10f64.powf(random.between(-4.0, -1.7));
        let (exact, _) = force(&gap, depth, &Settings { method: Method::ClosedForm, ..Settings::default() });
        let (found, said) =
            force(&gap, depth, &Settings { method: Method::Fft, kernel, tolerance, ..Settings::default() });
        let off = (found / exact - 1.0).abs();
        assert!(
            off <= said && said <= tolerance,
            "{n}: {name} at {depth:e}, {kernel:?}, {tolerance:.1e}: {off:.1e}, said {said:.1e}"
        );
    }
}

#[test]
fn of_pyramids_turned_against_the_grid() {
    // Converged values (data/reference, to 1e-6): 3 and 4 faces at 45 degrees, and their like at other depths.
    let mut random = Random(33);
    for n in 0..60 {
        let (faces, group) = if random.next() < 0.5 { (3, 0.882_412) } else { (4, 0.737_616) };
        let pyramid = AnyGap::new(Polyhedron::pyramid(faces, 45f64.to_radians()).unwrap());
        let at = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
        let gap = pyramid.placed(at, random.between(0.0, 6.3)).unwrap();
        let depth = 10f64.powf(random.between(-2.0, 0.5));
        let tolerance = 10f64.powf(random.between(-3.7, -1.7));
        let (found, said) = force(&gap, depth, &Settings { method: Method::Fft, tolerance, ..Settings::default() });
        let off = (found / (group * depth * depth) - 1.0).abs();
        assert!(
            off <= said + 2e-6 && said <= tolerance,
            "{n}: {faces} faces, {tolerance:.1e}: {off:.1e}, said {said:.1e}"
        );
    }
}

#[test]
fn of_irregular_pyramids() {
    let mut random = Random(12);
    for n in 0..40 {
        let (faces, skew) = (3 + (random.next() * 4.0) as usize, random.next());
        let aspect = 10f64.powf(random.next() * random.between(0.0, 1.0));
        let plane = |k: usize, random: &mut Random| {
            let angle = std::f64::consts::TAU * (k as f64 + 0.6 * skew * random.between(-0.5, 0.5)) / faces as f64;
            let slope = 1.0 + skew * random.between(-0.5, 0.5);
            [slope * angle.cos(), slope * aspect * angle.sin(), 0.0]
        };
        let planes = (0..faces).map(|k| plane(k, &mut random)).collect();
        let pyramid = AnyGap::new(Polyhedron::new(planes).unwrap());
        let fine = Settings { method: Method::Fft, tolerance: 2e-4, ..Settings::default() };
        let (exact, doubt) = force(&pyramid, 0.1, &fine);
        let gap = pyramid.placed([0.1, -0.2], random.between(0.0, 6.3)).unwrap();
        for tolerance in [1e-2, 2e-3] {
            let (found, said) = force(&gap, 0.1, &Settings { tolerance, ..fine });
            let off = (found / exact - 1.0).abs();
            assert!(
                off <= said + doubt && said <= tolerance,
                "{n}: {faces} faces, aspect {aspect:.1}, {tolerance:.0e}: {off:.1e}, said {said:.1e}"
            );
        }
    }
}

#[test]
fn where_the_material_ends() {
    // A round punch cut off at a: P = 2 E* (a d - a^3/(3 R)) once it has all touched; flat where R is infinite.
    let mut random = Random(7);
    for n in 0..24 {
        let (a, radius) = (random.between(0.3, 1.0), random.between(2.0, 20.0));
        let at = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
        let disc = Flat::new(Outline::disc(a).unwrap()).placed(at, 0.0).unwrap();
        let round = Paraboloid::new([radius; 2]).unwrap().placed(at, 0.0).unwrap();
        let flat = random.next() < 0.5;
        let gap = if flat { disc } else { AnyGap::new(Sum::new(vec![disc, round]).unwrap()) };
        let depth = random.between(1.1, 4.0) * a * a / radius;
        let exact = 2.0 * (a * depth - if flat { 0.0 } else { a.powi(3) / (3.0 * radius) });
        let kernel = if random.next() < 0.4 { Kernel::Collocation } else { Kernel::Galerkin };
        let tolerance = 10f64.powf(random.between(-3.0, -2.0));
        let (found, said) =
            force(&gap, depth, &Settings { method: Method::Fft, kernel, tolerance, ..Settings::default() });
        let off = (found / exact - 1.0).abs();
        assert!(off <= said && said <= tolerance, "{n}: {a} {radius} {flat} {kernel:?}: {off:.1e}, said {said:.1e}");
    }
}
