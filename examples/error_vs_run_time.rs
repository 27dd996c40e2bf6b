//! What does a digit of the force cost? Every method on a square punch, at several resolutions.

use std::fmt::Write;

use contact_patch::compare::{Plan, compare};
use contact_patch::{Contact, EffectiveModulus, Loading, Settings, gap::Polyhedron};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let punch = Polyhedron::pyramid(4, 22f64.to_radians())?;
    let contact = Contact::new(EffectiveModulus::from_e_star(1.0)?, punch, Loading::depth(1.0))?;
    let (fft_cells, qp_cells) = (vec![16, 32, 64, 128], vec![12, 24]);
    let plan = Plan { fft_cells, qp_cells, bracket_cells: None, ..Plan::new(Settings::default()) };
    let comparison = compare(&contact, &plan);
    if let Some(reference) = &comparison.reference {
        writeln!(out, "reference: {}, relative error {:.1e}", reference.source, reference.uncertainty)?;
    }
    writeln!(out, "method                  force      error      seconds    of the quickest as close")?;
    for run in &comparison.runs {
        let at = run.cells.map(|n| format!("{n} cells")).or(run.tolerance.map(|t| format!("tolerance {t:e}")));
        let at = at.unwrap_or_default();
        match &run.outcome {
            Ok(f) => writeln!(
                out,
                "{:11} {at:15} {:.6}  {:+.1e}   {:.1e}    {:.1}",
                run.method.name(),
                f.force,
                f.error,
                f.seconds,
                f.behind
            )?,
            Err(unsolved) => writeln!(out, "{:11} {at:15} {}", run.method.name(), unsolved.verdict)?,
        }
    }
    Ok(out)
}
