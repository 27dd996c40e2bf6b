//! Width of a bracket against the number of cells, both logarithmic.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium};
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};

/// A line with its name: points (cells along the longer side, size relative to the force).
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// What the legend calls it.
    pub label: String,
    /// Points; those that are not finite and greater than zero are left out.
    pub points: Vec<[f64; 2]>,
}

/// How widths or errors fall as cells get smaller, one line each, at most six.
///
/// # Errors
/// When there is no point, or drawing fails.
pub fn width_against_cells(title: &str, lines: &[Refinement], format: Format) -> Result<Vec<u8>, Error> {
    width_against_cells_on(Medium::Sheet, title, lines, format)
}

/// As [`width_against_cells`].
///
/// # Errors
/// As [`width_against_cells`].
pub(crate) fn width_against_cells_on(
    medium: Medium,
    title: &str,
    lines: &[Refinement],
    format: Format,
) -> Result<Vec<u8>, Error> {
    let lines: Vec<(&str, Vec<[f64; 2]>)> = lines
        .iter()
        .map(|line| {
            (
                line.label.as_str(),
                line.points.iter().copied().filter(|p| p.iter().all(|x| *x > 0.0 && x.is_finite())).collect(),
            )
        })
        .collect();
    if lines.iter().all(|(_, points)| points.is_empty()) {
        return Err(Error::Empty("there is no width greater than zero"));
    }
    render(&Picture { frame: Frame::new(medium, title, medium.width()), lines }, format)
}

struct Picture<'a> {
    frame: Frame,
    lines: Vec<(&'a str, Vec<[f64; 2]>)>,
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        let medium = self.frame.medium;
        (medium.width(), medium.height(px(440)) + self.frame.legend * self.lines.len() as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let points = || self.lines.iter().flat_map(|(_, points)| points);
        let range = |m: usize| {
            let (low, high) = points().fold((f64::INFINITY, 0.0f64), |(low, high), p| (low.min(p[m]), high.max(p[m])));
            (low, high)
        };
        let ((coarse, fine), (least, most)) = (range(0), range(1));
        let names = frame.legend * self.lines.len() as u32;
        let inner = area.margin(frame.top + names, 0, frame.edge, frame.right);
        let mut chart =
            ChartBuilder::on(&inner).x_label_area_size(frame.bottom).y_label_area_size(frame.left).build_cartesian_2d(
                (0.8 * coarse..1.25 * fine).log_scale().base(2.0),
                (axes::decade_below(0.9 * least)..axes::decade_above(1.1 * most)).log_scale(),
            )?;
        frame
            .styled(&mut chart.configure_mesh())
            .x_desc("cells along the longer side")
            .y_desc("share of the force")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&axes::decade)
            .draw()?;
        for (k, (label, points)) in self.lines.iter().enumerate() {
            let colour = COLOURS[(k + 1) % COLOURS.len()];
            let place = || points.iter().map(|p| (p[0], p[1]));
            chart.draw_series(LineSeries::new(place(), colour.stroke_width(px(2))))?;
            chart.draw_series(place().map(|place| Circle::new(place, at(4), colour.filled())))?;
            let (x, y) = (
                (frame.edge + frame.left) as i32,
                (frame.top + frame.legend * k as u32 + frame.legend / 2) as i32 - at(4),
            );
            area.draw(&PathElement::new(vec![(x, y), (x + at(44), y)], colour.stroke_width(px(2))))?;
            area.draw(&Circle::new((x + at(22), y), at(4), colour.filled()))?;
            let style = (FONT, frame.label).into_font().into_text_style(area);
            area.draw_text(label, &style, (x + at(54), y - frame.half()))?;
        }
        Ok(())
    }
}
