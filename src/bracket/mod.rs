//! A certified bracket on the force: lower <= P <= upper, whatever solver the pressure came from.
//!
//! The force is the value of a linear programme, and any admissible point of either side bounds it. With S p the
//! displacement by a pressure p and f = depth - gap the overlap of the undeformed bodies:
//!
//! - q >= 0 and S q >= f where f > 0: then P <= integral of q.
//! - q >= 0 and S q <= f where q > 0: then integral of q <= P (domination).
//!
//! A computed pressure is neither, but nearly so. [`certify`] finds by how much it fails, over the whole plane and not at the
//! nodes alone, and repairs it; [`sharp`] solves again with a right-hand side raised (or lowered) cell by cell by what it
//! failed by, which costs the weighted mean of the failure where the repair costs its maximum.
//!
//! What was proved and what was only sampled is part of the answer: [`Evidence`].

mod between;
mod check;
mod close;
mod displacement;
mod kernel;
mod outside;
mod sharp;
mod violation;

use std::time::Instant;

use crate::error::{Unsolved, Verdict};
use crate::gap::{Gap, Reach, Scaled, extent};
use crate::geometry::Rect;
use crate::grid::{Grid, Pressure};
use crate::material::EffectiveModulus;
use close::Closed;
use displacement::Lattice;
use violation::Violation;

pub use check::{Claim, Verification, check, check_claims};
pub use sharp::sharp;

/// How the suprema were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// Over every point of the plane, rounding included: what lies between lattice points is bounded.
    Proved,
    /// At this many lattice points along each side of a cell: a supremum between them is missed.
    Sampled {
        /// Points along a side of a cell.
        per_cell: usize,
    },
}

/// How the last of the violation was made good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Theorem {
    /// The pressure times a factor is admissible.
    Scaling,
    /// A stack of flat discs under the violation that is left carries at most so much.
    Discs,
    /// The bodies do not touch.
    NoContact,
}

/// One side of a bracket.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    force: f64,
    theorem: Theorem,
    violation: f64,
    at: [f64; 2],
    pressure: Pressure,
}

impl Side {
    /// The bound, in units of force.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.force
    }

    /// How it was closed.
    #[must_use]
    pub fn theorem(&self) -> Theorem {
        self.theorem
    }

    /// Largest violation that the discs had to make good, in units of length; 0 under [`Theorem::Scaling`].
    #[must_use]
    pub fn violation(&self) -> f64 {
        self.violation
    }

    /// Centre of the cell where the pressure violated its condition most, before any repair.
    #[must_use]
    pub fn at(&self) -> [f64; 2] {
        self.at
    }

    /// The pressure that proves the bound, up to the discs: what a checker needs.
    #[must_use]
    pub fn pressure(&self) -> &Pressure {
        &self.pressure
    }
}

/// What a bracket took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BracketCost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Products with a shifted kernel.
    pub products: usize,
    /// Solves on the grid.
    pub solves: usize,
}

/// lower <= P <= upper. Only this module can make one.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceBracket {
    lower: Side,
    upper: Side,
    evidence: Evidence,
    cost: BracketCost,
}

impl ForceBracket {
    /// Lower bound of the force.
    #[must_use]
    pub fn lower(&self) -> f64 {
        self.lower.force
    }

    /// Upper bound of the force.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.upper.force
    }

    /// Upper less lower bound, over their mean; 0 without contact.
    #[must_use]
    pub fn relative_width(&self) -> f64 {
        let mean = 0.5 * (self.lower() + self.upper());
        if mean > 0.0 { (self.upper() - self.lower()) / mean } else { 0.0 }
    }

    /// Whether the force lies in the bracket.
    #[must_use]
    pub fn contains(&self, force: f64) -> bool {
        (self.lower()..=self.upper()).contains(&force)
    }

    /// How the suprema were found.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        self.evidence
    }

    /// The lower bound and its proof.
    #[must_use]
    pub fn lower_side(&self) -> &Side {
        &self.lower
    }

    /// The upper bound and its proof.
    #[must_use]
    pub fn upper_side(&self) -> &Side {
        &self.upper
    }

    /// What it took.
    #[must_use]
    pub fn cost(&self) -> BracketCost {
        self.cost
    }
}

/// How to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BracketSettings {
    /// Lattice points along each side of a cell, at least 1; 4 unless said.
    pub per_cell: usize,
    /// Whether to bound what lies between lattice points where the gap allows it ([`Gap::range`]); yes unless said.
    pub prove: bool,
    /// Most rounds of [`sharp`] on either side; 4 unless said.
    pub rounds: usize,
    /// Threads for the solves of [`sharp`]; 1 unless said.
    pub threads: usize,
}

impl Default for BracketSettings {
    fn default() -> Self {
        Self { per_cell: 4, prove: true, rounds: 4, threads: 1 }
    }
}

/// Bracket on the force of `gap` at `depth` from any pressure on any grid. Negative pressures count as none; a poor pressure
/// gives a wide bracket, never a wrong one.
///
/// Units: any consistent set; `pressure` in the units of E*, on a grid in the units of the gap.
///
/// # Errors
/// [`Verdict::Unbounded`] when the gap stays below the depth without end, [`Verdict::NotApplicable`] when a number of the
/// pressure or of its grid is not finite.
///
/// ```
/// use contact_patch::bracket::{self, BracketSettings, Evidence};
/// use contact_patch::{EffectiveModulus, Grid, Pressure, gap::Paraboloid, geometry::Rect};
/// // Hertz's pressure, sampled on 64 x 64 cells: p = 2/pi sqrt(1 - r^2) for R = 1, d = 1, E* = 1.
/// let grid = Grid::over(&Rect::around([0.0; 2], [1.05; 2]), [64, 64]);
/// let hertz = |[x, y]: [f64; 2]| 2.0 / std::f64::consts::PI * (1.0 - x * x - y * y).max(0.0).sqrt();
/// let pressure = Pressure { grid, values: (0..grid.len()).map(|k| hertz(grid.centre_of(k))).collect() };
/// let gap = Paraboloid::new([1.0, 1.0])?;
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let bracket = bracket::certify(&gap, modulus, 1.0, &pressure, &BracketSettings::default())?;
/// assert!(bracket.contains(4.0 / 3.0) && bracket.relative_width() < 0.1);
/// assert_eq!(bracket.evidence(), Evidence::Proved);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn certify(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    settings: &BracketSettings,
) -> Result<ForceBracket, Unsolved> {
    let started = Instant::now();
    let Some((frame, q)) = Frame::enter(gap, modulus, depth, pressure)? else {
        return Ok(no_contact(pressure));
    };
    let mut lattice = Lattice::new(frame.grid.spacing, frame.grid.shape);
    let (found, evidence) = frame.look(&mut lattice, &q, settings);
    let outside = outside::look(&frame, &q);
    let (upper, lower) = (close::upper(&frame.grid, &q, &found, &outside), close::lower(&frame.grid, &q, &found));
    let cost = BracketCost { seconds: started.elapsed().as_secs_f64(), products: found.products, solves: 0 };
    Ok(ForceBracket { lower: frame.side(lower, &q), upper: frame.side(upper, &q), evidence, cost })
}

fn no_contact(pressure: &Pressure) -> ForceBracket {
    let none = Pressure { grid: pressure.grid, values: vec![0.0; pressure.values.len()] };
    let side = Side { force: 0.0, theorem: Theorem::NoContact, violation: 0.0, at: [0.0; 2], pressure: none };
    ForceBracket { lower: side.clone(), upper: side, evidence: Evidence::Proved, cost: BracketCost::default() }
}

/// The problem with E* = 1 and lengths of order 1: a pressure is proved in these units.
struct Frame<'a> {
    gap: Scaled<'a>,
    depth: f64,
    grid: Grid,
    /// Holds {f > 0}.
    reach: Rect,
    /// Whether that is certain.
    reach_known: bool,
    unit_pressure: f64,
    unit_force: f64,
    given: Grid,
}

impl<'a> Frame<'a> {
    /// The frame and the pressure in it; `None` when the bodies do not touch.
    fn enter(
        gap: &'a dyn Gap,
        modulus: EffectiveModulus,
        depth: f64,
        pressure: &Pressure,
    ) -> Result<Option<(Self, Vec<f64>)>, Unsolved> {
        let given = pressure.grid;
        let numbers = given.origin.iter().chain(&given.spacing).chain(&pressure.values);
        let sides = given.spacing.iter().all(|&h| h > 0.0);
        if !(depth.is_finite() && sides && !given.is_empty() && given.len() == pressure.values.len())
            || numbers.into_iter().any(|v| !v.is_finite())
        {
            let reason = "the pressure needs one finite number a cell, and its cells sides greater than zero";
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        // What is certain may be larger than what is found; a strip of it is not worth a proof.
        let (reach, reach_known) = match gap.certain_reach(depth) {
            Reach::Unknown | Reach::Unbounded => (extent(gap, depth), false),
            Reach::Within(r) if r.size().iter().any(|s| !s.is_finite()) => (extent(gap, depth), false),
            certain => (certain, true),
        };
        let reach = match reach {
            Reach::Within(rect) => rect,
            Reach::Nowhere => return Ok(None),
            Reach::Unbounded | Reach::Unknown => {
                let reason = format!("the gap stays below the depth {depth:e} however far one looks");
                return Err(Unsolved::new(Verdict::Unbounded, reason));
            }
        };
        let [w, h] = given.extent().size();
        let length = 0.5 * w.max(h);
        let origin = given.extent().centre();
        let [cx, cy] = gap.centre();
        let lattice = Grid::over(&reach, [33, 33]);
        let points =
            (0..given.len()).map(|k| given.centre_of(k)).chain((0..lattice.len()).map(|k| lattice.centre_of(k)));
        let deepest = points.map(|[x, y]| depth - gap.gap(x, y)).fold(depth - gap.gap(cx, cy), f64::max);
        let height = if deepest > 0.0 { deepest } else { depth.abs().max(f64::MIN_POSITIVE) };
        let scaled = Scaled { gap, origin, length, depth: height };
        let grid = Grid {
            origin: scaled.inward(given.origin),
            spacing: given.spacing.map(|h| h / length),
            shape: given.shape,
        };
        let unit_pressure = modulus.e_star() * height / length;
        let q = pressure.values.iter().map(|p| (p / unit_pressure).max(0.0)).collect();
        // A hair more than the gap says: its own rounding.
        let reach = Rect { min: scaled.inward(reach.min), max: scaled.inward(reach.max) }.scaled(1.0 + 1e-9);
        let unit_force = modulus.e_star() * height * length;
        let depth = depth / height;
        Ok(Some((Self { gap: scaled, depth, grid, reach, reach_known, unit_pressure, unit_force, given }, q)))
    }

    /// Suprema for the pressure `q` and what they are worth.
    fn look(&self, lattice: &mut Lattice, q: &[f64], settings: &BracketSettings) -> (Violation, Evidence) {
        let per_cell = settings.per_cell.max(1);
        let [a, b] = self.grid.spacing;
        let slender = a.max(b) > kernel::MOST_SLENDER * a.min(b);
        if settings.prove
            && self.reach_known
            && !slender
            && let Some(found) = Violation::proved(self, lattice, q, per_cell)
        {
            return (found, Evidence::Proved);
        }
        (Violation::sampled(self, lattice, q, per_cell), Evidence::Sampled { per_cell })
    }

    /// Supremum of f over a rectangle; where the gap proves none, its largest at 5 x 5 points.
    fn most_overlap(&self, rect: &Rect) -> f64 {
        if let Some([low, _]) = self.gap.range(rect, [0.0; 2]) {
            return self.depth - low + 1e-13 * self.depth.abs();
        }
        let [w, h] = rect.size();
        let points =
            (0..25).map(|k| [rect.min[0] + 0.25 * w * f64::from(k % 5), rect.min[1] + 0.25 * h * f64::from(k / 5)]);
        points.map(|[x, y]| self.depth - self.gap.gap(x, y)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// A side in the user's units.
    fn side(&self, closed: Closed, q: &[f64]) -> Side {
        let kept = |k: usize| closed.kept.as_ref().is_none_or(|kept| kept[k]);
        let factor = closed.factor * self.unit_pressure;
        let values = q.iter().enumerate().map(|(k, q)| if kept(k) { q * factor } else { 0.0 }).collect();
        Side {
            force: closed.force * self.unit_force,
            theorem: closed.theorem,
            violation: closed.left * self.gap.depth,
            at: self.gap.outward(closed.at),
            pressure: Pressure { grid: self.given, values },
        }
    }
}
