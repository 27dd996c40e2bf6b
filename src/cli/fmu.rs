//! The library inside a functional mock-up unit: built by the C compiler of this machine, where there is one.

use std::env;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::curve::{Binary, Source};

/// Name of the platform in the standard, and ending of a library there.
fn platform() -> Option<(&'static str, &'static str)> {
    match (env::consts::OS, env::consts::ARCH) {
        ("linux", "x86_64") => Some(("linux64", "so")),
        ("linux", "aarch64") => Some(("aarch64-linux", "so")),
        ("macos", _) => Some(("darwin64", "dylib")),
        ("windows", "x86_64") => Some(("win64", "dll")),
        _ => None,
    }
}

/// A library for this machine.
pub(super) struct Built {
    platform: &'static str,
    ending: &'static str,
    bytes: Vec<u8>,
}

impl Built {
    pub fn binary(&self) -> Binary<'_> {
        Binary { platform: self.platform, ending: self.ending, bytes: &self.bytes }
    }
}

/// Builds the sources by `CC`, else by `cc`.
///
/// # Errors
/// In words: no compiler, or what it said.
pub(super) fn built(sources: &[Source; 2]) -> Result<Built, String> {
    let (platform, ending) = platform().ok_or("FMI 2.0 has no name for this platform")?;
    let compiler = env::var_os("CC").filter(|cc| !cc.is_empty()).unwrap_or_else(|| "cc".into());
    let folder = tempfile::tempdir().map_err(|e| format!("no directory for temporary files: {e}"))?;
    for source in sources {
        fs::write(folder.path().join(&source.name), &source.text).map_err(|e| format!("{}: {e}", source.name))?;
    }
    let library = folder.path().join("library");
    let mut command = Command::new(&compiler);
    command
        .args(["-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-o"])
        .arg(&library)
        .arg(&sources[0].name)
        .arg("-lm");
    let output = command.current_dir(folder.path()).stdin(Stdio::null()).output();
    let name = Path::new(&compiler).display().to_string();
    let output = output.map_err(|e| format!("the C compiler {name} cannot be run: {e}"))?;
    if !output.status.success() {
        let said: String = String::from_utf8_lossy(&output.stderr).chars().take(500).collect();
        return Err(format!("the C compiler {name} failed: {said}"));
    }
    let bytes = fs::read(&library).map_err(|e| format!("what {name} built cannot be read: {e}"))?;
    Ok(Built { platform, ending, bytes })
}
