//! What a program hands to a scene besides its text: heights in memory, gaps that no text can say.

use std::path::PathBuf;

use crate::error::InputError;
use crate::files::named::Directory;
use crate::gap::{AnyGap, Gap, Heights};

/// Heights and gaps by name, and where the files that a scene names are looked for.
///
/// ```
/// use contact_patch::{Scene, scene::Given, gap::Heights, solve};
/// let bowl = |x: f64, y: f64| 0.5 * (x * x + y * y);
/// let heights = Heights::new(vec![0.0, 0.0, 1.0, 0.0], [2, 2], [1.0, 1.0])?;
/// let given = Given::default().gap("bowl", bowl).heights("rough", heights);
/// let scene = Scene::from_json_with(br#"{"effective_modulus": 1.0, "loading": {"depth": -0.1}, "gap": {"kind": "sum", "of": [
///     {"kind": "given", "name": "bowl"}, {"kind": "height_map", "file": "rough", "surface": "upper"}]}}"#, &given)?;
/// assert_eq!(solve(&scene.contact, &scene.settings).remove(0)?.force, 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Given {
    heights: Vec<(String, Heights)>,
    gaps: Vec<(String, AnyGap)>,
    directory: PathBuf,
    closed: bool,
}

impl Given {
    /// Files are looked for in this directory; else in the current one.
    #[must_use]
    pub fn directory(self, directory: impl Into<PathBuf>) -> Self {
        Self { directory: directory.into(), ..self }
    }

    /// Files are read from inside this directory alone, as by [`super::Scene::from_json_within`].
    #[must_use]
    pub fn root(self, directory: impl Into<PathBuf>) -> Self {
        Self { directory: directory.into(), closed: true, ..self }
    }

    /// Heights that a `height_map` reads where its `file` is this name. They carry their own spacing and first node; a spacing in
    /// the scene has to agree.
    #[must_use]
    pub fn heights(mut self, name: impl Into<String>, heights: Heights) -> Self {
        self.heights.push((name.into(), heights));
        self
    }

    /// A gap that stands where the scene says `{"kind": "given", "name": name}`.
    #[must_use]
    pub fn gap(mut self, name: impl Into<String>, gap: impl Gap + 'static) -> Self {
        self.gaps.push((name.into(), AnyGap::new(gap)));
        self
    }

    /// Where the files are.
    pub(crate) fn place(&self) -> Directory {
        if self.closed { Directory::closed(&self.directory) } else { Directory::open(&self.directory) }
    }
}

/// What the gap of a scene is read from, besides the document.
pub(super) struct Sources<'a> {
    pub files: &'a Directory,
    given: Option<&'a Given>,
}

impl<'a> Sources<'a> {
    pub fn new(files: &'a Directory, given: Option<&'a Given>) -> Self {
        Self { files, given }
    }

    /// The heights of this name, when they are in memory. `Some` error where the spacing of the scene is another.
    pub fn heights(&self, name: &str, spacing: Option<[f64; 2]>) -> Option<Result<Heights, InputError>> {
        let (_, heights) = self.given?.heights.iter().find(|(known, _)| known == name)?;
        let own = heights.spacing();
        let other = (0..2).find(|&m| spacing.is_some_and(|s| s[m] != own[m]));
        Some(match other {
            None => Ok(heights.clone()),
            Some(m) => {
                let given = spacing.unwrap_or_default()[m];
                Err(InputError::new(format!("spacing[{m}]"), given, format!("{}, the spacing of the heights", own[m])))
            }
        })
    }

    /// Whether gaps can be given by name.
    pub fn any_gap(&self) -> bool {
        self.given.is_some_and(|given| !given.gaps.is_empty())
    }

    /// The gap of this name.
    ///
    /// # Errors
    /// Names `name` when there is no such gap.
    pub fn gap(&self, name: &str) -> Result<AnyGap, InputError> {
        let gaps = self.given.map_or(&[][..], |given| &given.gaps);
        let found = gaps.iter().find(|(known, _)| known == name).map(|(_, gap)| gap.clone());
        found.ok_or_else(|| {
            let names: Vec<&str> = gaps.iter().map(|(known, _)| known.as_str()).collect();
            InputError::new("name", super::document::quoted(name), format!("one of: {}", names.join(", ")))
        })
    }
}
