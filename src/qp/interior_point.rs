//! The programme in Clarabel's form.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::reduced::Reduced;
use crate::clock::Deadline;
use crate::solution::{Unsolved, Verdict};

/// What the interior point ends with.
pub(super) struct Start {
    /// y of [`Reduced`].
    pub pressure: Vec<f64>,
    pub iterations: usize,
}

/// Minimise 1/2 y'S y - r'y over y >= 0.
///
/// Clarabel divides its residuals by max(1, norms): data far below 1 pass its tests at once, with a wrong answer and
/// the status `Solved`. [`Reduced`] is scaled to S_ii = 1 and max f = 1, and the status is never trusted: the caller
/// recomputes every residual.
pub(super) fn solve(reduced: &Reduced, deadline: Deadline) -> Result<Start, Unsolved> {
    let n = reduced.len();
    let settings = DefaultSettings::<f64> {
        verbose: false,
        max_threads: 1,
        // Clarabel counts elapsed time, which is never less than that of its one thread.
        time_limit: deadline.remaining(),
        direct_solve_method: "faer".to_owned(),
        presolve_enable: false,
        // S_ii = 1 and f <= 1 already: equilibration and refinement cost a third of the time and change nothing.
        equilibrate_enable: false,
        iterative_refinement_enable: false,
        ..DefaultSettings::default()
    };
    let q: Vec<f64> = reduced.overlap.iter().map(|r| -r).collect();
    let minus_identity = CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), vec![-1.0; n]);
    let cones = [SupportedConeT::NonnegativeConeT(n)];
    let mut solver = DefaultSolver::new(&upper_triangle(reduced), &q, &minus_identity, &vec![0.0; n], &cones, settings)
        .map_err(|e| Unsolved::new(Verdict::IterationLimit, format!("Clarabel refused the problem: {e}")))?;
    // An interrupt comes at any time.
    solver.set_termination_callback(move |_: &_| deadline.has_passed());
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => {}
        // An answer that stopped short still tells which cells touch; the polish and the residuals decide.
        SolverStatus::InsufficientProgress
        | SolverStatus::MaxIterations
        | SolverStatus::MaxTime
        | SolverStatus::CallbackTerminated
            if solver.solution.x.iter().all(|x| x.is_finite()) => {}
        status => {
            return Err(Unsolved::new(Verdict::IterationLimit, format!("Clarabel ended with status {status}")));
        }
    }
    Ok(Start { pressure: solver.solution.x.clone(), iterations: solver.solution.iterations as usize })
}

fn upper_triangle(reduced: &Reduced) -> CscMatrix<f64> {
    let n = reduced.len();
    let entries = n * (n + 1) / 2;
    let (mut colptr, mut rowval, mut nzval) =
        (Vec::with_capacity(n + 1), Vec::with_capacity(entries), Vec::with_capacity(entries));
    colptr.push(0);
    for column in 0..n {
        rowval.extend(0..=column);
        nzval.extend((0..=column).map(|row| reduced.matrix[(row, column)]));
        colptr.push(rowval.len());
    }
    CscMatrix::new(n, n, colptr, rowval, nzval)
}
