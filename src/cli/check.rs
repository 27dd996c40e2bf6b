//! `contact-patch check`

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;

use super::outputs::MainOutput;
use super::{Failure, Threads, inputs, scene};
use crate::check::{Shared, State, Verification};
use crate::error::InputError;
use crate::problem::{Load, Loading};
use crate::scene::{Json, Scene, SolveOptions};
use crate::threads::{each, with};

/// Check a result by direct summation: exit 0 accepted, 1 refused
#[derive(Args)]
pub(super) struct Check {
    /// Scene file; - reads standard input
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Result of this scene, with its pressure field ("output": ["pressure"]) or a bracket that needs none
    #[arg(value_name = "RESULT.json")]
    result: PathBuf,
    /// Take the values of the pressure from a NumPy array, [j, i] = cell (i, j), in place of those in the result
    #[arg(long, value_name = "FILE.npy")]
    field: Option<PathBuf>,
    /// What it was solved with, where neither the scene nor the result says so
    #[command(flatten)]
    options: SolveOptions,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    output: MainOutput,
}

impl Check {
    pub(super) fn run(&self) -> Result<ExitCode, Failure> {
        let mut scene = scene(&self.scene)?;
        let threads = self.threads.checked()?;
        let mut read_files = inputs(&self.scene, &scene);
        read_files.extend(self.field.iter().chain([&self.result]).cloned());
        let output = self.output.target(&read_files)?;
        let wrong = |e: &InputError| Failure::wrong(self.result.display(), e);
        let text = read(&self.result, LONGEST)?;
        let result = Json::parse(&text).map_err(|e| wrong(&e))?;
        let told = SolveOptions::told_in(&result).map_err(|e| wrong(&e))?;
        told.apply("options.", &mut scene.settings).map_err(|e| wrong(&e))?;
        self.options.apply("--", &mut scene.settings).map_err(|e| Failure::wrong("arguments", &e))?;
        let loads = scene.contact.loading().loads();
        let many = matches!(scene.contact.loading(), Loading::Steps(_));
        if self.field.is_some() && many {
            let error = InputError::new("--field", "a file for a list of loads", "one state of loading");
            return Err(Failure::wrong("arguments", &error));
        }
        let mut found = Verification::default();
        same_problem(&scene, &result, &mut found).map_err(|e| wrong(&e))?;
        let mut lines = Vec::new();
        let mut states = Vec::new();
        if found.accepted() {
            for (k, load) in loads.iter().enumerate() {
                let mut state = State::read(&result, many.then_some([k, loads.len()])).map_err(|e| wrong(&e))?;
                let beside = || state.field_file.as_ref().map(|file| self.result.with_file_name(file));
                let array = self.field.clone().or_else(beside);
                if let (Some(path), Some(field)) = (array, &mut state.field) {
                    field.values = npy(&path, field.grid.shape)?;
                }
                states.push((k, *load, state));
            }
        }
        let shared = Shared::default();
        let check = |(_, load, state): &(usize, Load, State)| state.check_among(&scene, *load, &shared);
        let all = with(threads, || each(&states, threads, check));
        let all = all.map_err(|e| wrong(&e))?;
        for ((k, ..), checked) in states.iter().zip(all) {
            if many {
                lines.push(format!("state {}:", k + 1));
            }
            lines.extend(checked.checked.iter().map(|what| mark(&checked, what)));
            if !checked.unchecked.is_empty() {
                lines.push(format!("--  not checked: {}", checked.unchecked.join(", ")));
            }
            found.objections.extend(checked.objections);
        }
        let mut head: Vec<String> = found.checked.iter().map(|what| mark(&found, what)).collect();
        head.extend(lines);
        head.push(if found.accepted() { "accepted".to_owned() } else { "refused".to_owned() });
        output.write(|to| head.iter().try_for_each(|line| writeln!(to, "{line}")))?;
        Ok(if found.accepted() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn mark(found: &Verification, what: &String) -> String {
    format!("{}  {what}", if found.objections.contains(what) { "NO" } else { "ok" })
}

/// Longest result that is read, in bytes.
const LONGEST: u64 = 1 << 28;

/// Longest array, in bytes.
const LARGEST_ARRAY: u64 = 1 << 31;

fn read(path: &Path, longest: u64) -> Result<Vec<u8>, Failure> {
    crate::files::read(path, longest).map_err(|e| Failure::wrong(path.display(), &e))
}

fn npy(path: &Path, [nx, ny]: [usize; 2]) -> Result<Vec<f64>, Failure> {
    let heights = crate::gap::Heights::from_npy(&read(path, LARGEST_ARRAY)?, [1.0; 2])
        .map_err(|e| Failure::wrong(path.display(), &e))?;
    if heights.shape() != [nx, ny] {
        let given = format!("a shape of {:?}", heights.shape());
        let error = InputError::new("shape", given, format!("that of the field in the result, [{nx}, {ny}]"));
        return Err(Failure::wrong(path.display(), &error));
    }
    Ok(heights.values().to_vec())
}

/// The result must be one of this scene, and one that was solved.
fn same_problem(scene: &Scene, result: &Json, found: &mut Verification) -> Result<(), InputError> {
    let missing = |key: &str, allowed: &str| InputError::new(key, "nothing", allowed);
    let echo = result.get("scene").ok_or_else(|| missing("scene", "the scene that was solved"))?;
    let (Json::Object(said), Json::Object(own)) = (echo, &scene.document) else {
        return Err(InputError::new("scene", echo.brief(), "the scene that was solved"));
    };
    for (key, _) in own.iter().chain(said) {
        if scene.document.get(key) != echo.get(key) {
            found.require(false, format!("the result is of this scene: \"{key}\" is another one"));
        }
    }
    if found.accepted() {
        found.require(true, "the result is of this scene");
    }
    let verdict = match result.get("verdict") {
        Some(Json::String(verdict)) => verdict,
        Some(other) => return Err(InputError::new("verdict", other.brief(), "a string")),
        None => return Err(missing("verdict", "a string")),
    };
    found.require(verdict == "solved", format!("the verdict is {verdict}"));
    Ok(())
}
