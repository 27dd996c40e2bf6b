//! A table of scenes from columns of Python's.

use contact_patch::scene::Json;
use contact_patch::table::{Column, Template};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::scene::{Source, wrong};
use crate::work::interruptible;

/// A column: numbers, or JSON texts.
#[derive(FromPyObject)]
pub(crate) enum Cells<'py> {
    Numbers(PyReadonlyArray1<'py, f64>),
    Texts(Vec<String>),
}

/// Numbers as an array, words as a list.
#[derive(IntoPyObject)]
pub(crate) enum Answer<'py> {
    Numbers(Bound<'py, PyArray1<f64>>),
    Words(Bound<'py, PyList>),
}

/// Columns of answers, the number of each row's verdict, and what the verdicts are called.
type Answered<'py> = (Vec<Answer<'py>>, Bound<'py, PyArray1<u8>>, Vec<&'static str>);

/// The answers of a table of scenes: one column an output, the number of each row's verdict, and what the verdicts are called.
#[pyfunction]
pub(crate) fn table<'py>(
    py: Python<'py>,
    source: Source,
    columns: Vec<(String, Cells)>,
    outputs: Vec<String>,
    threads: usize,
    seconds: Option<f64>,
) -> PyResult<Answered<'py>> {
    let (given, watch) = source.given(py)?;
    let pointers: Vec<&str> = columns.iter().map(|(pointer, _)| pointer.as_str()).collect();
    let outputs: Vec<&str> = outputs.iter().map(String::as_str).collect();
    let template = Template::new(&source.text, &pointers, &outputs).map_err(|e| wrong(py, &e))?.with(given);
    let template = template.adjusted(move |settings| {
        settings.seconds = seconds.unwrap_or(settings.seconds);
        Ok(())
    });
    let mut values: Vec<Option<Vec<Json>>> = Vec::with_capacity(columns.len());
    for (pointer, cells) in &columns {
        values.push(match cells {
            Cells::Numbers(_) => None,
            Cells::Texts(texts) => {
                let read = texts.iter().map(|text| Json::parse(text.as_bytes())).collect::<Result<_, _>>();
                Some(read.map_err(|e| wrong(py, &contact_patch::InputError { path: pointer.clone(), ..e }))?)
            }
        });
    }
    let mut cells = Vec::with_capacity(columns.len());
    for ((_, column), values) in columns.iter().zip(&values) {
        cells.push(match (column, values) {
            (Cells::Numbers(numbers), _) => Column::Numbers(numbers.as_slice()?),
            (_, values) => Column::Values(values.as_deref().unwrap_or_default()),
        });
    }
    let words = template.words();
    let answers = interruptible(py, &watch, |interrupt| template.solve(&cells, threads, Some(interrupt)))?
        .map_err(|e| wrong(py, &e))?;
    let mut known: Vec<&'static str> = Vec::new();
    let mut number = |word: &'static str| match known.iter().position(|other| *other == word) {
        Some(k) => k as u8,
        None => {
            known.push(word);
            (known.len() - 1) as u8
        }
    };
    let verdicts: Vec<u8> = answers.verdicts.into_iter().map(&mut number).collect();
    let columns = answers.numbers.into_iter().zip(answers.words).zip(words).map(|((numbers, texts), word)| {
        Ok(if word { Answer::Words(PyList::new(py, texts)?) } else { Answer::Numbers(numbers.into_pyarray(py)) })
    });
    Ok((columns.collect::<PyResult<_>>()?, verdicts.into_pyarray(py), known))
}
