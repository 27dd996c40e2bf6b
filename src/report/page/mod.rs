//! The report: one page that needs nothing else, for the screen and for paper.

mod answer;
mod evidence;
mod html;
mod pictures;
mod view;

pub use evidence::Parts;

use super::numbers;
use super::table::figure;
use crate::compare;
use crate::problem::{Load, Method};
use crate::scene::Scene;
use crate::units::UnitLabels;
use evidence::Evidence;
use html::{Html, facts, html, list, section, table, typeset};

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
/// answers, pictures, curve, comparison, brackets, plan, cost and problem. `say` is called with what is being done.
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
    let name = scene.name.as_deref().unwrap_or("Contact without a name");
    let units = scene.units.as_ref();
    let labels = units.cloned().unwrap_or_else(UnitLabels::kinds);
    let detail = evidence.detail.as_ref();
    // The picture of the first screen, with what a script needs to answer for it.
    let main = detail.and_then(|detail| view::view(detail.grid.as_ref().ok()?, &labels)).unwrap_or_default();
    let script = if main.is_empty() { "" } else { concat!("<script>\n", include_str!("page.js"), "</script>\n") };
    let comparison = detail.and_then(|d| d.comparison.as_ref());
    let sections = [
        answer::head(name, &evidence, units, main),
        answer::result(&evidence, scene),
        detail.map_or(Html::default(), |d| pictures::patch(d, evidence.steps.len(), &labels)),
        pictures::curve(&evidence, &labels),
        comparison.map_or(Html::default(), pictures::comparison),
        detail.filter(|_| parts.bounds).map_or(Html::default(), pictures::brackets),
        plan(&evidence),
        cost(&evidence),
        section("Not in this report", list(evidence.skipped.iter().map(String::as_str))),
        problem(scene),
        provenance(made),
    ];
    // Nothing may be fetched, whatever a scene's texts hold.
    let page = html!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n{}\
         <footer>contact-patch {}. Numbers are in the units of the scene; angles there are in degrees.</footer>\n</main>\n{}</body>\n\
         </html>\n",
        name,
        Html::markup(include_str!("page.css")),
        sections.into_iter().collect::<Html>(),
        env!("CARGO_PKG_VERSION"),
        Html::markup(script)
    );
    Page { html: page.into_string(), solved: evidence.steps.iter().all(Result::is_ok) }
}

fn provenance(made: &Provenance) -> Html {
    let rows = [
        ("by", made.author.clone()),
        ("written", made.written.clone()),
        ("program", Some(format!("contact-patch {}", env!("CARGO_PKG_VERSION")))),
    ];
    let known = rows.into_iter().filter_map(|(name, value)| Some((name, html!("{}", value?))));
    let command = made.command.as_ref().map_or(Html::default(), |command| html!("<pre>{}</pre>\n", command));
    section("How this page was made", html!("{}{}", facts(known), command))
}

fn problem(scene: &Scene) -> Html {
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
    let rows = [
        ("effective modulus E*", figure(scene.contact.modulus().e_star())),
        ("loading", loading),
        ("relative error of the force asked for", format!("{:e}", scene.settings.tolerance)),
    ];
    let told = html!(
        "{}<details>\n<summary>The scene</summary>\n<pre>{}</pre>\n</details>\n",
        facts(rows.each_ref().map(|(name, value)| (*name, typeset(value)))),
        document
    );
    section("Problem", told)
}

fn plan(evidence: &Evidence) -> Html {
    let told = match &evidence.plan {
        Ok(plan) => html!(
            "<p>Method: <b>{}</b></p>\n{}{}{}",
            plan.method.map_or("none", Method::name),
            list(plan.steps.iter().map(String::as_str)),
            if plan.left_out.is_empty() { Html::default() } else { html!("<p>Left out:</p>\n") },
            list(plan.left_out.iter().map(String::as_str))
        ),
        Err(unsolved) => html!("<p>Nothing can be planned: {}.</p>\n", unsolved.to_string()),
    };
    section("Plan", told)
}

fn cost(evidence: &Evidence) -> Html {
    let mut told = Html::default();
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
        told = facts(rows.iter().map(|(name, value)| (*name, typeset(value))));
    }
    let sum: f64 = evidence.seconds.iter().map(|(_, s)| s).sum();
    let mut rows: Vec<Vec<String>> =
        evidence.seconds.iter().map(|(what, s)| vec![(*what).to_owned(), format!("{s:.3}")]).collect();
    rows.push(vec!["all of this report".to_owned(), format!("{sum:.3}")]);
    let parts = table(&["part of this report", "seconds"], &rows, |_| false);
    section("Cost", html!("{}{}", told, parts))
}
