//! The non-linear spring as an object of C's.

use std::ffi::{c_char, c_int};

use contact_patch::curve::{About, Beyond};
use contact_patch::{Curve, InputError, Settings, UnitLabels, Unsolved, Verdict};

use crate::border::{Fault, Status, guarded, hand_over, put, text, text_or, threads};
use crate::scene::read;

/// Steps of a table.
const STEPS: usize = 200;

/// A spring with what is said beside it.
#[derive(Debug)]
pub struct Spring {
    curve: Curve,
    name: Option<String>,
    units: Option<UnitLabels>,
}

#[repr(C)]
pub struct Facts {
    first_touch: f64,
    deepest: f64,
    force_error: f64,
    stiffness_error: f64,
    coefficient: f64,
    exponent: f64,
    solves: usize,
}

/// # Safety
/// The texts end with null bytes; `curve` may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_new(
    scene: *const c_char,
    directory: *const c_char,
    accuracy: f64,
    from: f64,
    beyond: c_int,
    asked_threads: c_int,
    curve: *mut *mut Spring,
) -> Status {
    guarded(|| {
        if curve.is_null() {
            return Err(Fault::null("curve"));
        }
        // SAFETY: as the caller promises.
        let (scene, directory) = unsafe { (text("scene", scene)?, text_or("directory", directory, "")?) };
        let scene = read(scene, directory)?;
        if !(accuracy > 0.0 && accuracy < 1.0) {
            return Err(InputError::new("accuracy", accuracy, "a number greater than 0 and less than 1").into());
        }
        let beyond = match beyond {
            0 => Beyond::Power,
            1 => Beyond::Tangent,
            2 => Beyond::Refuse,
            other => return Err(InputError::new("beyond", other, "CP_BEYOND_POWER, _TANGENT or _REFUSE").into()),
        };
        let settings = Settings { threads: threads(asked_threads)?, ..scene.settings };
        let from = Some(from).filter(|from| !from.is_nan());
        let range = Curve::range_of(&scene.contact, &settings, from, accuracy)??;
        let found = Curve::new(&scene.contact, &settings, range)?.continued(beyond);
        let spring = Box::new(Spring { curve: found, name: scene.name, units: scene.units });
        // SAFETY: as the caller promises.
        unsafe { put(curve, Box::into_raw(spring)) };
        Ok(Status::Solved)
    })
}

/// # Safety
/// `curve` is null or came from `cp_curve_new` and was not freed.
unsafe fn spring<'a>(curve: *const Spring) -> Result<&'a Spring, Fault> {
    // SAFETY: as the caller promises.
    unsafe { curve.as_ref() }.ok_or_else(|| Fault::null("curve"))
}

/// Nothing is said beyond the range.
fn refused(depth: f64) -> Fault {
    Unsolved::new(Verdict::NotApplicable, format!("the depth {depth:e} is beyond the range of the curve")).into()
}

/// # Safety
/// `curve` came from `cp_curve_new` and was not freed; the places are null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_evaluate(
    curve: *const Spring,
    depth: f64,
    force: *mut f64,
    stiffness: *mut f64,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let spring = unsafe { spring(curve)? };
        let [p, k, _] = spring.curve.derivatives(depth).ok_or_else(|| refused(depth))?;
        // SAFETY: as the caller promises.
        unsafe {
            put(force, p);
            put(stiffness, k);
        }
        Ok(Status::Solved)
    })
}

/// # Safety
/// As `cp_curve_evaluate`; `centre` is null or two doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_patch(
    curve: *const Spring,
    depth: f64,
    area: *mut f64,
    centre: *mut [f64; 2],
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let spring = unsafe { spring(curve)? };
        let wide = spring.curve.area(depth).ok_or_else(|| refused(depth))?;
        let middle = match (centre.is_null(), spring.curve.centre(depth)) {
            (true, _) => None,
            (false, Some(middle)) => Some(middle),
            (false, None) => {
                let reason = "the method gives no centre of pressure";
                return Err(Unsolved::new(Verdict::NotApplicable, reason).into());
            }
        };
        // SAFETY: as the caller promises; an array of C's is one of Rust's.
        unsafe {
            put(area, wide);
            if let Some(middle) = middle {
                put(centre, middle);
            }
        }
        Ok(Status::Solved)
    })
}

/// # Safety
/// As `cp_curve_evaluate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_depth(curve: *const Spring, force: f64, depth: *mut f64) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let spring = unsafe { spring(curve)? };
        let found = spring.curve.depth(force).ok_or_else(|| {
            Fault::from(Unsolved::new(Verdict::NoEquilibrium, format!("no depth of the curve has the force {force:e}")))
        })?;
        // SAFETY: as the caller promises.
        unsafe { put(depth, found) };
        Ok(Status::Solved)
    })
}

/// # Safety
/// As `cp_curve_evaluate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_about(curve: *const Spring, facts: *mut Facts) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let Spring { curve, .. } = unsafe { spring(curve)? };
        let law = curve.power_law();
        let found = Facts {
            first_touch: curve.first_touch(),
            deepest: curve.deepest(),
            force_error: curve.interpolation_error(),
            stiffness_error: curve.stiffness_error(),
            coefficient: law.coefficient,
            exponent: law.exponent,
            solves: curve.solves(),
        };
        if facts.is_null() {
            return Err(Fault::null("facts"));
        }
        // SAFETY: as the caller promises.
        unsafe { put(facts, found) };
        Ok(Status::Solved)
    })
}

/// # Safety
/// As `cp_curve_evaluate`; `name` is null or ends with a null byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_text(
    curve: *const Spring,
    form: c_int,
    name: *const c_char,
    written: *mut *mut c_char,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let (Spring { curve, name: scene, units }, name) =
            unsafe { (spring(curve)?, text_or("name", name, "contact")?) };
        let about = About { scene: scene.as_deref(), units: units.as_ref() };
        let text = match form {
            0 => curve.csv_in(units.as_ref(), STEPS),
            1 => curve.json_about(about),
            2 => curve.c_header_about(about, name),
            other => return Err(InputError::new("form", other, "CP_FORM_CSV, _JSON or _C_HEADER").into()),
        };
        // SAFETY: as the caller promises.
        unsafe { hand_over(written, text)? };
        Ok(Status::Solved)
    })
}

/// # Safety
/// `curve` is null or came from `cp_curve_new` and was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cp_curve_free(curve: *mut Spring) {
    if !curve.is_null() {
        // SAFETY: it was made by `into_raw` in `cp_curve_new`, as the caller promises.
        drop(unsafe { Box::from_raw(curve) });
    }
}
