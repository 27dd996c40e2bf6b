//! A gap given by a function of Python: f(x, y) of arrays, called with many points at a time.

use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use contact_patch::gap::Gap;
use contact_patch::geometry::Rect;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::work::Watch;

/// A function with what watches over the work that calls it.
pub(crate) struct Function {
    function: Py<PyAny>,
    watch: Watch,
    /// Values at single points, by the bits of the coordinates: the search for the place of contact asks for the same ones again.
    known: Mutex<HashMap<[u64; 2], f64>>,
}

/// Most values that are kept; then they are forgotten.
const MOST_KNOWN: usize = 1 << 18;

impl Function {
    pub fn new(function: Py<PyAny>, watch: Watch) -> Self {
        Self { function, watch, known: Mutex::default() }
    }

    fn known(&self) -> MutexGuard<'_, HashMap<[u64; 2], f64>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The values at these points. What the function raises ends the work; until it has, there is no material anywhere.
    fn values(&self, points: &[[f64; 2]]) -> Vec<f64> {
        if !self.watch.is_over() {
            match Python::attach(|py| self.call(py, points)) {
                Ok(values) => return values,
                Err(raised) => self.watch.raise(raised),
            }
        }
        vec![f64::INFINITY; points.len()]
    }

    fn call(&self, py: Python<'_>, points: &[[f64; 2]]) -> PyResult<Vec<f64>> {
        let axis = |m: usize| points.iter().map(|p| p[m]).collect::<Vec<f64>>().into_pyarray(py);
        let answer = self.function.bind(py).call1((axis(0), axis(1)))?;
        if let Ok(array) = answer.cast::<PyArray1<f64>>()
            && array.len() == points.len()
        {
            return numbers(points, array.to_vec()?);
        }
        let numpy = py.import("numpy")?;
        let float = PyDict::new(py);
        float.set_item("dtype", "float64")?;
        let array = numpy.call_method("asarray", (answer,), Some(&float))?;
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let array = match shape.as_slice() {
            [n] if *n == points.len() => array,
            // A constant is a gap, too.
            [] => numpy.call_method1("full", (points.len(), array))?,
            _ => {
                let told = format!(
                    "gap: the function returned an array of shape {shape:?} for {n} points; allowed: an array of shape ({n},), as x and y",
                    n = points.len()
                );
                return Err(PyValueError::new_err(told));
            }
        };
        numbers(points, array.cast::<PyArray1<f64>>()?.to_vec()?)
    }
}

/// # Errors
/// ValueError where one of them is NaN.
fn numbers(points: &[[f64; 2]], values: Vec<f64>) -> PyResult<Vec<f64>> {
    match values.iter().position(|value| value.is_nan()) {
        None => Ok(values),
        Some(k) => {
            let [x, y] = points[k];
            let told = format!(
                "gap: the function returned NaN at ({x}, {y}); allowed: a number, or inf where there is no material"
            );
            Err(PyValueError::new_err(told))
        }
    }
}

impl Gap for Function {
    fn gap(&self, x: f64, y: f64) -> f64 {
        let key = [x.to_bits(), y.to_bits()];
        if let Some(value) = self.known().get(&key) {
            return *value;
        }
        let value = self.values(&[[x, y]])[0];
        let mut known = self.known();
        if known.len() == MOST_KNOWN {
            known.clear();
        }
        known.insert(key, value);
        value
    }

    /// As the mean of any closure (three-point Gauss, halved where it disagrees with itself), one call for each halving.
    fn mean(&self, cell: &Rect) -> f64 {
        let corners = cell.scaled(1.0 - 1e-9).corners();
        let points: Vec<[f64; 2]> = nodes(cell).into_iter().chain(corners).collect();
        let values = self.values(&points);
        let mean = average(&values[..9]);
        if values.iter().any(|value| !value.is_finite()) {
            return f64::INFINITY;
        }
        let (low, high) =
            values[..9].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (v.min(a), v.max(b)));
        let tolerance = AGREEMENT * (high - low);
        let (mut open, mut total) = (vec![(*cell, mean)], 0.0);
        let mut share = 1.0;
        for depth in 0..=DEEPEST {
            let quarters: Vec<Rect> = open.iter().flat_map(|(rect, _)| quarters(rect)).collect();
            let points: Vec<[f64; 2]> = quarters.iter().flat_map(nodes).collect();
            let values = self.values(&points);
            let means: Vec<f64> = values.chunks_exact(9).map(average).collect();
            let mut next = Vec::new();
            for (k, (_, whole)) in open.iter().enumerate() {
                let of = &means[4 * k..4 * k + 4];
                let halved = 0.25 * of.iter().sum::<f64>();
                if depth == DEEPEST || !halved.is_finite() || (halved - whole).abs() <= tolerance {
                    total += share * halved;
                } else {
                    next.extend((0..4).map(|m| (quarters[4 * k + m], of[m])));
                }
            }
            if next.is_empty() {
                break;
            }
            (open, share) = (next, 0.25 * share);
        }
        total
    }
}

/// Halvings of a cell that a kink runs through.
const DEEPEST: usize = 4;

/// Two rules that agree to this share of the variation in the cell are taken as exact.
const AGREEMENT: f64 = 1e-7;

/// Abscissae (half interval) and weights of the 3-point Gauss-Legendre rule on [-1, 1].
const NODES: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

fn nodes(cell: &Rect) -> [[f64; 2]; 9] {
    let ([x, y], [w, h]) = (cell.centre(), cell.size());
    std::array::from_fn(|k| [x + 0.5 * w * NODES[k / 3].0, y + 0.5 * h * NODES[k % 3].0])
}

fn average(values: &[f64]) -> f64 {
    values.iter().enumerate().map(|(k, value)| NODES[k / 3].1 * NODES[k % 3].1 * value).sum()
}

fn quarters(cell: &Rect) -> [Rect; 4] {
    let [x, y] = cell.centre();
    [
        Rect { min: cell.min, max: [x, y] },
        Rect { min: [x, cell.min[1]], max: [cell.max[0], y] },
        Rect { min: [cell.min[0], y], max: [x, cell.max[1]] },
        Rect { min: [x, y], max: cell.max },
    ]
}
