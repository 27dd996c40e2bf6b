//! A section through both bodies under load: the gap as it was, the surface as it is, and the pressure between them.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium, named_stroke, width_of};
use super::pressure::coarsened;
use super::{COLOURS, Error, Fault, Figure, Format, render};
use crate::gap::Gap;
use crate::grid::Pressure;
use crate::problem::Contact;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// Heights along a straight line through the contact, and the pressure there.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// The point from which positions are counted: the centre of pressure.
    pub centre: [f64; 2],
    /// Direction of the line, a unit vector: that in which the pressure is spread widest, x where it is spread evenly.
    pub direction: [f64; 2],
    /// Positions along the line.
    pub along: Vec<f64>,
    /// Gap less approach, -f = gap - depth - ax x - ay y: the bodies pushed into each other without deforming; infinite
    /// where there is no material.
    pub punch: Vec<f64>,
    /// -u: the surface of a half-space that takes all of the deformation.
    pub surface: Vec<f64>,
    /// Pressure.
    pub pressure: Vec<f64>,
}

/// Positions along the line.
const POSITIONS: usize = 281;

/// Cells along the longer side of the field that displaces the surface.
const CELLS: usize = 80;

/// The line is longer than the patch by this.
const BEYOND: f64 = 1.7;

/// Spreads that differ by less than this, relative, are the same: the line then goes along x.
const EVEN: f64 = 0.05;

/// Cells further away than this many of their sides act as a force at their centre: off by 1e-4.
const FAR: f64 = 10.0;

impl Section {
    /// The section of a solved state; `None` without a pressure field or without contact.
    #[must_use]
    pub fn through(contact: &Contact, solution: &Solution) -> Option<Self> {
        let field = solution.pressure.field.as_ref()?;
        let coarse = coarsened(field, CELLS);
        let grid = coarse.grid;
        let loaded: Vec<([f64; 2], f64)> = grid.loaded(&coarse.values).collect();
        let total: f64 = loaded.iter().map(|(_, p)| p).sum();
        if !(total > 0.0) {
            return None;
        }
        let mean = |of: &dyn Fn([f64; 2]) -> f64| loaded.iter().map(|(c, p)| p * of(*c)).sum::<f64>() / total;
        let centre = [mean(&|c| c[0]), mean(&|c| c[1])];
        let [xx, xy, yy] = [[0, 0], [0, 1], [1, 1]].map(|[i, j]| mean(&|c| (c[i] - centre[i]) * (c[j] - centre[j])));
        // Principal axes of the second moments.
        let unevenness = (xx - yy).hypot(2.0 * xy);
        let angle = if unevenness > EVEN * (xx + yy) { 0.5 * (2.0 * xy).atan2(xx - yy) } else { 0.0 };
        let direction = [angle.cos(), angle.sin()];
        let half_cell = 0.5 * (grid.spacing[0] * direction[0].abs() + grid.spacing[1] * direction[1].abs());
        let position = |c: [f64; 2]| (c[0] - centre[0]) * direction[0] + (c[1] - centre[1]) * direction[1];
        let farthest = loaded.iter().map(|(c, _)| position(*c).abs()).fold(0.0, f64::max) + half_cell;
        let mut section =
            Self { centre, direction, along: Vec::new(), punch: Vec::new(), surface: Vec::new(), pressure: Vec::new() };
        for k in 0..POSITIONS {
            let s = BEYOND * farthest * (2.0 * k as f64 / (POSITIONS - 1) as f64 - 1.0);
            let [x, y] = [0, 1].map(|m| centre[m] + s * direction[m]);
            section.along.push(s);
            let [ax, ay] = solution.tilt;
            section.punch.push(contact.gap().gap(x, y) - solution.depth - ax * x - ay * y);
            section.surface.push(-displacement(&loaded, grid.spacing, [x, y]) / contact.modulus().e_star());
            section.pressure.push(interpolated(field, [x, y]));
        }
        Some(section)
    }
}

/// The pressure at a point, bilinear between the centres of cells.
fn interpolated(field: &Pressure, point: [f64; 2]) -> f64 {
    let grid = field.grid;
    let place = [0, 1].map(|m| (point[m] - grid.origin[m]) / grid.spacing[m] - 0.5);
    let value = |cell: [f64; 2]| {
        let inside = (0..2).all(|m| cell[m] >= 0.0 && cell[m] < grid.shape[m] as f64);
        if inside { field.values[cell[1] as usize * grid.shape[0] + cell[0] as usize] } else { 0.0 }
    };
    let [i, j] = place.map(f64::floor);
    let [s, t] = [place[0] - i, place[1] - j];
    (1.0 - t) * ((1.0 - s) * value([i, j]) + s * value([i + 1.0, j]))
        + t * ((1.0 - s) * value([i, j + 1.0]) + s * value([i + 1.0, j + 1.0]))
}

/// u(x) = 1/pi sum of p times the integral of 1/r over its cell (E* = 1; Love 1929).
fn displacement(loaded: &[([f64; 2], f64)], [h, v]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    let far = FAR * h.max(v);
    let integral = |c: [f64; 2]| {
        let [dx, dy] = [x - c[0], y - c[1]];
        let r = dx.hypot(dy);
        if r > far {
            return h * v / r;
        }
        let f = |x: f64, y: f64| {
            let part = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * (b / a.abs()).asinh() };
            part(x, y) + part(y, x)
        };
        let [a, b] = [0.5 * h, 0.5 * v];
        f(dx + a, dy + b) - f(dx - a, dy + b) - f(dx + a, dy - b) + f(dx - a, dy - b)
    };
    loaded.iter().map(|(c, p)| p * integral(*c)).sum::<f64>() / std::f64::consts::PI
}

/// The section as two panels over one axis: heights above, pressure below.
///
/// # Errors
/// When drawing fails.
pub fn section(title: &str, section: &Section, format: Format) -> Result<Vec<u8>, Error> {
    section_in(&UnitLabels::kinds(), title, section, format)
}

/// As [`section`], with labels of units.
///
/// # Errors
/// As [`section`].
pub fn section_in(units: &UnitLabels, title: &str, section: &Section, format: Format) -> Result<Vec<u8>, Error> {
    section_on(Medium::Sheet, units, title, section, format)
}

/// As [`section_in`].
///
/// # Errors
/// As [`section`].
pub(crate) fn section_on(
    medium: Medium,
    units: &UnitLabels,
    title: &str,
    section: &Section,
    format: Format,
) -> Result<Vec<u8>, Error> {
    let deepest = section.surface.iter().copied().fold(0.0, f64::min);
    if !(deepest < 0.0) {
        return Err(Error::Empty("nothing is displaced along the section"));
    }
    render(&Picture { units, frame: Frame::new(medium, title, medium.width()), section, deepest }, format)
}

struct Picture<'a> {
    units: &'a UnitLabels,
    frame: Frame,
    section: &'a Section,
    /// Lowest point of the surface.
    deepest: f64,
}

/// Heights of the panels.
const HEIGHTS: u32 = px(330);
const PRESSURES: u32 = px(170);

/// How much of the punch is seen above the undeformed surface, against the depth of the dent.
const ABOVE: f64 = 0.5;

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        let (frame, medium) = (&self.frame, self.frame.medium);
        let panels = medium.height(HEIGHTS) + medium.height(PRESSURES) + frame.bottom;
        (medium.width(), frame.top + self.legend_lines() * frame.legend + panels)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let Section { along, punch, surface, pressure, .. } = self.section;
        let reach = along.last().copied().unwrap_or(1.0);
        let strongest = pressure.iter().copied().fold(0.0, f64::max);
        let labels = [self.units.length(), self.units.length(), &self.units.pressure()];
        let sizes = [reach, -self.deepest, strongest];
        let powers: [i32; 3] = std::array::from_fn(|k| axes::power_of_ten(sizes[k], labels[k]));
        let [length, height, load] = powers.map(|p| 10f64.powi(p));
        let (low, high) = (1.15 * self.deepest, -ABOVE * self.deepest);
        let x = -reach / length..reach / length;
        let (upper, lower) = area
            .margin(frame.top + self.legend_lines() * frame.legend, 0, frame.edge, frame.right)
            .split_vertically(frame.medium.height(HEIGHTS));

        let mut chart = ChartBuilder::on(&upper)
            .y_label_area_size(frame.left)
            .margin_bottom(px(10))
            .build_cartesian_2d(x.clone(), low / height..high / height)?;
        frame
            .styled(&mut chart.configure_mesh())
            .y_desc(axes::named("height", self.units.length(), powers[1]))
            .y_label_formatter(&|y| axes::tick(*y))
            .x_labels(if frame.medium == Medium::Phone { 5 } else { 9 })
            .y_labels(7)
            .draw()?;
        // The gap that is left, between the surface and the punch above it.
        let top = |k: usize| (along[k] / length, punch[k].max(surface[k]).min(high) / height);
        let bottom = |k: usize| (along[k] / length, surface[k] / height);
        let around: Vec<(f64, f64)> = (0..along.len()).map(bottom).chain((0..along.len()).rev().map(top)).collect();
        chart.draw_series([Polygon::new(around, RGBColor(236, 236, 236).filled())])?;
        let points =
            |of: &[f64]| -> Vec<[f64; 2]> { along.iter().zip(of).map(|(&s, &z)| [s / length, z / height]).collect() };
        chart.draw_series(DashedLineSeries::new(
            [(-reach / length, 0.0), (reach / length, 0.0)],
            px(3),
            px(5),
            BLACK.stroke_width(px(1)),
        ))?;
        let surface = points(surface).into_iter().map(|[s, z]| (s, z));
        chart.draw_series(LineSeries::new(surface, COLOURS[1].stroke_width(px(3))))?;
        for piece in below(&points(punch), high / height) {
            chart.draw_series(DashedLineSeries::new(
                piece.into_iter().map(|[s, z]| (s, z)),
                px(9),
                px(5),
                COLOURS[2].stroke_width(px(2)),
            ))?;
        }

        let mut chart = ChartBuilder::on(&lower)
            .x_label_area_size(frame.bottom)
            .y_label_area_size(frame.left)
            .build_cartesian_2d(x, 0.0..1.08 * strongest.max(f64::MIN_POSITIVE) / load)?;
        frame
            .styled(&mut chart.configure_mesh())
            .x_desc(axes::named("position along the section", self.units.length(), powers[0]))
            .y_desc(axes::named("pressure", &self.units.pressure(), powers[2]))
            .x_label_formatter(&|x| axes::tick(*x))
            .y_label_formatter(&|y| axes::tick(*y))
            .x_labels(if frame.medium == Medium::Phone { 5 } else { 9 })
            .y_labels(if frame.medium == Medium::Sheet { 4 } else { 3 })
            .draw()?;
        let line = || along.iter().zip(pressure).map(|(&s, &p)| (s / length, p / load));
        let ends = [(reach / length, 0.0), (-reach / length, 0.0)];
        chart.draw_series([Polygon::new(line().chain(ends).collect::<Vec<_>>(), RGBColor(206, 224, 236).filled())])?;
        chart.draw_series(LineSeries::new(line(), BLACK.stroke_width(px(2))))?;
        self.legend(area)
    }
}

impl Picture<'_> {
    /// What the legend names.
    const NAMES: [&'static str; 3] = ["surface under load", "gap less approach", "gap that is left"];

    /// Lines that the legend takes: one, where it fits into one.
    fn legend_lines(&self) -> u32 {
        let frame = &self.frame;
        let taken: u32 = Self::NAMES.iter().map(|name| px(60) + width_of(name, frame.label)).sum();
        if taken + frame.edge + frame.left <= frame.medium.width() { 1 } else { 3 }
    }

    fn legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        let left = (frame.edge + frame.left) as i32;
        let mut y = (frame.top + frame.legend / 2) as i32 - at(6);
        let mut x = left;
        for (k, name) in Self::NAMES.into_iter().enumerate() {
            let next = named_stroke(area, frame, [x, y], name, |area, from, to| match k {
                0 => area.draw(&PathElement::new(vec![(from, y), (to, y)], COLOURS[1].stroke_width(px(3)))),
                1 => [from, from + at(11), from + at(22)].into_iter().try_for_each(|piece| {
                    let dash = vec![(piece, y), (piece + at(8), y)];
                    area.draw(&PathElement::new(dash, COLOURS[2].stroke_width(px(2))))
                }),
                _ => area.draw(&Rectangle::new([(from, y - at(6)), (to, y + at(6))], RGBColor(236, 236, 236).filled())),
            })?;
            (x, y) = if self.legend_lines() == 1 { (next, y) } else { (left, y + frame.legend as i32) };
        }
        Ok(())
    }
}

/// The pieces of a polyline that lie below a height, cut where they cross it.
fn below(points: &[[f64; 2]], top: f64) -> Vec<Vec<[f64; 2]>> {
    let mut pieces = vec![Vec::new()];
    let mut before: Option<[f64; 2]> = None;
    for &[s, z] in points {
        if let Some([s0, z0]) = before
            && (z0 <= top) != (z <= top)
        {
            // Straight up where there is no material on the other side.
            let t = if z.is_finite() && z0.is_finite() { (top - z0) / (z - z0) } else { f64::from(z.is_finite()) };
            pieces.last_mut().into_iter().for_each(|piece| piece.push([s0 + t * (s - s0), top]));
            if z > top {
                pieces.push(Vec::new());
            }
        }
        if z <= top {
            pieces.last_mut().into_iter().for_each(|piece| piece.push([s, z]));
        }
        before = Some([s, z]);
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::Paraboloid;
    use crate::{EffectiveModulus, Loading, Method, Outputs, Settings, solve};

    #[test]
    fn under_a_ball_the_surface_is_that_of_hertz() {
        let ball = Paraboloid::new([1.0, 1.0]).unwrap();
        let contact = Contact::new(EffectiveModulus::from_e_star(2.0).unwrap(), ball, Loading::depth(1.0)).unwrap();
        let outputs = Outputs { pressure: true, ..Outputs::default() };
        let settings = Settings { method: Method::Fft, cells: Some(96), outputs, ..Settings::default() };
        let section = Section::through(&contact, &solve(&contact, &settings).remove(0).unwrap()).unwrap();
        for k in 0..section.along.len() {
            let r = section.along[k].abs();
            // Johnson 1985, (3.42): a = p0 = 1/(pi/2) = d = 1 in these units.
            let u = if r <= 1.0 {
                1.0 - 0.5 * r * r
            } else {
                ((2.0 - r * r) * (1.0 / r).asin() + (r * r - 1.0).sqrt()) / std::f64::consts::PI
            };
            assert!((section.surface[k] + u).abs() < 3e-3, "{r}: {} against {u}", -section.surface[k]);
            assert!((section.punch[k] - (0.5 * r * r - 1.0)).abs() < 1e-3);
        }
    }

    #[test]
    fn what_is_above_is_cut_off() {
        let pieces = below(&[[0.0, 2.0], [1.0, 0.0], [2.0, 0.0], [3.0, 4.0], [4.0, f64::INFINITY]], 1.0);
        assert_eq!(pieces, [[[0.5, 1.0], [1.0, 0.0], [2.0, 0.0], [2.25, 1.0]]]);
        assert_eq!(below(&[[0.0, f64::INFINITY], [1.0, 0.0]], 1.0), [[[1.0, 1.0], [1.0, 0.0]]]);
    }
}
