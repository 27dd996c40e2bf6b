//! A state of contact from the grid, in the user's units.

mod contact_loads;
pub(crate) mod dimensional;
mod displaced;
pub(crate) mod domain;
mod expansion;
pub(crate) mod extrapolation;
pub(crate) mod gap_left;
pub(crate) mod refined;
pub(crate) mod refinement;
mod samples;
mod separate;
mod separate_stiffness;
pub(crate) mod sharp_edges;
pub(crate) mod single_grid;
mod subcontact;
mod together;
mod unresolved;
pub(crate) mod warm_start;

use self::dimensional::dimensional;
use self::refined::Refined;
pub(crate) use self::refinement::REPEATABLE;
pub(crate) use self::separate::Contacts;
use self::separate::Wanted;
use self::sharp_edges::Edge;
use self::single_grid::GridState;
use crate::by_edges;
use crate::consistency::{Claim, within};
use crate::energy::moment_bounds;
use crate::gap::{AnyGap, Gap};
use crate::grid::Kernel;
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, Scaled};
use crate::problem::{Contact, ErrorBar, Method, Settings};
use crate::solution::{PairBracket, Solution, Unsolved};

/// The method on a grid that the settings ask for.
pub(crate) fn method(settings: &Settings) -> Method {
    if settings.method == Method::Qp { Method::Qp } else { Method::Fft }
}

/// The state at an overlap under this tilt; `with_matrix`: the stiffness against tilts too.
///
/// # Errors
/// As the solvers: `Unbounded`, `IterationLimit`, `ToleranceNotReached`, `TooLarge`.
pub(crate) fn solution(
    contact: &Contact,
    overlap: &Overlap,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let (asked_for, settings) = (settings, &within_samples(overlap, settings));
    let (gap, depth, method) = (&overlap.gap, overlap.depth, method(settings));
    let each_alone = |rectangles: &[Rect]| {
        let wanted = Wanted { gap, rectangles, depth, tilt, settings, with_matrix, roughly: false };
        each_with_gap(contact, wanted, &mut None)
    };
    if let Some(rectangles) = separate::rectangles(overlap, settings) {
        return each_alone(&rectangles);
    }
    let (law, scaled) = (gap.known().law, overlap.scaled());
    let mut refined = refinement::refined(&scaled, settings, method, law)?;
    let units = &scaled.units;
    if let Some(rectangles) = separate::missed_by(overlap, settings, &scaled, &refined) {
        return each_alone(&rectangles);
    }
    if let Some(bounds) = by_edges::force_bounds(overlap, settings) {
        let unit = units.length * units.height;
        // An estimate that bounds show to be a little too small moves to them; one that is far off is none.
        let claim = Claim { force: refined.force * unit, error: 2.0 * refined.error * unit };
        within(bounds, claim, "its flat part")?;
        refined = refined.moved_within(bounds.map(|force| force / unit), settings.cells.is_some());
    }
    let mut solution = dimensional(contact, &scaled, &refined, law, depth, tilt, settings)?;
    if with_matrix {
        solution = with_stiffness_matrix(contact, &scaled, &refined, solution)?;
        // What samples leave open of the moments of a measured gap is not known.
        let provable =
            settings.kernel == Kernel::Galerkin && settings.evidence == ErrorBar::Proof && !gap.is_measured();
        if settings.outputs.bracket && provable {
            solution = with_moment_bracket(contact, &scaled, &refined, solution, settings);
        }
    }
    // What was aimed at for the samples' sake may be missed: both errors together are held against what was asked for.
    let allowed = Settings { tolerance: settings.tolerance.max(asked_for.tolerance), ..*settings };
    match refined.shortfall(&allowed) {
        None => Ok(solution),
        Some(short) => Err(short.with_best(solution)),
    }
}

/// No closer than the samples of a measured gap can be told from: what they leave open of the force is stated beside the error of the
/// grids (`acceptance/sampled`), and where it exceeds the tolerance no finer grid helps.
pub(crate) fn within_samples(overlap: &Overlap, settings: &Settings) -> Settings {
    if settings.cells.is_some() || !overlap.gap.is_measured() {
        return *settings;
    }
    let open = samples::expected(overlap);
    if !(open > 0.0) {
        return *settings;
    }
    let tolerance = if open > settings.tolerance {
        (OF_SAMPLES * open).clamp(settings.tolerance, ROUGHEST.max(settings.tolerance))
    } else {
        // Both together are to be within it, where that is possible.
        let left = settings.tolerance - SAMPLES_ROOM * open;
        if left > 0.0 { left.max(LEAST_LEFT * settings.tolerance) } else { 0.5 * settings.tolerance }
    };
    Settings { tolerance, ..*settings }
}

/// What samples leave open of the force is expected on few cells: room for that.
const SAMPLES_ROOM: f64 = 1.5;

/// Share of the tolerance that the grids are asked for at least beside what samples leave open.
const LEAST_LEFT: f64 = 0.1;

/// Share of what samples leave open that the error of the grids may be, and the largest such error.
const OF_SAMPLES: f64 = 0.2;
pub(crate) const ROUGHEST: f64 = 0.02;

/// Whether the contacts of an overlap are solved on several grids.
pub(crate) fn takes_several_grids(overlap: &Overlap, settings: &Settings) -> bool {
    separate::rectangles(overlap, settings).is_some()
}

/// The untilted state at an overlap of contacts that are solved on several grids, which [`crate::grid_method::warm_start::WarmStart`] does
/// not do: from those at a depth before, which `held` holds for the next; `None` where one grid serves.
///
/// # Errors
/// As [`solution`].
pub(crate) fn on_several_grids(
    contact: &Contact,
    overlap: &Overlap,
    settings: &Settings,
    roughly: bool,
    held: &mut Option<Contacts>,
) -> Result<Option<Solution>, Unsolved> {
    let Some(rectangles) = separate::rectangles(overlap, settings) else { return Ok(None) };
    let settings = &within_samples(overlap, settings);
    let Overlap { gap, depth, .. } = overlap;
    let (rectangles, depth, tilt) = (&rectangles[..], *depth, [0.0; 2]);
    let wanted = Wanted { gap, rectangles, depth, tilt, settings, with_matrix: false, roughly };
    each_with_gap(contact, wanted, held).map(Some)
}

/// Contacts that lie far apart, with the gap that they leave where it is asked for.
fn each_with_gap(contact: &Contact, wanted: Wanted, held: &mut Option<Contacts>) -> Result<Solution, Unsolved> {
    let Settings { outputs, kernel, .. } = *wanted.settings;
    let with_gap = |state: Solution| gap_left::with_gap(contact, state, outputs, kernel);
    separate::solution(contact, wanted, held).map(with_gap).map_err(|unsolved| unsolved.map_best(with_gap))
}

/// Whether the cells of the one grid that this was solved on have missed a contact, which only [`solution`] finds.
pub(crate) fn misses_a_contact(overlap: &Overlap, settings: &Settings, scaled: &Scaled, refined: &Refined) -> bool {
    separate::missed_by(overlap, settings, scaled, refined).is_some()
}

fn with_stiffness_matrix(
    contact: &Contact,
    scaled: &Scaled,
    refined: &Refined,
    solution: Solution,
) -> Result<Solution, Unsolved> {
    let unit = contact.modulus().e_star() * scaled.units.length;
    let entries = |state: &GridState| {
        let matrix = single_grid::stiffness_matrix(state, |p| scaled.units.outward(p))?;
        Ok(std::array::from_fn::<f64, 9, _>(|n| matrix[n / 3][n % 3] * unit))
    };
    let entries = refined.limits(entries)?;
    Ok(Solution { stiffness_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| entries[3 * i + j]))), ..solution })
}

/// With bounds of its moments by the pressure of the last grid.
fn with_moment_bracket(
    contact: &Contact,
    scaled: &Scaled,
    refined: &Refined,
    mut solution: Solution,
    settings: &Settings,
) -> Solution {
    let (state, e_star) = (&refined.state, contact.modulus().e_star());
    let found = moment_bounds(scaled, e_star, &state.trial(), settings.tolerance, settings.deadline);
    let room = |[low, high]: [f64; 2]| {
        let room = REPEATABLE * (high - low);
        [low - room, high + room]
    };
    let bounds = found.map(|bounds| PairBracket::proved(bounds.map(room)));
    solution.moment = solution.moment.map(|moment| bounds.map_or(moment, |bounds| bounds.nearest(moment)));
    solution.moment_bracket = bounds;
    solution
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
    let Some(overlap) = Overlap::of(gap, depth)? else { return Ok(None) };
    let Some(rectangles) = separate::rectangles(&overlap, settings) else { return Ok(None) };
    let wanted = Wanted { gap, rectangles: &rectangles, depth, tilt, settings, with_matrix: true, roughly: false };
    separate::solution(contact, wanted, &mut None).map(Some)
}

/// The state at a depth and tilt on one grid that stays where it is from one tilt to the next, with its stiffness
/// matrix: force and moments are then the exact derivatives of one convex energy. `shared` is the box of that grid in the
/// user's units; found when `None`, enlarged when the contact outgrows it.
///
/// # Errors
/// As [`solution`].
pub(crate) fn on_shared_grid(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    cells: usize,
    shared: &mut SharedGrid,
) -> Result<Solution, Unsolved> {
    let method = method(settings);
    let Some(overlap) = Overlap::of(gap, depth)? else {
        return Ok(Solution::apart(method, depth, tilt));
    };
    let scaled = overlap.scaled();
    let window = match &shared.window {
        Some(rect) => scaled.units.rect_inward(rect),
        None => domain::locate(&scaled)?.scaled(ROOM),
    };
    // Cells end where the material does, the same at any depth and tilt.
    let material = shared.material.map(|material| scaled.units.rect_inward(&material));
    let mut window = material.and_then(|material| window.intersection(&material)).unwrap_or(window);
    let state = single_grid::at_resolution(&scaled, &mut window, cells, settings, method)?;
    shared.window = Some(scaled.units.rect_outward(&window));
    shared.edge = sharp_edges::boundary_type(&scaled, &state);
    let [spacing, lost] = sharp_edges::measure(&scaled, &state);
    shared.measure = [spacing * scaled.units.length, lost * scaled.units.length * scaled.units.length];
    shared.rim = unresolved::end(&state.problem, &state.solution.pressure);
    let error = if shared.needs_error { single_grid::load_by_other_kernel(&scaled, &state)? } else { 0.0 };
    // The energy of these cells themselves, whose derivatives force and moments are, whatever law the gap follows.
    let energy = state.energy() * contact.modulus().e_star() * scaled.units.height.powi(2) * scaled.units.length;
    let refined = Refined::of(state, error);
    let solution = dimensional(contact, &scaled, &refined, None, depth, tilt, settings)?;
    let solution = Solution { energy: Some(energy), ..solution };
    with_stiffness_matrix(contact, &scaled, &refined, solution)
}

/// The grid that all tilts share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedGrid {
    /// Its box, once it is known.
    pub window: Option<Rect>,
    /// A box around everything that can touch at any depth, where it is known.
    pub material: Option<Rect>,
    /// The edge that the last contact on it ran up to, if any.
    pub edge: Option<Edge>,
    /// The longer side of its cells, and the area of material that they leave out.
    pub measure: [f64; 2],
    /// Relative error of a number that rests on where the contact ends between cells.
    pub rim: f64,
    /// Whether a grid has to tell its own error, by the other kernel.
    pub needs_error: bool,
}

impl SharedGrid {
    /// Not laid yet.
    pub fn new() -> Self {
        Self { window: None, material: None, edge: None, measure: [0.0; 2], rim: 0.0, needs_error: true }
    }
}

/// What the box of an untilted contact is enlarged by before the punch tilts.
const ROOM: f64 = 1.3;
