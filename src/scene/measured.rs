//! Gaps from measurements: height maps and profiles, with what is done to them before they become a gap.

use serde::Deserialize;

use super::given::Sources;
use crate::error::InputError;
use crate::files::named::Directory;
use crate::gap::{
    Along, AnyGap, HeightMap, Heights, Interpolation, Line, LineFormat, MapFormat, Profile, SplineMap, Surface, Zero,
};

/// A measured surface.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct HeightMapForm {
    /// Text grid, XYZ, .npy, .x3p or .sdf; relative to the scene file.
    file: String,
    /// The map of the other body, facing this one.
    against: Option<String>,
    /// Distances of the nodes along x and y; XYZ, .x3p and .sdf files carry their own.
    spacing: Option<[f64; 2]>,
    /// text, xyz, npy, x3p or sdf; by the ending of the file name when left out.
    format: Option<FormatForm>,
    /// Whose surface was measured: the upper body's (the gap rises with the height) or the lower body's (it falls).
    surface: SurfaceForm,
    /// Depth 0 is where the surfaces first touch (first_touch) or where heights are zero (as_is).
    #[serde(default)]
    zero: ZeroForm,
    /// "plane" takes the least-squares plane out of each map first.
    #[serde(default)]
    level: LevelForm,
    /// What lies between the nodes.
    #[serde(default)]
    interpolation: InterpolationForm,
    /// Standard deviation of the noise that may be taken out, in units of length.
    smooth: Option<f64>,
    /// Unit of the lengths in the file: they become metres, or what scene_unit says. An .x3p's or .sdf's are metres, others stay as
    /// they are.
    unit: Option<UnitForm>,
    /// Unit of length of the scene, where a file's lengths have a unit: metres when left out.
    scene_unit: Option<UnitForm>,
    /// Unit of the heights in units of length.
    scale: Option<f64>,
    /// Where the first node lies; the middle of the map is at (0, 0) when left out.
    origin: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum FormatForm {
    Text,
    Xyz,
    Npy,
    X3p,
    Sdf,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum SurfaceForm {
    #[default]
    Upper,
    Lower,
}

impl From<SurfaceForm> for Surface {
    fn from(form: SurfaceForm) -> Self {
        match form {
            SurfaceForm::Upper => Self::Upper,
            SurfaceForm::Lower => Self::Lower,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum ZeroForm {
    #[default]
    FirstTouch,
    AsIs,
}

impl From<ZeroForm> for Zero {
    fn from(form: ZeroForm) -> Self {
        match form {
            ZeroForm::FirstTouch => Self::FirstTouch,
            ZeroForm::AsIs => Self::AsIs,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum LevelForm {
    #[default]
    None,
    Plane,
}

impl HeightMapForm {
    pub fn build(&self, from: &Sources) -> Result<AnyGap, InputError> {
        let format = self.format.map(|f| match f {
            FormatForm::Text => MapFormat::Text,
            FormatForm::Xyz => MapFormat::Xyz,
            FormatForm::Npy => MapFormat::Npy,
            FormatForm::X3p => MapFormat::X3p,
            FormatForm::Sdf => MapFormat::Sdf,
        });
        let read = |key: &str, name: &str| -> Result<Heights, InputError> {
            let given = from.heights(name, self.spacing);
            let heights = given.unwrap_or_else(|| {
                from.files.place(name).and_then(|place| Heights::read(&place, format, self.spacing))
            });
            let mut heights = heights.map_err(|e| renamed(e, key))?;
            let format = format.unwrap_or_else(|| MapFormat::of(std::path::Path::new(name)));
            let own = matches!(format, MapFormat::X3p | MapFormat::Sdf).then_some(UnitForm::M);
            let factor = factor(self.unit.or(own), self.scene_unit);
            if factor != 1.0 {
                heights = heights.scaled(factor)?;
                if format.has_places() {
                    heights = heights.stretched(factor)?;
                }
            }
            if let Some(factor) = self.scale {
                heights = heights.scaled(factor)?;
            }
            if let Some(origin) = self.origin {
                heights = heights.at(origin)?;
            }
            let heights = if self.level == LevelForm::Plane { heights.levelled() } else { heights };
            match self.smooth {
                None => Ok(heights),
                Some(deviation) => heights.smoothed(deviation),
            }
        };
        let heights = read("file", &self.file)?;
        let zero = self.zero.into();
        let other = self.against.as_ref().map(|other| read("against", other)).transpose()?;
        let (upper, lower) = match (&other, self.surface) {
            (None, _) => (&heights, None),
            (Some(other), SurfaceForm::Upper) => (&heights, Some(other)),
            (Some(other), SurfaceForm::Lower) => (other, Some(&heights)),
        };
        match (self.interpolation, lower) {
            (InterpolationForm::Cubic, None) => SplineMap::new(upper, self.surface.into(), zero).map(AnyGap::new),
            (InterpolationForm::Cubic, Some(lower)) => SplineMap::pair(upper, lower, zero).map(AnyGap::new),
            (InterpolationForm::Linear, None) => HeightMap::new(upper, self.surface.into(), zero).map(AnyGap::new),
            (InterpolationForm::Linear, Some(lower)) => HeightMap::pair(upper, lower, zero).map(AnyGap::new),
        }
    }
}

/// An error about a file stands at the key that names the file.
fn renamed(mut error: InputError, key: &str) -> InputError {
    if key != "file" && (error.path == "file" || error.path.starts_with("file.") || error.path.starts_with("file[")) {
        error.path.replace_range(.."file".len(), key);
    }
    error
}

/// A measured line y, z across a body, extruded along an axis or rolled along it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ProfileForm {
    /// Points [y, z] in order along the line; heights z count upwards.
    points: Option<Vec<[f64; 2]>>,
    /// Two columns y, z, or a MiniProf's .ban or .whl; relative to the scene file.
    file: Option<String>,
    /// columns or miniprof; by the ending of the file name when left out.
    format: Option<LineFormatForm>,
    /// The axis along which the body is straight, or rolled.
    along: AlongForm,
    /// Rolling radius, greater than 0: the body is curved along the axis. Straight when left out.
    radius: Option<f64>,
    /// Whose profile was measured: the upper body's (the gap rises with the height) or the lower body's (it falls).
    #[serde(default)]
    surface: SurfaceForm,
    /// Depth 0 is where the profile first touches a plane (first_touch) or where heights are zero (as_is).
    #[serde(default)]
    zero: ZeroForm,
    /// What lies between the points.
    #[serde(default)]
    interpolation: InterpolationForm,
    /// Standard deviation of the noise that may be taken out, in units of length.
    smooth: Option<f64>,
    /// Unit of the lengths in the file: they become metres, or what scene_unit says. A MiniProf's are millimetres, others stay as they
    /// are.
    unit: Option<UnitForm>,
    /// Unit of length of the scene, where the lengths have a unit: metres when left out.
    scene_unit: Option<UnitForm>,
    /// The profile's image in the line y = 0, in z = 0, or in both.
    mirror: Option<MirrorForm>,
    /// Degrees by which the profile is turned in its own plane about its origin, from y to z: the inclination of a rail.
    turn: Option<f64>,
    /// [dy, dz] by which it is moved then.
    shift: Option<[f64; 2]>,
    /// [y0, y1]: the part of the line that is kept after all this; the whole when left out.
    between: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum LineFormatForm {
    Columns,
    Miniprof,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum AlongForm {
    X,
    Y,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum InterpolationForm {
    /// A cubic spline: what a smooth body is met by.
    #[default]
    Cubic,
    /// Straight from value to value: the facets are the surface.
    Linear,
}

impl From<InterpolationForm> for Interpolation {
    fn from(form: InterpolationForm) -> Self {
        match form {
            InterpolationForm::Cubic => Self::Cubic,
            InterpolationForm::Linear => Self::Linear,
        }
    }
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum UnitForm {
    M,
    Mm,
    Um,
    Nm,
    In,
}

/// What lengths of a file are multiplied by: 1 where its unit is not known.
fn factor(file: Option<UnitForm>, scene: Option<UnitForm>) -> f64 {
    file.map_or(1.0, |file| file.metres() / scene.map_or(1.0, UnitForm::metres))
}

impl UnitForm {
    /// In metres.
    fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Mm => 1e-3,
            Self::Um => 1e-6,
            Self::Nm => 1e-9,
            Self::In => 0.0254,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) enum MirrorForm {
    Y,
    Z,
    Both,
}

impl ProfileForm {
    fn line(&self, directory: &Directory) -> Result<Line, InputError> {
        let format = self.format.map(|f| match f {
            LineFormatForm::Columns => LineFormat::Columns,
            LineFormatForm::Miniprof => LineFormat::Miniprof,
        });
        let (line, own) = match (&self.points, &self.file) {
            (Some(points), None) => (Line::new(points.clone())?, None),
            (None, Some(name)) => {
                let place = directory.place(name)?;
                let miniprof = format.unwrap_or_else(|| LineFormat::of(&place)) == LineFormat::Miniprof;
                (Line::read(&place, format)?, miniprof.then_some(UnitForm::Mm))
            }
            (Some(_), Some(_)) => {
                return Err(InputError::new("file", "a file beside points", "either points or file"));
            }
            (None, None) => return Err(InputError::new("points", "nothing", "points [y, z], or file in their place")),
        };
        let line = line.scaled(factor(self.unit.or(own), self.scene_unit))?;
        let mirrored = |axis| self.mirror == Some(axis) || self.mirror == Some(MirrorForm::Both);
        let line = line.mirrored(mirrored(MirrorForm::Y), mirrored(MirrorForm::Z));
        let line = line.turned(self.turn.unwrap_or(0.0).to_radians())?.shifted(self.shift.unwrap_or_default())?;
        let line = match self.between {
            None => line,
            Some(part) => line.between(part)?,
        };
        match self.smooth {
            None => Ok(line),
            Some(deviation) => line.smoothed(deviation, self.surface.into()),
        }
    }

    pub fn build(&self, directory: &Directory) -> Result<Profile, InputError> {
        let along = match self.along {
            AlongForm::X => Along::X,
            AlongForm::Y => Along::Y,
        };
        let named = |e: InputError| {
            let from_file = self.file.is_some() && (e.path == "points" || e.path.starts_with("points["));
            if from_file { InputError { path: "file".into(), ..e } } else { e }
        };
        let line = self.line(directory).map_err(named)?;
        let profile = Profile::new(&line, along, self.surface.into(), self.zero.into(), self.interpolation.into());
        let profile = profile.map_err(named)?;
        match self.radius {
            None => Ok(profile),
            Some(radius) => profile.rolling(radius),
        }
    }
}
