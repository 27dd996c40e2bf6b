//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::sync::Once;
use std::sync::{Mutex, MutexGuard, PoisonError};

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
        Temporary::beside(&path)?;
        Ok(Self::File(path))
    }

    /// Writes everything or, for a file, nothing.
    pub(crate) fn write(&self, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        match self {
            Self::Stdout => through(io::stdout().lock(), fill).map(|_| ()),
            Self::Special(path) => through(File::options().write(true).open(path)?, fill).map(|_| ()),
            Self::File(path) => through(Temporary::beside(path)?, fill)?.persist(path),
        }
    }
}

fn through<W: Write>(to: W, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<W> {
    let mut to = BufWriter::with_capacity(1 << 16, to);
    fill(&mut to)?;
    to.flush()?;
    to.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A file beside its place, which is removed unless it is put there, by a signal that ends the program too.
struct Temporary {
    /// `None` once it has its place.
    file: Option<tempfile::NamedTempFile>,
}

/// The temporary files that are there. Files come and go, and the program ends by a signal, only while this is locked.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn all() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Temporary {
    /// A new file in the directory of `path`, with the permissions that any new file has.
    fn beside(path: &Path) -> io::Result<Self> {
        remove_on_signals();
        let directory = path.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".contact-patch-");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut all = all();
        let file = builder.tempfile_in(directory)?;
        all.push(file.path().to_owned());
        Ok(Self { file: Some(file) })
    }

    /// Renames the file to `path`.
    fn persist(mut self, path: &Path) -> io::Result<()> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let mut all = all();
        all.retain(|known| known != file.path());
        file.persist(path).map(|_| ()).map_err(|e| e.error)
    }
}

impl Write for Temporary {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut all = all();
            all.retain(|known| known != file.path());
            drop(file);
        }
    }
}

/// From the first temporary file on, signals that end the program remove all of them first; the program then ends by the signal,
/// as it would have.
#[cfg(unix)]
fn remove_on_signals() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // What the caller wants ignored, as nohup does, stays ignored.
        let ignored = ignored_signals();
        let wanted = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
        let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) else { return };
        std::thread::spawn(move || {
            for signal in signals.forever() {
                let all = all();
                for path in all.iter() {
                    // What is gone already needs no removal.
                    let _ = fs::remove_file(path);
                }
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        });
    });
}

/// One bit a signal, signal 1 first; none where the system does not tell.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}

#[cfg(not(unix))]
fn remove_on_signals() {}
