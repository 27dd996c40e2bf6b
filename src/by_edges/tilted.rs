//! A flat face in a polygon that is tilted, or free to tilt: contact everywhere, or on a part of it.

use nalgebra::{Matrix3, Vector3};

use super::flat::Flat;
use super::{Found, Moments, field_grid};
use crate::edge_fitted::{Frame, Given, Limits, Tilted, resample, tilted};
use crate::gap::Face;
use crate::numeric::geometry::{Rect, convex_hull, left_of};
use crate::problem::{Contact, Settings};
use crate::solution::{PairBracket, Unsolved, Verdict};

/// A polygon with the plane of its face: the gap at x is value + slope . (x - at).
pub(crate) struct Tilting {
    flat: Flat,
    slope: [f64; 2],
    at: [f64; 2],
}

/// A punch free to tilt.
pub(super) struct Free {
    pub found: Found,
    pub depth: f64,
    pub tilt: [f64; 2],
    /// Of the depth, proved.
    pub bounds: Option<[f64; 2]>,
    pub bounds_of_tilt: Option<PairBracket>,
}

impl Tilting {
    /// `None` where cells cannot be fitted to the face.
    pub fn of(face: &Face) -> Option<Self> {
        let flat = Flat::outlined(face).or_else(|| Flat::ellipse(face))?;
        Some(Self { flat, slope: face.slope, at: face.at })
    }

    pub fn found(&self) -> String {
        if self.flat.outline.is_curved() {
            return "a flat ellipse with a sharp edge, tilted or free to tilt".to_owned();
        }
        format!("a flat polygon of {} corners with sharp edges, tilted or free to tilt", self.flat.corners.len())
    }

    /// Where the line of action meets the surface, in the outline's axes.
    fn through(&self, force: f64, moment: [f64; 2]) -> [f64; 2] {
        self.flat.inward([-moment[1] / force, moment[0] / force])
    }

    /// Whether it is known to touch everywhere under this force: an ellipse, which then has a formula.
    pub(super) fn is_core(&self, force: f64, moment: [f64; 2]) -> bool {
        self.flat.outline.touches_everywhere(self.through(force, moment))
    }

    /// The user's axes in the outline's: the depth is that at the user's origin.
    fn frame(&self) -> Frame {
        let [cos, sin] = self.flat.turn;
        Frame { origin: self.flat.inward([0.0; 2]), along: [[cos, -sin], [sin, cos]] }
    }

    /// (1, x, y) of the user's frame as combinations of those of the outline's.
    fn basis(&self) -> Matrix3<f64> {
        let Flat { origin: [x, y], turn: [cos, sin], length: l, .. } = self.flat;
        Matrix3::new(1.0, 0.0, 0.0, x, l * cos, -l * sin, y, l * sin, l * cos)
    }

    /// The state at a depth, the tilt being in the slope of the face.
    pub(super) fn at(&self, contact: &Contact, depth: f64, settings: &Settings, limits: &Limits) -> Option<Found> {
        let Flat { origin, turn: [cos, sin], length, value, .. } = self.flat;
        let [a, b] = self.slope;
        let centre = depth - value + a * (self.at[0] - origin[0]) + b * (self.at[1] - origin[1]);
        let plane = [centre, -length * (cos * a + sin * b), -length * (cos * b - sin * a)];
        let unit = plane.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let given = Given::Plane(plane.map(|c| c / unit));
        let state = tilted(&self.flat.outline, given, &self.frame(), limits)?;
        Some(self.state(contact, state, unit, settings))
    }

    /// The state under a force and moments about the user's origin, with its depth and tilts.
    pub(super) fn under(
        &self,
        contact: &Contact,
        force: f64,
        moment: [f64; 2],
        settings: &Settings,
        limits: &Limits,
    ) -> Option<Free> {
        if self.is_core(force, moment) {
            return None;
        }
        let Flat { origin, turn: [cos, sin], length, value, .. } = self.flat;
        let [x, y] = self.through(force, moment);
        let state = tilted(&self.flat.outline, Given::Load([1.0, x, y]), &self.frame(), limits)?;
        // Forces are E* length depth, and all is linear.
        let per = force / (contact.modulus().e_star() * length);
        // The middle of the bounds is taken for the force of the plane.
        let unit = per / (0.5 * (state.force[0] + state.force[1]));
        let [centre, u, v] = state.plane.map(|c| c * unit);
        let lean = [(cos * u - sin * v) / length, (sin * u + cos * v) / length];
        let tilt = [0, 1].map(|m| lean[m] + self.slope[m]);
        let back = |m: usize| lean[m] * origin[m] + self.slope[m] * self.at[m];
        let level = |own: f64| own + value - self.slope[0] * self.at[0] - self.slope[1] * self.at[1];
        let depth = centre + value - back(0) - back(1);
        // Of the load itself.
        let own = per / state.load[0];
        let bounds = state.depth.map(|ends| ends.map(|end| level(end * own)));
        let slopes = |m: usize, ends: [f64; 2]| ends.map(|end| end * own / length + self.slope[m]);
        let bounds_of_tilt = state.tilts.map(|[x, y]| PairBracket::proved([slopes(0, x), slopes(1, y)]));
        let tilt = bounds_of_tilt.map_or(tilt, |bounds| bounds.nearest(tilt));
        let depth = bounds.map_or(depth, |[low, high]| depth.clamp(low, high));
        Some(Free { found: self.state(contact, state, unit, settings), depth, tilt, bounds, bounds_of_tilt })
    }

    /// In the user's units; `unit`: that of the overlap.
    fn state(&self, contact: &Contact, state: Tilted, unit: f64, settings: &Settings) -> Found {
        let (flat, length, e_star) = (&self.flat, self.flat.length, contact.modulus().e_star());
        let of_force = e_star * length * unit;
        let basis = self.basis();
        // Of the middle of the bounds, through where the computed pressure acts.
        let middle = 0.5 * (state.force[0] + state.force[1]) / state.load[0];
        let load = basis * Vector3::from(state.load) * (middle * of_force);
        let moment = [load[2], -load[1]];
        let of_moment = of_force * length;
        let bounds = state.moments.map(|[[x0, x1], [y0, y1]]| {
            PairBracket::proved([[of_moment * y0, of_moment * y1], [-of_moment * x1, -of_moment * x0]])
        });
        let moment = bounds.map_or(moment, |bounds| bounds.nearest(moment));
        let matrix = basis * Matrix3::from_fn(|i, j| state.matrix[i][j]) * basis.transpose() * (e_star * length);
        let reference = contact.gap().known().reference;
        let patch = flat.patch(&state.regions, of_force, reference);
        let of_pressure = e_star * unit / length;
        let cells: Vec<_> = state.cells.iter().map(|(c, p)| (c.map(|q| flat.outward(q)), p * of_pressure)).collect();
        let boundary = patch.boundary.iter().flatten().flatten().copied();
        let rect = Rect::holding(boundary).unwrap_or(Rect::around(flat.origin, [length; 2]));
        let strongest =
            cells.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(flat.origin, |(c, _)| super::flat::middle(c));
        let touch =
            if state.everywhere { "it touches everywhere" } else { "it touches on a part, and lifts off elsewhere" };
        Found {
            force: state.force.map(|p| p * of_force),
            energy: state.energy.map(|u| u * of_force * unit),
            stiffness: matrix[(0, 0)],
            stiffness_error: Some(state.stiffness_error),
            area_error: Some(state.area_error() + super::flat::ROUNDING),
            patch,
            centre: flat.centre_of(&cells),
            max: None,
            max_error: None,
            at: strongest,
            field: settings.outputs.pressure.then(|| resample(&cells, field_grid(&rect))),
            unknowns: state.unknowns,
            how: format!("the gap is {}: {touch}", self.found()),
            left_out: "the surface grid: cells follow the edges of the material",
            proved: state.proved,
            tilting: Some(Moments {
                moment: Some(moment),
                bounds,
                matrix: [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)])),
            }),
        }
    }
}

/// # Errors
/// `NoEquilibrium` where the line of action meets the surface outside of the convex hull of the face: no pressure acts there.
pub(super) fn balances(face: &Face, force: f64, moment: [f64; 2]) -> Result<(), Unsolved> {
    let [x, y] = [-moment[1] / force, moment[0] / force];
    let (sin, cos) = face.turn.sin_cos();
    let [u, v] = [x - face.at[0], y - face.at[1]];
    let at = [cos * u + sin * v, cos * v - sin * u];
    let inside = match face.outline.semi_axes() {
        Some([a, b]) => (at[0] / a).hypot(at[1] / b) < 1.0,
        None => contains(&convex_hull(face.outline.corners().to_vec()), at),
    };
    if inside {
        return Ok(());
    }
    let reason =
        format!("the line of action meets the surface at ({x:e}, {y:e}), outside of the convex hull of all material");
    Err(Unsolved::new(Verdict::NoEquilibrium, reason))
}

/// Whether a point lies inside of a convex polygon.
fn contains(polygon: &[[f64; 2]], p: [f64; 2]) -> bool {
    (0..polygon.len()).all(|k| left_of(polygon[k], polygon[(k + 1) % polygon.len()], p) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_leaves_out_what_is_inside() {
        let star = [[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]];
        assert_eq!(convex_hull(star.to_vec()), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert!(
            contains(&convex_hull(star.to_vec()), [1.9, 1.0]) && !contains(&convex_hull(star.to_vec()), [2.1, 1.0])
        );
    }
}
