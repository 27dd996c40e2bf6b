//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A place to write to, checked before there is anything to write.
#[derive(Debug)]
pub(crate) enum Target {
    /// Standard output.
    Stdout,
    /// A file, written beside its place and then renamed into it.
    File(PathBuf),
    /// Something that is there and is not a file (a pipe, a device): opened and written to.
    Special(PathBuf),
}

impl Target {
    /// `-` is standard output. Fails when the place cannot be written to; leaves nothing behind.
    pub(crate) fn check(path: &Path) -> io::Result<Self> {
        if path.as_os_str() == "-" {
            return Ok(Self::Stdout);
        }
        match fs::metadata(path) {
            Ok(there) if there.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")),
            Ok(there) if !there.is_file() => Ok(Self::Special(path.to_owned())),
            // Through a link to the file itself, so that the link stays.
            Ok(_) => Self::beside(path.canonicalize()?),
            Err(_) => Self::beside(path.to_owned()),
        }
    }

    fn beside(path: PathBuf) -> io::Result<Self> {
        if path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it has no file name"));
        }
        temporary(&path)?;
        Ok(Self::File(path))
    }

    /// Writes everything or, for a file, nothing.
    pub(crate) fn write(&self, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        match self {
            Self::Stdout => through(io::stdout().lock(), fill).map(|_| ()),
            Self::Special(path) => through(File::options().write(true).open(path)?, fill).map(|_| ()),
            Self::File(path) => {
                let file = through(temporary(path)?, fill)?;
                file.persist(path).map(|_| ()).map_err(|e| e.error)
            }
        }
    }
}

fn through<W: Write>(to: W, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<W> {
    let mut to = BufWriter::with_capacity(1 << 16, to);
    fill(&mut to)?;
    to.flush()?;
    to.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A new file in the directory of `path`, with the permissions that any new file has.
fn temporary(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let directory = path.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".contact-patch-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(directory)
}
