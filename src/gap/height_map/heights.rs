//! Heights on a regular grid, and what is done to them before they become a gap.

use std::path::Path;

#[cfg(feature = "scene")]
use super::x3p;
use super::{Read, npy, sdf, text};
use crate::error::{InputError, finite, positive};

/// Largest array and largest text that is read, in bytes; a text of two bytes a height takes four times its size.
const LARGEST_ARRAY: u64 = 1 << 30;
const LARGEST_TEXT: u64 = 1 << 28;

/// Kinds of files that hold heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapFormat {
    /// Rows of numbers; `#` starts a comment.
    Text,
    /// Lines of x, y, z in any order, on a regular grid.
    Xyz,
    /// NumPy's array file, two-dimensional.
    Npy,
    /// ISO 25178-72, a zip archive; read with the feature `scene`.
    X3p,
    /// ISO 25178-71 in ASCII.
    Sdf,
}

impl MapFormat {
    /// Whether such files carry the places of their nodes, and not heights alone.
    #[must_use]
    pub fn has_places(self) -> bool {
        matches!(self, Self::Xyz | Self::X3p | Self::Sdf)
    }

    /// By the file's extension: `.npy`, `.xyz`, `.x3p`, `.sdf`, anything else is text.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("npy") => Self::Npy,
            Some("xyz") => Self::Xyz,
            Some("x3p") => Self::X3p,
            Some("sdf") => Self::Sdf,
            _ => Self::Text,
        }
    }
}

/// Heights z at the nodes of a regular grid; NaN where nothing was measured.
///
/// Columns run along x. The first row has the least y; [`Heights::top_row_first`] is for files written like pictures.
/// The middle of the map is the origin, unless the file has its own coordinates (XYZ) or [`Heights::at`] is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    shape: [usize; 2],
    spacing: [f64; 2],
    origin: [f64; 2],
    values: Vec<f64>,
    /// How far each may be from the true one, where noise was taken out.
    uncertainty: Option<Vec<f64>>,
}

/// The largest height: squares of larger ones are beyond the range of numbers.
const HIGHEST: f64 = 1e150;

impl Heights {
    /// Heights by rows, `shape` = number along x and along y, `spacing` = steps along x and y.
    ///
    /// # Errors
    /// Names `shape` when it has less than two nodes a side or does not fit the number of values, `spacing` when it is
    /// not positive, `values[k]` when it is infinite or larger than 1e150.
    pub fn new(values: Vec<f64>, shape: [usize; 2], spacing: [f64; 2]) -> Result<Self, InputError> {
        positive("spacing[0]", spacing[0])?;
        positive("spacing[1]", spacing[1])?;
        let given = format!("{} x {}", shape[0], shape[1]);
        if shape[0] < 2 || shape[1] < 2 {
            return Err(InputError::new("shape", given, "at least two nodes along x and along y"));
        }
        if shape[0].checked_mul(shape[1]) != Some(values.len()) {
            return Err(InputError::new("shape", given, format!("a shape that holds the {} values", values.len())));
        }
        if let Some(k) = values.iter().position(|v| v.abs() > HIGHEST) {
            let allowed = format!("a height of at most {HIGHEST:e} in size, or NaN for a hole");
            return Err(InputError::new(format!("values[{k}]"), values[k], allowed));
        }
        let origin = [0, 1].map(|m| -0.5 * (shape[m] - 1) as f64 * spacing[m]);
        finite("spacing[0]", origin[0])?;
        finite("spacing[1]", origin[1])?;
        Ok(Self { shape, spacing, origin, values, uncertainty: None })
    }

    /// Rows of numbers separated by blanks, commas or semicolons; `#` starts a comment; `nan`, `na`, `-` or nothing
    /// between two separators is a hole.
    ///
    /// # Errors
    /// Names `file` with the line and what is wrong there, or `spacing`.
    pub fn from_text(text: &str, spacing: [f64; 2]) -> Result<Self, InputError> {
        let (values, shape) = text::rows(text)?;
        Self::new(values, shape, spacing)
    }

    /// Lines of x, y, z in any order, separated as in [`Heights::from_text`]; x and y lie on a regular grid to one
    /// hundredth of a step; nodes that do not occur are holes. The coordinates are kept.
    ///
    /// # Errors
    /// Names `file` with the line and what is wrong there.
    pub fn from_xyz(text: &str) -> Result<Self, InputError> {
        let text::Scattered { values, shape, spacing, origin } = text::scattered(text)?;
        Self::new(values, shape, spacing)?.at(origin)
    }

    /// NumPy's array file (versions 1 to 3) with a two-dimensional array of floats or integers, rows along y.
    ///
    /// # Errors
    /// Names `file` and what is wrong with its header, its length or its numbers, or `spacing`.
    pub fn from_npy(bytes: &[u8], spacing: [f64; 2]) -> Result<Self, InputError> {
        let (values, shape) = npy::read(bytes)?;
        Self::new(values, shape, spacing)
    }

    /// An X3P file (ISO 25178-72) with a surface on a regular grid. Metres.
    ///
    /// # Errors
    /// Names `file` and what is wrong with the archive, its description or its heights.
    #[cfg(feature = "scene")]
    pub fn from_x3p(bytes: &[u8]) -> Result<Self, InputError> {
        x3p::read(bytes).and_then(Self::measured)
    }

    /// A surface data file in ASCII (ISO 25178-71). Metres.
    ///
    /// # Errors
    /// Names `file` and what is wrong with its header or its heights.
    pub fn from_sdf(text: &str) -> Result<Self, InputError> {
        sdf::read(text).and_then(Self::measured)
    }

    fn measured(Read { values, shape, spacing }: Read) -> Result<Self, InputError> {
        Self::new(values, shape, spacing).map_err(|e| InputError { path: "file".into(), ..e })
    }

    /// A file; `format` by its extension when not said. `spacing` is needed where the file has no places; else it is checked.
    ///
    /// # Errors
    /// Names `file` when it is not a regular file, cannot be read or is larger than 1 GiB (text: 256 MiB), or `spacing`; otherwise as the
    /// readers of the formats. No message repeats what the file holds.
    pub fn read(path: &Path, format: Option<MapFormat>, spacing: Option<[f64; 2]>) -> Result<Self, InputError> {
        let name = path.display();
        let format = format.unwrap_or_else(|| MapFormat::of(path));
        let bytes = crate::files::read(
            path,
            if matches!(format, MapFormat::Npy | MapFormat::X3p) { LARGEST_ARRAY } else { LARGEST_TEXT },
        )?;
        let needed = || {
            let allowed = "the steps [dx, dy] between the heights, which this kind of file does not hold";
            spacing.ok_or_else(|| InputError::new("spacing", "nothing", allowed))
        };
        let inside = |e: InputError| {
            if e.path == "file" { InputError { given: format!("{name}: {}", e.given), ..e } } else { e }
        };
        // A spacing beside that of the file is the same.
        let agreeing = |heights: Self| {
            let agrees = |m: usize| spacing.is_none_or(|s| (s[m] / heights.spacing[m] - 1.0).abs() < 0.01);
            match (0..2).find(|&m| !agrees(m)) {
                None => Ok(heights),
                Some(m) => {
                    let allowed = format!("the spacing of the coordinates in {name}");
                    Err(InputError::new(format!("spacing[{m}]"), spacing.unwrap_or_default()[m], allowed))
                }
            }
        };
        match format {
            MapFormat::Npy => Self::from_npy(&bytes, needed()?).map_err(inside),
            MapFormat::Text => {
                let spacing = needed()?;
                text::decoded(&bytes).and_then(|text| Self::from_text(text, spacing)).map_err(inside)
            }
            MapFormat::Xyz => text::decoded(&bytes).and_then(Self::from_xyz).map_err(inside).and_then(agreeing),
            MapFormat::Sdf => text::decoded(&bytes).and_then(Self::from_sdf).map_err(inside).and_then(agreeing),
            #[cfg(feature = "scene")]
            MapFormat::X3p => Self::from_x3p(&bytes).map_err(inside).and_then(agreeing),
            #[cfg(not(feature = "scene"))]
            MapFormat::X3p => {
                Err(InputError::new("file", name, "another format: this build has no .x3p (feature scene)"))
            }
        }
    }

    /// Number of nodes along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Steps between nodes along x and y.
    #[must_use]
    pub fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Where the first node lies.
    #[must_use]
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Heights, x fastest; NaN in holes.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The same with its first node at `origin`.
    ///
    /// # Errors
    /// Names `origin` when it is not finite.
    pub fn at(mut self, origin: [f64; 2]) -> Result<Self, InputError> {
        finite("origin[0]", origin[0])?;
        finite("origin[1]", origin[1])?;
        self.origin = origin;
        Ok(self)
    }

    /// Heights times `factor`: a file in micrometres is read with 1e-6.
    ///
    /// # Errors
    /// Names `scale` when it is zero or not finite, or a height no longer fits.
    pub fn scaled(mut self, factor: f64) -> Result<Self, InputError> {
        if !factor.is_finite() || factor == 0.0 {
            return Err(InputError::new("scale", factor, "a finite number other than 0"));
        }
        self.uncertainty.iter_mut().flatten().for_each(|uncertainty| *uncertainty *= factor.abs());
        for value in &mut self.values {
            *value *= factor;
            if value.is_infinite() {
                return Err(InputError::new("scale", factor, "a factor that keeps the heights finite"));
            }
        }
        Ok(self)
    }

    /// Without noise of this standard deviation: smoothing splines along rows and columns whose mean square distance from the heights
    /// is that of the noise (Reinsch 1967, as a tensor product).
    ///
    /// # Errors
    /// Names `smooth` when it is not a finite number greater than 0.
    pub fn smoothed(self, deviation: f64) -> Result<Self, InputError> {
        let deviation = positive("smooth", deviation)?;
        let found = crate::gap::spline::smoothed_grid(&self.values, self.shape, self.spacing, deviation);
        Ok(Self { values: found.values, uncertainty: Some(found.uncertainty), ..self })
    }

    /// How far each height may be from the true one, where noise was taken out.
    pub(super) fn uncertainty(&self) -> Option<&[f64]> {
        self.uncertainty.as_deref()
    }

    /// Places times `factor`: spacing and first node in another unit.
    ///
    /// # Errors
    /// Names `unit` when the factor is not a finite number greater than 0, or a place no longer fits.
    pub fn stretched(mut self, factor: f64) -> Result<Self, InputError> {
        positive("unit", factor)?;
        self.spacing = self.spacing.map(|h| h * factor);
        self.origin = self.origin.map(|x| x * factor);
        let fits = self.spacing.iter().all(|h| h.is_normal()) && self.origin.iter().all(|x| x.is_finite());
        if fits { Ok(self) } else { Err(InputError::new("unit", factor, "a factor that keeps the places finite")) }
    }

    /// The rows the other way up: the first row of the file has the largest y, as in a picture.
    #[must_use]
    pub fn top_row_first(mut self) -> Self {
        let nx = self.shape[0];
        let turned = |values: Vec<f64>| values.rchunks(nx).flatten().copied().collect();
        (self.values, self.uncertainty) = (turned(self.values), self.uncertainty.map(turned));
        self
    }

    /// Without the plane that fits the heights best in the mean square: the tilt of an instrument. Not done unless
    /// asked for, because a tilt may be real.
    #[must_use]
    pub fn levelled(mut self) -> Self {
        let [nx, _] = self.shape;
        // Places in steps about the middle of what was measured.
        let seen = || self.values.iter().enumerate().filter(|(_, z)| z.is_finite());
        let count = seen().count() as f64;
        let mean = seen().fold([0.0; 3], |m, (k, z)| {
            [m[0] + (k % nx) as f64 / count, m[1] + (k / nx) as f64 / count, m[2] + z / count]
        });
        let mut moments = [0.0; 5];
        for (k, z) in seen() {
            let (u, v, w) = ((k % nx) as f64 - mean[0], (k / nx) as f64 - mean[1], z - mean[2]);
            for (moment, product) in moments.iter_mut().zip([u * u, u * v, v * v, u * w, v * w]) {
                *moment += product;
            }
        }
        let [uu, uv, vv, uw, vw] = moments;
        let det = uu * vv - uv * uv;
        let spread = det > 1e-12 * uu * vv;
        if !spread {
            // Fewer than three nodes off a line: nothing to level by.
            return self;
        }
        let slope = [(vv * uw - uv * vw) / det, (uu * vw - uv * uw) / det];
        for (k, z) in self.values.iter_mut().enumerate() {
            *z -= mean[2] + slope[0] * ((k % nx) as f64 - mean[0]) + slope[1] * ((k / nx) as f64 - mean[1]);
        }
        self
    }
}
