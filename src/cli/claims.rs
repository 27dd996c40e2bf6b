//! What a result file claims about a state, and whether it holds.

use crate::bracket::{self, Claim, Repair, Verification};
use crate::contact::Load;
use crate::error::InputError;
use crate::gap::{AnyGap, Gap, Reach};
use crate::grid::{Grid, Pressure};
use crate::scene::{Json, Scene};

/// Beside the field of contacts that were solved apart.
const APART: &str = "the grid between the contacts";

/// Among the remarks where force, moments and area come from many grids.
const LIMIT: &str = crate::edges::REMARK;

/// Whether one of the sentences under a key begins so.
fn says(result: &Json, key: &str, beginning: &str) -> bool {
    let begins = |sentence: &Json| matches!(sentence, Json::String(text) if text.starts_with(beginning));
    matches!(result.get(key), Some(Json::Array(all)) if all.iter().any(begins))
}

/// What a result says about one state of loading.
pub(super) struct State {
    method: String,
    depth: f64,
    tilt: [f64; 2],
    force: f64,
    force_error: f64,
    moment: Option<Vec<f64>>,
    area: f64,
    mean: Option<f64>,
    max: Option<f64>,
    pub field: Option<Pressure>,
    /// Where the values of the field are, when not in the result.
    pub field_file: Option<String>,
    /// Whether the field is a mean of several, each on a grid of its own.
    apart: bool,
    /// Whether force, moments and area are the limit of many grids, of which the field is the finest.
    limit: bool,
    bracket: Option<Bounds>,
}

/// A bracket as the result gives it.
struct Bounds {
    lower: f64,
    upper: f64,
    above: Option<Proof>,
    below: Option<Proof>,
}

struct Proof {
    theorem: String,
    proved: bool,
    repair: Repair,
    pressure: Option<Pressure>,
}

impl State {
    pub fn read(result: &Json, step: Option<usize>, steps: usize) -> Result<Self, InputError> {
        // In a list the values of one state.
        let of = |key: &str| -> Result<Option<&Json>, InputError> {
            match (result.get(key), step) {
                (Some(Json::Array(all)), Some(k)) if all.len() == steps => Ok(Some(&all[k])),
                (Some(other), Some(_)) => {
                    Err(InputError::new(key, other.brief(), format!("a list of {steps}, one entry a state of loading")))
                }
                (value, None) => Ok(value),
                (None, Some(_)) => Ok(None),
            }
        };
        let need = |key: &str, allowed: &str| of(key)?.ok_or_else(|| missing(key, allowed));
        let patch = need("patch", "the patch of the result")?;
        let pressure = need("pressure", "the pressure of the result")?;
        let inside = |json: &Json, key: &str| optional(json, key);
        let tilt = match of("tilt")? {
            Some(tilt) => pair(tilt, "tilt")?,
            None => [0.0; 2],
        };
        let bracket = of("bracket")?.filter(|b| **b != Json::Null).map(Bounds::read).transpose()?;
        Ok(Self {
            method: match need("method", "the method that ran")? {
                Json::String(name) => name.clone(),
                other => return Err(InputError::new("method", other.brief(), "a string")),
            },
            depth: number(need("depth", "a number")?, "depth")?,
            tilt,
            force: number(need("force", "a number")?, "force")?,
            force_error: of("force_error")?.map_or(Ok(0.0), |e| number(e, "force_error"))?,
            moment: of("moment")?.filter(|m| **m != Json::Null).map(|m| numbers(m, "moment")).transpose()?,
            area: number(patch.get("area").ok_or_else(|| missing("patch.area", "a number"))?, "patch.area")?,
            mean: inside(pressure, "mean")?,
            max: inside(pressure, "max")?,
            field: pressure.get("field").map(|f| field(f, "pressure.field")).transpose()?,
            field_file: pressure
                .get("field")
                .filter(|f| f.get("values").is_none())
                .map(|f| string(f, "file"))
                .transpose()?,
            apart: says(result, "left_out", APART),
            limit: says(result, "remarks", LIMIT),
            bracket,
        })
    }

    pub fn check(&self, scene: &Scene, load: Load) -> Verification {
        let mut found = Verification::default();
        let gap = scene.contact.tilted_gap(self.tilt);
        self.agrees(load, &mut found);
        if self.force == 0.0 {
            let apart = gap.reach(self.depth) == Reach::Nowhere || crate::overlap::least(&gap).1 >= self.depth;
            found.require(apart, "no force: the undeformed bodies do not overlap");
            return found;
        }
        let modulus = scene.contact.modulus();
        match &self.field {
            Some(_) if self.apart => found.require(
                false,
                "the field is the contact on one grid; here it is a mean of several, one for each of contacts far apart, and shows \
                 nothing: solve with \"cells\" in \"solve\" for one grid",
            ),
            Some(field) => {
                let on_grid = self.method == "fft" || self.method == "qp";
                found.join(bracket::check_field(&gap, modulus, self.depth, field, self.force, on_grid));
                self.field_agrees(field, on_grid, &mut found);
            }
            None if self.bracket.as_ref().is_some_and(Bounds::needs_no_field) => {}
            None => found.require(
                false,
                "there is a pressure field to check; none is in the result: solve with \"pressure\" in \"output\"",
            ),
        }
        if let Some(bounds) = &self.bracket {
            let force_driven = !matches!(load, Load::Depth(_) | Load::Tilted { .. });
            let room = self.force_error * self.force + if force_driven { 0.01 * self.force } else { 0.0 };
            let exact = self.method != "ritz" && self.method != "fabrikant";
            found.require(
                !exact || (bounds.lower - room <= self.force && self.force <= bounds.upper + room),
                format!("the force {:e} lies in the bracket, but for its own error", self.force),
            );
            found.join(bounds.check(&gap, scene, self.depth));
        }
        found
    }

    /// The figures of a result say the same thing.
    fn agrees(&self, load: Load, found: &mut Verification) {
        let close = |a: f64, b: f64, room: f64| (a - b).abs() <= room * a.abs().max(b.abs());
        let as_loaded = match load {
            Load::Depth(depth) => close(self.depth, depth, 1e-12) && self.tilt == [0.0; 2],
            Load::Tilted { depth, tilt } => close(self.depth, depth, 1e-12) && self.tilt == tilt,
            Load::Force(force) => close(self.force, force, 1e-9),
            // Balanced at a tilt of its own, as closely as the force is known there.
            Load::ForceMoment { force, .. } => close(self.force, force, 1e-9 + self.force_error),
        };
        found.require(as_loaded, format!("depth {:e} and force {:e} are those of the loading", self.depth, self.force));
        if let Some(mean) = self.mean {
            let room = if self.method == "closed_form" { 1e-9 } else { 1e-6 };
            found.require(
                close(mean * self.area, self.force, room),
                format!("mean pressure {mean:e} times area {:e} is the force", self.area),
            );
        }
    }

    fn field_agrees(&self, field: &Pressure, on_grid: bool, found: &mut Verification) {
        if let Some(max) = self.max.filter(|_| on_grid) {
            let highest = field.values.iter().copied().fold(0.0, f64::max);
            found.require(
                (highest - max).abs() <= 1e-9 * max,
                format!("the largest pressure {max:e} is that of the field"),
            );
        }
        if let (Some(moment), true) = (&self.moment, on_grid && self.tilt == [0.0; 2]) {
            let area = field.grid.cell_area();
            let (mut sums, mut size) = ([0.0; 2], 0.0);
            for (k, p) in field.values.iter().enumerate() {
                let [x, y] = field.grid.centre_of(k);
                sums = [sums[0] + p * area * y, sums[1] - p * area * x];
                size += p * area * x.hypot(y);
            }
            // The force may be the limit of several grids: it acts where the field's does. Where edges fall between cells, that is
            // off by where in a cell they lie.
            let [hx, hy] = field.grid.spacing;
            let room = 1e-6 * size + if self.limit { hx.max(hy) * self.force } else { 0.0 };
            let more = self.force / field.force();
            let holds = moment.iter().zip(sums).all(|(m, s)| (m - more * s).abs() <= room);
            found.require(holds, format!("the moments {moment:?} are those of the field"));
        }
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

    /// Whether the theorems on both sides do without a pressure field.
    fn needs_no_field(&self) -> bool {
        let without = |p: &Option<Proof>| {
            p.as_ref().is_some_and(|p| matches!(p.theorem.as_str(), "ellipse" | "fabrikant" | "comparison"))
        };
        without(&self.above) && without(&self.below)
    }

    fn check(&self, gap: &AnyGap, scene: &Scene, depth: f64) -> Verification {
        let modulus = scene.contact.modulus();
        if self.needs_no_field() {
            return self.check_again(gap, scene, depth);
        }
        let proofs = (self.above.as_ref(), self.below.as_ref());
        let (Some(Proof { pressure: Some(q), repair, proved, .. }), Some(below)) = proofs else {
            return self.unproved();
        };
        let Some(m) = &below.pressure else { return self.unproved() };
        let upper = Claim { force: self.upper, repair: *repair, proved: *proved, pressure: q };
        let lower = Claim { force: self.lower, repair: below.repair, proved: below.proved, pressure: m };
        bracket::check_claims(gap, modulus, depth, &upper, &lower)
    }

    fn unproved(&self) -> Verification {
        let mut found = Verification::default();
        let what = format!("the bracket [{:e}, {:e}] comes with the fields that prove it", self.lower, self.upper);
        found.require(false, what);
        found
    }

    /// A bracket without fields: its theorems are applied again.
    fn check_again(&self, gap: &AnyGap, scene: &Scene, depth: f64) -> Verification {
        let mut found = Verification::default();
        let own = bracket::approximate(gap, scene.contact.modulus(), depth);
        let holds = own.as_ref().is_ok_and(|own| {
            let room = 1e-9 * own.upper();
            self.lower <= self.upper && self.lower <= own.lower() + room && self.upper >= own.upper() - room
        });
        found.require(holds, format!("the bracket [{:e}, {:e}] follows from its theorems", self.lower, self.upper));
        found
    }
}

impl Proof {
    fn read(json: &Json, path: &str) -> Result<Self, InputError> {
        let at = |key: &str| format!("{path}.{key}");
        let level = optional(json, "level")?.unwrap_or(0.0);
        let degree = if level > 0.0 { Some(optional(json, "degree")?.unwrap_or(f64::INFINITY)) } else { None };
        Ok(Self {
            theorem: string(json, "theorem").map_err(|e| e.within(path))?,
            proved: string(json, "evidence").map_err(|e| e.within(path))? == "proved",
            repair: Repair { discs: optional(json, "discs")?.unwrap_or(0.0), level, degree },
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
    let values = if elsewhere { Vec::new() } else { part("values").and_then(|(values, at)| numbers(values, &at))? };
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
fn optional(json: &Json, key: &str) -> Result<Option<f64>, InputError> {
    json.get(key).filter(|v| **v != Json::Null).map(|v| number(v, key)).transpose()
}

fn numbers(json: &Json, path: &str) -> Result<Vec<f64>, InputError> {
    match json {
        Json::Array(items) => items.iter().enumerate().map(|(k, v)| number(v, &format!("{path}[{k}]"))).collect(),
        other => Err(InputError::new(path, other.brief(), "a list of numbers")),
    }
}

fn pair(json: &Json, path: &str) -> Result<[f64; 2], InputError> {
    let all = numbers(json, path)?;
    <[f64; 2]>::try_from(all).map_err(|all| InputError::new(path, format!("a list of {}", all.len()), "two numbers"))
}

pub(super) fn string(json: &Json, key: &str) -> Result<String, InputError> {
    match json.get(key) {
        Some(Json::String(text)) => Ok(text.clone()),
        Some(other) => Err(InputError::new(key, other.brief(), "a string")),
        None => Err(missing(key, "a string")),
    }
}

pub(super) fn missing(path: &str, allowed: &str) -> InputError {
    InputError::new(path, "nothing", allowed)
}
