//! What a result says about one state of loading; and which of its numbers a check has used.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crate::bracket::Repair;
use crate::error::InputError;
use crate::grid::{Grid, Pressure};
use crate::result::{self, Column, Document};
use crate::scene::{Json, decode_state};

/// Most cells along a side of a field.
const MOST_CELLS: usize = 1_000_000;

/// A number of a result, or a list of them: where it stands, how it is read, how it is taken away.
#[derive(Clone, Copy)]
pub(super) struct Key<T> {
    pub path: &'static str,
    pub of: fn(&Document<'static>) -> Option<T>,
    pub remove: fn(&mut Document<'static>),
}

/// The [`Key`] at a path into [`Document`]: the names of the fields are the keys of the result.
macro_rules! key {
    ($outer:ident) => {
        $crate::check::result::Key {
            path: stringify!($outer),
            of: |said| said.$outer.one().cloned(),
            remove: |said| said.$outer = Default::default(),
        }
    };
    ($outer:ident.$inner:ident $(as $number:ty)?) => {
        $crate::check::result::Key {
            path: concat!(stringify!($outer), ".", stringify!($inner)),
            of: |said| said.$outer.one().and_then(|outer| outer.$inner.clone()) $(.map(|inner| inner as $number))?,
            remove: |said| {
                if let Some(outer) = said.$outer.one_mut() {
                    outer.$inner = None;
                }
            },
        }
    };
}
pub(super) use key;

/// What a result says about one state of loading.
pub struct State<'a> {
    document: &'a Json,
    /// Which of how many states; `None` where there is one.
    step: Option<[usize; 2]>,
    pub(super) said: Document<'static>,
    used: Mutex<Vec<fn(&mut Document<'static>)>>,
    pub(super) method: String,
    pub(super) origin: String,
    pub(super) depth: f64,
    pub(super) tilt: [f64; 2],
    pub(super) force: f64,
    pub(super) force_error: Option<f64>,
    pub(super) depth_error: Option<f64>,
    pub(super) area: f64,
    /// The pressure field, where there is one.
    pub field: Option<Pressure>,
    /// The file with the values of the field, where they are not in the result.
    pub field_file: Option<String>,
    pub(super) bracket: Option<Bounds>,
}

/// A bracket as the result gives it.
pub(super) struct Bounds {
    pub lower: f64,
    pub upper: f64,
    pub above: Option<Proof>,
    pub below: Option<Proof>,
}

/// What is said to prove a side.
pub(super) struct Proof {
    pub theorem: String,
    pub proved: bool,
    pub repair: Repair,
    pub pressure: Option<Pressure>,
}

impl<'a> State<'a> {
    /// The state of a result, `step` = (which, of how many) where the result is of a list.
    ///
    /// # Errors
    /// Names the path of what is missing or has another type.
    pub fn read(result: &'a Json, step: Option<[usize; 2]>) -> Result<Self, InputError> {
        let said: Document<'static> = decode_state(result, step)?;
        let needed = |key: Key<f64>| (key.of)(&said).ok_or_else(|| missing(key.path, "a number"));
        // A result of version 0.1.0 says nothing of the kind.
        let origin = object("origin", &said.origin)?;
        object("patch", &said.patch)?;
        let pressure = object("pressure", &said.pressure)?;
        Ok(Self {
            document: result,
            step,
            used: Mutex::default(),
            method: said.method.one().ok_or_else(|| missing("method", "a string"))?.to_string(),
            origin: origin.kind.to_string(),
            depth: needed(key!(depth))?,
            tilt: said.tilt.one().copied().unwrap_or_default(),
            force: needed(key!(force))?,
            force_error: said.force_error.one().copied(),
            depth_error: said.depth_error.one().copied(),
            area: needed(key!(patch.area))?,
            field: pressure.field.as_ref().map(|field| on_grid(field, "pressure.field")).transpose()?,
            field_file: pressure
                .field
                .as_ref()
                .filter(|field| field.values.is_none())
                .and_then(|field| field.file.as_ref().map(ToString::to_string)),
            bracket: said.bracket.one().map(Bounds::read).transpose()?,
            said,
        })
    }

    /// The value of a key; `None` where it is left out or null.
    pub(super) fn get<T>(&self, key: Key<T>) -> Option<T> {
        (key.of)(&self.said)
    }

    /// Notes that a check has used the numbers at a key, and all below it.
    pub(super) fn use_up<T>(&self, key: Key<T>) {
        self.use_all(key.remove);
    }

    /// Notes that a check has used the numbers that this removes.
    pub(super) fn use_all(&self, remove: fn(&mut Document<'static>)) {
        self.used.lock().unwrap_or_else(PoisonError::into_inner).push(remove);
    }

    /// Paths of the numbers that no check has used, those of unknown keys among them.
    pub(super) fn unused(&self) -> Vec<String> {
        let paths = |said: &Document| {
            let text = serde_json::to_vec(said).unwrap_or_default();
            Json::parse(&text).map_or_else(|_| Vec::new(), |json| numbers(&json, None))
        };
        let mut left = self.said.clone();
        self.used.lock().unwrap_or_else(PoisonError::into_inner).iter().for_each(|remove| remove(&mut left));
        let (known, left): (BTreeSet<_>, BTreeSet<_>) =
            (paths(&self.said).into_iter().collect(), paths(&left).into_iter().collect());
        let mut found = numbers(self.document, self.step);
        found.retain(|path| left.contains(path) || !known.contains(path));
        found
    }
}

/// Paths of the numbers that a result gives for a state.
fn numbers(result: &Json, step: Option<[usize; 2]>) -> Vec<String> {
    let mut found = Vec::new();
    let Json::Object(entries) = result else { return found };
    for (key, value) in entries.iter().filter(|(key, _)| key != "scene") {
        let own = match (value, step) {
            (Json::Array(all), Some([k, steps])) if all.len() == steps => &all[k],
            _ => value,
        };
        leaves(own, key, &mut found);
    }
    found
}

/// Paths of numbers and lists of them.
fn leaves(value: &Json, path: &str, found: &mut Vec<String>) {
    match value {
        Json::Number(_) => found.push(path.to_owned()),
        Json::Array(items) if items.iter().any(|item| !matches!(item, Json::String(_) | Json::Bool(_))) => {
            found.push(path.to_owned());
        }
        Json::Object(entries) => entries.iter().for_each(|(key, value)| leaves(value, &format!("{path}.{key}"), found)),
        _ => {}
    }
}

fn object<'a, T>(path: &str, column: &'a Column<T>) -> Result<&'a T, InputError> {
    column.one().ok_or_else(|| missing(path, "an object"))
}

impl Bounds {
    fn read(said: &result::Bracket) -> Result<Self, InputError> {
        let bound = |key: &str, value: Option<f64>| value.ok_or_else(|| missing(&format!("bracket.{key}"), "a number"));
        let side = |key: &str, side: &Option<result::Side>| {
            side.as_ref().map(|side| Proof::read(side, &format!("bracket.{key}"))).transpose()
        };
        Ok(Self {
            lower: bound("lower", said.lower)?,
            upper: bound("upper", said.upper)?,
            above: side("above", &said.above)?,
            below: side("below", &said.below)?,
        })
    }
}

impl Proof {
    fn read(said: &result::Side, path: &str) -> Result<Self, InputError> {
        let level = said.level.unwrap_or(0.0);
        let degree = (level > 0.0).then(|| said.degree.unwrap_or(f64::INFINITY));
        Ok(Self {
            theorem: said.theorem.to_string(),
            proved: said.evidence == "proved",
            repair: Repair { discs: said.discs.unwrap_or(0.0), level, degree },
            pressure: said.field.as_ref().map(|field| on_grid(field, &format!("{path}.field"))).transpose()?,
        })
    }
}

/// A field with as many values as cells, or with none where they are in a file.
pub(super) fn on_grid(said: &result::Field, path: &str) -> Result<Pressure, InputError> {
    let result::Field { origin, spacing, shape, ref values, ref file } = *said;
    let values = values.as_deref().map(<[f64]>::to_vec);
    if values.is_none() && file.is_none() {
        return Err(missing(&format!("{path}.values"), "a field has origin, spacing, shape and values"));
    }
    let cells = shape.iter().all(|n| (1..=MOST_CELLS).contains(n)).then(|| shape[0] * shape[1]);
    if cells.is_none() || values.as_ref().is_some_and(|values| cells != Some(values.len())) {
        let given = format!("{shape:?} with {} values", values.map_or(0, |values| values.len()));
        return Err(InputError::new(format!("{path}.shape"), given, "[nx, ny] with nx times ny values"));
    }
    if !spacing.iter().all(|h| *h > 0.0) {
        return Err(InputError::new(format!("{path}.spacing"), format!("{spacing:?}"), "two numbers greater than 0"));
    }
    Ok(Pressure { grid: Grid { origin, spacing, shape }, values: values.unwrap_or_default() })
}

fn missing(path: &str, allowed: &str) -> InputError {
    InputError::new(path, "nothing", allowed)
}
