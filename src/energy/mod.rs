//! A two-sided bound of the stored energy from any pressure, and through it of the force.
//!
//! E* = 1. S takes a pressure to the displacement of the surface, f = depth - gap is the overlap, and the half-space has the energy
//! a(v, v)/2 when its surface is displaced by v, a(v, v) = <S^-1 v, v> = min (1/2) integral of |grad Phi|^2 over z > 0 with Phi = v at
//! z = 0. By duality
//!
//!   U = max over p >= 0 of <f, p> - <p, S p>/2 = min over v >= f where f > 0 of a(v, v)/2.
//!
//! Take any p >= 0, u = S p, r = f - u, and any w with w >= r where f > 0. Then v = u + w may stand on the right, and with
//! a(u, w) = <p, w>, a(u, u) = <p, u>
//!
//!   U_low = <f, p> - <p, S p>/2  <=  U  <=  U_low + gamma,   gamma = <p, w - r> + a(w, w)/2.                              (1)
//!
//! w = r where p > 0 leaves a(w, w)/2 alone. Phi = w exp(-z/l) with one length l bounds it, and the best l gives
//!
//!   a(w, w) <= |w| |grad w|/2   (norms of L2 over the plane).                                                           (2)
//!
//! The residual of a solution on cells changes its sign within each cell: (2) is nearly an equation, and gamma falls with the square of
//! the residual. Nothing is asked of p: neither that it solves the grid nor how well.
//!
//! **Force.** For a gap that is homogeneous of degree k about its lowest point g0, P (d - g0) = (2 + 1/k) U: the bracket of U is that
//! of P. For any other the pressure of a flat punch on the contact bounds it on both sides (`any_gap`), and where the gap is smooth a
//! contact that is moved and dilated (`dilation`); the narrower of both counts.
//!
//! **How w goes on beyond the cells under pressure** decides the width: r falls like the power 3/2 of the distance there. w = chi r
//! with chi = 1 at the cells and 0 half a cell away (`extension`); further out w = 0 takes r <= 0, which is shown: by the loads alone
//! far away (`outside`), by bounds of u in a cell near by (`residual`, `cut`). Where it cannot be shown, w = r.
//!
//! **How the integrals of w^2 and |grad w|^2 are enclosed.** In a cell u is the sum of what the near cells do, by its expansion in
//! Legendre polynomials and in the functions of the eight cells that touch, and of an interpolant of what all others do (`basis`,
//! `tables`, `lanes`); f is a Taylor polynomial with enclosed coefficients (`overlap`). Both integrals are then quadratic forms
//! (`whole`), or sums over quarters where f has a kink or chi is not 1 (`quarter`, `cut`). What each step leaves out is bounded
//! and added in the norm it belongs to. Sums in double precision are rounded by less than is added for them (`field`).
//!
//! What bounds take from elsewhere: enclosures of the gap, its slopes and its means ([`crate::gap::Gap::bounds`],
//! [`crate::gap::Gap::slopes`], [`crate::gap::Gap::mean_bounds`]), and the influence coefficients to eleven digits.

mod any_gap;
mod basis;
mod bracket;
mod cut;
mod expansion;
mod expected;
mod extension;
mod faded;
mod field;
mod force;
mod functional;
mod lane;
mod of_gap;
mod on_cells;
mod outside;
mod overlap;
mod parts;
mod potential;
mod pressed;
mod quarter;
mod residual;
mod rest;
mod square_cells;
mod stiffness;
mod tables;
mod touching;
mod turned;
mod virial;
mod whole;

pub use bracket::{EnergyBracket, Padded, Trial, energy_bracket};
pub(crate) use expected::NoBounds;
pub use force::force_bracket;
pub(crate) use force::{Wanted, force_bounds, moment_bounds};
pub use of_gap::GapOverlap;
pub use overlap::{Interval, Jet, OverlapBounds};
pub(crate) use stiffness::stiffness;
