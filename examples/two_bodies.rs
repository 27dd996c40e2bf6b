//! Two curved elastic bodies: the gaps add, the compliances add. A steel ball in a groove of bronze, by formula and by grid.

use std::fmt::Write;

use contact_patch::gap::{AnyGap, Paraboloid, Sum};
use contact_patch::{Body, Contact, EffectiveModulus, Loading, Method, Settings, solve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let (steel, bronze) = (Body::elastic(2.1e11, 0.3)?, Body::elastic(1.1e11, 0.34)?);
    let modulus = EffectiveModulus::of_pair(steel, bronze)?;
    writeln!(out, "E* = {:.4e} Pa", modulus.e_star())?;
    // The ball, radius 10 mm; the other body, a shaft of 15 mm that lies along x.
    let ball = AnyGap::new(Paraboloid::new([0.010, 0.010])?);
    let shaft = AnyGap::new(Paraboloid::new([f64::INFINITY, 0.015])?);
    let both = Sum::new(vec![ball, shaft])?;
    let contact = Contact::new(modulus, both, Loading::force(50.0))?;
    writeln!(out, "method        depth, um  stiffness, N/um  patch, mm^2  largest pressure, GPa")?;
    for (method, cells) in [(Method::ClosedForm, None), (Method::Ritz, None), (Method::Fft, Some(128))] {
        let s = solve(&contact, &Settings { method, cells, ..Settings::default() }).remove(0)?;
        let highest = s.pressure.max.map_or("not given".to_owned(), |p| format!("{:.4}", 1e-9 * p));
        writeln!(
            out,
            "{:12}  {:9.5}  {:15.4}  {:11.6}  {highest}",
            method.name(),
            1e6 * s.depth,
            1e-6 * s.stiffness,
            1e6 * s.patch.area
        )?;
    }
    Ok(out)
}
