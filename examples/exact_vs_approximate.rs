//! How far is the approximate method from the converged force, over shapes from a cone to a triangle and from a ball to a
//! roller?

use std::fmt::Write;

use contact_patch::gap::{AnyGap, Paraboloid, Polyhedron};
use contact_patch::{Contact, EffectiveModulus, Loading, Method, Settings, solve};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", text()?);
    Ok(())
}

/// What is printed.
pub fn text() -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let modulus = EffectiveModulus::from_e_star(1.0)?;
    let mut shapes = Vec::new();
    for faces in [3, 4, 6, 12] {
        let punch = Polyhedron::pyramid(faces, 45f64.to_radians())?;
        shapes.push((format!("{faces}-faced pyramid"), AnyGap::new(punch)));
    }
    for ratio in [1.0, 2.0, 3.0, 10.0] {
        shapes.push((format!("paraboloid 1:{ratio}"), AnyGap::new(Paraboloid::new([1.0, ratio])?)));
    }
    writeln!(out, "depth 1, E* = 1; errors against auto to 1e-4")?;
    writeln!(out, "shape              force      fabrikant            best ellipse")?;
    for (name, gap) in shapes {
        let contact = Contact::new(modulus, gap, Loading::depth(1.0))?;
        let run = |method, tolerance| solve(&contact, &Settings { method, tolerance, ..Settings::default() }).remove(0);
        let force = run(Method::Auto, 1e-4)?.force;
        // Where the approximate method has no answer it says why, in a word.
        let error = |method| match run(method, 1e-3) {
            Ok(solution) => format!("{:+.3} %", 100.0 * (solution.force / force - 1.0)),
            Err(unsolved) => unsolved.verdict.to_string(),
        };
        writeln!(out, "{name:17}  {force:.5}   {:22} {}", error(Method::Fabrikant), error(Method::Ritz))?;
    }
    Ok(out)
}
