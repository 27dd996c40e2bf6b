//! Contacts on cells that are fitted to them: what one mesh finds, and what several tell of its errors.

use nalgebra::Matrix3;

use super::Limits;
use super::active_set::{Planes, factor, solve, solve_on};
use super::discrete::Discretisation;
use super::mesh::{Bilinear, Mesh, Point};
use super::symmetry::Isometry;

/// A contact whose errors are estimates, E* = 1.
#[derive(Debug, Clone)]
pub(crate) struct Estimated {
    /// The force, and an estimate of its relative error.
    pub force: f64,
    pub error: f64,
    /// The stored energy.
    pub energy: f64,
    /// dP/dd, and an estimate of its relative error.
    pub stiffness: f64,
    pub stiffness_error: f64,
    /// Against depth and tilts, where that was asked for.
    pub stiffness_matrix: Option<StiffnessMatrix>,
    /// Area, and an estimate of its relative error.
    pub area: f64,
    pub area_error: f64,
    /// An estimate of the relative error of the largest pressure, where that is finite.
    pub max_error: Option<f64>,
    /// Corners and pressure of the cells in contact.
    pub cells: Vec<([Point; 4], f64)>,
    /// Where the contact ends: closed lines, contact on the left.
    pub ends: Vec<Vec<Point>>,
    /// Unknowns of the last mesh.
    pub unknowns: usize,
}

impl Estimated {
    /// In other axes.
    pub fn in_axes(mut self, outward: impl Fn(Point) -> Point) -> Self {
        self.cells.iter_mut().for_each(|(corners, _)| *corners = corners.map(&outward));
        self.ends.iter_mut().flatten().for_each(|p| *p = outward(*p));
        self.stiffness_matrix = self.stiffness_matrix.map(|matrix| matrix.in_axes(&outward));
        self
    }

    /// With the stiffness against tilts, of the mesh that it was found on, where that is asked for and can be had.
    pub(super) fn with_tilts(self, solved: &Solved, touching: Touching, limits: &Limits) -> Option<Self> {
        if !limits.tilts {
            return Some(self);
        }
        Some(Self { stiffness_matrix: Some(solved.stiffness_matrix(touching, limits)?), ..self })
    }

    /// Where the resultant of the pressure acts.
    pub fn centre(&self) -> Point {
        centre_of(&self.cells)
    }
}

/// Where the resultant of the pressure in cells acts.
pub(super) fn centre_of(cells: &[([Point; 4], f64)]) -> Point {
    let sums = cells.iter().fold([0.0; 3], |sums, (corners, p)| {
        let own = Bilinear::new(*corners).moments();
        [0, 1, 2].map(|k| sums[k] + p * own[k])
    });
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// K_ij of a contact of stiffness E* K: the integral of (1, x, y)_i over the pressure that displaces it by (1, x, y)_j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StiffnessMatrix(Matrix3<f64>);

impl StiffnessMatrix {
    /// In other axes, (1, x, y) of which are linear in the old ones, and in their unit of length.
    pub fn in_axes(&self, outward: impl Fn(Point) -> Point) -> Self {
        let [o, u, v] = [[0.0; 2], [1.0, 0.0], [0.0, 1.0]].map(outward);
        let basis = Matrix3::new(1.0, 0.0, 0.0, o[0], u[0] - o[0], v[0] - o[0], o[1], u[1] - o[1], v[1] - o[1]);
        Self(basis * self.0 * basis.transpose())
    }

    /// Its rows, times a unit.
    pub fn rows(&self, unit: f64) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| unit * self.0[(i, j)]))
    }
}

/// Orders of what constant pressures on graded cells leave of energy and force: n^-3, the square of h^(3/2) in the norm of H^(-1/2); and
/// n^-2, as where the pressure is less smooth inside than the grading takes it for.
const ORDERS: [f64; 2] = [3.0, 2.0];

/// What a mesh leaves of a value, relative to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rest {
    /// What is added to the value (Richardson 1911).
    pub correction: f64,
    /// An estimate of what that may be off by: both orders are within it.
    pub error: f64,
}

impl Rest {
    /// From the value on the mesh and on one with `ratio` times fewer cells in some direction.
    pub fn new(value: f64, with_fewer: f64, ratio: f64) -> Self {
        let change = 1.0 - with_fewer / value;
        let [correction, slower] = ORDERS.map(|order| change / (ratio.powf(order) - 1.0));
        Self { correction, error: (slower - correction).abs() }
    }
}

/// Unknowns of a stiffness against tilts over those that a contact with its symmetries may have.
const WITHOUT_SYMMETRY: usize = 2;

/// A mesh with its pressure, E* = 1.
pub(super) struct Solved {
    pub force: f64,
    pub energy: f64,
    pub stiffness: f64,
    pub area: f64,
    pub mesh: Mesh,
    /// Of all loaded cells.
    pub pressure: Vec<f64>,
    pub unknowns: usize,
}

impl Solved {
    /// The largest pressure.
    pub fn largest(&self) -> f64 {
        self.pressure.iter().copied().fold(0.0, f64::max)
    }
}

/// Which cells are in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Touching {
    /// All: pressures may be negative where they should not be.
    All,
    /// Those on which the pressure is positive.
    Some,
}

impl Solved {
    /// The pressure under an overlap; `group`: symmetries of both. `None` with more unknowns than allowed, and once the time is used up.
    pub fn new(
        mesh: Mesh,
        group: &[Isometry],
        overlap: &dyn Fn(Point) -> f64,
        touching: Touching,
        limits: &Limits,
    ) -> Option<Self> {
        let Discretisation { mesh, orbits, compliance, areas, .. } =
            Discretisation::within(mesh, group, limits.unknowns, limits.means())?;
        let integral = |cell: Bilinear| cell.gauss().map(|(p, w)| w * overlap(p)).sum::<f64>();
        let rhs: Vec<f64> = (0..orbits.loaded)
            .map(|a| orbits.size[a] as f64 * integral(Bilinear::new(mesh.corners(orbits.representatives[a]))))
            .collect();
        let found = (touching == Touching::Some).then(|| solve(&compliance, &rhs));
        let contact: Vec<bool> =
            found.as_ref().map_or_else(|| vec![true; rhs.len()], |p| p.iter().map(|p| *p > 0.0).collect());
        let factored = factor(&compliance, &contact)?;
        let p = found.unwrap_or_else(|| solve_on(&factored, &contact, &rhs));
        let m = solve_on(&factored, &contact, &areas);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        Some(Self {
            force: dot(&p, &areas),
            energy: 0.5 * dot(&p, &rhs),
            stiffness: dot(&m, &areas),
            area: areas.iter().zip(&contact).filter(|(_, touches)| **touches).map(|(area, _)| area).sum(),
            pressure: orbits.expand(&p, mesh.loaded),
            mesh,
            unknowns: orbits.loaded,
        })
    }

    /// The stiffness against depth and tilts, which do not share the symmetries of the contact. `None` with more unknowns than allowed, and
    /// once the time is used up.
    pub fn stiffness_matrix(&self, touching: Touching, limits: &Limits) -> Option<StiffnessMatrix> {
        let unknowns = WITHOUT_SYMMETRY * limits.unknowns;
        let all = Discretisation::within(self.mesh.clone(), &[], unknowns, limits.means())?;
        let weights = all.mesh.weights();
        let contact: Vec<bool> = self.pressure.iter().map(|p| touching == Touching::All || *p > 0.0).collect();
        Some(StiffnessMatrix(Planes::on(&all.compliance, &weights, &contact)?.stiffness(&weights)))
    }

    /// Corners and pressure of the cells in contact.
    pub fn cells(&self, touching: Touching) -> Vec<([Point; 4], f64)> {
        self.cells_times(1.0, touching)
    }

    /// The same with pressures `times` as large: those of a corrected force.
    pub fn cells_times(&self, times: f64, touching: Touching) -> Vec<([Point; 4], f64)> {
        let loaded = |p: f64| touching == Touching::All || p > 0.0;
        let all = self.pressure.iter().enumerate();
        all.filter(|(_, p)| loaded(**p)).map(|(k, p)| (self.mesh.corners(k), times * p)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stiffness_against_tilts_moves_with_its_axes() {
        let rows: [[usize; 4]; 2] = [[0, 1, 4, 3], [1, 2, 5, 4]];
        let nodes = [[0.0, 0.0], [0.3, 0.1], [1.0, 0.0], [0.0, 1.0], [0.4, 1.2], [1.1, 0.9]];
        let limits = Limits::default();
        let matrix = |outward: &dyn Fn(Point) -> Point| {
            let mesh = Mesh::new(nodes.map(outward).to_vec(), rows.to_vec(), Vec::new());
            let solved = Solved::new(mesh, &[], &|_| 1.0, Touching::All, &limits).unwrap();
            (solved.stiffness_matrix(Touching::All, &limits).unwrap(), solved.stiffness)
        };
        let (own, stiffness) = matrix(&|p| p);
        assert!((own.rows(1.0)[0][0] / stiffness - 1.0).abs() < 1e-12);
        // Turned by a right angle, three times as large and moved.
        let outward = |[x, y]: Point| [2.0 - 3.0 * y, 3.0 * x - 1.0];
        let (there, seen) = (matrix(&outward).0.rows(1.0), own.in_axes(outward).rows(3.0));
        let size = |i: usize, j: usize| (there[i][i] * there[j][j]).sqrt();
        assert!((0..9).all(|k| (there[k / 3][k % 3] - seen[k / 3][k % 3]).abs() < 1e-9 * size(k / 3, k % 3)));
    }

    #[test]
    fn both_orders_are_within_the_error() {
        for order in [2.0, 2.3, 3.0, 4.0] {
            for (n, fewer) in [(5.0, 3.0), (12.0, 8.0), (9.0, 6.0)] {
                let at = |n: f64| 1.0 - 0.3 * f64::powf(n, -order);
                let rest = Rest::new(at(n), at(fewer), n / fewer);
                let off = (1.0 / at(n) - 1.0 - rest.correction).abs();
                assert!(off <= rest.error * (1.0 + 1e-9), "{order} {n}: {off:e} of {:e}", rest.error);
            }
        }
    }
}
