//! How the pressure of a state on a grid is spread: largest value, moments, patch.

use super::again::boundary_distance;
use super::cells::Cells;
use super::result::{State, key};
use super::scaled::ScaledField;
use super::state::ROUNDING;
use super::{Verification, close, homogeneous};
use crate::gap::AnyGap;
use crate::grid::Pressure;
use crate::scene::Scene;
use crate::solution::Piece;

/// Error of a boundary, in cells: it moves with the gap that is left beside it.
const OF_BOUNDARY: f64 = 0.02;

impl State<'_> {
    /// The largest pressure is that of the field.
    pub(super) fn pressures(&self, gap: &AnyGap, field: &Pressure, found: &mut Verification) {
        let degree = homogeneous::degree(gap, &field.grid);
        if degree.is_some_and(|k| k <= 1.0 || k.is_infinite()) {
            let said = self.get(key!(pressure.singular)).is_some();
            found.require(said, "the pressure is infinite at the tip or the edge of such a gap, and is said to be");
        }
        let highest = field.values.iter().copied().fold(0.0, f64::max);
        if let Some(max) = self.get(key!(pressure.max)) {
            found.require(close(max, highest, ROUNDING), format!("the largest pressure {max:e} is that of the field"));
            self.use_up(key!(pressure.max));
        }
        if let Some(at) = self.get(key!(pressure.at)) {
            let centre = |k: usize| {
                let c = field.grid.centre_of(k);
                (0..2).all(|m| (at[m] - c[m]).abs() <= 1e-6 * field.grid.spacing[m])
            };
            let high = (0..field.values.len()).filter(|&k| close(field.values[k], highest, ROUNDING));
            found.require(high.into_iter().any(centre), format!("the largest pressure is in the cell at {at:?}"));
            self.use_up(key!(pressure.at));
        }
    }

    /// The force acts where the field's does.
    pub(super) fn moments(&self, field: &Pressure, force_driven: bool, found: &mut Verification) {
        let Some(moment) = self.get(key!(moment)) else { return };
        let area = field.grid.cell_area();
        let (mut sums, mut size) = ([0.0; 2], 0.0);
        for ([x, y], p) in field.grid.loaded(&field.values) {
            sums = [sums[0] + p * area * y, sums[1] - p * area * x];
            size += p * area * x.hypot(y);
        }
        let more = self.force / field.force();
        // What a cell leaves open of them is moved within their bounds, which are worked out again.
        let bounds = self.get(key!(bracket.moment));
        let own = |m: usize| {
            let own = more * sums[m];
            bounds.as_ref().map_or(own, |bounds| own.max(bounds.lower[m]).min(bounds.upper[m]))
        };
        let room = if force_driven { self.error().unwrap_or(0.0).max(1e-6) } else { ROUNDING };
        // Where edges fall between cells, the force acts elsewhere by where in a cell they lie.
        let [hx, hy] = field.grid.spacing;
        let cell = if self.missed_by_one_grid(field) > 0.0 { hx.max(hy) * self.force } else { 0.0 };
        let holds = (0..2).all(|m| (moment[m] - own(m)).abs() <= room * size + cell);
        found.require(holds, format!("the moments {moment:?} are those of the field"));
        self.use_up(key!(moment));
    }

    /// Bounds of the moments, worked out again from the field.
    pub(super) fn moments_bracketed(&self, scene: &Scene, gap: &AnyGap, field: &Pressure, found: &mut Verification) {
        let Some(claimed) = self.get(key!(bracket.moment)) else { return };
        let own =
            ScaledField::of(gap, scene.contact.modulus(), self.depth, field).and_then(|field| field.moment_bounds());
        found.require(
            own.is_some_and(|own| claimed.holds(own, |_| 0.0)),
            format!("{}: the field proves {own:?}", claimed.told("bracket.moment")),
        );
        self.use_up(key!(bracket.moment));
    }

    /// By how much, relatively, a length of the contact on one grid may be off where the force is the limit of several: as much
    /// as the force is, and the error that is stated.
    fn missed_by_one_grid(&self, field: &Pressure) -> f64 {
        if self.origin == "many_grids" {
            (self.force / field.force() - 1.0).abs() + self.error().unwrap_or(0.0)
        } else {
            0.0
        }
    }

    /// Area, places and pieces of the patch are those of the field.
    pub(super) fn patch_of(&self, cells: &Cells, scene: &Scene, found: &mut Verification) {
        let Some(field) = &self.field else { return };
        let own = cells.patch(scene.contact.gap().known().reference);
        let [hx, hy] = field.grid.spacing;
        let pressed = field.values.iter().filter(|p| **p > 0.0).count() as f64;
        // All around, by a share of a cell.
        let off = OF_BOUNDARY * hx.max(hy);
        let around = 4.0 * off * (pressed * hx * hy).sqrt().max(hx.max(hy));
        let missed = self.missed_by_one_grid(field);
        // The force grows with the size of a patch, half as much as the area.
        let around = around + 2.0 * missed * own.area;
        found.require(
            (self.area - own.area).abs() <= around,
            format!("the area {:e} is that of the field, {:e}", self.area, own.area),
        );
        self.use_up(key!(patch.area));
        let (more, wider) = (self.force / field.force(), self.area / own.area);
        let e_star = scene.contact.modulus().e_star();
        let scaled = |piece: &Piece| Piece {
            force: piece.force * e_star * more,
            area: piece.area * wider,
            max_pressure: piece.max_pressure.map(|p| p * e_star),
            ..piece.clone()
        };
        self.pieces_are(&own.pieces.iter().map(scaled).collect::<Vec<_>>(), ROUNDING, off, found);
        self.validity_is(scene, found);
        if let (Some(said), Some(own)) = (self.get(key!(patch.centroid)), own.centroid) {
            let holds = (0..2).all(|m| (said[m] - own[m]).abs() <= off);
            found.require(holds, format!("the centroid {said:?} is that of the field, {own:?}"));
            self.use_up(key!(patch.centroid));
        }
        if let Some(said) = self.get(key!(patch.regions)) {
            found.require(said == own.regions, format!("{said} regions are those of the field"));
            self.use_up(key!(patch.regions));
        }
        if let Some(said) = self.get(key!(patch.max_radius)) {
            let holds = (said - own.max_radius).abs() <= off + missed * own.max_radius;
            found.require(holds, format!("the largest radius {said:e} is that of the field, {:e}", own.max_radius));
            self.use_up(key!(patch.max_radius));
        }
        if let (Some(said), Some(own)) = (self.get(key!(patch.boundary)), &own.boundary) {
            let holds = boundary_distance(&said, own).is_some_and(|far| far <= off);
            found.require(holds, "the boundary is that of the field");
            self.use_up(key!(patch.boundary));
        }
    }
}
