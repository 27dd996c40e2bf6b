//! Linear systems on a fixed contact: how the pressure grows when the load does.

use super::window::Window;
use super::{Operator, Operators, Settings, faces, fixed, with_threads};
use crate::discrete::Discrete;
use crate::influence::InfluenceTable;
use crate::solution::{Unsolved, Verdict};

/// The pressure that grows at the given rates of overlap on the cells where `pressure` is positive: A m = rate there,
/// m = 0 elsewhere. Rate 1 is a flat punch of the plan-form of the contact: its force is the stiffness dP/dd.
///
/// Conjugate gradients with the preconditioner of the contact solver, in single precision; the residual in double.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, gap::Paraboloid, geometry::Rect, matrix_free};
/// let grid = Grid::over(&Rect::around([0.0; 2], [1.1; 2]), [64, 64]);
/// let problem = Discrete::sample(&Paraboloid::new([1.0, 1.0])?, 1.0, grid, Kernel::Galerkin);
/// let settings = matrix_free::Settings::default();
/// let contact = matrix_free::solve_nested(&problem, &settings)?;
/// let punch = matrix_free::growth(&problem, &contact.pressure, &vec![1.0; grid.len()], &settings)?;
/// // dP/dd = 2 E* a, and a = 1 here.
/// let stiffness = punch.iter().sum::<f64>() * grid.cell_area();
/// assert!((stiffness / 2.0 - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `IterationLimit` when the products are used up, `TimeLimit` when the time is.
pub fn growth(problem: &Discrete, pressure: &[f64], rates: &[f64], settings: &Settings) -> Result<Vec<f64>, Unsolved> {
    let grid = problem.grid;
    let masked: Vec<f64> = pressure.iter().map(|&p| if p > 0.0 { 1.0 } else { f64::NEG_INFINITY }).collect();
    let contact = Discrete { grid, kernel: problem.kernel, overlap: masked };
    let Some(mut window) = Window::of(&contact, 0.0) else { return Ok(vec![0.0; pressure.len()]) };
    let rate = |k: usize| if pressure[k] > 0.0 { rates[k] } else { 0.0 };
    let largest = (0..rates.len()).map(|k| rate(k).abs()).fold(0.0, f64::max);
    let tolerance = settings.tolerance;
    if !window.symmetric(grid.shape, |a, b| (rate(a) - rate(b)).abs() <= 1e-3 * tolerance * largest) {
        window.unfold();
    }
    let table = window.table(&contact);
    let Operators { compliance, single, preconditioner, .. } =
        Operators::new(&table, window.shape(), window.mirrored, true);
    let Some(compliance) = compliance.filter(|_| largest > 0.0) else { return Ok(vec![0.0; pressure.len()]) };
    let face: Vec<f32> = window.grid(&contact).overlap.iter().map(|&f| if f > 0.0 { 1.0 } else { 0.0 }).collect();
    let mut target = window.cut(grid.shape, rates, 0.0);
    target.iter_mut().zip(&face).for_each(|(t, m)| *t = if *m > 0.0 { *t / largest } else { 0.0 });
    let rows = 0..window.shape()[1];
    let mut residual = target.clone();
    let mut m = vec![0.0; target.len()];
    with_threads(settings.threads, |scratch| {
        let mut products = 0;
        let mut before = f64::INFINITY;
        loop {
            let worst =
                residual.iter().zip(&face).filter(|(_, m)| **m > 0.0).fold(0.0, |e: f64, (r, _)| e.max(r.abs()));
            if worst <= tolerance {
                // From the units of the window to those of the rates.
                let unit = largest / table.get(0, 0);
                m.iter_mut().for_each(|m| *m *= unit);
                return Ok(window.paste(grid.shape, &m));
            }
            settings.deadline.check()?;
            if products >= settings.products || worst > 0.5 * before {
                let reason = format!("the stiffness of the contact was not found in {products} products");
                return Err(Unsolved::new(Verdict::IterationLimit, reason));
            }
            before = worst;
            let fixed = fixed::Fixed { single: &single, periodic: None, preconditioner: &preconditioner, face: &face };
            let mut r: Vec<f32> = residual.iter().zip(&face).map(|(r, m)| (r / worst) as f32 * m).collect();
            let goal = (0.7 * tolerance / worst).max(faces::FALL);
            products += 1 + fixed.relax(&mut r, goal as f32, settings.products - products, scratch, |alpha, d| {
                for (m, d) in m.iter_mut().zip(d) {
                    *m += worst * alpha * f64::from(*d);
                }
            });
            compliance.product(&m, rows.clone(), &mut residual, rows.clone(), scratch);
            for (r, t) in residual.iter_mut().zip(&target) {
                *r = t - *r;
            }
        }
    })
}

/// Displacement under a pressure on every cell of its grid, E* = 1.
#[must_use]
pub fn displacement(problem: &Discrete, pressure: &[f64]) -> Vec<f64> {
    let (shape, spacing) = (problem.grid.shape, problem.grid.spacing);
    let table = InfluenceTable::new(problem.kernel, spacing, shape);
    let mut u = vec![0.0; pressure.len()];
    let rows = 0..shape[1];
    with_threads(1, |scratch| {
        Operator::compliance(&table, spacing, shape).apply(pressure, rows.clone(), &mut u, rows, scratch);
    });
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Grid, Kernel};
    use crate::numeric::geometry::Rect;

    #[test]
    fn a_full_square_under_unit_rate_is_a_flat_punch() {
        let grid = Grid::over(&Rect::around([0.0; 2], [0.5; 2]), [64, 64]);
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: vec![1.0; grid.len()] };
        let ones = vec![1.0; grid.len()];
        let punch = growth(&problem, &ones, &ones, &Settings::default()).unwrap();
        let force: f64 = punch.iter().sum::<f64>() * grid.cell_area();
        // P/(E* d) = 1.152298 for a unit square; cell means approach it from below, of first order.
        assert!(force < 1.152298 && force > 1.152298 * 0.99, "{force}");
        let u = displacement(&problem, &punch);
        assert!(u.iter().all(|u| (u - 1.0).abs() < 1e-7));
    }
}
