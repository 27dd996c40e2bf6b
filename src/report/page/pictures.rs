//! The pictures of a page, with the tables and sentences beside them.

use super::evidence::{Bracketing, Detail, Evidence};
use super::html::{Html, figure as picture, html, list, section, table, typeset};
use crate::bracket::Evidence as Proof;
use crate::compare::Comparison;
use crate::plot::{self, Format, Medium, Outline, Refinement};
use crate::problem::Method;
use crate::report::comparison::{COLUMNS, in_words, row};
use crate::report::numbers;
use crate::report::table::figure;
use crate::units::UnitLabels;

/// A picture in both widths with its caption; why there is none otherwise.
fn drawn(picture_on: impl Fn(Medium) -> Result<Vec<u8>, plot::Error>, caption: &str) -> Html {
    match (picture_on(Medium::Page), picture_on(Medium::Phone)) {
        (Ok(page), Ok(phone)) => picture([&page, &phone], caption),
        (Err(e), _) | (_, Err(e)) => html!("<p class=\"soft\">{}: {}.</p>\n", caption, e.to_string()),
    }
}

/// Two numbers; what is rounding against `size` is zero.
fn pair(values: [f64; 2], size: f64) -> String {
    let [x, y] = values.map(|v| figure(if v.abs() < 1e-9 * size { 0.0 } else { v }));
    format!("({x}, {y})")
}

/// The patch, and a section through it.
pub(super) fn patch(detail: &Detail, states: usize, units: &UnitLabels) -> Html {
    let mut told = Html::default();
    if states > 1 {
        told.push(&html!("<p>State {} of {}.</p>\n", detail.index + 1, states));
    }
    if let Err(e) = &detail.grid {
        told.push(&html!("<p class=\"soft\">No pressure map: {}.</p>\n", e.to_string()));
    }
    let called = |method: Method| match method {
        Method::Fft | Method::Qp | Method::EdgeFitted => "grid",
        Method::ClosedForm => "closed form",
        Method::Fabrikant => "Fabrikant, stationary boundary",
        _ => "best ellipse",
    };
    let drawn_boundaries: Vec<Outline> = detail
        .boundaries
        .iter()
        .map(|(method, loops)| Outline { label: called(*method).to_owned(), loops: loops.clone() })
        .collect();
    let mut both = drawn(
        |medium| plot::outlines_on(medium, units, "", &drawn_boundaries, Format::Svg),
        "The contact patch by every method that gives its boundary.",
    );
    if let Some(cut) = &detail.section {
        let reach = cut.along.last().copied().unwrap_or(0.0);
        let centre = pair(cut.centre, reach);
        let angle = cut.direction[1].atan2(cut.direction[0]).to_degrees();
        let angle = if angle.abs() < 0.05 { 0.0 } else { angle };
        both.push(&drawn(
            |medium| plot::section_on(medium, units, "", cut, Format::Svg),
            &format!(
                "Section through the centre of pressure {centre} at {angle:.1} degrees to x, where the pressure is spread \
                 widest. Heights count from the undeformed surface."
            ),
        ));
    }
    section("Patch and section", html!("{}<div class=\"pair\">\n{}</div>\n", told, both))
}

/// Force against depth.
pub(super) fn curve(evidence: &Evidence, units: &UnitLabels) -> Html {
    let told = match &evidence.curve {
        Some(Ok(curve)) => {
            let law = curve.power_law();
            let within =
                if law.error < 5e-5 { "to rounding".to_owned() } else { format!("within {:.2} %", 100.0 * law.error) };
            html!(
                "{}<p>{} solved; error of interpolation about {}. Least squares over the range: force = {} · \
                 overlap<sup>{}</sup>, {}.</p>\n",
                drawn(
                    |medium| plot::curve_on(medium, units, "", curve, Format::Svg),
                    "The contact as a non-linear spring; dots are states that were solved or follow from one by similarity."
                ),
                match curve.solves() {
                    1 => "1 state".to_owned(),
                    n => format!("{n} states"),
                },
                typeset(&format!("{:.1e}", curve.interpolation_error())),
                typeset(&figure(law.coefficient)),
                format!("{:.4}", law.exponent),
                within
            )
        }
        // The states themselves, where there are several.
        _ if evidence.steps.len() > 1 => {
            let states: Vec<[f64; 3]> =
                evidence.steps.iter().filter_map(numbers).map(|s| [s.depth, s.force, s.stiffness]).collect();
            if states.iter().all(|s| s[1] == 0.0) {
                return Html::default();
            }
            drawn(
                |medium| plot::states_on(medium, units, "", &states, None, Format::Svg),
                "Force against depth, the states of the scene.",
            )
        }
        Some(Err(why)) => html!("<p class=\"soft\">{}</p>\n", why),
        None => return Html::default(),
    };
    section("Force against depth", told)
}

/// Every method side by side.
pub(super) fn comparison(comparison: &Comparison) -> Html {
    let reference = comparison.reference.as_ref().map_or(Html::default(), |r| {
        html!(
            "<p>Reference: {}. Force {}, relative error about {}.{}</p>\n",
            typeset(&r.source),
            typeset(&figure(r.force)),
            typeset(&format!("{:.1e}", r.uncertainty)),
            r.bracket.as_ref().map_or(Html::default(), |b| html!(" Its {}.", typeset(&in_words(b))))
        )
    });
    let rows: Vec<Vec<String>> = comparison.runs.iter().map(|run| row(run).to_vec()).collect();
    let on_front = |k: usize| comparison.runs[k].outcome.as_ref().is_ok_and(|f| f.behind <= 1.0);
    let told = html!(
        "{}{}<p class=\"soft\">behind: run time over that of the quickest run as close to the reference; shaded lines (*) are the \
         Pareto front. patch diff.: area in one patch but not in both, over the reference's; pressure diff.: integral of the \
         difference over the force; bytes: most heap held at once.</p>\n{}{}",
        reference,
        table(&COLUMNS, &rows, on_front),
        list(comparison.remarks.iter().map(String::as_str)),
        drawn(
            |medium| plot::error_against_time_on(medium, "", comparison, Format::Svg),
            "Relative error of the force against run time, one line a method.",
        )
    );
    section("Every method", told)
}

/// Bounds of the force on several grids.
pub(super) fn brackets(detail: &Detail) -> Html {
    const HEADING: &str = "Bounds of the force";
    if detail.brackets.is_empty() {
        return section(HEADING, html!("<p class=\"soft\">No grid gave a bracket.</p>\n"));
    }
    let heads = ["cells", "lower", "force of the grid", "upper", "width", "evidence", "seconds"];
    let rows = detail.brackets.iter().map(|b| {
        let evidence = match b.bracket.evidence() {
            Proof::Proved => "proved".to_owned(),
            Proof::Sampled { per_cell } => format!("sampled at {per_cell} x {per_cell} points a cell"),
        };
        let [lower, force, upper] = [b.bracket.lower(), b.force, b.bracket.upper()].map(|x| format!("{x:.6e}"));
        let width = format!("{:.1e}", b.bracket.relative_width());
        vec![b.cells.to_string(), lower, force, upper, width, evidence, format!("{:.2}", b.seconds)]
    });
    let rows = table(&heads, &rows.collect::<Vec<_>>(), |_| false);
    let points =
        |of: &dyn Fn(&Bracketing) -> f64| detail.brackets.iter().map(|b| [b.cells as f64, of(b)]).collect::<Vec<_>>();
    let mut lines =
        vec![Refinement { label: "width of the bracket".into(), points: points(&|b| b.bracket.relative_width()) }];
    if let Some(r) = detail.comparison.as_ref().and_then(|c| c.reference.as_ref()) {
        let error = |b: &Bracketing| (b.force / r.force - 1.0).abs();
        lines.push(Refinement { label: "error of the grid's force".into(), points: points(&error) });
    }
    let narrowing = drawn(
        |medium| plot::width_against_cells_on(medium, "", &lines, Format::Svg),
        "What is proved or sampled of the force narrows with the cells, behind the error itself.",
    );
    section(HEADING, html!("{}{}", rows, narrowing))
}
