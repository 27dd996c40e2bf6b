//! A contact as the search for equilibrium sees it: states at depths and tilts, each from what the last one left.

use super::equilibrium::Respond;
use crate::by_edges::LayerStates;
use crate::grid_method::warm_start::WarmStart;
use crate::grid_method::{self, Contacts, SharedGrid};
use crate::loading::{by_formula, respond, without_grid};
use crate::overlap::Overlap;
use crate::problem::{Contact, ErrorBar, Method, Outputs, Settings};
use crate::solution::{Cost, Origin, Solution, Unsolved, Verdict};

/// A contact and settings, as the search for equilibrium sees them.
pub(crate) struct Engine<'a> {
    pub contact: &'a Contact,
    pub settings: &'a Settings,
    with_matrix: bool,
    /// The grid that all tilts share, and the cells along its longer side.
    pub shared: SharedGrid,
    pub cells: usize,
    /// The last full grid of an untilted contact.
    warm_start: Option<WarmStart>,
    /// The last contacts far apart.
    separate: Option<Contacts>,
    /// What holds the states of small depths of a list.
    pub layers: Option<&'a LayerStates>,
    /// Whether one grid has missed a contact.
    several_grids: bool,
    /// What the tilts of a balance are solved on: one kind for all, as what differs between them would be noise to Newton's method.
    pub cells_of_tilts: CellsOfTilts,
    /// Of all states so far.
    spent: Cost,
}

/// Cells of a punch that is free to tilt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellsOfTilts {
    /// The first state decides.
    Open,
    Fitted,
    Grid,
}

impl<'a> Engine<'a> {
    /// `with_matrix`: for a punch that is free to tilt.
    pub fn new(contact: &'a Contact, settings: &'a Settings, with_matrix: bool) -> Self {
        let coarsest = (1.0 / settings.tolerance.sqrt()).clamp(24.0, 256.0) as usize;
        let cells = settings.cells.unwrap_or(coarsest);
        Self {
            contact,
            settings,
            with_matrix,
            shared: SharedGrid::new(),
            cells,
            warm_start: None,
            separate: None,
            layers: None,
            several_grids: false,
            cells_of_tilts: CellsOfTilts::Open,
            spent: Cost::default(),
        }
    }

    /// A state that this engine found without tilt, with proved bounds where they can be had.
    pub fn proved(&self, state: Solution) -> Solution {
        let on_grid = matches!(state.origin, Origin::OneGrid | Origin::ManyGrids { .. });
        let wanted = self.settings.evidence == ErrorBar::Proof && on_grid;
        let found = self.warm_start.as_ref().filter(|_| wanted);
        // Both errors together are to be within the tolerance, where that is possible.
        let open = state.samples.map_or(0.0, |open| open.force / state.force);
        let left = self.settings.tolerance - open;
        let settings =
            Settings { tolerance: if left > 0.0 { left } else { self.settings.tolerance }, ..*self.settings };
        match found.and_then(|found| found.bounds_at(self.contact, state.depth, &settings)) {
            Some(bounds) => state.held_by(bounds, settings.tolerance),
            None => state,
        }
    }

    /// The state by a method without a grid; `None` when it takes a grid.
    fn without_grid(&self, depth: f64, tilt: [f64; 2], quick: bool) -> Option<Result<Solution, Unsolved>> {
        let settings = self.settings;
        let untilted = self.layers.filter(|_| tilt == [0.0; 2]);
        if let Some(held) = untilted.and_then(|layers| layers.at(self.contact, depth, settings)) {
            return Some(Ok(held));
        }
        match settings.method {
            Method::Ritz | Method::Fabrikant | Method::ClosedForm | Method::EdgeFitted => {
                Some(respond(self.contact, depth, tilt, settings, self.with_matrix))
            }
            Method::Auto if settings.cells.is_none() && !settings.outputs.gap => {
                let rough = Settings {
                    outputs: Outputs::default(),
                    tolerance: ROUGH.min(OF_FULL * settings.tolerance).max(settings.tolerance),
                    evidence: ErrorBar::Estimate,
                    ..*settings
                };
                let settings = if quick { &rough } else { settings };
                let gap = self.contact.tilted_gap(tilt);
                let answer = match self.cells_of_tilts {
                    CellsOfTilts::Grid => by_formula(self.contact, &gap, depth, tilt, settings),
                    _ => without_grid(self.contact, &gap, depth, tilt, settings, self.with_matrix),
                };
                let fitted = self.cells_of_tilts == CellsOfTilts::Fitted;
                if fitted && answer.is_none() {
                    let reason =
                        format!("no cells can be fitted at depth {depth:e}, tilt ({:e}, {:e})", tilt[0], tilt[1]);
                    return Some(Err(Unsolved::new(Verdict::NotApplicable, reason)));
                }
                let answer = answer?;
                // A grid may do better.
                let short = answer.as_ref().is_err_and(|e| e.verdict == Verdict::ToleranceNotReached);
                (fitted || !short).then_some(answer)
            }
            _ => None,
        }
    }

    /// A state with what all states took so far.
    fn counted(&mut self, mut state: Solution) -> Solution {
        self.spent.iterations += state.cost.iterations;
        self.spent.operator_products += state.cost.operator_products;
        self.spent.steps += 1;
        state.cost = Cost { unknowns: state.cost.unknowns, ..self.spent };
        state
    }

    /// On a grid, without tilt: a coarse one when that is enough, the cells of the last full one when the contact stays on them.
    fn untilted(&mut self, depth: f64, quick: bool) -> Result<Solution, Unsolved> {
        let apart = || Ok(Solution::apart(self.settings.method, depth, [0.0; 2]));
        let rough = Settings { outputs: Outputs::default(), ..*self.settings };
        let Some(overlap) = Overlap::of(self.contact.gap(), depth)? else { return apart() };
        let asked_for = if quick { &rough } else { self.settings };
        let held = &mut self.separate;
        if let Some(state) = grid_method::on_several_grids(self.contact, &overlap, asked_for, quick, held)? {
            return Ok(state);
        }
        if self.several_grids {
            let rough = Settings { tolerance: ROUGH, ..rough };
            return respond(self.contact, depth, [0.0; 2], if quick { &rough } else { self.settings }, false);
        }
        if quick {
            let found = WarmStart::coarse_solve(self.contact, depth, &rough)?;
            return found.map_or_else(apart, |warm_start| warm_start.solution(self.contact, &rough));
        }
        let moved = match &self.warm_start {
            Some(warm_start) if self.settings.method != Method::Qp => {
                warm_start.continued_to(self.contact, depth, self.settings)?
            }
            _ => None,
        };
        let moved = moved.filter(WarmStart::keeps_its_errors);
        self.warm_start = match moved {
            Some(moved) => Some(moved),
            None => WarmStart::at(&overlap, self.settings)?,
        };
        match &self.warm_start {
            Some(warm_start) => warm_start.solution(self.contact, self.settings),
            None => {
                self.several_grids = true;
                respond(self.contact, depth, [0.0; 2], self.settings, false)
            }
        }
    }
}

/// Relative error of the force that the search for equilibrium begins with, and what it is of the tolerance at most: a full state that is
/// nearer to the load may be the last.
const ROUGH: f64 = 0.02;
const OF_FULL: f64 = 10.0;

/// Times that grids are laid anew because the force lies far from where their errors were told.
const MOST_ANEW: usize = 4;

/// A prescribed grid has so many times the cells, along a side, of the one that its depth is sought on; and the fewest of that.
const COARSER: usize = 4;
const FEWEST: usize = 48;

impl Respond for Engine<'_> {
    fn nearer(&mut self, depth: f64, force: f64) -> Option<f64> {
        let cells = self.settings.cells? / COARSER;
        let sought = cells >= FEWEST
            && matches!(self.settings.method, Method::Auto | Method::Fft)
            && !self.with_matrix
            && !self.several_grids;
        let depth_under = || WarmStart::depth_under(self.contact, depth, force, cells, self.settings).ok()?;
        sought.then(depth_under).flatten()
    }

    fn loaded(&mut self, force: f64) -> Result<Option<Solution>, Unsolved> {
        let Some(warm_start) = self.warm_start.as_ref().filter(|_| self.settings.method != Method::Qp) else {
            return Ok(None);
        };
        let under = |warm_start: &WarmStart| match warm_start.continued_under(self.contact, force, self.settings) {
            Err(unsolved) if unsolved.verdict != Verdict::TimeLimit => Ok(None),
            other => other,
        };
        let Some(mut loaded) = under(warm_start)? else { return Ok(None) };
        let mut anew = 0;
        while !loaded.keeps_its_errors() {
            anew += 1;
            if anew > MOST_ANEW {
                return Ok(None);
            }
            // Where it led to.
            let Some(overlap) = loaded.overlap(self.contact)? else { return Ok(None) };
            let Some(there) = WarmStart::at(&overlap, self.settings)? else { return Ok(None) };
            let Some(found) = under(&there)? else { return Ok(None) };
            loaded = found;
        }
        let state = loaded.solution(self.contact, self.settings);
        self.warm_start = Some(loaded);
        Ok(Some(self.counted(state?)))
    }

    fn respond(&mut self, depth: f64, tilt: [f64; 2], quick: bool) -> Result<Solution, Unsolved> {
        self.settings.deadline.check()?;
        let state = match self.without_grid(depth, tilt, quick) {
            Some(answered) => {
                let state = answered?;
                if self.with_matrix && state.origin == Origin::EdgeFitted {
                    self.cells_of_tilts = CellsOfTilts::Fitted;
                }
                state
            }
            None if !self.with_matrix => self.untilted(depth, quick)?,
            None => {
                // One grid for all tilts, for the same reason.
                self.cells_of_tilts = CellsOfTilts::Grid;
                let gap = self.contact.tilted_gap(tilt);
                let shared = &mut self.shared;
                match grid_method::separately(self.contact, &gap, depth, tilt, self.settings)? {
                    Some(apart) => apart,
                    None => {
                        grid_method::on_shared_grid(self.contact, &gap, depth, tilt, self.settings, self.cells, shared)?
                    }
                }
            }
        };
        Ok(self.counted(state))
    }
}

/// Relative miss of the load that is sought, and that which may be left to the last linear step. What a method without a grid
/// answers is a law without noise; a field that is written shall be that of the depth beside it.
pub(crate) fn close(settings: &Settings, method: Method) -> [f64; 2] {
    match method {
        Method::ClosedForm => [1e-12; 2],
        Method::Ritz | Method::Fabrikant => [3e-3 * settings.tolerance; 2],
        _ if settings.outputs.pressure || settings.outputs.gap => [1e-7, 0.3 * settings.tolerance],
        _ => [0.3 * settings.tolerance; 2],
    }
}
