//! A warm contact as an object of C's.

use std::ffi::{c_char, c_int};
use std::sync::{Mutex, PoisonError};

use contact_patch::curve::{Pose, WarmContact};

use crate::border::{Fault, Status, guarded, put, text, text_or};
use crate::scene::read;

/// A contact; calls on it wait for each other.
#[derive(Debug)]
pub struct Warm(Mutex<WarmContact>);

#[repr(C)]
pub struct CPose {
    depth: f64,
    tilt: [f64; 2],
    at: [f64; 2],
}

#[repr(C)]
pub struct CReaction {
    force: f64,
    moment: [f64; 2],
    area: f64,
    error: f64,
    laid: c_int,
}

/// # Safety
/// The texts end with null bytes; `contact` may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_contact_new(
    scene: *const c_char,
    directory: *const c_char,
    contact: *mut *mut Warm,
) -> Status {
    guarded(|| {
        if contact.is_null() {
            return Err(Fault::null("contact"));
        }
        // SAFETY: as the caller promises.
        let (scene, directory) = unsafe { (text("scene", scene)?, text_or("directory", directory, "")?) };
        let scene = read(scene, directory)?;
        let warm = Box::new(Warm(Mutex::new(WarmContact::new(&scene.contact, &scene.settings))));
        // SAFETY: as the caller promises.
        unsafe { put(contact, Box::into_raw(warm)) };
        Ok(Status::Solved)
    })
}

/// # Safety
/// `contact` came from `cp_contact_new` and was not freed; `pose` may be read, `reaction` written to; `stiffness` is null or nine doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_contact_step(
    contact: *mut Warm,
    pose: *const CPose,
    reaction: *mut CReaction,
    stiffness: *mut [f64; 9],
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises; the contact is shared, its inside locked.
        let (warm, pose) = unsafe { (contact.as_ref(), pose.as_ref()) };
        let (warm, pose) = (warm.ok_or_else(|| Fault::null("contact"))?, pose.ok_or_else(|| Fault::null("pose"))?);
        if reaction.is_null() {
            return Err(Fault::null("reaction"));
        }
        let pose = Pose { depth: pose.depth, tilt: pose.tilt, at: pose.at };
        // After a panic the grid that it left is not gone back to: each step takes it away before it works.
        let mut warm = warm.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = if stiffness.is_null() { warm.force(pose)? } else { warm.reaction(pose)? };
        let matrix = std::array::from_fn(|n| found.stiffness[n / 3][n % 3]);
        let answer = CReaction {
            force: found.force,
            moment: found.moment,
            area: found.area,
            error: found.error,
            laid: c_int::from(found.laid),
        };
        // SAFETY: as the caller promises; an array of C's is one of Rust's.
        unsafe {
            put(reaction, answer);
            put(stiffness, matrix);
        }
        Ok(Status::Solved)
    })
}

/// # Safety
/// `contact` is null or came from `cp_contact_new` and was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_contact_free(contact: *mut Warm) {
    if !contact.is_null() {
        // SAFETY: it was made by `into_raw` in `cp_contact_new`, as the caller promises.
        drop(unsafe { Box::from_raw(contact) });
    }
}
