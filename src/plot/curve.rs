//! Force against depth: the contact as a non-linear spring.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, BOTTOM, EDGE, LABEL, LEFT, RIGHT, TOP, px};
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};
use crate::curve::Curve;
use crate::units::UnitLabels;

/// A solved curve: its interpolant as a line, its states as dots.
///
/// # Errors
/// When drawing fails.
pub fn curve(title: &str, curve: &Curve, format: Format) -> Result<Vec<u8>, Error> {
    curve_in(&UnitLabels::kinds(), title, curve, format)
}

/// As [`curve()`], with labels of units.
///
/// # Errors
/// As [`curve()`].
pub fn curve_in(units: &UnitLabels, title: &str, curve: &Curve, format: Format) -> Result<Vec<u8>, Error> {
    let overlap = curve.deepest() - curve.first_touch();
    let at = |k: i32| curve.first_touch() + overlap * f64::from(k) / 200.0;
    let line: Vec<[f64; 2]> = (0..=200).filter_map(|k| Some([at(k), curve.force(at(k))?])).collect();
    let solved: Vec<[f64; 2]> = curve.samples().iter().map(|s| [s.depth, s.force]).collect();
    force_depth_in(units, title, &line, &solved, format)
}

/// A line through points (depth, force), and dots on the states that were solved, both in any order.
///
/// # Errors
/// When there is no point, or drawing fails.
pub fn force_depth(title: &str, line: &[[f64; 2]], solved: &[[f64; 2]], format: Format) -> Result<Vec<u8>, Error> {
    force_depth_in(&UnitLabels::kinds(), title, line, solved, format)
}

/// As [`force_depth`], with labels of units.
///
/// # Errors
/// As [`force_depth`].
pub fn force_depth_in(
    units: &UnitLabels,
    title: &str,
    line: &[[f64; 2]],
    solved: &[[f64; 2]],
    format: Format,
) -> Result<Vec<u8>, Error> {
    let in_order = |points: &[[f64; 2]]| {
        let mut points: Vec<[f64; 2]> = points.iter().copied().filter(|p| p.iter().all(|x| x.is_finite())).collect();
        points.sort_by(|p, q| p[0].total_cmp(&q[0]));
        points
    };
    let (line, solved) = (in_order(line), in_order(solved));
    if line.is_empty() && solved.is_empty() {
        return Err(Error::Empty("there is no point of the curve"));
    }
    render(&Picture { units, title, line, solved }, format)
}

struct Picture<'a> {
    units: &'a UnitLabels,
    title: &'a str,
    line: Vec<[f64; 2]>,
    solved: Vec<[f64; 2]>,
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (px(720), px(520))
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        axes::title(area, self.title)?;
        let points = || self.line.iter().chain(&self.solved);
        let largest = |m: usize| points().map(|p| p[m].abs()).fold(0.0, f64::max);
        let least = |m: usize| points().map(|p| p[m]).fold(0.0, f64::min);
        let power = [0, 1].map(|m| axes::power_of_ten(largest(m)));
        let unit = power.map(|p| 10f64.powi(p));
        let range = |m: usize| {
            let high = points().map(|p| p[m]).fold(least(m), f64::max);
            let high = if high > least(m) { high } else { least(m) + unit[m] };
            least(m) / unit[m]..1.05 * high / unit[m]
        };
        let inner = area.margin(TOP, 0, EDGE, RIGHT);
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(range(0), range(1))?;
        chart
            .configure_mesh()
            .x_desc(axes::named("depth", self.units.length(), power[0]))
            .y_desc(axes::named("force", self.units.force(), power[1]))
            .x_label_formatter(&|x| axes::tick(*x))
            .y_label_formatter(&|y| axes::tick(*y))
            .label_style((FONT, LABEL))
            .axis_desc_style((FONT, LABEL))
            .light_line_style(TRANSPARENT)
            .bold_line_style(axes::GRID.stroke_width(px(1)))
            .axis_style(BLACK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(5))
            .draw()?;
        let at = |p: &[f64; 2]| (p[0] / unit[0], p[1] / unit[1]);
        chart.draw_series(LineSeries::new(self.line.iter().map(at), COLOURS[1].stroke_width(px(2))))?;
        chart.draw_series(self.solved.iter().map(|p| Circle::new(at(p), axes::at(3), COLOURS[1].filled())))?;
        Ok(())
    }
}
