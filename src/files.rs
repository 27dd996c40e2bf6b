//! Files that are read: regular ones, of a limited size. Whatever is refused is refused before it is opened, and no message
//! repeats what a file holds.

use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::Path;

use crate::error::InputError;

/// The bytes of a regular file of at most `longest` bytes.
///
/// # Errors
/// Names `file` when there is no such file, when it is a pipe, a device, a socket or a directory, when it cannot be read, or
/// when it is longer.
pub(crate) fn read(path: &Path, longest: u64) -> Result<Vec<u8>, InputError> {
    let refused = |what: &str| {
        let allowed = format!("a regular file of at most {longest} bytes that can be read");
        Err(InputError::new("file", format!("{} ({what})", path.display()), allowed))
    };
    let unread = |e: io::Error| match e.kind() {
        io::ErrorKind::NotFound => "no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "no permission to read it".to_owned(),
        _ => e.to_string(),
    };
    // To open a pipe is to wait for its other end.
    match std::fs::metadata(path) {
        Err(e) => return refused(&unread(e)),
        Ok(about) if !about.is_file() => return refused(kind(about.file_type())),
        Ok(about) if about.len() > longest => return refused(&format!("{} bytes", about.len())),
        Ok(_) => {}
    }
    let bytes = File::open(path).and_then(|file| {
        // Another may stand there by now.
        if !file.metadata()?.is_file() {
            return Err(io::Error::other("no longer a regular file"));
        }
        let mut bytes = Vec::new();
        file.take(longest + 1).read_to_end(&mut bytes).map(|_| bytes)
    });
    match bytes {
        Ok(bytes) if bytes.len() as u64 <= longest => Ok(bytes),
        Ok(_) => refused("longer than that"),
        Err(e) => refused(&unread(e)),
    }
}

fn kind(file: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if file.is_fifo() {
            return "a pipe";
        }
        if file.is_char_device() || file.is_block_device() {
            return "a device";
        }
        if file.is_socket() {
            return "a socket";
        }
    }
    if file.is_dir() { "a directory" } else { "not a regular file" }
}

/// Where the files that a scene names are read, and which were.
#[cfg(feature = "scene")]
pub(crate) mod named {
    use std::cell::RefCell;
    use std::path::{Component, Path, PathBuf};

    use crate::error::InputError;

    /// The directory that names of files start from.
    #[derive(Debug)]
    pub(crate) struct Directory {
        path: PathBuf,
        /// Whether files are read from inside of it alone.
        closed: bool,
        read: RefCell<Vec<PathBuf>>,
    }

    impl Directory {
        /// Names may lead anywhere.
        pub fn open(path: &Path) -> Self {
            Self { path: path.to_owned(), closed: false, read: RefCell::default() }
        }

        /// Only what lies inside is read, whatever names and symbolic links say.
        pub fn closed(path: &Path) -> Self {
            Self { closed: true, ..Self::open(path) }
        }

        /// The place of the file with this name.
        ///
        /// # Errors
        /// Names `file` when it lies outside of a closed directory; whether there is such a file is not told.
        pub fn place(&self, name: &str) -> Result<PathBuf, InputError> {
            let mut place = self.path.join(name);
            if self.closed {
                let outside = || InputError::new("file", name, "a file inside the directory of --root");
                let climbs = |part| !matches!(part, Component::Normal(_) | Component::CurDir);
                if Path::new(name).components().any(climbs) {
                    return Err(outside());
                }
                // Links are followed here, so that what is opened is what was looked at.
                let whole = place.canonicalize().and_then(|place| Ok((place, self.path.canonicalize()?)));
                match whole {
                    Ok((whole, root)) if whole.starts_with(&root) => place = whole,
                    Ok(_) => return Err(outside()),
                    Err(_) => return Err(InputError::new("file", name, "a file that can be read inside of --root")),
                }
            }
            self.read.borrow_mut().push(place.clone());
            Ok(place)
        }

        /// The files that were asked for.
        pub fn into_read(self) -> Vec<PathBuf> {
            self.read.into_inner()
        }
    }
}
