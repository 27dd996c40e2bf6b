//! A bracket for a state that was asked to have one: grids refined until it is as narrow as the tolerance.

use super::approximate::approximate_before;
use crate::bracket::{self, BracketSettings, DepthBracket, Evidence, ForceBracket};
use crate::clock::Stopwatch;
use crate::gap::{AnyGap, Degree};
use crate::grid::Pressure;
use crate::grid_method::domain::locate;
use crate::grid_method::refinement::{AS_A_BRACKET, claimed};
use crate::grid_method::single_grid::at_resolution;
use crate::overlap::Overlap;
use crate::problem::{Contact, ErrorBar, Load, Method, Settings};
use crate::solution::{Solution, Unsolved};

/// Cells along the longer side of the first and the last grid, when the scene does not say.
const GRIDS: [usize; 2] = [64, 512];

/// A bracket narrows at least with this power of the number of cells where the pressure is finite.
const ORDER: f64 = 1.4;

/// The solution with a bracket on its force, and on its depth where the force was prescribed.
///
/// # Errors
/// None: a bracket that cannot be had is said in a remark.
pub(crate) fn with_bracket(
    contact: &Contact,
    load: Load,
    mut solution: Solution,
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    if solution.force <= 0.0 {
        return Ok(solution);
    }
    let gap = contact.tilted_gap(solution.tilt);
    // Half the width is what the force may err by.
    let narrow =
        |b: &mut ForceBracket| b.evidence() == Evidence::Proved && b.relative_width() <= 2.0 * settings.tolerance;
    let before = solution.bracket.clone().filter(|_| settings.evidence == ErrorBar::Proof);
    let found = match (solution.bracket.take_if(narrow), settings.method) {
        (Some(narrow), _) => Ok(Some(narrow)),
        (None, Method::Ritz | Method::Fabrikant) => {
            approximate_before(&gap, contact.modulus(), solution.depth, settings.deadline).map(Some)
        }
        (None, _) => on_grids(contact, &gap, before, &mut solution, settings),
    };
    let bracket = match found {
        Ok(Some(bracket)) => bracket,
        Ok(None) => return Ok(solution),
        Err(e) => {
            // The state is solved all the same.
            solution.remarks.push(format!("no bracket: {}", e.reason));
            return Ok(solution);
        }
    };
    if let Load::Force(force) = load {
        solution.depth_bracket = Some(DepthBracket::under(&gap, solution.depth, force, &bracket));
        solution.remarks.push("the bracket of the force is that at the depth given".to_owned());
    } else if !bracket.contains(solution.force) {
        let side = if solution.force < bracket.lower() { "below" } else { "above" };
        let how = if bracket.evidence() == Evidence::Proved { "is proved to lie" } else { "lies" };
        solution.remarks.push(format!("the force {how} {side} the true one, which the bracket holds"));
    }
    solution.bracket = Some(bracket);
    Ok(solution)
}

/// Grids as fine as the tolerance needs, from the width on the first; what is missing in the end is said in a remark.
fn on_grids(
    contact: &Contact,
    gap: &AnyGap,
    mut best: Option<ForceBracket>,
    solution: &mut Solution,
    settings: &Settings,
) -> Result<Option<ForceBracket>, Unsolved> {
    let Some(overlap) = Overlap::of(gap, solution.depth)? else { return Ok(None) };
    let scaled = overlap.scaled();
    let mut window = locate(&scaled)?;
    let [mut cells, last] = settings.cells.map_or(GRIDS, |cells| [cells; 2]);
    let look = BracketSettings { threads: settings.threads, deadline: settings.deadline, ..BracketSettings::default() };
    let unit_pressure = contact.modulus().e_star() * scaled.units.height / scaled.units.length;
    let unit_force = unit_pressure * scaled.units.length.powi(2);
    let law = gap.known().law.map(|law| law.degree);
    loop {
        let started = Stopwatch::start();
        let state = at_resolution(&scaled, &mut window, cells, settings, Method::Fft)?;
        let grid = scaled.units.grid_outward(&state.problem.grid);
        let values = state.solution.pressure.iter().map(|p| p * unit_pressure).collect();
        let pressure = Pressure { grid, values };
        let mut better = |found: ForceBracket| {
            if best.as_ref().is_none_or(|b| found.relative_width() < b.relative_width()) {
                best = Some(found);
            }
            best.as_ref().is_some_and(|b| b.relative_width() <= settings.tolerance)
        };
        // Far cheaper, and narrower but where the pressure has no bound. Who wants no proof for the error wants that of the bracket alone.
        let wanted = settings.evidence == ErrorBar::Proof && law != Some(Degree::Flat);
        let energy = if wanted { claimed(&scaled, law, &state.trial(), settings, AS_A_BRACKET).ok() } else { None };
        let by_energy =
            energy.map(|bounds| ForceBracket::of_pressure(bounds.map(|force| force * unit_force), &pressure));
        if !by_energy.is_some_and(&mut better) {
            better(bracket::sharp(gap, contact.modulus(), solution.depth, &pressure, &look)?);
        }
        let seconds = started.seconds();
        let width = best.as_ref().map_or(f64::INFINITY, ForceBracket::relative_width);
        if width <= settings.tolerance {
            return Ok(best);
        }
        // As many times the cells as the order asks for, and a tenth more; a whole number of doublings is not needed.
        let finer = 1.1 * (width / settings.tolerance).powf(1.0 / ORDER);
        if cells >= last {
            let more = finer.min(1e4);
            solution.remarks.push(format!(
                "the bracket is {width:.1e} wide with {cells} cells along the longer side, not {:.1e}; that would take \
                 about {:.0} cells where the pressure is finite, and {:.1e} s; twice the cells {:.1e} s",
                settings.tolerance,
                cells as f64 * more,
                seconds * more * more,
                4.5 * seconds
            ));
            return Ok(best);
        }
        cells = ((cells as f64 * finer.clamp(1.5, 8.0) / 16.0).ceil() as usize * 16).min(last);
    }
}
