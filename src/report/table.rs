//! The result as a short table for people. Units are the user's own, so none are named.

use super::{Step, numbers, said_once};
use crate::bracket::Evidence;
use crate::contact::Loading;
use crate::scene::Scene;
use crate::solution::Solution;

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
            rows.extend(numbers(step).map(single).unwrap_or_default());
            lines.extend(aligned(&rows));
        }
        _ => several(steps, &mut lines),
    }
    lines.extend(said_once(steps, |s| &s.remarks).iter().map(|remark| format!("note: {remark}")));
    lines.extend(said_once(steps, |s| &s.left_out).iter().map(|what| format!("left out: {what}")));
    lines.push(String::new());
    lines.join("\n")
}

fn single(s: &Solution) -> Vec<[String; 2]> {
    let mut rows = vec![["method".into(), s.method.name().to_owned()], ["depth".into(), figure(s.depth)]];
    if s.tilt != [0.0; 2] {
        rows.push(["tilt".into(), pair(s.tilt)]);
    }
    let error = s.force_error.map_or(String::new(), |e| format!("  (relative error about {e:.1e})"));
    rows.push(["force".into(), format!("{}{error}", figure(s.force))]);
    if let Some(b) = &s.bracket {
        let evidence = match b.evidence() {
            Evidence::Proved => "proved".to_owned(),
            Evidence::Sampled { per_cell: 0 } => {
                format!("sampled: {} below, {} above", b.lower_side().theorem().name(), b.upper_side().theorem().name())
            }
            Evidence::Sampled { per_cell } => format!("sampled at {per_cell} x {per_cell} points a cell"),
        };
        rows.push(["bracket".into(), format!("{:.8e} to {:.8e}  ({evidence})", b.lower(), b.upper())]);
    }
    if let Some(d) = &s.depth_bracket {
        let upper = d.upper().map_or("any".to_owned(), |upper| format!("{upper:.8e}"));
        rows.push(["bracket of the depth".into(), format!("{:.8e} to {upper}", d.lower())]);
    }
    rows.push(["stiffness".into(), figure(s.stiffness)]);
    if let Some(moment) = s.moment.filter(|m| m.iter().any(|m| *m != 0.0)) {
        rows.push(["moments about the origin".into(), pair(moment)]);
    }
    if let Some(energy) = s.energy {
        rows.push(["energy".into(), figure(energy)]);
    }
    rows.push(["patch area".into(), figure(s.patch.area)]);
    rows.push(["patch regions".into(), s.patch.regions.to_string()]);
    rows.push(["largest radius".into(), figure(s.patch.max_radius)]);
    if let Some(mean) = s.pressure.mean {
        rows.push(["mean pressure".into(), figure(mean)]);
    }
    if let Some(max) = s.pressure.max {
        let at = s.pressure.at.map_or(String::new(), |at| format!("  at {}", pair(at)));
        rows.push(["largest pressure".into(), format!("{}{at}", figure(max))]);
    }
    if let Some(r) = s.residuals {
        let [c, t, p] = [r.complementarity, r.tension, r.penetration];
        rows.push(["checks".into(), format!("complementarity {c:.1e}, tension {t:.1e}, penetration {p:.1e}")]);
    }
    let cost = &s.cost;
    rows.push([
        "cost".into(),
        format!(
            "{:.3} s, {} unknowns, {} iterations, {} products",
            cost.seconds, cost.unknowns, cost.iterations, cost.operator_products
        ),
    ]);
    rows
}

fn several(steps: &[Step], lines: &mut Vec<String>) {
    let heads = ["depth", "force", "stiffness", "area", "regions", "largest radius", "mean pressure", "method", "s"];
    let mut rows = vec![heads.map(str::to_owned)];
    rows.extend(steps.iter().map(|step| match numbers(step) {
        Some(s) => [
            figure(s.depth),
            figure(s.force),
            figure(s.stiffness),
            figure(s.patch.area),
            s.patch.regions.to_string(),
            figure(s.patch.max_radius),
            s.pressure.mean.map_or("-".into(), figure),
            s.method.name().to_owned(),
            format!("{:.3}", s.cost.seconds),
        ],
        None => {
            let mut row: [String; 9] = std::array::from_fn(|_| "-".to_owned());
            row[7] = step.as_ref().err().map_or(String::new(), |e| e.verdict.to_string());
            row
        }
    }));
    lines.extend(aligned(&rows));
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
