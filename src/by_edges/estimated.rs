//! What is estimated on cells that are fitted to a contact, in the user's units.

use super::flat::middle;
use super::{Found, Moments, field_grid};
use crate::edge_fitted::{Estimated, resample};
use crate::numeric::geometry::{Rect, farthest};
use crate::overlap::Units;
use crate::problem::{Contact, Settings};
use crate::solution::Patch;

/// The state of one contact; `centroid` of its patch and `centre` of its pressure as it was solved. What it is and why is left to say.
pub(super) fn in_users_units(
    found: Estimated,
    units: &Units,
    [centroid, centre]: [[f64; 2]; 2],
    contact: &Contact,
    settings: &Settings,
) -> Option<Found> {
    let Estimated {
        force,
        error,
        energy,
        stiffness,
        stiffness_error,
        stiffness_matrix,
        area,
        area_error,
        max_error,
        cells,
        ends,
        unknowns,
    } = found;
    let Units { length, height, .. } = *units;
    let e_star = contact.modulus().e_star();
    let unit_force = e_star * height * length;
    let unit_pressure = e_star * height / length;
    let outward = |p: [f64; 2]| units.outward(p);
    let boundary: Vec<Vec<[f64; 2]>> = ends.into_iter().map(|line| line.into_iter().map(outward).collect()).collect();
    let reference = contact.gap().known().reference;
    let (strongest, largest) = cells.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let at = outward(middle(strongest));
    let field = || {
        let all: Vec<_> = cells.iter().map(|(c, p)| (c.map(outward), p.max(0.0) * unit_pressure)).collect();
        Some(resample(&all, field_grid(&Rect::holding(boundary.iter().flatten().copied())?)))
    };
    let field = if settings.outputs.pressure { field() } else { None };
    let bounds = |value: f64| [value * (1.0 - error), value * (1.0 + error)];
    Some(Found {
        force: bounds(force * unit_force),
        energy: bounds(energy * unit_force * height),
        stiffness: stiffness * e_star * length,
        stiffness_error: Some(stiffness_error),
        area_error: Some(area_error),
        max: Some(largest * unit_pressure),
        max_error,
        at,
        field,
        patch: Patch {
            area: area * length * length,
            centroid: Some(outward(centroid)),
            regions: 1,
            max_radius: farthest(boundary.iter().flatten(), reference),
            boundary: Some(boundary),
            ..Patch::default()
        },
        centre: outward(centre),
        unknowns,
        how: String::new(),
        left_out: "",
        proved: false,
        tilting: stiffness_matrix.map(|own| Moments {
            moment: None,
            bounds: None,
            matrix: own.in_axes(outward).rows(e_star * length),
        }),
    })
}
