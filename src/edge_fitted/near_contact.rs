//! Rows of cells near where another mesh found the contact: those far from there are free, and need no unknowns.

use super::rows::between;

/// Cells on either side of what is found in contact that may be, too.
pub(super) const BESIDE: f64 = 1.0;

/// Where the contact of one mesh lies.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// Rows from the first to the last that is in contact: y of their ends with those of the rows beside them, and the shares of the
    /// overlap across between which they touch.
    pub rows: Vec<([f64; 2], [f64; 2])>,
    /// A cell across, as a share of the overlap.
    pub cell: f64,
}

impl Found {
    /// Whether a cell between these y and these shares across may touch: what is found on cells of one size is off by one of either size.
    fn reaches(&self, [bottom, top]: [f64; 2], [left, right]: [f64; 2]) -> bool {
        let (row, cell) = (top - bottom, BESIDE * self.cell.max(right - left));
        let beside = |([low, high], [a, b]): &([f64; 2], [f64; 2])| {
            top + row > *low && bottom - row < *high && right > a - cell && left < b + cell
        };
        self.rows.iter().any(beside)
    }
}

/// Cells that are laid, of rows between lines, so many equal ones in each.
pub(super) struct Laid {
    rows: usize,
    cells: usize,
    /// Row, and cell in it.
    pub all: Vec<[usize; 2]>,
}

impl Laid {
    /// Those not far from where the contact was found, between two shares of the overlap across; all where it was not looked for.
    pub fn new(lines: &[f64], cells: usize, across: [f64; 2], found: Option<&Found>) -> Self {
        let rows = lines.len() - 1;
        let share = |j: usize| between(across, j as f64 / cells as f64);
        let is_near = |[k, j]: [usize; 2]| {
            found.is_none_or(|found| found.reaches([lines[k], lines[k + 1]], [share(j), share(j + 1)]))
        };
        // As symmetric as the strip may be.
        let images = |[k, j]: [usize; 2]| {
            let (m, n) = (rows - 1 - k, cells - 1 - j);
            [[k, j], [m, j], [k, n], [m, n]]
        };
        let all = (0..rows).flat_map(|k| (0..cells).map(move |j| [k, j]));
        let all = all.filter(|&cell| images(cell).into_iter().any(is_near)).collect();
        Self { rows, cells, all }
    }

    /// The pressures of all cells, row by row; zero on those that are not laid.
    pub fn pressures(&self, own: &[f64]) -> Vec<f64> {
        let mut pressures = vec![0.0; self.rows * self.cells];
        self.all.iter().zip(own).for_each(|([k, j], p)| pressures[k * self.cells + j] = *p);
        pressures
    }

    /// Whether a cell under pressure has no neighbour where its row, or the row beside, goes on.
    pub fn is_cut(&self, own: &[f64]) -> bool {
        let mut is_laid = vec![false; self.rows * self.cells];
        self.all.iter().for_each(|[k, j]| is_laid[k * self.cells + j] = true);
        let missing = |k: usize, j: usize| !is_laid[k * self.cells + j];
        self.all.iter().zip(own).any(|(&[k, j], p)| {
            let rows = (k > 0 && missing(k - 1, j)) || (k + 1 < self.rows && missing(k + 1, j));
            *p > 0.0 && (rows || (j > 0 && missing(k, j - 1)) || (j + 1 < self.cells && missing(k, j + 1)))
        })
    }
}
