//! The pressure as a surface over the plane, seen from above at an angle.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium};
use super::pressure::{coarsened, highest};
use super::scale::Scale;
use super::{Error, FONT, Fault, Figure, Format, SHADES, colour, render};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::Rect;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// The pressure field of a solution (`outputs.pressure`) as a surface in parallel projection, x to the right, y to the back, in the
/// colours of [`super::pressure_map`].
///
/// # Errors
/// When the solution has no field or no pressure, or drawing fails.
pub fn surface(title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    surface_in(&UnitLabels::kinds(), title, solution, format)
}

/// As [`surface`], with labels of units.
///
/// # Errors
/// As [`surface`].
pub fn surface_in(units: &UnitLabels, title: &str, solution: &Solution, format: Format) -> Result<Vec<u8>, Error> {
    let whole = solution.pressure.field.as_ref().ok_or(Error::Empty("the solution has no pressure field"))?;
    let field = coarsened(whole, MOST_CELLS);
    let loaded = field.grid.loaded(&field.values).map(|(c, _)| c);
    let seen = Rect::holding(loaded).ok_or(Error::Empty("there is no pressure"))?;
    let [h, v] = field.grid.spacing;
    let seen = Rect {
        min: [seen.min[0] - 2.0 * h, seen.min[1] - 2.0 * v],
        max: [seen.max[0] + 2.0 * h, seen.max[1] + 2.0 * v],
    };
    let frame = Frame::new(Medium::Sheet, title, px(WIDTH));
    let (highest, without_end) = (highest(solution), solution.pressure.singular.is_some());
    render(&Picture { units, frame, field, seen, highest, without_end }, format)
}

/// Cells along the longer side: more of them are narrower than a line.
const MOST_CELLS: usize = 80;

const WIDTH: u32 = 720;
const HEIGHT: u32 = 460;

/// Direction of the view: turned about the vertical, and down from the horizontal, degrees.
const TURN: f64 = -35.0;
const DOWN: f64 = 32.0;

/// Height of the surface against the longer side of what is under it.
const RISE: f64 = 0.55;

/// A piece of the surface: how far away it is, where its corners are seen, its pressure.
type Quad = (f64, [(i32, i32); 4], f64);

struct Picture<'a> {
    units: &'a UnitLabels,
    frame: Frame,
    field: Pressure,
    seen: Rect,
    highest: f64,
    without_end: bool,
}

impl Picture<'_> {
    /// Where a point (x, y) at a share of the height is seen, and how far away it is: plane coordinates, and points once fitted.
    fn projected(&self, [x, y]: [f64; 2], share: f64) -> [f64; 3] {
        let [w, h] = self.seen.size();
        let longest = w.max(h);
        let centre = self.seen.centre();
        let [u, v] = [(x - centre[0]) / longest, (y - centre[1]) / longest];
        let (turn, down) = (TURN.to_radians(), DOWN.to_radians());
        let right = u * turn.cos() - v * turn.sin();
        let away = u * turn.sin() + v * turn.cos();
        [right, away * down.sin() + RISE * share * down.cos(), away]
    }
}

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        (px(WIDTH), self.frame.top + px(HEIGHT))
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let share = |p: f64| (p / self.highest).min(1.0);
        let corners = self.seen.corners();
        let flat = corners.map(|c| self.projected(c, 0.0));
        let high = corners.map(|c| self.projected(c, 1.0));
        let all = || flat.iter().chain(&high);
        let range =
            |m: usize| all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[m]), high.max(p[m])));
        let ((left, right), (low, top)) = (range(0), range(1));
        let room = [px(WIDTH) - px(150) - px(60), px(HEIGHT) - px(70)].map(f64::from);
        let unit = (room[0] / (right - left)).min(room[1] / (top - low));
        let place = |p: [f64; 3]| {
            let x = f64::from(px(30)) + 0.5 * (room[0] - unit * (right - left)) + unit * (p[0] - left);
            let y = f64::from(frame.top) + unit * (top - p[1]);
            (x.round() as i32, y.round() as i32)
        };
        let floor: Vec<(i32, i32)> = flat.iter().chain(flat.first()).map(|p| place(*p)).collect();
        area.draw(&PathElement::new(floor, axes::GRID.stroke_width(px(1))))?;
        let Grid { shape: [nx, ny], .. } = self.field.grid;
        let value = |i: usize, j: usize| self.field.values[j * nx + i];
        let mut quads: Vec<Quad> = Vec::new();
        for j in 0..ny.saturating_sub(1) {
            for i in 0..nx.saturating_sub(1) {
                let nodes = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                let pressures = nodes.map(|(i, j)| value(i, j));
                if pressures.iter().all(|p| !(*p > 0.0)) {
                    continue;
                }
                let points = nodes.map(|(i, j)| self.projected(self.field.grid.centre(i, j), share(value(i, j))));
                let away = points.iter().map(|p| p[2]).sum::<f64>();
                quads.push((away, points.map(place), pressures.iter().sum::<f64>() / 4.0));
            }
        }
        // The farthest first.
        quads.sort_by(|p, q| q.0.total_cmp(&p.0));
        for (_, points, p) in quads {
            let step = ((share(p) * f64::from(SHADES)) as u32).min(SHADES - 1);
            area.draw(&Polygon::new(points.to_vec(), colour(step).filled()))?;
            let around: Vec<(i32, i32)> = points.iter().chain(points.first()).copied().collect();
            area.draw(&PathElement::new(around, BLACK.mix(0.25).stroke_width(1)))?;
        }
        // The sides of what is seen, named where they begin and end.
        let length = self.seen.corners().into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
        let power = axes::power_of_ten(length, self.units.length());
        let style = (FONT, frame.label).into_font().into_text_style(area);
        let tick = |x: f64| axes::brief(x / 10f64.powi(power));
        let [c00, c10, c11, _] = flat.map(place);
        let middle = |a: (i32, i32), b: (i32, i32)| ((a.0 + b.0) / 2, (a.1 + b.1) / 2);
        for (name, (x, y)) in [("x", middle(c00, c10)), ("y", middle(c10, c11))] {
            let aside = if name == "x" { -at(16) } else { at(8) };
            area.draw_text(name, &style, (x + aside, y + at(6)))?;
        }
        let bottom = (frame.top + px(HEIGHT)) as i32;
        for (m, name) in ["x", "y"].into_iter().enumerate() {
            let [from, to] = [self.seen.min[m], self.seen.max[m]].map(tick);
            let said = format!("{}: {from} to {to}", axes::named(name, self.units.length(), power));
            area.draw_text(&said, &style, (at(30), bottom - at(44) + m as i32 * at(20)))?;
        }
        let scale = Scale {
            quantity: "pressure",
            unit: self.units.pressure(),
            highest: self.highest,
            without_end: self.without_end,
        };
        scale.beside(area, frame, px(WIDTH) - px(140), px(HEIGHT) - px(90))
    }
}
