//! A scene as Python hands it over: its text, arrays of heights, functions.

use std::path::PathBuf;

use contact_patch::gap::Heights;
use contact_patch::scene::Given;
use contact_patch::{InputError, Scene, Unsolved};
use numpy::PyReadonlyArray1;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::function::Function;
use crate::work::{Watch, protected};

/// An exception of `contact_patch`, made of these arguments.
fn exception<'py>(py: Python<'py>, name: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py.import("contact_patch._errors").and_then(|module| module.getattr(name));
    class.and_then(|class| class.call1(arguments)).map_or_else(|e| e, PyErr::from_value)
}

/// `SceneError(path, given, allowed)`: a scene that is wrong.
pub(crate) fn wrong(py: Python<'_>, error: &InputError) -> PyErr {
    exception(py, "SceneError", (&error.path, &error.given, &error.allowed))
}

/// `Unsolved(verdict, reason)`: no answer.
pub(crate) fn unsolved(py: Python<'_>, unsolved: &Unsolved) -> PyErr {
    exception(py, "Unsolved", (unsolved.verdict.word(), &unsolved.reason))
}

/// Heights: name, values (x fastest), shape, spacing, first node.
type HeightsOf<'py> = (String, PyReadonlyArray1<'py, f64>, [usize; 2], [f64; 2], Option<[f64; 2]>);

/// A scene and what belongs to it: (text, directory, heights, functions).
pub(crate) struct Source<'py> {
    pub text: PyBackedBytes,
    directory: PathBuf,
    heights: Vec<HeightsOf<'py>>,
    functions: Vec<(String, Py<PyAny>)>,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Source<'py> {
    type Error = PyErr;

    fn extract(from: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let (text, directory, heights, functions) = from
            .extract::<(PyBackedBytes, PathBuf, Vec<HeightsOf<'py>>, Vec<(String, Py<PyAny>)>)>()
            .map_err(|_| PyTypeError::new_err("a scene: (text, directory, heights, functions)"))?;
        Ok(Self { text, directory, heights, functions })
    }
}

impl Source<'_> {
    /// What the scene is read with, and what watches over it.
    pub fn given(&self, py: Python<'_>) -> PyResult<(Given, Watch)> {
        let watch = Watch::default();
        let mut given = Given::default().directory(&self.directory);
        for (name, values, shape, spacing, origin) in &self.heights {
            let heights = Heights::new(values.as_slice()?.to_vec(), *shape, *spacing);
            let heights = heights.and_then(|heights| origin.map_or(Ok(heights.clone()), |origin| heights.at(origin)));
            given = given.heights(name, heights.map_err(|e| wrong(py, &e.within("gap")))?);
        }
        for (name, function) in &self.functions {
            given = given.gap(name, Function::new(function.clone_ref(py), watch.clone()));
        }
        Ok((given, watch))
    }

    /// The scene.
    ///
    /// # Errors
    /// SceneError when it is wrong; what a function raised.
    pub fn scene(&self, py: Python<'_>) -> PyResult<(Scene, Watch)> {
        let (given, watch) = self.given(py)?;
        let text: &[u8] = &self.text;
        let read = protected(|| py.detach(|| Scene::from_json_with(text, &given)))?;
        watch.check()?;
        read.map(|scene| (scene, watch)).map_err(|e| wrong(py, &e))
    }
}
