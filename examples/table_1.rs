//! Table 1 of Barber & Billings (1990): the digits they print, ours, and how far both are from the converged force.

use std::fmt::Write;

use contact_patch::fabrikant::{self, RegularPolyhedron, Settings};
use contact_patch::{EffectiveModulus, gap::Polyhedron, ritz};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    // Faces, printed D and P, converged force P tan(alpha)/(E* d^2) by a boundary-element solution.
    const TABLE: [(usize, f64, f64, f64); 10] = [
        (3, 1.000, 1.696, 0.882412),
        (4, 0.853, 1.449, 0.737616),
        (5, 0.809, 1.373, 0.693338),
        (6, 0.789, 1.339, 0.673297),
        (7, 0.778, 1.320, 0.66239),
        (8, 0.770, 1.308, 0.655757),
        (10, 0.763, 1.295, 0.64840),
        (15, 0.757, 1.283, 0.64162),
        (20, 0.754, 1.279, 0.63938),
        (50, 0.750, 1.274, 0.63705),
    ];
    let (modulus, settings) = (EffectiveModulus::from_e_star(1.0)?, Settings::default());
    writeln!(out, "3 pi D tan(alpha)/(4 d^2) and (1 - nu) P tan(alpha)/(mu d^2); errors against the converged force")?;
    writeln!(out, "faces   D printed   D        P printed   P general    P closed     error     best ellipse")?;
    for (faces, printed_d, printed_p, exact) in TABLE {
        let punch = Polyhedron::pyramid(faces, 45f64.to_radians())?;
        let general = fabrikant::stationary(&punch, modulus, 1.0, &settings)?;
        let closed = RegularPolyhedron::new(faces)?;
        let ellipse = ritz::ellipse(&punch, modulus, 1.0, &settings)?;
        let percent = |force: f64| 100.0 * (force / exact - 1.0);
        writeln!(
            out,
            "{faces:5}   {printed_d:9.3}   {:.5}  {printed_p:9.3}   {:.7}    {:.7}    {:5.2} %   {:6.2} %",
            closed.kappa,
            2.0 * general.force,
            2.0 * closed.force,
            percent(general.force),
            percent(ellipse.force)
        )?;
    }
    Ok(out)
}
