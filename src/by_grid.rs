//! A state of contact from the grid, in the user's units.

use crate::Contact;
use crate::discrete::Discrete;
use crate::domain::{self, Door};
use crate::edges::{self, Edge};
use crate::error::Unsolved;
use crate::exact::{self, Refined};
use crate::gap::{AnyGap, Gap, Reach, extent};
use crate::geometry::Rect;
use crate::grid::{Grid, Pressure};
use crate::homogeneity::{self, Degree};
use crate::matrix_free;
use crate::one_grid::{self, GridState};
use crate::outgrown::outgrown;
use crate::patch;
use crate::separate;
use crate::settings::{Method, Settings};
use crate::solution::{Cost, Origin, Patch, PressureSummary, Solution};

/// The state at a depth and tilt (`gap` is the contact's gap under that tilt); `with_matrix`: the stiffness against tilts too.
///
/// # Errors
/// As the solvers: `Unbounded`, `IterationLimit`, `ToleranceNotReached`, `TooLarge`.
pub(crate) fn solution(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let method = if settings.method == Method::Qp { Method::Qp } else { Method::Fft };
    let Some(door) = Door::enter(gap, depth)? else {
        return Ok(Solution::apart(method, depth, tilt));
    };
    let reach = Rect { min: door.gap.outward(door.reach.min), max: door.gap.outward(door.reach.max) };
    if let Some(rectangles) = separate::rectangles(gap, depth, &reach, settings) {
        return separate::solution(contact, gap, depth, tilt, settings, &rectangles, with_matrix);
    }
    let degree = homogeneity::degree(gap, &reach);
    let refined = exact::refined(&door, settings, method, degree)?;
    let mut solution = dimensional(contact, &door, &refined, degree, depth, tilt, settings)?;
    if with_matrix {
        solution = with_stiffness_matrix(contact, &door, &refined, solution)?;
    }
    match refined.shortfall(settings) {
        None => Ok(solution),
        Some(short) => Err(short.with_best(solution)),
    }
}

/// Whether the contact at this depth is solved on several grids, which [`Held`] does not do.
pub(crate) fn on_several_grids(contact: &Contact, depth: f64, settings: &Settings) -> bool {
    match extent(contact.gap(), depth) {
        Reach::Within(reach) => separate::rectangles(contact.gap(), depth, &reach, settings).is_some(),
        _ => false,
    }
}

fn with_stiffness_matrix(
    contact: &Contact,
    door: &Door,
    refined: &Refined,
    solution: Solution,
) -> Result<Solution, Unsolved> {
    let unit = contact.modulus().e_star() * door.gap.length;
    let entries = |state: &GridState| {
        let matrix = one_grid::stiffness_matrix(state, |p| door.gap.outward(p))?;
        Ok(std::array::from_fn::<f64, 9, _>(|n| matrix[n / 3][n % 3] * unit))
    };
    let entries = refined.limits(entries)?;
    Ok(Solution { stiffness_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| entries[3 * i + j]))), ..solution })
}

/// The state of contacts that lie far apart, each on grids of its own, with its stiffness matrix; `None` when one grid serves.
///
/// # Errors
/// As [`solution`].
pub(crate) fn separately(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Option<Solution>, Unsolved> {
    let Reach::Within(reach) = extent(gap, depth) else { return Ok(None) };
    let rectangles = separate::rectangles(gap, depth, &reach, settings);
    let solved = |r: Vec<Rect>| separate::solution(contact, gap, depth, tilt, settings, &r, true);
    rectangles.map(solved).transpose()
}

/// The state at a depth and tilt on one grid that stays where it is from one tilt to the next, with its stiffness
/// matrix: force and moments are then the exact derivatives of one convex energy. `frame` is the box of that grid in the
/// user's units; found when `None`, enlarged when the contact outgrows it.
///
/// # Errors
/// As [`solution`].
pub(crate) fn in_frame(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    cells: usize,
    frame: &mut Frame,
) -> Result<Solution, Unsolved> {
    let method = if settings.method == Method::Qp { Method::Qp } else { Method::Fft };
    let Some(door) = Door::enter(gap, depth)? else {
        return Ok(Solution::apart(method, depth, tilt));
    };
    let inward = |r: &Rect| Rect { min: door.gap.inward(r.min), max: door.gap.inward(r.max) };
    let outward = |r: &Rect| Rect { min: door.gap.outward(r.min), max: door.gap.outward(r.max) };
    let window = match &frame.window {
        Some(rect) => inward(rect),
        None => domain::locate(&door)?.scaled(ROOM),
    };
    // Cells end where the material does.
    let mut window = window.intersection(&door.reach).unwrap_or(window);
    let state = one_grid::at_resolution(&door, &mut window, cells, settings, method)?;
    frame.window = Some(outward(&window));
    frame.sharp = edges::met(&door, &state) == Some(Edge::End);
    let [spacing, lost] = edges::measure(&door, &state);
    frame.measure = [spacing * door.gap.length, lost * door.gap.length * door.gap.length];
    let error = if frame.alone { one_grid::other_kernel(&door, &state)? - state.force() } else { 0.0 };
    let refined = Refined::of(state, error.abs());
    let solution = dimensional(contact, &door, &refined, None, depth, tilt, settings)?;
    with_stiffness_matrix(contact, &door, &refined, solution)
}

/// The grid that all tilts share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// Its box, once it is known.
    pub window: Option<Rect>,
    /// Whether the last contact on it ended at sharp edges.
    pub sharp: bool,
    /// The longer side of its cells, and the area of material that they leave out.
    pub measure: [f64; 2],
    /// Whether a grid has to tell its own error, by the other kernel.
    pub alone: bool,
}

impl Frame {
    /// Not laid yet.
    pub fn new() -> Self {
        Self { window: None, sharp: false, measure: [0.0; 2], alone: true }
    }
}

/// A solved grid with what it takes to go on from it to another depth.
pub(crate) struct Held<'a> {
    door: Door<'a>,
    refined: Refined,
    /// Pressure that grows with the depth on the cells in contact; `None` where the state is the limit of many grids.
    growing: Option<Vec<f64>>,
}

impl<'a> Held<'a> {
    /// The state at a depth of the untilted contact; `None` when the bodies do not touch.
    ///
    /// # Errors
    /// As [`solution`].
    pub fn at_depth(contact: &'a Contact, depth: f64, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let method = if settings.method == Method::Qp { Method::Qp } else { Method::Fft };
        let Some(door) = Door::enter(contact.gap(), depth)? else { return Ok(None) };
        let refined = exact::refined(&door, settings, method, None)?;
        Ok(Some(Self::grown(door, refined)?))
    }

    /// A state good to a few percent: one coarse grid.
    pub fn roughly(contact: &'a Contact, depth: f64, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let Some(door) = Door::enter(contact.gap(), depth)? else { return Ok(None) };
        let window = domain::locate(&door)?;
        let grid = Grid::over(&window, domain::shape(&window, ROUGH_CELLS));
        let problem = Discrete::sample(&door.gap, door.depth, grid, settings.kernel);
        let solution = domain::coarse(&problem)?;
        let state = GridState::of(Method::Fft, problem, solution);
        Ok(Some(Self::grown(door, Refined::of(state, f64::INFINITY))?))
    }

    /// The state at another depth on the same cells, from here; `None` when they do not hold its contact, or when it takes
    /// the limit of many grids.
    ///
    /// # Errors
    /// `IterationLimit`.
    pub fn moved(&self, contact: &'a Contact, depth: f64, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let Some(growing) = &self.growing else { return Ok(None) };
        let Refined { state: before, force, error, .. } = &self.refined;
        let Reach::Within(reach) = extent(contact.gap(), depth) else { return Ok(None) };
        let scaled = self.door.gap;
        let reach = Rect { min: scaled.inward(reach.min), max: scaled.inward(reach.max) };
        // A smaller reach takes no cell away.
        let door = Door { gap: scaled, depth: depth / scaled.depth, reach: reach.union(&self.door.reach) };
        let deeper = door.depth - self.door.depth;
        let problem =
            Discrete { overlap: before.problem.overlap.iter().map(|f| f + deeper).collect(), ..before.problem.clone() };
        // To first order in the change, exactly.
        let start: Vec<f64> = before.solution.pressure.iter().zip(growing).map(|(p, m)| p + deeper * m).collect();
        let Settings { threads, deadline, .. } = *settings;
        let settings = matrix_free::Settings { threads, deadline, ..matrix_free::Settings::default() };
        let solution = matrix_free::solve(&problem, Some(&start), &settings)?;
        if outgrown(&door, &problem.grid.extent(), &problem.grid, &solution.pressure).is_some() {
            return Ok(None);
        }
        let state = GridState {
            iterations: solution.iterations,
            operator_products: solution.operator_products,
            problem,
            solution,
            ..before.clone()
        };
        let error = error / force * state.force();
        Ok(Some(Self::grown(door, Refined::of(state, error))?))
    }

    fn grown(door: Door<'a>, refined: Refined) -> Result<Self, Unsolved> {
        let grow = || one_grid::growth(&refined.state, &vec![1.0; refined.state.problem.grid.len()]);
        let growing = if refined.ladder.is_none() { Some(grow()?) } else { None };
        Ok(Self { door, refined, growing })
    }

    /// In the user's units.
    ///
    /// # Errors
    /// Those of the stiffness, where it is the limit of many grids; `ToleranceNotReached` and `TimeLimit` with the state.
    pub fn solution(&self, contact: &Contact, settings: &Settings) -> Result<Solution, Unsolved> {
        let stiffness = match &self.growing {
            Some(growing) => growing.iter().sum::<f64>() * self.refined.state.problem.grid.cell_area(),
            None => self.refined.limits(|state| Ok([one_grid::stiffness(state)?]))?[0],
        };
        let depth = self.door.depth * self.door.gap.depth;
        let solution = in_users_units(contact, &self.door, &self.refined, stiffness, depth, [0.0; 2], settings);
        match self.refined.shortfall(settings) {
            None => Ok(solution),
            Some(short) => Err(short.with_best(solution)),
        }
    }
}

/// Cells along the longer side of the grid that only has to show the way.
const ROUGH_CELLS: usize = 32;

/// What the box of an upright contact is enlarged by before the punch tilts.
const ROOM: f64 = 1.3;

/// A solved grid in the user's units.
pub(crate) fn dimensional(
    contact: &Contact,
    door: &Door,
    refined: &Refined,
    degree: Option<Degree>,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let stiffness = match degree {
        // P ~ d^(1 + 1/k).
        Some(degree) => (1.0 + degree.inverse()) * refined.force / door.depth,
        None => refined.limits(|state| Ok([one_grid::stiffness(state)?]))?[0],
    };
    Ok(in_users_units(contact, door, refined, stiffness, depth, tilt, settings))
}

fn in_users_units(
    contact: &Contact,
    door: &Door,
    refined: &Refined,
    stiffness: f64,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Solution {
    let Refined { state, force, error, .. } = refined;
    let (length, height, e_star) = (door.gap.length, door.gap.depth, contact.modulus().e_star());
    let unit_force = e_star * height * length;
    let grid = state.problem.grid;
    let values = &state.solution.pressure;
    let reference = door.gap.inward(contact.gap().reference());
    let patch_of = |state: &GridState| patch::of(&state.problem, &state.solution, reference);
    let mut patch = patch_of(state);
    let sums = |state: &GridState, patch: &Patch| {
        let [x, y] = centre_of_load(state, door);
        [state.energy(), x, y, patch.area, patch.max_radius]
    };
    let [energy, x, y, area, max_radius] = match &refined.ladder {
        Some(ladder) => ladder.found(|state| sums(state, &patch_of(state))),
        None => sums(state, &patch),
    };
    (patch.area, patch.max_radius) = (area * length * length, max_radius * length);
    patch.centroid = patch.centroid.map(|c| door.gap.outward(c));
    patch.boundary = if settings.outputs.patch {
        patch
            .boundary
            .map(|loops| loops.into_iter().map(|l| l.into_iter().map(|p| door.gap.outward(p)).collect()).collect())
    } else {
        None
    };
    let strongest = (0..grid.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    let unit_pressure = e_star * height / length;
    let outward_grid =
        Grid { origin: door.gap.outward(grid.origin), spacing: grid.spacing.map(|h| h * length), shape: grid.shape };
    let pressure = PressureSummary {
        max: Some(values[strongest] * unit_pressure),
        mean: (patch.area > 0.0).then(|| force * unit_force / patch.area),
        at: Some(outward_grid.centre_of(strongest)),
        field: settings
            .outputs
            .pressure
            .then(|| Pressure { grid: outward_grid, values: values.iter().map(|p| p * unit_pressure).collect() }),
        gap: settings
            .outputs
            .gap
            .then(|| (outward_grid, one_grid::gap_left(state).into_iter().map(|g| g * height).collect())),
    };
    Solution {
        method: state.method,
        origin: if refined.grids > 1 { Origin::ManyGrids { grids: refined.grids } } else { Origin::OneGrid },
        grid: Some(outward_grid),
        depth,
        tilt,
        force: force * unit_force,
        force_error: Some(error / force),
        bracket: None,
        depth_bracket: None,
        stiffness: stiffness * e_star * length,
        stiffness_matrix: None,
        // Of the best force, where the pressure acts: the force of one grid differs from it.
        moment: Some([force * unit_force * y, -force * unit_force * x]),
        energy: Some(energy * unit_force * height),
        patch,
        pressure,
        residuals: Some(state.solution.residuals),
        cost: Cost {
            seconds: 0.0,
            unknowns: state.solution.unknowns,
            iterations: state.iterations,
            operator_products: state.operator_products,
            steps: 0,
        },
        left_out: state.left_out.clone(),
        remarks: state.remarks.clone(),
    }
}

/// Where the resultant of the pressure acts, in the user's units.
fn centre_of_load(state: &GridState, door: &Door) -> [f64; 2] {
    let grid = &state.problem.grid;
    let pressure = &state.solution.pressure;
    let total: f64 = pressure.iter().sum();
    let sums = pressure.iter().enumerate().fold([0.0; 2], |[sx, sy], (k, p)| {
        let [x, y] = grid.centre_of(k);
        [sx + p * x, sy + p * y]
    });
    door.gap.outward(sums.map(|s| s / total))
}
