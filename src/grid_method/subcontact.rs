//! One of several contacts that lie far apart, solved on the gap that the loads of the others have left.

use super::contact_loads::{ContactLoads, PointLoads};
use super::dimensional::at_least;
use super::displaced::DisplacedGap;
use super::expansion::{expanded, touches_border};
use super::refined::Refined;
use super::refinement::{self, PRECISE};
use super::single_grid::{self, GridState};
use crate::discrete::Discrete;
use crate::gap::AnyGap;
use crate::matrix_free;
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, Scaled};
use crate::problem::{Method, Settings};
use crate::solution::Unsolved;

/// Cells along the longer side of a grid that only has to tell what a contact does to the others.
const ROUGH_CELLS: usize = 32;

/// How closely a change of the gap is resolved, in that change; and the least and the largest error of the gap, relative to the depth.
const OF_CHANGE: f64 = 1e-3;
const GAP_ERROR: [f64; 2] = [PRECISE[0], 1e-5];

/// How far the gap may have moved since its grids were laid, in the deepest overlap; and where they are rough.
const MOVED: f64 = 0.05;
const ROUGHLY_MOVED: f64 = 0.5;

/// What the grids of a contact are to tell.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Cells {
    /// What it does to the others.
    Rough,
    /// Its force, to the tolerance.
    Fine,
}

/// A contact, its grids, and where it has been moved to since they were laid.
pub(super) struct Subcontact {
    gap: AnyGap,
    pub cells: Cells,
    within: Rect,
    pub depth: f64,
    displaced: DisplacedGap,
    /// `None` when the others have pushed the surface out of reach.
    pub solved: Option<Solved>,
    pub loads: ContactLoads,
    /// What the gap has changed by since the grids were laid, in the deepest overlap.
    shift: f64,
}

/// A contact in units of its own.
pub(super) struct Solved {
    pub scaled: Scaled,
    pub refined: Refined,
}

impl Solved {
    /// The loads of pressures on the cells of the finest grid, in the user's frame.
    pub fn loads(&self, pressure: impl Fn(usize) -> f64) -> ContactLoads {
        ContactLoads::new(cell_loads(&self.scaled, &self.refined, pressure))
    }

    /// The loads of the pressure: the finest grid carries the force of all of them together.
    fn own_loads(&self) -> ContactLoads {
        let share = self.refined.force / self.refined.state.force();
        self.loads(|k| self.refined.state.solution.pressure[k] * share)
    }

    /// Where its grid lies in the user's frame.
    pub fn extent(&self) -> Rect {
        self.scaled.units.rect_outward(&self.refined.state.problem.grid.extent())
    }

    /// Relative error of the stiffness by its grids.
    pub fn stiffness_error(&self) -> Result<Option<f64>, Unsolved> {
        let [(_, error)] = self.refined.estimated(|state| Ok([single_grid::stiffness(state)?]))?;
        Ok(error.map(|change| at_least(&self.refined, change) + self.refined.error / self.refined.force))
    }
}

/// The loads of pressures in the user's frame, one of each cell.
pub(super) fn cell_loads(scaled: &Scaled, refined: &Refined, pressure: impl Fn(usize) -> f64) -> PointLoads {
    let grid = &refined.state.problem.grid;
    let unit = scaled.units.height * scaled.units.length * grid.cell_area();
    let load = |k: usize| (scaled.units.outward(grid.centre_of(k)), pressure(k) * unit);
    (0..grid.len()).map(load).filter(|load| load.1 != 0.0).collect()
}

impl Subcontact {
    /// On grids of its own.
    pub fn solve<'a>(
        gap: &AnyGap,
        depth: f64,
        within: Rect,
        others: impl IntoIterator<Item = &'a ContactLoads>,
        settings: &Settings,
        cells: Cells,
    ) -> Result<Self, Unsolved> {
        let displaced = DisplacedGap::new(gap.clone(), within, others);
        let solved = match Overlap::of(&AnyGap::new(displaced.clone()), depth)? {
            None => None,
            Some(overlap) => {
                let scaled = overlap.scaled();
                let roughly = || refinement::as_far_as(ROUGH_CELLS, &scaled, settings, Method::Fft, None).ok();
                let rough = if cells == Cells::Rough { roughly() } else { None };
                let refined = rough.map_or_else(|| refinement::refined(&scaled, settings, Method::Fft, None), Ok)?;
                Some(Solved { scaled, refined })
            }
        };
        let loads = solved.as_ref().map(Solved::own_loads).unwrap_or_default();
        Ok(Self { gap: gap.clone(), cells, within, depth, displaced, solved, loads, shift: 0.0 })
    }

    /// On the same cells at another depth, which it has all of `within` at, and under other loads; `None` where they do not hold the contact,
    /// or do not tell it alone.
    pub fn moved<'a>(
        &self,
        gap: &AnyGap,
        depth: f64,
        within: Rect,
        others: impl IntoIterator<Item = &'a ContactLoads>,
        settings: &Settings,
    ) -> Result<Option<Self>, Unsolved> {
        let Some(Solved { scaled, refined }) = &self.solved else { return Ok(None) };
        if refined.sequence.is_some() {
            return Ok(None);
        }
        let displaced = DisplacedGap::new(gap.clone(), within, others);
        let units = scaled.units;
        let again = |before: &GridState| {
            let grid = units.grid_outward(&before.problem.grid);
            let apart = displaced.displacements(&grid).into_iter().zip(self.displaced.displacements(&grid));
            let deeper: Vec<f64> = apart.map(|(now, then)| (depth - self.depth + then - now) / units.height).collect();
            let pressed = deeper.iter().zip(&before.solution.pressure).filter(|(_, p)| **p > 0.0);
            let most = pressed.fold(0.0, |most: f64, (by, _)| most.max(by.abs()));
            let overlap = before.problem.overlap.iter().zip(&deeper).map(|(f, by)| f + by).collect();
            let problem = Discrete { grid: before.problem.grid, kernel: before.problem.kernel, overlap };
            let settings = matrix_free::Settings {
                threads: settings.threads,
                deadline: settings.deadline,
                tolerance: (OF_CHANGE * most).clamp(GAP_ERROR[0], GAP_ERROR[1]),
                ..matrix_free::Settings::default()
            };
            let solution = matrix_free::solve(&problem, Some(&before.solution.pressure), &settings)?;
            let (left_out, remarks) = (before.left_out.clone(), before.remarks.clone());
            let state = GridState { left_out, remarks, ..GridState::of(before.method, problem, solution) };
            Ok::<_, Unsolved>((state, most))
        };
        let (state, shift) = again(&refined.state)?;
        let scaled = Scaled {
            gap: AnyGap::new(displaced.clone()).scaled(units.origin, units.length, units.height),
            depth: depth / units.height,
            reach: if depth > self.depth { units.rect_inward(&within).union(&scaled.reach) } else { scaled.reach },
            ..*scaled
        };
        if state.force() <= 0.0 || touches_border(&scaled, &state.problem.grid, &state.solution.pressure) {
            return Ok(None);
        }
        let coarser = refined.coarser.as_ref().map(|coarser| again(coarser).map(|(state, _)| Box::new(state)));
        let times = state.force() / refined.state.force();
        let refined = Refined {
            force: refined.force * times,
            error: refined.error * times,
            sums: refined.sums.iter().map(|sum| sum * times).collect(),
            state,
            coarser: coarser.transpose()?,
            grids: refined.grids,
            stopped: refined.stopped.clone(),
            sequence: None,
            proved: None,
        };
        let solved = Solved { scaled, refined };
        let (loads, shift) = (solved.own_loads(), self.shift + shift);
        Ok(Some(Self {
            gap: gap.clone(),
            cells: self.cells,
            within,
            depth,
            displaced,
            solved: Some(solved),
            loads,
            shift,
        }))
    }

    /// Whether its cells, once moved, still hold and tell the contact.
    pub fn serves(&self) -> bool {
        let holds = |Solved { scaled, refined }: &Solved| {
            let GridState { problem, solution, .. } = &refined.state;
            expanded(scaled, &problem.grid.extent(), &problem.grid, &solution.pressure).is_none()
        };
        let room = match self.cells {
            Cells::Rough => ROUGHLY_MOVED,
            Cells::Fine => MOVED,
        };
        self.shift == 0.0 || (self.shift <= room && self.solved.as_ref().is_none_or(holds))
    }

    /// By how much, at the most, other loads displace the surface differently from those that it was solved under.
    pub fn displaced_by<'a>(&self, others: impl IntoIterator<Item = &'a ContactLoads>) -> f64 {
        let latest = DisplacedGap::new(self.gap.clone(), self.within, others);
        let points = self.within.corners().into_iter().chain([self.within.centre()]);
        points.map(|p| (latest.displacement(p) - self.displaced.displacement(p)).abs()).fold(0.0, f64::max)
    }

    /// Half of what its load does in the displacement by the others.
    pub fn shared_energy(&self) -> f64 {
        0.5 * self.loads.iter().map(|(p, q)| q * self.displaced.displacement(*p)).sum::<f64>()
    }

    /// What other loads displace at the cells of its grid, in the user's units.
    pub fn displacements<'a>(&self, solved: &Solved, others: impl IntoIterator<Item = &'a ContactLoads>) -> Vec<f64> {
        let grid = solved.scaled.units.grid_outward(&solved.refined.state.problem.grid);
        DisplacedGap::new(self.gap.clone(), self.within, others).displacements(&grid)
    }
}
