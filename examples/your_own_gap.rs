//! How do I press a shape that no kind has a name for? Any closure is a gap: here a ball with a groove along x.

use std::fmt::Write;

use contact_patch::{Body, Contact, EffectiveModulus, Loading, Outputs, Settings, solve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let steel = Body::elastic(2.1e11, 0.3)?;
    let modulus = EffectiveModulus::of_pair(steel, steel)?;
    // Ball of 10 mm, groove 0.5 um deep with a width of some 20 um; lengths in metres.
    let grooved = |x: f64, y: f64| (x * x + y * y) / 0.02 + 0.5e-6 * (-(y / 1e-5).powi(2)).exp();
    writeln!(out, "load, N   depth, um   patch, um^2   regions   largest pressure, GPa")?;
    for force in [0.1, 1.0, 10.0, 100.0] {
        let contact = Contact::new(modulus, grooved, Loading::force(force))?;
        let settings =
            Settings { cells: Some(96), tolerance: 0.02, outputs: Outputs::default(), ..Settings::default() };
        let s = solve(&contact, &settings).remove(0)?;
        let highest = s.pressure.max.unwrap_or(f64::NAN);
        writeln!(
            out,
            "{force:7}   {:9.4}   {:11.1}   {:7}   {:.3}",
            1e6 * s.depth,
            1e12 * s.patch.area,
            s.patch.regions,
            1e-9 * highest
        )?;
    }
    Ok(out)
}
