//! The part of the Python package that is Rust: texts and arrays in, texts and arrays out. What users see is written in Python on top of it.
//!
//! Work runs without Python's lock, on a thread of its own, so that Ctrl-C reaches it; no panic gets across.

mod curve;
mod function;
mod scene;
mod table;
mod work;

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use contact_patch::{Grid, Method, Pressure, Settings, plot, report};
use scene::Source;
use work::{interruptible, protected};

/// The values of a field, x fastest, or nothing.
type Field<'py> = Option<Bound<'py, PyArray1<f64>>>;

/// The result of a scene as JSON, without the values of its fields, and those: (pressure, gap) of each state.
#[pyfunction]
fn solve<'py>(py: Python<'py>, source: Source, threads: usize) -> PyResult<(String, Vec<(Field<'py>, Field<'py>)>)> {
    let (scene, watch) = source.scene(py)?;
    let (text, steps) = interruptible(py, &watch, |interrupt| {
        let mut scene = scene;
        scene.settings = Settings { threads, deadline: scene.settings.deadline.unless(interrupt), ..scene.settings };
        let steps = contact_patch::solve(&scene.contact, &scene.settings);
        let text = serde_json::to_string(&report::json(&scene, &steps).without_fields());
        (text, steps)
    })?;
    let text = text.map_err(|e| PyValueError::new_err(e.to_string()))?;
    let array = |values: Vec<f64>| values.into_pyarray(py);
    let fields =
        steps.into_iter().map(|step| match step.or_else(|unsolved| unsolved.best.map(|best| *best).ok_or(())) {
            Ok(state) => (
                state.pressure.field.map(|field| array(field.values)),
                state.pressure.gap.map(|(_, values)| array(values)),
            ),
            Err(()) => (None, None),
        });
    Ok((text, fields.collect()))
}

/// What would run, why, and what is left out: (method or None, steps, left out).
#[pyfunction]
fn plan(py: Python<'_>, source: Source) -> PyResult<(Option<&'static str>, Vec<String>, Vec<String>)> {
    let (scene, watch) = source.scene(py)?;
    let plan = interruptible(py, &watch, |_| contact_patch::plan(&scene.contact, &scene.settings))?;
    let plan = plan.map_err(|unsolved| scene::unsolved(py, &unsolved))?;
    Ok((plan.method.map(Method::name), plan.steps, plan.left_out))
}

/// A grid of cells: origin, spacing, shape.
type GridOf = ([f64; 2], [f64; 2], [usize; 2]);

fn grid((origin, spacing, shape): GridOf) -> PyResult<Grid> {
    if shape[0].checked_mul(shape[1]).is_none() {
        return Err(PyValueError::new_err("shape: more cells than there can be"));
    }
    Ok(Grid { origin, spacing, shape })
}

/// Fields on a grid as VTK image data.
#[pyfunction]
fn vti<'py>(
    py: Python<'py>,
    on: GridOf,
    fields: Vec<(String, PyReadonlyArray1<f64>)>,
) -> PyResult<Bound<'py, PyBytes>> {
    let on = grid(on)?;
    let named =
        fields.iter().map(|(name, values)| Ok((name.as_str(), values.as_slice()?))).collect::<PyResult<Vec<_>>>()?;
    let mut file = Vec::new();
    report::vti(&mut file, &on, &named)?;
    Ok(PyBytes::new(py, &file))
}

/// The boundary of a patch and the pressure as a picture, SVG; None when there is nothing to draw. `without_end`: pressures go on to
/// infinity.
#[pyfunction]
fn picture(
    py: Python<'_>,
    title: &str,
    boundary: Vec<Vec<[f64; 2]>>,
    field: Option<(GridOf, PyReadonlyArray1<f64>)>,
    without_end: bool,
) -> PyResult<Option<String>> {
    let field = match field {
        Some((on, values)) => Some(Pressure { grid: grid(on)?, values: values.as_slice()?.to_vec() }),
        None => None,
    };
    if field.as_ref().is_some_and(|field| field.values.len() != field.grid.len()) {
        return Err(PyValueError::new_err("field: one value a cell"));
    }
    let draw = || plot::field_map(title, &boundary, field.as_ref(), without_end, plot::Format::Svg);
    let drawn = protected(|| py.detach(draw))?;
    match drawn {
        Ok(svg) => Ok(Some(String::from_utf8_lossy(&svg).into_owned())),
        Err(plot::Error::Empty(_)) => Ok(None),
        Err(e) => Err(PyValueError::new_err(e.to_string())),
    }
}

/// Runs the command line; returns its exit code.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
    use std::process::ExitCode;
    let code = protected(|| py.detach(|| contact_patch::cli::run_with(arguments)))?;
    Ok([0, 1].into_iter().find(|&n| code == ExitCode::from(n)).unwrap_or(2))
}

/// JSON Schema of a scene, as text.
#[pyfunction]
fn schema() -> &'static str {
    contact_patch::scene::schema()
}

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<curve::Curve>()?;
    for function in [
        wrap_pyfunction!(solve, module)?,
        wrap_pyfunction!(plan, module)?,
        wrap_pyfunction!(curve::curve, module)?,
        wrap_pyfunction!(table::table, module)?,
        wrap_pyfunction!(vti, module)?,
        wrap_pyfunction!(picture, module)?,
        wrap_pyfunction!(command, module)?,
        wrap_pyfunction!(schema, module)?,
    ] {
        module.add_function(function)?;
    }
    Ok(())
}
