//! Contacts far apart as one answer.

use crate::grid::{Grid, Pressure};
use crate::problem::Settings;
use crate::solution::{Origin, Patch, Piece, PressureSummary, Residuals, Samples, Solution, TouchesEdge, Validity};

/// Cells along the longer side of the field that all contacts share.
const FIELD: usize = 1024;

/// One state from those of all contacts; `missed` is the force that the last sweep still changed.
pub(super) fn together(states: Vec<Solution>, settings: &Settings, missed: f64) -> Solution {
    let force: f64 = states.iter().map(|s| s.force).sum();
    let error: f64 = states.iter().map(|s| s.force_error.unwrap_or(0.0) * s.force).sum();
    let singular = states.iter().find_map(|s| s.pressure.singular);
    let strongest =
        states.iter().max_by(|a, b| a.pressure.max.unwrap_or(0.0).total_cmp(&b.pressure.max.unwrap_or(0.0)));
    let finite = |s: &&Solution| singular.is_none() && s.pressure.singular.is_none();
    let (max, max_error) = strongest.filter(finite).map_or((None, None), |s| (s.pressure.max, s.pressure.max_error));
    let at = states.iter().find(|s| s.pressure.singular.is_some()).or(strongest).and_then(|s| s.pressure.at);
    let area: f64 = states.iter().map(|s| s.patch.area).sum();
    let centroid =
        |m: usize| states.iter().filter_map(|s| s.patch.centroid.map(|c| c[m] * s.patch.area)).sum::<f64>() / area;
    let mut pieces: Vec<Piece> = states.iter().flat_map(|s| s.patch.pieces.iter().cloned()).collect();
    pieces.sort_by(|a, b| b.force.total_cmp(&a.force));
    // Errors add up as the numbers do; that of the stiffness, found for all at once, is at most the largest.
    let added = |error: fn(&Solution) -> Option<f64>, value: fn(&Solution) -> Option<f64>| {
        let all: Option<f64> = states.iter().map(|s| Some(error(s)? * value(s)?)).sum();
        Some(all? / states.iter().map(value).sum::<Option<f64>>()?).filter(|share| share.is_finite())
    };
    let area_error = added(|s| s.area_error, |s| Some(s.patch.area));
    let energy_error = added(|s| s.energy_error, |s| s.energy).map(|error| error + missed / force);
    let stiffness_error =
        states.iter().map(|s| s.stiffness_error).try_fold(0.0_f64, |all, error| Some(all.max(error?)));
    let edges = states.iter().filter_map(|s| s.touches_edge.map(|edge| (s.force, edge)));
    let strongest_edge = edges.clone().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, edge)| edge);
    let beside: f64 = edges.map(|(force, edge)| force * edge.share.unwrap_or(0.0)).sum();
    let touches_edge = strongest_edge.map(|edge| TouchesEdge { share: Some(beside / force), ..edge });
    let doubtful =
        |of: fn(&Validity) -> f64| states.iter().filter_map(|s| s.validity.as_ref().map(of)).reduce(f64::max);
    let validity = states[0].validity.map(|first| Validity {
        slope: doubtful(|v| v.slope).unwrap_or(first.slope),
        size_over_radius: None,
        pressure_over_modulus: doubtful(|v| v.pressure_over_modulus).unwrap_or(first.pressure_over_modulus),
    });
    let finest = |s: &&Solution| s.grid.map_or(f64::INFINITY, |grid| grid.spacing[0].min(grid.spacing[1]));
    let grid = states.iter().min_by(|a, b| finest(a).total_cmp(&finest(b))).and_then(|s| s.grid);
    let patch = Patch {
        area,
        centroid: (area > 0.0).then(|| [centroid(0), centroid(1)]),
        regions: states.iter().map(|s| s.patch.regions).sum(),
        max_radius: states.iter().map(|s| s.patch.max_radius).fold(0.0, f64::max),
        boundary: settings
            .outputs
            .patch
            .then(|| states.iter().filter_map(|s| s.patch.boundary.clone()).flatten().collect()),
        pieces,
        semi_axes: None,
        angle: None,
    };
    let fields: Vec<&Pressure> = states.iter().filter_map(|s| s.pressure.field.as_ref()).collect();
    let field = (settings.outputs.pressure || settings.outputs.gap).then(|| spread(&fields)).flatten();
    let worst =
        |of: fn(&Residuals) -> f64| states.iter().filter_map(|s| s.residuals.as_ref().map(of)).fold(0.0, f64::max);
    let residuals = Residuals {
        complementarity: worst(|r| r.complementarity),
        tension: worst(|r| r.tension),
        penetration: worst(|r| r.penetration),
    };
    let count = states.len();
    let sum = |of: fn(&Solution) -> Option<f64>| states.iter().map(of).sum::<Option<f64>>();
    let mut all = states[0].clone();
    all.origin = Origin::SeparateContacts { count };
    all.force = force;
    all.force_error = Some((error + missed) / force);
    all.energy = sum(|s| s.energy);
    all.moment = sum(|s| s.moment.map(|m| m[0])).zip(sum(|s| s.moment.map(|m| m[1]))).map(|(x, y)| [x, y]);
    all.pressure =
        PressureSummary { max, max_error, singular, mean: (area > 0.0).then(|| force / area), at, field, gap: None };
    (all.stiffness_error, all.energy_error, all.area_error) = (stiffness_error, energy_error, area_error);
    all.samples = states.iter().filter_map(|s| s.samples).reduce(|a, b| Samples {
        off: a.off.max(b.off),
        force: a.force + b.force,
        work: a.work + b.work,
    });
    (all.touches_edge, all.validity, all.grid) = (touches_edge, validity, grid);
    all.patch = patch;
    all.residuals = Some(residuals);
    all.cost.unknowns = states.iter().map(|s| s.cost.unknowns).max().unwrap_or(0);
    all.left_out = vec!["the grid between the contacts: each has one of its own".to_owned()];
    all.remarks = vec![format!("{count} contacts far apart, solved in turn on what the others leave of the gap")];
    all
}

/// The pressures of several grids as means over the cells of one around all of them; no load is lost.
fn spread(fields: &[&Pressure]) -> Option<Pressure> {
    let all = fields.iter().map(|f| f.grid.extent()).reduce(|a, b| a.union(&b))?;
    let finest = fields.iter().flat_map(|f| f.grid.spacing).fold(f64::INFINITY, f64::min);
    let [w, h] = all.size();
    let spacing = finest.max(w.max(h) / FIELD as f64);
    let shape = [w, h].map(|side| ((side / spacing).ceil() as usize).max(1));
    let grid = Grid::over(&all, shape);
    let mut values = vec![0.0; grid.len()];
    for field in fields {
        for (k, &p) in field.values.iter().enumerate().filter(|(_, p)| **p != 0.0) {
            let cell = field.grid.cell(k % field.grid.shape[0], k / field.grid.shape[0]);
            let place = |x: f64, m: usize| ((x - grid.origin[m]) / grid.spacing[m]).clamp(0.0, grid.shape[m] as f64);
            let [from, to] =
                [[place(cell.min[0], 0), place(cell.min[1], 1)], [place(cell.max[0], 0), place(cell.max[1], 1)]];
            for j in from[1] as usize..(to[1].ceil() as usize).min(grid.shape[1]) {
                for i in from[0] as usize..(to[0].ceil() as usize).min(grid.shape[0]) {
                    let overlap = |n: usize, m: usize| (to[m].min(n as f64 + 1.0) - from[m].max(n as f64)).max(0.0);
                    values[j * grid.shape[0] + i] += p * overlap(i, 0) * overlap(j, 1);
                }
            }
        }
    }
    Some(Pressure { grid, values })
}
