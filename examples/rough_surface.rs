//! How does the real area of contact of a rough surface grow with the load? A self-affine one, pressed step by step.

use std::fmt::Write;

use contact_patch::gap::{HeightMap, Heights, Surface, Zero};
use contact_patch::{Contact, EffectiveModulus, InputError, Load, Loading, Method, Settings, solve};

/// Heights at 129 x 129 points of a square of side 1, as a profilometer gives them: waves with random phases, always the same
/// ones, that fall as k^-1.8 (Hurst exponent 0.8).
fn surface() -> Result<Heights, InputError> {
    let mut state = 1_u64;
    let mut random = move || {
        // A linear congruential generator (Knuth) is random enough for phases.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut waves = Vec::new();
    for i in -8_i32..=8 {
        for j in 0..=8 {
            let k = f64::from(i).hypot(f64::from(j));
            if (2.0..=8.0).contains(&k) {
                let [p, q] = [i, j].map(|n| std::f64::consts::TAU * f64::from(n));
                waves.push([p, q, std::f64::consts::TAU * random(), 0.01 * k.powf(-1.8)]);
            }
        }
    }
    let place = |n: usize| n as f64 / 128.0 - 0.5;
    let heights = (0..129 * 129).map(|k| {
        let [x, y] = [place(k % 129), place(k / 129)];
        waves.iter().map(|[p, q, phase, height]| height * (p * x + q * y + phase).cos()).sum()
    });
    Heights::new(heights.collect(), [129; 2], [1.0 / 128.0; 2])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let modulus = EffectiveModulus::from_e_star(1.0)?;
    let depths = [-0.014, -0.011, -0.008, -0.005, -0.002, 0.001];
    let steps = Loading::Steps(depths.map(Load::Depth).to_vec());
    // Heights count from the mean plane of the upper surface, and so do depths.
    let contact = Contact::new(modulus, HeightMap::new(&surface()?, Surface::Upper, Zero::AsIs)?, steps)?;
    let settings = Settings { method: Method::Fft, cells: Some(128), tolerance: 0.2, ..Settings::default() };
    writeln!(out, "square of side 1, E* = 1")?;
    writeln!(out, "depth    force        area       area/force   regions")?;
    for step in solve(&contact, &settings) {
        let s = step?;
        writeln!(
            out,
            "{:+.3}   {:.4e}   {:.6}   {:10.3}   {:7}",
            s.depth,
            s.force,
            s.patch.area,
            s.patch.area / s.force,
            s.patch.regions
        )?;
    }
    Ok(out)
}
