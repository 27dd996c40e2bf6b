//! Error of the force against run time, both logarithmic, one line a method.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium, width_of};
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};
use crate::compare::{Comparison, Figures};
use crate::problem::Method;

/// The runs of a comparison: a bar on each point for the uncertainty of the reference, a ring around each point of the Pareto
/// front, a grey band where errors are too small to be told from that uncertainty. Errors below the axis stand on it.
///
/// # Errors
/// When no run was solved, or drawing fails.
pub fn error_against_time(title: &str, comparison: &Comparison, format: Format) -> Result<Vec<u8>, Error> {
    error_against_time_on(Medium::Sheet, title, comparison, format)
}

/// As [`error_against_time`].
///
/// # Errors
/// As [`error_against_time`].
pub(crate) fn error_against_time_on(
    medium: Medium,
    title: &str,
    comparison: &Comparison,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let runs = comparison.runs.iter().filter_map(|run| Some((run.method, run.outcome.as_ref().ok()?)));
    let runs: Vec<(Method, &Figures)> = runs.filter(|(_, f)| f.error.is_finite()).collect();
    let (Some(reference), false) = (&comparison.reference, runs.is_empty()) else {
        return Err(Error::Empty("no method solved the scene"));
    };
    let uncertainty = if reference.uncertainty.is_finite() { reference.uncertainty } else { 0.0 };
    // A decade below what can be told, or below the smallest error of a method that is not the reference itself.
    let smallest = runs.iter().map(|(_, f)| f.error.abs()).filter(|e| *e > 1e-12).fold(1.0, f64::min);
    let floor = axes::decade_below(0.1 * smallest.max(uncertainty));
    let mut picture = Picture { frame: Frame::new(medium, title, medium.width()), runs, uncertainty, floor };
    if medium == Medium::Sheet {
        picture.frame = Frame::new(medium, title, picture.size().0);
    }
    render(&picture, format)
}

struct Picture<'a> {
    frame: Frame,
    runs: Vec<(Method, &'a Figures)>,
    uncertainty: f64,
    floor: f64,
}

/// The order of the legend, and the colours.
const METHODS: [Method; 6] =
    [Method::ClosedForm, Method::Fft, Method::Fabrikant, Method::Qp, Method::Auto, Method::Ritz];

/// Shortest run time shown, seconds: what a clock can tell.
const SHORTEST: f64 = 1e-7;

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        let medium = self.frame.medium;
        let legend = self.frame.legend * (self.legend().last().map_or(0, |entry| entry.line) + 1);
        (medium.width(), medium.height(px(500)) + legend)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let legend = self.legend();
        let names = frame.legend * (legend.last().map_or(0, |entry| entry.line) + 1);
        let times = || self.runs.iter().map(|(_, f)| f.seconds.max(SHORTEST));
        let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
        let highest = self.runs.iter().map(|(_, f)| f.error.abs()).fold(10.0 * self.floor, f64::max);
        // A little wider, so that rounding does not lose the label of the end.
        let (left, right) =
            ((1.0 - 1e-9) * axes::decade_below(0.8 * first), (1.0 + 1e-9) * axes::decade_above(1.25 * last));
        let top = axes::decade_above(1.25 * highest.max(self.uncertainty));
        let inner = area.margin(frame.top + names, 0, frame.edge, frame.right);
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(frame.bottom)
            .y_label_area_size(frame.left)
            .build_cartesian_2d((left..right).log_scale(), (self.floor..top).log_scale())?;
        if self.uncertainty > self.floor {
            let band = [(left, self.floor), (right, self.uncertainty)];
            chart.draw_series([Rectangle::new(band, RGBColor(232, 232, 232).filled())])?;
        }
        frame
            .styled(&mut chart.configure_mesh())
            .x_desc("run time, s")
            .y_desc("relative error of the force")
            .x_label_formatter(&axes::decade)
            .y_label_formatter(&axes::decade)
            .draw()?;
        for (k, method) in METHODS.into_iter().enumerate() {
            let colour = COLOURS[k];
            let mine: Vec<&Figures> = self.runs.iter().filter(|(m, _)| *m == method).map(|(_, f)| *f).collect();
            let place = |f: &Figures| (f.seconds.max(SHORTEST), f.error.abs().max(self.floor));
            chart.draw_series(LineSeries::new(mine.iter().map(|f| place(f)), colour.stroke_width(px(2))))?;
            for figures in &mine {
                let (t, e) = place(figures);
                let size = figures.error.abs();
                let bar = [(size - self.uncertainty).max(self.floor), (size + self.uncertainty).max(self.floor)];
                chart.draw_series([PathElement::new(bar.map(|e| (t, e)).to_vec(), colour.stroke_width(px(1)))])?;
                chart.draw_series([Circle::new((t, e), at(4), colour.filled())])?;
                if figures.behind <= 1.0 {
                    chart.draw_series([Circle::new((t, e), at(8), BLACK.stroke_width(px(1)))])?;
                }
            }
        }
        for Entry { what, line, x, name } in legend {
            let y = (frame.top + frame.legend * line + frame.legend / 2) as i32 - at(4);
            let x = (frame.edge + frame.left) as i32 + x;
            match what {
                Some(method) => {
                    let colour = METHODS.iter().position(|m| *m == method).map_or(BLACK, |k| COLOURS[k]);
                    area.draw(&PathElement::new(vec![(x, y), (x + at(24), y)], colour.stroke_width(px(2))))?;
                    area.draw(&Circle::new((x + at(12), y), at(4), colour.filled()))?;
                }
                None if name == FRONT => {
                    area.draw(&Circle::new((x + at(12), y), at(7), BLACK.stroke_width(px(1))))?;
                }
                None => {
                    let band = [(x, y - at(7)), (x + at(24), y + at(7))];
                    area.draw(&Rectangle::new(band, RGBColor(232, 232, 232).filled()))?;
                }
            }
            let style = (FONT, frame.label).into_font().into_text_style(area);
            area.draw_text(name, &style, (x + at(30), y - frame.half()))?;
        }
        Ok(())
    }
}

/// Names of what is no method.
const FRONT: &str = "Pareto front";
const BAND: &str = "uncertainty of the reference";

/// A name in the legend, in which line and how far from its beginning.
struct Entry {
    what: Option<Method>,
    line: u32,
    x: i32,
    name: &'static str,
}

impl Picture<'_> {
    /// Names side by side as far as they have room.
    fn legend(&self) -> Vec<Entry> {
        let frame = &self.frame;
        let room = (frame.medium.width() - frame.edge - frame.left) as i32;
        let shown = METHODS.into_iter().filter(|m| self.runs.iter().any(|(of, _)| of == m));
        let names = shown.map(|m| (Some(m), m.name())).chain([(None, FRONT), (None, BAND)]);
        let (mut line, mut x) = (0, 0);
        names
            .map(|(what, name)| {
                let taken = at(30) + width_of(name, frame.label) as i32 + at(8);
                if x > 0 && x + taken > room {
                    (line, x) = (line + 1, 0);
                }
                let entry = Entry { what, line, x, name };
                x += taken + at(10);
                entry
            })
            .collect()
    }
}
