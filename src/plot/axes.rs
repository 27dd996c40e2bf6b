//! Scales, labels and frames that all pictures share.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::{FONT, Fault};
use crate::numeric::geometry::Rect;

/// Points of a picture for one pixel on the screen: positions are whole numbers, and lines drawn on whole pixels are ragged.
pub(super) const FINE: u32 = 3;

/// So many pixels on the screen, in points.
pub(super) const fn px(pixels: u32) -> u32 {
    FINE * pixels
}

/// As [`px`], for positions.
pub(super) const fn at(pixels: i32) -> i32 {
    FINE as i32 * pixels
}

/// Grid lines.
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);

/// Room for the title, for the labels below and on the left, and beside.
pub(super) const TOP: u32 = px(48);
pub(super) const BOTTOM: u32 = px(54);
pub(super) const LEFT: u32 = px(86);
pub(super) const RIGHT: u32 = px(24);
/// Free space at the left edge, so that the description of the axis is not cut.
pub(super) const EDGE: u32 = px(12);

/// Size of titles and labels.
pub(super) const TITLE: u32 = px(20);
pub(super) const LABEL: u32 = px(16);

/// The power of 1000 by which numbers up to `largest` become readable.
pub(super) fn power_of_ten(largest: f64) -> i32 {
    if largest > 0.0 && largest.is_finite() && !(0.01..10_000.0).contains(&largest) {
        3 * (largest.log10() / 3.0).floor() as i32
    } else {
        0
    }
}

/// "depth (1e-6 length)": the quantity, the power taken out, the kind of unit unless it is the quantity itself.
pub(super) fn named(quantity: &str, unit: &str, power: i32) -> String {
    match (quantity == unit, power) {
        (true, 0) => quantity.to_owned(),
        (true, power) => format!("{quantity} (1e{power})"),
        (false, power) => format!("{quantity} ({})", scaled(unit, power)),
    }
}

/// "1e-6 length", or "length" when no power was taken out.
pub(super) fn scaled(unit: &str, power: i32) -> String {
    if power == 0 { unit.to_owned() } else { format!("1e{power} {unit}") }
}

/// A tick, without trailing noise.
pub(super) fn tick(x: f64) -> String {
    let text = format!("{:.4}", x);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A step of 1, 2 or 5 times a power of ten that divides `largest` into three to eight.
pub(super) fn round_step(largest: f64) -> f64 {
    let decade = 10f64.powf(largest.log10().floor());
    [0.2, 0.5, 1.0, 2.0].map(|m| m * decade).into_iter().find(|step| largest / step <= 6.0).unwrap_or(decade)
}

/// A decade of a logarithmic axis; what lies between is not written.
pub(super) fn decade(x: &f64) -> String {
    let power = x.log10().round();
    if (x / 10f64.powf(power) - 1.0).abs() < 1e-6 { format!("1e{power}") } else { String::new() }
}

/// Whether a character may stand in XML and HTML: no control characters, and none of those that Unicode has set aside for good
/// (U+FDD0 to U+FDEF and the last two of each plane).
pub(crate) fn is_text(c: char) -> bool {
    let code = u32::from(c);
    !c.is_control() && !(0xfdd0..=0xfdef).contains(&code) && code & 0xfffe != 0xfffe
}

/// The title in the middle of the top.
pub(super) fn title<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, text: &str) -> Result<(), Fault<DB>> {
    let (width, _) = area.dim_in_pixel();
    // Cut rather than run over the edge; a letter is about half as wide as it is high.
    let most = (width as usize * 2) / TITLE as usize;
    let text: String = text.chars().filter(|&c| is_text(c)).take(most).collect();
    let style = (FONT, TITLE).into_font().into_text_style(area);
    let taken = area.estimate_text_size(&text, &style)?.0;
    area.draw_text(&text, &style, ((width.saturating_sub(taken) / 2) as i32, (TOP / 4) as i32))
}

/// A window onto the plane with equal scales along x and y.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// What is seen, in units of 10^power.
    pub extent: Rect,
    /// The power of ten taken out of both coordinates.
    pub power: i32,
    /// Pixels of the plotting area.
    pub pixels: [u32; 2],
}

impl Window {
    /// Longer side of the plotting area, pixels.
    const LONGEST: f64 = px(560) as f64;

    /// `seen` with a margin of 6 %.
    pub fn onto(seen: &Rect) -> Self {
        let seen = seen.scaled(1.12);
        let largest = seen.corners().into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
        let power = power_of_ten(largest);
        let unit = 10f64.powi(power);
        let [w, h] = seen.size();
        let longest = w.max(h);
        // A very slender patch keeps an area on which it can be seen; its short side then has room to spare.
        let side = |length: f64| (Self::LONGEST * (length / longest).max(0.3)).round();
        let pixels = [side(w), side(h)];
        let half = pixels.map(|p| 0.5 * p / Self::LONGEST * longest / unit);
        let extent = Rect::around(seen.centre().map(|c| c / unit), half);
        Self { extent, power, pixels: pixels.map(|p| p as u32) }
    }

    /// Size of the picture around it; `beside` pixels more on the right.
    pub fn size(&self, beside: u32) -> (u32, u32) {
        (self.pixels[0] + EDGE + LEFT + RIGHT + beside, self.pixels[1] + TOP + BOTTOM)
    }

    /// A point in the units of the axes.
    pub fn place(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let unit = 10f64.powi(self.power);
        (x / unit, y / unit)
    }
}
