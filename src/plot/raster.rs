//! A field as an image: every dot within the patch has a colour, and none beside it.

use plotters::prelude::RGBColor;
use png::{BitDepth, ColorType, Encoder};

use super::{SHADES, colour};
use crate::grid::Pressure;
use crate::numeric::geometry::Rect;

/// No colour.
pub(super) const CLEAR: u8 = 255;

/// Steps of the scale of colours on equal dots, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Raster {
    pub width: usize,
    pub height: usize,
    pub steps: Vec<u8>,
}

/// How far from a loaded cell a dot may lie and still take its pressure, in cells.
const NEAR: i64 = 2;

impl Raster {
    /// `field` over `extent` on so many dots, `highest` at the dark end of the scale. Within `boundary` (even-odd) dots beside the
    /// last loaded cell take its value; without a boundary the loaded cells themselves are seen.
    pub fn of(
        field: &Pressure,
        boundary: &[Vec<[f64; 2]>],
        extent: &Rect,
        [width, height]: [usize; 2],
        highest: f64,
    ) -> Self {
        let mut steps = vec![CLEAR; width * height];
        let [w, h] = extent.size();
        for (j, row) in steps.chunks_mut(width.max(1)).enumerate() {
            let y = extent.max[1] - (j as f64 + 0.5) / height as f64 * h;
            let position = |i: usize| extent.min[0] + (i as f64 + 0.5) / width as f64 * w;
            let crossed = crossings(boundary, y);
            let mut next = 0;
            for (i, step) in row.iter_mut().enumerate() {
                let x = position(i);
                while next < crossed.len() && crossed[next] <= x {
                    next += 1;
                }
                let value = if boundary.is_empty() {
                    own(field, [x, y])
                } else if next % 2 == 1 {
                    extended(field, [x, y])
                } else {
                    None
                };
                if let Some(p) = value.filter(|p| *p > 0.0) {
                    *step = step_of(p, highest);
                }
            }
        }
        Self { width, height, steps }
    }

    /// Runs of one colour: row, first dot, one beyond the last, step.
    pub fn runs(&self) -> impl Iterator<Item = (usize, usize, usize, u8)> + '_ {
        (0..self.height).flat_map(move |j| {
            let row = &self.steps[j * self.width..(j + 1) * self.width];
            let mut i = 0;
            std::iter::from_fn(move || {
                let from = i;
                let step = *row.get(from)?;
                while row.get(i) == Some(&step) {
                    i += 1;
                }
                Some((j, from, i, step))
            })
            .filter(|run| run.3 != CLEAR)
        })
    }

    /// A PNG file with transparent dots where there is no colour.
    ///
    /// # Errors
    /// As the encoder.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(png::Compression::Default);
        let mut palette: Vec<u8> = (0..SHADES)
            .flat_map(|k| {
                let RGBColor(r, g, b) = colour(k);
                [r, g, b]
            })
            .collect();
        palette.extend([255, 255, 255]);
        encoder.set_palette(palette);
        let mut opacity = vec![255; SHADES as usize];
        opacity.push(0);
        encoder.set_trns(opacity);
        let mut writer = encoder.write_header()?;
        let clear = SHADES as u8;
        let dots: Vec<u8> = self.steps.iter().map(|&s| if s == CLEAR { clear } else { s }).collect();
        writer.write_image_data(&dots)?;
        writer.finish()?;
        Ok(file)
    }
}

/// The step of the scale for a value greater than zero.
fn step_of(value: f64, highest: f64) -> u8 {
    ((value / highest * f64::from(SHADES)) as u32).min(SHADES - 1) as u8
}

/// Where the level y crosses closed polylines, in order.
fn crossings(boundary: &[Vec<[f64; 2]>], y: f64) -> Vec<f64> {
    let mut crossed: Vec<f64> = Vec::new();
    for points in boundary {
        for (k, &[x1, y1]) in points.iter().enumerate() {
            let [x0, y0] = points[(k + points.len() - 1) % points.len()];
            if (y0 <= y) != (y1 <= y) {
                crossed.push(x0 + (y - y0) / (y1 - y0) * (x1 - x0));
            }
        }
    }
    crossed.sort_by(f64::total_cmp);
    crossed
}

fn value(field: &Pressure, i: i64, j: i64) -> Option<f64> {
    let [nx, ny] = field.grid.shape.map(|n| n as i64);
    let inside = (0..nx).contains(&i) && (0..ny).contains(&j);
    inside.then(|| field.values[(j * nx + i) as usize]).filter(|p| *p > 0.0 && p.is_finite())
}

/// The value of the cell that holds a point.
fn own(field: &Pressure, point: [f64; 2]) -> Option<f64> {
    let grid = &field.grid;
    let [i, j] = [0, 1].map(|m| ((point[m] - grid.origin[m]) / grid.spacing[m]).floor() as i64);
    value(field, i, j)
}

/// Bilinear between the centres of loaded cells; beside the last of them the nearest.
pub(super) fn extended(field: &Pressure, point: [f64; 2]) -> Option<f64> {
    let grid = &field.grid;
    let place = [0, 1].map(|m| (point[m] - grid.origin[m]) / grid.spacing[m] - 0.5);
    let [i, j] = place.map(|p| p.floor() as i64);
    let [s, t] = [place[0] - i as f64, place[1] - j as f64];
    let corners = [((0, 0), (1.0 - s) * (1.0 - t)), ((1, 0), s * (1.0 - t)), ((0, 1), (1.0 - s) * t), ((1, 1), s * t)];
    let (mut sum, mut weight) = (0.0, 0.0);
    for ((a, b), share) in corners {
        if let Some(p) = value(field, i + a, j + b) {
            sum += share * p;
            weight += share;
        }
    }
    if weight > 1e-6 {
        return Some(sum / weight);
    }
    let around = (-NEAR..=NEAR + 1).flat_map(|b| (-NEAR..=NEAR + 1).map(move |a| (i + a, j + b)));
    let distance = |(a, b): (i64, i64)| (a as f64 - place[0]).hypot(b as f64 - place[1]);
    let near = around.filter_map(|cell| Some((distance(cell), value(field, cell.0, cell.1)?)));
    near.min_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, p)| p)
}

/// Bytes as text (RFC 4648).
pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let all = three.iter().enumerate().fold(0u32, |all, (k, &b)| all | u32::from(b) << (16 - 8 * k));
        for k in 0..4 {
            let letter = char::from(LETTERS[(all >> (18 - 6 * k) & 63) as usize]);
            text.push(if k <= three.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;

    #[test]
    fn bytes_as_text() {
        assert_eq!([&b""[..], b"f", b"fo", b"foo", b"foob"].map(base64), ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg=="]);
    }

    #[test]
    fn every_dot_within_the_outline_has_a_colour_and_none_beside_it() {
        let grid = Grid { origin: [-1.2, -1.2], spacing: [0.2, 0.2], shape: [12, 12] };
        let values: Vec<f64> = grid.centres().map(|[x, y]| (1.0 - x * x - y * y).max(0.0).sqrt()).collect();
        let circle: Vec<[f64; 2]> = (0..200)
            .map(|k| {
                let (s, c) = (f64::from(k) * 0.01 * std::f64::consts::PI).sin_cos();
                [c, s]
            })
            .collect();
        let extent = Rect { min: [-1.1, -1.1], max: [1.1, 1.1] };
        let raster = Raster::of(&Pressure { grid, values }, &[circle], &extent, [100, 100], 1.0);
        for j in 0..100 {
            for i in 0..100 {
                let r = (-1.1 + 0.022 * (i as f64 + 0.5)).hypot(1.1 - 0.022 * (j as f64 + 0.5));
                if (r - 1.0).abs() > 2e-3 {
                    assert_eq!(raster.steps[100 * j + i] != CLEAR, r < 1.0, "{i}, {j}");
                }
            }
        }
        // Dark in the middle, and beside the edge as the last cell, sqrt(1 - 0.9^2 - 0.1^2) of the scale; the runs hold every dot with a colour.
        assert!(raster.steps[5050] > 44 && raster.steps[50 * 100 + 6] <= step_of(0.43, 1.0));
        let dots: usize = raster.runs().map(|(_, from, to, _)| to - from).sum();
        assert_eq!(dots, raster.steps.iter().filter(|s| **s != CLEAR).count());
        assert!(raster.png().unwrap().starts_with(b"\x89PNG"));
    }
}
