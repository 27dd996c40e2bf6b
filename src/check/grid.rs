//! States on a grid: the contact conditions in its cells, and the force, energy and stiffness that follow from the field.

use super::cells::Cells;
use super::result::{Bounds, Key, State, key, on_grid};
use super::scaled::ScaledField;
use super::state::ROUNDING;
use super::{CLOSER, Shared, Verification, close, homogeneous};
use crate::error::InputError;
use crate::gap::AnyGap;
use crate::grid::{Grid, Kernel};
use crate::problem::Load;
use crate::scene::Scene;
use crate::solution::Residuals;

/// Largest residual of a pressure that is said to solve a grid, relative to the largest overlap.
const RESIDUAL: f64 = 2e-6;

/// The checker's own error of a displacement, relative to the largest overlap.
const OWN_ERROR: f64 = 1e-6;

/// Relative error of an energy and of a flat punch from such displacements.
const OF_SUMS: f64 = 1e-6;

impl State<'_> {
    pub(super) fn on_grid(
        &self,
        scene: &Scene,
        gap: &AnyGap,
        load: Load,
        shared: &Shared,
        found: &mut Verification,
    ) -> Result<(), InputError> {
        found.require(
            self.method == "fft" || self.method == "qp",
            format!("the origin {} is that of the method {}", self.origin, self.method),
        );
        let Some(field) = &self.field else {
            found.require(
                false,
                "there is a pressure field to check; none is in the result: solve with \"pressure\" in \"output\"",
            );
            return Ok(());
        };
        self.grid_is_that_of(field.grid, found);
        if !found.accepted() {
            return Ok(());
        }
        let modulus = scene.contact.modulus();
        let degree = homogeneous::degree(gap, &field.grid).filter(|_| self.tilt == [0.0; 2] && self.depth > 0.0);
        // One field shows no limit but that of a gap whose force follows from its energy; at a sharp edge it shows little of that.
        let of_limit = self.origin == "many_grids" && !degree.is_some_and(f64::is_finite);
        if of_limit && matches!(load, Load::ForceMoment { .. }) {
            // Depth and tilts are of the limit as well: those of the field are not known.
            self.applied_again(scene, gap, load, shared, found);
            return Ok(());
        }
        let by = |kernel: Kernel| Cells::of(gap, modulus, self.depth, field, kernel);
        let means = by(Kernel::Galerkin);
        let of_means = means.worst();
        let centres = (of_means > RESIDUAL || degree.is_none()).then(|| by(Kernel::Collocation));
        let (cells, other, worst) = match &centres {
            None => (&means, None, of_means),
            Some(centres) => match centres.worst() {
                of_centres if !(of_means <= of_centres) => (centres, Some(&means), of_centres),
                _ => (&means, Some(centres), of_means),
            },
        };
        let what = if cells.kernel() == Kernel::Galerkin { "means over cells" } else { "centres of cells" };
        found.require(
            worst <= RESIDUAL,
            format!(
                "contact conditions in {what}: largest residual {:.1e} of the overlap, {RESIDUAL:.0e} allowed",
                worst
            ),
        );
        if !found.accepted() {
            return Ok(());
        }
        if of_limit {
            self.applied_again(scene, gap, load, shared, found);
            return self.gap_left(cells, found);
        }
        self.use_up(key!(pressure.field));
        self.use_up(key!(depth));
        if !matches!(load, Load::Depth(_) | Load::Tilted { .. }) {
            self.use_up(key!(tilt));
        }
        self.residuals(&cells.residuals(), &format!("by direct summation, good to {RESIDUAL:.0e}"), found);
        let force_driven = !matches!(load, Load::Depth(_) | Load::Tilted { .. });
        self.force_of_grid(scene, degree, [cells, &means], other, force_driven, found);
        self.pressures(gap, field, found);
        self.moments(field, force_driven, found);
        self.moments_bracketed(scene, gap, field, found);
        self.patch_of(cells, scene, found);
        self.stiffness_of(cells, scene, gap, degree, found);
        self.gap_left(cells, found)
    }

    /// The grid that is named is that of the field.
    pub(super) fn grid_is_that_of(&self, grid: Grid, found: &mut Verification) {
        let Some(said) = self.get(key!(grid)) else { return };
        let holds = said.shape == grid.shape && (0..2).all(|m| close(said.spacing[m], grid.spacing[m], ROUNDING));
        found.require(holds, "the finest grid is that of the field");
        self.use_up(key!(grid));
    }

    /// The residuals that are stated are these, found in this way.
    pub(super) fn residuals(&self, own: &Residuals, how: &str, found: &mut Verification) {
        let numbers: [(Key<f64>, f64); 3] = [
            (key!(checks.complementarity), own.complementarity),
            (key!(checks.tension), own.tension),
            (key!(checks.penetration), own.penetration),
        ];
        for (key, own) in numbers {
            if let Some(said) = self.get(key) {
                let holds = said >= 0.0 && (said - own).abs() <= RESIDUAL;
                found.require(holds, format!("{} {said:.1e}: {own:.1e} {how}", key.path));
                self.use_up(key);
            }
        }
    }

    /// Force, energy, and the error that is stated.
    fn force_of_grid(
        &self,
        scene: &Scene,
        degree: Option<f64>,
        [cells, means]: [&Cells; 2],
        other: Option<&Cells>,
        force_driven: bool,
        found: &mut Verification,
    ) {
        let Some(field) = &self.field else { return };
        let (carried, e_star) = (field.force(), scene.contact.modulus().e_star());
        let error = self.error().unwrap_or(0.0);
        // P d = (2 + 1/k) U of a homogeneous gap, and U at least that of the field.
        let by_energy = degree.map(|k| (2.0 + 1.0 / k) * means.energy() * e_star / self.depth);
        match (self.origin.as_str(), by_energy) {
            // A force that was prescribed is met as closely as it is known at this depth.
            ("one_grid", _) => {
                let room = if force_driven { error.max(1e-6) } else { ROUNDING };
                // A force whose error is that of its bracket lies in it, and it is worked out again.
                let within = |b: &Bounds| b.is_of_energy() && (b.lower..=b.upper).contains(&self.force);
                let bounded = self.said.evidence.one().is_some_and(|word| word == "proved" || word == "sampled")
                    && self.bracket.as_ref().is_some_and(within);
                found.require(
                    close(self.force, carried, room) || bounded,
                    format!("the force {:e} is the sum of the field, {carried:e}, or lies in the bracket that its energy proves", self.force),
                );
            }
            (_, Some(least)) => {
                let most = least * (1.0 + CLOSER * error + OF_SUMS);
                found.require(
                    self.force >= least * (1.0 - OF_SUMS) && self.force <= most,
                    format!(
                        "the force {:e} is at least {least:e}, which the energy of the field proves, and above it by no more than \
                         {CLOSER} times the stated error",
                        self.force
                    ),
                );
                let grids = self.get(key!(origin.grids)).unwrap_or(0);
                found.require(grids >= 2, format!("{grids} grids are several"));
            }
            _ => return found.require(false, "the force is that of one grid, or the limit of several"),
        }
        self.use_up(key!(force));
        self.energy_of(cells, e_star, carried, degree, found);
        // How far off one grid is, by the field itself.
        let stiffness = self.get(key!(stiffness)).unwrap_or(0.0);
        let off = match by_energy {
            Some(least) => (self.force - least).abs(),
            None => (stiffness * other.map_or(f64::NAN, Cells::shortfall)).abs(),
        };
        let lacking = by_energy.is_none_or(|least| self.force * (1.0 + error) >= least * (1.0 - OF_SUMS));
        if let Some(error) = self.error() {
            found.require(
                lacking && error * self.force * CLOSER >= off - OF_SUMS * self.force && error > 0.0,
                format!(
                    "the stated error {error:.1e} is no less than a tenth of what the field shows, {:.1e}, and leaves room for \
                     the force that its energy proves",
                    off / self.force
                ),
            );
            self.use_up(key!(force_error));
            self.use_up(key!(depth_error));
            if degree.is_some() {
                self.errors_follow(0.0, found);
            }
        } else {
            found.require(false, "an error of the force is stated");
        }
    }

    /// The energy is that of the field, or follows from the force by the law of a homogeneous gap.
    fn energy_of(&self, cells: &Cells, e_star: f64, carried: f64, degree: Option<f64>, found: &mut Verification) {
        let Some(said) = self.get(key!(energy)) else { return };
        let own = cells.energy() * e_star;
        // A last linear step of the depth adds its work.
        let step = 2.0 * (self.force / carried - 1.0).abs();
        let of_field = close(said, own, OF_SUMS + step);
        let by_law = degree.is_some_and(|k| close(said, self.force * self.depth / (2.0 + 1.0 / k), ROUNDING));
        found.require(
            of_field || by_law,
            format!("the energy {said:e} is that of the field, {own:e}, or follows from the force"),
        );
        self.use_up(key!(energy));
    }

    /// dP/dd by the law of a homogeneous gap, else by a flat punch on the pressed cells, alone or for what the force leaves to it.
    fn stiffness_of(&self, cells: &Cells, scene: &Scene, gap: &AnyGap, degree: Option<f64>, found: &mut Verification) {
        let (Some(field), Some(said)) = (&self.field, self.get(key!(stiffness))) else { return };
        let by_law = degree.map(|k| (1.0 + 1.0 / k) * self.force / self.depth);
        let rows = self.get(key!(stiffness_matrix));
        if rows.is_none() && by_law.is_some_and(|law| close(said, law, ROUNDING)) {
            found.require(true, format!("the stiffness {said:e} follows from the force: the gap is homogeneous"));
            self.use_up(key!(stiffness));
            return;
        }
        let e_star = scene.contact.modulus().e_star();
        let area = field.grid.cell_area();
        let rates: [fn([f64; 2]) -> f64; 3] = [|_| 1.0, |[x, _]| x, |[_, y]| y];
        let (mut own, mut by_force) = ([[0.0; 3]; 3], None);
        for (column, rate) in rates.iter().enumerate().take(if rows.is_some() { 3 } else { 1 }) {
            // Too many cells: named as not checked.
            let Some(growing) = cells.growth(rate) else { return };
            if column == 0 {
                let scaled = ScaledField::of(gap, scene.contact.modulus(), self.depth, field);
                by_force = scaled.and_then(|scaled| scaled.stiffness(&growing, self.force));
            }
            for (row, weight) in rates.iter().enumerate() {
                let moment: f64 = field.grid.centres().zip(&growing).map(|(at, m)| m * weight(at)).sum();
                own[row][column] = moment * area * e_star;
            }
        }
        let punch = own[0][0];
        found.require(
            close(said, punch, OF_SUMS)
                || by_law.is_some_and(|law| close(said, law, ROUNDING))
                || by_force.is_some_and(|own| close(said, own, OF_SUMS)),
            format!(
                "the stiffness {said:e} is that of a flat punch on the pressed cells, {punch:e}, or follows from the force, {:e}",
                by_law.or(by_force).unwrap_or(f64::NAN)
            ),
        );
        self.use_up(key!(stiffness));
        if let Some(rows) = rows {
            // In units of the contact.
            let far = field.grid.loaded(&field.values).map(|([x, y], _)| x.hypot(y)).fold(0.0, f64::max);
            let size = |i: usize, j: usize| punch * far.powi(i32::from(i > 0) + i32::from(j > 0));
            let near =
                (0..9).map(|n| (n / 3, n % 3)).all(|(i, j)| (rows[i][j] - own[i][j]).abs() <= OF_SUMS * size(i, j));
            found.require(near, "the stiffness matrix is that of flat punches on the pressed cells");
            self.use_up(key!(stiffness_matrix));
        }
    }

    /// The gap after loading is what the displacement leaves of it.
    fn gap_left(&self, cells: &Cells, found: &mut Verification) -> Result<(), InputError> {
        let said = self.get(key!(gap.field)).map(|said| on_grid(&said, "gap.field")).transpose()?;
        let (Some(said), Some(field)) = (said, &self.field) else { return Ok(()) };
        let allowed = (RESIDUAL + OWN_ERROR) * cells.deepest();
        let each = |(gap, own): (&f64, &f64)| gap == own || (gap - own).abs() <= allowed + OWN_ERROR * own.abs();
        let holds = said.grid == field.grid && said.values.iter().zip(&cells.gap_left()).all(each);
        found.require(holds, "the gap after loading is what the displacement by the field leaves");
        self.use_up(key!(gap.field));
        Ok(())
    }
}
