//! Energy, moments and the stiffness against tilts of an approximate contact, which the paper leaves out.
//!
//! While the depth s grows the contact passes through patches A(s), and each step adds the pressure of a flat punch on the
//! patch of the moment (Mossakovskii 1963; Hill & Storakers 1990). With the force P(s) = max over A of P(A; s), equation (12), the
//! stored energy is
//!
//! ```text
//! U = int P ds,   dU/dd = P,   dU/da = (int p x, int p y)   under f = d + a x - g
//! ```
//!
//! Ellipses: P is stationary in the patch and its centre, so dP/ds = K, the stiffness of the flat punch on A(s), dP/da = K c with its
//! centre c, and dU/da = int K c ds. That int K ds gives P back checks the sum, and that all patches belong to one branch.
//! Other boundaries have their centre prescribed (the centroid): P is not stationary in it, and dU/da is a difference of energies. For a
//! homogeneous gap, contacts are similar and U = P d/(2 + 1/k).

use nalgebra::{Matrix2, SymmetricEigen};

use super::fabrikant::{Approximation, Family};
use crate::closed_form::{Ellipse, tilt_stiffness};
use crate::gap::AnyGap;
use crate::numeric::geometry;
use crate::numeric::quadrature::GaussLegendre;
use crate::overlap::least;
use crate::solution::{Unsolved, Verdict};

/// Depths of one panel.
const NODES: usize = 8;

/// Panels of the finest sum.
const MOST_PANELS: u32 = 8;

/// How far int K ds may stay off P however many depths are taken, where the centroid of an unsymmetric patch moves (see
/// [`Approximation::stiffness`]). More means boundaries of several branches.
const MOST_UNSYMMETRIC: f64 = 1e-2;

/// Tilts of the differences: the share of the depth that they add at the rim.
const TURN: f64 = 0.02;

/// What a contact has stored, and how its force answers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EnergyAndMoments {
    /// U, from first touch to here.
    pub energy: f64,
    /// (int p x, int p y) about the origin.
    pub first_moment: Option<[f64; 2]>,
    /// dP/dd.
    pub stiffness: f64,
    /// Second derivatives of U by (depth, ax, ay).
    pub matrix: Option<[[f64; 3]; 3]>,
    /// Boundaries that were found for it.
    pub states: usize,
    /// How it came about, where that is not exact.
    pub remark: Option<String>,
}

/// A contact whose energy is sought.
pub(crate) struct EnergyProblem<'a> {
    pub gap: &'a AnyGap,
    pub depth: f64,
    /// Its boundary.
    pub found: &'a Approximation,
    /// Relative.
    pub tolerance: f64,
    /// The boundary by the same method for another gap or depth.
    pub at: &'a dyn Fn(&AnyGap, f64) -> Result<Approximation, Unsolved>,
}

/// A sum over the depths that a contact went through.
struct Sum {
    energy: f64,
    /// int K c ds/int K ds.
    centre: [f64; 2],
    /// How far c moves with the depth, in units of length.
    centre_moves: f64,
    states: usize,
    /// |int K ds/P - 1|.
    miss: f64,
}

impl EnergyProblem<'_> {
    /// What needs no other boundary: a homogeneous gap's.
    pub fn by_homogeneity(&self) -> Option<EnergyAndMoments> {
        let k = self.gap.known().degree()?.inverse();
        let (force, about, centroid) = (self.found.force, self.gap.known().centre, self.found.centroid);
        let size = self.found.area.sqrt();
        let nearer = (1.0 + k) / (1.0 + 2.0 * k);
        let still = (0..2).all(|m| (centroid[m] - about[m]).abs() <= 1e-9 * size);
        let centre = [0, 1].map(|m| about[m] + nearer * (centroid[m] - about[m]));
        Some(EnergyAndMoments {
            energy: force * self.depth / (2.0 + k),
            first_moment: (still || self.elliptic()).then(|| centre.map(|c| force * c)),
            stiffness: (1.0 + k) * force / self.depth,
            matrix: None,
            states: 0,
            remark: None,
        })
    }

    /// Energy, and the moments where they can be had, by further solves.
    ///
    /// # Errors
    /// The verdict of a further solve; `ToleranceNotReached` when the stiffnesses do not add up to the force.
    pub fn by_integration(&self) -> Result<EnergyAndMoments, Unsolved> {
        let work = self.stored()?;
        if work.first_moment.is_some() {
            return Ok(work);
        }
        // The energy stands without the moments.
        self.by_tilt_differences(&work).or_else(|e| {
            let remark = Some(format!("no moments: {}", e.reason));
            Ok(EnergyAndMoments { remark, ..work })
        })
    }

    /// Energy, moments and the stiffness against tilts.
    ///
    /// # Errors
    /// As [`Self::by_integration`], and where no moments can be had.
    pub fn with_matrix(&self, e_star: f64) -> Result<EnergyAndMoments, Unsolved> {
        let mut work = self.stored()?;
        if work.first_moment.is_none() {
            work = self.by_tilt_differences(&work)?;
        }
        work.matrix = Some(self.matrix(e_star, work.stiffness));
        Ok(work)
    }

    /// The energy, with the moments of ellipses and of patches that stay about one centre.
    fn stored(&self) -> Result<EnergyAndMoments, Unsolved> {
        if let Some(work) = self.by_homogeneity() {
            return Ok(work);
        }
        let sum = self.sum(self.gap, self.depth, self.found.force)?;
        let still = sum.centre_moves <= 1e-6 * self.found.area.sqrt();
        let first_moment = (still || self.elliptic()).then(|| sum.centre.map(|c| self.found.force * c));
        let remark = format!(
            "energy and moments: the sum of the flat punches at {} depths, {:.1e} off the force",
            sum.states, sum.miss
        );
        let (energy, states, remark) = (sum.energy, sum.states, Some(remark));
        Ok(EnergyAndMoments { energy, first_moment, stiffness: self.found.stiffness, matrix: None, states, remark })
    }

    fn elliptic(&self) -> bool {
        matches!(self.found.family, Family::Ellipse | Family::Circle)
    }

    /// The moments from the energy of contacts tilted about the centroid.
    fn by_tilt_differences(&self, work: &EnergyAndMoments) -> Result<EnergyAndMoments, Unsolved> {
        let (force, centroid) = (self.found.force, self.found.centroid);
        let overlap = self.depth - least(self.gap).1;
        let turn = TURN * overlap / (self.found.area / std::f64::consts::PI).sqrt();
        let mut states = work.states;
        let mut first_moment = [0.0; 2];
        for m in 0..2 {
            let mut energy = |turn: f64| -> Result<f64, Unsolved> {
                let tilt = if m == 0 { [turn, 0.0] } else { [0.0, turn] };
                let gap = self.gap.tilted(tilt);
                let depth = self.depth - turn * centroid[m];
                let found = (self.at)(&gap, depth)?;
                states += 1;
                match gap.known().degree() {
                    Some(degree) => Ok(found.force * depth / (2.0 + degree.inverse())),
                    None => {
                        let sum = self.sum(&gap, depth, found.force)?;
                        states += sum.states;
                        Ok(sum.energy)
                    }
                }
            };
            first_moment[m] = force * centroid[m] + (energy(turn)? - energy(-turn)?) / (2.0 * turn);
        }
        let words = format!("moments: differences of the energy over tilts of {turn:.1e}");
        let remark = Some(work.remark.as_ref().map_or_else(|| words.clone(), |before| format!("{before}; {words}")));
        Ok(EnergyAndMoments { first_moment: Some(first_moment), states, remark, ..work.clone() })
    }

    /// The sum over depths from first touch to `depth`, where the force is `force`.
    fn sum(&self, gap: &AnyGap, depth: f64, force: f64) -> Result<Sum, Unsolved> {
        let first_touch = least(gap).1;
        let overlap = depth - first_touch;
        let rule = GaussLegendre::new(NODES);
        let (mut panels, mut states, mut before) = (1, 0, f64::INFINITY);
        loop {
            let (mut energy, mut added, mut first, mut centre_moves) = (0.0, 0.0, [0.0; 2], 0.0_f64);
            let here = self.found.centroid;
            for panel in 0..panels {
                for (x, weight) in rule.nodes() {
                    // s ~ t^2: with K ~ s^(1/k), a polynomial in t for cones, paraboloids and flat punches.
                    let t = (f64::from(panel) + 0.5 * (1.0 + x)) / f64::from(panels);
                    let ds = overlap * t * weight / f64::from(panels);
                    let state = (self.at)(gap, first_touch + overlap * t * t)?;
                    states += 1;
                    energy += state.force * ds;
                    added += state.stiffness * ds;
                    let c = state.centroid;
                    first = [0, 1].map(|m| first[m] + state.stiffness * ds * c[m]);
                    centre_moves = centre_moves.max((c[0] - here[0]).hypot(c[1] - here[1]));
                }
            }
            let miss = (added / force - 1.0).abs();
            let converged = (added / before - 1.0).abs() <= self.tolerance && miss <= MOST_UNSYMMETRIC;
            if miss <= self.tolerance || converged {
                return Ok(Sum { energy, centre: first.map(|m| m / added), centre_moves, states, miss });
            }
            if panels == MOST_PANELS {
                let reason = format!(
                    "the flat punches that the contact went through add up to a force that is off by {miss:.1e}: \
                     energy and moments are not known"
                );
                return Err(Unsolved::new(Verdict::ToleranceNotReached, reason));
            }
            (panels, before) = (2 * panels, added);
        }
    }

    /// A flat punch on the patch. Its K and the centre of K are the method's own; against tilts, the patch counts as the ellipse of the
    /// same second moments (which it is for ellipses).
    fn matrix(&self, e_star: f64, stiffness: f64) -> [[f64; 3]; 3] {
        let tilting = tilt_stiffness(e_star, &ellipse_like(self.found));
        let ([x, y], k) = (self.found.centroid, stiffness);
        let xy = tilting[(1, 2)] + k * x * y;
        [[k, k * x, k * y], [k * x, tilting[(1, 1)] + k * x * x, xy], [k * y, xy, tilting[(2, 2)] + k * y * y]]
    }
}

/// The ellipse about the origin with the second moments of the patch about its centroid.
fn ellipse_like(found: &Approximation) -> Ellipse {
    let polyline = found.boundary.polyline();
    let shrunk = found.area / geometry::area(&polyline);
    let about = geometry::centroid(&polyline);
    // The polyline cuts corners: second moments grow with the square of the area.
    let [xx, xy, yy] = geometry::second_moments(&polyline, about).map(|i| i * shrunk * shrunk);
    let axes = SymmetricEigen::new(Matrix2::new(xx, xy, xy, yy));
    let (long, short) = if axes.eigenvalues[0] >= axes.eigenvalues[1] { (0, 1) } else { (1, 0) };
    // pi a^3 b/4 and pi a b^3/4.
    let [most, least] = [axes.eigenvalues[long], axes.eigenvalues[short]].map(|i| 4.0 * i / std::f64::consts::PI);
    let (root_aspect, side) = ((most / least).powf(0.25), (most * least).powf(0.125));
    let along = axes.eigenvectors.column(long);
    Ellipse {
        centre: [0.0; 2],
        semi_axes: [side * root_aspect, side / root_aspect],
        orientation: along[1].atan2(along[0]),
    }
}
