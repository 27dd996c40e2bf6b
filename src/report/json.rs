//! The result as JSON: its parts from the solutions. The keys are in [`crate::result`].

use std::borrow::Cow;

use serde::ser::{Serialize, Serializer};

use super::{Step, centre_of_pressure, numbers, said_once};
use crate::bracket::{Evidence, ForceBracket, Theorem};
use crate::curve::Curve;
use crate::grid::Grid;
use crate::problem::{Loading, Settings};
use crate::result::{
    Bracket, Column, Cost, DepthBracket, Document, Field, FinestGrid, Gap, Origin, PairBracket, Patch, Piece, Pressure,
    Residuals, Side, TouchesEdge, Validity,
};
use crate::scene::{Scene, SolveOptions};
use crate::solution::{self, Solution};

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
        self.document().serialize(to)
    }
}

impl<'a> Outcome<'a> {
    fn document(&'a self) -> Document<'a> {
        let fields = self.fields;
        let many = matches!(self.scene.contact.loading(), Loading::Steps(_));
        let wrong = self.steps.iter().find_map(|step| step.as_ref().err());
        let listed = if many && wrong.is_some() { self.steps } else { &[] };
        let verdict = |step: &Step| step.as_ref().err().map_or("solved", |e| e.verdict.word());
        Document {
            scene: Some(&self.scene.document),
            options: SolveOptions::of(self.scene),
            method: self.given(|s| Some(s.method.name().into())),
            origin: self.given(|s| Some(origin(s))),
            grid: self.given(|s| s.grid.map(|Grid { shape, spacing, .. }| FinestGrid { shape, spacing })),
            depth: self.given(|s| finite(s.depth)),
            force: self.given(|s| finite(s.force)),
            force_error: self.or_null(|s| s.force_error),
            depth_error: self.or_null(|s| s.depth_error),
            stiffness_error: self.or_null(|s| s.stiffness_error),
            map_error: self.given(|s| s.map_error),
            energy_error: self.or_null(|s| s.energy_error),
            area_error: self.or_null(|s| s.area_error),
            evidence: self.given(|s| s.error().map(|_| s.evidence().word().into())),
            bracket: self.given(|s| s.bracket.as_ref().map(|of| bracket(of, s))),
            stiffness: self.given(|s| finite(s.stiffness)),
            stiffness_matrix: self.given(|s| s.stiffness_matrix.filter(|m| m.iter().flatten().all(|x| x.is_finite()))),
            energy: self.given(|s| s.energy.and_then(finite)),
            tilt: self.given(|s| Some(s.tilt)),
            moment: self.given(|s| s.moment.filter(|m| m.iter().all(|x| x.is_finite()))),
            centre_of_pressure: self.given(centre_of_pressure),
            patch: self.given(|s| Some(patch(&s.patch))),
            touches_edge: self
                .or_null(|s| s.touches_edge.map(|at| TouchesEdge { edge: at.edge.word().into(), share: at.share })),
            validity: self.given(|s| s.validity.map(validity)),
            pressure: self.given(|s| Some(pressure(s, fields))),
            gap: self.given(|s| {
                let (grid, values) = s.pressure.gap.as_ref()?;
                let fields = if let Fields::In(_) = fields { Fields::Here } else { fields };
                Some(Gap { field: Some(field(*grid, values, fields)) })
            }),
            curve: self.curve.clone(),
            verdict: wrong.map_or("solved", |e| e.verdict.word()).into(),
            reason: wrong.map(|e| e.reason.as_str().into()),
            hint: wrong.and_then(|e| e.hint.as_deref()).map(Cow::from),
            verdicts: listed.iter().map(verdict).collect(),
            reasons: listed.iter().map(|step| step.as_ref().err().map(|e| e.reason.as_str())).collect(),
            checks: self.given(|s| {
                let solution::Residuals { complementarity, tension, penetration } = s.residuals?;
                let [complementarity, tension, penetration] = [complementarity, tension, penetration].map(Some);
                Some(Residuals { complementarity, tension, penetration })
            }),
            cost: self.given(|s| {
                let solution::Cost { seconds, unknowns, iterations, operator_products, steps } = s.cost;
                Some(Cost { seconds: Some(seconds), unknowns, iterations, operator_products, steps })
            }),
            left_out: said_once(self.steps, |s| &s.left_out),
            remarks: said_once(self.steps, |s| &s.remarks),
        }
    }

    /// A key that is left out where there is nothing.
    fn given<T>(&'a self, of: impl Fn(&'a Solution) -> Option<T>) -> Column<T> {
        self.column(|s| of(s).map(Some))
    }

    /// A key that is `null` where there is nothing.
    fn or_null<T>(&'a self, of: impl Fn(&'a Solution) -> Option<T>) -> Column<T> {
        self.column(|s| Some(of(s)))
    }

    fn column<T>(&'a self, of: impl Fn(&'a Solution) -> Option<Option<T>>) -> Column<T> {
        let many = matches!(self.scene.contact.loading(), Loading::Steps(_));
        Column::new(self.steps.iter().map(|step| numbers(step).and_then(&of)).collect(), many)
    }
}

/// NaN and the infinities have no place in JSON.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn origin<'a>(state: &Solution) -> Origin<'a> {
    let (grids, count) = match state.origin {
        solution::Origin::ManyGrids { grids } => (Some(grids), None),
        solution::Origin::SeparateContacts { count } => (None, Some(count)),
        _ => (None, None),
    };
    Origin { kind: state.origin.kind().into(), grids, count, turned: state.turned.map(f64::to_degrees) }
}

fn patch(patch: &solution::Patch) -> Patch<'_> {
    let ellipse = patch.semi_axes.zip(patch.angle);
    let piece = |piece: &solution::Piece| {
        let solution::Piece { area, force, centroid, extent, max_pressure } = *piece;
        Piece { area, force, centroid, extent, max_pressure }
    };
    Patch {
        area: Some(patch.area),
        centroid: patch.centroid,
        regions: Some(patch.regions),
        max_radius: Some(patch.max_radius),
        semi_axes: ellipse.map(|(axes, _)| axes),
        angle: ellipse.map(|(_, angle)| angle.to_degrees()),
        pieces: Some(patch.pieces.iter().map(piece).collect()),
        boundary: patch.boundary.as_deref().map(Cow::from),
    }
}

fn validity(validity: solution::Validity) -> Validity {
    let solution::Validity { slope, size_over_radius, pressure_over_modulus } = validity;
    Validity { slope: Some(slope), size_over_radius, pressure_over_modulus: Some(pressure_over_modulus) }
}

fn bracket<'a>(bracket: &'a ForceBracket, solution: &'a Solution) -> Bracket<'a> {
    // What proves a side, for a checker: the field only beside the field of the solution.
    let with_field = solution.pressure.field.is_some();
    Bracket {
        lower: Some(bracket.lower()),
        upper: Some(bracket.upper()),
        evidence: word(bracket.evidence()).into(),
        points_per_cell_side: match bracket.evidence() {
            Evidence::Proved => None,
            Evidence::Sampled { per_cell } => Some(per_cell),
        },
        depth: solution.depth_bracket.as_ref().map(|depth| DepthBracket {
            lower: Some(depth.lower()),
            upper: depth.upper(),
            evidence: word(depth.evidence()).into(),
        }),
        moment: solution.moment_bracket.as_ref().map(pair),
        tilt: solution.tilt_bracket.as_ref().map(pair),
        below: Some(side(bracket.lower_side(), with_field)),
        above: Some(side(bracket.upper_side(), with_field)),
    }
}

fn pair(bracket: &solution::PairBracket) -> PairBracket<'static> {
    PairBracket { lower: bracket.lower(), upper: bracket.upper(), evidence: word(Evidence::Proved).into() }
}

fn word(evidence: Evidence) -> &'static str {
    if evidence == Evidence::Proved { "proved" } else { "sampled" }
}

fn side(side: &solution::Side, with_field: bool) -> Side<'_> {
    // The energy has no use for the rest.
    let repaired = (side.theorem() != Theorem::Energy).then(|| side.repair());
    let moved = repaired.filter(|repair| repair.level > 0.0);
    let own = side.pressure().filter(|_| with_field);
    Side {
        theorem: side.theorem().name().into(),
        evidence: word(side.evidence()).into(),
        violation: repaired.map(|_| side.violation()),
        at: repaired.map(|_| side.at()),
        discs: repaired.map(|repair| repair.discs),
        level: moved.map(|repair| repair.level),
        // A flat with a sharp edge has no finite degree: null.
        degree: moved.map(|repair| repair.degree.unwrap_or(f64::INFINITY)),
        field: own.map(|own| field(own.grid, &own.values, Fields::Here)),
    }
}

fn pressure<'a>(solution: &'a Solution, fields: Fields<'a>) -> Pressure<'a> {
    let pressure = &solution.pressure;
    let regular = pressure.singular.is_none() && pressure.max.is_some();
    Pressure {
        max: pressure.max,
        singular: pressure.singular.map(|singular| singular.word().into()),
        // Not known: null.
        max_error: regular.then(|| pressure.max_error.unwrap_or(f64::NAN)),
        mean: pressure.mean,
        at: pressure.at,
        field: pressure.field.as_ref().map(|own| field(own.grid, &own.values, fields)),
    }
}

fn field<'a>(grid: Grid, values: &'a [f64], fields: Fields<'a>) -> Field<'a> {
    let Grid { origin, spacing, shape } = grid;
    let (values, file) = match fields {
        Fields::Here => (Some(values.into()), None),
        Fields::In(file) => (None, Some(file.into())),
        Fields::Elsewhere => (None, None),
    };
    Field { origin, spacing, shape, values, file }
}
