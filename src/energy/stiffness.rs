//! The stiffness of a gap without a law, from its force and what dilations leave of one.
//!
//! The exact pressure grows with the depth like that of a flat punch on the contact, m_A. From <1, p> = (2 mu - beta) U + <T, p> with
//! T = 1 - mu f - W . grad f ([`super::virial`]), df/dd = 1 and dU/dd = P
//!
//!   dP/dd = (mu - beta) P + <T, m_A>.                                                                                    (9)
//!
//! The force is known far better than m_A, whose contact ends between cells: what T leaves of eta = 1 is all that m_A is needed for.

use super::bracket::Trial;
use super::of_gap::GapOverlap;
use super::on_cells::OnCells;
use super::overlap::OverlapBounds;
use super::parts::in_parts;
use super::pressed::Pressed;
use super::virial::Virial;
use crate::gap::AnyGap;

/// dP/dd by (9) from the force and the pressure `growing` on the cells of a trial, E* = 1, and the largest T where the contact ends between
/// cells: what an error there counts. `None` where nothing is known that helps.
pub(crate) fn stiffness(gap: &AnyGap, depth: f64, trial: &Trial, growing: &[f64], force: f64) -> Option<[f64; 2]> {
    let overlap = GapOverlap::new(gap, depth);
    let cells = OnCells::new(&overlap, trial.grid);
    let nx = trial.grid.shape[0];
    let halves = trial.halves(&cells as &dyn OverlapBounds);
    let pressed = Pressed::new(trial.grid, halves, |i, j| trial.pressure[j * nx + i]);
    let [width, height] = trial.grid.shape.map(|n| n as isize);
    let bare = |[i, j]: [isize; 2]| {
        let inside = i >= 0 && j >= 0 && i < width && j < height;
        !inside || trial.pressure[j as usize * nx + i as usize] <= 0.0
    };
    in_parts(&overlap, &cells, trial.grid, |parts| {
        let virial = Virial::fitted(&pressed, parts, [1.0, 0.0, 0.0], &[]);
        if virial.is_plain() {
            return None;
        }
        let (mut sum, mut at_end) = (0.0, 0.0_f64);
        for &(i, j, _) in &pressed.cells {
            let left = |[i, j]: [isize; 2]| virial.nearly(&pressed.rect(i, j), parts);
            let own = left([i, j]);
            sum += pressed.images(i, j) * growing[j as usize * nx + i as usize] * own;
            // On both sides of the end: it lies somewhere in either cell.
            for beyond in [[i - 1, j], [i + 1, j], [i, j - 1], [i, j + 1]].into_iter().filter(|cell| bare(*cell)) {
                at_end = at_end.max(own.abs()).max(left(beyond).abs());
            }
        }
        let found = virial.per_depth() * force + trial.grid.cell_area() * sum;
        (found > 0.0).then_some([found, at_end])
    })
}
