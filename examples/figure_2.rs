//! Figure 2 of Barber & Billings (1990): where does a tetrahedral punch touch? The converged patch, the boundary of the
//! approximate method, and the best circle, as a picture: `figure_2 [FILE.svg|.png]`.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use contact_patch::plot::{Format, Outline, outlines};
use contact_patch::{
    BoundaryFamily, Contact, EffectiveModulus, Loading, Method, Outputs, Settings, gap::Polyhedron, solve,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("figure_2.svg"), PathBuf::from);
    print!("{}", text(&file)?);
    Ok(())
}

/// What is printed; the picture goes into the file.
pub fn text(file: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
    let contact = Contact::new(EffectiveModulus::from_e_star(1.0)?, punch, Loading::depth(1.0))?;
    let outputs = Outputs { patch: true, ..Outputs::default() };
    let converged = Settings { method: Method::Fft, cells: Some(256), outputs, ..Settings::default() };
    let fabrikant = Settings { method: Method::Fabrikant, outputs, ..Settings::default() };
    let circle = Settings { boundary: BoundaryFamily::Circle, ..fabrikant };
    let mut drawn = Vec::new();
    writeln!(out, "tetrahedral punch, lengths in d/tan(alpha), forces in E* d^2/tan(alpha)")?;
    for (label, settings) in
        [("converged (fft, 256 cells)", converged), ("Fabrikant, stationary", fabrikant), ("best circle", circle)]
    {
        let solution = solve(&contact, &settings).remove(0)?;
        writeln!(out, "{label:28} force {:.6}  patch area {:.4}", solution.force, solution.patch.area)?;
        drawn.push(Outline { label: label.to_owned(), loops: solution.patch.boundary.unwrap_or_default() });
    }
    std::fs::write(
        file,
        outlines("Tetrahedral punch: contact patch, lengths in d/tan(alpha)", &drawn, Format::of(file)?)?,
    )?;
    writeln!(out, "drawn in {}", file.display())?;
    Ok(out)
}
