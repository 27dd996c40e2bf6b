//! How does the real area of contact of a rough surface grow with the load? A self-affine map, pressed step by step.

use contact_patch::{Contact, EffectiveModulus, Loading, Method, Settings, solve};

/// Waves with random phases whose heights fall as k^-1.8 (Hurst exponent 0.8); always the same ones.
fn surface() -> impl Fn(f64, f64) -> f64 + Send + Sync + 'static {
    let mut state = 1_u64;
    let mut random = move || {
        // A linear congruential generator (Knuth) is random enough for phases.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut waves = Vec::new();
    for i in -12_i32..=12 {
        for j in 0..=12 {
            let k = f64::from(i).hypot(f64::from(j));
            if (2.0..=12.0).contains(&k) {
                let [p, q] = [i, j].map(|n| std::f64::consts::TAU * f64::from(n));
                waves.push([p, q, std::f64::consts::TAU * random(), 0.01 * k.powf(-1.8)]);
            }
        }
    }
    move |x, y| {
        if x.abs() <= 0.5 && y.abs() <= 0.5 {
            waves.iter().map(|[p, q, phase, height]| height * (p * x + q * y + phase).cos()).sum()
        } else {
            f64::INFINITY
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let modulus = EffectiveModulus::from_e_star(1.0)?;
    let forces = [1e-4, 3e-4, 1e-3, 3e-3, 1e-2];
    println!("square of side 1, E* = 1, 96 x 96 cells");
    println!("force      depth      area       area/force   regions");
    for force in forces {
        let contact = Contact::new(modulus, surface(), Loading::force(force))?;
        let settings = Settings { method: Method::Fft, cells: Some(96), ..Settings::default() };
        let s = solve(&contact, &settings).remove(0)?;
        println!(
            "{force:.0e}   {:+.5}   {:.6}   {:10.3}   {:7}",
            s.depth,
            s.patch.area,
            s.patch.area / force,
            s.patch.regions
        );
    }
    Ok(())
}
