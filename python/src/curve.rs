//! Force over depth as an object of Python's.

use contact_patch::{Curve as Spring, Deadline, Load, Loading, Settings, Unsolved};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::scene::{Source, unsolved, wrong};
use crate::work::interruptible;

/// Force over depth: values of arrays, NaN beyond the range.
#[pyclass(frozen, module = "contact_patch._core")]
pub(crate) struct Curve(Spring);

#[pymethods]
impl Curve {
    fn force<'py>(&self, py: Python<'py>, depth: PyReadonlyArray1<f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.each(py, depth, |spring, depth| spring.force(depth))
    }

    fn stiffness<'py>(&self, py: Python<'py>, depth: PyReadonlyArray1<f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.each(py, depth, |spring, depth| spring.stiffness(depth))
    }

    fn depth<'py>(&self, py: Python<'py>, force: PyReadonlyArray1<f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.each(py, force, |spring, force| spring.depth(force))
    }

    /// First touch, largest depth, estimated relative error, states that were solved.
    fn facts(&self) -> (f64, f64, f64, usize) {
        let spring = &self.0;
        (spring.first_touch(), spring.deepest(), spring.interpolation_error(), spring.solves())
    }

    fn json(&self) -> String {
        self.0.json()
    }
}

impl Curve {
    fn each<'py>(
        &self,
        py: Python<'py>,
        at: PyReadonlyArray1<f64>,
        of: impl Fn(&Spring, f64) -> Option<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let values: Vec<f64> = at.as_slice()?.iter().map(|&x| of(&self.0, x).unwrap_or(f64::NAN)).collect();
        Ok(values.into_pyarray(py))
    }
}

/// The curve of a scene up to its largest load; raises Unsolved.
#[pyfunction]
pub(crate) fn curve(py: Python<'_>, source: Source, accuracy: f64, threads: usize) -> PyResult<Curve> {
    let (scene, watch) = source.scene(py)?;
    let tilted = |load: &Load| matches!(load, Load::Tilted { .. } | Load::ForceMoment { .. });
    if scene.contact.loading().loads().iter().any(tilted) {
        let allowed = "depths or forces of a punch that does not tilt";
        return Err(wrong(py, &contact_patch::InputError::new("loading", "a tilt or a moment", allowed)));
    }
    let found = interruptible(py, &watch, |interrupt| -> Result<Spring, Unsolved> {
        let settings = Settings { threads, deadline: Deadline::NEVER.unless(interrupt), ..scene.settings };
        let contact = &scene.contact;
        let (mut deepest, mut strongest) = (f64::NEG_INFINITY, 0.0f64);
        for load in contact.loading().loads() {
            match *load {
                Load::Depth(depth) | Load::Tilted { depth, .. } => deepest = deepest.max(depth),
                Load::Force(force) | Load::ForceMoment { force, .. } => strongest = strongest.max(force),
            }
        }
        if strongest > 0.0 {
            let contact =
                contact_patch::Contact::new(contact.modulus(), contact.gap().clone(), Loading::force(strongest))
                    .map_err(|e| Unsolved::new(contact_patch::Verdict::NotApplicable, e.to_string()))?;
            let state = contact_patch::solve(&contact, &settings).remove(0).or_else(Unsolved::accept_best)?;
            deepest = deepest.max(state.depth);
        }
        Spring::up_to(contact, &settings, deepest, accuracy)
    })?;
    found.map(Curve).map_err(|e| unsolved(py, &e))
}
