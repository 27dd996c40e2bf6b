//! The answer of a page: the verdict, the key numbers, every number of the states.

use super::evidence::Evidence;
use super::html::{Html, facts, html, list, section, table, typeset};
use crate::report::table::{facts as state_facts, figure, peak};
use crate::report::{Step, numbers, said_once};
use crate::scene::Scene;
use crate::solution::Solution;
use crate::units::UnitLabels;

/// The verdict and the key numbers, with the picture of the first screen.
pub(super) fn head(name: &str, evidence: &Evidence, units: Option<&UnitLabels>, main: Html) -> Html {
    let verdict = match evidence.steps.iter().find_map(|step| step.as_ref().err()) {
        None => html!("<p class=\"verdict\">solved</p>\n"),
        Some(e) => html!(
            "<p class=\"verdict no\">not solved: {}</p>\n<p>{}</p>\n{}",
            e.verdict.word(),
            e.reason,
            e.hint.as_ref().map_or(Html::default(), |hint| html!("<p>What to try: {}.</p>\n", hint))
        ),
    };
    let mut told = Html::default();
    let states = evidence.steps.len();
    if let Some((k, s)) = evidence.detail.as_ref().and_then(|d| Some((d.index, numbers(&evidence.steps[d.index])?))) {
        if states > 1 {
            told.push(&html!("<p class=\"soft\">State {} of {}:</p>\n", k + 1, states));
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
        let item = |(what, value, error): (&str, String, String)| {
            let error = if error.is_empty() { Html::default() } else { html!("<small>{}</small>", typeset(&error)) };
            html!("<li><span>{}</span><b>{}</b>{}</li>\n", what, typeset(&value), error)
        };
        told.push(&html!("<ul class=\"key\">\n{}</ul>\n", keys.into_iter().map(item).collect::<Html>()));
    }
    html!("<header>\n<div class=\"answer\">\n<h1>{}</h1>\n{}{}</div>\n{}</header>\n", name, verdict, told, main)
}

/// Every number of the states.
pub(super) fn result(evidence: &Evidence, scene: &Scene) -> Html {
    let told = match &evidence.steps[..] {
        [step] => numbers(step).map_or(Html::default(), |s| single(s, scene)),
        steps => several(steps, scene.units.as_ref()),
    };
    if told.is_empty() {
        return told;
    }
    let remarks = said_once(&evidence.steps, |s| &s.remarks);
    let left_out = match &said_once(&evidence.steps, |s| &s.left_out)[..] {
        [] => Html::default(),
        what => html!("<p class=\"soft\">Left out: {}.</p>\n", what.join("; ")),
    };
    section("Result", html!("{}{}{}", told, list(remarks), left_out))
}

fn single(s: &Solution, scene: &Scene) -> Html {
    let rows = state_facts(s, scene);
    // What it took has a section of its own.
    let shown = rows.iter().filter(|[name, _]| name != "cost");
    facts(shown.map(|[name, value]| (name.as_str(), typeset(value))))
}

fn several(steps: &[Step], units: Option<&UnitLabels>) -> Html {
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
