//! Results out: JSON for programs, a table for people, CSV for spreadsheets, .npy and .vti for fields, a page for reading.

mod comparison;
mod csv;
#[cfg(feature = "cli")]
pub(crate) mod error_by_cells;
mod json;
#[cfg(feature = "cli")]
pub(crate) mod npy;
#[cfg(feature = "plot")]
mod page;
#[cfg(feature = "plot")]
pub(crate) mod pictured;
pub(crate) mod table;
mod vti;
#[cfg(feature = "cli")]
pub(crate) mod write;

pub use comparison::{comparison_csv, comparison_json, comparison_table};
pub use csv::{csv, csv_in, pieces_csv};
pub use json::{Outcome, json};
#[cfg(feature = "plot")]
pub use page::{Page, Parts, Provenance, page, page_of};
pub use table::table;
pub use vti::{vti, vti_of};

use crate::solution::{Solution, Unsolved};

/// One load state: solved, or what is wrong.
pub type Step = Result<Solution, Unsolved>;

/// The numbers of a step: those of its solution, or the best that its verdict carries.
pub(crate) fn numbers(step: &Step) -> Option<&Solution> {
    step.as_ref().map_or_else(|unsolved| unsolved.best.as_deref(), Some)
}

/// Where the resultant of the pressure meets the surface: x = -My/P, y = Mx/P; `None` without force or moment.
fn centre_of_pressure(solution: &Solution) -> Option<[f64; 2]> {
    let [mx, my] = solution.moment?;
    let centre = [-my / solution.force, mx / solution.force];
    (solution.force > 0.0 && centre.iter().all(|c| c.is_finite())).then_some(centre)
}

/// What all steps say, each sentence once, in the order of its first appearance.
fn said_once<'a>(steps: &'a [Step], of: impl Fn(&'a Solution) -> &'a [String]) -> Vec<&'a str> {
    let mut known = std::collections::HashSet::new();
    let sentences = steps.iter().filter_map(numbers).flat_map(of).map(String::as_str);
    sentences.filter(|sentence| known.insert(*sentence)).collect()
}
