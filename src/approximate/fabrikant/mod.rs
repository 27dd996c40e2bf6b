//! The approximate method of Barber & Billings (1990): the contact region maximises the force P(A), and P(A) follows by
//! reciprocity from Fabrikant's pressure under a flat punch of plan-form A (equations 9 to 15).
//!
//! | equation | file |
//! |---|---|
//! | (10), (11) flat punch of any star-shaped plan-form | `flat_punch.rs` |
//! | (12) P(A) of any boundary, inner integral along a ray | `force.rs`, `sums.rs`; `ray.rs`, `radial.rs` |
//! | (15) stationary boundary | `stationary.rs`: `sweeps.rs` for D, `outer_root.rs` and `hump.rs` for a(theta) on a ray, `centring.rs`, `crossings.rs` |
//! | kinks of the gap along the rays | `facets.rs` for many planes, `hidden_kinks.rs` for what the gap does not tell, `ridges.rs`; parts that no ray sees, `second_part.rs` |
//! | (17)-(19), (25) regular polyhedra in closed form | `polyhedron.rs` |
//! | families of boundaries | `family.rs`; which of them, `choice.rs`, beside this folder |
//! | section 2.2, Rayleigh-Ritz ellipse | `ritz.rs`, beside this folder |
//!
//! Reciprocity gives the total force only, neither the pressure nor its line of action; energy and moments follow from the
//! forces at other depths and tilts (`energy.rs`, beside this folder). Results are estimates, neither upper nor lower bounds, except for ellipses
//! ([`Approximation::lower_bound`]).

// Comparisons are written so that NaN takes the branch of failure.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod approximation;
mod centring;
mod crossings;
mod facets;
mod family;
mod flat_punch;
mod force;
mod hidden_kinks;
mod hump;
mod outer_root;
mod plan_form;
mod polyhedron;
mod problem;
mod radial;
mod ray;
mod ridges;
mod second_part;
mod sectors;
mod star;
mod stationary;
mod sums;

mod sweeps;

pub use approximation::{Approximation, Boundary, Error, Family, LowerBound, Settings};
pub(crate) use family::best;
pub use flat_punch::FlatPunch;
pub(crate) use flat_punch::agm;
pub use force::{Force, force};
pub use polyhedron::RegularPolyhedron;
pub(crate) use problem::{Problem, first_rung};
pub(crate) use radial::RadialRule;
pub(crate) use ray::{DIFFERENCE_STEP, ScaledOverlap};
pub(crate) use sectors::{Sectors, Spoke, THIRD};
pub use stationary::stationary;
