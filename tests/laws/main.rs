//! Laws that hold between scenes, over scenes of every kind and nesting drawn by lot: what is the same contact has the same force,
//! within the sum of the errors that both answers state.
//!
//! `cargo test --release --test laws` runs some of fixed seeds. Longer by hand, on all cores:
//! `LAWS_SCENES=1000 LAWS_SEED=7 cargo test --release --test laws -- --ignored --nocapture`,
//! from scene `LAWS_FIRST` on where a long run is had in pieces.
#![cfg(all(feature = "scene", feature = "qp", feature = "formula"))]

mod laws;
#[path = "../random/mod.rs"]
mod random;
mod scenes;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use contact_patch::{Origin, Scene, Settings, Solution, Unsolved, Verdict, solve};
use laws::{Known, LAWS, Variant, variant};
use random::Random;
use scenes::Drawn;
use serde_json::{Value, json};

/// Rounding, relative.
const ROUNDING: f64 = 1e-9;

/// How much is asked of each scene.
#[derive(Clone, Copy)]
struct Run {
    /// Number of the first scene, and the one at which the run ends: a long run may be had in pieces.
    first: u64,
    scenes: u64,
    seed: u64,
    threads: usize,
    /// CPU seconds that a state may take.
    seconds: f64,
    /// Laws that each scene is held to, drawn by lot.
    laws: usize,
}

/// What became of the scenes.
#[derive(Default)]
struct Tally {
    scenes: u64,
    /// Scenes and variants without a force, by verdict.
    unanswered: BTreeMap<String, u64>,
    compared: BTreeMap<&'static str, u64>,
    violations: Vec<String>,
}

impl Tally {
    fn lacking(&mut self, verdict: &str, scene: &Value) {
        if verdict == Verdict::Inconsistent.word() {
            eprintln!("an answer broke a law of its own: {scene}");
            self.violations.push(format!("an answer broke a law of its own: {scene}"));
        }
        *self.unanswered.entry(verdict.to_owned()).or_default() += 1;
    }
}

/// The states of a scene.
fn states(scene: &Value, maps: &Path, run: Run) -> Result<Vec<Result<Solution, Unsolved>>, String> {
    let text = scene.to_string();
    let scene = Scene::from_json_within(text.as_bytes(), maps).map_err(|e| format!("{}: {e}", e.path))?;
    Ok(solve(&scene.contact, &Settings { seconds: run.seconds, ..scene.settings }))
}

/// The state, or the best that there is, when it states an error.
fn best(answer: Result<Solution, Unsolved>) -> Result<Solution, String> {
    let state = answer.or_else(|e| e.best.map(|best| *best).ok_or_else(|| e.verdict.word().to_owned()))?;
    if state.error().is_some() { Ok(state) } else { Err("no error stated".to_owned()) }
}

/// The number that starts the generator of a scene; not by its step, which would make one scene's numbers the next one's.
fn seed_of(run: Run, number: u64) -> u64 {
    let mixed = number.wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31);
    run.seed.wrapping_mul(0xd6e8_feb8_6659_fd93) ^ mixed
}

/// A disc that holds the patch.
fn disc(state: &Solution) -> ([f64; 2], f64) {
    let centre = state.patch.centroid.unwrap_or_default();
    let points = state.patch.boundary.iter().flatten().flatten();
    (centre, points.map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1])).fold(0.0, f64::max))
}

/// One scene: its own laws, then those against other scenes.
fn judge(number: u64, run: Run, maps: &Path, tally: &Mutex<Tally>) {
    let seed = seed_of(run, number);
    let first = scenes::drawn(Random(seed), 1.0, 1.0);
    let document = first.document(&[], &["patch"]);
    let lacking = |verdict: &str, scene: &Value| tally.lock().unwrap().lacking(verdict, scene);
    let broken = |law: &str, found: String, other: &Value| {
        let text = format!("scene {number} of seed {}, {law}: {found}\n  {document}\n  {other}", run.seed);
        eprintln!("{text}");
        tally.lock().unwrap().violations.push(text);
    };
    tally.lock().unwrap().scenes += 1;
    let answer = match states(&document, maps, run) {
        Ok(mut answers) => best(answers.remove(0)),
        Err(e) => return broken("scene", format!("refused: {e}"), &Value::Null),
    };
    let state = match answer {
        Ok(state) if state.force > 0.0 => state,
        Ok(_) => return lacking("no contact", &document),
        Err(verdict) => return lacking(&verdict, &document),
    };
    let known = Known { force: state.force, disc: disc(&state), closed_form: state.origin == Origin::ClosedForm };
    // The laws in an order of their own.
    let mut random = Random(seed ^ 0x5851_f42d_4c95_7f2d);
    let mut laws = LAWS.to_vec();
    for k in (1..laws.len()).rev() {
        laws.swap(k, random.below(k + 1));
    }
    let mut left = run.laws;
    for law in laws {
        if left == 0 {
            break;
        }
        let Some(Variant { scene, step, factor }) = variant(law, &first, seed, &known, &mut random) else { continue };
        left -= 1;
        let mut answers = match states(&scene, maps, run) {
            Ok(answers) => answers,
            Err(e) => {
                broken(law, format!("refused: {e}"), &scene);
                continue;
            }
        };
        if law == "list of depths" {
            rising(&answers, |found| broken("force rises with the depth", found, &scene));
        }
        match best(answers.swap_remove(step)) {
            Ok(other) => {
                *tally.lock().unwrap().compared.entry(law).or_default() += 1;
                if let Some(found) = unequal(&state, &other, factor, law == "force given back its depth") {
                    broken(law, found, &scene);
                }
            }
            Err(verdict) => lacking(&verdict, &scene),
        }
    }
    if left > 0 || random.next() < 0.3 {
        *tally.lock().unwrap().compared.entry("sum of the pressures").or_default() += 1;
        if let Err((found, scene)) = pressures_carry_the_force(&first, maps, run) {
            broken("sum of the pressures", found, &scene);
        }
    }
}

/// What is unequal in two states of one contact.
fn unequal(first: &Solution, second: &Solution, factor: f64, given_back: bool) -> Option<String> {
    // Under a force the error is that of the depth: times the stiffness, that of the force at the depth.
    let of_force = |s: &Solution| {
        let share = if s.depth_error == Some(0.0) { 1.0 } else { (s.depth * s.stiffness / s.force).abs() };
        s.error().map_or(f64::INFINITY, |error| error * share)
    };
    let [e1, e2] = [first, second].map(of_force);
    let force = second.force / factor;
    // A depth that answers the same force is compared by the force that it stands for.
    let off = if given_back { (second.depth - first.depth) * first.stiffness } else { force - first.force };
    let allowed = e1 * first.force + e2 * force + ROUNDING * first.force;
    (!(off.abs() <= allowed)).then(|| {
        format!(
            "{:e} (stated {e1:.2e}) against {force:e} (stated {e2:.2e}){}: off by {:.2e}, {:.2} times what is stated",
            first.force,
            if given_back { format!(", depths {:e} and {:e}", first.depth, second.depth) } else { String::new() },
            off / first.force,
            off.abs() / allowed
        )
    })
}

/// P(d) does not fall.
fn rising(answers: &[Result<Solution, Unsolved>], broken: impl Fn(String)) {
    let states: Vec<Solution> = answers.iter().filter_map(|answer| best(answer.clone()).ok()).collect();
    for pair in states.windows(2) {
        let [low, high] = [&pair[0], &pair[1]]
            .map(|s| [1.0 - s.force_error.unwrap(), 1.0 + s.force_error.unwrap()].map(|f| f * s.force));
        if low[0] > high[1] * (1.0 + ROUNDING) {
            broken(format!(
                "{:e} at depth {:e}, {:e} at depth {:e}",
                pair[0].force, pair[0].depth, pair[1].force, pair[1].depth
            ));
        }
    }
}

/// On one grid the force is the sum of the pressure over the cells.
fn pressures_carry_the_force(first: &Drawn, maps: &Path, run: Run) -> Result<(), (String, Value)> {
    let scene =
        first.document(&[("method", json!("fft")), ("cells", json!(48)), ("tolerance", json!(0.5))], &["pressure"]);
    let mut answers = states(&scene, maps, run).map_err(|e| (e, scene.clone()))?;
    let Ok(state) = best(answers.remove(0)) else { return Ok(()) };
    let (Origin::OneGrid, Some(field)) = (state.origin, &state.pressure.field) else { return Ok(()) };
    let sum = field.values.iter().sum::<f64>() * field.grid.cell_area();
    if (sum - state.force).abs() <= ROUNDING * state.force {
        return Ok(());
    }
    Err((format!("the force is {:e}, the field carries {sum:e}", state.force), scene))
}

fn held(run: Run) -> Tally {
    let maps = tempfile::tempdir().unwrap();
    for (name, text) in scenes::MAPS {
        std::fs::write(maps.path().join(name), text).unwrap();
    }
    let (tally, next) = (Mutex::new(Tally::default()), AtomicU64::new(run.first));
    std::thread::scope(|scope| {
        for _ in 0..run.threads {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= run.scenes {
                        break;
                    }
                    judge(number, run, maps.path(), &tally);
                }
            });
        }
    });
    tally.into_inner().unwrap()
}

fn told(tally: &Tally) {
    println!("{} scenes, {} comparisons", tally.scenes, tally.compared.values().sum::<u64>());
    println!("compared: {:?}", tally.compared);
    println!("unanswered: {:?}", tally.unanswered);
    println!("violations: {}", tally.violations.len());
}

#[test]
fn hold_between_scenes_drawn_by_lot() {
    let tally = held(Run { first: 0, scenes: 60, seed: 20_261_122, threads: 2, seconds: 1.0, laws: 2 });
    told(&tally);
    assert!(tally.violations.is_empty(), "{}", tally.violations.join("\n"));
    let compared: u64 = tally.compared.values().sum();
    assert!(compared > 80, "only {compared} comparisons");
}

#[test]
#[ignore = "as long as LAWS_SCENES says; run by hand"]
fn hold_between_as_many_scenes_as_asked_for() {
    let number = |name: &str, unless: u64| std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(unless);
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u64;
    let tally = held(Run {
        first: number("LAWS_FIRST", 0),
        scenes: number("LAWS_SCENES", 1000),
        seed: number("LAWS_SEED", 1),
        threads: number("LAWS_THREADS", threads) as usize,
        seconds: number("LAWS_SECONDS", 3) as f64,
        laws: number("LAWS_EACH", 5) as usize,
    });
    told(&tally);
    assert!(tally.violations.is_empty(), "{} violations", tally.violations.len());
}
