//! Sizes of a picture: by where it is shown, and by how many lines its title takes.

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{GRID, at, is_text, px};
use super::{FONT, Fault};

/// Where a picture is shown.
// Pages are for scenes.
#[cfg_attr(not(feature = "scene"), allow(dead_code))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Medium {
    /// A file of its own.
    Sheet,
    /// A column of a page on a screen or on paper.
    Page,
    /// A page as wide as a phone.
    Phone,
}

/// Margins and sizes of text of a picture, in points.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub medium: Medium,
    /// The title, cut into lines that fit.
    lines: Vec<String>,
    /// Height of a line of the title.
    leading: u32,
    /// Size of the title.
    size: u32,
    /// Room for the title.
    pub top: u32,
    /// Room for the labels below and on the left, and beside.
    pub bottom: u32,
    pub left: u32,
    pub right: u32,
    /// Free space at the left edge, so that the description of the axis is not cut.
    pub edge: u32,
    /// Size of labels.
    pub label: u32,
    /// Height of a line of a legend.
    pub legend: u32,
}

/// Most lines of a title; what does not fit ends in an ellipsis.
const MOST_LINES: usize = 3;

impl Medium {
    /// Width of a diagram.
    pub fn width(self) -> u32 {
        match self {
            Self::Sheet => px(720),
            Self::Page => px(540),
            Self::Phone => px(352),
        }
    }

    /// A height of a diagram, given for a sheet.
    pub fn height(self, on_sheet: u32) -> u32 {
        match self {
            Self::Sheet => on_sheet,
            Self::Page => on_sheet * 3 / 4,
            Self::Phone => on_sheet * 3 / 5,
        }
    }
}

impl Frame {
    /// For a picture of this width. A page says in a caption what a title would.
    pub fn new(medium: Medium, title: &str, width: u32) -> Self {
        let size = px(20);
        let leading = px(26);
        let lines =
            if medium == Medium::Sheet { wrapped(title, size, width.saturating_sub(px(24))) } else { Vec::new() };
        let above = px(22) + leading * (lines.len().max(1) as u32);
        match medium {
            Medium::Sheet => Self {
                medium,
                lines,
                leading,
                size,
                top: above,
                bottom: px(54),
                left: px(86),
                right: px(24),
                edge: px(12),
                label: px(16),
                legend: px(22),
            },
            Medium::Page => Self {
                medium,
                lines,
                leading,
                size,
                top: px(12),
                bottom: px(48),
                left: px(70),
                right: px(18),
                edge: px(8),
                label: px(15),
                legend: px(20),
            },
            Medium::Phone => Self {
                medium,
                lines,
                leading,
                size,
                top: px(10),
                bottom: px(46),
                left: px(60),
                right: px(16),
                edge: px(4),
                label: px(16),
                legend: px(21),
            },
        }
    }

    /// The title in the middle of the top, line below line.
    pub fn title<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>> {
        let (width, _) = area.dim_in_pixel();
        let style = (FONT, self.size).into_font().into_text_style(area);
        for (k, line) in self.lines.iter().enumerate() {
            let taken = area.estimate_text_size(line, &style)?.0;
            let y = px(12) + self.leading * k as u32;
            area.draw_text(line, &style, ((width.saturating_sub(taken) / 2) as i32, y as i32))?;
        }
        Ok(())
    }

    /// The mesh of a chart, with the sizes of this frame.
    pub fn styled<'m, 'a, 'b, X, Y, DB>(
        &self,
        mesh: &'m mut MeshStyle<'a, 'b, X, Y, DB>,
    ) -> &'m mut MeshStyle<'a, 'b, X, Y, DB>
    where
        X: Ranged,
        Y: Ranged,
        DB: DrawingBackend + 'b,
    {
        mesh.label_style((FONT, self.label))
            .axis_desc_style((FONT, self.label))
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID.stroke_width(px(1)))
            .axis_style(BLACK.stroke_width(px(1)))
            .set_all_tick_mark_size(px(5))
    }

    /// How far above its middle a label begins.
    pub fn half(&self) -> i32 {
        self.label as i32 * 3 / 8
    }
}

/// Width of a text, points; without a font a letter is about half as wide as it is high.
pub(super) fn width_of(text: &str, size: u32) -> u32 {
    (FONT, size).into_font().box_size(text).map_or(text.chars().count() as u32 * size / 2, |(w, _)| w)
}

/// Text in lines of at most `width`; words that are longer are cut.
pub(super) fn wrapped(text: &str, size: u32, width: u32) -> Vec<String> {
    super::load_font();
    let text: String = text.chars().filter(|&c| is_text(c)).collect();
    let fits = |line: &str| width_of(line, size) <= width;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let joined = lines.last().map(|line| format!("{line} {word}"));
        match (lines.last_mut(), joined) {
            (Some(line), Some(joined)) if fits(&joined) => *line = joined,
            _ => lines.push(shortened(word, &fits)),
        }
    }
    if lines.len() > MOST_LINES {
        lines.truncate(MOST_LINES);
        if let Some(last) = lines.last_mut() {
            *last = shortened(&format!("{last} …"), &fits);
        }
    }
    lines
}

/// The text, or as much of its beginning as fits before an ellipsis.
fn shortened(text: &str, fits: &dyn Fn(&str) -> bool) -> String {
    // A title is not a document: what is cut here is far beyond any width.
    let mut letters: Vec<char> = text.chars().take(400).collect();
    if fits(&letters.iter().collect::<String>()) && letters.len() == text.chars().count() {
        return text.to_owned();
    }
    while !letters.is_empty() {
        letters.pop();
        let cut: String = letters.iter().chain(&['…']).collect();
        if fits(&cut) {
            return cut;
        }
    }
    String::new()
}

/// A short stroke of a legend with its name; returns where the next one may begin.
pub(super) fn named_stroke<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    frame: &Frame,
    [x, y]: [i32; 2],
    name: &str,
    stroke: impl FnOnce(&DrawingArea<DB, Shift>, i32, i32) -> Result<(), Fault<DB>>,
) -> Result<i32, Fault<DB>> {
    stroke(area, x, x + at(30))?;
    let style = (FONT, frame.label).into_font().into_text_style(area);
    area.draw_text(name, &style, (x + at(38), y - frame.half()))?;
    Ok(x + at(38) + width_of(name, frame.label) as i32 + at(22))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_wrap_within_their_width() {
        let title =
            "cylinders of radii 20 mm and 50 mm with axes at right angles, once more and longer than ever before";
        let lines = wrapped(title, px(20), px(300));
        assert!(lines.len() == MOST_LINES && lines.iter().all(|line| width_of(line, px(20)) <= px(300)), "{lines:?}");
        assert!(lines[2].ends_with('…') && title.starts_with(&lines[0]));
        assert_eq!(wrapped("short", px(20), px(300)), ["short"]);
        assert!(wrapped(&"x".repeat(5000), px(20), px(300))[0].ends_with('…'));
        assert!(wrapped(" \u{7} ", px(20), px(300)).is_empty());
    }
}
