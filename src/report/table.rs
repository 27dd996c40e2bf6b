//! The result as a short table for people, with the units that the scene names.

use super::{Step, centre_of_pressure, numbers, said_once};
use crate::bracket::Evidence;
use crate::overlap::least;
use crate::problem::{Load, Loading};
use crate::scene::Scene;
use crate::solution::{ForceEvidence, Origin, Singular, Solution};
use crate::units::UnitLabels;

/// A table of the answers: a line a quantity for one state of loading, a line a state for several.
#[must_use]
pub fn table(scene: &Scene, steps: &[Step]) -> String {
    let mut lines: Vec<String> = scene.name.iter().map(|name| name.escape_debug().to_string()).collect();
    match (scene.contact.loading(), steps) {
        (Loading::Single(_), [step]) => {
            let mut rows = Vec::new();
            if let Err(e) = step {
                rows = vec![["verdict".into(), e.verdict.to_string()], ["reason".into(), e.reason.clone()]];
                rows.extend(e.hint.iter().map(|hint| ["hint".into(), hint.clone()]));
            }
            rows.extend(numbers(step).map(|s| facts(s, scene)).unwrap_or_default());
            lines.extend(aligned(&rows));
        }
        _ => several(scene, steps, &mut lines),
    }
    lines.extend(said_once(steps, |s| &s.remarks).iter().map(|remark| format!("note: {remark}")));
    lines.extend(said_once(steps, |s| &s.left_out).iter().map(|what| format!("left out: {what}")));
    lines.push(String::new());
    lines.join("\n")
}

/// Pieces of a patch that a table names.
const MOST_PIECES: usize = 5;

/// One state as lines of a name and a value.
pub(super) fn facts(s: &Solution, scene: &Scene) -> Vec<[String; 2]> {
    let units = scene.units.as_ref();
    let length = units.map_or(String::new(), |u| format!(" {}", u.length()));
    let unit = |of: fn(&UnitLabels) -> String| units.map_or(String::new(), |u| format!(" {}", of(u)));
    let (force, pressure) = (unit(|u| u.force().to_owned()), unit(UnitLabels::pressure));
    let fine = fineness(s);
    let point = |p: [f64; 2]| format!("({}, {})", place(p[0], fine), place(p[1], fine));
    let prescribed = |error: Option<f64>, other: Option<f64>| match (error, other) {
        (Some(0.0), other) if other != Some(0.0) && s.force > 0.0 => "  (prescribed)".to_owned(),
        (error, _) => off_by(error),
    };
    let mut rows: Vec<[String; 2]> = Vec::new();
    let mut row = |name: &str, value: String| rows.push([name.to_owned(), value]);
    let exact = if s.evidence() == ForceEvidence::Exact { "  (exact to rounding)" } else { "" };
    row("method", format!("{}{exact}", s.method.name()));
    if let Some(grid) = &s.grid {
        let [[nx, ny], [h, v]] = [grid.shape.map(|n| n as f64), grid.spacing];
        let sides = if (h / v - 1.0).abs() < 1e-9 { figure(h) } else { format!("{} x {}", figure(h), figure(v)) };
        row("grid", format!("{nx} x {ny} cells of {sides}{length}"));
    }
    match approach(s, scene) {
        None => row("depth", format!("{}{length}{}", figure(s.depth), prescribed(s.depth_error, s.force_error))),
        Some((approach, error)) => {
            row("depth", format!("{}{length}", figure(s.depth)));
            row(
                "approach from first touch",
                format!("{}{length}{}", figure(approach), prescribed(error, s.force_error)),
            );
        }
    }
    if s.tilt != [0.0; 2] {
        row("tilt", pair(s.tilt));
    }
    row("force", format!("{}{force}{}", figure(s.force), prescribed(s.force_error, s.depth_error)));
    if let Some(b) = &s.bracket {
        let evidence = match b.evidence() {
            Evidence::Proved => "proved".to_owned(),
            Evidence::Sampled { per_cell: 0 } => {
                format!("sampled: {} below, {} above", b.lower_side().theorem().name(), b.upper_side().theorem().name())
            }
            Evidence::Sampled { per_cell } => format!("sampled at {per_cell} x {per_cell} points a cell"),
        };
        row("bracket", format!("{:.8e} to {:.8e}{force}  ({evidence})", b.lower(), b.upper()));
    }
    if let Some(d) = &s.depth_bracket {
        let upper = d.upper().map_or("any".to_owned(), |upper| format!("{upper:.8e}"));
        row("bracket of the depth", format!("{:.8e} to {upper}{length}", d.lower()));
    }
    let stiffness = unit(UnitLabels::stiffness);
    row("stiffness", format!("{}{stiffness}{}", figure(s.stiffness), off_by(s.stiffness_error)));
    let rounding = fine * s.force;
    if let Some(moment) = s.moment.filter(|m| m.iter().any(|m| m.abs() > rounding)) {
        let moment = moment.map(|m| if m.abs() > rounding { m } else { 0.0 });
        row("moments about the origin", format!("{}{}", pair(moment), unit(UnitLabels::work)));
        if let Some(b) = &s.moment_bracket {
            row(
                "bracket of the moments",
                format!("{} to {}{}", pair(b.lower()), pair(b.upper()), unit(UnitLabels::work)),
            );
        }
    }
    if let Some(energy) = s.energy {
        row("energy", format!("{}{}{}", figure(energy), unit(UnitLabels::work), off_by(s.energy_error)));
    }
    row("patch area", format!("{}{}{}", figure(s.patch.area), unit(UnitLabels::area), off_by(s.area_error)));
    if let (Some([a, b]), Some(angle)) = (s.patch.semi_axes, s.patch.angle) {
        let turned =
            format!(", the longer at {:.4} degrees to x", if angle.abs() < 1e-9 { 0.0 } else { angle.to_degrees() });
        if a == b {
            row("radius", format!("{}{length}", place(a, fine)));
        } else {
            row("semi-axes", format!("{} and {}{length}{turned}", place(a, fine), place(b, fine)));
        }
    }
    if let Some([low, high]) = s.patch.extent() {
        let corner = |p: [f64; 2]| format!("({}, {})", border(p[0], s), border(p[1], s));
        row("patch extent", format!("{} to {}{length}", corner(low), corner(high)));
    }
    let centres = [s.patch.centroid, centre_of_pressure(s)].map(|c| c.map(point));
    match centres {
        [Some(centroid), Some(centre)] if centroid == centre => {
            row("centroid and centre of pressure", format!("{centre}{length}"));
        }
        [centroid, centre] => {
            for (name, at) in [("patch centroid", centroid), ("centre of pressure", centre)] {
                if let Some(at) = at {
                    row(name, format!("{at}{length}"));
                }
            }
        }
    }
    row("patch regions", s.patch.regions.to_string());
    if s.patch.semi_axes.is_none() {
        row("farthest from the origin", format!("{}{length}", border(s.patch.max_radius, s)));
    }
    if let Some(mean) = s.pressure.mean {
        row("mean pressure", format!("{}{pressure}{}", figure(mean), off_by(mean_error(s))));
    }
    if let Some(peak) = peak(s) {
        let at = s.pressure.at.filter(|_| s.force > 0.0).map_or(String::new(), |at| format!("  at {}", point(at)));
        let (unit, error) = if s.pressure.singular.is_some() {
            ("", String::new())
        } else {
            (pressure.as_str(), off_by(s.pressure.max_error))
        };
        row("largest pressure", format!("{peak}{unit}{error}{at}"));
    }
    for (k, piece) in s.patch.pieces.iter().enumerate().take(MOST_PIECES).filter(|_| s.patch.pieces.len() > 1) {
        let peak = match (piece.max_pressure, s.pressure.singular) {
            (Some(p), _) => format!(", largest pressure {}{pressure}", figure(p)),
            (None, Some(_)) => ", largest pressure infinite".to_owned(),
            (None, None) => String::new(),
        };
        let area = unit(UnitLabels::area);
        let (own_force, own_area) = (figure(piece.force), figure(piece.area));
        let at = point(piece.centroid);
        row(&format!("piece {}", k + 1), format!("force {own_force}{force}, area {own_area}{area}, at {at}{peak}"));
    }
    if s.patch.pieces.len() > MOST_PIECES {
        let rest: f64 = s.patch.pieces[MOST_PIECES..].iter().map(|piece| piece.force).sum();
        let count = s.patch.pieces.len() - MOST_PIECES;
        row("other pieces", format!("{count}, with {} % of the force", percent(rest / s.force)));
    }
    if let Some(touched) = s.touches_edge {
        let share = touched
            .share
            .map_or(String::new(), |share| format!(", {} % of the force on the cells beside it", percent(share)));
        row("touches the edge of the", format!("{}{share}", touched.edge.word()));
    }
    if let Some(v) = &s.validity {
        let size = v.size_over_radius.map_or(String::new(), |size| format!("size over radius {size:.1e}, "));
        let (slope, hard) = (v.slope, v.pressure_over_modulus);
        row("small against 1", format!("slope {slope:.1e}, {size}mean pressure over E* {hard:.1e}"));
    }
    if let Some(r) = s.residuals {
        let [c, t, p] = [r.complementarity, r.tension, r.penetration];
        row("checks", format!("complementarity {c:.1e}, tension {t:.1e}, penetration {p:.1e}"));
    }
    let cost = &s.cost;
    let mut took =
        vec![if cost.seconds < 1e-3 { "less than a millisecond".to_owned() } else { format!("{:.3} s", cost.seconds) }];
    let counts = [(cost.unknowns, "unknowns"), (cost.iterations, "iterations"), (cost.operator_products, "products")];
    took.extend(counts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    row("cost", took.join(", "));
    rows
}

/// The depth below first touch and its relative error, where first touch is not at depth 0.
fn approach(s: &Solution, scene: &Scene) -> Option<(f64, Option<f64>)> {
    let touch = least(scene.contact.gap()).1;
    let approach = s.depth - touch;
    let shifted = s.tilt == [0.0; 2] && s.force > 0.0 && touch.abs() > SHIFTED * approach.abs();
    (shifted && approach > 0.0).then(|| (approach, s.depth_error.map(|error| error * (s.depth / approach).abs())))
}

/// Share of the approach from which on the depth of first touch is worth a line.
const SHIFTED: f64 = 1e-6;

/// Relative error of the mean pressure.
fn mean_error(s: &Solution) -> Option<f64> {
    s.area_error.zip(s.force_error).map(|(area, force)| area + force)
}

/// What places and lengths of the patch are known to.
fn fineness(s: &Solution) -> f64 {
    let size = s.patch.area.sqrt();
    match (&s.grid, s.origin) {
        (Some(grid), origin) if origin != Origin::ClosedForm => 0.5 * grid.spacing[0].max(grid.spacing[1]),
        _ => size * s.area_error.unwrap_or(0.0).max(1e-8),
    }
}

/// A length with the digits that it is known to; 0 where it is not known to be another.
fn place(x: f64, fineness: f64) -> String {
    beyond(x, fineness, 1.0)
}

/// A length that is known to this, with as many digits as if it were known to so many times that; 0 where it is not known to be another.
fn beyond(x: f64, error: f64, times: f64) -> String {
    if x.abs() <= error { "0".to_owned() } else { rounded(x, times * error / x.abs()) }
}

/// How far a patch reaches, with the digits that are certain.
fn border(x: f64, s: &Solution) -> String {
    if s.area_error.is_some_and(|error| error <= ROUNDING) {
        return place(x, 1e-8 * s.patch.area.sqrt());
    }
    beyond(x, CORNER * fineness(s), 10.0)
}

/// An acute corner of a patch, where the pressure fades, is found so many times less well than a smooth border: that of the
/// tetrahedral punch three half cells short on 40, 80 and 320 cells.
const CORNER: f64 = 3.0;

/// A number with the digits that its relative error leaves.
fn known(x: f64, error: Option<f64>) -> String {
    error.map_or_else(|| figure(x), |error| rounded(x, error))
}

/// One digit more than what the error leaves, six at most.
fn rounded(x: f64, error: f64) -> String {
    let digits = (1.0 - error.log10()).ceil().clamp(1.0, 6.0) as usize;
    let text = format!("{x:.*e}", digits - 1);
    let short = text.parse::<f64>().unwrap_or(x);
    let whole = figure(short);
    match whole.split_once('e') {
        Some(_) => text,
        None if digits < 6 && whole.contains('.') => whole.trim_end_matches('0').trim_end_matches('.').to_owned(),
        None => whole,
    }
}

/// A share in per cent, with no sign of what is less than is printed.
fn percent(share: f64) -> String {
    let share = 100.0 * share;
    if share.abs() < 0.005 { "less than 0.01".to_owned() } else { format!("{share:.2}") }
}

/// Relative errors below this are rounding.
const ROUNDING: f64 = 1e-12;

/// The relative error of a number, in brackets; nothing where it is rounding or not known.
fn off_by(error: Option<f64>) -> String {
    error
        .filter(|error| *error > ROUNDING)
        .map_or(String::new(), |error| format!("  (relative error about {error:.1e})"))
}

/// The largest pressure as it is printed; `None` where the method gives none.
pub(super) fn peak(s: &Solution) -> Option<String> {
    match (s.pressure.singular, s.pressure.max) {
        (Some(Singular::Edge), _) => Some("infinite (edge)".to_owned()),
        (Some(Singular::Tip), _) => Some("infinite (tip)".to_owned()),
        (None, max) => max.map(figure),
    }
}

fn several(scene: &Scene, steps: &[Step], lines: &mut Vec<String>) {
    let units = scene.units.as_ref();
    let head =
        |name: &str, of: fn(&UnitLabels) -> String| units.map_or(name.to_owned(), |u| format!("{name} [{}]", of(u)));
    let length: fn(&UnitLabels) -> String = |u| u.length().to_owned();
    let heads = [
        head("depth", length),
        head("force", |u| u.force().to_owned()),
        head("stiffness", UnitLabels::stiffness),
        head("area", UnitLabels::area),
        "regions".to_owned(),
        head("farthest", length),
        head("mean pressure", UnitLabels::pressure),
        head("largest pressure", UnitLabels::pressure),
        "error".to_owned(),
        "method".to_owned(),
        "s".to_owned(),
    ];
    let mut rows = vec![heads];
    rows.extend(steps.iter().map(|step| match numbers(step) {
        Some(s) => [
            figure(s.depth),
            figure(s.force),
            known(s.stiffness, s.stiffness_error),
            known(s.patch.area, s.area_error),
            s.patch.regions.to_string(),
            border(s.patch.max_radius, s),
            s.pressure.mean.map_or("-".into(), |mean| known(mean, mean_error(s))),
            peak(s).unwrap_or_else(|| "-".into()),
            s.error().map_or("-".into(), |error| format!("{error:.1e}")),
            s.method.name().to_owned(),
            format!("{:.3}", s.cost.seconds),
        ],
        None => {
            let mut row: [String; 11] = std::array::from_fn(|_| "-".to_owned());
            row[9] = step.as_ref().err().map_or(String::new(), |e| e.verdict.to_string());
            row
        }
    }));
    lines.extend(aligned(&rows));
    let forces = scene.contact.loading().loads().iter().any(|load| matches!(load, Load::Force(_)));
    lines.push(format!("error: relative, of the {}", if forces { "depth" } else { "force" }));
    for (k, step) in steps.iter().enumerate() {
        if let Err(e) = step {
            lines.push(format!("step {}: {e}", k + 1));
            lines.extend(e.hint.iter().map(|hint| format!("  hint: {hint}")));
        }
    }
}

/// Six digits; whole numbers and middling sizes plainly, the rest with an exponent.
pub(crate) fn figure(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    match x.abs().log10().floor() {
        e if (-3.0..6.0).contains(&e) => format!("{x:.*}", (5 - e as i32).max(0) as usize),
        _ => format!("{x:.5e}"),
    }
}

fn pair([x, y]: [f64; 2]) -> String {
    format!("({}, {})", figure(x), figure(y))
}

/// Rows as lines with columns in line, two spaces apart.
pub(crate) fn aligned<const N: usize>(rows: &[[String; N]]) -> Vec<String> {
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}
