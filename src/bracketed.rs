//! A bracket for a state that was asked to have one: grids refined until it is as narrow as the tolerance.

use crate::Contact;
use crate::bracket::{self, BracketSettings, ForceBracket};
use crate::by_grid;
use crate::error::Unsolved;
use crate::gap::{AnyGap, Tilted};
use crate::settings::{Method, Outputs, Settings};
use crate::solution::Solution;

/// Cells along the longer side of the first and the last grid, when the scene does not say.
const GRIDS: [usize; 2] = [64, 512];

/// The solution with a bracket on its force.
///
/// # Errors
/// Those of the grid solves and of the bracket.
pub(crate) fn with_bracket(
    contact: &Contact,
    mut solution: Solution,
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    if solution.force <= 0.0 {
        return Ok(solution);
    }
    let gap = match solution.tilt {
        [0.0, 0.0] => contact.gap().clone(),
        tilt => AnyGap::new(Tilted::new(contact.gap().clone(), tilt)),
    };
    let [mut cells, last] = settings.cells.map_or(GRIDS, |cells| [cells; 2]);
    let look = BracketSettings { threads: settings.threads, ..BracketSettings::default() };
    let mut best: Option<ForceBracket> = None;
    loop {
        let outputs = Outputs { pressure: true, ..Outputs::default() };
        let on_grid = Settings { method: Method::Fft, cells: Some(cells), outputs, ..*settings };
        let grid = by_grid::solution(contact, &gap, solution.depth, solution.tilt, &on_grid, false)?;
        if let Some(field) = &grid.pressure.field {
            let found = bracket::sharp(&*gap, contact.modulus(), solution.depth, field, &look)?;
            if best.as_ref().is_none_or(|b| found.relative_width() < b.relative_width()) {
                best = Some(found);
            }
        }
        let narrow = best.as_ref().is_some_and(|b| b.relative_width() <= settings.tolerance);
        if narrow || cells >= last {
            break;
        }
        cells *= 2;
    }
    if let Some(bracket) = best.as_ref().filter(|b| b.relative_width() > settings.tolerance) {
        solution.remarks.push(format!(
            "the bracket is {:.1e} wide with {cells} cells, not {:.1e}; twice the cells would take about five times as long",
            bracket.relative_width(),
            settings.tolerance
        ));
    }
    solution.bracket = best;
    Ok(solution)
}
