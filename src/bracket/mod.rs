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

mod approximate;
mod away;
mod cell;
mod close;
mod comparison;
mod depth;
mod field;
mod frame;
pub(crate) mod kernel;
mod known;
mod look;
mod measure;
mod mirrors;
mod outside;
mod polynomial;
pub(crate) mod refined;
mod sharp;
mod source;
mod spread;
mod tables;
mod trend;
mod violation;

use crate::clock::{Deadline, Stopwatch};
use crate::error::Unsolved;
use crate::gap::AnyGap;
use crate::grid::Pressure;
use crate::problem::EffectiveModulus;
use field::Surroundings;
use frame::Attention;
use known::Known;
use mirrors::Mirrors;

pub use approximate::approximate;
pub use depth::DepthBracket;
pub use sharp::sharp;

/// How the suprema were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// Over every point of the plane, rounding included: what lies between lattice points is bounded.
    Proved,
    /// At this many lattice points along each side of a cell: a supremum between them is missed.
    Sampled {
        /// Points along a side of a cell; 0 where no grid was looked at.
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
    /// The pressure is admissible at another depth of a homogeneous gap, up to discs: P(d') = P(d) (d'/d)^(1 + 1/k).
    OtherDepth,
    /// The exact flat-punch pressure of an ellipse (Rayleigh & Ritz).
    Ellipse,
    /// Fabrikant's pressure, made less where it displaces much until it displaces nearly evenly, over the supremum of what it
    /// then displaces: his pressure alone proves less.
    CorrectedFabrikant,
    /// A gap with a closed form that lies below everywhere: it is pressed with more force.
    Comparison,
    /// Bounds of the stored energy, P (d - g0) = (2 + 1/k) U for a homogeneous gap ([`crate::energy`]): by the pressure of the solution,
    /// or on cells fitted to the edges of the material.
    Energy,
    /// The bodies do not touch.
    NoContact,
}

impl Theorem {
    /// The name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scaling => "scaling",
            Self::Discs => "discs",
            Self::OtherDepth => "other_depth",
            Self::Ellipse => "ellipse",
            Self::CorrectedFabrikant => "fabrikant",
            Self::Comparison => "comparison",
            Self::Energy => "energy",
            Self::NoContact => "no_contact",
        }
    }
}

/// One side of a bracket.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    force: f64,
    theorem: Theorem,
    evidence: Evidence,
    violation: f64,
    at: [f64; 2],
    repair: Repair,
    pressure: Option<Pressure>,
}

/// What stands between the force of a pressure Q and the bound: (Q + discs)/(1 - level/d)^(1 + 1/k) above,
/// (Q - discs)/(1 + level/d)^(1 + 1/k) below.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Repair {
    /// Force of the discs.
    pub discs: f64,
    /// Violation that another depth makes good, in units of length.
    pub level: f64,
    /// k, where the level is not zero.
    pub degree: Option<f64>,
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

    /// How its supremum was found.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        self.evidence
    }

    /// What was added to the force of the pressure.
    #[must_use]
    pub fn repair(&self) -> Repair {
        self.repair
    }

    /// Largest violation that the repair had to make good, in units of length; 0 under [`Theorem::Scaling`].
    #[must_use]
    pub fn violation(&self) -> f64 {
        self.violation
    }

    /// Centre of the cell where the pressure violated its condition most, before any repair.
    #[must_use]
    pub fn at(&self) -> [f64; 2] {
        self.at
    }

    /// The pressure that proves the bound, up to the repair: what a checker needs. `None` where the theorem has no use for one.
    #[must_use]
    pub fn pressure(&self) -> Option<&Pressure> {
        self.pressure.as_ref()
    }
}

/// What a bracket took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BracketCost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Products with the influence coefficients to look at pressures; those of the solves are not counted.
    pub products: usize,
    /// Solves on the grid for pressures nearer to admissible.
    pub solves: usize,
}

/// lower <= P <= upper. Only this module can make one.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceBracket {
    lower: Side,
    upper: Side,
    cost: BracketCost,
}

/// What scaling may move a bound by, relative.
pub(crate) const ROUNDED: f64 = 1e-13;

impl ForceBracket {
    /// From bounds of the energy, proved.
    pub(crate) fn of_energy([lower, upper]: [f64; 2]) -> Self {
        let side = |force: f64| Side {
            force,
            theorem: Theorem::Energy,
            evidence: Evidence::Proved,
            violation: 0.0,
            at: [0.0; 2],
            repair: Repair::default(),
            pressure: None,
        };
        Self { lower: side(lower), upper: side(upper), cost: BracketCost::default() }
    }

    /// At another depth of a homogeneous gap, where all forces are larger by this factor; `None` for bounds that come with fields.
    pub(crate) fn at_other_depth(&self, factor: f64) -> Option<Self> {
        let both = self.lower.theorem == Theorem::Energy && self.upper.theorem == Theorem::Energy;
        let more = |force: f64, rounding: f64| force * factor * (1.0 + rounding);
        both.then(|| Self::of_energy([more(self.lower(), -ROUNDED), more(self.upper(), ROUNDED)]))
    }

    /// For a gap that is known to within what changes the force by at most `more`, as samples show: discs make that good, too.
    pub(crate) fn widened(mut self, more: f64) -> Self {
        for (side, sign) in [(&mut self.lower, -1.0), (&mut self.upper, 1.0)] {
            side.force = (side.force + sign * more).max(0.0);
            side.repair.discs += more;
            if side.evidence == Evidence::Proved {
                side.evidence = Evidence::Sampled { per_cell: 0 };
            }
        }
        self
    }

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

    /// How the suprema were found: the weaker of the two sides.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        if self.lower.evidence == Evidence::Proved { self.upper.evidence } else { self.lower.evidence }
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
    /// Whether to bound what lies between lattice points where the gap allows it ([`crate::gap::Gap::bounds`]); yes unless said.
    pub prove: bool,
    /// Most rounds of [`sharp`] on either side; 4 unless said.
    pub rounds: usize,
    /// Threads for the solves of [`sharp`]; 1 unless said.
    pub threads: usize,
    /// When no further round of [`sharp`] is begun; never unless said. What is found until then is a bracket all the same.
    pub deadline: Deadline,
}

impl Default for BracketSettings {
    fn default() -> Self {
        Self { per_cell: 4, prove: true, rounds: 4, threads: 1, deadline: Deadline::NEVER }
    }
}

/// Bracket on the force of `gap` at `depth` from any pressure on any grid. Negative pressures count as none; a poor pressure
/// gives a wide bracket, never a wrong one.
///
/// Units: any consistent set; `pressure` in the units of E*, on a grid in the units of the gap.
///
/// # Errors
/// [`crate::Verdict::Unbounded`] when the gap stays below the depth without end, [`crate::Verdict::NotApplicable`] when a number of the
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
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    settings: &BracketSettings,
) -> Result<ForceBracket, Unsolved> {
    let gap = &gap.into();
    frame::within(gap, modulus, depth, pressure, |frame, mut q| {
        let started = Stopwatch::start();
        let mirrors = Mirrors::found(&mut q, frame);
        let mut around = Surroundings::new(&frame.grid, settings.per_cell.max(1));
        let known = Known::new(q.len(), false);
        let closely = vec![look::WHOLE; q.len()];
        let mut attention = Attention { known, closely, mirrors, prove: settings.prove };
        let (_, found, evidence) = frame.look(&mut around, &q, violation::Side::Both, &mut attention);
        let outside = outside::look(frame, &q);
        let (upper, lower) = (close::upper(frame, &q, &found, &outside), close::lower(frame, &q, &found));
        let cost = BracketCost { seconds: started.seconds(), products: 1, solves: 0 };
        ForceBracket { lower: frame.side(lower, &q, evidence), upper: frame.side(upper, &q, evidence), cost }
    })
}

/// Nothing above and nothing below.
fn no_contact(pressure: Option<Pressure>) -> ForceBracket {
    let side = Side {
        force: 0.0,
        theorem: Theorem::NoContact,
        evidence: Evidence::Proved,
        violation: 0.0,
        at: [0.0; 2],
        repair: Repair::default(),
        pressure,
    };
    ForceBracket { lower: side.clone(), upper: side, cost: BracketCost::default() }
}
