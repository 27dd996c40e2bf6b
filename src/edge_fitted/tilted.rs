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
//! **From above.** Where the computed p_h is positive on all of the material, take any tau > 0, q = max(m_h - tau p_h, 0) and
//! m' = m_h - q <= tau p_h. With u = S p, the least energy gamma above U_low, a'' = a(1 - S m_h, 1 - S m_h) and X = <u - f, p_h>,
//! U - U_low = |p - p_h|^2/2 + X. On Galerkin cells 1 - S m_h and f - S p_h are orthogonal to all pressures of the mesh, so that
//! <p_h, S q> = <f, q>, <f, m_h> = P_h, a(1 - S m', 1 - S m') = a'' + <q, S q>, and
//!
//! ```text
//! P = <u, m'> + <p_h, 1 - S m'> + <p - p_h, 1 - S m'>
//!   <= P_h + max over X in [0, gamma] of tau X + sqrt(2 (gamma - X) (a'' + <q, S q>)):
//! ```
//!
//! sqrt(2 gamma a) with a = a'' + <q, S q> where tau is at most sqrt(a/(2 gamma)), else tau gamma + a/(2 tau). Where p_h all but vanishes in
//! a corner, q takes it out.
//!
//! Thin cells between larger ones take up what these leave, and may be pulled although nothing lifts off there: under a given plane they
//! get a pressure as of their neighbours. With p_h + d > 0 in place of p_h, by the same orthogonality, gamma grows by <d, S d>/2, and
//! <p_h + d, 1> + <m', f - S (p_h + d)> = P_h + <q, S d>.
//!
//! **Moments.** The same for psi = x or y in place of 1, m_h being its pressure: whatever the sign of m', <u - f, m'> <= tau X for
//! m' <= tau p_h, so that <psi, p> <= <psi, p_h> + max over X of tau X + sqrt(2 (gamma - X) (a'' + <q, S q>)), and by -psi from below.
//!
//! **The plane under a load w** = (integrals of p, p x, p y): g = K^-1 w of the computed pressure. Let c = K^-1 e, m the pressure of the
//! plane c, so that its load is e, and rho = c . (1, x, y) - S m. For the exact g* and p*, s = S p* - f* >= 0 on the material,
//! <s, p*> = 0:
//!
//! ```text
//! <S p*, m> = g* . e + <s, m> = <p*, c . (1, x, y)> - <p*, rho> = c . w - <p*, rho>,   <p_h, rho> = 0,   c . w = g . e
//! g* . e = g . e - <p* - p_h, rho> - <s, m>.                                                                          (10)
//! ```
//!
//! p* and p_h have one load, so that <S p_h, p_h>/2 - <S p*, p*>/2 = X + |p* - p_h|^2/2 with X = <s, p_h>, and by w . g <= U(g) + U*(w)
//! both are at most gamma: with -tau' p_h <= m <= tau p_h the depth g* . e, e = (1, x, y) of where it is asked for, is bounded as the force
//! is, a'' that of rho. Where p_h all but vanishes, m is cut there as above, by q = max(m - tau p_h, 0), and c = K^-1 (e + load of q) takes
//! on its load: m' = m - q has the load e, and with rho' = rho + S q, <p_h, rho'> = <f_h, q> = g . load of q, (10) holds for m' and rho',
//! whatever q is; a(rho', rho') = a(rho, rho) + <q, S q>. With the load (0, 1, 0) for e it is the tilt that is bounded. The norms of all
//! these planes are one quadratic form (`residual_form`).
//!
//! Where the punch lifts off, nothing is proved: U_low rises to U as n^-3 and tells its own error from two meshes; the force of A is
//! stationary in A (Barber 1974), so that it errs by no more, and is held against its own change.

use nalgebra::{Matrix3, Vector3};

use super::Limits;
use super::flat::AIM;
use super::outline::{COARSEST, FINE, Outline};
use super::tilted_bounds::Tilted;
use super::tilted_mesh::{FINEST, Frame, Given, Punch};

/// n that is mostly enough for an error of 1e-3 where it lifts off: of a level punch, and more by the share that f varies by.
pub(super) const ENOUGH: [f64; 2] = [4.5, 1.3];

/// The mesh before the first one, where it lifts off, over that.
pub(super) const BEFORE: f64 = 0.67;

/// The n of a mesh that another one is held against, over its own, at most where there is one.
const APART: f64 = 0.75;

/// The least n of a mesh that only tells what a finer one leaves.
const FEWEST: usize = 2;

/// The least order that the error is taken to fall with.
pub(super) const SLOWEST: f64 = 0.5;

/// Cells of the first look, over half the size of the outline.
pub(super) const LOOK: f64 = 0.4;

/// Meshes of rising n until the error of the force is within the tolerance. `None` where the outline has no mesh that can be solved on, the
/// load has no balance, and where the time ends before the first one is solved.
#[must_use]
pub(crate) fn tilted(outline: &Outline, given: Given, frame: &Frame, limits: &Limits) -> Option<Tilted> {
    // Without symmetry, and mostly without a proof, which is what takes the time.
    let unknowns = limits.unknowns + limits.unknowns / 2;
    // Where fewer leave too much.
    let at_most = 2 * limits.unknowns;
    let punch = |n: usize, most: f64| {
        let fitted = outline.mesh_within(n, most).filter(|fitted| fitted.mesh.loaded <= at_most)?;
        Punch::new(fitted, limits.means())
    };
    // A look at what is in contact, for the size of the cells.
    let look = punch(COARSEST, 0.5 * LOOK * outline.extent()).or_else(|| punch(COARSEST, f64::INFINITY))?;
    let first = look.pressed(given)?;
    if let Some(part) = in_reach(outline, look.outer_plane(&first)?, given)
        && let Some(mut found) = tilted(&part, given, frame, &Limits { proof: false, ..*limits })
        && !outline.beyond(&part, found.plane)
    {
        (found.everywhere, found.proved) = (false, false);
        return Some(found);
    }
    let mut size = first.size(outline);
    let provable = outline.is_covered() && limits.proof;
    let lifts = first.lifts() || !provable;
    let enough = (ENOUGH[0] + ENOUGH[1] * first.varies) * (1e-3 / limits.tolerance).cbrt();
    let enough = enough.round().min(FINEST as f64);
    let mut n = if lifts {
        ((BEFORE * enough).round() as usize).max(COARSEST)
    } else {
        look.enough(&first, given, outline, AIM * limits.tolerance)
    };
    // An estimate takes two meshes.
    let second = |n: usize| (n as f64 / BEFORE).ceil().min(enough).max(n as f64 + 1.0);
    let last = |n: usize| if lifts { second(n) as usize } else { n };
    let is_within = |unknowns: usize, n: usize, size: f64| {
        let most = FINE * size / n as f64;
        outline.mesh_within(n, most).is_some_and(|fitted| fitted.mesh.loaded <= unknowns)
    };
    let fits = |n: usize, size: f64| is_within(unknowns, n, size);
    while n > COARSEST && !fits(last(n), size) {
        n -= 1;
    }
    let mut meshes: Vec<(usize, Tilted)> = Vec::new();
    let mut before = limits.deadline.remaining();
    // The look that tells how fine a mesh proves enough: a coarse one may see no contact in a corner.
    let mut told = !lifts || !provable;
    loop {
        let found = punch(n, FINE * size / n as f64).and_then(|punch| Some((punch.pressed(given)?, punch)));
        if let Some((pressed, punch)) = &found {
            size = pressed.size(outline);
            if !pressed.lifts() && !told {
                told = true;
                let wanted = punch.enough(pressed, given, outline, AIM * limits.tolerance);
                if let Some(finer) = (n + 1..=wanted).rev().find(|n| fits(*n, size)) {
                    n = finer;
                    continue;
                }
            }
        }
        let found = found.and_then(|(pressed, punch)| punch.bounded(&pressed, given, frame, outline, provable));
        // Too many cells: one that is not as fine as it should be is better than none.
        let found = found.or_else(|| {
            if meshes.is_empty() { punch(n, f64::INFINITY)?.answer(given, frame, outline, provable) } else { None }
        });
        let Some(mut found) = found else { return meshes.pop().map(|(_, best)| best) };
        // A coarser mesh, which only tells what this one leaves.
        let on_coarser = |coarser: usize| {
            let punch = punch(coarser, FINE * size / coarser as f64)?;
            Some((coarser, punch.answer(given, frame, outline, false)?))
        };
        if !found.proved {
            found.estimate(n, compared(&meshes, n));
            if meshes.is_empty() && !fits(second(n) as usize, size) {
                // No finer one can follow: a coarser one tells as well.
                let coarser = ((BEFORE * n as f64).round() as usize).max(FEWEST);
                if let Some((coarser, other)) = on_coarser(coarser) {
                    found.estimate(n, Some((coarser, &other)));
                }
            }
        }
        let width = found.width();
        if width <= limits.tolerance {
            return Some(found);
        }
        // What cells at many corners leave falls more slowly.
        let order = meshes.last().filter(|(_, before)| before.width() < 1.0).map_or(3.0, |(coarser, before)| {
            let seen = (before.width() / width).ln() / (n as f64 / *coarser as f64).ln();
            seen.clamp(SLOWEST, 3.0)
        });
        let wanted =
            if width < 1.0 { n as f64 * (width / (AIM * limits.tolerance)).powf(1.0 / order) } else { second(n) };
        let finest = ((0.98 * wanted).ceil() as usize).max(n + 1).min(2 * n);
        let next =
            [unknowns, at_most].iter().find_map(|most| (n + 1..=finest).rev().find(|k| is_within(*most, *k, size)));
        let next = next.unwrap_or(n);
        let growth = (next * next) as f64 / (n * n) as f64;
        let left = limits.deadline.remaining();
        let last = next <= n || (before - left) * growth > left;
        if last && found.proved {
            // More than can be proved can be told.
            let again = || on_coarser(((BEFORE * n as f64) as usize).max(COARSEST));
            if let Some((coarser, other)) = meshes.pop().or_else(again).filter(|(coarser, _)| *coarser < n) {
                let mut told = found.clone();
                told.estimate(n, Some((coarser, &other)));
                (told.proved, told.depth, told.tilts, told.moments) = (false, None, None, None);
                if told.force[1] - told.force[0] <= limits.tolerance * (told.force[0] + told.force[1]) {
                    return Some(told);
                }
            }
        }
        if last {
            return Some(found);
        }
        meshes.push((n, found));
        (n, before) = (next, left);
    }
}

/// The mesh that tells what one of this n leaves. The line of lift-off lies anywhere in a cell: of what changes between two meshes that are
/// nearly alike most is chance, and the order it is divided by nearly zero.
fn compared(meshes: &[(usize, Tilted)], n: usize) -> Option<(usize, &Tilted)> {
    let apart = meshes.iter().rev().find(|(coarser, _)| *coarser as f64 <= APART * n as f64);
    apart.or(meshes.first()).map(|(coarser, found)| (*coarser, found))
}

/// What of an outline can touch: nothing does where f <= 0; where f is not given, with room for what the look at it leaves open. A small
/// part of a polygon is worth a mesh of its own, else cells are left out. `None` where that is all of it, or was done.
fn in_reach(outline: &Outline, plane: [f64; 3], given: Given) -> Option<Outline> {
    let room = match given {
        Given::Plane(_) => 0.0,
        Given::Load(_) => ROOM,
    };
    let [c, a, b] = plane;
    let most = outline.corners().iter().map(|[x, y]| c + a * x + b * y).fold(0.0, f64::max);
    let small = outline.part([c + room * most, a, b]).filter(|part| part.extent() <= SMALL * outline.extent());
    small.or_else(|| outline.within([c + (room + MARGIN) * most, a, b]).filter(|_| !outline.is_limited()))
}

/// Of the largest f: so that cells in contact have neighbours which are not.
const MARGIN: f64 = 0.05;

/// Of the largest f.
const ROOM: f64 = 0.3;

/// Size of a part over that of the outline below which it is worth a mesh of its own.
const SMALL: f64 = 0.7;

impl Tilted {
    /// Half of it, relative.
    fn width(&self) -> f64 {
        (self.force[1] - self.force[0]) / (self.force[0] + self.force[1])
    }

    /// Where it lifts off: what energy and force still change by, after what they changed by since the mesh before.
    fn estimate(&mut self, n: usize, before: Option<(usize, &Self)>) {
        let told = before.and_then(|(coarser, before)| {
            // Cells may be fewer than n asks for: not finer along all sides.
            let cells = (self.unknowns as f64 / before.unknowns as f64).sqrt();
            let ratio = cells.min(n as f64 / coarser as f64);
            (ratio > 1.0).then_some((ratio, before))
        });
        let Some((ratio, before)) = told else {
            self.force[0] = 0.0;
            self.force[1] = 2.0 * self.load[0];
            self.stiffness_error = 1.0;
            return;
        };
        // Under a load what changes is the plane: the load that this takes, its moments about where it acts over the size of the contact.
        let moved = Vector3::from(self.plane) - Vector3::from(before.plane);
        let moved = Matrix3::from_fn(|i, j| self.matrix[i][j]) * moved;
        let about = |k: usize| moved[k] - self.load[k] / self.load[0] * moved[0];
        let size = (self.area() / std::f64::consts::PI).sqrt();
        let moved = moved[0].abs().max(about(1).hypot(about(2)) / size);
        let changed = (self.load[0] - before.load[0]).abs().max(moved) / self.load[0];
        // At one plane: U is homogeneous of degree 2 in it.
        let turned =
            |state: &Self| state.energy[0] / (0..3).map(|k| state.plane[k] * self.load[k]).sum::<f64>().powi(2);
        let stored = (turned(self) / turned(before) - 1.0).abs() / (ratio.powi(3) - 1.0);
        let error = stored.max(changed / (ratio.powi(2) - 1.0));
        self.force = [self.load[0] * (1.0 - error), self.load[0] * (1.0 + error)];
        self.energy[1] = self.energy[0] * (1.0 + 2.0 * stored);
        // The stiffness follows the line of lift-off, which is known to a cell: of the first order, and half of what that leaves of the area.
        let stiffer = (self.matrix[0][0] / before.matrix[0][0] - 1.0).abs() / (ratio - 1.0);
        self.stiffness_error = error.max(stiffer).max(0.5 * self.area_error());
    }

    fn area(&self) -> f64 {
        self.regions.iter().map(|region| region.area).sum()
    }

    /// What the line of lift-off leaves of the area, relative.
    pub fn area_error(&self) -> f64 {
        let off: f64 = self.regions.iter().map(|region| 0.5 * region.doubt).sum();
        off / self.area()
    }
}
