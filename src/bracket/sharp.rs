//! The sharp bracket: solve again with what the last pressure failed by, a few times, then close.
//!
//! By reciprocity raising the right-hand side by v(x) costs the mean of v weighted with the pressure of a flat punch on the
//! contact, where closing costs its maximum. On the lower side the support never grows: a cell that is taken in again is
//! thrown out in the next round. Less support costs little, since P(A) is stationary at the true contact.

use std::time::Instant;

use super::close::{self, Closed};
use super::displacement::Lattice;
use super::frame::{self, Frame};
use super::violation::Violation;
use super::{BracketCost, BracketSettings, Evidence, ForceBracket, outside};
use crate::discrete::Discrete;
use crate::error::Unsolved;
use crate::gap::Gap;
use crate::grid::{Kernel, Pressure};
use crate::material::EffectiveModulus;
use crate::matrix_free;

/// Tolerance of the solves, relative to the depth: below every violation that a grid leaves.
const TOLERANCE: f64 = 1e-6;

/// Points along a side of a cell between the first look and the last: what they miss is taken to stay as it was.
const FEW: usize = 2;

/// A last round is worth its price when closing still takes this share of the distance between the bounds.
const PAYS: f64 = 0.08;

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
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    settings: &BracketSettings,
) -> Result<ForceBracket, Unsolved> {
    frame::within(gap, modulus, depth, pressure, |frame, q| {
        let started = Instant::now();
        let mut session = Session {
            lattice: Lattice::new(frame.grid.spacing, frame.grid.shape),
            frame,
            settings,
            cost: BracketCost::default(),
            evidence: Evidence::Proved,
        };
        let first = session.look(&q);
        let outside = outside::look(frame, &q);
        let upper = (close::upper(frame, &q, &first, &outside), q.clone());
        let lower = (close::lower(frame, &q, &first), q);
        let upper = session.raise(upper, &first, lower.0.force);
        let lower = session.lower(lower, &first, upper.0.force);
        session.cost.seconds = started.elapsed().as_secs_f64();
        ForceBracket {
            lower: frame.side(lower.0, &lower.1, session.evidence),
            upper: frame.side(upper.0, &upper.1, session.evidence),
            cost: session.cost,
        }
    })
}

struct Session<'a, 'f> {
    lattice: Lattice,
    frame: &'a Frame<'f>,
    settings: &'a BracketSettings,
    cost: BracketCost,
    evidence: Evidence,
}

impl Session<'_, '_> {
    fn look(&mut self, q: &[f64]) -> Violation {
        let (found, evidence) = self.frame.look(&mut self.lattice, q, self.settings);
        self.evidence = evidence;
        self.cost.products += found.products;
        found
    }

    /// Pressure and displacement at the centres for these overlaps; `None` when the solver gives up.
    fn solve(&mut self, overlap: &[f64], start: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let problem = Discrete { grid: self.frame.grid, kernel: Kernel::Collocation, overlap: overlap.to_vec() };
        let settings =
            matrix_free::Settings { tolerance: TOLERANCE, threads: self.settings.threads, ..Default::default() };
        self.cost.solves += 1;
        let solved = matrix_free::solve(&problem, Some(start), &settings).ok()?;
        Some((solved.pressure, solved.displacement))
    }

    /// f at the centre of a cell, or, where there is no material, the most of it in the cell.
    fn overlap(&self, k: usize) -> f64 {
        let [x, y] = self.frame.grid.centre_of(k);
        let f = self.frame.depth - self.frame.gap.gap(x, y);
        let nx = self.frame.grid.shape[0];
        if f.is_finite() { f } else { self.frame.most_overlap(&self.frame.grid.cell(k % nx, k / nx)) }
    }

    /// Displacement at the centres.
    fn displacement(&mut self, q: &[f64]) -> Vec<f64> {
        let spectrum = self.lattice.pressure(q);
        let layer = self.lattice.layer(&spectrum, [0.5, 0.5], false);
        self.cost.products += 1;
        let nx = self.frame.grid.shape[0];
        (0..q.len()).map(|k| layer.u[k / nx * (nx + 1) + k % nx]).collect()
    }

    /// Suprema on few points.
    fn glance(&mut self, q: &[f64]) -> Violation {
        let found = Violation::sampled(self.frame, &mut self.lattice, q, FEW.min(self.settings.per_cell.max(1)));
        self.cost.products += found.products;
        found
    }

    fn raise(&mut self, first: (Closed, Vec<f64>), found: &Violation, other: f64) -> (Closed, Vec<f64>) {
        let mut overlap: Vec<f64> = (0..self.frame.grid.len()).map(|k| self.overlap(k)).collect();
        let mut q = first.1.clone();
        let mut u = self.displacement(&q);
        let mut over = found.over.clone();
        let missed = missed(&over, &self.glance(&q).over);
        let mut best = first;
        let rounds = self.settings.rounds;
        for round in 1..=rounds {
            for k in 0..overlap.len() {
                if over[k] > f64::NEG_INFINITY && (q[k] > 0.0 || over[k] > 0.0) {
                    overlap[k] = u[k] + over[k];
                }
            }
            let Some(solved) = self.solve(&overlap, &q) else { break };
            (q, u) = solved;
            if round + 1 < rounds {
                over = self.glance(&q).over;
                over.iter_mut().zip(&missed).for_each(|(over, missed)| *over += missed);
                continue;
            }
            let found = self.look(&q);
            let outside = outside::look(self.frame, &q);
            let closed = close::upper(self.frame, &q, &found, &outside);
            over = found.over;
            let repair = closed.force - self.carried(&q);
            if closed.force < best.0.force {
                best = (closed, q.clone());
            }
            if repair < PAYS * (best.0.force - other) {
                break;
            }
        }
        best
    }

    fn lower(&mut self, first: (Closed, Vec<f64>), found: &Violation, other: f64) -> (Closed, Vec<f64>) {
        let mut q = first.1.clone();
        let mut u = self.displacement(&q);
        let mut under = found.under.clone();
        let missed = missed(&under, &self.glance(&q).under);
        let mut best = first;
        let mut support: Vec<bool> = (0..q.len()).map(|k| q[k] > 0.0 && under[k] < f64::INFINITY).collect();
        let rounds = self.settings.rounds;
        for round in 1..=rounds {
            let overlap: Vec<f64> =
                (0..q.len()).map(|k| if support[k] { u[k] - under[k] } else { f64::NEG_INFINITY }).collect();
            let Some(solved) = self.solve(&overlap, &q) else { break };
            (q, u) = solved;
            let mut repair = f64::INFINITY;
            if round + 1 < rounds {
                under = self.glance(&q).under;
                under.iter_mut().zip(&missed).for_each(|(under, missed)| *under += missed);
            } else {
                let found = self.look(&q);
                let closed = close::lower(self.frame, &q, &found);
                under = found.under;
                repair = self.carried(&q) - closed.force;
                if closed.force > best.0.force {
                    best = (closed, q.clone());
                }
            }
            for k in 0..q.len() {
                support[k] = support[k] && q[k] > 0.0 && under[k] < f64::INFINITY;
            }
            if repair < PAYS * (other - best.0.force) {
                break;
            }
        }
        best
    }

    fn carried(&self, q: &[f64]) -> f64 {
        q.iter().sum::<f64>() * self.frame.grid.cell_area()
    }
}

/// What few points missed of each supremum.
fn missed(full: &[f64], few: &[f64]) -> Vec<f64> {
    full.iter().zip(few).map(|(a, b)| if a.is_finite() && b.is_finite() { (a - b).max(0.0) } else { 0.0 }).collect()
}
