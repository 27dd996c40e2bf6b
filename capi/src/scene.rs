//! A scene in, a result out.

use std::ffi::c_char;

use contact_patch::scene::Given;
use contact_patch::{Scene, report, solve};

use crate::border::{Fault, Status, guarded, hand_over, text, text_or};

/// Reads a scene; files that it names are looked for in this directory.
pub fn read(scene: &str, directory: &str) -> Result<Scene, Fault> {
    Ok(Scene::from_json_with(scene.as_bytes(), &Given::default().directory(directory))?)
}

/// # Safety
/// The texts end with null bytes; `result` may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_solve(scene: *const c_char, directory: *const c_char, result: *mut *mut c_char) -> Status {
    guarded(|| {
        if result.is_null() {
            return Err(Fault::null("result"));
        }
        // SAFETY: as the caller promises.
        let (scene, directory) = unsafe { (text("scene", scene)?, text_or("directory", directory, "")?) };
        let scene = read(scene, directory)?;
        let steps = solve(&scene.contact, &scene.settings);
        let written = serde_json::to_string(&report::json(&scene, &steps))
            .map_err(|e| Fault(Status::Internal, format!("the result cannot be written: {e}")))?;
        // SAFETY: as the caller promises.
        unsafe { hand_over(result, written)? };
        match steps.into_iter().find_map(Result::err) {
            None => Ok(Status::Solved),
            Some(unsolved) => Err(unsolved.into()),
        }
    })
}
