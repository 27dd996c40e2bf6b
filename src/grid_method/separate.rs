//! Contacts that lie far apart, each on a grid of its own.
//!
//! Pressure vanishes where the undeformed bodies do not overlap, so separate pieces of {f > 0} are separate contacts. They
//! feel one another only through the displacement that the load of one leaves at the others, which is smooth there: each
//! is solved in turn on the gap that the others have left (block Gauss-Seidel), until the force no longer changes. The
//! factor from sweep to sweep is about the square of size over distance.

use std::f64::consts::PI;

use super::dimensional::dimensional;
use super::displaced::{ContactLoads, DisplacedGap, PointLoads};
use super::refined::Refined;
use super::refinement;
use super::single_grid;
use super::together::together;
use crate::consistency::{nothing_left_out, too_few_cells};
use crate::gap::{AnyGap, Gap, enclosure};
use crate::numeric::geometry::{Rect, distance};
use crate::overlap::{Overlap, Scaled};
use crate::problem::{Contact, ErrorBar, Method, Settings};
use crate::solution::{Solution, Unsolved, Verdict};

/// More contacts than that share one grid.
const MOST: usize = 256;

/// Contacts among which needles have grids of their own; of more of them one grid tells what matters.
const FEW: usize = 16;

/// The box of all contacts is so many times as long as the largest one, or one grid serves them all.
const FAR: f64 = 4.0;

/// Sweeps over all contacts at one tolerance.
const SWEEPS: usize = 20;

/// Whether what is asked for allows more than one grid.
fn may_be_several(settings: &Settings) -> bool {
    settings.cells.is_none() && settings.method != Method::Qp
}

/// Rectangles around contacts that are to be solved apart; `None` when one grid serves.
pub(crate) fn rectangles(overlap: &Overlap, settings: &Settings) -> Option<Vec<Rect>> {
    if !may_be_several(settings) {
        return None;
    }
    let apart = overlap.components();
    let largest = apart.iter().map(Rect::longer_side).fold(0.0, f64::max);
    let far = (2..=MOST).contains(&apart.len()) && overlap.reach.longer_side() >= FAR * largest && largest > 0.0;
    // One grid would lose the smallest of them.
    let fits = far || (2..=FEW).contains(&apart.len()) && overlap.has_needles();
    fits.then(|| apart.to_vec())
}

/// The same where the cells of one grid have missed a contact: it lies outside of them, or is smaller than they are.
pub(crate) fn missed_by(
    overlap: &Overlap,
    settings: &Settings,
    scaled: &Scaled,
    refined: &Refined,
) -> Option<Vec<Rect>> {
    if overlap.known().tips.len() < 2 || !may_be_several(settings) {
        return None;
    }
    let units = &scaled.units;
    let extent = units.rect_outward(&refined.state.problem.grid.extent());
    let force = refined.force * units.height * units.length;
    let outside = nothing_left_out(&overlap.gap, overlap.depth, &[extent], force).is_err();
    // Where the box is filled, only a contact that is known to be missed is worth the search for all of them.
    if !outside && overlap.fills_its_box() {
        return None;
    }
    let pieces = overlap.closer_components().filter(|pieces| pieces.len() <= MOST)?;
    let loads = cell_loads(scaled, refined, |k| refined.state.solution.pressure[k]);
    let smaller = || pieces.len() <= FEW && pieces.iter().any(|piece| is_bare(overlap, piece, &loads));
    (outside || smaller()).then_some(pieces)
}

/// Whether no cell within a piece of the overlap carries a load, and what those elsewhere displace leaves some of it.
fn is_bare(overlap: &Overlap, piece: &Rect, loads: &PointLoads) -> bool {
    if loads.iter().any(|(p, _)| piece.contains(*p)) {
        return false;
    }
    let left = |p: [f64; 2]| {
        let displacement = |(at, q): &([f64; 2], f64)| q / (PI * distance(p, *at));
        overlap.depth - loads.iter().map(displacement).sum::<f64>()
    };
    let found = enclosure::least(&overlap.gap, piece, 0.0, left(piece.centre()));
    found.is_some_and(|lowest| lowest.value < left(lowest.at))
}

/// One of the contacts, solved on the gap that the others left.
struct Subcontact {
    displaced: DisplacedGap,
    /// `None` when the others have pushed the surface out of reach.
    solved: Option<Refined>,
    /// In the units of its own solve.
    scaled: Option<Scaled>,
    loads: ContactLoads,
}

impl Subcontact {
    fn solve<'a>(
        gap: &AnyGap,
        depth: f64,
        within: Rect,
        others: impl IntoIterator<Item = &'a ContactLoads>,
        settings: &Settings,
    ) -> Result<Self, Unsolved> {
        let displaced = DisplacedGap::new(gap.clone(), within, others);
        let Some(overlap) = Overlap::of(&AnyGap::new(displaced.clone()), depth)? else {
            return Ok(Self { displaced, solved: None, scaled: None, loads: ContactLoads::default() });
        };
        let scaled = overlap.scaled();
        let refined = refinement::refined(&scaled, settings, Method::Fft, None)?;
        // The finest grid carries the force of all of them together.
        let share = refined.force / refined.state.force();
        let loads = loads(&scaled, &refined, |k| refined.state.solution.pressure[k] * share);
        Ok(Self { displaced, solved: Some(refined), scaled: Some(scaled), loads })
    }
}

/// The loads of pressures.
fn loads(scaled: &Scaled, refined: &Refined, pressure: impl Fn(usize) -> f64) -> ContactLoads {
    ContactLoads::new(cell_loads(scaled, refined, pressure))
}

/// The same in the user's frame, one of each cell.
fn cell_loads(scaled: &Scaled, refined: &Refined, pressure: impl Fn(usize) -> f64) -> PointLoads {
    let grid = &refined.state.problem.grid;
    let unit = scaled.units.height * scaled.units.length * grid.cell_area();
    let load = |k: usize| (scaled.units.outward(grid.centre_of(k)), pressure(k) * unit);
    (0..grid.len()).map(load).filter(|load| load.1 != 0.0).collect()
}

fn others(all: &[ContactLoads], but: usize) -> impl Iterator<Item = &ContactLoads> {
    all.iter().enumerate().filter(move |(k, _)| *k != but).map(|(_, loads)| loads)
}

fn total(loads: &[ContactLoads]) -> f64 {
    loads.iter().map(ContactLoads::total).sum()
}

/// The state of all contacts at a depth and tilt (`gap` is the contact's gap under that tilt), in the user's units.
///
/// # Errors
/// As for a single contact; where one of them falls short of the tolerance, with the state of all.
pub(crate) fn solution(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    rectangles: &[Rect],
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    // What the others displace is known to a few digits, and proves nothing.
    let settings = &Settings { evidence: ErrorBar::Estimate, ..*settings };
    let mut current = vec![ContactLoads::default(); rectangles.len()];
    // Of many parts only those that matter in a rectangle.
    let gaps: Vec<AnyGap> =
        rectangles.iter().map(|within| gap.restricted(within).unwrap_or_else(|| gap.clone())).collect();
    let mut ones: Vec<Subcontact> = Vec::new();
    let mut missed = 0.0;
    let mut out_of_time = None;
    let (mut iterations, mut operator_products) = (0, 0);
    // Roughly first: what the contacts do to one another needs few cells.
    'sweeps: for tolerance in [settings.tolerance.max(0.02), settings.tolerance] {
        let settings = Settings { tolerance, ..*settings };
        for _ in 0..SWEEPS {
            let before = total(&current);
            let mut next = Vec::new();
            for (k, &within) in rectangles.iter().enumerate() {
                let solved = settings.deadline.check().map_err(Unsolved::from);
                let solved =
                    solved.and_then(|()| Subcontact::solve(&gaps[k], depth, within, others(&current, k), &settings));
                let one = match solved {
                    // The sweep before serves.
                    Err(e) if e.verdict == Verdict::TimeLimit && !ones.is_empty() => {
                        out_of_time = Some(e);
                        break 'sweeps;
                    }
                    solved => solved?,
                };
                current[k].clone_from(&one.loads);
                if let Some(refined) = &one.solved {
                    iterations += refined.state.iterations;
                    operator_products += refined.state.operator_products;
                }
                next.push(one);
            }
            ones = next;
            missed = (total(&current) - before).abs();
            if missed <= 0.1 * tolerance * total(&current) {
                break;
            }
        }
    }
    let mut states = Vec::new();
    let quiet =
        Settings { outputs: crate::problem::Outputs { pressure: true, gap: false, ..settings.outputs }, ..*settings };
    for (k, one) in ones.iter().enumerate() {
        let (Some(refined), Some(scaled)) = (&one.solved, &one.scaled) else { continue };
        let mut state = dimensional(contact, scaled, refined, None, depth, tilt, &quiet)?;
        // The others' last displacement against the one this contact was solved with.
        let latest = DisplacedGap::new(gap.clone(), rectangles[k], others(&current, k));
        let moved = rectangles[k].corners().into_iter().chain([rectangles[k].centre()]);
        let moved = moved.map(|p| (latest.displacement(p) - one.displaced.displacement(p)).abs()).fold(0.0, f64::max);
        if let Some(residuals) = &mut state.residuals {
            residuals.penetration += moved / scaled.units.height;
            residuals.complementarity += moved / scaled.units.height;
        }
        // Half of what this contact's load does in the displacement by the others; the rest is in its own overlap.
        let shared: f64 = one.loads.iter().map(|(p, q)| q * one.displaced.displacement(*p)).sum();
        state.energy = state.energy.map(|u| u + 0.5 * shared * contact.modulus().e_star());
        states.push(state);
    }
    if states.is_empty() {
        return Ok(Solution::apart(Method::Fft, depth, tilt));
    }
    let extent = |one: &Subcontact| {
        let (refined, scaled) = (one.solved.as_ref()?, one.scaled.as_ref()?);
        Some(scaled.units.rect_outward(&refined.state.problem.grid.extent()))
    };
    let boxes: Vec<Rect> = ones.iter().filter_map(extent).collect();
    if let Err(broken) = nothing_left_out(gap, depth, &boxes, total(&current)) {
        // A contact smaller than a cell of the grid that was prescribed, or that there was time for.
        return Err(match out_of_time {
            Some(short) => short.without_numbers(&broken),
            None if settings.cells.is_some() => too_few_cells(&broken),
            None => broken,
        });
    }
    let short = || ones.iter().filter_map(|one| one.solved.as_ref()).find_map(|refined| refined.shortfall(settings));
    let short = out_of_time.or_else(short);
    let matrix = growth(contact, &ones, gap, rectangles, with_matrix)?;
    let mut all = together(states, settings, missed * contact.modulus().e_star());
    all.stiffness = matrix[0][0];
    all.stiffness_matrix = with_matrix.then_some(matrix);
    all.cost.iterations = iterations;
    all.cost.operator_products = operator_products;
    match short {
        None => Ok(all),
        Some(short) => Err(short.with_best(all)),
    }
}

/// Stiffness against depth, and against tilts if asked for: flat punches on all patches at once, by the same sweeps.
fn growth(
    contact: &Contact,
    ones: &[Subcontact],
    gap: &AnyGap,
    rectangles: &[Rect],
    with_matrix: bool,
) -> Result<[[f64; 3]; 3], Unsolved> {
    let rates: [fn([f64; 2]) -> f64; 3] = [|_| 1.0, |[x, _]| x, |[_, y]| y];
    let mut matrix = [[0.0; 3]; 3];
    let columns = if with_matrix { 3 } else { 1 };
    for (column, rate) in rates.iter().enumerate().take(columns) {
        let mut current = vec![ContactLoads::default(); ones.len()];
        for _ in 0..SWEEPS {
            let (before, mut size) = (current.clone(), 0.0);
            for (k, one) in ones.iter().enumerate() {
                let (Some(refined), Some(scaled)) = (&one.solved, &one.scaled) else { continue };
                let raised = DisplacedGap::new(gap.clone(), rectangles[k], others(&current, k));
                let grid = &refined.state.problem.grid;
                let wanted: Vec<f64> = (0..grid.len())
                    .map(|i| scaled.units.outward(grid.centre_of(i)))
                    .map(|p| (rate(p) - raised.displacement(p)) / scaled.units.height)
                    .collect();
                let growing = single_grid::growth(&refined.state, &wanted)?;
                current[k] = loads(scaled, refined, |i| growing[i]);
                size += current[k].iter().map(|load| load.1.abs()).sum::<f64>();
            }
            let change: f64 = current.iter().zip(&before).map(|(a, b)| (a.total() - b.total()).abs()).sum();
            if change <= 1e-8 * size {
                break;
            }
        }
        let e_star = contact.modulus().e_star();
        for (row, weight) in rates.iter().enumerate() {
            matrix[row][column] =
                current.iter().flat_map(ContactLoads::iter).map(|(p, q)| q * weight(*p)).sum::<f64>() * e_star;
        }
    }
    let mean = |i: usize, j: usize| if with_matrix { 0.5 * (matrix[i][j] + matrix[j][i]) } else { matrix[i][j] };
    Ok([0, 1, 2].map(|i| [0, 1, 2].map(|j| mean(i, j))))
}
