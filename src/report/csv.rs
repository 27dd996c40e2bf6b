//! The result as comma-separated values: a header, then a line a state of loading.

use std::fmt::Write;

use super::{Step, numbers};

const HEADER: &str = "depth,force,force_error,stiffness,area,centroid_x,centroid_y,regions,max_radius,pressure_max,\
                      pressure_mean,energy,method,verdict,reason\n";

/// The steps as CSV; one that was not solved has the best numbers there are beside its verdict. What is not known is an empty field; the last field is quoted.
#[must_use]
pub fn csv(steps: &[Step]) -> String {
    let mut text = HEADER.to_owned();
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
                ]
                .join(",")
            }
            None => format!("{},{verdict},{reason}", ",".repeat(12)),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "{line}");
    }
    text
}
