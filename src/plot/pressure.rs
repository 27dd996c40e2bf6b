//! The pressure as a map, with the boundary of the patch.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, BOTTOM, EDGE, LABEL, LEFT, RIGHT, TOP, Window, at, px};
use super::outlines::frame;
use super::{Error, FONT, Fault, Figure, Format, render, shade};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// The pressure field and the patch boundary of a solution, as far as it has them (`outputs.pressure`, `outputs.patch`).
///
/// Where the exact pressure is infinite the scale of colours ends at a quantile of the cells, with an arrow.
///
/// Fields of more than 140 cells along the longer side are drawn as means over blocks of cells.
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
    let boundary = solution.patch.boundary.as_deref().unwrap_or_default();
    let pressure = &solution.pressure;
    field_map_in(units, title, boundary, pressure.field.as_ref(), pressure.singular.is_some(), format)
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
    let field = field.map(coarsened);
    let patch = Rect::holding(boundary.iter().flatten().copied());
    let seen = patch.or(field.as_ref().map(|f| f.grid.extent()));
    let seen = seen.ok_or(Error::Empty("the solution has no patch boundary and no pressure field"))?;
    let highest = field.as_ref().map_or(0.0, |f| top(&f.values, without_end));
    render(&Picture { units, title, boundary, field, highest, without_end, window: Window::onto(&seen) }, format)
}

/// Share of the loaded cells whose pressures are on a scale of colours that has no end.
const ON_SCALE: f64 = 0.98;

/// The largest pressure, or the quantile at which a scale without end is cut.
fn top(values: &[f64], without_end: bool) -> f64 {
    let mut loaded: Vec<f64> = values.iter().copied().filter(|p| *p > 0.0).collect();
    if loaded.is_empty() {
        return 0.0;
    }
    loaded.sort_by(f64::total_cmp);
    let last = loaded.len() - 1;
    loaded[if without_end { (ON_SCALE * last as f64) as usize } else { last }]
}

struct Picture<'a> {
    units: &'a UnitLabels,
    title: &'a str,
    boundary: &'a [Vec<[f64; 2]>],
    field: Option<Pressure>,
    highest: f64,
    /// Whether pressures go on beyond that, to infinity.
    without_end: bool,
    window: Window,
}

/// Cells along the longer side beyond which the eye gains nothing and the file grows.
const MOST_CELLS: usize = 140;

/// Means over square blocks of cells.
pub(super) fn coarsened(field: &Pressure) -> Pressure {
    let Grid { origin, spacing, shape } = field.grid;
    let block = shape[0].max(shape[1]).div_ceil(MOST_CELLS).max(1);
    let coarse = shape.map(|n| n.div_ceil(block));
    let mut values = vec![0.0; coarse[0] * coarse[1]];
    for (k, p) in field.values.iter().enumerate() {
        // Cells beyond the border of the last block count as unloaded, which they are.
        values[(k / shape[0] / block) * coarse[0] + k % shape[0] / block] += p / (block * block) as f64;
    }
    Pressure { grid: Grid { origin, spacing: spacing.map(|h| h * block as f64), shape: coarse }, values }
}

/// Room beside the map for the scale of colours.
const BESIDE: u32 = px(150);

/// Steps of the colour scale.
const SHADES: u32 = 48;

impl Picture<'_> {
    /// The step of the scale for a pressure; `None`: unloaded.
    fn step(&self, p: f64) -> Option<u32> {
        (p > 0.0).then(|| ((p / self.highest * f64::from(SHADES)) as u32).min(SHADES - 1))
    }
}

fn colour(step: u32) -> RGBColor {
    shade((f64::from(step) + 0.5) / f64::from(SHADES))
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        self.window.size(if self.field.is_some() { BESIDE } else { 0 })
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        axes::title(area, self.title)?;
        let beside = if self.field.is_some() { BESIDE } else { 0 };
        let inner = area.margin(TOP, 0, EDGE, RIGHT + beside);
        let Rect { min, max } = self.window.extent;
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(min[0]..max[0], min[1]..max[1])?;
        frame(&mut chart.configure_mesh(), self.units, self.window.power)?;
        if let Some(Pressure { grid, values }) = &self.field {
            let [nx, ny] = grid.shape;
            for j in 0..ny {
                let mut i = 0;
                while i < nx {
                    let step = self.step(values[j * nx + i]);
                    let from = i;
                    while i < nx && self.step(values[j * nx + i]) == step {
                        i += 1;
                    }
                    let corner = |i: usize, j: usize| {
                        let [h, v] = grid.spacing;
                        self.window.place([grid.origin[0] + i as f64 * h, grid.origin[1] + j as f64 * v])
                    };
                    if let Some(step) = step {
                        let cells = [corner(from, j), corner(i, j + 1)];
                        chart.draw_series([Rectangle::new(cells, colour(step).filled())])?;
                    }
                }
            }
        }
        for points in self.boundary {
            let closed = points.iter().chain(points.first()).map(|&p| self.window.place(p));
            chart.draw_series(LineSeries::new(closed, BLACK.stroke_width(px(2))))?;
        }
        if self.highest > 0.0 { self.scale(area) } else { Ok(()) }
    }
}

impl Picture<'_> {
    /// The scale of colours on the right.
    fn scale<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let (width, _) = area.dim_in_pixel();
        let (left, height) = ((width - BESIDE) as i32, self.window.pixels[1] as i32);
        let (top, bottom) = (TOP as i32 + at(if self.without_end { 38 } else { 24 }), TOP as i32 + height);
        let level = |k: u32| bottom - (bottom - top) * k as i32 / SHADES as i32;
        for k in 0..SHADES {
            area.draw(&Rectangle::new([(left, level(k + 1)), (left + at(20), level(k))], colour(k).filled()))?;
        }
        area.draw(&Rectangle::new([(left, top), (left + at(20), bottom)], BLACK.stroke_width(px(1))))?;
        if self.without_end {
            let points = vec![(left, top), (left + at(10), top - at(14)), (left + at(20), top)];
            area.draw(&Polygon::new(points.clone(), colour(SHADES - 1).filled()))?;
            area.draw(&PathElement::new(points, BLACK.stroke_width(px(1))))?;
        }
        let power = axes::power_of_ten(self.highest);
        let style = (FONT, LABEL).into_font().into_text_style(area);
        area.draw_text("pressure", &style, (left, TOP as i32 - at(22)))?;
        area.draw_text(&axes::scaled(&self.units.pressure(), power), &style, (left, TOP as i32 - at(2)))?;
        let largest = self.highest / 10f64.powi(power);
        let step = axes::round_step(largest);
        let mut value = 0.0;
        while value <= largest {
            let y = bottom - (f64::from(bottom - top) * value / largest).round() as i32;
            area.draw(&PathElement::new(vec![(left + at(20), y), (left + at(25), y)], BLACK.stroke_width(px(1))))?;
            area.draw_text(&axes::tick(value), &style, (left + at(30), y - LABEL as i32 * 3 / 8))?;
            value += step;
        }
        Ok(())
    }
}
