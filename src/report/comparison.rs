//! A comparison of methods: table, CSV and JSON.

use std::fmt::Write;

use serde::Serialize;

use super::table::{aligned, figure};
use crate::bracket::{Evidence, ForceBracket};
use crate::compare::{Comparison, Figures, Run};

/// A table of the runs, a line each, with the reference above it.
#[must_use]
pub fn comparison_table(name: Option<&str>, comparison: &Comparison) -> String {
    let mut lines: Vec<String> = name.iter().map(|name| name.escape_debug().to_string()).collect();
    if let Some(r) = &comparison.reference {
        lines.push(format!("reference: {}; relative error of its force about {:.1e}", r.source, r.uncertainty));
        lines.push(format!("force {}, patch area {}", figure(r.force), figure(r.area)));
        lines.extend(r.bracket.as_ref().map(in_words));
    }
    let mut rows = vec![COLUMNS.map(str::to_owned)];
    rows.extend(comparison.runs.iter().map(row));
    lines.extend(aligned(&rows));
    if comparison.reference.is_some() {
        lines.push(
            "behind: run time over that of the quickest run as close to the reference; * marks the Pareto front".into(),
        );
    }
    lines.extend(comparison.remarks.iter().map(|remark| format!("note: {remark}")));
    lines.push(String::new());
    lines.join("\n")
}

/// Heads of the columns of [`row`].
pub(crate) const COLUMNS: [&str; 13] = [
    "method",
    "at",
    "force",
    "error",
    "own estimate",
    "area error",
    "patch diff.",
    "pressure diff.",
    "unknowns",
    "products",
    "seconds",
    "bytes",
    "behind",
];

/// The bracket of the reference in a line.
pub(crate) fn in_words(bracket: &ForceBracket) -> String {
    let evidence = match bracket.evidence() {
        Evidence::Proved => "proved",
        Evidence::Sampled { .. } => "sampled",
    };
    let [lower, upper] = [bracket.lower(), bracket.upper()];
    format!("bracket {lower:.6e} to {upper:.6e}, {:.1e} wide, {evidence}", bracket.relative_width())
}

/// A run as a line of the table.
pub(crate) fn row(run: &Run) -> [String; 13] {
    let dash = || "-".to_owned();
    let [method, at] = [run.method.name().to_owned(), setting(run)];
    match &run.outcome {
        Ok(f) => [
            method,
            at,
            figure(f.force),
            signed(f.error),
            f.estimate.map_or_else(dash, |e| format!("{e:.1e}")),
            signed(f.area_error),
            f.patch_difference.map_or_else(dash, |d| format!("{d:.1e}")),
            f.pressure_difference.map_or_else(dash, |d| format!("{d:.1e}")),
            f.unknowns.to_string(),
            f.products.to_string(),
            format!("{:.2e}", f.seconds),
            f.peak_bytes.map_or_else(dash, |b| format!("{:.1e}", b as f64)),
            behind(f),
        ],
        Err(e) => {
            let mut row: [String; 13] = std::array::from_fn(|_| dash());
            [row[0], row[1], row[2]] = [method, at, e.verdict.to_string()];
            row
        }
    }
}

/// Cells or tolerance of a run.
pub(crate) fn setting(run: &Run) -> String {
    match (run.cells, run.tolerance) {
        (Some(cells), _) => format!("{cells} cells"),
        (None, Some(tolerance)) => format!("tol. {tolerance:e}"),
        (None, None) => String::new(),
    }
}

fn signed(error: f64) -> String {
    if error == 0.0 { "0".into() } else { format!("{error:+.2e}") }
}

fn behind(figures: &Figures) -> String {
    if figures.behind <= 1.0 { "*".into() } else { format!("{:.1}", figures.behind) }
}

/// The runs as CSV: a header, then a line a run. What is not known is an empty field.
#[must_use]
pub fn comparison_csv(comparison: &Comparison) -> String {
    let mut text =
        "method,cells,tolerance,ran,force,error,estimate,area,area_error,patch_difference,pressure_difference,unknowns,\
                    products,seconds,peak_bytes,behind,verdict,reason\n"
            .to_owned();
    let number = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or(String::new(), |x| format!("{x:e}"));
    for run in &comparison.runs {
        let cells = run.cells.map_or(String::new(), |n| n.to_string());
        let asked = format!("{},{cells},{}", run.method.name(), number(run.tolerance));
        // Writing to a string does not fail.
        let _ = match &run.outcome {
            Ok(f) => {
                let [force, area] = [f.force, f.area].map(Some);
                let differences = [Some(f.area_error), f.patch_difference, f.pressure_difference];
                let values = [[force, Some(f.error), f.estimate].map(number).join(","), number(area)];
                let values = [values.join(","), differences.map(number).join(",")].join(",");
                let bytes = f.peak_bytes.map_or(String::new(), |b| b.to_string());
                let [seconds, behind] = [f.seconds, f.behind].map(|x| number(Some(x)));
                let cost = format!("{},{},{seconds},{bytes},{behind}", f.unknowns, f.products);
                writeln!(text, "{asked},{},{values},{cost},solved,", f.ran.name())
            }
            Err(e) => writeln!(text, "{asked}{},{},\"{}\"", ",".repeat(13), e.verdict, e.reason.replace('"', "\"\"")),
        };
    }
    text
}

#[derive(Serialize)]
struct ReferenceForm<'a> {
    method: &'a str,
    source: &'a str,
    force: f64,
    uncertainty: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bracket: Option<BracketForm>,
    area: f64,
}

#[derive(Serialize)]
struct BracketForm {
    lower: f64,
    upper: f64,
    evidence: &'static str,
}

#[derive(Serialize)]
struct RunForm<'a> {
    method: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    cells: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    verdict: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'a str>,
    #[serde(flatten)]
    figures: Option<FiguresForm<'a>>,
}

#[derive(Serialize)]
struct FiguresForm<'a> {
    ran: &'a str,
    force: f64,
    error: f64,
    estimate: Option<f64>,
    area: f64,
    area_error: f64,
    patch_difference: Option<f64>,
    pressure_difference: Option<f64>,
    unknowns: usize,
    products: usize,
    seconds: f64,
    peak_bytes: Option<usize>,
    behind: f64,
}

#[derive(Serialize)]
struct ComparisonForm<'a> {
    scene: &'a crate::scene::Json,
    reference: Option<ReferenceForm<'a>>,
    runs: Vec<RunForm<'a>>,
    remarks: &'a [String],
}

/// The comparison as JSON: `scene`, `reference: {method, source, force, uncertainty, bracket?, area}`, and `runs`, each with
/// `method`, `cells` or `tolerance`, `verdict` (`solved`, or what is wrong, with its `reason`) and what [`Figures`] holds.
///
/// # Errors
/// As `serde_json` when a number cannot be written; there is none such in a comparison.
pub fn comparison_json(scene: &crate::Scene, comparison: &Comparison) -> Result<String, serde_json::Error> {
    let reference = comparison.reference.as_ref().map(|r| ReferenceForm {
        method: r.method.name(),
        source: &r.source,
        force: r.force,
        uncertainty: Some(r.uncertainty).filter(|u| u.is_finite()),
        bracket: r.bracket.as_ref().map(|b| BracketForm {
            lower: b.lower(),
            upper: b.upper(),
            evidence: if b.evidence() == Evidence::Proved { "proved" } else { "sampled" },
        }),
        area: r.area,
    });
    let runs = comparison.runs.iter().map(run_form).collect();
    let form = ComparisonForm { scene: &scene.document, reference, runs, remarks: &comparison.remarks };
    serde_json::to_string(&form)
}

fn run_form(run: &Run) -> RunForm<'_> {
    let wrong = run.outcome.as_ref().err();
    let figures = run.outcome.as_ref().ok().map(|f| FiguresForm {
        ran: f.ran.name(),
        force: f.force,
        error: f.error,
        estimate: f.estimate,
        area: f.area,
        area_error: f.area_error,
        patch_difference: f.patch_difference,
        pressure_difference: f.pressure_difference,
        unknowns: f.unknowns,
        products: f.products,
        seconds: f.seconds,
        peak_bytes: f.peak_bytes,
        behind: f.behind,
    });
    RunForm {
        method: run.method.name(),
        cells: run.cells,
        tolerance: run.tolerance,
        verdict: wrong.map_or("solved", |e| e.verdict.word()),
        reason: wrong.map(|e| e.reason.as_str()),
        figures,
    }
}
