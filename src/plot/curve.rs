//! Force against depth: the contact as a non-linear spring.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, BOTTOM, EDGE, LABEL, LEFT, RIGHT, TOP};
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};

/// Points (depth, force), in any order, joined by lines.
///
/// # Errors
/// When there is no point, or drawing fails.
pub fn force_depth(title: &str, points: &[[f64; 2]], format: Format) -> Result<Vec<u8>, Error> {
    let mut points: Vec<[f64; 2]> = points.iter().copied().filter(|p| p.iter().all(|x| x.is_finite())).collect();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    if points.is_empty() {
        return Err(Error::Empty("there is no point of the curve"));
    }
    render(&Picture { title, points }, format)
}

struct Picture<'a> {
    title: &'a str,
    points: Vec<[f64; 2]>,
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (720, 520)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        axes::title(area, self.title)?;
        let largest = |m: usize| self.points.iter().map(|p| p[m].abs()).fold(0.0, f64::max);
        let least = |m: usize| self.points.iter().map(|p| p[m]).fold(0.0, f64::min);
        let power = [0, 1].map(|m| axes::power_of_ten(largest(m)));
        let unit = power.map(|p| 10f64.powi(p));
        let range = |m: usize| {
            let high = self.points.iter().map(|p| p[m]).fold(least(m), f64::max);
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
            .x_desc(axes::named("depth", power[0]))
            .y_desc(axes::named("force", power[1]))
            .x_label_formatter(&|x| axes::tick(*x))
            .y_label_formatter(&|y| axes::tick(*y))
            .label_style((FONT, LABEL))
            .axis_desc_style((FONT, LABEL))
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()?;
        let at = |p: &[f64; 2]| (p[0] / unit[0], p[1] / unit[1]);
        chart.draw_series(LineSeries::new(self.points.iter().map(at), COLOURS[1].stroke_width(2)))?;
        chart.draw_series(self.points.iter().map(|p| Circle::new(at(p), 3, COLOURS[1].filled())))?;
        Ok(())
    }
}
