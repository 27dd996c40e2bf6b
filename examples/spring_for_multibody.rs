//! What does a larger analysis need of a contact? A spring: force against depth with its slope, solved a few times and
//! evaluated often, and a file that a multibody code reads.

use std::fmt::Write;

use contact_patch::gap::Polyhedron;
use contact_patch::{Body, Contact, Curve, CurveRange, EffectiveModulus, Loading, Settings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let modulus = EffectiveModulus::of_pair(Body::elastic(2.1e11, 0.3)?, Body::RIGID)?;
    // A pyramid with a worn tip: flat at small depth, pyramid at large.
    let punch = Polyhedron::truncated_pyramid(4, 22f64.to_radians(), 1e-6)?;
    let contact = Contact::new(modulus, punch, Loading::depth(2e-6))?;
    let range = CurveRange { from: 2.5e-7, to: 2e-6, accuracy: 1e-3 };
    let spring = Curve::new(&contact, &Settings::default(), range)?;
    writeln!(out, "{} solves, estimated error {:.1e}", spring.solves(), spring.interpolation_error())?;
    writeln!(out, "{:>12} {:>12} {:>14}", "depth (m)", "force (N)", "slope (N/m)")?;
    for k in 2..=10 {
        let depth = 2e-7 * f64::from(k);
        if let (Some(force), Some(slope)) = (spring.force(depth), spring.stiffness(depth)) {
            writeln!(out, "{depth:12.2e} {force:12.5} {slope:14.5e}")?;
        }
    }
    writeln!(out, "as a table for a spline element:")?;
    for line in spring.two_columns(4).lines().take(8) {
        writeln!(out, "  {line}")?;
    }
    Ok(out)
}
