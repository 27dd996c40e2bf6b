//! The exact contact at one depth: grids that become finer until the force is known to the tolerance.

mod error;
mod prescribed;

use error::FINEST_PROVED;
pub(crate) use error::{AS_A_BRACKET, AS_THEY_ARE, REPEATABLE, claimed};

use super::domain::{coarsest, locate, locate_closely, squared};
use super::extrapolation::{self, Ends, Estimate};
use super::refined::Refined;
use super::sharp_edges::{self, CutCells, Edge};
use super::single_grid::{GridOptions, GridState, laid};
use crate::energy::NoBounds;
use crate::gap::{Degree, Gap, Law};
use crate::grid::{Grid, Kernel, shape};
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;
use crate::problem::{Method, Settings};
use crate::solution::{Unsolved, Verdict};

/// Cells along the longer side that no grid has more of.
const FINEST: usize = 2560;

/// Cells under pressure without which an energy tells nothing of the next.
const FEWEST: usize = 19;

/// Times that the grids begin anew in a larger box.
const MOST_RESTARTS: usize = 6;

/// Error of the gap on a grid whose force is asked for, relative to the depth: it changes the force by twice that.
pub(super) const PRECISE: [f64; 2] = [5e-8, 1e-8];

/// The same on a grid of which nothing but the energy and a start is taken: it errs by the square.
const PASSING: f64 = 3e-4;

/// Cells along the longer side at which a step of the gap is no longer hoped to be a flank.
const STEPPED: usize = 512;

/// What the error is larger by where the contact ends at steps of the gap: there the forces jump from grid to grid (by up to
/// 1.42 times more than they tell, measured on 60 minima of flat and other punches).
const BESIDE_STEPS: f64 = 1.5;

/// Cells along the longer side from which on an estimate stands where no bounds were had: coarser grids may agree by chance.
const FINE_ENOUGH: usize = 80;

/// The contact at one depth, on grids that double until the estimated error of the force is below the tolerance or no finer
/// one can be had ([`Refined::shortfall`]), or on the prescribed number of cells and half of it.
pub(crate) fn refined(
    scaled: &Scaled,
    settings: &Settings,
    method: Method,
    law: Option<Law>,
) -> Result<Refined, Unsolved> {
    as_far_as(FINEST, scaled, settings, method, law)
}

/// Least overlap that is solved on grids, and the inverse of the largest: values of the gap around it are numbers still, and keep their
/// digits.
const WITHIN_RANGE: f64 = 1e-280;

/// The same of the size of a contact: gaps are made of squares.
const SIZES: f64 = 1e-150;

/// As [`refined`], with at most `finest` cells along the longer side where their number is not prescribed: the best that
/// can be had of them, whether or not that meets the tolerance.
pub(crate) fn as_far_as(
    finest: usize,
    scaled: &Scaled,
    settings: &Settings,
    method: Method,
    law: Option<Law>,
) -> Result<Refined, Unsolved> {
    if !(WITHIN_RANGE..=1.0 / WITHIN_RANGE).contains(&scaled.units.height) {
        let reason = "the overlap of the bodies is beyond 1e-280 to 1e280, where numbers keep their digits";
        return Err(Unsolved::new(Verdict::Incomplete, reason).with_hint("units in which lengths are closer to 1"));
    }
    if !(SIZES..=1.0 / SIZES).contains(&scaled.units.length) {
        let reason = "the size of the contact is beyond 1e-150 to 1e150, where its square keeps its digits";
        return Err(Unsolved::new(Verdict::Incomplete, reason).with_hint("units in which lengths are closer to 1"));
    }
    let degree = law.filter(|_| settings.kernel == Kernel::Galerkin).map(|law| law.degree);
    // Grids of energies begin anew in a larger box.
    let closely = settings.cells.is_none() && matches!(degree, Some(Degree::Power(_)));
    let window = if closely { locate_closely(scaled)? } else { locate(scaled)? };
    let (forces, energies) = (Vec::new(), Vec::new());
    let law = degree.map(|degree| {
        let ends = match degree {
            Degree::Flat => Ends::Edges,
            Degree::Power(1.0) if scaled.gap.planes().is_some() || scaled.gap.ridges().is_some() => Ends::Corners,
            Degree::Power(k) if k < 1.0 => Ends::Tip(k),
            Degree::Power(_) => Ends::Unknown,
        };
        (degree, ends)
    });
    let refinement = Refinement {
        scaled,
        settings,
        method,
        law,
        finest,
        window,
        forces,
        energies,
        times: None,
        expected: None,
        spent: (0, 0),
    };
    let best = match settings.cells {
        Some(cells) => refinement.prescribed(cells)?,
        None => refinement.adaptive()?,
    };
    // The scaled opens only when the bodies overlap somewhere, so they do touch.
    let best = best.filter(|b| b.force > 0.0).ok_or_else(|| {
        let reason = "the bodies overlap, but no cell does as a whole: the grid is too coarse to see the contact";
        Unsolved::new(Verdict::ToleranceNotReached, reason)
    })?;
    // What was cut short may be good by chance, and seen not to be.
    let short = || best.shortfall(settings).or_else(|| best.stopped.clone());
    best.is_consistent(scaled, degree)
        .map_err(|broken| short().map_or(broken.clone(), |short| short.without_numbers(&broken)))?;
    Ok(best)
}

/// Grids that become finer, and what they found.
struct Refinement<'a> {
    scaled: &'a Scaled,
    settings: &'a Settings,
    method: Method,
    /// The homogeneity that gives the force from the energy, and how that converges.
    law: Option<(Degree, Ends)>,
    finest: usize,
    window: Rect,
    forces: Vec<f64>,
    energies: Vec<f64>,
    /// Cells along a side of the last grid that had bounds, and how many times too wide those were.
    times: Option<(usize, f64)>,
    /// The same of the last grid whose bounds were not worked out: what was expected of them.
    expected: Option<(usize, NoBounds)>,
    /// Iterations and products of all grids so far.
    spent: (usize, usize),
}

/// Whether a grid is the last one.
enum Step {
    Done(Refined),
    Finer(Refined),
}

/// Cells along the longer side from which on bounds of a force without a law may be narrow enough.
const FEWEST_BOUNDED: usize = 32;

/// How many times as many cells along a side as an estimate takes a proof is worth, and how many more than the order asks for it is given.
const FARTHEST: usize = 6;
const MORE: f64 = 1.03;

/// The least and the largest order with which bounds are taken to narrow: roots of gamma and of the ring that may touch, which have the
/// orders 2 to 3 and 1 (1.3 to 1.7 are seen beside kinks, 1.9 to 3 without).
const ORDERS_OF_BOUNDS: [f64; 2] = [1.3, 2.2];

/// Share of the last step of the energy that the force errs by at least: second order.
const OF_ENERGY: f64 = 1.0 / 3.0;

/// How many times as wide as is within reach bounds are expected to be, from a coarser grid, that are not tried.
const LEEWAY: f64 = 1.5;

/// The same of a force by its energy: gamma is a square.
const ORDER_OF_ENERGY: f64 = 2.0;

impl Refinement<'_> {
    fn adaptive(mut self) -> Result<Option<Refined>, Unsolved> {
        let smooth = matches!(self.law, Some((Degree::Power(_), _)));
        let coarsest = coarsest(self.law.map(|(degree, _)| degree));
        self.window = squared(self.scaled, &self.window, coarsest);
        let (tolerance, finest) = (self.settings.tolerance, self.finest);
        let mut best: Option<Refined> = None;
        let (mut laid, mut restarts, mut next) = (self.window, 0, 0);
        while coarsest << next <= finest {
            let (level, cells) = (next, coarsest << next);
            next += 1;
            // Whole cells become quarters: the grids are of one family, and each starts where the last one ended.
            let nested = |window: &Rect| shape(window, coarsest).map(|n| n << level);
            // With two grids before it, it may be the last.
            let last = !smooth || coarsest << next > finest || self.energies.len() >= 2;
            let gap_error = if last { (1e-4 * tolerance).clamp(PRECISE[1], PRECISE[0]) } else { PASSING };
            let state = match self.grid(nested, gap_error, best.as_ref().map(|b| &b.state)) {
                // The grid before was the finest that this method can hold, or that there was time for.
                Err(e) if matches!(e.verdict, Verdict::TooLarge | Verdict::TimeLimit) && best.is_some() => {
                    // One step alone may be small by luck.
                    let step = if let [before, last] = self.energies[..] { (last - before).abs() } else { 0.0 };
                    return Ok(best.map(|b| Refined { error: b.error.max(step), stopped: Some(e), ..b }));
                }
                other => other?,
            };
            if state.force() <= 0.0 {
                // No cell overlaps as a whole: the grid is too coarse to tell anything.
                continue;
            }
            let loaded = state.solution.pressure.iter().filter(|&&p| p > 0.0).count();
            if smooth && level > 0 && self.window != laid && restarts < MOST_RESTARTS {
                // Grids of another box are of another family.
                self.energies.clear();
                self.window = squared(self.scaled, &self.window, coarsest);
                (laid, restarts, next, best) = (self.window, restarts + 1, 0, None);
                continue;
            }
            laid = self.window;
            let few = smooth && loaded < FEWEST;
            let Estimate { value, mut error } =
                if few { Estimate { value: state.force(), error: state.force() } } else { self.limit(&state) };
            let three = if smooth { self.energies.len() >= 3 } else { self.forces.len() >= 3 };
            // Three grids may agree on a limit that is not the punch's while its edges lie between two rows of cells.
            let edge = if three && !smooth { sharp_edges::boundary_type(self.scaled, &state) } else { None };
            // Forces may seem to converge while an edge falls between two cells: a grid is believed when means over cells and
            // values at their centres agree on it. Where the material ends it is not asked for alone.
            if self.law.is_none() && three && error <= tolerance * value && edge != Some(Edge::End) {
                error = error.max(self.kernel_difference(&state)?);
            }
            if edge.is_some() && self.law.is_none() {
                error = error.max(extrapolation::left_by_first_order(&self.forces));
            }
            if edge == Some(Edge::Step) {
                error *= BESIDE_STEPS;
            }
            // So may the forces of coarse grids, by where the contact ends between cells.
            if self.law.is_none() && cells < FINE_ENOUGH {
                error = error.max(extrapolation::left_by_first_order(&self.forces));
            }
            // Forces may come to rest by chance. Energies come from below alone: what they still change by is not yet in the force either.
            if let Some(before) = best.as_ref().filter(|_| self.law.is_none()) {
                let change = (1.0 - before.state.energy() / state.energy()).abs();
                error = error.max(OF_ENERGY * change * value);
            }
            // One step alone may be small by luck.
            let close = error <= tolerance * value && three;
            let good = close && edge != Some(Edge::End);
            if edge == Some(Edge::End) {
                // What falls with the first power of the cells, at edges, and what jumps, at other ends, may cancel on a few grids.
                return match self.at_sharp_edges(CutCells::of(self.scaled, &state).aligned) {
                    // Without a line this grid stands alone.
                    Err(e) if matches!(e.verdict, Verdict::TooLarge | Verdict::TimeLimit) => {
                        let error = self.error_as_given(&state, Estimate { value, error })?;
                        Ok(Some(Refined { stopped: Some(e), ..Refined::of(state, error) }))
                    }
                    found => found.map(Some),
                };
            }
            if !good && edge == Some(Edge::Step) && cells == STEPPED {
                // A flank may be resolved yet: only if a line does better than that, which knows nothing of flanks.
                let flanks = sharp_edges::on_flanks(self.scaled, &state);
                let tried = if flanks < tolerance { self.at_sharp_edges(false).ok() } else { None };
                let tried = tried.map(|found| Refined { error: found.error + flanks * found.force, ..found });
                // A line that leaves what these grids allow is not that of a step.
                let room = extrapolation::left_by_first_order(&self.forces);
                let possible = |found: &Refined| (found.force - value).abs() <= room + found.error;
                if let Some(found) = tried.filter(|found| found.is_within(tolerance) && possible(found)) {
                    return Ok(Some(found));
                }
            }
            let grids = if few { 1 } else { self.energies.len().max(1) };
            let coarser =
                best.take().map(|b| Box::new(b.state)).filter(|c| c.problem.grid.shape != state.problem.grid.shape);
            let sums = if few { vec![state.force()] } else { self.forces.clone() };
            let found = Refined {
                state,
                coarser,
                force: value,
                error,
                grids,
                stopped: None,
                sequence: None,
                proved: None,
                sums,
            };
            // What the energy of this grid leaves is about what its bounds are off by: the next grid may leave little enough. (Of a singular
            // tip bounds are hardly ever had.)
            let short = match self.law {
                None | Some((_, Ends::Tip(_))) => 0.0,
                Some(_) => self.energies.last().map_or(0.0, |low| value - low),
            };
            match self.bounded(found, good, cells, short)? {
                Step::Done(found) => return Ok(Some(found)),
                Step::Finer(found) => best = Some(found),
            }
        }
        Ok(best)
    }

    /// With proved bounds of the force, as far as they can be had: of this grid, else, once the estimate is `good`, of those that are
    /// expected to be fine enough. `short`: what the energy of this grid leaves of a force that follows a law.
    fn bounded(&mut self, mut found: Refined, good: bool, mut cells: usize, short: f64) -> Result<Step, Unsolved> {
        let (tolerance, lawful) = (self.settings.tolerance, self.law.is_some());
        let step = |found: Refined, last: bool| Ok(if last { Step::Done(found) } else { Step::Finer(found) });
        let wanted = if lawful { good } else { cells >= FEWEST_BOUNDED };
        if !wanted || self.provable().is_none() {
            return step(found, good);
        }
        let finest = FINEST_PROVED.min(self.finest).min(if lawful { usize::MAX } else { FARTHEST * cells });
        let finer = |cells: usize, times: f64, order: f64| {
            let finer = (MORE * cells as f64 * times.powf(1.0 / order) / 8.0).ceil() * 8.0;
            (finer <= finest as f64).then_some(finer as usize)
        };
        // How many times as many cells along a side there may be.
        let reach = |cells: usize| if good { finest as f64 / (MORE * cells as f64) } else { 0.0 };
        let expected = short / (tolerance * found.force);
        let mut next = finer(cells, expected, ORDER_OF_ENERGY).filter(|_| expected > 1.0);
        // Should there be no time for the next grid, this one stands by its energy and by its pressures.
        let mut alone = found.error.max(short).max((found.state.force() - found.force).abs());
        loop {
            if next.is_none() {
                let (times, order) = match self.bounds_within(&found.state, cells, reach(cells)) {
                    Some(Ok(bounds)) => {
                        found = found.bounded_by(bounds, tolerance);
                        let times = (bounds[1] - bounds[0]) / (tolerance * (bounds[1] + bounds[0]));
                        if times <= 1.0 {
                            return Ok(Step::Done(found));
                        }
                        (times, if lawful { ORDER_OF_ENERGY } else { self.order_of_bounds(cells, times) })
                    }
                    Some(Err(NoBounds { times, order })) if !lawful => (times, order),
                    // An estimate stands without bounds on a fine grid.
                    _ => return step(found, good && (!lawful || cells >= FINE_ENOUGH)),
                };
                (next, alone) = (finer(cells, times, order), found.error);
            }
            let Some(n) = next.take().filter(|_| good) else { return step(found, good) };
            cells = n;
            let state = match self.grid(|window| shape(window, cells), PRECISE[0], None) {
                Err(e) if matches!(e.verdict, Verdict::TooLarge | Verdict::TimeLimit) => {
                    let found = Refined { error: alone, ..found };
                    let stopped = if found.is_within(tolerance) { None } else { Some(e) };
                    return Ok(Step::Done(Refined { stopped, ..found }));
                }
                other => other?,
            };
            found = found.on_finer(state, lawful);
        }
    }

    /// [`Refinement::proved`] where bounds are of use as they are, unless what was expected of a coarser grid leaves no hope that this one or
    /// any of up to `reach` times as many cells along a side is enough.
    fn bounds_within(&mut self, state: &GridState, cells: usize, reach: f64) -> Option<Result<[f64; 2], NoBounds>> {
        let narrowed = |(n, NoBounds { times, order }): (usize, NoBounds)| NoBounds {
            times: times * (n as f64 / cells as f64).powf(order),
            order,
        };
        let hopeless = |NoBounds { times, order }: &NoBounds| *times > LEEWAY * reach.powf(*order).max(AS_THEY_ARE);
        if let Some(expected) = self.expected.map(narrowed).filter(hopeless) {
            return Some(Err(expected));
        }
        let found = self.proved(state, AS_THEY_ARE);
        if let Some(Err(expected)) = &found {
            self.expected = Some((cells, *expected)).filter(|(_, expected)| expected.times.is_finite());
        }
        found
    }

    /// The order that bounds are seen to narrow with from grid to grid, or that was expected of a coarser one.
    fn order_of_bounds(&mut self, cells: usize, times: f64) -> f64 {
        let before = self.times.replace((cells, times));
        let seen = before.map(|(n, t)| (t / times).ln() / (cells as f64 / n as f64).ln());
        let expected = || self.expected.map_or(ORDERS_OF_BOUNDS[0], |(_, expected)| expected.order);
        seen.filter(|order| order.is_finite()).unwrap_or_else(expected).clamp(ORDERS_OF_BOUNDS[0], ORDERS_OF_BOUNDS[1])
    }

    /// The next grid, with what all took so far, from a coarser one where its cells are quarters of that.
    fn grid(
        &mut self,
        shape: impl Fn(&Rect) -> [usize; 2],
        tolerance: f64,
        coarser: Option<&GridState>,
    ) -> Result<GridState, Unsolved> {
        let options = GridOptions { tolerance, coarser, ..GridOptions::precise(self.settings, self.method) };
        let state = laid(self.scaled, &mut self.window, |window| Grid::over(window, shape(window)), options)?;
        Ok(self.with_spent(state))
    }

    fn with_spent(&mut self, mut state: GridState) -> GridState {
        self.spent = (self.spent.0 + state.iterations, self.spent.1 + state.operator_products);
        (state.iterations, state.operator_products) = self.spent;
        state
    }

    /// The limit of grids fitted by a line; see [`edges`].
    fn at_sharp_edges(&mut self, aligned: bool) -> Result<Refined, Unsolved> {
        let Self { scaled, settings, method, finest, .. } = *self;
        let (sequence, limit, stopped) =
            sharp_edges::sequence(scaled, &mut self.window, aligned, finest, settings, method)?;
        let (iterations, operator_products) = sequence.spent();
        let mut state = self.with_spent(GridState { iterations, operator_products, ..sequence.last().clone() });
        state.remarks.push(sharp_edges::remark(sequence.grids()));
        let most = || {
            Unsolved::new(
                Verdict::ToleranceNotReached,
                sharp_edges::most(sharp_edges::finest(finest, &scaled.gap, settings.tolerance)),
            )
        };
        let stopped = stopped.or_else(|| Some(most()));
        let grids = sequence.grids();
        let (force, error) = (limit.value, limit.error);
        let sums = sequence.sums();
        Ok(Refined { state, coarser: None, force, error, grids, stopped, sequence: Some(sequence), proved: None, sums })
    }
}
