//! Linear systems on a fixed contact: how the pressure grows when the load does.

use super::{Operator, Settings, Window, with_threads};
use crate::discrete::Discrete;
use crate::error::{Unsolved, Verdict};
use crate::influence::InfluenceTable;

/// The pressure that grows at the given rates of overlap on the cells where `pressure` is positive: A m = rate there,
/// m = 0 elsewhere. Rate 1 is a flat punch of the plan-form of the contact: its force is the stiffness dP/dd.
///
/// Conjugate gradients with the preconditioner of the contact solver.
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
/// `IterationLimit` when the products are used up.
pub fn growth(problem: &Discrete, pressure: &[f64], rates: &[f64], settings: &Settings) -> Result<Vec<f64>, Unsolved> {
    let masked = pressure.iter().map(|&p| if p > 0.0 { 1.0 } else { f64::NEG_INFINITY }).collect();
    let contact = Discrete { grid: problem.grid, kernel: problem.kernel, overlap: masked };
    let Some(window) = Window::of(&contact) else { return Ok(vec![0.0; pressure.len()]) };
    let spacing = problem.grid.spacing;
    let table = InfluenceTable::new(problem.kernel, spacing, window.shape);
    let compliance = Operator::compliance(&table, spacing, window.shape);
    let preconditioner = Operator::preconditioner(&table, spacing, window.shape);
    let cells: Vec<usize> = (0..window.overlap.len()).filter(|&k| window.overlap[k] > 0.0).collect();
    let rate = window.cut(problem.grid.shape[0], rates);
    let largest = cells.iter().map(|&k| rate[k].abs()).fold(0.0, f64::max);
    let (size, rows) = (window.overlap.len(), 0..window.shape[1]);
    let (mut m, mut r, mut z) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
    let (mut direction, mut image) = (vec![0.0; size], vec![0.0; size]);
    cells.iter().for_each(|&k| r[k] = rate[k]);
    let dot = |a: &[f64], b: &[f64]| cells.iter().map(|&k| a[k] * b[k]).sum::<f64>();
    with_threads(settings.threads, |scratch| {
        let mut slope_before = 0.0;
        for step in 0..settings.products {
            let worst = cells.iter().map(|&k| r[k].abs()).fold(0.0, f64::max);
            if worst <= settings.tolerance * largest {
                return Ok(window.paste(problem.grid.shape, &m));
            }
            preconditioner.apply(&r, rows.clone(), &mut z, rows.clone(), scratch);
            let slope = dot(&r, &z);
            let beta = if step == 0 { 0.0 } else { slope / slope_before };
            slope_before = slope;
            cells.iter().for_each(|&k| direction[k] = z[k] + beta * direction[k]);
            compliance.apply(&direction, rows.clone(), &mut image, rows.clone(), scratch);
            let length = slope / dot(&direction, &image);
            if !length.is_finite() {
                break;
            }
            for &k in &cells {
                m[k] += length * direction[k];
                r[k] -= length * image[k];
            }
        }
        let reason = format!("the stiffness of the contact was not found in {} products", settings.products);
        Err(Unsolved::new(Verdict::IterationLimit, reason))
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
    use crate::geometry::Rect;
    use crate::grid::{Grid, Kernel};

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
