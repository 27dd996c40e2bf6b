//! An independent check of results: what a result says about a state of contact, against what follows from its pressure field.
//!
//! Nothing is shared with a proof or with a solver but the gap, and the rule that places boundaries between cells: displacements are
//! summed directly, flat punches are solved by another method. The checker samples: it can refuse, and it cannot prove.
//!
//! | origin of the force | what is checked | window of the force |
//! |---|---|---|
//! | `one_grid` | the contact conditions in the cells; every number that follows from the field | the sum of the field |
//! | `many_grids` of a homogeneous gap | the same, on the finest | from the energy of the field: see below |
//! | `many_grids` of another | the contact conditions on the finest; else all grids, solved again: no independent code | rounding |
//! | `closed_form`, `approximate` | the formula, applied again; its field by the displacement of neighbours | rounding |
//! | `edge_fitted`, `separate_contacts`, grids that were turned | the same cells, solved again: no independent code | rounding |
//! | `no_contact` | that the bodies do not overlap | zero |
//!
//! **Force of many grids.** For any p >= 0 that vanishes where there is no material, U_h = integral of p f - p S p/2 is at most the
//! stored energy U (minimum principle), and P d = (2 + 1/k) U where the gap is homogeneous of degree k. So the field itself proves
//! P >= (2 + 1/k) U_h/d = P_h. A limit of several grids may lie above P_h, by what it says is left: the window is
//! [P_h, P_h (1 + [`CLOSER`] e)] with e the stated error.
//!
//! **Stated error.** e must leave room for what the field shows: P (1 + e) >= P_h; and it must not be less than a tenth of the
//! discretisation error that the field itself shows, which is the distance from P_h for a homogeneous gap, and else what the force
//! changes by, to first order, when means over cells and values at centres are exchanged: no estimate from grids is closer.
//!
//! **Brackets.** Those of pressures that displace too much or too little are worked out by direct summation ([`bounds`]). One that is
//! said to follow from the energy ([`crate::energy`]) has to follow from the field by the same code and, for a homogeneous gap, may not be
//! narrower than what direct summation sees of it.
//!
//! A number that no check uses is named as not checked.

#[cfg(feature = "scene")]
mod again;
mod bounds;
#[cfg(feature = "scene")]
mod cells;
#[cfg(feature = "scene")]
mod energy;
#[cfg(feature = "scene")]
mod formula;
#[cfg(feature = "scene")]
mod grid;
mod homogeneous;
#[cfg(feature = "scene")]
mod keys;
mod one_cell;
#[cfg(feature = "scene")]
mod result;
#[cfg(feature = "scene")]
mod scaled;
#[cfg(feature = "scene")]
mod spread;
#[cfg(feature = "scene")]
mod state;
mod summation;

#[cfg(feature = "scene")]
pub use again::Shared;
pub use bounds::{Claim, bounds, bracket};
#[cfg(feature = "scene")]
pub use result::State;

/// How many times closer than the discretisation error that its field shows a stated error may be.
pub const CLOSER: f64 = 10.0;

/// What the checker found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Verification {
    /// What was checked, with the figures found.
    pub checked: Vec<String>,
    /// What speaks against it.
    pub objections: Vec<String>,
    /// Numbers of the result that no check uses.
    pub unchecked: Vec<String>,
}

impl Verification {
    /// Whether nothing speaks against it.
    #[must_use]
    pub fn accepted(&self) -> bool {
        self.objections.is_empty()
    }

    /// Notes a condition and its figures.
    pub fn require(&mut self, holds: bool, what: impl Into<String>) {
        let what = what.into();
        if !holds {
            self.objections.push(what.clone());
        }
        self.checked.push(what);
    }

    /// Everything that another check found.
    pub fn join(&mut self, other: Self) {
        self.checked.extend(other.checked);
        self.objections.extend(other.objections);
        self.unchecked.extend(other.unchecked);
    }
}

#[cfg(feature = "scene")]
/// Whether two numbers agree to this share of the larger.
fn close(a: f64, b: f64, share: f64) -> bool {
    (a - b).abs() <= share * a.abs().max(b.abs())
}
