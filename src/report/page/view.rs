//! The picture of the first screen: a map for everyone, and for browsers with scripts the numbers behind it.

use serde_json::json;

use super::html::{Html, both, html};
use crate::plot::{self, Format, Medium, Placed, base64, coarsened};
use crate::solution::Solution;
use crate::units::UnitLabels;

/// Cells along the longer side of the field that a page carries: what a pointer can tell apart.
const CELLS: usize = 128;

/// The largest value of a whole number of 16 bits; it stands for what is infinite or not known.
const FULL: f64 = 65535.0;

/// The map of the pressure and what a script shows of it; `None` without a field.
pub(super) fn view(solution: &Solution, units: &UnitLabels) -> Option<Html> {
    let drawn = |medium| plot::pressure_map_on(medium, units, "", solution, Format::Svg);
    let ((page, on_page), (phone, on_phone)) = (drawn(Medium::Page).ok()?, drawn(Medium::Phone).ok()?);
    let field = coarsened(solution.pressure.field.as_ref()?, CELLS);
    let most = field.values.iter().copied().fold(0.0, f64::max);
    if !(most > 0.0) {
        return None;
    }
    // Only cells under pressure and their neighbours.
    let [nx, ny] = field.grid.shape;
    let loaded = |k: &usize| field.values[*k] > 0.0;
    let range = |of: &dyn Fn(usize) -> usize, n: usize| {
        let places = || (0..field.values.len()).filter(loaded).map(of);
        let (low, high) = (places().min().unwrap_or(0), places().max().unwrap_or(0));
        (low.saturating_sub(2), (high + 3).min(n))
    };
    let (i0, i1) = range(&|k| k % nx, nx);
    let (j0, j1) = range(&|k| k / nx, ny);
    let cells = || (j0..j1).flat_map(move |j| (i0..i1).map(move |i| (i, j)));
    let text = |values: &mut dyn Iterator<Item = Option<f64>>| {
        let whole = |x: Option<f64>| x.map_or(u16::MAX, |x| (x * (FULL - 1.0)).round() as u16);
        base64(&values.flat_map(|x| whole(x).to_le_bytes()).collect::<Vec<u8>>())
    };
    let pressure = text(&mut cells().map(|(i, j)| Some((field.values[j * nx + i] / most).clamp(0.0, 1.0))));
    // The gap in the cell of its own grid that holds the centre.
    let left = |point: [f64; 2]| {
        let (grid, values) = solution.pressure.gap.as_ref()?;
        let place: [f64; 2] = std::array::from_fn(|m| ((point[m] - grid.origin[m]) / grid.spacing[m]).floor());
        let inside = (0..2).all(|m| place[m] >= 0.0 && place[m] < grid.shape[m] as f64);
        let value = inside.then(|| values[place[1] as usize * grid.shape[0] + place[0] as usize])?;
        value.is_finite().then_some(value.max(0.0))
    };
    let gaps: Vec<Option<f64>> = cells().map(|(i, j)| left(field.grid.centre(i, j))).collect();
    let widest = gaps.iter().flatten().copied().fold(0.0, f64::max);
    let gap = (widest > 0.0).then(|| text(&mut gaps.iter().map(|g| g.map(|g| g / widest))));
    let [h, v] = field.grid.spacing;
    let data = json!({
        "origin": [field.grid.origin[0] + i0 as f64 * h, field.grid.origin[1] + j0 as f64 * v],
        "spacing": [h, v],
        "shape": [i1 - i0, j1 - j0],
        "most": most,
        "scale": plot::highest(solution),
        "pressure": pressure,
        "widest": widest,
        "gap": gap,
        "units": {"length": units.length(), "pressure": units.pressure()},
        "placed": {"page": place(&on_page), "phone": place(&on_phone)},
    });
    // "</" would end the script.
    let data = data.to_string().replace('<', "\\u003c");
    let caption = "Pressure over the patch.";
    let maps = both([&page, &phone], caption);
    Some(html!(
        "<figure class=\"main\" id=\"view\">\n\
         <div class=\"tabs\" role=\"group\" aria-label=\"view\" hidden>\
         <button type=\"button\" data-view=\"map\" aria-pressed=\"true\">map</button>\
         <button type=\"button\" data-view=\"surface\" aria-pressed=\"false\">surface</button>\
         <button type=\"button\" data-view=\"section\" aria-pressed=\"false\">section</button></div>\n\
         <div class=\"map\">{}</div>\n<canvas hidden tabindex=\"0\" aria-label=\"Pressure as a surface; drag or use the arrow keys to turn it\"></canvas>\n\
         <div class=\"cut\" hidden></div>\n<p class=\"said\" aria-live=\"polite\"></p>\n<figcaption>{}</figcaption>\n</figure>\n\
         <script type=\"application/json\" id=\"data\">{}</script>\n",
        maps,
        caption_of(solution),
        Html::markup(data)
    ))
}

/// What is seen, and on which grid.
fn caption_of(solution: &Solution) -> String {
    let grid = solution.pressure.field.as_ref().map_or(String::new(), |field| {
        let [nx, ny] = field.grid.shape;
        format!(" from {nx} x {ny} cells")
    });
    let cut = if solution.pressure.singular.is_some() { "; where it is infinite the scale is cut" } else { "" };
    format!("Pressure over the patch{grid}{cut}.")
}

fn place(placed: &Placed) -> serde_json::Value {
    json!({"area": placed.area, "min": placed.extent.min, "max": placed.extent.max})
}
