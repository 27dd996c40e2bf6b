//! The sharp bracket: solve again with what the last pressure failed by, a few times, then close.
//!
//! By reciprocity raising the right-hand side by v(x) costs the mean of v weighted with the pressure of a flat punch on the
//! contact, where closing costs its maximum. On the lower side the support never grows: a cell that is taken in again is
//! thrown out in the next round. Less support costs little, since P(A) is stationary at the true contact.

use super::field::{Field, Surroundings};
use super::gap_bounds::GapBounds;
use super::mirrors::Mirrors;
use super::problem::{self, BracketProblem};
use super::repair::{self, Repaired};
use super::suprema::{BoundState, suprema};
use super::violation::{self, Violation};
use super::{BracketCost, BracketSettings, Evidence, ForceBracket, evaluate, exterior};
use crate::clock::Stopwatch;
use crate::discrete::Discrete;
use crate::gap::{AnyGap, Gap};
use crate::grid::{Kernel, Pressure};
use crate::matrix_free;
use crate::problem::EffectiveModulus;
use crate::solution::Unsolved;

/// Largest residual of a solve, as a share of the largest violation that it is to make good.
const SHARE: f64 = 0.03;

/// Another round is worth its price when closing still takes this share of the distance between the bounds.
const PAYS: f64 = 0.35;

/// A round that gained no more than this share is the last.
const GAINS: f64 = 0.3;

/// As [`super::certify`], and narrower: each side is solved again for, at most `settings.rounds` times.
///
/// # Errors
/// As [`super::certify`].
///
/// ```
/// use contact_patch::bracket::{self, BracketSettings};
/// use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, gap::Cone, geometry::Rect, matrix_free};
/// let gap = Cone::with_slope(1.0)?;
/// let grid = Grid::over(&Rect::around([0.0; 2], [0.75; 2]), [64, 64]);
/// let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
/// let values = matrix_free::solve(&problem, None, &matrix_free::Settings::default())?.pressure;
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let pressure = Pressure { grid, values };
/// let bracket = bracket::sharp(&gap, modulus, 1.0, &pressure, &BracketSettings::default())?;
/// assert!(bracket.contains(2.0 / std::f64::consts::PI) && bracket.relative_width() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sharp(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    settings: &BracketSettings,
) -> Result<ForceBracket, Unsolved> {
    let gap = &gap.into();
    problem::within(gap, modulus, depth, pressure, |problem, mut q| {
        let started = Stopwatch::start();
        let mirrors = Mirrors::found(&mut q, problem);
        let mut session = Session {
            around: Surroundings::new(&problem.grid, settings.per_cell.max(1)),
            state: BoundState {
                known: GapBounds::new(q.len(), true),
                closely: vec![evaluate::QUARTERED; q.len()],
                mirrors,
                prove: settings.prove,
            },
            problem,
            settings,
            cost: BracketCost::default(),
            evidence: Evidence::Proved,
        };
        let (field, first) = session.look(&q, violation::Side::Both);
        let exterior = exterior::uncovered(problem, &q);
        let upper = (repair::upper(problem, &q, &first, &exterior), q.clone());
        let lower = (repair::lower(problem, &q, &first), q);
        let upper = session.raise(upper, (&field, &first), lower.0.force);
        let lower = session.lower(lower, (&field, &first), upper.0.force);
        session.cost.seconds = started.seconds();
        ForceBracket {
            lower: lower.0.side(problem, &lower.1, session.evidence),
            upper: upper.0.side(problem, &upper.1, session.evidence),
            cost: session.cost,
        }
    })
}

struct Session<'a> {
    around: Surroundings,
    state: BoundState,
    problem: &'a BracketProblem,
    settings: &'a BracketSettings,
    cost: BracketCost,
    evidence: Evidence,
}

impl Session<'_> {
    fn look(&mut self, q: &[f64], side: violation::Side) -> (Field, Violation) {
        let (field, found, evidence) = suprema(self.problem, &mut self.around, q, side, &mut self.state);
        self.evidence = evidence;
        self.cost.products += 1;
        (field, found)
    }

    /// The pressure for these overlaps, good to a share of the violation that they make good; `None` when the solver gives
    /// up or the time is used up. From nothing: on nested grids that is quicker than from a pressure near by.
    fn solve(&mut self, overlap: Vec<f64>, violation: f64) -> Option<Vec<f64>> {
        let problem = Discrete { grid: self.problem.grid, kernel: Kernel::Collocation, overlap };
        let tolerance = (SHARE * violation / self.problem.depth.abs()).clamp(1e-9, 1e-3);
        let settings = matrix_free::Settings {
            tolerance,
            threads: self.settings.threads,
            deadline: self.settings.deadline,
            ..Default::default()
        };
        if settings.deadline.has_passed() {
            return None;
        }
        self.cost.solves += 1;
        let solved = matrix_free::solve_nested(&problem, &settings).ok()?;
        let mut q = solved.pressure;
        self.state.mirrors.even_out(&mut q);
        Some(q)
    }

    /// f at the centre of a cell, or, where there is no material, the most of it in the cell.
    fn overlap(&self, k: usize) -> f64 {
        let [x, y] = self.problem.grid.centre_of(k);
        let f = self.problem.depth - self.problem.gap.gap(x, y);
        let nx = self.problem.grid.shape[0];
        if f.is_finite() { f } else { self.problem.most_overlap(&self.problem.grid.cell(k % nx, k / nx)) }
    }

    fn raise(&mut self, first: (Repaired, Vec<f64>), look: (&Field, &Violation), other: f64) -> (Repaired, Vec<f64>) {
        let nx = self.problem.grid.shape[0];
        let mut best = first;
        let mut q = best.1.clone();
        let mut aim: Vec<f64> = (0..q.len()).map(|k| self.overlap(k)).collect();
        let mut again: Option<(Field, Violation)> = None;
        for _ in 0..self.settings.rounds {
            let (field, found) = again.as_ref().map_or(look, |(field, found)| (field, found));
            for k in 0..q.len() {
                let over = found.over[k];
                if over > f64::NEG_INFINITY && (q[k] > 0.0 || over > 0.0) {
                    aim[k] = field.at_centre(k % nx, k / nx) + over;
                }
            }
            let worst = found.over.iter().copied().fold(0.0, f64::max);
            let Some(next) = self.solve(aim.clone(), worst) else { break };
            q = next;
            let (field, found) = self.look(&q, violation::Side::Upper);
            let exterior = exterior::uncovered(self.problem, &q);
            let repaired = repair::upper(self.problem, &q, &found, &exterior);
            let repair = repaired.force - self.carried(&q);
            let gained = best.0.force - repaired.force;
            if gained > 0.0 {
                best = (repaired, q.clone());
            }
            let width = best.0.force - other;
            if repair < PAYS * width || gained < GAINS * width {
                break;
            }
            again = Some((field, found));
        }
        best
    }

    fn lower(&mut self, first: (Repaired, Vec<f64>), look: (&Field, &Violation), other: f64) -> (Repaired, Vec<f64>) {
        let nx = self.problem.grid.shape[0];
        let mut best = first;
        let mut q = best.1.clone();
        let mut again: Option<(Field, Violation)> = None;
        let mut support = vec![true; q.len()];
        for _ in 0..self.settings.rounds {
            let (field, found) = again.as_ref().map_or(look, |(field, found)| (field, found));
            let mut worst = 0.0_f64;
            let aim: Vec<f64> = (0..q.len())
                .map(|k| {
                    let under = found.under[k];
                    support[k] = support[k] && q[k] > 0.0 && under < f64::INFINITY;
                    if !support[k] {
                        return f64::NEG_INFINITY;
                    }
                    worst = worst.max(under);
                    field.at_centre(k % nx, k / nx) - under
                })
                .collect();
            let Some(next) = self.solve(aim, worst) else { break };
            q = next;
            let (field, found) = self.look(&q, violation::Side::Lower);
            let repaired = repair::lower(self.problem, &q, &found);
            let repair = self.carried(&q) - repaired.force;
            let gained = repaired.force - best.0.force;
            if gained > 0.0 {
                best = (repaired, q.clone());
            }
            let width = other - best.0.force;
            if repair < PAYS * width || gained < GAINS * width {
                break;
            }
            again = Some((field, found));
        }
        best
    }

    fn carried(&self, q: &[f64]) -> f64 {
        q.iter().sum::<f64>() * self.problem.grid.cell_area()
    }
}
