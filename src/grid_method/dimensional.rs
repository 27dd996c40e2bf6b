//! A solved grid in the user's units.

use super::gap_left;
use super::refined::Refined;
use super::samples;
use super::single_grid::{self, GridState};
use super::unresolved;
use crate::discrete::Discrete;
use crate::energy;
use crate::gap::{AnyGap, Law};
use crate::grid::Pressure;
use crate::numeric::geometry::Rect;
use crate::overlap::{Scaled, touching};
use crate::patch;
use crate::patch::peak::{self, Ends};
use crate::problem::{Contact, Settings};
use crate::solution::{
    Cost, ForceBracket, Origin, Patch, PressureSummary, Samples, Singular, Solution, TouchesEdge, Unsolved, Validity,
};

/// A state of the grid method, its stiffness found.
pub(crate) fn dimensional(
    contact: &Contact,
    scaled: &Scaled,
    refined: &Refined,
    law: Option<Law>,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let stiffness = match law {
        Some(law) => (law.stiffness(refined.force, scaled.above_lowest()), Some(refined.error / refined.force)),
        None => stiffness_of(scaled, refined)?,
    };
    in_users_units(contact, scaled, refined, stiffness, depth, tilt, settings)
}

/// An estimate of a relative error that rests on which cells are in contact: one step from grid to grid may be small by luck.
pub(crate) fn at_least(refined: &Refined, change: f64) -> f64 {
    no_less(refined, change, unresolved::end)
}

/// The same of an area.
pub(crate) fn area_at_least(refined: &Refined, change: f64) -> f64 {
    no_less(refined, change, unresolved::area)
}

fn no_less(refined: &Refined, change: f64, of_cells: impl Fn(&Discrete, &[f64]) -> f64) -> f64 {
    let GridState { problem, solution, .. } = &refined.state;
    if refined.sequence.is_some() { change } else { change.max(of_cells(problem, &solution.pressure)) }
}

/// dP/dd with an estimate of its relative error.
pub(crate) fn stiffness_of(scaled: &Scaled, refined: &Refined) -> Result<(f64, Option<f64>), Unsolved> {
    // By what the gap is known to do when it is moved, where that leaves less to the cells.
    let by_force = |state: &GridState| {
        let growing = single_grid::growth(state, &vec![1.0; state.problem.grid.len()])?;
        let own = growing.iter().sum::<f64>() * state.problem.grid.cell_area();
        let found = energy::stiffness(&scaled.gap, scaled.depth, &state.trial(), &growing, refined.force);
        let of_use = |[_, share]: &[f64; 2]| *share < 1.0 && scaled.certain && refined.sequence.is_none();
        Ok::<_, Unsolved>(found.filter(of_use).unwrap_or([own, 1.0]))
    };
    let [(stiffness, change), (share, _)] = refined.estimated(by_force)?;
    let of_force = if share < 1.0 { refined.error / refined.force } else { 0.0 };
    let error = change.map(|change| {
        let cells = if share < 1.0 { share * at_least(refined, 0.0) } else { at_least(refined, change) };
        change.max(cells) + of_force
    });
    Ok((stiffness, error))
}

/// The same, its stiffness and the relative error of that known.
pub(crate) fn in_users_units(
    contact: &Contact,
    scaled: &Scaled,
    refined: &Refined,
    (stiffness, stiffness_error): (f64, Option<f64>),
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let Refined { state, force, error, .. } = refined;
    let (length, height, e_star) = (scaled.units.length, scaled.units.height, contact.modulus().e_star());
    let unit_force = e_star * height * length;
    let grid = state.problem.grid;
    let values = &state.solution.pressure;
    let reference = scaled.units.inward(contact.gap().known().reference);
    let (mut patch, peaks) = patch::with_peaks(&state.problem, &state.solution, reference);
    let own_area = patch.area;
    let sums = |state: &GridState, patch: &Patch| {
        let [x, y] = scaled.units.outward(state.centre());
        let highest = state.solution.pressure.iter().copied().fold(0.0, f64::max);
        [state.energy(), x, y, patch.area, patch.max_radius, highest]
    };
    let finest = sums(state, &patch);
    let coarser = |state: &GridState| Ok(sums(state, &patch::of(&state.problem, &state.solution, reference)));
    let [(energy, energy_error), (x, _), (y, _), (area, area_error), (max_radius, _), (_, peak_error)] =
        refined.estimated_beside(Some(finest), coarser)?;
    let area_error = area_error.map(|change| area_at_least(refined, change));
    // Of the best force.
    let (energy, energy_error) = match scaled.gap.known().law {
        Some(law) => (law.energy(*force, scaled.above_lowest()), Some(error / force)),
        // The energies of two grids may agree by chance, and those of many lie along a line whose bend is not seen; their error is of the size
        // of that of the force, from which they grow.
        None => {
            let times = if refined.proved.is_some() { 1.0 } else { OF_FORCE };
            (energy, energy_error.map(|change| change.max(times * error / force)))
        }
    };
    // The gap itself: beside other contacts the scaled one is displaced by them.
    let own_gap = touching(&contact.tilted_gap(tilt), depth).scaled(scaled.units.origin, length, height);
    let ends = Ends::of(&own_gap, &state.problem, values);
    let singular = infinite(&own_gap, state, &ends, &mut patch, &peaks);
    let unit_pressure = e_star * height / length;
    let (more, wider) = (force / state.force() * unit_force, area / own_area * length * length);
    for piece in &mut patch.pieces {
        piece.area *= wider;
        piece.force *= more;
        piece.centroid = scaled.units.outward(piece.centroid);
        piece.extent = piece.extent.map(|p| scaled.units.outward(p));
        piece.max_pressure = piece.max_pressure.map(|p| p * unit_pressure);
    }
    let validity = patch.boundary.as_ref().and_then(|loops| {
        let outward = |line: &Vec<[f64; 2]>| line.iter().map(|p| scaled.units.outward(*p)).collect();
        let loops: Vec<Vec<[f64; 2]>> = loops.iter().map(outward).collect();
        Validity::of(contact, &loops, area * length * length, force * unit_force)
    });
    (patch.area, patch.max_radius) = (area * length * length, max_radius * length);
    patch.centroid = patch.centroid.map(|c| scaled.units.outward(c));
    patch.boundary = if settings.outputs.patch {
        patch
            .boundary
            .map(|loops| loops.into_iter().map(|l| l.into_iter().map(|p| scaled.units.outward(p)).collect()).collect())
    } else {
        None
    };
    let strongest = strongest(values);
    let outward_grid = scaled.units.grid_outward(&grid);
    let pressure = PressureSummary {
        max: singular.is_none().then_some(values[strongest] * unit_pressure),
        max_error: peak_error
            .filter(|_| singular.is_none() && ends.data.is_none())
            .map(|change| change.max(unresolved::peak(&grid, values, strongest))),
        singular,
        mean: (patch.area > 0.0).then(|| force * unit_force / patch.area),
        at: Some(outward_grid.centre_of(strongest)),
        field: settings
            .outputs
            .pressure
            .then(|| Pressure { grid: outward_grid, values: values.iter().map(|p| p * unit_pressure).collect() }),
        gap: settings.outputs.gap.then(|| {
            (
                outward_grid,
                gap_left::of(&state.problem, &state.solution.pressure).into_iter().map(|g| g * height).collect(),
            )
        }),
    };
    Ok(Solution {
        method: state.method,
        origin: if refined.grids > 1 { Origin::ManyGrids { grids: refined.grids } } else { Origin::OneGrid },
        turned: None,
        grid: Some(outward_grid),
        depth,
        tilt,
        force: force * unit_force,
        force_error: Some(error / force),
        depth_error: Some(0.0),
        map_error: None,
        samples: samples::left_open(scaled, state).map(|open| Samples {
            off: open.off * height,
            force: open.force * unit_force,
            work: open.work * unit_force * height,
        }),
        stiffness_error,
        energy_error,
        area_error,
        bracket: refined.proved.map(|bounds| ForceBracket::of_energy(bounds.map(|force| force * unit_force))),
        depth_bracket: None,
        moment_bracket: None,
        tilt_bracket: None,
        stiffness: stiffness * e_star * length,
        stiffness_matrix: None,
        // Of the best force, where the pressure acts: the force of one grid differs from it.
        moment: Some([force * unit_force * y, -force * unit_force * x]),
        energy: Some(energy * unit_force * height),
        patch,
        pressure,
        residuals: Some(state.solution.residuals),
        touches_edge: ends.data.map(|(edge, share)| TouchesEdge { edge, share: Some(share) }),
        validity,
        cost: Cost {
            seconds: 0.0,
            unknowns: state.solution.unknowns,
            iterations: state.iterations,
            operator_products: state.operator_products,
            steps: 0,
        },
        left_out: state.left_out.clone(),
        remarks: state.remarks.clone(),
    })
}

/// Why the pressure is infinite in the patch, if it is known to be; such pieces have no largest pressure.
fn infinite(gap: &AnyGap, state: &GridState, ends: &Ends, patch: &mut Patch, peaks: &[usize]) -> Option<Singular> {
    let grid = &state.problem.grid;
    let mut found: Option<Singular> = None;
    for (k, (piece, &peak)) in patch.pieces.iter_mut().zip(peaks).enumerate() {
        let [min, max] = piece.extent;
        let around = Rect { min, max };
        let at_end = ends.rising.iter().any(|&k| around.contains(grid.centre_of(k)));
        let here = if at_end {
            Some(Singular::Edge)
        } else if k < MOST_LOOKED_AT {
            peak::singular(gap, &state.problem, peak)
        } else {
            found
        };
        if here.is_some() {
            piece.max_pressure = None;
            found = found.or(here);
        }
    }
    found
}

/// Relative error of an energy over that of its force, where two grids agree on it: 1.1 to 1.4 is seen on worn pyramids.
const OF_FORCE: f64 = 1.5;

/// Pieces in which kinks are looked for; the others are taken to be as these.
const MOST_LOOKED_AT: usize = 64;

/// The cell of the largest pressure.
pub(crate) fn strongest(pressure: &[f64]) -> usize {
    (0..pressure.len()).max_by(|&a, &b| pressure[a].total_cmp(&pressure[b])).unwrap_or(0)
}
