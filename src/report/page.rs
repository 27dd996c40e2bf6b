//! The report: one page that needs nothing else, for the screen and for paper.

use std::fmt::Write;

use super::comparison::{COLUMNS, in_words, row};
pub use super::evidence::Parts;
use super::evidence::{Detail, Evidence};
use super::html::{escaped, facts, figure as picture, list, table, typeset};
use super::table::{facts as state_facts, figure, peak};
use super::view::view;
use super::{Step, numbers, said_once};
use crate::bracket::Evidence as Proof;
use crate::compare::{self, Comparison};
use crate::plot::{self, Format, Medium, Outline, Refinement};
use crate::problem::{Load, Method};
use crate::scene::Scene;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// A page, and whether every state of the scene was solved.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// The document, complete: no script, style or picture from elsewhere.
    pub html: String,
    /// Every state of loading has an answer.
    pub solved: bool,
}

/// Who made a page, when and how: said on it where it is known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// Who.
    pub author: Option<String>,
    /// When, in words.
    pub written: Option<String>,
    /// The command that writes the page again.
    pub command: Option<String>,
}

/// Solves the scene, runs every method of `runs` on the last of its states that touches, and writes all of it down: the
/// answers, pictures, curve, comparison, brackets, plan, cost and problem. `say` hears what is going on.
///
/// ```
/// use contact_patch::{Scene, compare, report};
/// let scene = Scene::from_json(br#"{"name": "ball & plate", "effective_modulus": 1.0,
///     "gap": {"kind": "sphere", "radius": 1.0}, "loading": {"depth": -0.5}}"#)?;
/// let page = report::page(&scene, &compare::Plan::new(scene.settings), &mut |_| ());
/// assert!(page.solved && page.html.contains("<h1>ball &amp; plate</h1>"));
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[must_use]
pub fn page(scene: &Scene, runs: &compare::Plan, say: &mut dyn FnMut(&str)) -> Page {
    page_of(scene, runs, Parts::ALL, &Provenance::default(), say)
}

/// As [`page`], with some of its parts: those that are not asked for are left out, unless they fit into three times what the answer
/// takes (at least a quarter of a second more, and five seconds at most); what is left out is listed.
///
/// ```
/// use contact_patch::{Scene, compare, report};
/// let scene = Scene::from_json(br#"{"effective_modulus": 1.0, "gap": {"kind": "sphere", "radius": 1.0}, "loading": {"depth": 0.01}}"#)?;
/// let (runs, made) = (compare::Plan::new(scene.settings), report::Provenance::default());
/// let page = report::page_of(&scene, &runs, report::Parts::default(), &made, &mut |_| ());
/// assert!(page.html.contains("--with methods") && page.html.contains("<svg"));
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[must_use]
pub fn page_of(
    scene: &Scene,
    runs: &compare::Plan,
    parts: Parts,
    made: &Provenance,
    say: &mut dyn FnMut(&str),
) -> Page {
    let evidence = Evidence::gather(scene, runs, parts, say);
    say("the page");
    let name = escaped(scene.name.as_deref().unwrap_or("Contact without a name"));
    let units = scene.units.as_ref();
    let labels = units.cloned().unwrap_or_else(UnitLabels::kinds);
    let main = main_view(&evidence, &labels);
    let script = if main.is_empty() { "" } else { concat!("<script>\n", include_str!("page.js"), "</script>\n") };
    // Nothing may be fetched, even by what a scene's texts might smuggle in.
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{name}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n",
        include_str!("page.css")
    );
    let comparison = evidence.detail.as_ref().and_then(|d| d.comparison.as_ref());
    let sections = [
        head(&name, &evidence, units, &main),
        result(&evidence, scene),
        evidence.detail.as_ref().map_or(String::new(), |d| pictures(d, evidence.steps.len(), &labels)),
        curve(&evidence, &labels),
        comparison.map_or(String::new(), self::comparison),
        evidence.detail.as_ref().filter(|_| parts.bounds).map_or(String::new(), brackets),
        plan(&evidence),
        cost(&evidence),
        skipped(&evidence),
        problem(scene),
        provenance(made),
    ];
    sections.iter().for_each(|section| html.push_str(section));
    let _ = writeln!(
        html,
        "<footer>contact-patch {}. Numbers are in the units of the scene; angles there are in degrees.</footer>\n</main>\n{script}</body>\n\
         </html>",
        env!("CARGO_PKG_VERSION")
    );
    Page { html, solved: evidence.steps.iter().all(Result::is_ok) }
}

/// The picture of the first screen, with what a script needs to answer for it; of several states force against depth.
fn main_view(evidence: &Evidence, units: &UnitLabels) -> String {
    match evidence.detail.as_ref().map(|detail| &detail.grid) {
        Some(Ok(solution)) => view(solution, units).unwrap_or_default(),
        _ => String::new(),
    }
}

fn skipped(evidence: &Evidence) -> String {
    if evidence.skipped.is_empty() {
        return String::new();
    }
    let items = list(evidence.skipped.iter().map(String::as_str));
    format!("<section>\n<h2>Not in this report</h2>\n{items}</section>\n")
}

fn provenance(made: &Provenance) -> String {
    let rows: Vec<(&str, String)> = [("by", &made.author), ("written", &made.written)]
        .into_iter()
        .filter_map(|(name, value)| value.clone().map(|value| (name, value)))
        .chain([("program", format!("contact-patch {}", env!("CARGO_PKG_VERSION")))])
        .collect();
    let rows: String = rows
        .iter()
        .map(|(name, value)| format!("<tr><th>{name}</th><td class=\"wrap\">{}</td></tr>\n", escaped(value)))
        .collect();
    let command = made.command.as_ref().map_or(String::new(), |c| format!("<pre>{}</pre>\n", escaped(c)));
    format!(
        "<section>\n<h2>How this page was made</h2>\n<div class=\"scroll\"><table><tbody>\n{rows}</tbody></table></div>\n{command}</section>\n"
    )
}

fn head(name: &str, evidence: &Evidence, units: Option<&UnitLabels>, main: &str) -> String {
    let mut html = format!("<header>\n<div class=\"answer\">\n<h1>{name}</h1>\n");
    match evidence.steps.iter().find_map(|step| step.as_ref().err()) {
        None => html.push_str("<p class=\"verdict\">solved</p>\n"),
        Some(e) => {
            let _ = writeln!(
                html,
                "<p class=\"verdict no\">not solved: {}</p>\n<p>{}</p>",
                escaped(e.verdict.word()),
                escaped(&e.reason)
            );
            if let Some(hint) = &e.hint {
                let _ = writeln!(html, "<p>What to try: {}.</p>", escaped(hint));
            }
        }
    }
    let states = evidence.steps.len();
    if let Some((k, s)) = evidence.detail.as_ref().and_then(|d| Some((d.index, numbers(&evidence.steps[d.index])?))) {
        if states > 1 {
            let _ = writeln!(html, "<p class=\"soft\">State {} of {states}:</p>", k + 1);
        }
        let with = |value: String, of: fn(&UnitLabels) -> String| {
            units.map_or(value.clone(), |u| format!("{value} {}", of(u)))
        };
        let off = |error: Option<f64>| match error {
            Some(e) if e > 1e-12 => format!("within {e:.1e}"),
            Some(_) => String::new(),
            None => "error not known".to_owned(),
        };
        let prescribed = |own: Option<f64>, other: Option<f64>| match own {
            Some(0.0) if other != Some(0.0) => "prescribed".to_owned(),
            own => off(own),
        };
        let mut keys = vec![
            ("force", with(figure(s.force), |u| u.force().to_owned()), prescribed(s.force_error, s.depth_error)),
            ("depth", with(figure(s.depth), |u| u.length().to_owned()), prescribed(s.depth_error, s.force_error)),
            ("stiffness", with(figure(s.stiffness), UnitLabels::stiffness), off(s.stiffness_error)),
            ("patch area", with(figure(s.patch.area), UnitLabels::area), off(s.area_error)),
        ];
        keys.extend(peak(s).map(|p| match s.pressure.singular {
            Some(_) => ("largest pressure", p, String::new()),
            None => ("largest pressure", with(p, UnitLabels::pressure), off(s.pressure.max_error)),
        }));
        keys.push(("method", s.method.name().to_owned(), s.evidence().word().to_owned()));
        html.push_str("<ul class=\"key\">\n");
        for (what, value, error) in keys {
            let error = if error.is_empty() { error } else { format!("<small>{}</small>", typeset(&error)) };
            let _ = writeln!(html, "<li><span>{what}</span><b>{}</b>{error}</li>", typeset(&value));
        }
        html.push_str("</ul>\n");
    }
    html + "</div>\n" + main + "</header>\n"
}

fn problem(scene: &Scene) -> String {
    let loads = scene.contact.loading().loads();
    let one = |load: &Load| match load {
        Load::Depth(d) => format!("depth {}", figure(*d)),
        Load::Force(p) => format!("force {}", figure(*p)),
        Load::Tilted { depth, tilt: [ax, ay] } => {
            format!("depth {} and tilt ({}, {}) rad", figure(*depth), figure(*ax), figure(*ay))
        }
        Load::ForceMoment { force, moment: [mx, my] } => {
            format!(
                "force {} and moments ({}, {}) about the origin, free to tilt",
                figure(*force),
                figure(*mx),
                figure(*my)
            )
        }
    };
    let loading = match loads {
        [load] => one(load),
        [first, .., last] => format!("{} states, from {} to {}", loads.len(), one(first), one(last)),
        [] => String::new(),
    };
    let document = serde_json::to_string_pretty(&scene.document).unwrap_or_default();
    format!(
        "<section>\n<h2>Problem</h2>\n{}<details>\n<summary>The scene</summary>\n<pre>{}</pre>\n</details>\n</section>\n",
        facts(&[
            ("effective modulus E*", figure(scene.contact.modulus().e_star())),
            ("loading", loading),
            ("relative error of the force asked for", format!("{:e}", scene.settings.tolerance)),
        ]),
        escaped(&document)
    )
}

fn plan(evidence: &Evidence) -> String {
    let told = match &evidence.plan {
        Ok(plan) => {
            let left_out = if plan.left_out.is_empty() { "" } else { "<p>Left out:</p>\n" };
            format!(
                "<p>Method: <b>{}</b></p>\n{}{left_out}{}",
                plan.method.map_or("none", Method::name),
                list(plan.steps.iter().map(String::as_str)),
                list(plan.left_out.iter().map(String::as_str))
            )
        }
        Err(unsolved) => format!("<p>Nothing can be planned: {}.</p>\n", escaped(&unsolved.to_string())),
    };
    format!("<section>\n<h2>Plan</h2>\n{told}</section>\n")
}

fn result(evidence: &Evidence, scene: &Scene) -> String {
    let told = match &evidence.steps[..] {
        [step] => numbers(step).map_or(String::new(), |s| single(s, scene)),
        steps => several(steps, scene.units.as_ref()),
    };
    let remarks = said_once(&evidence.steps, |s| &s.remarks);
    let left_out = match &said_once(&evidence.steps, |s| &s.left_out)[..] {
        [] => String::new(),
        what => format!("<p class=\"soft\">Left out: {}.</p>\n", escaped(&what.join("; "))),
    };
    if told.is_empty() {
        return String::new();
    }
    format!("<section>\n<h2>Result</h2>\n{told}{}{left_out}</section>\n", list(remarks))
}

/// Two numbers; what is rounding against `size` is zero.
fn pair(values: [f64; 2], size: f64) -> String {
    let [x, y] = values.map(|v| figure(if v.abs() < 1e-9 * size { 0.0 } else { v }));
    format!("({x}, {y})")
}

fn single(s: &Solution, scene: &Scene) -> String {
    let rows = state_facts(s, scene);
    // What it took has a section of its own.
    let shown = rows.iter().filter(|[name, _]| name != "cost");
    facts(&shown.map(|[name, value]| (name.as_str(), value.clone())).collect::<Vec<_>>())
}

fn several(steps: &[Step], units: Option<&UnitLabels>) -> String {
    let named =
        |name: &str, of: fn(&UnitLabels) -> String| units.map_or(name.to_owned(), |u| format!("{name} [{}]", of(u)));
    let heads = [
        "state".to_owned(),
        named("depth", |u| u.length().to_owned()),
        named("force", |u| u.force().to_owned()),
        named("stiffness", UnitLabels::stiffness),
        named("area", UnitLabels::area),
        "regions".to_owned(),
        named("mean pressure", UnitLabels::pressure),
        named("largest pressure", UnitLabels::pressure),
        "method".to_owned(),
    ];
    let heads: [&str; 9] = std::array::from_fn(|k| heads[k].as_str());
    let rows = steps.iter().enumerate().map(|(k, step)| match numbers(step) {
        Some(s) => vec![
            (k + 1).to_string(),
            figure(s.depth),
            figure(s.force),
            figure(s.stiffness),
            figure(s.patch.area),
            s.patch.regions.to_string(),
            s.pressure.mean.map_or("-".to_owned(), figure),
            peak(s).unwrap_or_else(|| "-".to_owned()),
            s.method.name().to_owned(),
        ],
        None => {
            let mut row = vec!["-".to_owned(); heads.len()];
            row[0] = (k + 1).to_string();
            row[8] = step.as_ref().err().map_or(String::new(), |e| e.verdict.to_string());
            row
        }
    });
    table(&heads, &rows.collect::<Vec<_>>(), |_| false)
}

/// A picture in both widths with its caption; why there is none otherwise.
fn drawn(picture_on: impl Fn(Medium) -> Result<Vec<u8>, plot::Error>, caption: &str) -> String {
    match (picture_on(Medium::Page), picture_on(Medium::Phone)) {
        (Ok(page), Ok(phone)) => picture([&page, &phone], caption),
        (Err(e), _) | (_, Err(e)) => {
            format!("<p class=\"soft\">{}: {}.</p>\n", escaped(caption), escaped(&e.to_string()))
        }
    }
}

fn pictures(detail: &Detail, states: usize, units: &UnitLabels) -> String {
    let mut html = "<section>\n<h2>Patch and section</h2>\n".to_owned();
    if states > 1 {
        let _ = writeln!(html, "<p>State {} of {states}.</p>", detail.index + 1);
    }
    if let Err(e) = &detail.grid {
        let _ = writeln!(html, "<p class=\"soft\">No pressure map: {}.</p>", escaped(&e.to_string()));
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
    html.push_str("<div class=\"pair\">\n");
    html.push_str(&drawn(
        |medium| plot::outlines_on(medium, units, "", &drawn_boundaries, Format::Svg),
        "The contact patch by every method that gives its boundary.",
    ));
    if let Some(section) = &detail.section {
        let reach = section.along.last().copied().unwrap_or(0.0);
        let centre = pair(section.centre, reach);
        let angle = section.direction[1].atan2(section.direction[0]).to_degrees();
        let angle = if angle.abs() < 0.05 { 0.0 } else { angle };
        html.push_str(&drawn(
            |medium| plot::section_on(medium, units, "", section, Format::Svg),
            &format!(
                "Section through the centre of pressure {centre} at {angle:.1} degrees to x, where the pressure is spread \
                 widest. Heights count from the undeformed surface."
            ),
        ));
    }
    html + "</div>\n</section>\n"
}

fn curve(evidence: &Evidence, units: &UnitLabels) -> String {
    let told = match &evidence.curve {
        Some(Ok(curve)) => {
            let law = curve.power_law();
            let within =
                if law.error < 5e-5 { "to rounding".to_owned() } else { format!("within {:.2} %", 100.0 * law.error) };
            format!(
                "{}<p>{} solved; error of interpolation about {}. Least squares over the range: force = {} · \
                 overlap<sup>{:.4}</sup>, {within}.</p>\n",
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
                law.exponent,
            )
        }
        // The states themselves, where there are several.
        _ if evidence.steps.len() > 1 => {
            let states: Vec<[f64; 3]> =
                evidence.steps.iter().filter_map(numbers).map(|s| [s.depth, s.force, s.stiffness]).collect();
            if states.iter().all(|s| s[1] == 0.0) {
                return String::new();
            }
            drawn(
                |medium| plot::states_on(medium, units, "", &states, None, Format::Svg),
                "Force against depth, the states of the scene.",
            )
        }
        Some(Err(why)) => format!("<p class=\"soft\">{}</p>\n", escaped(why)),
        None => return String::new(),
    };
    format!("<section>\n<h2>Force against depth</h2>\n{told}</section>\n")
}

fn comparison(comparison: &Comparison) -> String {
    let mut html = "<section>\n<h2>Every method</h2>\n".to_owned();
    if let Some(r) = &comparison.reference {
        let _ = writeln!(
            html,
            "<p>Reference: {}. Force {}, relative error about {}.{}</p>",
            typeset(&r.source),
            typeset(&figure(r.force)),
            typeset(&format!("{:.1e}", r.uncertainty)),
            r.bracket.as_ref().map_or(String::new(), |b| format!(" Its {}.", typeset(&in_words(b))))
        );
    }
    let rows: Vec<Vec<String>> = comparison.runs.iter().map(|run| row(run).to_vec()).collect();
    let on_front = |k: usize| comparison.runs[k].outcome.as_ref().is_ok_and(|f| f.behind <= 1.0);
    html.push_str(&table(&COLUMNS, &rows, on_front));
    html.push_str(
        "<p class=\"soft\">behind: run time over that of the quickest run as close to the reference; shaded lines (*) are the \
         Pareto front. patch diff.: area in one patch but not in both, over the reference's; pressure diff.: integral of the \
         difference over the force; bytes: most heap held at once.</p>\n",
    );
    html.push_str(&list(comparison.remarks.iter().map(String::as_str)));
    html.push_str(&drawn(
        |medium| plot::error_against_time_on(medium, "", comparison, Format::Svg),
        "Relative error of the force against run time, one line a method.",
    ));
    html + "</section>\n"
}

fn brackets(detail: &Detail) -> String {
    let mut html = "<section>\n<h2>Bounds of the force</h2>\n".to_owned();
    if detail.brackets.is_empty() {
        return html + "<p class=\"soft\">No grid gave a bracket.</p>\n</section>\n";
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
    html.push_str(&table(&heads, &rows.collect::<Vec<_>>(), |_| false));
    let points = |of: &dyn Fn(&super::evidence::Bracketing) -> f64| {
        detail.brackets.iter().map(|b| [b.cells as f64, of(b)]).collect::<Vec<_>>()
    };
    let mut lines =
        vec![Refinement { label: "width of the bracket".into(), points: points(&|b| b.bracket.relative_width()) }];
    if let Some(r) = detail.comparison.as_ref().and_then(|c| c.reference.as_ref()) {
        let error = |b: &super::evidence::Bracketing| (b.force / r.force - 1.0).abs();
        lines.push(Refinement { label: "error of the grid's force".into(), points: points(&error) });
    }
    html.push_str(&drawn(
        |medium| plot::width_against_cells_on(medium, "", &lines, Format::Svg),
        "What is proved or sampled of the force narrows with the cells, behind the error itself.",
    ));
    html + "</section>\n"
}

fn cost(evidence: &Evidence) -> String {
    let mut html = "<section>\n<h2>Cost</h2>\n".to_owned();
    let costs: Vec<_> = evidence.steps.iter().filter_map(numbers).map(|s| s.cost).collect();
    if !costs.is_empty() {
        let total = |of: fn(&crate::Cost) -> usize| costs.iter().map(of).sum::<usize>().to_string();
        let unknowns = costs.iter().map(|c| c.unknowns).max().unwrap_or(0);
        let mut rows = vec![
            ("seconds of the answer", format!("{:.2e}", costs.iter().map(|c| c.seconds).sum::<f64>())),
            ("unknowns of the largest system", unknowns.to_string()),
            ("iterations", total(|c| c.iterations)),
            ("products with the compliance operator", total(|c| c.operator_products)),
        ];
        // A formula has none of them.
        rows.retain(|(_, value)| value != "0");
        html.push_str(&facts(&rows));
    }
    let sum: f64 = evidence.seconds.iter().map(|(_, s)| s).sum();
    let mut rows: Vec<Vec<String>> =
        evidence.seconds.iter().map(|(what, s)| vec![(*what).to_owned(), format!("{s:.3}")]).collect();
    rows.push(vec!["all of this report".to_owned(), format!("{sum:.3}")]);
    html + &table(&["part of this report", "seconds"], &rows, |_| false) + "</section>\n"
}
