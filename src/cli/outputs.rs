//! The files that a command writes: checked before anything is computed.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::Failure;
use crate::error::InputError;
use crate::report::write::Target;

/// An output: the path that was given, and where it leads.
pub(super) type Output<'a> = Option<(&'a Path, Target)>;

/// Where the options lead, in their order. None may name a file that the command reads, nor the same file as another.
///
/// # Errors
/// Names the option; the file when it cannot be written.
pub(super) fn outputs<'a, const N: usize>(
    options: [(&str, Option<&'a Path>); N],
    inputs: &[PathBuf],
) -> Result<[Output<'a>; N], Failure> {
    let mut found = [const { None }; N];
    for (k, (option, path)) in options.iter().enumerate() {
        let Some(path) = path else { continue };
        let given = |what: &str| {
            let error = InputError::new(*option, format!("{}, {what}", path.display()), "a file of its own");
            Failure::wrong("arguments", &error)
        };
        if path.as_os_str() != "-" && inputs.iter().any(|input| are_one(input, path)) {
            return Err(given("which is read"));
        }
        for (other, before) in options[..k].iter().filter_map(|(other, before)| before.map(|before| (other, before))) {
            if are_one(before, path) {
                return Err(given(&format!("which {other} names too")));
            }
        }
        found[k] = Some((*path, Target::check(path).map_err(|e| Failure::unwritable(path, &e))?));
    }
    Ok(found)
}

/// Where the main output of a command goes.
#[derive(Args)]
pub(super) struct MainOutput {
    /// Where to write; - is standard output
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

impl MainOutput {
    /// Checked before anything is computed.
    ///
    /// # Errors
    /// As [`outputs`].
    pub fn target(&self, inputs: &[PathBuf]) -> Result<MainTarget<'_>, Failure> {
        let [target] = outputs([("--output", Some(self.output.as_path()))], inputs)?;
        Ok(MainTarget { path: &self.output, target: target.map_or(Target::Stdout, |(_, target)| target) })
    }
}

/// The main output, ready to be written.
pub(super) struct MainTarget<'a> {
    path: &'a Path,
    target: Target,
}

impl MainTarget<'_> {
    /// Writes it as a whole.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
        self.target.write(fill).map_err(|e| Failure::unwritable(self.path, &e))
    }
}

/// Whether two paths lead to one file, whether or not it is there yet.
fn are_one(a: &Path, b: &Path) -> bool {
    a == b || identity(a).zip(identity(b)).is_some_and(|(a, b)| a == b)
}

/// What tells files apart.
#[derive(PartialEq)]
enum Identity {
    /// Device and number on it: the same for every name of a file.
    #[cfg(unix)]
    Node(u64, u64),
    Place(PathBuf),
}

fn identity(path: &Path) -> Option<Identity> {
    #[cfg(unix)]
    if let Ok(about) = std::fs::metadata(path) {
        use std::os::unix::fs::MetadataExt;
        return Some(Identity::Node(about.dev(), about.ino()));
    }
    if let Ok(place) = path.canonicalize() {
        return Some(Identity::Place(place));
    }
    // Not there yet: its directory is.
    let directory = path.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(Identity::Place(directory.canonicalize().ok()?.join(path.file_name()?)))
}
