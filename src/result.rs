//! A result as data: one structure a part, written as JSON by [`crate::report`] and read again by [`crate::check`].
//!
//! One object a scene. With one state of loading the values are numbers and objects; with a list or a range of states
//! every value is a list with one entry a state, `null` where that state has none. `scene`, `verdict`, `reason`, `hint`,
//! `left_out` and `remarks` are said once for the whole; `verdicts` and `reasons` are lists, there when a state of
//! several was not solved. What is not known is left out, or `null` in a list; no number is NaN or infinite. A number comes with
//! its verdict: `tolerance_not_reached` and `time_limit` carry the best state that was found, with its true error.
//!
//! | key | value |
//! |---|---|
//! | `scene` | the scene as it was read |
//! | `options` | `{method?, cells?, kernel?, evidence?, tolerance?}`: what was said in place of the scene's own `solve`, by options of the command; left out where nothing was |
//! | `method` | what ran |
//! | `origin` | how the force was found: `{kind, grids?, count?, turned?}`, `kind` one of `closed_form`, `approximate`, `one_grid`, `many_grids`, `separate_contacts`, `edge_fitted`, `no_contact`; `turned`, degrees, where it was solved along other axes: the pressure field is then a mean, over upright cells, of that of turned ones |
//! | `grid` | `{shape, spacing}` of the finest grid |
//! | `depth`, `force`, `stiffness` | approach, normal force, dP/dd |
//! | `map_error` | the part of `force_error` (of the force at the depth, under a force) that the samples of a measured gap leave open; left out where nothing was measured |
//! | `force_error`, `depth_error`, `stiffness_error`, `energy_error`, `area_error` | relative error of each; 0 for what was prescribed, `null` where nothing is known |
//! | `evidence` | what the error of the force is, of the depth under a force: `exact` (rounding), `proved` (of a bracket), `sampled`, `estimated` |
//! | `energy`, `moment`, `tilt`, `stiffness_matrix`, `centre_of_pressure` | where the method gives them |
//! | `bracket` | `{lower, upper, evidence, points_per_cell_side?, depth?, moment?, tilt?, below, above}`: see below |
//! | `patch` | `{area, centroid, regions, max_radius, semi_axes?, angle?, pieces, boundary?}`, boundaries counter-clockwise, holes clockwise; semi-axes and the angle from x (degrees) of ellipses |
//! | `patch.pieces` | `[{area, force, centroid, extent: [[x0, y0], [x1, y1]], max_pressure}]`, largest force first |
//! | `touches_edge` | `null`, or `{edge, share}`: the edge of the data (`map`, `hole`, `region`) that the patch meets, the share of the force on the cells beside it |
//! | `validity` | `{slope, size_over_radius?, pressure_over_modulus}`: small where small-strain half-space theory holds |
//! | `pressure` | `{max, max_error \| singular, mean, at, field?}`: `max` is `null` where the exact one is infinite, at an `edge` or a `tip`, or not given |
//! | `gap` | `{field}`: the gap after loading, when asked for |
//! | `verdict`, `reason`, `hint` | `solved`, or what is wrong in one word and in a sentence, and what to try |
//! | `checks` | `{complementarity, tension, penetration}`, relative, recomputed |
//! | `cost` | `{seconds, unknowns, iterations, operator_products, steps}` |
//! | `left_out`, `remarks` | sentences |
//!
//! `bracket.evidence` is `proved` or `sampled` (at so many points along the side of a cell). `bracket.depth`, `{lower, upper,
//! evidence}`, bounds the depth under a prescribed force (`upper` is `null` when nothing bounds it); `bracket.moment` and `bracket.tilt`,
//! `{lower: [.., ..], upper: [.., ..], evidence}`, the moments at a given tilt and the tilts under given moments: of a polygon that touches
//! everywhere; moments on grids, too, where a bracket is asked for and the gap is no measurement. `below` and `above`, `{theorem,
//! evidence, violation, at, discs, level?, degree?, field?}`, are what proves each side: with Q the force of the field and k the
//! degree (`null` for a flat), the bound is (Q + discs)/(1 - level/depth)^(1 + 1/k) above and (Q - discs)/(1 + level/depth)^(1 + 1/k)
//! below. The fields come with that of the pressure; `contact-patch check` takes them.
//!
//! A field is `{origin, spacing, shape, values}`, with `file` in place of `values` where those are in an array beside the
//! result: `shape` = [nx, ny] cells, `origin` the lower left corner of cell (0, 0), `spacing` the sides of a cell; cell (i, j)
//! is `values[j nx + i]`, with its centre at origin + (i + 1/2, j + 1/2) spacing.
//!
//! Numbers that are not finite are written as `null`; a number that may be so, and one that a check may take away, is an [`Option`].

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::scene::{Json, SolveOptions};

/// A word or a sentence.
pub(crate) type Word<'a> = Cow<'a, str>;

/// The result of a scene; read by [`crate::scene::decode_state`], it holds one state.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Document<'a> {
    #[serde(skip_deserializing)]
    pub scene: Option<&'a Json>,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub options: Option<SolveOptions>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub method: Column<Word<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub origin: Column<Origin<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub grid: Column<FinestGrid>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub depth: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub force: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub force_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub depth_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub stiffness_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub map_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub energy_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub area_error: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub evidence: Column<Word<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub bracket: Column<Bracket<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub stiffness: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub stiffness_matrix: Column<[[f64; 3]; 3]>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub energy: Column<f64>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub tilt: Column<[f64; 2]>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub moment: Column<[f64; 2]>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub centre_of_pressure: Column<[f64; 2]>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub patch: Column<Patch<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub touches_edge: Column<TouchesEdge<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub validity: Column<Validity>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub pressure: Column<Pressure<'a>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub gap: Column<Gap<'a>>,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub curve: Option<serde_json::Value>,
    pub verdict: Word<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Word<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<Word<'a>>,
    #[serde(skip_deserializing, skip_serializing_if = "Vec::is_empty")]
    pub verdicts: Vec<&'a str>,
    #[serde(skip_deserializing, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<Option<&'a str>>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub checks: Column<Residuals>,
    #[serde(skip_serializing_if = "Column::is_left_out")]
    pub cost: Column<Cost>,
    #[serde(skip_deserializing)]
    pub left_out: Vec<&'a str>,
    #[serde(skip_deserializing)]
    pub remarks: Vec<&'a str>,
}

/// The values of one key, an entry a state of loading.
#[derive(Debug, Clone, Deserialize)]
#[serde(from = "Entry<T>", bound(deserialize = "T: Deserialize<'de>"))]
pub(crate) struct Column<T> {
    entries: Vec<Option<Option<T>>>,
    /// Whether there is a list of states: then a list is written.
    many: bool,
}

/// The entry of one state; [`crate::scene::decode_state`] knows it by its name.
#[derive(Deserialize)]
struct Entry<T>(Option<T>);

impl<T> From<Entry<T>> for Column<T> {
    fn from(Entry(value): Entry<T>) -> Self {
        Self { entries: vec![Some(value)], many: false }
    }
}

impl<T> Default for Column<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), many: false }
    }
}

impl<T> Column<T> {
    /// Entries of the states; `None` where a state has no such key, `Some(None)` where it is `null`.
    pub fn new(entries: Vec<Option<Option<T>>>, many: bool) -> Self {
        Self { entries, many }
    }

    /// Whether no state has the key.
    fn is_left_out(&self) -> bool {
        self.entries.iter().all(Option::is_none)
    }

    /// The value of the one state.
    pub fn one(&self) -> Option<&T> {
        self.entries.first()?.as_ref()?.as_ref()
    }

    /// The value of the one state.
    pub fn one_mut(&mut self) -> Option<&mut T> {
        self.entries.first_mut()?.as_mut()?.as_mut()
    }
}

impl<T: Serialize> Serialize for Column<T> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        if self.many {
            to.collect_seq(self.entries.iter().map(|entry| entry.as_ref().and_then(Option::as_ref)))
        } else {
            self.one().serialize(to)
        }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Origin<'a> {
    pub kind: Word<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grids: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned: Option<f64>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FinestGrid {
    pub shape: [usize; 2],
    pub spacing: [f64; 2],
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Bracket<'a> {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    #[serde(default)]
    pub evidence: Word<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points_per_cell_side: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthBracket<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment: Option<PairBracket<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<PairBracket<'a>>,
    pub below: Option<Side<'a>>,
    pub above: Option<Side<'a>>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct DepthBracket<'a> {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    #[serde(default)]
    pub evidence: Word<'a>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PairBracket<'a> {
    pub lower: [f64; 2],
    pub upper: [f64; 2],
    #[serde(default)]
    pub evidence: Word<'a>,
}

impl PairBracket<'_> {
    /// Whether it holds other bounds, but for some room.
    pub fn holds(&self, bounds: [[f64; 2]; 2], room: impl Fn([f64; 2]) -> f64) -> bool {
        (0..2).all(|m| {
            let ([low, high], room) = (bounds[m], room(bounds[m]));
            self.lower[m] <= low + room && high - room <= self.upper[m]
        })
    }

    /// In words.
    pub fn told(&self, path: &str) -> String {
        format!("{path}, {:?} to {:?},", self.lower, self.upper)
    }
}

/// What proves a side of a bracket.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Side<'a> {
    pub theorem: Word<'a>,
    pub evidence: Word<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub violation: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discs: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degree: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<Field<'a>>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Patch<'a> {
    pub area: Option<f64>,
    pub centroid: Option<[f64; 2]>,
    pub regions: Option<usize>,
    pub max_radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub semi_axes: Option<[f64; 2]>,
    /// From x to the longer axis, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    pub pieces: Option<Vec<Piece>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<Cow<'a, [Vec<[f64; 2]>]>>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Piece {
    pub area: f64,
    pub force: f64,
    pub centroid: [f64; 2],
    pub extent: [[f64; 2]; 2],
    pub max_pressure: Option<f64>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct TouchesEdge<'a> {
    pub edge: Word<'a>,
    pub share: Option<f64>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Validity {
    pub slope: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_over_radius: Option<f64>,
    pub pressure_over_modulus: Option<f64>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Pressure<'a> {
    pub max: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular: Option<Word<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
    pub mean: Option<f64>,
    pub at: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field: Option<Field<'a>>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Gap<'a> {
    pub field: Option<Field<'a>>,
}

/// Values in the cells of a grid. An infinite one, of a gap without material, is `null`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Field<'a> {
    pub origin: [f64; 2],
    pub spacing: [f64; 2],
    pub shape: [usize; 2],
    #[serde(default, deserialize_with = "with_infinities", skip_serializing_if = "Option::is_none")]
    pub values: Option<Cow<'a, [f64]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<Word<'a>>,
}

fn with_infinities<'de, 'a, D: Deserializer<'de>>(from: D) -> Result<Option<Cow<'a, [f64]>>, D::Error> {
    let values = Option::<Vec<Option<f64>>>::deserialize(from)?;
    Ok(values.map(|values| values.into_iter().map(|value| value.unwrap_or(f64::INFINITY)).collect()))
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Residuals {
    pub complementarity: Option<f64>,
    pub tension: Option<f64>,
    pub penetration: Option<f64>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Cost {
    pub seconds: Option<f64>,
    pub unknowns: usize,
    pub iterations: usize,
    pub operator_products: usize,
    pub steps: usize,
}
