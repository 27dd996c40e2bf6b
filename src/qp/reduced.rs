//! The dense compliance matrix of the candidate cells, one unknown for each group of cells that a symmetry joins.

use faer::Mat;

use crate::discrete::Discrete;
use crate::discrete::symmetry::Orbits;
use crate::influence::InfluenceTable;

/// S y = r in place of A p = f. With m cells in a group, y = sqrt(m) p, r = sqrt(m) f and
/// S = (sum of A over both groups)/sqrt(m m'), which is symmetric. Scaled so that |f| <= 1 and a cell alone has S = 1.
pub(super) struct Reduced {
    pub matrix: Mat<f64>,
    pub overlap: Vec<f64>,
    /// sqrt(m) of each group.
    pub weight: Vec<f64>,
    orbits: Orbits,
    table: InfluenceTable,
    /// Unit of pressure.
    unit: f64,
}

impl Reduced {
    pub fn assemble(problem: &Discrete, orbits: Orbits) -> Self {
        let grid = &problem.grid;
        let table = InfluenceTable::new(problem.kernel, grid.spacing, grid.shape);
        let own = table.get(0, 0);
        let nx = grid.shape[0];
        let n = orbits.members.len();
        let position: Vec<Vec<(usize, usize)>> =
            orbits.members.iter().map(|m| m.iter().map(|&c| (c % nx, c / nx)).collect()).collect();
        let mut matrix = Mat::zeros(n, n);
        for column in 0..n {
            let from = position[column][0];
            for row in column..n {
                // Every cell of one group sees the other group alike: one of them stands for all.
                let sum: f64 =
                    position[row].iter().map(|&(i, j)| table.get(i.abs_diff(from.0), j.abs_diff(from.1))).sum();
                let share = position[column].len() as f64 / position[row].len() as f64;
                let value = sum * share.sqrt() / own;
                matrix[(row, column)] = value;
                matrix[(column, row)] = value;
            }
        }
        let finite = problem.overlap.iter().filter(|f| f.is_finite());
        let deepest = finite.fold(0.0, |a: f64, f| a.max(f.abs()));
        let weight: Vec<f64> = orbits.members.iter().map(|m| (m.len() as f64).sqrt()).collect();
        let overlap = orbits.members.iter().zip(&weight).map(|(m, w)| w * problem.overlap[m[0]] / deepest).collect();
        Self { matrix, overlap, weight, orbits, table, unit: deepest / own }
    }

    pub fn len(&self) -> usize {
        self.weight.len()
    }

    /// Pressure on every cell of the grid.
    pub fn pressure_of(&self, problem: &Discrete, y: &[f64]) -> Vec<f64> {
        let mut pressure = vec![0.0; problem.grid.len()];
        for ((members, w), y) in self.orbits.members.iter().zip(&self.weight).zip(y) {
            for &cell in members {
                pressure[cell] = self.unit * y / w;
            }
        }
        pressure
    }

    /// Pressure and displacement on every cell of the grid. Only cells with f > 0 or pressure get their displacement
    /// from here when the grid is large: the others are not needed for any residual.
    pub fn spread(&self, problem: &Discrete, y: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let grid = &problem.grid;
        let nx = grid.shape[0];
        let pressure = self.pressure_of(problem, y);
        let loaded: Vec<(usize, usize, f64)> =
            (0..grid.len()).filter(|&k| pressure[k] != 0.0).map(|k| (k % nx, k / nx, pressure[k])).collect();
        let displacement = (0..grid.len())
            .map(|k| {
                let (i, j) = (k % nx, k / nx);
                loaded.iter().map(|&(a, b, p)| p * self.table.get(i.abs_diff(a), j.abs_diff(b))).sum()
            })
            .collect();
        (pressure, displacement)
    }
}
