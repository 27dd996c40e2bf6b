//! Pictures, as SVG or PNG with the same look: maps of the pressure and of the gap that is left, the pressure as a surface, patch
//! boundaries, section through gap and displacement, force against depth, error against run time, width of a bracket against cells.
//!
//! Colours are those of Okabe & Ito (2008) for lines and viridis, light to dark, for fields: both can be told apart by the
//! colour-blind and in a grey print. Units are the user's own: axes carry the labels given to the functions that end in
//! `_in` with a prefix of the SI where they have one, or else name the kind of unit and the power of ten taken out.

mod axes;
mod curve;
mod error_time;
mod frame;
mod outlines;
mod pressure;
mod raster;
mod scale;
mod section;
mod surface;
mod width;
mod window;

#[cfg(feature = "scene")]
pub(crate) use axes::is_text;
pub use curve::{curve, curve_in, force_depth, force_depth_in, states, states_in};
#[cfg(feature = "scene")]
pub(crate) use curve::{curve_on, states_on};
pub use error_time::error_against_time;
#[cfg(feature = "scene")]
pub(crate) use error_time::error_against_time_on;
#[cfg(feature = "scene")]
pub(crate) use frame::Medium;
#[cfg(feature = "scene")]
pub(crate) use outlines::outlines_on;
pub use outlines::{Outline, outlines, outlines_in};
#[cfg(feature = "scene")]
pub(crate) use pressure::{Placed, coarsened, highest, pressure_map_on};
pub use pressure::{error_map_in, field_map, field_map_in, gap_map, gap_map_in, pressure_map, pressure_map_in};
#[cfg(feature = "scene")]
pub(crate) use raster::base64;
#[cfg(feature = "scene")]
pub(crate) use section::section_on;
pub use section::{Section, section, section_in};
pub use surface::{surface, surface_in};
#[cfg(feature = "scene")]
pub(crate) use width::width_against_cells_on;
pub use width::{Refinement, width_against_cells};

use std::path::Path;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

use crate::error::InputError;
use raster::Raster;

/// File formats of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Scalable; text stays text.
    Svg,
    /// Pixels.
    Png,
}

impl Format {
    /// By the ending of the file name.
    ///
    /// # Errors
    /// When it is neither `.svg` nor `.png`.
    pub fn of(file: &Path) -> Result<Self, InputError> {
        let ending = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            _ => Err(InputError::new("", file.display(), "an ending of .svg or .png")),
        }
    }
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// There is nothing that could be drawn.
    #[error("nothing to draw: {0}")]
    Empty(&'static str),
    /// The drawing library failed.
    #[error("cannot draw: {0}")]
    Drawing(String),
}

/// What went wrong on a backend.
type Fault<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;

/// A picture that can be drawn on any backend.
trait Figure {
    /// Width and height, in points of [`axes::FINE`] to a pixel.
    fn size(&self) -> (u32, u32);

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), Fault<DB>>;

    /// An image and where it stands, [left, top, right, bottom]; a file of pixels has its dots drawn by `draw`, an SVG takes it whole
    /// in place of a rectangle in the colour [`PLACE`].
    fn image(&self) -> Option<([i32; 4], &Raster)> {
        None
    }
}

/// What stands for an image until it is put there: no picture has this colour otherwise.
const PLACE: RGBColor = RGBColor(1, 2, 3);

/// The name under which the font that comes with the crate is known; viewers of SVG take their own sans-serif.
const FONT: &str = "sans-serif";

/// Measures text the same on every system, whatever fonts it has.
fn load_font() {
    static LOADED: Once = Once::new();
    LOADED.call_once(|| {
        // Without it drawing fails and says that there is no font.
        let _ = register_font(FONT, FontStyle::Normal, include_bytes!("../../data/fonts/plot_sans.ttf"));
    });
}

/// The picture at its size on the screen; cells of a field meet without a seam.
fn on_screen(svg: &str, width: u32, height: u32) -> String {
    let size = |w: u32, h: u32| format!("width=\"{w}\" height=\"{h}\"");
    let (drawn, shown) = (size(width, height), size(width / axes::FINE, height / axes::FINE));
    svg.replacen(&drawn, &shown, 1).replace("<rect ", "<rect shape-rendering=\"crispEdges\" ")
}

/// The picture with an image in its place.
fn with_image(mut svg: String, [left, top, right, bottom]: [i32; 4], png: &[u8]) -> String {
    let mark = format!("fill=\"#{:02X}{:02X}{:02X}\"", PLACE.0, PLACE.1, PLACE.2);
    let Some(at) = svg.find(&mark) else { return svg };
    let (Some(from), Some(to)) = (svg[..at].rfind("<rect "), svg[at..].find("/>")) else { return svg };
    let (width, height) = (right - left, bottom - top);
    let image = format!(
        "<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{}\"/>",
        raster::base64(png)
    );
    svg.replace_range(from..at + to + 2, &image);
    svg
}

/// The bytes of a file with this picture.
fn render(figure: &impl Figure, format: Format) -> Result<Vec<u8>, Error> {
    load_font();
    let failed = |e: &dyn std::fmt::Display| Error::Drawing(e.to_string());
    let (width, height) = figure.size();
    match format {
        Format::Svg => {
            let mut text = String::new();
            {
                let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
                area.fill(&WHITE).map_err(|e| failed(&e))?;
                figure.draw(&area).map_err(|e| failed(&e))?;
                area.present().map_err(|e| failed(&e))?;
            }
            let text = match figure.image() {
                Some((place, image)) => with_image(text, place, &image.png().map_err(|e| failed(&e))?),
                None => text,
            };
            Ok(on_screen(&text, width, height).into_bytes())
        }
        Format::Png => {
            let mut pixels = vec![0; 3 * width as usize * height as usize];
            {
                let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
                area.fill(&WHITE).map_err(|e| failed(&e))?;
                figure.draw(&area).map_err(|e| failed(&e))?;
                area.present().map_err(|e| failed(&e))?;
            }
            let mut file = Vec::new();
            let mut encoder = png::Encoder::new(&mut file, width, height);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            let mut writer = encoder.write_header().map_err(|e| failed(&e))?;
            writer.write_image_data(&pixels).map_err(|e| failed(&e))?;
            writer.finish().map_err(|e| failed(&e))?;
            Ok(file)
        }
    }
}

/// Okabe & Ito's colours, dark ones first: black, blue, vermilion, green, purple, orange.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];

/// Viridis (Smith & van der Walt 2015) at ninths, dark to light.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];

/// Light for 0, dark for 1: on paper more ink is more pressure.
fn shade(share: f64) -> RGBColor {
    let at = (1.0 - share.clamp(0.0, 1.0)) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    let mix = |m: usize| (VIRIDIS[k][m] + (at - k as f64) * (VIRIDIS[k + 1][m] - VIRIDIS[k][m])).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}

/// Steps of the scale of colours.
const SHADES: u32 = 48;

/// The colour of a step.
fn colour(step: u32) -> RGBColor {
    shade((f64::from(step) + 0.5) / f64::from(SHADES))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_pressure_is_darker() {
        // Luminance of sRGB values, close enough for an order.
        let ink = |share: f64| {
            let RGBColor(r, g, b) = shade(share);
            0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
        };
        assert!((0..100).all(|k| ink(f64::from(k) / 100.0) > ink(f64::from(k + 1) / 100.0)));
    }

    #[test]
    fn format_by_ending() {
        assert_eq!(Format::of(Path::new("a.SVG")).unwrap(), Format::Svg);
        assert_eq!(Format::of(Path::new("b.c.png")).unwrap(), Format::Png);
        assert!(Format::of(Path::new("svg")).unwrap_err().given.contains("svg"));
    }
}
