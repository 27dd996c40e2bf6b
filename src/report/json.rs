//! The result as JSON.
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
//! | `method` | what ran |
//! | `origin` | how the force was found: `{kind, grids?, count?}`, `kind` one of `closed_form`, `approximate`, `one_grid`, `many_grids`, `separate_contacts`, `edge_fitted`, `no_contact` |
//! | `grid` | `{shape, spacing}` of the finest grid |
//! | `depth`, `force`, `stiffness` | approach, normal force, dP/dd |
//! | `map_error` | the part of `force_error` (of the force at the depth, under a force) that the samples of a measured gap leave open; left out where nothing was measured |
//! | `force_error`, `depth_error`, `stiffness_error`, `energy_error`, `area_error` | relative error of each; 0 for what was prescribed, `null` where nothing is known |
//! | `evidence` | what the error of the force is, of the depth under a force: `exact` (rounding), `proved` (of a bracket), `sampled`, `estimated` |
//! | `energy`, `moment`, `tilt`, `stiffness_matrix`, `centre_of_pressure` | where the method gives them |
//! | `bracket` | `{lower, upper, evidence, points_per_cell_side?, depth?, below, above}`: see below |
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
//! evidence}`, bounds the depth under a prescribed force (`upper` is `null` when nothing bounds it). `below` and `above`, `{theorem,
//! evidence, violation, at, discs, level?, degree?, field?}`, are what proves each side: with Q the force of the field and k the
//! degree (`null` for a flat), the bound is (Q + discs)/(1 - level/depth)^(1 + 1/k) above and (Q - discs)/(1 + level/depth)^(1 + 1/k)
//! below. The fields come with that of the pressure; `contact-patch check` takes them.
//!
//! A field is `{origin, spacing, shape, values}`, with `file` in place of `values` where those are in an array beside the
//! result: `shape` = [nx, ny] cells, `origin` the lower left corner of cell (0, 0), `spacing` the sides of a cell; cell (i, j)
//! is `values[j nx + i]`, with its centre at origin + (i + 1/2, j + 1/2) spacing.

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use super::{Step, centre_of_pressure, numbers, said_once};
use crate::bracket::{DepthBracket, Evidence, ForceBracket, Side, Theorem};
use crate::curve::Curve;
use crate::grid::Grid;
use crate::problem::{Loading, Settings};
use crate::scene::Scene;
use crate::solution::{Origin, Piece, Solution, TouchesEdge, Validity};

/// A scene with its answers, ready to be written.
#[derive(Clone)]
pub struct Outcome<'a> {
    scene: &'a Scene,
    steps: &'a [Step],
    curve: Option<serde_json::Value>,
    fields: Fields<'a>,
}

/// Where the values of the fields of pressure and gap are.
#[derive(Clone, Copy)]
enum Fields<'a> {
    /// In the result.
    Here,
    /// Those of the pressure in a file of their own.
    In(&'a str),
    /// With the caller.
    Elsewhere,
}

impl<'a> Outcome<'a> {
    /// The same with the values of the pressure field left out and this file named in their place (`pressure.field.file`).
    #[must_use]
    pub fn with_field_in(self, file: &'a str) -> Self {
        Self { fields: Fields::In(file), ..self }
    }

    /// The same with the values of the fields of pressure and gap left out: the caller has them, in the steps.
    #[must_use]
    pub fn without_fields(self) -> Self {
        Self { fields: Fields::Elsewhere, ..self }
    }
}

/// The result of `scene`; `steps` as [`crate::solve`] returned them.
///
/// ```
/// use contact_patch::{Scene, report, solve};
/// let scene = Scene::from_json(br#"{"effective_modulus": 1.0, "gap": {"kind": "sphere", "radius": 1.0},
///     "loading": {"depth": -0.5}}"#)?;
/// let steps = solve(&scene.contact, &scene.settings);
/// let text = serde_json::to_string(&report::json(&scene, &steps))?;
/// assert!(text.contains(r#""verdict":"solved""#) && text.contains(r#""force":0.0"#));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn json<'a>(scene: &'a Scene, steps: &'a [Step]) -> Outcome<'a> {
    Outcome { scene, steps, curve: curve(scene, steps), fields: Fields::Here }
}

/// The force-depth curve up to the deepest of the answers, when the scene asks for it and it can be had.
fn curve(scene: &Scene, steps: &[Step]) -> Option<serde_json::Value> {
    if !scene.settings.outputs.curve {
        return None;
    }
    let deepest = steps.iter().filter_map(numbers).filter(|s| s.force > 0.0).map(|s| s.depth).reduce(f64::max)?;
    // The whole curve takes no longer than a state may.
    let Settings { deadline, seconds, threads, tolerance, .. } = scene.settings;
    let deadline = deadline.or_after(seconds, threads);
    let settings = Settings { deadline, ..scene.settings };
    let curve = Curve::up_to(&scene.contact, &settings, deepest, tolerance).ok()?;
    serde_json::from_str(&curve.json()).ok()
}

impl Serialize for Outcome<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let many = matches!(self.scene.contact.loading(), Loading::Steps(_));
        let mut map = Keys { map: to.serialize_map(None)?, steps: self.steps, many };
        map.map.serialize_entry("scene", &self.scene.document)?;
        map.each("method", |s| Some(s.method.name()))?;
        map.each("origin", |s| Some(OriginOf(s.origin)))?;
        map.each("grid", |s| s.grid.map(GridOf))?;
        map.each("depth", |s| finite(s.depth))?;
        map.each("force", |s| finite(s.force))?;
        map.each("force_error", |s| Some(s.force_error.and_then(finite)))?;
        map.each("depth_error", |s| Some(s.depth_error.and_then(finite)))?;
        map.each("stiffness_error", |s| Some(s.stiffness_error.and_then(finite)))?;
        map.each("map_error", |s| s.map_error)?;
        map.each("energy_error", |s| Some(s.energy_error.and_then(finite)))?;
        map.each("area_error", |s| Some(s.area_error.and_then(finite)))?;
        map.each("evidence", |s| s.error().map(|_| s.evidence().word()))?;
        map.each("bracket", |s| {
            let with_fields = s.pressure.field.is_some();
            s.bracket.as_ref().map(|bracket| BracketOf { bracket, depth: s.depth_bracket.as_ref(), with_fields })
        })?;
        map.each("stiffness", |s| finite(s.stiffness))?;
        map.each("stiffness_matrix", |s| s.stiffness_matrix.filter(|m| m.iter().flatten().all(|x| x.is_finite())))?;
        map.each("energy", |s| s.energy.and_then(finite))?;
        map.each("tilt", |s| Some(s.tilt))?;
        map.each("moment", |s| s.moment.filter(|m| m.iter().all(|x| x.is_finite())))?;
        map.each("centre_of_pressure", centre_of_pressure)?;
        map.each("patch", |s| Some(PatchOf(s)))?;
        map.each("touches_edge", |s| Some(s.touches_edge.map(TouchesOf)))?;
        map.each("validity", |s| s.validity.map(ValidityOf))?;
        map.each("pressure", |s| Some(PressureOf { solution: s, fields: self.fields }))?;
        map.each("gap", |s| {
            s.pressure.gap.as_ref().map(|(grid, values)| GapOf { grid: *grid, values, fields: self.fields })
        })?;
        if let Some(curve) = &self.curve {
            map.map.serialize_entry("curve", curve)?;
        }
        map.verdicts()?;
        map.each("checks", |s| s.residuals.map(|_| ChecksOf(s)))?;
        map.each("cost", |s| Some(CostOf(s)))?;
        map.map.serialize_entry("left_out", &said_once(self.steps, |s| &s.left_out))?;
        map.map.serialize_entry("remarks", &said_once(self.steps, |s| &s.remarks))?;
        map.map.end()
    }
}

/// NaN and the infinities have no place in JSON.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

struct Keys<'a, M> {
    map: M,
    steps: &'a [Step],
    many: bool,
}

impl<'a, M: SerializeMap> Keys<'a, M> {
    /// A value a step, left out when no step has it.
    fn each<T: Serialize>(
        &mut self,
        key: &'static str,
        of: impl Fn(&'a Solution) -> Option<T> + Copy,
    ) -> Result<(), M::Error> {
        let value = |step: &'a Step| numbers(step).and_then(of);
        if self.steps.iter().all(|step| value(step).is_none()) {
            return Ok(());
        }
        if self.many {
            return self.map.serialize_entry(key, &List(self.steps, value));
        }
        match self.steps.first().and_then(value) {
            Some(value) => self.map.serialize_entry(key, &value),
            None => Ok(()),
        }
    }

    /// One word for the whole: that of the first step which was not solved.
    fn verdicts(&mut self) -> Result<(), M::Error> {
        let Some(wrong) = self.steps.iter().find_map(|step| step.as_ref().err()) else {
            return self.map.serialize_entry("verdict", "solved");
        };
        self.map.serialize_entry("verdict", wrong.verdict.word())?;
        self.map.serialize_entry("reason", &wrong.reason)?;
        if let Some(hint) = &wrong.hint {
            self.map.serialize_entry("hint", hint)?;
        }
        if self.many {
            let words = |s: &'a Step| s.as_ref().err().map_or("solved", |e| e.verdict.word());
            self.map.serialize_entry("verdicts", &List(self.steps, words))?;
            self.map
                .serialize_entry("reasons", &List(self.steps, |s: &'a Step| s.as_ref().err().map(|e| &e.reason)))?;
        }
        Ok(())
    }
}

/// A list written entry by entry.
struct List<'a, F>(&'a [Step], F);

impl<'a, T: Serialize, F: Fn(&'a Step) -> T> Serialize for List<'a, F> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut list = to.serialize_seq(Some(self.0.len()))?;
        for step in self.0 {
            list.serialize_element(&(self.1)(step))?;
        }
        list.end()
    }
}

struct OriginOf(Origin);

impl Serialize for OriginOf {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("kind", self.0.kind())?;
        match self.0 {
            Origin::ManyGrids { grids } => map.serialize_entry("grids", &grids)?,
            Origin::SeparateContacts { count } => map.serialize_entry("count", &count)?,
            _ => {}
        }
        map.end()
    }
}

struct GridOf(Grid);

impl Serialize for GridOf {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(2))?;
        map.serialize_entry("shape", &self.0.shape)?;
        map.serialize_entry("spacing", &self.0.spacing)?;
        map.end()
    }
}

struct PatchOf<'a>(&'a Solution);

impl Serialize for PatchOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let patch = &self.0.patch;
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("area", &finite(patch.area))?;
        map.serialize_entry("centroid", &patch.centroid)?;
        map.serialize_entry("regions", &patch.regions)?;
        map.serialize_entry("max_radius", &finite(patch.max_radius))?;
        if let (Some(axes), Some(angle)) = (patch.semi_axes, patch.angle) {
            map.serialize_entry("semi_axes", &axes)?;
            map.serialize_entry("angle", &angle.to_degrees())?;
        }
        map.serialize_entry("pieces", &patch.pieces.iter().map(PieceOf).collect::<Vec<_>>())?;
        if let Some(boundary) = &patch.boundary {
            map.serialize_entry("boundary", boundary)?;
        }
        map.end()
    }
}

struct PieceOf<'a>(&'a Piece);

impl Serialize for PieceOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(5))?;
        map.serialize_entry("area", &self.0.area)?;
        map.serialize_entry("force", &self.0.force)?;
        map.serialize_entry("centroid", &self.0.centroid)?;
        map.serialize_entry("extent", &self.0.extent)?;
        map.serialize_entry("max_pressure", &self.0.max_pressure.and_then(finite))?;
        map.end()
    }
}

struct TouchesOf(TouchesEdge);

impl Serialize for TouchesOf {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(2))?;
        map.serialize_entry("edge", self.0.edge.word())?;
        map.serialize_entry("share", &self.0.share.and_then(finite))?;
        map.end()
    }
}

struct ValidityOf(Validity);

impl Serialize for ValidityOf {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("slope", &finite(self.0.slope))?;
        if let Some(size) = self.0.size_over_radius {
            map.serialize_entry("size_over_radius", &finite(size))?;
        }
        map.serialize_entry("pressure_over_modulus", &finite(self.0.pressure_over_modulus))?;
        map.end()
    }
}

struct BracketOf<'a> {
    bracket: &'a ForceBracket,
    depth: Option<&'a DepthBracket>,
    with_fields: bool,
}

impl Serialize for BracketOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("lower", &finite(self.bracket.lower()))?;
        map.serialize_entry("upper", &finite(self.bracket.upper()))?;
        map.serialize_entry("evidence", word(self.bracket.evidence()))?;
        if let Evidence::Sampled { per_cell } = self.bracket.evidence() {
            map.serialize_entry("points_per_cell_side", &per_cell)?;
        }
        if let Some(depth) = self.depth {
            map.serialize_entry("depth", &DepthOf(depth))?;
        }
        for (key, side) in [("below", self.bracket.lower_side()), ("above", self.bracket.upper_side())] {
            map.serialize_entry(key, &SideOf { side, with_field: self.with_fields })?;
        }
        map.end()
    }
}

fn word(evidence: Evidence) -> &'static str {
    if evidence == Evidence::Proved { "proved" } else { "sampled" }
}

struct DepthOf<'a>(&'a DepthBracket);

impl Serialize for DepthOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(3))?;
        map.serialize_entry("lower", &finite(self.0.lower()))?;
        map.serialize_entry("upper", &self.0.upper())?;
        map.serialize_entry("evidence", word(self.0.evidence()))?;
        map.end()
    }
}

/// What proves a side, for a checker: the field only beside the field of the solution.
struct SideOf<'a> {
    side: &'a Side,
    with_field: bool,
}

impl Serialize for SideOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("theorem", self.side.theorem().name())?;
        map.serialize_entry("evidence", word(self.side.evidence()))?;
        let field = self.side.pressure().filter(|_| self.with_field);
        let field = field.map(|field| Field { grid: field.grid, values: Values::Here(&field.values) });
        if self.side.theorem() == Theorem::Energy {
            field.iter().try_for_each(|field| map.serialize_entry("field", field))?;
            return map.end();
        }
        map.serialize_entry("violation", &finite(self.side.violation()))?;
        map.serialize_entry("at", &self.side.at())?;
        let repair = self.side.repair();
        map.serialize_entry("discs", &finite(repair.discs))?;
        if repair.level > 0.0 {
            map.serialize_entry("level", &finite(repair.level))?;
            // A flat with a sharp edge has no finite degree.
            map.serialize_entry("degree", &repair.degree.and_then(finite))?;
        }
        field.iter().try_for_each(|field| map.serialize_entry("field", field))?;
        map.end()
    }
}

struct PressureOf<'a> {
    solution: &'a Solution,
    fields: Fields<'a>,
}

impl Serialize for PressureOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let pressure = &self.solution.pressure;
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("max", &pressure.max.and_then(finite))?;
        if let Some(singular) = pressure.singular {
            map.serialize_entry("singular", singular.word())?;
        } else if pressure.max.is_some() {
            map.serialize_entry("max_error", &pressure.max_error.and_then(finite))?;
        }
        map.serialize_entry("mean", &pressure.mean.and_then(finite))?;
        map.serialize_entry("at", &pressure.at)?;
        if let Some(field) = &pressure.field {
            let values = match self.fields {
                Fields::Here => Values::Here(&field.values),
                Fields::In(file) => Values::In(file),
                Fields::Elsewhere => Values::Elsewhere,
            };
            map.serialize_entry("field", &Field { grid: field.grid, values })?;
        }
        map.end()
    }
}

struct GapOf<'a> {
    grid: Grid,
    values: &'a [f64],
    fields: Fields<'a>,
}

impl Serialize for GapOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(1))?;
        let values = match self.fields {
            Fields::Elsewhere => Values::Elsewhere,
            Fields::Here | Fields::In(_) => Values::Here(self.values),
        };
        map.serialize_entry("field", &Field { grid: self.grid, values })?;
        map.end()
    }
}

struct Field<'a> {
    grid: Grid,
    values: Values<'a>,
}

enum Values<'a> {
    Here(&'a [f64]),
    /// In a file of their own.
    In(&'a str),
    /// With the caller.
    Elsewhere,
}

impl Serialize for Field<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("origin", &self.grid.origin)?;
        map.serialize_entry("spacing", &self.grid.spacing)?;
        map.serialize_entry("shape", &self.grid.shape)?;
        match self.values {
            // An infinite gap, where there is no material, becomes null.
            Values::Here(values) => map.serialize_entry("values", values)?,
            Values::In(file) => map.serialize_entry("file", file)?,
            Values::Elsewhere => {}
        }
        map.end()
    }
}

struct ChecksOf<'a>(&'a Solution);

impl Serialize for ChecksOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(3))?;
        let checks = self.0.residuals;
        map.serialize_entry("complementarity", &checks.map(|r| r.complementarity).and_then(finite))?;
        map.serialize_entry("tension", &checks.map(|r| r.tension).and_then(finite))?;
        map.serialize_entry("penetration", &checks.map(|r| r.penetration).and_then(finite))?;
        map.end()
    }
}

struct CostOf<'a>(&'a Solution);

impl Serialize for CostOf<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let cost = &self.0.cost;
        let mut map = to.serialize_map(Some(5))?;
        map.serialize_entry("seconds", &finite(cost.seconds))?;
        map.serialize_entry("unknowns", &cost.unknowns)?;
        map.serialize_entry("iterations", &cost.iterations)?;
        map.serialize_entry("operator_products", &cost.operator_products)?;
        map.serialize_entry("steps", &cost.steps)?;
        map.end()
    }
}
