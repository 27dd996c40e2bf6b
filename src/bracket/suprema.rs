//! Suprema of the violations of a pressure, proved where the gap allows it.

use super::field::{Field, Surroundings};
use super::gap_bounds::GapBounds;
use super::mirrors::Mirrors;
use super::problem::BracketProblem;
use super::violation::{self, BoundInput, Violation};
use super::{Evidence, kernel};

/// What is kept from one pressure to the next.
pub(super) struct BoundState {
    pub known: GapBounds,
    /// How closely each cell is looked at.
    pub closely: Vec<u8>,
    pub mirrors: Mirrors,
    pub prove: bool,
}

/// Suprema for the pressure `q` and what they are worth.
pub(super) fn suprema(
    problem: &BracketProblem,
    around: &mut Surroundings,
    q: &[f64],
    side: violation::Side,
    state: &mut BoundState,
) -> (Field, Violation, Evidence) {
    let BoundState { known, closely, prove, mirrors } = state;
    let [a, b] = problem.grid.spacing;
    let slender = a.max(b) > kernel::MOST_SLENDER * a.min(b);
    let (field, tables) = (Field::new(around, q), &around.tables);
    let input = BoundInput { problem, field: &field, tables, q, side, mirrors: *mirrors };
    *prove &= problem.reach_certain && !slender;
    if *prove {
        if let Some(found) = Violation::proved(&input, known, closely) {
            return (field, found, Evidence::Proved);
        }
        *prove = false;
        known.forget();
    }
    let found = Violation::sampled(&input, known, closely);
    (field, found, Evidence::Sampled { per_cell: tables.per_cell })
}
