//! Scene files: a contact problem and how to solve it, as JSON.
//!
//! ```
//! use contact_patch::{Scene, solve};
//! let scene = Scene::from_json(br#"{
//!     "bodies": [{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"],
//!     "gap": {"kind": "cone", "inclination": 45.0},
//!     "loading": {"depth": -1e-6}
//! }"#)?;
//! let solution = solve(&scene.contact, &scene.settings).remove(0)?;
//! assert_eq!(solution.force, 0.0);
//! let wrong = Scene::from_json(br#"{"effective_modulus": 1.0, "gap": {"kind": "cone", "incline": 45.0},
//!     "loading": {"depth": 1e-6}}"#);
//! assert_eq!(wrong.unwrap_err().path, "gap.incline");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bodies;
mod decode;
mod document;
mod fault;
mod gap;
mod given;
mod loading;
mod measured;
mod options;
mod schema;
pub(crate) mod settings;
mod shapes;
mod words;

use std::path::{Path, PathBuf};

use serde::Deserialize;

pub use document::Json;
pub(crate) use document::{key_in_path, quoted};
pub use given::Given;
pub(crate) use options::SolveOptions;
pub use schema::schema;

use crate::error::InputError;
use crate::files;
use crate::files::named::Directory;
use crate::gap::AnyGap;
use crate::problem::{Contact, EffectiveModulus, Load, Loading, Settings};
use crate::units::UnitLabels;
use decode::decode;
pub(crate) use decode::decode_state;
use document::ROOT;
use given::Sources;

/// Longest scene that is read, in bytes; as a document it takes up to twenty times that.
pub(crate) const LONGEST: u64 = 1 << 26;

/// A scene: the problem, how to solve it, and the document both came from.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The name it was given.
    pub name: Option<String>,
    /// The checked problem.
    pub contact: Contact,
    /// Method, resolution, outputs.
    pub settings: Settings,
    /// Labels of the units that its numbers are in.
    pub units: Option<UnitLabels>,
    /// The document as it was written.
    pub document: Json,
    /// The files that it names and that were read.
    pub files: Vec<PathBuf>,
}

/// The keys of a scene. Bodies, gap and loading are read by their own modules.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct SceneForm {
    /// Where the schema of this file is, for editors.
    #[serde(rename = "$schema")]
    _schema: Option<String>,
    /// Any text; comes back with the result.
    name: Option<String>,
    /// One or two bodies; one alone is pressed against a rigid one.
    #[cfg_attr(test, schemars(with = "Option<Vec<bodies::BodyForm>>", length(min = 1, max = 2)))]
    bodies: Option<Any>,
    /// E* > 0 of the pair, in place of `bodies`.
    effective_modulus: Option<f64>,
    #[cfg_attr(test, schemars(with = "gap::GapForm"))]
    #[serde(rename = "gap")]
    _gap: Any,
    #[cfg_attr(test, schemars(with = "loading::LoadingForm"))]
    #[serde(rename = "loading")]
    _loading: Any,
    /// Labels of units for tables, pictures and exports; numbers are not converted.
    units: Option<settings::UnitsForm>,
    /// How to solve.
    solve: Option<settings::SolveForm>,
    /// What else to compute and write.
    output: Option<Vec<settings::OutputName>>,
}

/// A value that is there; its own module reads it.
struct Any;

impl<'de> Deserialize<'de> for Any {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        serde::de::IgnoredAny::deserialize(from).map(|_| Self)
    }
}

impl Scene {
    /// Reads a scene. Files that it names are looked for in the current directory.
    ///
    /// # Errors
    /// Names the path in the document, the value that stands there, and what is allowed: text that is not UTF-8 or
    /// not JSON, unknown, missing and doubled keys, wrong types, values out of range.
    pub fn from_json(text: &[u8]) -> Result<Self, InputError> {
        Self::from_json_in(text, Directory::open(Path::new("")))
    }

    /// Reads a scene from a file. Files that it names are looked for in the same directory.
    ///
    /// # Errors
    /// As [`Scene::from_json`]; also when there is no such file, when it is not a regular file (a pipe, a device), or when it
    /// cannot be read.
    pub fn from_file(file: &Path) -> Result<Self, InputError> {
        let text = files::read(file, LONGEST).map_err(|e| InputError { path: ROOT.to_owned(), ..e })?;
        Self::from_json_in(&text, Directory::open(file.parent().unwrap_or(Path::new(""))))
    }

    /// Reads a scene that somebody else wrote: files that it names are read from inside the directory `root` alone, whatever
    /// `..`, absolute paths and symbolic links say.
    ///
    /// # Errors
    /// As [`Scene::from_json`]; also when a file lies outside of `root`.
    pub fn from_json_within(text: &[u8], root: &Path) -> Result<Self, InputError> {
        Self::from_json_in(text, Directory::closed(root))
    }

    /// Reads a scene of which a program holds a part: heights, gaps.
    ///
    /// # Errors
    /// As [`Scene::from_json`]; also when a given gap is named that there is none of.
    pub fn from_json_with(text: &[u8], given: &Given) -> Result<Self, InputError> {
        Self::from_document(document(text)?, given.place(), Some(given))
    }

    /// Reads a scene; files that it names are looked for in `directory`.
    fn from_json_in(text: &[u8], directory: Directory) -> Result<Self, InputError> {
        Self::from_document(document(text)?, directory, None)
    }

    /// Reads a scene from a document.
    pub(crate) fn from_document(
        document: Json,
        directory: Directory,
        given: Option<&Given>,
    ) -> Result<Self, InputError> {
        if !matches!(document, Json::Object(_)) {
            return Err(InputError::new(ROOT, document.brief(), "an object with gap, loading and bodies"));
        }
        let form: SceneForm = decode(&document, ROOT)?;
        let modulus = form.modulus(&document)?;
        let gap = gap::whole(section(&document, "gap"), "gap", &Sources::new(&directory, given))?;
        let loading = loading::loading(section(&document, "loading"))?;
        let units = form.units.map(settings::units).transpose()?;
        let settings = settings(form.solve, form.output, &gap, &loading)?;
        let contact = Contact::new(modulus, gap, loading)?;
        Ok(Self { name: form.name, contact, settings, units, document, files: directory.into_read() })
    }

    /// Reads these parts of the document once more, after it was changed there.
    ///
    /// # Errors
    /// As [`Scene::from_json`]; the parts are then as they were.
    pub(crate) fn read_again(&mut self, parts: Parts, given: &Given) -> Result<(), InputError> {
        let gap = if parts.gap {
            let directory = given.place();
            gap::whole(section(&self.document, "gap"), "gap", &Sources::new(&directory, Some(given)))?
        } else {
            self.contact.gap().clone()
        };
        let loading = match parts.loading {
            true => loading::loading(section(&self.document, "loading"))?,
            false => self.contact.loading().clone(),
        };
        let (mut modulus, mut chosen) = (self.contact.modulus(), self.settings);
        // Cells of a map are those of its gap.
        if parts.others || (parts.gap && chosen.nodes) {
            let form: SceneForm = decode(&self.document, ROOT)?;
            modulus = form.modulus(&self.document)?;
            chosen = settings(form.solve, form.output, &gap, &loading)?;
        }
        self.contact = Contact::new(modulus, gap, loading)?;
        self.settings = chosen;
        Ok(())
    }
}

/// Parts of a document that are read apart from each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Parts {
    pub gap: bool,
    pub loading: bool,
    /// Bodies, settings, names.
    pub others: bool,
}

impl SceneForm {
    fn modulus(&self, document: &Json) -> Result<EffectiveModulus, InputError> {
        let bodies = self.bodies.as_ref().and_then(|_| document.get("bodies"));
        bodies::modulus(bodies, self.effective_modulus)
    }
}

/// What a scene asks of the solve of this gap under this loading.
fn settings(
    solve: Option<settings::SolveForm>,
    output: Option<Vec<settings::OutputName>>,
    gap: &AnyGap,
    loading: &Loading,
) -> Result<Settings, InputError> {
    let settings = settings::settings(solve.unwrap_or_default(), &output.unwrap_or_default(), gap)?;
    if settings.nodes && loading.loads().iter().any(|load| matches!(load, Load::ForceMoment { .. })) {
        let allowed = "a number of cells: the grid of a punch free to tilt is found with its tilt";
        return Err(InputError::new("solve.cells", "\"map\" for a punch free to tilt", allowed));
    }
    Ok(settings)
}

/// What stands under this key; null where nothing does.
fn section<'a>(document: &'a Json, key: &str) -> &'a Json {
    document.get(key).unwrap_or(&Json::Null)
}

/// The document of a scene.
pub(crate) fn document(text: &[u8]) -> Result<Json, InputError> {
    if text.len() as u64 > LONGEST {
        return Err(InputError::new(ROOT, "a longer text", format!("at most {LONGEST} bytes")));
    }
    Json::parse(text)
}

/// Everything there is, up to one byte more than a scene may have.
#[cfg(feature = "cli")]
pub(crate) fn read_all(from: impl std::io::Read) -> std::io::Result<Vec<u8>> {
    use std::io::Read;
    let mut text = Vec::new();
    from.take(LONGEST + 1).read_to_end(&mut text)?;
    Ok(text)
}
