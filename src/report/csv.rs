//! The result as comma-separated values: a header, then a line a state of loading.

use std::fmt::Write;

use super::{Step, numbers};
use crate::solution::Singular;
use crate::units::UnitLabels;

const HEADER: &str = "depth,force,force_error,stiffness,area,centroid_x,centroid_y,regions,max_radius,pressure_max,\
                      pressure_mean,energy,method,verdict,reason,depth_error,stiffness_error,energy_error,area_error,\
                      pressure_max_error,pressure_singular,touches_edge\n";

/// The steps as CSV; one that was not solved has the best numbers there are beside its verdict. What is not known is an empty field;
/// the reason is quoted.
#[must_use]
pub fn csv(steps: &[Step]) -> String {
    csv_in(None, steps)
}

/// As [`csv()`], with units in the heads of the columns: `depth [mm]`.
#[must_use]
pub fn csv_in(units: Option<&UnitLabels>, steps: &[Step]) -> String {
    let mut text = header(units);
    let number = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or(String::new(), |x| format!("{x:e}"));
    for step in steps {
        let (verdict, reason) = match step {
            Ok(_) => ("solved", String::new()),
            Err(e) => (e.verdict.word(), format!("\"{}\"", e.reason.replace('"', "\"\""))),
        };
        let line = match numbers(step) {
            Some(s) => {
                let centroid = s.patch.centroid;
                [
                    number(Some(s.depth)),
                    number(Some(s.force)),
                    number(s.force_error),
                    number(Some(s.stiffness)),
                    number(Some(s.patch.area)),
                    number(centroid.map(|c| c[0])),
                    number(centroid.map(|c| c[1])),
                    s.patch.regions.to_string(),
                    number(Some(s.patch.max_radius)),
                    number(s.pressure.max),
                    number(s.pressure.mean),
                    number(s.energy),
                    s.method.name().to_owned(),
                    verdict.to_owned(),
                    reason,
                    number(s.depth_error),
                    number(s.stiffness_error),
                    number(s.energy_error),
                    number(s.area_error),
                    number(s.pressure.max_error),
                    s.pressure.singular.map_or("", Singular::word).to_owned(),
                    s.touches_edge.map_or("", |touched| touched.edge.word()).to_owned(),
                ]
                .join(",")
            }
            None => format!("{},{verdict},{reason}{}", ",".repeat(12), ",".repeat(7)),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "{line}");
    }
    text
}

/// The names of the columns, with their units where those are known.
fn header(units: Option<&UnitLabels>) -> String {
    let Some(units) = units else { return HEADER.to_owned() };
    let unit = |name: &str| match name {
        "depth" | "centroid_x" | "centroid_y" | "max_radius" => Some(units.length().to_owned()),
        "force" => Some(units.force().to_owned()),
        "stiffness" => Some(units.stiffness()),
        "area" => Some(units.area()),
        "pressure_max" | "pressure_mean" => Some(units.pressure()),
        "energy" => Some(units.work()),
        _ => None,
    };
    let named = |name: &str| unit(name).map_or(name.to_owned(), |unit| format!("{name} [{unit}]"));
    HEADER.trim_end().split(',').map(named).collect::<Vec<_>>().join(",") + "\n"
}

const PIECES: &str = "state,piece,area,force,centroid_x,centroid_y,x0,y0,x1,y1,max_pressure\n";

/// The pieces of all patches as CSV: a header, then a line a piece, states and pieces counted from 1, largest force first. A largest
/// pressure that is infinite or not given is an empty field.
#[must_use]
pub fn pieces_csv(units: Option<&UnitLabels>, steps: &[Step]) -> String {
    let mut text = match units {
        None => PIECES.to_owned(),
        Some(u) => {
            let (l, p) = (u.length(), u.pressure());
            format!(
                "state,piece,area [{}],force [{}],centroid_x [{l}],centroid_y [{l}],x0 [{l}],y0 [{l}],x1 [{l}],y1 [{l}],max_pressure [{p}]\n",
                u.area(),
                u.force()
            )
        }
    };
    for (k, solution) in steps.iter().enumerate().filter_map(|(k, step)| numbers(step).map(|s| (k, s))) {
        for (n, piece) in solution.patch.pieces.iter().enumerate() {
            let [[x0, y0], [x1, y1]] = piece.extent;
            let [x, y] = piece.centroid;
            let peak = piece.max_pressure.map_or(String::new(), |p| format!("{p:e}"));
            let (area, force) = (piece.area, piece.force);
            // Writing to a string does not fail.
            let _ =
                writeln!(text, "{},{},{area:e},{force:e},{x:e},{y:e},{x0:e},{y0:e},{x1:e},{y1:e},{peak}", k + 1, n + 1);
        }
    }
    text
}
