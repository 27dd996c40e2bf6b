//! Crowned punches: a polynomial of second degree as face, a sharp edge, contact on all of it or on a part that reaches the edge.
//!
//! The cells are those of the flat punch, graded to every edge and no larger than what a pressure that varies needs (`tilted`). On them
//! the pressure is the one of the discrete contact problem. What two meshes change the energy and the force by, which is stationary in the
//! set of cells (Barber 1974), tells the error: taken to fall as n^-2, as it does where cells end the contact in steps. Nothing is proved.

use std::f64::consts::PI;
use std::rc::Rc;

use super::Limits;
use super::estimated::{Estimated, Solved, Touching, centre_of};
use super::mesh::{Bilinear, Point, minus, norm};
use super::outline::{COARSEST, FINE, Fitted, Outline};
use super::region::{Region, regions};
use super::symmetry::Isometry;
use super::tilted::{BEFORE, ENOUGH, LOOK, SLOWEST};
use super::tilted_mesh::FINEST;
use crate::gap::Quadratic;

/// Orders that errors of force and energy are taken to fall with where the end of the contact is not resolved, the force stationary in it.
const ORDER: f64 = 2.0;
const OF_ENERGY: f64 = 1.0;

/// What the force errs by at least over the square of what the end of the contact leaves open of the area, in which it is stationary: 0.13 was
/// seen where two coarse meshes agreed by chance.
const OF_END: f64 = 0.16;

/// The order that no error is taken to fall faster with: two meshes may agree by chance.
const FASTEST: f64 = 3.0;

/// The least width over the length of a contact that lifts off: cells for less are too many, and too few tell too small an error.
const SLENDEREST: f64 = 0.25;

/// Meshes at most.
const ROUNDS: usize = 5;

/// Share of the tolerance that the next mesh aims at.
const AIM: f64 = 0.9;

/// A crowned punch in contact, in the outline's axes.
pub(crate) struct Crowned {
    pub state: Estimated,
    /// An estimate of the relative error of the stored energy.
    pub energy_error: f64,
    /// The separate regions of contact.
    pub regions: Vec<Region>,
    /// Whether it touches everywhere.
    pub everywhere: bool,
}

/// The contact of the overlap `f` on the material inside an outline. `None` where it does not reach the edge, where the outline has no
/// mesh that can be solved on, and where the time ends before two of them are.
#[must_use]
pub(crate) fn crowned(outline: &Outline, f: &Quadratic, limits: &Limits) -> Option<Crowned> {
    let unknowns = limits.unknowns + limits.unknowns / 2;
    let limits = &Limits { unknowns, ..*limits };
    let solve = |n: usize, most: f64| State::new(outline, f, n, most, limits);
    let look = solve(COARSEST, 0.5 * LOOK * outline.extent()).or_else(|| solve(COARSEST, f64::INFINITY));
    let look = look.filter(|look| look.reaches_edge)?;
    let mut size = look.size;
    let enough = (ENOUGH[0] + ENOUGH[1] * look.varies) * (1e-3 / limits.tolerance).cbrt();
    let enough = (enough.round() as usize).min(FINEST);
    let mut n = ((BEFORE * enough as f64).round() as usize).max(COARSEST);
    let mut before: Option<(usize, Rc<State>)> = None;
    let mut best: Option<(f64, Crowned, Rc<State>)> = None;
    let (mut last, mut left) = (None, limits.deadline.remaining());
    for _ in 0..ROUNDS {
        let Some(state) = solve(n, FINE * size / n as f64).filter(|state| state.reaches_edge) else { break };
        let state = Rc::new(state);
        size = state.size;
        let Some((coarser, other)) = before.take() else {
            before = Some((n, state));
            n = enough.max(n + 1);
            continue;
        };
        let finer = n as f64 / coarser as f64;
        let mut found = state.after(&other, finer);
        before = Some((n, Rc::clone(&state)));
        let least = last.map_or(0.0, |error: f64| error * finer.powf(-FASTEST));
        let error = found.state.error.max(least);
        (found.state.error, found.energy_error) = (error, found.energy_error.max(error));
        last = Some(error);
        let seen = best.as_ref().map(|(error, ..)| *error);
        if seen.is_none_or(|least| error < least) {
            best = Some((error, found, state));
        }
        let order = seen.map_or(ORDER, |before| (before / error).ln() / finer.ln());
        let wanted = n as f64 * (error / (AIM * limits.tolerance)).powf(1.0 / order.clamp(SLOWEST, FASTEST));
        let next = (wanted.ceil() as usize).max(n + 1).min(2 * n).min(FINEST);
        let growth = (next * next) as f64 / (n * n) as f64;
        let remaining = limits.deadline.remaining();
        if error <= limits.tolerance || next <= n || (left - remaining) * growth > remaining {
            break;
        }
        (n, left) = (next, remaining);
    }
    let (_, mut found, state) = best?;
    found.state = found.state.with_tilts(&state.solved, Touching::Some, limits)?;
    found.state.stiffness_matrix = found.state.stiffness_matrix.map(|own| own.in_axes(|q| state.fitted.to_outline(q)));
    Some(found)
}

/// One mesh, solved.
struct State {
    fitted: Fitted,
    solved: Solved,
    regions: Vec<Region>,
    /// Corners and pressure of the cells in contact, in the outline's axes.
    cells: Vec<([Point; 4], f64)>,
    everywhere: bool,
    reaches_edge: bool,
    /// Share of the largest overlap that it varies by.
    varies: f64,
    /// Half the extent of the contact, longer where the overlap varies less.
    size: f64,
    /// Where the resultant of the pressure acts.
    centre: Point,
}

impl State {
    fn new(outline: &Outline, f: &Quadratic, n: usize, most: f64, limits: &Limits) -> Option<Self> {
        let fitted = outline.mesh_within(n, most)?;
        let outward = |q: Point| fitted.to_outline(q);
        let mesh = fitted.mesh.with(|corners| overlaps(f, &corners.map(outward)))?;
        let all = mesh.loaded == fitted.mesh.loaded;
        let group: Vec<Isometry> = fitted.group.iter().filter(|g| keeps(f, &fitted, g)).copied().collect();
        let overlap = |q: Point| f.about(outward(q)).value;
        let solved = Solved::new(mesh, &group, &overlap, Touching::Some, limits)?;
        let contact: Vec<bool> = solved.pressure.iter().map(|p| *p > 0.0).collect();
        let mut regions = regions(&solved.mesh, &contact, &solved.pressure, &|_| false);
        regions.iter_mut().for_each(|region| region.map(outward));
        let cells: Vec<_> = solved.cells(Touching::Some).into_iter().map(|(c, p)| (c.map(outward), p)).collect();
        let corners = || cells.iter().flat_map(|(corners, _)| *corners);
        let range = |of: &dyn Fn(Point) -> f64| {
            corners().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
        };
        let extent = |k: usize| {
            let (low, high) = range(&|p| p[k]);
            high - low
        };
        let (low, high) = range(&|p| f.about(p).value);
        let varies = ((high - low) / high).clamp(1e-3, 1.0);
        let everywhere = all && contact.iter().all(|c| *c);
        let (length, area) = (extent(0).max(extent(1)), regions.iter().map(|region| region.area).sum::<f64>());
        // Where it lifts off cells have to follow what it is wide.
        let width = if everywhere { length } else { area / length };
        let size = 0.5 * (length * width).sqrt() * varies.powf(-2.0 / 3.0);
        let centre = centre_of(&cells);
        let reaches_edge = cells.iter().any(|(corners, _)| touches(outline, corners));
        let finite = solved.force > 0.0 && solved.stiffness > 0.0 && size > 0.0;
        (finite && width >= SLENDEREST * length).then_some(Self {
            fitted,
            solved,
            regions,
            cells,
            everywhere,
            reaches_edge,
            varies,
            size,
            centre,
        })
    }

    /// With errors by what changed since a mesh that was coarser by `ratio`.
    fn after(&self, coarser: &Self, ratio: f64) -> Crowned {
        let own = &self.solved;
        let change = |of: fn(&Solved) -> f64, order: f64| {
            (of(own) / of(&coarser.solved) - 1.0).abs() / (ratio.powf(order) - 1.0)
        };
        // Moments are as near as the force where it acts on the size of the contact.
        let area: f64 = self.regions.iter().map(|region| region.area).sum();
        let moved = norm(minus(self.centre, coarser.centre)) / (area / PI).sqrt() / (ratio.powf(ORDER) - 1.0);
        let off: f64 = self.regions.iter().map(|region| 0.5 * region.doubt).sum();
        let area_error = off / area;
        let changed = change(|s| s.energy, ORDER).max(change(|s| s.force, ORDER));
        let error = changed.max(moved).max(OF_END * area_error * area_error);
        let state = Estimated {
            force: own.force,
            error,
            energy: own.energy,
            stiffness: own.stiffness,
            // It follows the end of the contact, which is known to a cell.
            stiffness_error: error.max(change(|s| s.stiffness, 1.0)).max(0.5 * area_error),
            stiffness_matrix: None,
            area,
            area_error,
            max_error: None,
            cells: self.cells.clone(),
            ends: self.regions.iter().flat_map(|region| region.boundary.clone()).collect(),
            unknowns: own.unknowns,
        };
        Crowned {
            state,
            // The energy comes from below alone, and more slowly where the end of the contact is not resolved.
            energy_error: error.max(change(|s| s.energy, OF_ENERGY)),
            regions: self.regions.clone(),
            everywhere: self.everywhere,
        }
    }
}

/// Whether the overlap may be positive in a cell: its value in the middle and the most that it rises by from there.
fn overlaps(f: &Quadratic, corners: &[Point; 4]) -> bool {
    let centre = Bilinear::new(*corners).centre;
    let reach = corners.iter().map(|p| norm(minus(*p, centre))).fold(0.0, f64::max);
    let Quadratic { value, gradient, hessian: [xx, xy, yy], .. } = f.about(centre);
    let curvature = xx.abs().max(yy.abs()) + xy.abs();
    value + reach * (norm(gradient) + 0.5 * reach * curvature) > 0.0
}

/// Points that tell a polynomial of second degree from any other.
const TELLING: [Point; 6] = [[0.1, 0.2], [0.9, -0.1], [-0.3, 0.8], [-0.7, -0.6], [0.5, 0.7], [0.4, -0.9]];

/// Relative difference of values that are the same but for rounding.
const ROUNDING: f64 = 1e-12;

/// Whether a symmetry of the mesh is one of the overlap.
fn keeps(f: &Quadratic, fitted: &Fitted, g: &Isometry) -> bool {
    let at = |q: Point| f.about(fitted.to_outline(q)).value;
    let [h, k] = [[f.hessian[0], f.hessian[1]], [f.hessian[1], f.hessian[2]]];
    let size = f.about([0.0; 2]).value.abs() + norm(f.about([0.0; 2]).gradient) + norm(h) + norm(k);
    TELLING.into_iter().all(|q| (at(g.apply(q)) - at(q)).abs() <= ROUNDING * size)
}

/// Whether a side of a cell lies on the outline.
fn touches(outline: &Outline, cell: &[Point; 4]) -> bool {
    let sides = (0..4).map(|k| (cell[k], cell[(k + 1) % 4]));
    sides.filter(|(a, b)| a != b).any(|(a, b)| outline.is_along_edge(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_fitted::{Frame, Given, tilted};

    fn square() -> Outline {
        Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap()
    }

    #[test]
    fn a_plane_is_a_tilted_punch() {
        let outline = Outline::polygon(&[[-1.0, -0.8], [1.0, -0.5], [0.3, 0.9]]).unwrap();
        for slope in [0.2, 0.9, 1.1] {
            let f = Quadratic { about: [0.0; 2], value: 1.0, gradient: [slope, 0.3], hessian: [0.0; 3] };
            let found = crowned(&outline, &f, &Limits::default()).unwrap();
            let plane = tilted(
                &outline,
                Given::Plane([1.0, slope, 0.3]),
                &Frame::OWN,
                &Limits { proof: false, ..Limits::default() },
            );
            let plane = plane.unwrap();
            let [low, high] = plane.force;
            let force = 0.5 * (low + high);
            let error = found.state.error + 0.5 * (high - low) / force;
            assert!((found.state.force / force - 1.0).abs() <= error, "{slope}");
            assert_eq!(found.everywhere, plane.everywhere, "{slope}");
        }
    }

    #[test]
    fn a_disc_with_a_spherical_face() {
        // D(s) = 1 - s^2/R: P = 2 (1 - 1/(3 R)), dP/dd = 2, U = integral of D^2 (Sneddon 1965).
        for r in [1.5, 5.0, -2.0] {
            let f = Quadratic { about: [0.0; 2], value: 1.0, gradient: [0.0; 2], hessian: [-1.0 / r, 0.0, -1.0 / r] };
            let Crowned { state, everywhere, energy_error, .. } =
                crowned(&Outline::ellipse([1.0; 2]), &f, &Limits::default()).unwrap();
            assert!(everywhere && state.error <= 1e-3);
            let (force, energy) = (2.0 - 2.0 / (3.0 * r), 1.0 - 2.0 / (3.0 * r) + 0.2 / (r * r));
            assert!((state.force / force - 1.0).abs() <= state.error, "{r} {} {}", state.force, state.error);
            assert!((state.energy / energy - 1.0).abs() <= energy_error, "{r} {} {energy_error}", state.energy);
            assert!((0.5 * state.stiffness - 1.0).abs() <= state.stiffness_error, "{r} {}", state.stiffness);
        }
    }

    #[test]
    fn a_state_keeps_its_laws() {
        // dP/dd by differences, and dU/dd = P; symmetries of the outline that the overlap has not are none.
        let outline = square();
        let at = |d: f64| {
            let f = Quadratic { about: [0.1, 0.0], value: d, gradient: [0.0; 2], hessian: [-0.9, -0.1, -0.4] };
            crowned(&outline, &f, &Limits { tolerance: 1e-4, ..Limits::default() }).unwrap().state
        };
        let (less, state, more) = (at(0.99), at(1.0), at(1.01));
        assert!(state.error <= 1e-4);
        assert!(((more.force - less.force) / (0.02 * state.stiffness) - 1.0).abs() < 2e-2);
        assert!(((more.energy - less.energy) / (0.02 * state.force) - 1.0).abs() < 2e-2);
    }
}
