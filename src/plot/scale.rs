//! The scale of colours of a map: beside it, or below it where the page is narrow.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{self, at, px};
use super::frame::{Frame, Medium, width_of};
use super::{FONT, Fault, SHADES, colour};

/// A scale of colours from zero to `highest`.
pub(super) struct Scale<'a> {
    pub quantity: &'a str,
    pub unit: String,
    /// The value at its dark end.
    pub highest: f64,
    /// Whether there are values beyond that.
    pub without_end: bool,
}

impl Scale<'_> {
    /// Points that it takes on the right of the map, and below it.
    pub fn room(medium: Medium) -> [u32; 2] {
        match medium {
            Medium::Sheet => [px(150), 0],
            Medium::Page => [px(112), 0],
            Medium::Phone => [0, px(68)],
        }
    }

    /// Values with a tick, with what is written beside them: the end of the scale is one of them.
    fn ticks(&self, parts: f64) -> (i32, Vec<(f64, String)>) {
        let power = axes::power_of_ten(self.highest, &self.unit);
        let largest = self.highest / 10f64.powi(power);
        let step = axes::round_step(largest, parts);
        let mut ticks: Vec<(f64, String)> = (0..)
            .map(|k| f64::from(k) * step)
            // The end of the scale needs room for itself.
            .take_while(|value| *value <= largest - 0.45 * step)
            .map(|value| (value / largest, axes::tick(value)))
            .collect();
        ticks.push((1.0, axes::brief(largest)));
        (power, ticks)
    }

    /// On the right of a map of this height, which begins at `left`.
    pub fn beside<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        frame: &Frame,
        left: u32,
        height: u32,
    ) -> Result<(), Fault<DB>> {
        let (left, start) = (left as i32 + at(18), frame.top as i32);
        let label = frame.label as i32;
        let top = start + 2 * label + at(if self.without_end { 24 } else { 14 });
        let bottom = (start + height as i32).max(top + at(60));
        let level = |share: f64| bottom - (f64::from(bottom - top) * share).round() as i32;
        for k in 0..SHADES {
            let [low, high] = [k, k + 1].map(|k| level(f64::from(k) / f64::from(SHADES)));
            area.draw(&Rectangle::new([(left, high), (left + at(18), low)], colour(k).filled()))?;
        }
        area.draw(&Rectangle::new([(left, top), (left + at(18), bottom)], BLACK.stroke_width(px(1))))?;
        if self.without_end {
            let points = vec![(left, top), (left + at(9), top - at(12)), (left + at(18), top)];
            area.draw(&Polygon::new(points.clone(), colour(SHADES - 1).filled()))?;
            area.draw(&PathElement::new(points, BLACK.stroke_width(px(1))))?;
        }
        let parts = (f64::from(bottom - top) / f64::from(2 * frame.label)).clamp(1.0, 7.0);
        let (power, ticks) = self.ticks(parts);
        let style = (FONT, frame.label).into_font().into_text_style(area);
        area.draw_text(self.quantity, &style, (left, start - at(4)))?;
        area.draw_text(&axes::scaled(&self.unit, power), &style, (left, start - at(4) + label * 5 / 4))?;
        for (share, text) in ticks {
            let y = level(share);
            area.draw(&PathElement::new(vec![(left + at(18), y), (left + at(23), y)], BLACK.stroke_width(px(1))))?;
            area.draw_text(&text, &style, (left + at(27), y - frame.half()))?;
        }
        Ok(())
    }

    /// Below a map, from `left` to `right`, its upper edge at `top`.
    pub fn below<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        frame: &Frame,
        [left, right]: [u32; 2],
        top: u32,
    ) -> Result<(), Fault<DB>> {
        let style = (FONT, frame.label).into_font().into_text_style(area);
        let (power, ticks) = self.ticks(4.0);
        let said = format!("{} ({})", self.quantity, axes::scaled(&self.unit, power));
        area.draw_text(&said, &style, (left as i32, top as i32))?;
        let end = if self.without_end { at(12) } else { 0 };
        let (left, right) = (left as i32, right as i32 - end);
        let (top, bottom) = (top as i32 + frame.label as i32 + at(8), top as i32 + frame.label as i32 + at(22));
        let place = |share: f64| left + (f64::from(right - left) * share).round() as i32;
        for k in 0..SHADES {
            let [low, high] = [k, k + 1].map(|k| place(f64::from(k) / f64::from(SHADES)));
            area.draw(&Rectangle::new([(low, top), (high, bottom)], colour(k).filled()))?;
        }
        area.draw(&Rectangle::new([(left, top), (right, bottom)], BLACK.stroke_width(px(1))))?;
        if self.without_end {
            let points = vec![(right, top), (right + end, (top + bottom) / 2), (right, bottom)];
            area.draw(&Polygon::new(points.clone(), colour(SHADES - 1).filled()))?;
            area.draw(&PathElement::new(points, BLACK.stroke_width(px(1))))?;
        }
        let mut free = i32::MIN;
        let last = ticks.len() - 1;
        let start_of = |share: f64, text: &str| place(share) - width_of(text, frame.label) as i32 / 2;
        let last_start = start_of(ticks[last].0, &ticks[last].1);
        for (k, (share, text)) in ticks.iter().enumerate() {
            let x = start_of(*share, text);
            let ends = x + width_of(text, frame.label) as i32;
            if x < free || (k < last && ends + at(6) > last_start) {
                continue;
            }
            area.draw(&PathElement::new(
                vec![(place(*share), bottom), (place(*share), bottom + at(4))],
                BLACK.stroke_width(px(1)),
            ))?;
            area.draw_text(text, &style, (x, bottom + at(6)))?;
            free = ends + at(6);
        }
        Ok(())
    }
}
