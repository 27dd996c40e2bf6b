//! Boundaries of patches on one pair of axes with equal scales.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium, width_of};
use super::window::Window;
use super::{COLOURS, Error, FONT, Fault, Figure, Format, render};
use crate::numeric::geometry::Rect;
use crate::units::UnitLabels;

/// Closed polylines with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// What the legend calls it.
    pub label: String,
    /// Closed polylines, the first point not repeated, units of length.
    pub loops: Vec<Vec<[f64; 2]>>,
}

/// The outlines over each other, each in its colour and with its own dashes; at most six can be told apart.
///
/// # Errors
/// When there is no point to draw, or drawing fails.
///
/// ```
/// # #[cfg(feature = "plot")] {
/// use contact_patch::plot::{Format, Outline, outlines};
/// let square = Outline { label: "square".into(), loops: vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]] };
/// let picture = outlines("one square", &[square], Format::Svg)?;
/// assert!(String::from_utf8_lossy(&picture).starts_with("<svg"));
/// # }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn outlines(title: &str, outlines: &[Outline], format: Format) -> Result<Vec<u8>, Error> {
    outlines_in(&UnitLabels::kinds(), title, outlines, format)
}

/// As [`outlines`], with labels of units.
///
/// # Errors
/// As [`outlines`].
pub fn outlines_in(units: &UnitLabels, title: &str, outlines: &[Outline], format: Format) -> Result<Vec<u8>, Error> {
    outlines_on(Medium::Sheet, units, title, outlines, format)
}

/// As [`outlines_in`].
///
/// # Errors
/// As [`outlines`].
pub(crate) fn outlines_on(
    medium: Medium,
    units: &UnitLabels,
    title: &str,
    outlines: &[Outline],
    format: Format,
) -> Result<Vec<u8>, Error> {
    let points = outlines.iter().flat_map(|o| &o.loops).flatten().copied();
    let seen = Rect::holding(points).ok_or(Error::Empty("there is no patch"))?;
    let margins = Frame::new(medium, "", 0);
    let longest = match medium {
        Medium::Sheet => px(560),
        Medium::Page => px(330),
        Medium::Phone => medium.width() - margins.edge - margins.left - margins.right,
    };
    let window = Window::onto(&seen, longest, units.length());
    // No name runs over the edge.
    let names = outlines.iter().map(|o| width_of(&o.label, margins.label)).max().unwrap_or(0);
    let wanted = margins.edge + margins.left + px(54) + names + px(8);
    let beside = wanted.saturating_sub(window.size(&margins, 0, 0).0);
    let frame = Frame::new(medium, title, window.size(&margins, beside, 0).0);
    render(&Picture { units, outlines, window, frame, beside }, format)
}

struct Picture<'a> {
    units: &'a UnitLabels,
    outlines: &'a [Outline],
    window: Window,
    frame: Frame,
    /// Room on the right for names that are longer than the map is wide.
    beside: u32,
}

/// Lengths of dash and space; no space: a full line.
const DASHES: [[i32; 2]; 6] =
    [[at(1), 0], [at(12), at(5)], [at(3), at(4)], [at(20), at(4)], [at(6), at(6)], [at(2), at(7)]];

impl Figure for Picture<'_> {
    fn size(&self) -> (u32, u32) {
        self.window.size(&self.frame, self.beside, self.frame.legend * self.outlines.len() as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let frame = &self.frame;
        frame.title(area)?;
        let names = frame.legend * self.outlines.len() as u32;
        let inner = area.margin(frame.top + names, 0, frame.edge, frame.right + self.beside);
        let Rect { min, max } = self.window.extent;
        let mut chart = ChartBuilder::on(&inner)
            .x_label_area_size(frame.bottom)
            .y_label_area_size(frame.left)
            .build_cartesian_2d(min[0]..max[0], min[1]..max[1])?;
        mesh(&mut chart.configure_mesh(), self.units, &self.window, frame)?;
        for (k, outline) in self.outlines.iter().enumerate() {
            let (colour, [dash, space]) = (COLOURS[k % COLOURS.len()], DASHES[k % DASHES.len()]);
            for points in &outline.loops {
                let closed = points.iter().chain(points.first()).map(|&p| self.window.place(p));
                if space == 0 {
                    chart.draw_series(LineSeries::new(closed, colour.stroke_width(px(2))))?;
                } else {
                    chart.draw_series(DashedLineSeries::new(
                        closed,
                        dash as u32,
                        space as u32,
                        colour.stroke_width(px(2)),
                    ))?;
                }
            }
            let y = (frame.top + frame.legend * k as u32 + frame.legend / 2) as i32 - at(4);
            let left = (frame.edge + frame.left) as i32;
            let mut x = left;
            while x < left + at(44) {
                let end = if space == 0 { left + at(44) } else { (x + dash).min(left + at(44)) };
                area.draw(&PathElement::new(vec![(x, y), (end, y)], colour.stroke_width(px(2))))?;
                x = end + space.max(1);
            }
            let style = (FONT, frame.label).into_font().into_text_style(area);
            area.draw_text(&outline.label, &style, (left + at(54), y - frame.half()))?;
        }
        Ok(())
    }
}

/// The mesh of a plane with lengths along both axes.
pub(super) fn mesh<'b, DB: DrawingBackend + 'b>(
    mesh: &mut plotters::chart::MeshStyle<
        '_,
        'b,
        plotters::coord::types::RangedCoordf64,
        plotters::coord::types::RangedCoordf64,
        DB,
    >,
    units: &UnitLabels,
    window: &Window,
    frame: &Frame,
) -> Result<(), Fault<DB>> {
    // As many labels as have room: eight figures along x, two lines along y.
    let room = |points: u32, each: u32| (points / each).clamp(3, 7) as usize;
    let power = window.power;
    frame
        .styled(mesh)
        .x_desc(axes::named("x", units.length(), power))
        .y_desc(axes::named("y", units.length(), power))
        .x_label_formatter(&|x| axes::tick(*x))
        .y_label_formatter(&|y| axes::tick(*y))
        .x_labels(room(window.pixels[0], 4 * frame.label))
        .y_labels(room(window.pixels[1], 2 * frame.label))
        .draw()
}
