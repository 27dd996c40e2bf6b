//! Contacts that lie far apart, each on a grid of its own.
//!
//! Pressure vanishes where the undeformed bodies do not overlap, so separate pieces of {f > 0} are separate contacts. They
//! feel one another only through the displacement that the load of one leaves at the others, which is smooth there: each
//! is solved in turn on the gap that the others have left (block Gauss-Seidel), until the forces no longer change. The
//! factor from sweep to sweep is about the square of size over distance. Sweeps stay on the cells that the first one laid: what the
//! others displace changes little of how well these tell the force.

use std::f64::consts::PI;

use super::contact_loads::{ContactLoads, PointLoads};
use super::dimensional::in_users_units;
use super::refined::Refined;
use super::samples;
use super::separate_stiffness::growth;
use super::subcontact::{Cells, Solved, Subcontact, cell_loads};
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
const FAR: f64 = 2.0;

/// Sweeps over all contacts at one tolerance, and times that their grids are laid.
pub(super) const SWEEPS: usize = 20;
const LAID: usize = 4;

/// What of the tolerance a sweep may still change of the force, and the tolerance of the first, rough grids.
const SETTLED: f64 = 0.1;
const ROUGH: f64 = 0.02;

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

/// Contacts that are solved in turn, at one depth and tilt after another.
pub(crate) struct Contacts {
    /// Of many parts only those that matter in a rectangle.
    gaps: Vec<AnyGap>,
    rectangles: Vec<Rect>,
    /// None of those that the first sweep has not come to.
    ones: Vec<Option<Subcontact>>,
    /// The forces that the last sweep has changed, all together.
    missed: f64,
    /// Iterations and products of all sweeps.
    spent: (usize, usize),
}

/// The loads of all contacts but one.
fn others(ones: &[Option<Subcontact>], but: usize) -> impl Iterator<Item = &ContactLoads> {
    ones.iter().enumerate().filter(move |(k, _)| *k != but).filter_map(|(_, one)| Some(&one.as_ref()?.loads))
}

impl Contacts {
    /// Within these rectangles, from contacts at a depth before that lie in the same places.
    fn of(gap: &AnyGap, rectangles: &[Rect], before: Option<Self>) -> Self {
        let restricted = |within: &Rect| gap.restricted(within).unwrap_or_else(|| gap.clone());
        let gaps = rectangles.iter().map(restricted).collect();
        let same = |before: &Self| {
            let pairs = || before.rectangles.iter().zip(rectangles);
            before.rectangles.len() == rectangles.len() && pairs().all(|(a, b)| a.contains(b.centre()))
        };
        let anew = || rectangles.iter().map(|_| None).collect();
        let ones = before.filter(same).map_or_else(anew, |before| before.ones);
        Self { gaps, rectangles: rectangles.to_vec(), ones, missed: 0.0, spent: (0, 0) }
    }

    /// All at the depth, to the tolerance or `roughly`, which comes first: what they do to one another needs few cells.
    fn solve(&mut self, depth: f64, settings: &Settings, roughly: bool) -> Result<(), Unsolved> {
        if self.ones.iter().any(Option::is_none) {
            self.sweep(depth, settings, Some(Cells::Rough))?;
        }
        let rough = settings.tolerance.max(ROUGH);
        let tolerance = if roughly { rough } else { settings.tolerance };
        self.settle(depth, settings, if self.all(|one| one.cells == Cells::Fine) { tolerance } else { rough })?;
        for laid in 1..=LAID {
            if self.all(|one| (roughly || one.cells == Cells::Fine) && one.serves()) {
                break;
            }
            self.sweep(depth, settings, Some(if roughly { Cells::Rough } else { Cells::Fine }))?;
            // Cells that hold everything only as they were laid stay.
            if laid < LAID {
                self.settle(depth, settings, tolerance)?;
            }
        }
        Ok(())
    }

    /// Sweeps on the same cells until the forces no longer change.
    fn settle(&mut self, depth: f64, settings: &Settings, tolerance: f64) -> Result<(), Unsolved> {
        for _ in 0..SWEEPS {
            self.sweep(depth, settings, None)?;
            if self.missed <= SETTLED * tolerance * self.total() {
                break;
            }
        }
        Ok(())
    }

    /// One sweep, on the cells that there are or on new ones.
    fn sweep(&mut self, depth: f64, settings: &Settings, cells: Option<Cells>) -> Result<(), Unsolved> {
        let mut missed = 0.0;
        for k in 0..self.ones.len() {
            settings.deadline.check()?;
            let (gap, within) = (&self.gaps[k], self.rectangles[k]);
            let moved = match &self.ones[k] {
                Some(before) if cells.is_none() => before.moved(gap, depth, within, others(&self.ones, k), settings)?,
                _ => None,
            };
            let cells = cells.or(self.ones[k].as_ref().map(|one| one.cells)).unwrap_or(Cells::Rough);
            let anew = || Subcontact::solve(gap, depth, within, others(&self.ones, k), settings, cells);
            let one = moved.map_or_else(anew, Ok)?;
            if let Some(Solved { refined, .. }) = &one.solved {
                self.spent.0 += refined.state.iterations;
                self.spent.1 += refined.state.operator_products;
            }
            let before = self.ones[k].as_ref().map_or(0.0, |before| before.loads.total());
            missed += (one.loads.total() - before).abs();
            self.ones[k] = Some(one);
        }
        self.missed = missed;
        Ok(())
    }

    fn all(&self, that: impl Fn(&Subcontact) -> bool) -> bool {
        self.ones.iter().all(|one| one.as_ref().is_some_and(&that))
    }

    fn total(&self) -> f64 {
        self.ones.iter().flatten().map(|one| one.loads.total()).sum()
    }
}

/// What is asked of the state of contacts that lie far apart.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// The gap under the tilt, and where its contacts lie.
    pub gap: &'a AnyGap,
    pub rectangles: &'a [Rect],
    pub depth: f64,
    pub tilt: [f64; 2],
    pub settings: &'a Settings,
    /// The stiffness against tilts too.
    pub with_matrix: bool,
    /// A few percent are enough.
    pub roughly: bool,
}

/// The state of all contacts, in the user's units; from those that were held before, which it holds for the next.
///
/// # Errors
/// As for a single contact; where one of them falls short of the tolerance, with the state of all.
pub(crate) fn solution(contact: &Contact, wanted: Wanted, held: &mut Option<Contacts>) -> Result<Solution, Unsolved> {
    let Wanted { gap, rectangles, depth, tilt, settings, with_matrix, roughly } = wanted;
    // What the others displace is known to a few digits, and proves nothing.
    let settings = &Settings { evidence: ErrorBar::Estimate, ..*settings };
    let before = held.take();
    let contacts = held.insert(Contacts::of(gap, rectangles, before));
    let out_of_time = match contacts.solve(depth, settings, roughly) {
        // The sweeps before serve.
        Err(e) if e.verdict == Verdict::TimeLimit && contacts.all(|one| one.depth == depth) => Some(e),
        solved => solved.map(|()| None)?,
    };
    let mut states = Vec::new();
    let quiet =
        Settings { outputs: crate::problem::Outputs { pressure: true, gap: false, ..settings.outputs }, ..*settings };
    for (k, one) in contacts.ones.iter().enumerate() {
        let Some((one, solved)) = one.as_ref().and_then(|one| Some((one, one.solved.as_ref()?))) else { continue };
        let Solved { scaled, refined } = solved;
        // Of the stiffness, found for all at once, only the error is taken.
        let stiffness = (0.0, solved.stiffness_error()?);
        let mut state = in_users_units(contact, scaled, refined, stiffness, depth, tilt, &quiet)?;
        let moved = one.displaced_by(others(&contacts.ones, k));
        if let Some(residuals) = &mut state.residuals {
            residuals.penetration += moved / scaled.units.height;
            residuals.complementarity += moved / scaled.units.height;
        }
        // The rest of what its load does is in its own overlap.
        state.energy = state.energy.map(|u| u + one.shared_energy() * contact.modulus().e_star());
        states.push(state);
    }
    if states.is_empty() {
        return Ok(Solution::apart(Method::Fft, depth, tilt));
    }
    let solved = || contacts.ones.iter().flatten().filter_map(|one| one.solved.as_ref());
    let boxes: Vec<Rect> = solved().map(Solved::extent).collect();
    if let Err(broken) = nothing_left_out(gap, depth, &boxes, contacts.total()) {
        // A contact smaller than a cell of the grid that was prescribed, or that there was time for.
        return Err(match out_of_time {
            Some(short) => short.without_numbers(&broken),
            None if settings.cells.is_some() => too_few_cells(&broken),
            None => broken,
        });
    }
    let short = || solved().find_map(|solved| solved.refined.shortfall(settings));
    let short = out_of_time.or_else(short);
    let matrix = growth(contact, &contacts.ones, with_matrix)?;
    let mut all = together(states, settings, contacts.missed * contact.modulus().e_star());
    let forces = contacts.ones.iter().map(|one| one.as_ref().map_or(0.0, |one| one.loads.total()));
    let loaded: Vec<(Rect, f64)> = rectangles.iter().copied().zip(forces).collect();
    if samples::may_touch_between(gap, depth, &loaded) {
        all.samples = None;
    }
    all.stiffness = matrix[0][0];
    all.stiffness_matrix = with_matrix.then_some(matrix);
    (all.cost.iterations, all.cost.operator_products) = contacts.spent;
    match short {
        None => Ok(all),
        Some(short) => Err(short.with_best(all)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{Minimum, Paraboloid, Place};
    use crate::problem::{EffectiveModulus, Loading};

    fn three_tips() -> Contact {
        let tip = |radius: f64, at: [f64; 2]| Paraboloid::new([radius; 2]).unwrap().placed(at, 0.0).unwrap();
        let gap = Minimum::new(vec![tip(1.0, [0.0, 0.0]), tip(0.7, [4.0, 0.5]), tip(1.3, [-1.0, 5.0])]).unwrap();
        Contact::new(EffectiveModulus::from_e_star(1.0).unwrap(), gap, Loading::depth(1.0)).unwrap()
    }

    fn at(contact: &Contact, depth: f64, held: &mut Option<Contacts>) -> Solution {
        let settings = &Settings::default();
        let overlap = Overlap::of(contact.gap(), depth).unwrap().unwrap();
        let (gap, pieces) = (contact.gap(), rectangles(&overlap, settings).expect("apart"));
        let (tilt, with_matrix, roughly) = ([0.0; 2], false, false);
        let wanted = Wanted { gap, rectangles: &pieces, depth, tilt, settings, with_matrix, roughly };
        solution(contact, wanted, held).unwrap()
    }

    #[test]
    fn a_state_that_was_gone_on_to_is_that_of_its_depth() {
        let contact = three_tips();
        let mut held = None;
        let first = at(&contact, 0.2, &mut held);
        // dP/dd, on the same cells.
        let next = at(&contact, 0.202, &mut held);
        let rate = (next.force - first.force) / 0.002 / (0.5 * (first.stiffness + next.stiffness));
        assert!((rate - 1.0).abs() < 0.01, "{rate}");
        for depth in [0.202, 0.3, 0.15] {
            let gone_on = at(&contact, depth, &mut held);
            let anew = at(&contact, depth, &mut None);
            let off = |value: fn(&Solution) -> f64| (value(&gone_on) / value(&anew) - 1.0).abs();
            assert!(off(|s| s.force) < gone_on.force_error.unwrap(), "{depth}: {}", off(|s| s.force));
            assert!(off(|s| s.energy.unwrap()) < gone_on.energy_error.unwrap(), "{depth}");
            assert!(off(|s| s.patch.area) < gone_on.area_error.unwrap(), "{depth}");
            assert!(off(|s| s.stiffness) < gone_on.stiffness_error.unwrap(), "{depth}");
            assert!(gone_on.residuals.unwrap().penetration < 1e-4, "{depth}");
        }
    }
}
