//! Bounds of the force of a contact on some of the cells of a mesh, the others being free of pressure: of any gap.
//!
//! p is the exact pressure, P its force, p_h >= 0 that of the cells, u_h = S p_h, r = f - u_h; w >= r on the material, w = r under p_h;
//! N^2 = a(w, w), so that (1) is U <= U_low + N^2/2. With y the distance of p and p_h in the energy norm and X = <S p - f, p_h> >= 0
//!
//! ```text
//! U - U_low = y^2/2 + X,       0 <= <p, w - r> = <p - p_h, w> - y^2 - X <= N y - y^2 - X.
//! ```
//!
//! **Below.** On the cells A under pressure let m be any function, v = 1 - S m, m_A the exact pressure of a flat punch on A. P >= <f, m_A>
//! (Barber 1974), and m_A - m displaces A by v:
//!
//! ```text
//! P >= P_h + <r, m> - N sqrt(a_v),                                  a_v = a(w', w') of any w' = v on A.                (4)
//! ```
//!
//! **Above.** For 0 <= m <= tau p_h and w' = v under p_h with v - w' <= tau (w - r) on the material,
//!
//! ```text
//! P = <S p, m> + <p_h, v> + <p - p_h, w'> + <p, v - w'>
//!   <= P_h + <r, m> + tau X + y sqrt(a_v) + tau (N y - y^2 - X)
//!   <= P_h + <r, m> + max over 0 <= y <= N of y sqrt(a_v) + tau (N y - y^2),                                           (5)
//! ```
//!
//! N sqrt(a_v) where tau N <= sqrt(a_v), else (tau N + sqrt(a_v))^2/(4 tau).
//!
//! The cells A reach a little farther than the contact, m is nearly the pressure of the flat punch on them, and p_h the least energy of all
//! pressures that are no less than m/tau: where the contact ends p_h is small, S p_h > f beside it, and what is asked of w' beyond A is
//! shown by `beyond`. No bound of where the contact ends enters.

use super::active_set::{factor, solve_on, solve_within};
use super::discrete::Discretisation;
use super::line_potential::Lines;
use super::residual_norm::{Beyond, Overlap, Parted, Target, decay_lengths, parted};

/// Rounding of sums of products, relative to their sizes.
const ROUNDING: f64 = 1e-12;

/// Proved bounds, E* = 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    pub force: [f64; 2],
    pub energy: [f64; 2],
}

/// p and m on the cells of A.
pub(crate) struct Pressures<'a> {
    /// The loaded cells that are in A.
    pub contact: &'a [bool],
    /// Of the edges, for p and for m.
    pub strengths: [&'a [f64]; 2],
    pub tau: f64,
}

/// How v goes on beyond A: chi' of `beyond`, and l0 of what it leaves, at the nodes.
pub(crate) struct Continuation {
    pub chi: Vec<f64>,
    pub decay: Vec<f64>,
}

/// An overlap of depth 1 on a mesh: on each cell a plane, continuous from cell to cell.
pub(crate) struct Problem<'a> {
    pub mesh: &'a Discretisation,
    /// By cell: value + slope . x, and what that leaves out of the slope and of the value.
    pub planes: &'a [([f64; 3], [f64; 2])],
    /// Its integral over each orbit of loaded cells.
    pub integrals: &'a [f64],
    /// Cells from here on lie beyond the material.
    pub material: usize,
    /// What the overlap on the mesh may be off by.
    pub off: f64,
    /// The smaller it is the farther A has to reach.
    pub tau: f64,
    pub continuation: &'a dyn Fn(Pressures) -> Option<Continuation>,
}

impl Problem<'_> {
    /// By a pressure on these orbits; `None` where something cannot be shown, or takes too long.
    pub fn bounds(&self, set: &[bool]) -> Option<Bounds> {
        let Discretisation { mesh, orbits, lines, compliance, areas, means } = self.mesh;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let tau = self.tau;
        let m: Vec<f64> = solve_on(&factor(compliance, set)?, set, areas).iter().map(|m| m.max(0.0)).collect();
        let least: Vec<f64> = m.iter().map(|m| m / tau).collect();
        let left: Vec<f64> = compliance.product(&least).iter().zip(self.integrals).map(|(u, f)| f - u).collect();
        let more = solve_within(compliance, &left, set);
        // m <= tau p, rounded too.
        let p: Vec<f64> = least.iter().zip(&more).map(|(a, b)| (a + b) * (1.0 + 4.0 * f64::EPSILON)).collect();
        let contact: Vec<bool> = (0..mesh.loaded).map(|cell| set[orbits.orbit[cell]]).collect();
        let (pressure, punch) = (orbits.expand(&p, mesh.loaded), orbits.expand(&m, mesh.loaded));
        let strengths = [&pressure, &punch].map(|p| Lines::strengths(mesh, p));
        let strengths = [strengths[0].as_slice(), strengths[1].as_slice()];
        let Continuation { chi, decay: wider } = (self.continuation)(Pressures { contact: &contact, strengths, tau })?;
        let targets = [Target { pressure: &pressure, overlap: Overlap::Planes(self.planes) }, Target::level(&punch)];
        let beyond = Beyond { contact: &contact, wider: &chi, decay: &wider, material: self.material, tau };
        let decay = decay_lengths(mesh);
        let Parted { residual, punch, wider } = parted(mesh, lines, orbits, &decay, beyond, targets, *means)?;
        let [residual, of_punch, of_wider] = [residual, punch, wider].map(|sums| sums.bound());
        let n = residual.sqrt();
        let more = {
            let (a, b) = (tau * n, of_wider.sqrt());
            (if a <= b { n * b } else { 0.25 * (a + b).powi(2) / tau }) * (1.0 + ROUNDING)
        };
        let less = n * of_punch.sqrt() * (1.0 + ROUNDING);
        let displaced = compliance.product(&p);
        let (force, size) = (dot(&p, areas), dot(&m, self.integrals));
        let work = size - dot(&m, &displaced);
        let rounding = compliance.uncertainty(&p, &m) + ROUNDING * (size + force) + self.off * dot(&m, areas);
        let stored = dot(&p, self.integrals) - 0.5 * dot(&p, &displaced);
        let off = 0.5 * compliance.uncertainty(&p, &p) + ROUNDING * dot(&p, self.integrals) + self.off * force;
        let bounds = Bounds {
            force: [force + work - less - rounding, force + work + more + rounding],
            energy: [stored - off, stored + off + 0.5 * residual],
        };
        let finite = bounds.force.iter().chain(&bounds.energy).all(|x| x.is_finite());
        (finite && bounds.force[0] > 0.0 && bounds.force[0] <= bounds.force[1]).then_some(bounds)
    }
}
