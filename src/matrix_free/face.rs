//! Conjugate gradients on a face of the cone p >= 0, and the walk from face to face.

use super::operator::{Operator, Scratch};
use super::{Settings, exhausted};
use crate::InfluenceTable;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::Unsolved;

/// Fall of the residual on a face before the face is looked at again. Anything from 0.03 to 0.5 costs within a tenth of the best.
const INNER: f64 = 0.1;

/// Steps on one face at the most: a face that is this hard will be clearer after a look at its edges.
const MOST_INNER: usize = 25;

/// Steps of projected gradient after the energy failed to fall.
const SAFE_STEPS: usize = 4;

/// A problem cropped to the box of its candidate cells, with its operators and the current pressure.
pub(super) struct Face<'a> {
    problem: &'a Discrete,
    /// First cell and shape of the box within the grid.
    corner: [usize; 2],
    shape: [usize; 2],
    /// Candidate cells, as indices in the box.
    cells: Vec<usize>,
    /// f in the box, in units of the largest.
    f: Vec<f64>,
    unit: f64,
    compliance: Operator,
    compliance_scratch: Scratch,
    preconditioner: Operator,
    preconditioner_scratch: Scratch,
    /// Upper bound of the operator's norm: the sum of the magnitudes of a row.
    norm: f64,
    p: Vec<f64>,
    u: Vec<f64>,
    pub products: usize,
    pub iterations: usize,
}

impl<'a> Face<'a> {
    /// The candidates are the cells with f > 0; `None` when there is none.
    pub fn new(problem: &'a Discrete) -> Option<Self> {
        Self::with(problem, |f| f > 0.0)
    }

    /// Every cell with a finite f.
    pub fn on_all(problem: &'a Discrete) -> Option<Self> {
        Self::with(problem, f64::is_finite)
    }

    fn with(problem: &'a Discrete, candidate: impl Fn(f64) -> bool) -> Option<Self> {
        let [nx, ny] = problem.grid.shape;
        let (mut low, mut high) = ([nx, ny], [0, 0]);
        for (k, &f) in problem.overlap.iter().enumerate() {
            if candidate(f) {
                let at = [k % nx, k / nx];
                low = [low[0].min(at[0]), low[1].min(at[1])];
                high = [high[0].max(at[0] + 1), high[1].max(at[1] + 1)];
            }
        }
        if low[0] >= high[0] {
            return None;
        }
        let shape = [high[0] - low[0], high[1] - low[1]];
        let size = shape[0] * shape[1];
        let in_grid = |k: usize| (low[1] + k / shape[0]) * nx + low[0] + k % shape[0];
        let cells: Vec<usize> = (0..size).filter(|&k| candidate(problem.overlap[in_grid(k)])).collect();
        let unit = cells.iter().map(|&k| problem.overlap[in_grid(k)].abs()).fold(0.0, f64::max);
        let f = (0..size).map(|k| problem.overlap[in_grid(k)] / unit).collect();
        // Coefficients in units of the longer side of a cell: sizes near 1 whatever the units.
        let spacing = problem.grid.spacing;
        let table = InfluenceTable::new(problem.kernel, spacing, shape);
        let compliance = Operator::compliance(&table, shape);
        let preconditioner = Operator::periodic(shape, |kx, ky, [lx, ly]| wave_number(spacing, [kx, ky], [lx, ly]));
        let row: f64 = (0..size).map(|k| table.get(k % shape[0], k / shape[0])).sum();
        Some(Self {
            problem,
            corner: low,
            shape,
            cells,
            f,
            unit,
            compliance_scratch: compliance.scratch(),
            compliance,
            preconditioner_scratch: preconditioner.scratch(),
            preconditioner,
            norm: 4.0 * row,
            p: vec![0.0; size],
            u: vec![0.0; size],
            products: 0,
            iterations: 0,
        })
    }

    fn in_grid(&self, k: usize) -> usize {
        (self.corner[1] + k / self.shape[0]) * self.problem.grid.shape[0] + self.corner[0] + k % self.shape[0]
    }

    /// Starts from a pressure on the whole grid.
    pub fn start_from(&mut self, pressure: &[f64]) {
        for n in 0..self.cells.len() {
            let k = self.cells[n];
            self.p[k] = pressure[self.in_grid(k)].max(0.0) / self.unit;
        }
    }

    /// Starts from a pressure in proportion to the overlap, as large as lowers the energy most.
    pub fn start_from_overlap(&mut self) {
        for &k in &self.cells {
            self.p[k] = self.f[k];
        }
        self.displace();
        let dot = |a: &[f64], b: &[f64]| self.cells.iter().map(|&k| a[k] * b[k]).sum::<f64>();
        let scale = dot(&self.f, &self.p) / dot(&self.p, &self.u);
        for &k in &self.cells {
            self.p[k] *= scale;
        }
    }

    /// The pressure on the whole grid.
    pub fn pressure(&self) -> Vec<f64> {
        let mut pressure = vec![0.0; self.problem.grid.len()];
        for &k in &self.cells {
            pressure[self.in_grid(k)] = self.p[k] * self.unit;
        }
        pressure
    }

    fn displace(&mut self) {
        self.compliance.apply(&self.p, &mut self.u, &mut self.compliance_scratch);
        self.products += 1;
    }

    /// J = p'A p/2 - f'p at the present displacement.
    fn energy(&self) -> f64 {
        self.cells.iter().map(|&k| self.p[k] * (0.5 * self.u[k] - self.f[k])).sum()
    }

    /// Largest gap error on the contact and penetration outside.
    fn residual(&self) -> f64 {
        let worst = |k: &usize| {
            let r = self.f[*k] - self.u[*k];
            if self.p[*k] > 0.0 { r.abs() } else { r }
        };
        self.cells.iter().map(worst).fold(0.0, f64::max)
    }

    /// From face to face until the residual is small enough.
    pub fn run(&mut self, settings: &Settings) -> Result<(), Unsolved> {
        self.displace();
        let (mut energy, mut kept, mut least) = (self.energy(), self.p.clone(), f64::INFINITY);
        loop {
            let residual = self.residual();
            if residual <= settings.residual {
                return Ok(());
            }
            if self.products >= settings.most_products {
                return Err(exhausted(residual, settings));
            }
            let face: Vec<usize> = self
                .cells
                .iter()
                .copied()
                .filter(|&k| self.p[k] > 0.0 || self.f[k] - self.u[k] > 0.1 * settings.residual)
                .collect();
            self.descend(&face, (INNER * residual).max(0.3 * settings.residual), settings.most_products)?;
            for &k in &face {
                self.p[k] = self.p[k].max(0.0);
            }
            self.displace();
            let reached = self.energy();
            // Close to the end the energy is flat to rounding, and the residual tells the progress.
            let progress = self.residual() < 0.7 * least;
            if reached > energy && !progress {
                self.p.copy_from_slice(&kept);
                self.safe_steps();
                energy = self.energy();
            } else {
                energy = reached;
            }
            least = least.min(self.residual());
            kept.copy_from_slice(&self.p);
        }
    }

    /// A m = f on all candidates, of any sign.
    pub fn linear(&mut self, settings: &Settings) -> Result<(), Unsolved> {
        let face = self.cells.clone();
        for _ in 0..20 {
            self.descend(&face, 0.1 * settings.residual, settings.most_products)?;
            self.displace();
            let worst = face.iter().map(|&k| (self.f[k] - self.u[k]).abs()).fold(0.0, f64::max);
            if worst <= settings.residual {
                return Ok(());
            }
        }
        Err(exhausted(self.residual(), settings))
    }

    /// Projected gradient with the step 1/norm: the energy falls unless the pressure is the solution.
    fn safe_steps(&mut self) {
        for _ in 0..SAFE_STEPS {
            self.displace();
            for &k in &self.cells {
                self.p[k] = (self.p[k] + (self.f[k] - self.u[k]) / self.norm).max(0.0);
            }
        }
        self.displace();
    }

    /// Preconditioned conjugate gradients on the cells of `face`, from the present p and u, until the largest residual there
    /// is below `target`.
    fn descend(&mut self, face: &[usize], target: f64, most_products: usize) -> Result<(), Unsolved> {
        let size = self.p.len();
        let (mut r, mut z, mut direction) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
        let mut image = vec![0.0; size];
        for &k in face {
            r[k] = self.f[k] - self.u[k];
        }
        let mut slope_before = 0.0;
        for step in 0..MOST_INNER {
            self.preconditioner.apply(&r, &mut z, &mut self.preconditioner_scratch);
            let slope: f64 = face.iter().map(|&k| r[k] * z[k]).sum();
            let beta = if step == 0 { 0.0 } else { slope / slope_before };
            slope_before = slope;
            for &k in face {
                direction[k] = z[k] + beta * direction[k];
            }
            self.compliance.apply(&direction, &mut image, &mut self.compliance_scratch);
            self.products += 1;
            self.iterations += 1;
            let curvature: f64 = face.iter().map(|&k| direction[k] * image[k]).sum();
            if !(curvature > 0.0 && slope > 0.0) {
                return Ok(());
            }
            let length = slope / curvature;
            let mut worst = 0.0f64;
            for &k in face {
                self.p[k] += length * direction[k];
                r[k] -= length * image[k];
                worst = worst.max(r[k].abs());
            }
            if worst <= target || self.products >= most_products {
                break;
            }
        }
        Ok(())
    }

    /// The answer on the whole grid, its residuals taken from the pressure itself.
    pub fn finish(self) -> DiscreteSolution {
        let pressure = self.pressure();
        let displacement = displacement(self.problem, &pressure);
        DiscreteSolution {
            residuals: self.problem.residuals(&pressure, &displacement),
            unknowns: self.cells.len(),
            iterations: self.iterations,
            operator_products: self.products,
            pressure,
            displacement,
        }
    }
}

/// |q|/2, the inverse of the symbol of 1/(pi r): lowest mode halved for the zero frequency, which has none.
fn wave_number(spacing: [f64; 2], k: [usize; 2], period: [usize; 2]) -> f64 {
    let q = |n: usize| std::f64::consts::TAU * k[n] as f64 / (period[n] as f64 * spacing[n]);
    let least = std::f64::consts::PI / (period[0] as f64 * spacing[0]).max(period[1] as f64 * spacing[1]);
    q(0).hypot(q(1)).max(least) / 2.0
}

/// A p on the whole grid.
pub(super) fn displacement(problem: &Discrete, pressure: &[f64]) -> Vec<f64> {
    let shape = problem.grid.shape;
    let operator = Operator::compliance(&InfluenceTable::new(problem.kernel, problem.grid.spacing, shape), shape);
    let mut u = vec![0.0; pressure.len()];
    operator.apply(pressure, &mut u, &mut operator.scratch());
    u
}
