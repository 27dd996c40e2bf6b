//! The Pareto front of error and run time, and how far behind it each run lies.

use super::{Figures, Run};
use crate::problem::Method;

/// Fills in how far behind the Pareto front of error and run time each run lies.
pub(super) fn rank(runs: &mut [Run], uncertainty: f64) {
    let size = |f: &Figures| f.error.abs().max(uncertainty);
    let points: Vec<(f64, f64)> = runs.iter().flat_map(|r| &r.outcome).map(|f| (size(f), f.seconds)).collect();
    for figures in runs.iter_mut().flat_map(|r| &mut r.outcome) {
        let error = size(figures);
        let as_close = points.iter().filter(|p| p.0 <= error).map(|p| p.1);
        let quickest = as_close.fold(figures.seconds, f64::min);
        // A run too short for the clock is on the front.
        figures.behind = if quickest > 0.0 { figures.seconds / quickest } else { 1.0 };
    }
}

/// Run times closer than this are the same.
const BESIDE: f64 = 1.2;

/// How far `auto` lies from the front, in words.
pub(super) fn of_auto(runs: &[Run]) -> Option<String> {
    let auto = runs.iter().filter(|r| r.method == Method::Auto);
    let told: Vec<String> = auto
        .filter_map(|run| {
            let figures = run.outcome.as_ref().ok()?;
            let at = run.tolerance.map_or(String::new(), |t| format!(" at {t:e}"));
            Some(if figures.behind <= BESIDE {
                format!("on or beside the front{at}")
            } else {
                format!("{:.1} times as long as the quickest run as close{at}", figures.behind)
            })
        })
        .collect();
    (!told.is_empty()).then(|| format!("auto: {}", told.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(method: Method, error: f64, seconds: f64) -> Run {
        let figures = Figures {
            ran: Method::Fft,
            force: 1.0,
            error,
            estimate: None,
            area: 1.0,
            area_error: 0.0,
            patch_difference: None,
            pressure_difference: None,
            unknowns: 1,
            products: 1,
            seconds,
            peak_bytes: None,
            behind: 0.0,
        };
        Run { method, cells: None, tolerance: None, outcome: Ok(figures) }
    }

    #[test]
    fn behind_the_front() {
        let times = [(1e-2, 1.0), (-1e-3, 2.0), (2e-3, 3.0), (1e-7, 8.0), (1e-9, 9.0)];
        let mut runs = times.map(|(error, seconds)| run(Method::Fft, error, seconds));
        rank(&mut runs, 1e-6);
        let behind: Vec<f64> = runs.iter().map(|r| r.outcome.as_ref().unwrap().behind).collect();
        assert_eq!(behind, [1.0, 1.0, 1.5, 1.0, 9.0 / 8.0]);
    }

    #[test]
    fn auto_is_told_apart() {
        let mut runs = [run(Method::Fft, 1e-3, 2.0), run(Method::Auto, 2e-3, 5.0), run(Method::Auto, 1e-5, 6.0)];
        rank(&mut runs, 0.0);
        assert_eq!(
            of_auto(&runs).unwrap(),
            "auto: 2.5 times as long as the quickest run as close; on or beside the front"
        );
        assert_eq!(of_auto(&runs[..1]), None);
    }
}
