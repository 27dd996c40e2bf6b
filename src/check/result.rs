//! What a result says about one state of loading, read from its JSON; and which of its numbers a check has used.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::bracket::Repair;
use crate::error::InputError;
use crate::grid::{Grid, Pressure};
use crate::scene::Json;

/// Keys that are said once for all states.
const ONCE: [&str; 9] = ["scene", "verdict", "verdicts", "reason", "reasons", "hint", "left_out", "remarks", "curve"];

/// The numbers of one state.
pub(super) struct Reader<'a> {
    result: &'a Json,
    /// Which of how many states; `None` where there is one.
    step: Option<[usize; 2]>,
    used: Mutex<BTreeSet<String>>,
}

impl<'a> Reader<'a> {
    fn new(result: &'a Json, step: Option<[usize; 2]>) -> Self {
        Self { result, step, used: Mutex::default() }
    }

    /// The value at a path of keys; `None` where it is left out or null.
    pub fn get(&self, path: &str) -> Result<Option<&'a Json>, InputError> {
        let mut keys = path.split('.');
        let first = keys.next().unwrap_or_default();
        let mut value = match (self.result.get(first), self.step) {
            (Some(Json::Array(all)), Some([k, steps])) if all.len() == steps => &all[k],
            (Some(other), Some([_, steps])) if !ONCE.contains(&first) => {
                let allowed = format!("a list of {steps}, one entry a state of loading");
                return Err(InputError::new(first, other.brief(), allowed));
            }
            (Some(value), _) => value,
            (None, _) => return Ok(None),
        };
        for key in keys {
            match value.get(key) {
                Some(inner) => value = inner,
                None => return Ok(None),
            }
        }
        Ok(Some(value).filter(|value| **value != Json::Null))
    }

    pub fn number(&self, path: &str) -> Result<Option<f64>, InputError> {
        self.get(path)?.map(|value| number(value, path)).transpose()
    }

    pub fn numbers(&self, path: &str) -> Result<Option<Vec<f64>>, InputError> {
        self.get(path)?.map(|value| numbers(value, path)).transpose()
    }

    pub fn pair(&self, path: &str) -> Result<Option<[f64; 2]>, InputError> {
        self.get(path)?.map(|value| pair(value, path)).transpose()
    }

    /// A number that has to be there.
    pub fn need(&self, path: &str) -> Result<f64, InputError> {
        self.number(path)?.ok_or_else(|| missing(path, "a number"))
    }

    /// A word that has to be there.
    pub fn word(&self, path: &str) -> Result<&'a str, InputError> {
        match self.get(path)? {
            Some(Json::String(text)) => Ok(text),
            Some(other) => Err(InputError::new(path, other.brief(), "a string")),
            None => Err(missing(path, "a string")),
        }
    }

    /// A pressure or gap field; infinite values are null.
    pub fn field(&self, path: &str) -> Result<Option<Pressure>, InputError> {
        self.get(path)?.map(|value| field(value, path)).transpose()
    }

    /// Notes that a check has used the numbers at a path, and all below it.
    pub fn use_up(&self, path: &str) {
        self.used().insert(path.to_owned());
    }

    fn used(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Paths of the numbers that no check has used.
    pub fn unused(&self) -> Vec<String> {
        let mut found = Vec::new();
        if let Json::Object(entries) = self.result {
            for (key, _) in entries.iter().filter(|(key, _)| !ONCE.contains(&key.as_str()) || key == "curve") {
                if let Ok(Some(value)) = self.get(key) {
                    leaves(value, key, &mut found);
                }
            }
        }
        let used = self.used();
        let below = |path: &str, above: &str| {
            path.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        found.retain(|path| !used.iter().any(|above| below(path, above)));
        found
    }
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

/// What a result says about one state of loading.
pub struct State<'a> {
    pub(super) reader: Reader<'a>,
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
        let reader = Reader::new(result, step);
        let object = |path: &str| match reader.get(path)? {
            Some(Json::Object(_)) => Ok(()),
            Some(other) => Err(InputError::new(path, other.brief(), "an object")),
            None => Err(missing(path, "an object")),
        };
        // A result of an older version says nothing of the kind.
        object("origin")?;
        object("patch")?;
        object("pressure")?;
        let values = reader.get("pressure.field.values")?;
        let elsewhere = values.is_none() && reader.get("pressure.field")?.is_some();
        Ok(Self {
            method: reader.word("method")?.to_owned(),
            origin: reader.word("origin.kind")?.to_owned(),
            depth: reader.need("depth")?,
            tilt: reader.pair("tilt")?.unwrap_or_default(),
            force: reader.need("force")?,
            force_error: reader.number("force_error")?,
            depth_error: reader.number("depth_error")?,
            area: reader.need("patch.area")?,
            field: reader.field("pressure.field")?,
            field_file: elsewhere.then(|| reader.word("pressure.field.file").map(str::to_owned)).transpose()?,
            bracket: reader.get("bracket")?.map(Bounds::read).transpose()?,
            reader,
        })
    }
}

impl Bounds {
    fn read(json: &Json) -> Result<Self, InputError> {
        let bound = |key: &str| {
            let path = format!("bracket.{key}");
            number(json.get(key).ok_or_else(|| missing(&path, "a number"))?, &path)
        };
        let side = |key: &str| json.get(key).map(|side| Proof::read(side, &format!("bracket.{key}"))).transpose();
        Ok(Self { lower: bound("lower")?, upper: bound("upper")?, above: side("above")?, below: side("below")? })
    }
}

impl Proof {
    fn read(json: &Json, path: &str) -> Result<Self, InputError> {
        let at = |key: &str| format!("{path}.{key}");
        let level = optional(json, "level", path)?.unwrap_or(0.0);
        let degree = if level > 0.0 { Some(optional(json, "degree", path)?.unwrap_or(f64::INFINITY)) } else { None };
        let word = |key: &str| match json.get(key) {
            Some(Json::String(text)) => Ok(text.clone()),
            other => Err(InputError::new(at(key), other.map_or("nothing".to_owned(), Json::brief), "a string")),
        };
        Ok(Self {
            theorem: word("theorem")?,
            proved: word("evidence")? == "proved",
            repair: Repair { discs: optional(json, "discs", path)?.unwrap_or(0.0), level, degree },
            pressure: json.get("field").map(|f| field(f, &at("field"))).transpose()?,
        })
    }
}

fn field(json: &Json, path: &str) -> Result<Pressure, InputError> {
    let part = |key: &str| {
        let at = format!("{path}.{key}");
        json.get(key).ok_or_else(|| missing(&at, "a field has origin, spacing, shape and values")).map(|v| (v, at))
    };
    let two = |key: &str| part(key).and_then(|(v, at)| pair(v, &at));
    let (origin, spacing, shape) = (two("origin")?, two("spacing")?, two("shape")?);
    let elsewhere = json.get("file").is_some() && json.get("values").is_none();
    let values = if elsewhere { Vec::new() } else { part("values").and_then(|(values, at)| with_gaps(values, &at))? };
    let whole = shape.iter().all(|n| *n >= 1.0 && *n <= 1e6 && n.fract() == 0.0);
    if !whole || !(elsewhere || shape[0] * shape[1] == values.len() as f64) {
        let given = format!("{shape:?} with {} values", values.len());
        return Err(InputError::new(format!("{path}.shape"), given, "[nx, ny] with nx times ny values"));
    }
    if !spacing.iter().all(|h| *h > 0.0) {
        return Err(InputError::new(format!("{path}.spacing"), format!("{spacing:?}"), "two numbers greater than 0"));
    }
    Ok(Pressure { grid: Grid { origin, spacing, shape: shape.map(|n| n as usize) }, values })
}

fn number(json: &Json, path: &str) -> Result<f64, InputError> {
    match json {
        Json::Number(n) => n.as_f64().ok_or_else(|| InputError::new(path, n, "a finite number")),
        other => Err(InputError::new(path, other.brief(), "a number")),
    }
}

/// The number under a key, when it is there and not null.
fn optional(json: &Json, key: &str, path: &str) -> Result<Option<f64>, InputError> {
    json.get(key).filter(|v| **v != Json::Null).map(|v| number(v, &format!("{path}.{key}"))).transpose()
}

fn numbers(json: &Json, path: &str) -> Result<Vec<f64>, InputError> {
    match json {
        Json::Array(items) => items.iter().enumerate().map(|(k, v)| number(v, &format!("{path}[{k}]"))).collect(),
        other => Err(InputError::new(path, other.brief(), "a list of numbers")),
    }
}

/// Numbers, and null where they are infinite.
fn with_gaps(json: &Json, path: &str) -> Result<Vec<f64>, InputError> {
    let each = |(k, v): (usize, &Json)| match v {
        Json::Null => Ok(f64::INFINITY),
        v => number(v, &format!("{path}[{k}]")),
    };
    match json {
        Json::Array(items) => items.iter().enumerate().map(each).collect(),
        other => Err(InputError::new(path, other.brief(), "a list of numbers")),
    }
}

fn pair(json: &Json, path: &str) -> Result<[f64; 2], InputError> {
    let all = numbers(json, path)?;
    <[f64; 2]>::try_from(all).map_err(|all| InputError::new(path, format!("a list of {}", all.len()), "two numbers"))
}

pub(super) fn missing(path: &str, allowed: &str) -> InputError {
    InputError::new(path, "nothing", allowed)
}
