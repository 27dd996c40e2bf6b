//! Contact with sharp edges: cells graded to the edges of the material, a dense solve, proved bounds of energy and force.
//!
//! With S the displacement by a pressure (symbol 2/(E* |q|)) and a(v, v) = <S^-1 v, v>, the stored energy of an overlap f is
//!
//! ```text
//! U = max over p >= 0 of <f, p> - <p, S p>/2 = min of a(v, v)/2 over v >= f where there is material.
//! ```
//!
//! Any p >= 0 on the material gives U_low = <f, p> - <p, S p>/2 <= U. With r = f - S p and any w >= r on {f > 0}, v = S p + w is
//! admissible in the second principle, and
//!
//! ```text
//! U <= U_low + <p, w - r> + a(w, w)/2.                                                                                (1)
//! ```
//!
//! a(w, w) is bounded from above by the Dirichlet integral of any continuation of w into the half-space (`residual_norm`, (2)).
//! Where material ends, p ~ s^(-1/2); cells graded as (i/n)^beta, beta > 3, towards every edge give bounds that close as n^-3, on a mesh that lies
//! along the outline, however it is turned. Pair integrals of near cells are exact, those of far cells carry their remainder.
//!
//! Lengths are in units of the outline, depth and E* are 1.

// Letters of the formulas index several arrays at once.
#![allow(clippy::needless_range_loop)]

mod active_set;
mod annular;
mod beyond;
mod bilinear;
mod block;
mod cells;
mod cholesky;
mod compliance;
mod crowned;
mod density;
mod directions;
mod discrete;
mod edge_lanes;
mod ellipse;
mod equidistributed;
mod estimated;
mod fade;
mod far;
mod first_mesh;
mod flanked;
mod flanked_bounds;
mod flanked_ends;
mod flanked_mesh;
mod flat;
mod force;
mod gauss;
mod group;
mod integrand;
mod interpolation;
mod kites;
mod line_contact;
mod line_potential;
mod mesh;
mod mirrored;
mod near_contact;
mod outline;
mod oval;
mod pair_integral;
mod peak;
mod polygon;
mod rectilinear;
mod region;
mod regular;
mod residual_form;
mod residual_norm;
mod roller;
mod rows;
mod strip;
mod subcell;
mod subdivision;
mod surroundings;
mod symmetry;
mod tilted;
mod tilted_bounds;
mod tilted_mesh;

pub(crate) use annular::{Annular, Law, RadialBounds, RadialJet, Span, annular};
pub(crate) use cells::{resample, resample_rings};
pub(crate) use crowned::{Crowned, crowned};
pub(crate) use equidistributed::{Boxed, OverlapBox, equidistributed};
pub(crate) use estimated::Estimated;
pub(crate) use flanked::{Flat as FlankedFlat, flanked};
pub(crate) use flanked_bounds::{Bounded, flanked_bounds};
pub(crate) use flat::{FlatStiffness, estimated_stiffness, flat_stiffness};
pub(crate) use line_contact::{LineContact, line_contact};
pub(crate) use outline::Outline;
pub(crate) use oval::{Quarters, oval};
pub(crate) use region::Region;
pub(crate) use roller::{Roller, roller};
pub(crate) use rows::width_of_line_contact;
pub(crate) use symmetry::mirrors;
pub(crate) use tilted::tilted;
pub(crate) use tilted_bounds::Tilted;
pub(crate) use tilted_mesh::{Frame, Given};

use crate::clock::Deadline;

/// What is asked for and what may be spent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Relative half width of the bracket.
    pub tolerance: f64,
    /// Unknowns at most, after symmetry.
    pub unknowns: usize,
    /// Rings that a proof is worth where an estimate is good enough.
    pub worth: usize,
    /// Cells at most.
    pub cells: usize,
    /// Whether the force of a flat punch is to be proved where it can be: most of the time goes there.
    pub proof: bool,
    /// Whether the stiffness against tilts is wanted, too.
    pub tilts: bool,
    /// The mesh that is being solved is finished; none is begun that would last longer.
    pub deadline: Deadline,
    /// Threads of the pool that this is called in, or 1.
    pub threads: usize,
}

impl Limits {
    fn means(&self) -> Means {
        Means { deadline: self.deadline, threads: self.threads }
    }
}

/// What one mesh may be solved with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Means {
    pub deadline: Deadline,
    pub threads: usize,
}

/// Cells, or orbits of them, from which threads pay.
const WORTH_THREADS: usize = 64;

impl Means {
    /// Threads for work on so many cells.
    fn of(self, cells: usize) -> usize {
        if cells < WORTH_THREADS { 1 } else { self.threads }
    }

    /// No limit of time, one thread.
    #[cfg(test)]
    pub const PLAIN: Self = Self { deadline: Deadline::NEVER, threads: 1 };
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            tolerance: 1e-3,
            unknowns: 1600,
            worth: 400,
            cells: 12_000,
            proof: true,
            tilts: false,
            deadline: Deadline::NEVER,
            threads: 1,
        }
    }
}
