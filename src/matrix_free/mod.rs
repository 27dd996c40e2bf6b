//! The minimum principle on grids that no dense matrix can hold: conjugate gradients on the contact cells, with the
//! compliance operator and a |q| preconditioner by fast Fourier transforms, from coarse grids to fine.
//!
//! On the present contact the linear system is solved until its residual has fallen tenfold; then cells in
//! tension leave, cells that penetrate enter, and the residual is recomputed (the primal-dual active set of Hintermueller,
//! Ito & Kunisch 2003 with inexact inner solves). The energy must fall from one contact to the next; where it does not, steps of
//! projected gradient with a safe step length take over, which cannot fail to lower it.

mod face;
mod nested;
mod operator;

use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::{Unsolved, Verdict};
use face::Face;

/// How far to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest gap error on the contact, and penetration outside it, relative to the largest overlap.
    pub residual: f64,
    /// Products with the compliance operator after which the answer is a verdict.
    pub most_products: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { residual: 1e-8, most_products: 1000 }
    }
}

/// Solves from coarse grids to this one, or from `start`, a pressure on this grid, when there is one.
///
/// # Errors
/// `IterationLimit` when the products are used up: an answer that has not converged is not an answer.
pub fn solve(problem: &Discrete, start: Option<&[f64]>, settings: &Settings) -> Result<DiscreteSolution, Unsolved> {
    let Some(mut face) = Face::new(problem) else {
        return Ok(nothing(problem));
    };
    match start {
        Some(pressure) => face.start_from(pressure),
        None => nested::start(problem, &mut face, settings)?,
    }
    face.run(settings)?;
    Ok(face.finish())
}

/// The pressure that grows at the given rates of overlap on the cells where `pressure` is positive: A m = rate there,
/// m = 0 elsewhere. Rate 1 is a flat punch of the plan-form of the contact: its force is the stiffness dP/dd.
///
/// # Errors
/// `IterationLimit` when the products are used up.
pub fn growth(problem: &Discrete, pressure: &[f64], rates: &[f64], settings: &Settings) -> Result<Vec<f64>, Unsolved> {
    let overlap = pressure.iter().zip(rates).map(|(&p, &r)| if p > 0.0 { r } else { f64::NEG_INFINITY }).collect();
    let linear = Discrete { grid: problem.grid, kernel: problem.kernel, overlap };
    match Face::on_all(&linear) {
        Some(mut face) => {
            face.linear(settings)?;
            Ok(face.pressure())
        }
        None => Ok(vec![0.0; problem.grid.len()]),
    }
}

/// No overlap anywhere, no pressure.
fn nothing(problem: &Discrete) -> DiscreteSolution {
    let zero = vec![0.0; problem.grid.len()];
    DiscreteSolution {
        residuals: problem.residuals(&zero, &zero),
        pressure: zero.clone(),
        displacement: zero,
        unknowns: 0,
        iterations: 0,
        operator_products: 0,
    }
}

fn exhausted(residual: f64, settings: &Settings) -> Unsolved {
    let reason = format!(
        "residual {residual:.1e} after {} products with the compliance operator; {:.1e} was asked for",
        settings.most_products, settings.residual
    );
    Unsolved::new(Verdict::IterationLimit, reason)
}
