//! The stiffness of contacts that lie far apart: flat punches on all patches at once, in sweeps from one to the next.

use super::contact_loads::ContactLoads;
use super::separate::SWEEPS;
use super::single_grid::{self, OF_GROWTH};
use super::subcontact::{Solved, Subcontact};
use crate::problem::Contact;
use crate::solution::Unsolved;

/// Residual of a last, small change of the pressures that grow, in that change.
const OF_LAST_GROWTH: f64 = 1e-3;

/// A contact whose pressure grows when all are moved.
struct Growing<'a> {
    one: &'a Subcontact,
    solved: &'a Solved,
    /// The rate at which its overlap grows, cell by cell, and the pressure that grows with it.
    rates: Vec<f64>,
    pressure: Vec<f64>,
    loads: ContactLoads,
}

impl<'a> Growing<'a> {
    fn at_rest(one: &'a Subcontact) -> Option<Self> {
        let solved = one.solved.as_ref()?;
        let none = vec![0.0; solved.refined.state.problem.grid.len()];
        Some(Self { one, solved, rates: none.clone(), pressure: none, loads: ContactLoads::default() })
    }

    /// Goes on with what has changed of the rates; by how much that changes the force.
    fn grow(&mut self, rates: Vec<f64>) -> Result<f64, Unsolved> {
        let state = &self.solved.refined.state;
        let change: Vec<f64> = rates.iter().zip(&self.rates).map(|(now, before)| now - before).collect();
        let pressed = |rates: &[f64]| {
            let under = rates.iter().zip(&state.solution.pressure).filter(|(_, p)| **p > 0.0);
            under.fold(0.0, |most: f64, (rate, _)| most.max(rate.abs()))
        };
        let tolerance = (OF_GROWTH * pressed(&rates) / pressed(&change)).clamp(OF_GROWTH, OF_LAST_GROWTH);
        let more = single_grid::growth_within(tolerance, state, &change)?;
        self.pressure.iter_mut().zip(&more).for_each(|(sum, more)| *sum += more);
        self.rates = rates;
        let before = self.loads.total();
        self.loads = self.solved.loads(|k| self.pressure[k]);
        Ok((self.loads.total() - before).abs())
    }
}

/// Stiffness against depth, and against tilts if asked for: flat punches on all patches at once, by the same sweeps.
pub(super) fn growth(
    contact: &Contact,
    ones: &[Option<Subcontact>],
    with_matrix: bool,
) -> Result<[[f64; 3]; 3], Unsolved> {
    let of_place: [fn([f64; 2]) -> f64; 3] = [|_| 1.0, |[x, _]| x, |[_, y]| y];
    let mut matrix = [[0.0; 3]; 3];
    let columns = if with_matrix { 3 } else { 1 };
    for (column, rate) in of_place.iter().enumerate().take(columns) {
        let mut growing: Vec<Growing> = ones.iter().flatten().filter_map(Growing::at_rest).collect();
        for _ in 0..SWEEPS {
            let (mut change, mut size) = (0.0, 0.0);
            for k in 0..growing.len() {
                let others = growing.iter().enumerate().filter(|(n, _)| *n != k).map(|(_, other)| &other.loads);
                let Growing { one, solved, .. } = &growing[k];
                let units = &solved.scaled.units;
                let displaced = one.displacements(solved, others);
                let places = solved.refined.state.problem.grid.centres().map(|p| rate(units.outward(p)));
                let rates = places.zip(displaced).map(|(rate, by)| (rate - by) / units.height).collect();
                change += growing[k].grow(rates)?;
                size += growing[k].loads.iter().map(|load| load.1.abs()).sum::<f64>();
            }
            if change <= OF_GROWTH * size {
                break;
            }
        }
        let e_star = contact.modulus().e_star();
        for (row, weight) in of_place.iter().enumerate() {
            let loads = growing.iter().flat_map(|one| one.loads.iter());
            matrix[row][column] = loads.map(|(p, q)| q * weight(*p)).sum::<f64>() * e_star;
        }
    }
    let mean = |i: usize, j: usize| if with_matrix { 0.5 * (matrix[i][j] + matrix[j][i]) } else { matrix[i][j] };
    Ok([0, 1, 2].map(|i| [0, 1, 2].map(|j| mean(i, j))))
}
