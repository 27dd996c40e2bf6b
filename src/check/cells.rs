//! What a pressure field does in its cells: overlap, displacement, residuals, energy, and the flat punch on its contact.

use super::summation::{Near, Receiver, Summation};
use crate::discrete::{Discrete, DiscreteSolution};
use crate::gap::Gap;
use crate::grid::{Kernel, Pressure};
use crate::patch;
use crate::problem::EffectiveModulus;
use crate::solution::{Patch, Residuals};

/// Pressed cells up to which flat punches are solved for: about two seconds each at this limit.
const MOST_PRESSED: usize = 20_000;

/// Steps of conjugate gradients; the condition of a contact of 20 000 cells takes about a hundred.
const MOST_STEPS: usize = 400;

/// Relative residual of a flat punch.
const PUNCH: f64 = 1e-7;

/// A pressure field (E* = 1) in the cells of its grid, one kernel assumed.
pub(super) struct Cells<'a> {
    field: &'a Pressure,
    kernel: Kernel,
    q: Vec<f64>,
    problem: Discrete,
    /// In the cells that overlap or are pressed and in their neighbours; 0 elsewhere.
    displacement: Vec<f64>,
    near: Near,
}

impl<'a> Cells<'a> {
    pub fn of(gap: &dyn Gap, modulus: EffectiveModulus, depth: f64, field: &'a Pressure, kernel: Kernel) -> Self {
        let grid = &field.grid;
        let q: Vec<f64> = field.values.iter().map(|p| p / modulus.e_star()).collect();
        let problem = Discrete::sample(gap, depth, *grid, kernel);
        let [nx, ny] = grid.shape;
        let open: Vec<bool> = q.iter().zip(&problem.overlap).map(|(q, f)| *q > 0.0 || *f > 0.0).collect();
        let around = |n: usize, end: usize| n.saturating_sub(1)..(n + 2).min(end);
        let wanted: Vec<bool> =
            (0..grid.len()).map(|k| around(k / nx, ny).any(|j| around(k % nx, nx).any(|i| open[j * nx + i]))).collect();
        let receiver = match kernel {
            Kernel::Galerkin => Receiver::Mean,
            Kernel::Collocation => Receiver::Point([0.5; 2]),
        };
        let summation = Summation::new(grid, &q);
        let near = summation.near(receiver);
        let displacement = summation.in_cells_with(&near, &wanted);
        Self { field, kernel, q, problem, displacement, near }
    }

    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The largest overlap of a cell.
    pub fn deepest(&self) -> f64 {
        self.problem.deepest()
    }

    /// Residuals as the solvers state them.
    pub fn residuals(&self) -> Residuals {
        self.problem.residuals(&self.q, &self.displacement)
    }

    /// Largest |f - u| under pressure and f - u elsewhere, over the largest overlap; NaN where a number is lost.
    pub fn worst(&self) -> f64 {
        let each = self.q.iter().zip(&self.problem.overlap).zip(&self.displacement);
        let worst = each.fold(0.0, |worst: f64, ((q, f), u)| {
            let off = if *q > 0.0 { (f - u).abs() } else { f - u };
            if off > worst || off.is_nan() { off } else { worst }
        });
        worst / self.deepest()
    }

    /// Integral of p f - p u/2, E* = 1: never more than the stored energy of the contact where f and u are means.
    pub fn energy(&self) -> f64 {
        let each = self.q.iter().zip(&self.problem.overlap).zip(&self.displacement);
        let sum: f64 = each.filter(|((q, _), _)| **q > 0.0).map(|((q, f), u)| q * (f - 0.5 * u)).sum();
        sum * self.field.grid.cell_area()
    }

    /// Mean of f - u over the contact, weighted with the pressure: times the stiffness, it is what the force lacks of that which
    /// these conditions ask for, to first order.
    pub fn shortfall(&self) -> f64 {
        let each = self.q.iter().zip(&self.problem.overlap).zip(&self.displacement);
        let sum: f64 = each.filter(|((q, _), _)| **q > 0.0).map(|((q, f), u)| q * (f - u)).sum();
        sum / self.q.iter().sum::<f64>()
    }

    /// The gap that is left in each cell; infinite where there is no material.
    pub fn gap_left(&self) -> Vec<f64> {
        let everywhere = vec![true; self.q.len()];
        let u = Summation::new(&self.field.grid, &self.q).in_cells_with(&self.near, &everywhere);
        let each = self.q.iter().zip(&self.problem.overlap).zip(&u);
        each.map(|((q, f), u)| if *q > 0.0 { 0.0 } else { u - f }).collect()
    }

    /// The patch by the same rule that places boundaries between cells.
    pub fn patch(&self, reference: [f64; 2]) -> Patch {
        let solution = DiscreteSolution {
            pressure: self.q.clone(),
            displacement: self.displacement.clone(),
            residuals: Residuals { complementarity: 0.0, tension: 0.0, penetration: 0.0 },
            unknowns: 0,
            iterations: 0,
            operator_products: 0,
            single_precision: 0,
        };
        patch::of(&self.problem, &solution, reference)
    }

    /// The pressure (E* = 1) on the cells in contact that displaces them by `rate` of their centres: conjugate gradients on products
    /// by direct summation. `None` when there are too many cells or it does not converge.
    pub fn growth(&self, rate: impl Fn([f64; 2]) -> f64) -> Option<Vec<f64>> {
        let grid = &self.field.grid;
        let pressed: Vec<bool> = self.q.iter().map(|q| *q > 0.0).collect();
        if pressed.iter().filter(|p| **p).count() > MOST_PRESSED {
            return None;
        }
        let masked = |k: usize, value: f64| if pressed[k] { value } else { 0.0 };
        let mut r: Vec<f64> = (0..grid.len()).map(|k| masked(k, rate(grid.centre_of(k)))).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (mut m, mut d) = (vec![0.0; r.len()], r.clone());
        let mut rr = dot(&r, &r);
        let goal = PUNCH * PUNCH * rr;
        for _ in 0..MOST_STEPS {
            if rr <= goal {
                return Some(m);
            }
            let mut ad = Summation::new(grid, &d).in_cells_with(&self.near, &pressed);
            ad.iter_mut().enumerate().for_each(|(k, value)| *value = masked(k, *value));
            let alpha = rr / dot(&d, &ad);
            if !alpha.is_finite() {
                return None;
            }
            m.iter_mut().zip(&d).for_each(|(m, d)| *m += alpha * d);
            r.iter_mut().zip(&ad).for_each(|(r, ad)| *r -= alpha * ad);
            let now = dot(&r, &r);
            d.iter_mut().zip(&r).for_each(|(d, r)| *d = r + now / rr * *d);
            rr = now;
        }
        None
    }
}
