//! Bounds of a force and of a depth, and what they rest on.

use crate::grid::Pressure;

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
    pub(crate) force: f64,
    pub(crate) theorem: Theorem,
    pub(crate) evidence: Evidence,
    pub(crate) violation: f64,
    pub(crate) at: [f64; 2],
    pub(crate) repair: Repair,
    pub(crate) pressure: Option<Pressure>,
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

/// lower <= P <= upper. Only this crate can make one.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceBracket {
    pub(crate) lower: Side,
    pub(crate) upper: Side,
    pub(crate) cost: BracketCost,
}

/// What scaling may move a bound by, relative.
pub(crate) const ROUNDED: f64 = 1e-13;

impl ForceBracket {
    /// Nothing above and nothing below: the bodies do not touch.
    pub(crate) fn no_contact(pressure: Option<Pressure>) -> Self {
        let side = Side {
            force: 0.0,
            theorem: Theorem::NoContact,
            evidence: Evidence::Proved,
            violation: 0.0,
            at: [0.0; 2],
            repair: Repair::default(),
            pressure,
        };
        Self { lower: side.clone(), upper: side, cost: BracketCost::default() }
    }

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

    /// The same by a pressure that is not the solution's own.
    pub(crate) fn of_pressure(bounds: [f64; 2], pressure: &Pressure) -> Self {
        let mut bracket = Self::of_energy(bounds);
        // One field proves both sides.
        bracket.upper.pressure = Some(pressure.clone());
        bracket
    }

    /// At another depth of a homogeneous gap, where all forces are larger by this factor; `None` for bounds that come with fields.
    pub(crate) fn at_other_depth(&self, factor: f64) -> Option<Self> {
        let energy = |side: &Side| side.theorem == Theorem::Energy && side.pressure.is_none();
        let both = energy(&self.lower) && energy(&self.upper);
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

/// lower <= depth <= upper for a prescribed force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthBracket {
    pub(crate) lower: f64,
    pub(crate) upper: Option<f64>,
    pub(crate) evidence: Evidence,
}

impl DepthBracket {
    /// Bounds that are proved.
    pub(crate) fn proved([lower, upper]: [f64; 2]) -> Self {
        Self { lower, upper: Some(upper), evidence: Evidence::Proved }
    }

    /// Lower bound.
    #[must_use]
    pub fn lower(&self) -> f64 {
        self.lower
    }

    /// Upper bound; `None` when the force has no lower bound to derive one from.
    #[must_use]
    pub fn upper(&self) -> Option<f64> {
        self.upper
    }

    /// Both, where there are both.
    pub(crate) fn ends(&self) -> Option<[f64; 2]> {
        Some([self.lower, self.upper?])
    }

    /// How the suprema under it were found.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        self.evidence
    }
}

/// lower <= v <= upper, for both parts of a moment or a tilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairBracket {
    lower: [f64; 2],
    upper: [f64; 2],
}

impl PairBracket {
    /// Bounds that are proved.
    pub(crate) fn proved(bounds: [[f64; 2]; 2]) -> Self {
        Self { lower: bounds.map(|[low, _]| low), upper: bounds.map(|[_, high]| high) }
    }

    /// Lower bounds.
    #[must_use]
    pub fn lower(&self) -> [f64; 2] {
        self.lower
    }

    /// Upper bounds.
    #[must_use]
    pub fn upper(&self) -> [f64; 2] {
        self.upper
    }

    /// Whether both lie in the bracket.
    #[must_use]
    pub fn contains(&self, pair: [f64; 2]) -> bool {
        (0..2).all(|m| (self.lower[m]..=self.upper[m]).contains(&pair[m]))
    }

    /// The nearest pair in it.
    pub(crate) fn nearest(&self, pair: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|m| pair[m].max(self.lower[m]).min(self.upper[m]))
    }
}
