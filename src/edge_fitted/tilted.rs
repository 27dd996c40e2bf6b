//! Flat punches under a tilt, and under a force off their centre: as far as they touch everywhere with a proof, else by the cells that
//! stay in contact.
//!
//! The overlap is f = g . (1, x, y). On a set A of cells the displacement f takes the pressure p with S p = f on A, linear in g: with m_j
//! for (1, x, y)_j the stiffness K_ij = <(1, x, y)_i, m_j> is that of the punch in contact on A, and the form
//!
//! ```text
//! Q(g) = g . K g = max over p on A of 2 <f, p> - <p, S p>,     Q_low <= Q <= Q_low + a(w, w),     w = f - S p on A,
//! ```
//!
//! is bounded from both sides as the energy is (`residual_norm`), whatever the sign of p. With e the unit overlap and any t > 0 the force
//! of A is 4 P_A = Q(t e + g/t) - Q(t e - g/t).
//!
//! **From below.** P >= P_A for every A: m_0 of A displaces by at most 1 everywhere, so that P >= <S m_0, p> = <m_0, S p> >= <m_0, f>
//! (Barber 1974; Shield 1967).
//!
//! **From above.** Where the computed p_h is positive on all of the material, m_h <= tau p_h with a known tau. With u = S p and
//! X = <u - f, p_h>, U - U_low = |p - p_h|^2/2 + X,
//!
//! ```text
//! P = <u, m_h> + <p_h, 1 - S m_h> + <p - p_h, 1 - S m_h> <= P_h + tau X + sqrt(2 (gamma - X) a''),     a'' = a(1 - S m_h, ...),
//! ```
//!
//! with <p_h, 1 - S m_h> = 0 and <f, m_h> = P_h on Galerkin cells; the greatest over 0 <= X <= gamma.
//!
//! Where the punch lifts off, the force of A is stationary in A (Barber 1974): what cells at the line of lift-off leave open is of second
//! order, and estimated by what the force changed by from the mesh before.

use nalgebra::{Matrix3, Vector3};

use super::Limits;
use super::active_set::{balance, factor, solve, solve_on};
use super::compliance::Compliance;
use super::integrand::Sums;
use super::line_potential::Lines;
use super::mesh::{Bilinear, Mesh, Point};
use super::outline::{COARSEST, Fitted, Outline};
use super::region::{Region, regions};
use super::residual_norm::{Target, decay_lengths, norms};
use super::symmetry::Orbits;
use crate::clock::Deadline;

/// What is given of a tilting punch, in the outline's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Given {
    /// f = g . (1, x, y).
    Plane([f64; 3]),
    /// The integrals of p, p x and p y.
    Load([f64; 3]),
}

/// A tilted punch in contact, E* = 1, in the outline's axes.
#[derive(Debug, Clone)]
pub(crate) struct Tilted {
    /// f = plane . (1, x, y).
    pub plane: [f64; 3],
    /// The integrals of p, p x and p y of the computed pressure.
    pub load: [f64; 3],
    /// Their derivatives by the plane.
    pub matrix: [[f64; 3]; 3],
    /// Relative error of its first entry.
    pub stiffness_error: f64,
    /// Bounds of the force at the plane; within its error where it is not proved.
    pub force: [f64; 2],
    /// Whether these are proved: contact everywhere.
    pub proved: bool,
    /// Bounds of the stored energy.
    pub energy: [f64; 2],
    /// Corners and pressure of all cells.
    pub cells: Vec<([Point; 4], f64)>,
    /// The separate regions of contact.
    pub regions: Vec<Region>,
    /// Whether it touches everywhere.
    pub everywhere: bool,
    /// Unknowns of the last mesh.
    pub unknowns: usize,
}

/// Cells are at most this part of the contact over n where it may end inside of the material.
const FINE: f64 = 1.5;

/// Meshes of rising n until the error of the force is within the tolerance. `None` where the outline has no mesh that can be solved on, the
/// load has no balance, and where the time ends before the first one is solved.
#[must_use]
pub(crate) fn tilted(outline: &Outline, given: Given, limits: &Limits) -> Option<Tilted> {
    let mut n = COARSEST;
    let mut most = f64::INFINITY;
    let mut best: Option<Tilted> = None;
    let mut before = limits.deadline.remaining();
    loop {
        let fitted = outline.mesh_within(n, most)?;
        if fitted.mesh.loaded > limits.unknowns {
            return best;
        }
        let loaded = fitted.mesh.loaded;
        let punch = Punch::new(fitted, limits.deadline);
        let Some(mut found) = punch.and_then(|punch| punch.solve(given, outline.displaced())) else { return best };
        if !found.everywhere && most == f64::INFINITY {
            // Where it lifts off cells inside have to be small, too.
            most = FINE * found.extent() / n as f64;
            best = best.or(Some(found));
            continue;
        }
        if let Some(best) = best.as_ref().filter(|_| !found.everywhere) {
            let changed = (found.load[0] - best.load[0]).abs();
            // Under a load what changes is the plane.
            let moved = Vector3::from(found.plane) - Vector3::from(best.plane);
            let moved = (Matrix3::from_fn(|i, j| found.matrix[i][j]) * moved)[0].abs();
            found.widen(changed.max(moved));
        }
        let width = (found.force[1] - found.force[0]) / (found.force[0] + found.force[1]);
        let met = width <= limits.tolerance;
        let next = if found.everywhere {
            ((n as f64 * (width / limits.tolerance).cbrt()).ceil() as usize).max(n + 1).min(2 * n)
        } else {
            n + 2
        };
        if most < f64::INFINITY {
            most = FINE * found.extent() / next as f64;
        }
        best = Some(found);
        let growth = (next * next) as f64 / (n * n) as f64;
        let left = limits.deadline.remaining();
        if met || loaded as f64 * growth > limits.unknowns as f64 || (before - left) * growth > left {
            return best;
        }
        (n, before) = (next, left);
    }
}

impl Tilted {
    /// The size of the contact.
    fn extent(&self) -> f64 {
        let points = || self.regions.iter().flat_map(|region| region.boundary.iter().flatten());
        let range = |k: usize| {
            let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p[k]), b.max(p[k])));
            high - low
        };
        0.5 * range(0).max(range(1))
    }

    /// The same with this much more doubt of the force.
    fn widen(&mut self, force: f64) {
        let share = force / self.load[0];
        self.force = [self.force[0] - force, self.force[1] + force];
        self.energy = [self.energy[0] * (1.0 - share), self.energy[1] * (1.0 + share)];
        self.stiffness_error += share;
    }
}

/// A mesh with its compliance, every cell an unknown.
struct Punch {
    fitted: Fitted,
    orbits: Orbits,
    lines: Lines,
    compliance: Compliance,
    /// Integrals of 1, x and y over the cells, in the mesh's axes.
    weights: [Vec<f64>; 3],
    deadline: Deadline,
}

impl Punch {
    /// `None` once the time is used up.
    fn new(fitted: Fitted, deadline: Deadline) -> Option<Self> {
        let mesh = &fitted.mesh;
        let lines = Lines::new(mesh);
        let orbits = Orbits::new(mesh, &[]);
        let compliance = Compliance::new(mesh, &lines, &orbits, deadline)?;
        let moments: Vec<[f64; 3]> = (0..mesh.loaded).map(|i| Bilinear::new(mesh.corners(i)).moments()).collect();
        let weights = [0, 1, 2].map(|k| moments.iter().map(|m| m[k]).collect());
        Some(Self { fitted, orbits, lines, compliance, weights, deadline })
    }

    fn mesh(&self) -> &Mesh {
        &self.fitted.mesh
    }

    /// The integral of g . (1, x, y) over every cell.
    fn integrals(&self, g: &Vector3<f64>) -> Vec<f64> {
        let [one, x, y] = &self.weights;
        (0..one.len()).map(|i| g[0] * one[i] + g[1] * x[i] + g[2] * y[i]).collect()
    }

    /// The integrals of p, p x and p y.
    fn load(&self, p: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|k, _| p.iter().zip(&self.weights[k]).map(|(p, w)| p * w).sum())
    }

    /// `displaced`: see [`Outline::displaced`].
    fn solve(&self, given: Given, displaced: f64) -> Option<Tilted> {
        let map = self.fitted.basis();
        let (p, g) = match given {
            Given::Plane(plane) => {
                let g = map.transpose() * Vector3::from(plane);
                (solve(&self.compliance, &self.integrals(&g)), g)
            }
            Given::Load(load) => {
                let wanted = map.try_inverse()? * Vector3::from(load);
                balance(&self.compliance, &self.weights, wanted, self.deadline)?
            }
        };
        let contact: Vec<bool> = p.iter().map(|p| *p > 0.0).collect();
        let everywhere = contact.iter().all(|c| *c);
        let own = factor(&self.compliance, &contact)?;
        let each = [0, 1, 2].map(|k| solve_on(&own, &contact, &self.weights[k]));
        let matrix = Matrix3::from_fn(|i, j| each[j].iter().zip(&self.weights[i]).map(|(m, w)| m * w).sum::<f64>());
        let unit = &each[0];
        // t that makes both parts of one size.
        let energy = g.dot(&(matrix * g));
        let t2 = (energy / matrix[(0, 0)]).sqrt();
        if !(t2 > 0.0 && t2.is_finite()) {
            return None;
        }
        let t = t2.sqrt();
        let mixed = |sign: f64| -> (Vec<f64>, Vector3<f64>) {
            let pressure = unit.iter().zip(&p).map(|(m, p)| t * m + sign * p / t).collect();
            (pressure, Vector3::new(t, 0.0, 0.0) + g * (sign / t))
        };
        let ((plus, over), (minus, under)) = (mixed(1.0), mixed(-1.0));
        let e = Vector3::new(1.0, 0.0, 0.0);
        let target = |p, g: &Vector3<f64>| Target { pressure: p, value: g[0], slope: [g[1], g[2]] };
        let targets = [target(unit, &e), target(&plus, &over), target(&minus, &under), target(&p, &g)];
        let decay = decay_lengths(self.mesh());
        let sums = norms(self.mesh(), &self.lines, &self.orbits, &decay, &contact, targets, self.deadline)?;
        let [of_unit, of_plus, of_minus, of_p] = sums.map(|s: Sums| s.bound());
        // What the place of the edges leaves open, of the sizes of both parts.
        let form = |p: &[f64], g: &Vector3<f64>, rest: f64| -> [f64; 2] {
            let (low, off) = (self.form_below(p, g), displaced * (energy / t2 + matrix[(0, 0)] * g.norm_squared()));
            [low - off, low + rest + off]
        };
        let (stiffness, energy) = (form(unit, &e, of_unit), form(&p, &g, of_p));
        let (above, below) = (form(&plus, &over, of_plus), form(&minus, &under, of_minus));
        let load = self.load(&p);
        let low = 0.25 * (above[0] - below[1]);
        let mut high = 0.25 * (above[1] - below[0]);
        let rounding = 1e-12 * (load[0] + above[1] + below[1].abs());
        if everywhere {
            let tau = unit.iter().zip(&p).map(|(m, p)| m / p).fold(0.0, f64::max);
            let (gamma, rest) = (0.5 * (energy[1] - energy[0]), stiffness[1] - stiffness[0]);
            let more = if tau <= (rest / (2.0 * gamma)).sqrt() {
                (2.0 * gamma * rest).sqrt()
            } else {
                tau * gamma + rest / (2.0 * tau)
            };
            let off = 2.0 * self.compliance.uncertainty(&p, unit);
            high = load[0] + more + off + displaced * load[0];
        }
        let force = [low - rounding, high + rounding];
        let finite = force.iter().chain(&energy).all(|x| x.is_finite()) && force[1] > force[0] && energy[0] > 0.0;
        if !(finite && load[0] > 0.0) {
            return None;
        }
        // In the outline's axes.
        let plane = map.transpose().try_inverse()? * g;
        let outer = map * matrix * map.transpose();
        let cells = (0..self.mesh().loaded).map(|i| (self.mesh().corners(i).map(|q| self.fitted.to_outline(q)), p[i]));
        let mut regions = regions(self.mesh(), &contact, &p);
        regions.iter_mut().for_each(|region| region.map(|q| self.fitted.to_outline(q)));
        Some(Tilted {
            plane: plane.into(),
            load: (map * load).into(),
            matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| outer[(i, j)])),
            stiffness_error: (stiffness[1] - stiffness[0]) / (stiffness[1] + stiffness[0]),
            force,
            proved: everywhere,
            energy: energy.map(|q| 0.5 * q),
            cells: cells.collect(),
            regions,
            everywhere,
            unknowns: self.compliance.n,
        })
    }

    /// 2 <f, p> - <p, S p>, from below.
    fn form_below(&self, p: &[f64], g: &Vector3<f64>) -> f64 {
        let work: f64 = p.iter().zip(self.integrals(g)).map(|(p, f)| p * f).sum();
        let size: f64 = p.iter().zip(self.integrals(g)).map(|(p, f)| (p * f).abs()).sum();
        let product: f64 = p.iter().zip(self.compliance.product(p)).map(|(p, u)| p * u).sum();
        2.0 * work - product - self.compliance.uncertainty(p, p) - 4e-12 * size
    }
}
