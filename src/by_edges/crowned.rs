//! Crowned punches: a face that is a polynomial of second degree in a polygon or an ellipse with sharp edges, in contact up to some of these.

use super::flat::{Flat, middle};
use super::{Found, Moments, field_grid};
use crate::edge_fitted::{Crowned, Limits, crowned, resample};
use crate::gap::{Crown, Quadratic};
use crate::numeric::geometry::Rect;
use crate::overlap::Overlap;
use crate::problem::{Contact, Settings};

/// The outline with the overlap inside, a polynomial in the outline's axes.
pub(crate) struct Crowning {
    flat: Flat,
    /// In units of `height`.
    overlap: Quadratic,
    height: f64,
}

impl Crowning {
    /// `None` where the gap is no such face, cells cannot be fitted to it, or the bodies overlap nowhere on its edges: a grid serves there.
    pub fn of(overlap: &Overlap) -> Option<Self> {
        let Crown { outline, at, turn, form } = overlap.known().crown.as_ref()?;
        let (sin, cos) = turn.sin_cos();
        let flat = match outline.semi_axes() {
            Some(semi_axes) => Flat::round(semi_axes, *at, [cos, sin], 0.0),
            None => Flat::polygon(outline.corners(), *at, [cos, sin], 0.0)?,
        };
        let Flat { origin, turn: [cos, sin], length, .. } = flat;
        let (form, height) = (form.about(origin), overlap.deepest);
        let per = length / height;
        let [a, b] = form.gradient;
        let [xx, xy, yy] = form.hessian;
        // H e for e the axes of the outline.
        let [hu, hv] = [[xx * cos + xy * sin, xy * cos + yy * sin], [xy * cos - xx * sin, yy * cos - xy * sin]];
        let second = [cos * hu[0] + sin * hu[1], cos * hv[0] + sin * hv[1], cos * hv[1] - sin * hv[0]];
        let overlap = Quadratic {
            about: [0.0; 2],
            value: (overlap.depth - form.value) / height,
            gradient: [-per * (cos * a + sin * b), -per * (cos * b - sin * a)],
            hessian: second.map(|h| -per * length * h),
        };
        let corners = flat.outline.corners();
        let mut edges = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
        edges.any(|(a, b)| highest(&overlap, a, b) > 0.0).then_some(Self { flat, overlap, height })
    }

    pub fn found(&self) -> String {
        if self.flat.outline.is_curved() {
            return "a curved face in an ellipse with a sharp edge".to_owned();
        }
        format!("a curved face in a polygon of {} corners with sharp edges", self.flat.corners.len())
    }

    pub(super) fn solve(&self, contact: &Contact, settings: &Settings, limits: &Limits) -> Option<Found> {
        let Self { flat, height, .. } = self;
        let Crowned { state, energy_error, regions, everywhere } = crowned(&flat.outline, &self.overlap, limits)?;
        let (length, e_star) = (flat.length, contact.modulus().e_star());
        let of_force = e_star * length * height;
        let of_pressure = e_star * height / length;
        let reference = contact.gap().known().reference;
        let patch = flat.patch(&regions, of_force, reference);
        let cells: Vec<_> = state.cells.iter().map(|(c, p)| (c.map(|q| flat.outward(q)), p * of_pressure)).collect();
        let boundary = patch.boundary.iter().flatten().flatten().copied();
        let rect = Rect::holding(boundary).unwrap_or(Rect::around(flat.origin, [length; 2]));
        let at = cells.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(flat.origin, |(c, _)| middle(c));
        let bounds = |value: f64, error: f64| [value * (1.0 - error), value * (1.0 + error)];
        let touch = if everywhere { "it touches everywhere" } else { "it touches on a part, up to the edge" };
        Some(Found {
            force: bounds(state.force * of_force, state.error),
            energy: bounds(state.energy * of_force * height, energy_error),
            stiffness: state.stiffness * e_star * length,
            stiffness_error: Some(state.stiffness_error),
            area_error: Some(state.area_error + super::flat::ROUNDING),
            patch,
            centre: flat.centre_of(&cells),
            max: None,
            max_error: None,
            at,
            field: settings.outputs.pressure.then(|| resample(&cells, field_grid(&rect))),
            unknowns: state.unknowns,
            how: format!("the gap is {}: {touch}", self.found()),
            left_out: "the surface grid: cells follow the edges of the material",
            proved: false,
            tilting: state.stiffness_matrix.map(|own| Moments {
                moment: None,
                bounds: None,
                matrix: own.in_axes(|q| flat.outward(q)).rows(e_star * length),
            }),
        })
    }
}

/// The largest value of a polynomial of second degree between two points.
fn highest(f: &Quadratic, a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let Quadratic { gradient: [gx, gy], hessian: [xx, xy, yy], .. } = f.about(a);
    let slope = gx * along[0] + gy * along[1];
    let bend = xx * along[0] * along[0] + 2.0 * xy * along[0] * along[1] + yy * along[1] * along[1];
    let top = (-slope / bend).clamp(0.0, 1.0);
    let between = if top.is_finite() { top } else { 0.0 };
    let at = |t: f64| f.about([a[0] + t * along[0], a[1] + t * along[1]]).value;
    at(0.0).max(at(1.0)).max(at(between))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_point_of_a_segment() {
        let f = Quadratic { about: [0.0; 2], value: 1.0, gradient: [0.0, 0.5], hessian: [-2.0, 0.0, -1.0] };
        assert_eq!(highest(&f, [-1.0, 0.0], [1.0, 0.0]), 1.0);
        assert_eq!(highest(&f, [0.0, -1.0], [0.0, 1.0]), 1.125);
        assert_eq!(highest(&f, [1.0, 0.0], [1.0, 0.0]), 0.0);
    }
}
