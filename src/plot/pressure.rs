//! A field as a map, with the boundary of the patch: the pressure, or the gap that is left.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::px;
use super::frame::{Frame, Medium};
use super::outlines::mesh;
use super::raster::Raster;
use super::scale::Scale;
use super::window::Window;
use super::{Error, Fault, Figure, Format, PLACE, colour, render};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// The pressure field and the patch boundary of a solution, as far as it has them (`outputs.pressure`, `outputs.patch`).
///
/// The scale of colours ends at the largest pressure that the solution states. Where the exact one is infinite it ends at a quantile of
/// the cells, with an arrow. Colours are interpolated between the centres of cells and end at the boundary.
///
/// Fields of more than 560 cells along the longer side are drawn as means over blocks of cells.
///
/// # Errors
/// When the solution has neither field nor boundary, or drawing fails.
pub fn pressure_map(title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    pressure_map_in(&UnitLabels::kinds(), title, solution, format)
}

/// As [`pressure_map`], with labels of units.
///
/// # Errors
/// As [`pressure_map`].
pub fn pressure_map_in(units: &UnitLabels, title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    pressure_map_on(Medium::Sheet, units, title, solution, format).map(|(picture, _)| picture)
}

/// Where the plane is in a picture.
// Pages are for scenes.
#[cfg_attr(not(feature = "scene"), allow(dead_code))]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    /// Left, top, width, height of the plotting area, shares of the picture.
    pub area: [f64; 4],
    /// What it shows, in the units of the scene.
    pub extent: Rect,
}

/// As [`pressure_map_in`], and where the plane is.
///
/// # Errors
/// As [`pressure_map`].
pub(crate) fn pressure_map_on(
    medium: Medium,
    units: &UnitLabels,
    title: &str,
    solution: &Solution,
    format: Format,
) -> Result<(Vec<u8>, Placed), Error> {
    let boundary = solution.patch.boundary.as_deref().unwrap_or_default();
    let pressure = &solution.pressure;
    let map = Map {
        units,
        title,
        quantity: "pressure",
        unit: units.pressure(),
        boundary,
        clip: boundary.to_vec(),
        field: pressure.field.as_ref(),
        highest: highest(solution),
        without_end: pressure.singular.is_some(),
    };
    map.drawn(medium, format)
}

/// Where the scale of colours of a solution's pressure ends: at its largest pressure, or at a quantile of the cells where that is
/// infinite; 0 without a field.
pub(crate) fn highest(solution: &Solution) -> f64 {
    let field = solution.pressure.field.as_ref();
    let in_cells = field.map_or(0.0, |f| top(&f.values, solution.pressure.singular.is_some()));
    match solution.pressure.max {
        Some(max) if in_cells > 0.0 && max > 0.0 => max,
        _ => in_cells,
    }
}

/// A pressure field and closed polylines around where it acts, as far as they are there: as [`pressure_map`]. `without_end`: pressures
/// go on to infinity beyond those of the field.
///
/// # Errors
/// As [`pressure_map`].
pub fn field_map(
    title: &str,
    boundary: &[Vec<[f64; 2]>],
    field: Option<&Pressure>,
    without_end: bool,
    format: Format,
) -> Result<Vec<u8>, Error> {
    field_map_in(&UnitLabels::kinds(), title, boundary, field, without_end, format)
}

/// As [`field_map`], with labels of units.
///
/// # Errors
/// As [`pressure_map`].
pub fn field_map_in(
    units: &UnitLabels,
    title: &str,
    boundary: &[Vec<[f64; 2]>],
    field: Option<&Pressure>,
    without_end: bool,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let highest = field.map_or(0.0, |f| top(&f.values, without_end));
    let (quantity, unit, clip) = ("pressure", units.pressure(), boundary.to_vec());
    let map = Map { units, title, quantity, unit, boundary, clip, field, highest, without_end };
    map.drawn(Medium::Sheet, format).map(|(picture, _)| picture)
}

/// The gap that is left around the patch (`outputs.gap`, `outputs.patch`), nothing where there is no material. The scale of colours ends
/// at a quantile of the cells, with an arrow.
///
/// # Errors
/// When the solution has no such field, or drawing fails.
pub fn gap_map(title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    gap_map_in(&UnitLabels::kinds(), title, solution, format)
}

/// As [`gap_map`], with labels of units.
///
/// # Errors
/// As [`gap_map`].
pub fn gap_map_in(units: &UnitLabels, title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    let (grid, values) = solution.pressure.gap.as_ref().ok_or(Error::Empty("the solution has no field of the gap"))?;
    // Gaps that are rounding are closed.
    let open = 1e-9 * values.iter().copied().filter(|g| g.is_finite()).fold(0.0, f64::max);
    let values = values.iter().map(|&g| if g.is_finite() && g > open { g } else { 0.0 }).collect();
    let field = Pressure { grid: *grid, values };
    let boundary = solution.patch.boundary.as_deref().unwrap_or_default();
    // Even-odd: around the patch, not in it.
    let mut clip = boundary.to_vec();
    clip.push(grid.extent().corners().to_vec());
    let highest = top(&field.values, true);
    let unit = units.length().to_owned();
    let field = Some(&field);
    let map = Map { units, title, quantity: "gap left", unit, boundary, clip, field, highest, without_end: true };
    map.drawn(Medium::Sheet, format).map(|(picture, _)| picture)
}

/// Where the error of a field sits: shares of its cells in the bounds of the energy, over the energy. The scale of colours ends at a
/// quantile of the cells, with an arrow.
///
/// # Errors
/// When drawing fails.
pub fn error_map_in(
    units: &UnitLabels,
    title: &str,
    boundary: &[Vec<[f64; 2]>],
    shares: &Pressure,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let clip = vec![shares.grid.extent().corners().to_vec()];
    let highest = top(&shares.values, true);
    let (quantity, unit, field) = ("error of the energy", "of it, a cell".to_owned(), Some(shares));
    let map = Map { units, title, quantity, unit, boundary, clip, field, highest, without_end: true };
    map.drawn(Medium::Sheet, format).map(|(picture, _)| picture)
}

/// Share of the loaded cells whose values are on a scale of colours that has no end.
const ON_SCALE: f64 = 0.98;

/// The largest value, or the quantile at which a scale without end is cut.
fn top(values: &[f64], without_end: bool) -> f64 {
    let mut loaded: Vec<f64> = values.iter().copied().filter(|p| *p > 0.0).collect();
    if loaded.is_empty() {
        return 0.0;
    }
    loaded.sort_by(f64::total_cmp);
    let last = loaded.len() - 1;
    loaded[if without_end { (ON_SCALE * last as f64) as usize } else { last }]
}

/// Cells along the longer side beyond which a picture of this size shows no more.
const MOST_CELLS: usize = 560;

/// Means over square blocks of cells, so that there are at most `most` along the longer side.
pub(crate) fn coarsened(field: &Pressure, most: usize) -> Pressure {
    let Grid { origin, spacing, shape } = field.grid;
    let block = shape[0].max(shape[1]).div_ceil(most).max(1);
    let coarse = shape.map(|n| n.div_ceil(block));
    let mut values = vec![0.0; coarse[0] * coarse[1]];
    for (k, p) in field.values.iter().enumerate() {
        // Cells beyond the border of the last block count as unloaded, which they are.
        values[(k / shape[0] / block) * coarse[0] + k % shape[0] / block] += p / (block * block) as f64;
    }
    Pressure { grid: Grid { origin, spacing: spacing.map(|h| h * block as f64), shape: coarse }, values }
}

/// What a map shows.
struct Map<'a> {
    units: &'a UnitLabels,
    title: &'a str,
    quantity: &'a str,
    unit: String,
    boundary: &'a [Vec<[f64; 2]>],
    /// Within these (even-odd) there is colour; empty: in every cell with a value.
    clip: Vec<Vec<[f64; 2]>>,
    field: Option<&'a Pressure>,
    highest: f64,
    /// Whether values go on beyond that.
    without_end: bool,
}

impl Map<'_> {
    fn drawn(&self, medium: Medium, format: Format) -> Result<(Vec<u8>, Placed), Error> {
        let patch = Rect::holding(self.clip.iter().flatten().copied());
        let seen = patch.or(self.field.map(|f| f.grid.extent()));
        let seen = seen.ok_or(Error::Empty("the solution has no patch boundary and no pressure field"))?;
        let [beside, below] = if self.field.is_some() && self.highest > 0.0 { Scale::room(medium) } else { [0; 2] };
        // The margins do not depend on the title's width, and the longer side not on the margins of a sheet.
        let margins = Frame::new(medium, "", 0);
        let longest = match medium {
            Medium::Sheet => px(560),
            Medium::Page | Medium::Phone => medium.width() - margins.edge - margins.left - margins.right - beside,
        };
        let longest = if medium == Medium::Page { longest.min(px(330)) } else { longest };
        let window = Window::onto(&seen, longest, self.units.length());
        // A scale below a narrow map is as wide as the page.
        let beside = if below > 0 { medium.width().saturating_sub(window.size(&margins, 0, 0).0) } else { beside };
        let frame = Frame::new(medium, self.title, window.size(&margins, beside, below).0);
        let [left, top] = window.pixel(&frame, [seen.min[0], seen.max[1]]).map(|p| p.round() as i32);
        let [right, bottom] = window.pixel(&frame, [seen.max[0], seen.min[1]]).map(|p| p.round() as i32);
        let dots = [right - left, bottom - top].map(|points| {
            let points = points.max(1) as usize;
            // An SVG has two dots a pixel of the screen, a file of pixels all of its own.
            if format == Format::Svg { (2 * points).div_ceil(3) } else { points }
        });
        let raster = self.field.filter(|_| self.highest > 0.0).map(|field| {
            let field = coarsened(field, MOST_CELLS);
            Raster::of(&field, &self.clip, &seen, dots, self.highest)
        });
        let place = [left, top, right, bottom];
        let picture = Picture { map: self, window, frame, raster, place, format, beside, below };
        let (width, height) = picture.size();
        let [w, h] = [width, height].map(f64::from);
        let area = [
            f64::from(picture.frame.edge + picture.frame.left) / w,
            f64::from(picture.frame.top) / h,
            f64::from(window.pixels[0]) / w,
            f64::from(window.pixels[1]) / h,
        ];
        let unit = 10f64.powi(window.power);
        let extent = Rect { min: window.extent.min.map(|x| unit * x), max: window.extent.max.map(|x| unit * x) };
        Ok((render(&picture, format)?, Placed { area, extent }))
    }
}

struct Picture<'a> {
    map: &'a Map<'a>,
    window: Window,
    frame: Frame,
    raster: Option<Raster>,
    /// Left, top, right, bottom of the raster.
    place: [i32; 4],
    format: Format,
    /// Room for the scale of colours.
    beside: u32,
    below: u32,
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        self.window.size(&self.frame, self.beside, self.below)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let (frame, window) = (&self.frame, &self.window);
        frame.title(area)?;
        let inner = area.margin(frame.top, self.below, frame.edge, frame.right + self.beside);
        let Rect { min, max } = window.extent;
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(frame.bottom)
            .y_label_area_size(frame.left)
            .build_cartesian_2d(min[0]..max[0], min[1]..max[1])?;
        mesh(&mut chart.configure_mesh(), self.map.units, window, frame)?;
        let [left, top, right, bottom] = self.place;
        match (&self.raster, self.format) {
            (None, _) => {}
            (Some(_), Format::Svg) => area.draw(&Rectangle::new([(left, top), (right, bottom)], PLACE.filled()))?,
            (Some(raster), Format::Png) => {
                for (j, from, to, step) in raster.runs() {
                    let y = top + j as i32;
                    let run = [(left + from as i32, y), (left + to as i32, y + 1)];
                    area.draw(&Rectangle::new(run, colour(u32::from(step)).filled()))?;
                }
            }
        }
        for points in self.map.boundary {
            let closed = points.iter().chain(points.first()).map(|&p| window.place(p));
            chart.draw_series(LineSeries::new(closed, BLACK.stroke_width(px(2))))?;
        }
        if self.raster.is_none() {
            return Ok(());
        }
        let Map { quantity, unit, highest, without_end, .. } = self.map;
        let scale = Scale { quantity, unit: unit.clone(), highest: *highest, without_end: *without_end };
        let left = frame.edge + frame.left;
        if self.below > 0 {
            // Half of what is written at its end has room beside it.
            let right = self.size().0 - px(28);
            scale.below(area, frame, [left, right], frame.top + window.pixels[1] + frame.bottom)
        } else {
            scale.beside(area, frame, left + window.pixels[0], window.pixels[1])
        }
    }

    fn image(&self) -> Option<([i32; 4], &Raster)> {
        self.raster.as_ref().map(|raster| (self.place, raster))
    }
}
