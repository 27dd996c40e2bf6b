//! The approximate method of Barber & Billings (1990): the contact region maximises the force P(A), and P(A) follows by
//! reciprocity from Fabrikant's pressure under a flat punch of plan-form A (equations 9 to 15).
//!
//! | equation | file |
//! |---|---|
//! | (10), (11) flat punch of any star-shaped plan-form | `flat_punch.rs` |
//! | (12) P(A) of any boundary, inner integral along a ray | `force.rs`, `sums.rs`; `ray.rs`, `radial.rs` |
//! | (15) stationary boundary | `stationary.rs`: `sweeps.rs` for D, `outer_root.rs` and `power_law_model.rs` for a(theta) on a ray, `symmetry.rs` for the turns that leave a gap as it is, `centring.rs`, `crossings.rs` |
//! | kinks of the gap along the rays | `facets.rs` for many planes, `kink_detection.rs` for those that are not known; parts beyond the first, `second_part.rs` |
//! | (17)-(19), (25) regular polyhedra in closed form | `polyhedron.rs` |
//! | families of boundaries | `family.rs`; which of them, `choice.rs`, beside this folder |
//! | section 2.2, Rayleigh-Ritz ellipse | `ritz.rs`, beside this folder |
//!
//! Reciprocity gives the total force only, neither the pressure nor its line of action; energy and moments follow from the
//! forces at other depths and tilts (`energy.rs`, beside this folder).
//! Results are estimates, neither upper nor lower bounds, except for ellipses
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
mod kink_detection;
mod outer_root;
mod plan_form;
mod polyhedron;
mod power_law_model;
mod problem;
mod radial;
mod ray;
mod ray_fan;
mod second_part;
mod sectors;
mod stationary;
mod sums;
mod sweeps;
mod symmetry;

pub use approximation::{Approximation, Boundary, Error, Family, LowerBound, Settings};
pub(crate) use family::best;
pub use flat_punch::FlatPunch;
pub(crate) use flat_punch::agm;
pub use force::{Force, force};
pub use polyhedron::RegularPolyhedron;
pub(crate) use problem::{Problem, first_rule_level};
pub(crate) use radial::RadialRule;
pub(crate) use ray::{DIFFERENCE_STEP, ScaledOverlap};
pub(crate) use sectors::{QuadratureNode, Sectors, THIRD};
pub use stationary::stationary;
