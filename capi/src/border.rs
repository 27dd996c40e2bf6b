//! What every call does at the border: texts in and out, panics caught, the message of a thread.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

use contact_patch::{InputError, Unsolved};

/// What a call returns.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    Solved = 0,
    NotSolved = 1,
    Wrong = 2,
    Internal = 3,
}

/// Why a call has no answer.
pub struct Fault(pub Status, pub String);

impl Fault {
    pub fn null(what: &str) -> Self {
        Self(Status::Wrong, format!("{what}: given a null pointer; allowed: a place"))
    }
}

impl From<InputError> for Fault {
    fn from(e: InputError) -> Self {
        Self(Status::Wrong, format!("{}: given {}; allowed: {}", e.path, e.given, e.allowed))
    }
}

impl From<Unsolved> for Fault {
    fn from(e: Unsolved) -> Self {
        Self(Status::NotSolved, e.to_string())
    }
}

thread_local! {
    static MESSAGE: RefCell<CString> = RefCell::default();
}

/// Leaves a message for this thread; a null byte in it becomes a space.
fn leave(message: &str) {
    let plain = CString::new(message.replace('\0', " ")).unwrap_or_default();
    // While a thread ends there is nobody left to read it.
    let _ = MESSAGE.try_with(|kept| *kept.borrow_mut() = plain);
}

/// Does the work of a call; a panic becomes a status.
pub fn guarded(work: impl FnOnce() -> Result<Status, Fault>) -> Status {
    // What a panic may leave half done is dropped with it, or locked away by a poisoned mutex.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(status)) => status,
        Ok(Err(Fault(status, message))) => {
            leave(&message);
            status
        }
        Err(panic) => {
            let said =
                panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
            leave(&format!("a fault of the library: {}", said.unwrap_or("without words")));
            Status::Internal
        }
    }
}

/// A text that came in.
///
/// # Safety
/// `text` is null or ends with a null byte, and stays as it is during the call.
pub unsafe fn text<'a>(what: &str, text: *const c_char) -> Result<&'a str, Fault> {
    if text.is_null() {
        return Err(Fault::null(what));
    }
    // SAFETY: it is not null; the rest is what the caller promises.
    let bytes = unsafe { CStr::from_ptr(text) };
    bytes.to_str().map_err(|_| Fault(Status::Wrong, format!("{what}: given bytes that are not UTF-8; allowed: UTF-8")))
}

/// The same where null stands for something.
///
/// # Safety
/// As [`text`].
pub unsafe fn text_or<'a>(what: &str, given: *const c_char, other: &'a str) -> Result<&'a str, Fault> {
    // SAFETY: as the caller promises.
    if given.is_null() { Ok(other) } else { unsafe { text(what, given) } }
}

/// Hands a text over, to be freed by `cp_text_free`.
///
/// # Safety
/// `place` is null or may be written to.
pub unsafe fn hand_over(place: *mut *mut c_char, text: String) -> Result<(), Fault> {
    if place.is_null() {
        return Err(Fault::null("the place of the text"));
    }
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    // SAFETY: it is not null; the caller promises that it may be written to.
    unsafe { place.write(text.into_raw()) };
    Ok(())
}

/// Writes where there is a place.
///
/// # Safety
/// `place` is null or may be written to.
pub unsafe fn put<T>(place: *mut T, value: T) {
    if !place.is_null() {
        // SAFETY: it is not null; the caller promises that it may be written to.
        unsafe { place.write(value) };
    }
}

/// Threads asked for: 0 is one a core.
pub fn threads(asked: c_int) -> Result<usize, Fault> {
    match usize::try_from(asked) {
        Ok(0) => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
        Ok(n) if n <= 1024 => Ok(n),
        _ => Err(Fault(Status::Wrong, format!("threads: given {asked}; allowed: a whole number from 0 to 1024"))),
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn cp_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

#[unsafe(no_mangle)]
pub extern "C" fn cp_message() -> *const c_char {
    MESSAGE.try_with(|kept| kept.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// # Safety
/// `text` is null or came from a call of this library and was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_text_free(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: it was made by `into_raw` in `hand_over`, as the caller promises.
        drop(unsafe { CString::from_raw(text) });
    }
}
