//! Force against depth: the contact as a non-linear spring.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, px};
use super::frame::{Frame, Medium};
use super::{COLOURS, Error, Fault, Figure, Format, render};
use crate::curve::Curve;
use crate::numeric::cubic::Cubic;
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
    curve_on(Medium::Sheet, units, title, curve, format)
}

/// As [`curve_in`].
///
/// # Errors
/// As [`curve()`].
pub(crate) fn curve_on(
    medium: Medium,
    units: &UnitLabels,
    title: &str,
    curve: &Curve,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let overlap = curve.deepest() - curve.first_touch();
    let at = |k: i32| curve.first_touch() + overlap * f64::from(k) / 200.0;
    let line: Vec<[f64; 2]> = (0..=200).filter_map(|k| Some([at(k), curve.force(at(k))?])).collect();
    let solved: Vec<[f64; 2]> = curve.samples().iter().map(|s| [s.depth, s.force]).collect();
    drawn(medium, units, title, &line, &solved, format)
}

/// States of a list as dots, [depth, force, dP/dd] each in any order, with the law between them as a line: a power law from first touch to
/// the shallowest, and between two states the cubic through force and stiffness of both, in logarithms of overlap and force. Without
/// `first_touch` the dots alone.
///
/// # Errors
/// When there is no state, or drawing fails.
///
/// ```
/// # #[cfg(feature = "plot")] {
/// use contact_patch::plot::{Format, states};
/// // Two states of a ball: force = 4/3 depth^(3/2).
/// let solved = [1.0f64, 4.0].map(|d| [d, 4.0 / 3.0 * d.powf(1.5), 2.0 * d.sqrt()]);
/// assert!(states("ball", &solved, Some(0.0), Format::Svg)?.starts_with(b"<svg"));
/// # }
/// # Ok::<(), contact_patch::plot::Error>(())
/// ```
pub fn states(title: &str, solved: &[[f64; 3]], first_touch: Option<f64>, format: Format) -> Result<Vec<u8>, Error> {
    states_in(&UnitLabels::kinds(), title, solved, first_touch, format)
}

/// As [`states`], with labels of units.
///
/// # Errors
/// As [`states`].
pub fn states_in(
    units: &UnitLabels,
    title: &str,
    solved: &[[f64; 3]],
    first_touch: Option<f64>,
    format: Format,
) -> Result<Vec<u8>, Error> {
    states_on(Medium::Sheet, units, title, solved, first_touch, format)
}

/// As [`states_in`].
///
/// # Errors
/// As [`states`].
pub(crate) fn states_on(
    medium: Medium,
    units: &UnitLabels,
    title: &str,
    solved: &[[f64; 3]],
    first_touch: Option<f64>,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let line = first_touch.map_or(Vec::new(), |touch| between(solved, touch));
    let dots: Vec<[f64; 2]> = solved.iter().map(|s| [s[0], s[1]]).collect();
    drawn(medium, units, title, &line, &dots, format)
}

/// Points of the line between two states.
const BETWEEN: u32 = 60;

/// The law between states, from first touch to the deepest.
fn between(solved: &[[f64; 3]], touch: f64) -> Vec<[f64; 2]> {
    let mut states: Vec<[f64; 3]> =
        solved.iter().copied().filter(|s| s[0] > touch && s[1] > 0.0 && s[2] > 0.0 && s[2].is_finite()).collect();
    states.sort_by(|p, q| p[0].total_cmp(&q[0]));
    states.dedup_by(|p, q| p[0] == q[0]);
    let mut line = vec![[touch, 0.0]];
    let exponent = |s: &[f64; 3]| s[2] * (s[0] - touch) / s[1];
    if let Some(first) = states.first() {
        let law = |t: f64| [touch + t * (first[0] - touch), first[1] * t.powf(exponent(first))];
        line.extend((1..=BETWEEN).map(|k| law(f64::from(k) / f64::from(BETWEEN))));
    }
    for pair in states.windows(2) {
        let [from, to] = [0, 1].map(|k| [(pair[k][0] - touch).ln(), pair[k][1].ln(), exponent(&pair[k])]);
        let h = to[0] - from[0];
        for k in 1..=BETWEEN {
            let depth = pair[0][0] + f64::from(k) / f64::from(BETWEEN) * (pair[1][0] - pair[0][0]);
            let t = ((depth - touch).ln() - from[0]) / h;
            let log = Cubic { t, h }.value(0, [from[1], from[2]], [to[1], to[2]]);
            line.push([depth, log.exp()]);
        }
    }
    line
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
    drawn(Medium::Sheet, units, title, line, solved, format)
}

fn drawn(
    medium: Medium,
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
    render(&Picture { units, frame: Frame::new(medium, title, medium.width()), line, solved }, format)
}

struct Picture<'a> {
    units: &'a UnitLabels,
    frame: Frame,
    line: Vec<[f64; 2]>,
    solved: Vec<[f64; 2]>,
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (self.frame.medium.width(), self.frame.medium.height(px(520)))
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let points = || self.line.iter().chain(&self.solved);
        let largest = |m: usize| points().map(|p| p[m].abs()).fold(0.0, f64::max);
        let least = |m: usize| points().map(|p| p[m]).fold(0.0, f64::min);
        let labels = [self.units.length(), self.units.force()];
        let power = [0, 1].map(|m| axes::power_of_ten(largest(m), labels[m]));
        let unit = power.map(|p| 10f64.powi(p));
        let range = |m: usize| {
            let high = points().map(|p| p[m]).fold(least(m), f64::max);
            let high = if high > least(m) { high } else { least(m) + unit[m] };
            least(m) / unit[m]..1.05 * high / unit[m]
        };
        let inner = area.margin(frame.top, 0, frame.edge, frame.right);
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(frame.bottom)
            .y_label_area_size(frame.left)
            .build_cartesian_2d(range(0), range(1))?;
        frame
            .styled(&mut chart.configure_mesh())
            .x_desc(axes::named("depth", self.units.length(), power[0]))
            .y_desc(axes::named("force", self.units.force(), power[1]))
            .x_label_formatter(&|x| axes::tick(*x))
            .y_label_formatter(&|y| axes::tick(*y))
            .x_labels(if frame.medium == Medium::Phone { 5 } else { 9 })
            .draw()?;
        let at = |p: &[f64; 2]| (p[0] / unit[0], p[1] / unit[1]);
        chart.draw_series(LineSeries::new(self.line.iter().map(at), COLOURS[1].stroke_width(px(2))))?;
        chart.draw_series(self.solved.iter().map(|p| Circle::new(at(p), axes::at(3), COLOURS[1].filled())))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_between_states_of_a_power_law_is_that_law() {
        let force = |d: f64| 3.0 * (d - 0.5).powf(1.5);
        let solved = [4.5, 1.5, 0.6].map(|d| [d, force(d), 4.5 * (d - 0.5f64).sqrt()]);
        let line = between(&solved, 0.5);
        assert_eq!(line.len(), 1 + 3 * BETWEEN as usize);
        assert!(line.iter().skip(1).all(|p| (p[1] / force(p[0]) - 1.0).abs() < 1e-12), "{line:?}");
        assert!(line.windows(2).all(|p| p[0][0] < p[1][0] && p[0][1] < p[1][1]));
    }
}
