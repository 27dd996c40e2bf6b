//! Error of the force against run time, both logarithmic, one line a method.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, BOTTOM, EDGE, LABEL, LEFT, TOP, at, px};
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};
use crate::compare::{Comparison, Figures};
use crate::problem::Method;

/// The runs of a comparison: a bar on each point for the uncertainty of the reference, a ring around each point of the Pareto
/// front, a grey band where errors are too small to be told from that uncertainty. Errors below the axis stand on it.
///
/// # Errors
/// When no run was solved, or drawing fails.
pub fn error_against_time(title: &str, comparison: &Comparison, format: Format) -> Result<Vec<u8>, Error> {
    let runs = comparison.runs.iter().filter_map(|run| Some((run.method, run.outcome.as_ref().ok()?)));
    let runs: Vec<(Method, &Figures)> = runs.filter(|(_, f)| f.error.is_finite()).collect();
    let (Some(reference), false) = (&comparison.reference, runs.is_empty()) else {
        return Err(Error::Empty("no method solved the scene"));
    };
    let uncertainty = if reference.uncertainty.is_finite() { reference.uncertainty } else { 0.0 };
    // A decade below what can be told, or below the smallest error of a method that is not the reference itself.
    let smallest = runs.iter().map(|(_, f)| f.error.abs()).filter(|e| *e > 1e-12).fold(1.0, f64::min);
    let floor = decade_below(0.1 * smallest.max(uncertainty));
    render(&Picture { title, runs, uncertainty, floor }, format)
}

struct Picture<'a> {
    title: &'a str,
    runs: Vec<(Method, &'a Figures)>,
    uncertainty: f64,
    floor: f64,
}

/// The order of the legend, and the colours.
const METHODS: [Method; 6] =
    [Method::ClosedForm, Method::Fft, Method::Fabrikant, Method::Qp, Method::Auto, Method::Ritz];

/// Room beside the picture for the legend.
const BESIDE: u32 = px(170);

/// Shortest run time shown, seconds: what a clock can tell.
const SHORTEST: f64 = 1e-7;

fn decade_below(x: f64) -> f64 {
    10f64.powf(x.log10().floor())
}

fn decade_above(x: f64) -> f64 {
    10f64.powf(x.log10().ceil())
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (px(820), px(540))
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        axes::title(area, self.title)?;
        let (width, _) = area.dim_in_pixel();
        let times = || self.runs.iter().map(|(_, f)| f.seconds.max(SHORTEST));
        let (first, last) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
        let highest = self.runs.iter().map(|(_, f)| f.error.abs()).fold(10.0 * self.floor, f64::max);
        // A little wider, so that rounding does not lose the label of the end.
        let (left, right) = ((1.0 - 1e-9) * decade_below(0.8 * first), (1.0 + 1e-9) * decade_above(1.25 * last));
        let top = decade_above(1.25 * highest.max(self.uncertainty));
        let inner = area.margin(TOP, 0, EDGE, BESIDE);
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d((left..right).log_scale(), (self.floor..top).log_scale())?;
        if self.uncertainty > self.floor {
            let band = [(left, self.floor), (right, self.uncertainty)];
            chart.draw_series([Rectangle::new(band, RGBColor(232, 232, 232).filled())])?;
        }
        chart
            .configure_mesh()
            .x_desc("run time, s")
            .y_desc("relative error of the force")
            .x_label_formatter(&axes::decade)
            .y_label_formatter(&axes::decade)
            .label_style((FONT, LABEL))
            .axis_desc_style((FONT, LABEL))
            .light_line_style(TRANSPARENT)
            .bold_line_style(axes::GRID.stroke_width(px(1)))
            .axis_style(BLACK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(5))
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
            if !mine.is_empty() {
                legend(area, (width - BESIDE) as i32 + at(12), k, method.name(), colour)?;
            }
        }
        let x = (width - BESIDE) as i32 + at(12);
        let style = (FONT, LABEL).into_font().into_text_style(area);
        let y = TOP as i32 + at(24) * METHODS.len() as i32 + at(16);
        area.draw(&Circle::new((x + at(12), y), at(8), BLACK.stroke_width(px(1))))?;
        area.draw_text("Pareto front", &style, (x + at(30), y - LABEL as i32 * 3 / 8))?;
        area.draw(&Rectangle::new([(x, y + at(16)), (x + at(24), y + at(32))], RGBColor(232, 232, 232).filled()))?;
        area.draw_text("uncertainty of", &style, (x + at(30), y + at(16)))?;
        area.draw_text("the reference", &style, (x + at(30), y + at(34)))
    }
}

fn legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    x: i32,
    line: usize,
    name: &str,
    colour: RGBColor,
) -> Result<(), Fault<DB>> {
    let y = TOP as i32 + at(12) + at(24) * line as i32;
    area.draw(&PathElement::new(vec![(x, y), (x + at(24), y)], colour.stroke_width(px(2))))?;
    area.draw(&Circle::new((x + at(12), y), at(4), colour.filled()))?;
    let style = (FONT, LABEL).into_font().into_text_style(area);
    area.draw_text(name, &style, (x + at(30), y - LABEL as i32 * 3 / 8))
}
