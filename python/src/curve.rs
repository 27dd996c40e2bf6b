//! Force over depth as an object of Python's.

use contact_patch::{Curve as Spring, Deadline, InputError, Settings, Unsolved};
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
    let found = interruptible(py, &watch, |interrupt| -> Result<Result<Spring, Unsolved>, InputError> {
        let settings = Settings { threads, deadline: Deadline::NEVER.unless(interrupt), ..scene.settings };
        let range = Spring::range_of(&scene.contact, &settings, None, accuracy)?;
        Ok(range.and_then(|range| Spring::new(&scene.contact, &settings, range)))
    })?;
    let found = found.map_err(|e| wrong(py, &e))?;
    found.map(Curve).map_err(|e| unsolved(py, &e))
}
