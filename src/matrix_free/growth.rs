//! Linear systems on a fixed contact: how the pressure grows when the load does.

use super::fields::{Fields, Near};
use super::region::Region;
use super::window::Window;
use super::{Operator, Operators, Scratch, Settings, faces, with_threads};
use crate::discrete::Discrete;
use crate::influence::InfluenceTable;
use crate::solution::{Unsolved, Verdict};

/// The pressure that grows at the given rates of overlap on the cells where `pressure` is positive: A m = rate there,
/// m = 0 elsewhere. Rate 1 is a flat punch of the plan-form of the contact: its force is the stiffness dP/dd.
///
/// Conjugate gradients with the preconditioner of the contact solver, in single precision; below a tolerance of 1e-5 the residual in
/// double. Of a residual in double, r, the multiple of least energy is taken, <rate, m>/(<rate, m> - <m, r>): its <rate, m> errs by the
/// square of the residual.
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
    grown(problem, pressure, rates, settings, settings.tolerance < faces::WITHIN_SINGLE)
}

/// The same where nothing but <rate, m>, a force or a moment, is wanted to the tolerance.
pub(crate) fn growth_in_sum(
    problem: &Discrete,
    pressure: &[f64],
    rates: &[f64],
    settings: &Settings,
) -> Result<Vec<f64>, Unsolved> {
    let settings = Settings { tolerance: settings.tolerance.sqrt(), ..*settings };
    grown(problem, pressure, rates, &settings, true)
}

/// The same with the last residual in double precision or not.
fn grown(
    problem: &Discrete,
    pressure: &[f64],
    rates: &[f64],
    settings: &Settings,
    double: bool,
) -> Result<Vec<f64>, Unsolved> {
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
    if largest == 0.0 {
        return Ok(vec![0.0; pressure.len()]);
    }
    let table = window.table(&contact);
    let shape = window.shape();
    let operators = Operators::new(&table, shape, Region::whole(shape), window.mirrored, double, &Scratch::new());
    let mut fields = Fields::new(shape);
    for (m, f) in fields.face.iter_mut().zip(window.grid(&contact).overlap) {
        *m = if f > 0.0 { 1.0 } else { 0.0 };
    }
    let mut target = window.cut(grid.shape, rates, 0.0);
    target.iter_mut().zip(&fields.face).for_each(|(t, m)| *t = if *m > 0.0 { *t / largest } else { 0.0 });
    let rows = 0..shape[1];
    let mut residual = target.clone();
    with_threads(settings.threads, shape, |scratch| {
        let mut products = 0;
        let mut before = f64::INFINITY;
        loop {
            for ((to, from), m) in fields.r.iter_mut().zip(&residual).zip(&fields.face) {
                *to = *from as f32 * m;
            }
            let worst = f64::from(fields.mask(&rows, scratch));
            if worst <= tolerance {
                // From the units of the window to those of the rates.
                let unit = largest / table.get(0, 0);
                fields.p.iter_mut().for_each(|m| *m *= unit);
                return Ok(window.paste(grid.shape, &fields.p));
            }
            settings.deadline.check()?;
            if products >= settings.products || worst > 0.5 * before {
                let reason = format!("the stiffness of the contact was not found in {products} products");
                return Err(Unsolved::new(Verdict::IterationLimit, reason));
            }
            before = worst;
            let goal = (0.7 * tolerance).max(faces::FALL * worst) as f32;
            products += 1 + relaxed(&mut fields, &operators.near, goal, settings.products - products, scratch);
            match &operators.compliance {
                Some(compliance) => {
                    compliance.product(&fields.p, rows.clone(), &mut residual, rows.clone(), scratch);
                    take_best_multiple(&mut fields.p, &mut residual, &target);
                }
                None => residual.iter_mut().zip(&fields.r).for_each(|(to, r)| *to = f64::from(*r)),
            }
        }
    })
}

/// The multiple of m with the least energy on the face, and the residual of it in place of A m: <t, m>/<m, A m>.
fn take_best_multiple(m: &mut [f64], am: &mut [f64], target: &[f64]) {
    let product = |v: &[f64]| m.iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
    let best = product(target) / product(am);
    let best = if best.is_finite() { best } else { 1.0 };
    m.iter_mut().for_each(|m| *m *= best);
    am.iter_mut().zip(target).for_each(|(r, t)| *r = t - best * *r);
}

/// Lowers the residual on the face, w, to `goal`, as far as `limit` products allow; how many it took.
fn relaxed(fields: &mut Fields, near: &Near, goal: f32, limit: usize, scratch: &mut Scratch) -> usize {
    let rows = 0..fields.shape()[1];
    let mut dad_old = 0.0;
    for products in 0..limit {
        let zad = fields.solve_nearly(near, &rows, scratch);
        let beta = if dad_old == 0.0 { 0.0 } else { -zad / dad_old };
        fields.turn(beta as f32, &rows, scratch);
        let [dr, dad, _] = fields.displace(near, &rows, scratch);
        let alpha = dr / dad;
        if !alpha.is_finite() || fields.advance([alpha, 0.0], false, &rows, scratch) <= goal {
            return products + 1;
        }
        dad_old = dad;
    }
    limit
}

/// Displacement under a pressure on every cell of its grid, E* = 1.
#[must_use]
pub fn displacement(problem: &Discrete, pressure: &[f64]) -> Vec<f64> {
    let (shape, spacing) = (problem.grid.shape, problem.grid.spacing);
    let table = InfluenceTable::new(problem.kernel, spacing, shape);
    let mut u = vec![0.0; pressure.len()];
    let rows = 0..shape[1];
    with_threads(1, shape, |scratch| {
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
    fn a_sum_errs_by_the_square_of_the_residual() {
        // Large enough that the product in single precision is split.
        let grid = Grid::over(&Rect::around([0.0; 2], [1.0; 2]), [300, 280]);
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: vec![1.0; grid.len()] };
        let pressure: Vec<f64> = (0..grid.len())
            .map(|k| {
                let [x, y] = grid.centre_of(k);
                // A ring and a spot beside it, without mirrors.
                f64::from(u8::from((0.3..0.9).contains(&(x - 0.05).hypot(y)) || (x - 0.1).hypot(y + 0.07) < 0.11))
            })
            .collect();
        let rates: Vec<f64> = (0..grid.len()).map(|k| 1.0 + 0.3 * grid.centre_of(k)[0]).collect();
        let sum = |m: Vec<f64>| m.iter().zip(&rates).map(|(m, rate)| m * rate).sum::<f64>();
        let settings = Settings::default();
        let close = sum(growth(&problem, &pressure, &rates, &Settings { tolerance: 1e-11, ..settings }).unwrap());
        let found = sum(growth_in_sum(&problem, &pressure, &rates, &settings).unwrap());
        assert!((found / close - 1.0).abs() < settings.tolerance, "{found} {close}");
    }

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
