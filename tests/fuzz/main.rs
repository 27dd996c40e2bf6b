//! Scenes drawn by lot and changed, through the library: no panic, no hang, no answer with a part missing or not finite.
//!
//! `cargo test --release --test fuzz` runs 4000 of fixed seeds. Longer by hand, on all cores:
//! `FUZZ_SCENES=1000000 FUZZ_SEED=7 FUZZ_MILLISECONDS=5 cargo test --release --test fuzz -- --ignored --nocapture`,
//! with the CPU time that a state may take; from scene `FUZZ_FIRST` on where a long run is had in pieces.
#![cfg(all(feature = "scene", feature = "qp", feature = "formula"))]

#[path = "../random/mod.rs"]
mod random;
mod scenes;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use contact_patch::{Origin, Scene, Settings, Verdict, report, solve};
use random::Random;
use serde_json::Value;

/// CPU seconds that a state may take in the runs of fixed seeds.
const SECONDS: f64 = 0.05;

/// CPU seconds over all states of a scene, reading and writing, beyond which it hangs. A state ends at its limit, or with the step
/// that it is in; the rest is the search of the gap, which no limit ends yet.
const HANGS: f64 = 20.0;

/// What became of the scenes.
#[derive(Default)]
struct Tally {
    outcomes: BTreeMap<String, u64>,
    faults: Vec<String>,
    slowest: Vec<(f64, u64, String)>,
}

/// The scene of a number.
fn drawn(seed: u64, number: u64) -> Vec<u8> {
    // Not by the step of the generator, which would make one scene's numbers the next one's.
    let mixed = number.wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31);
    let mut random = Random(seed.wrapping_mul(0xd6e8_feb8_6659_fd93) ^ mixed);
    let mut scene = scenes::scene(&mut random);
    for _ in 0..scenes::pick(&mut random, 4) {
        scenes::change(&mut scene, &mut random);
    }
    scenes::text(&scene, &mut random)
}

/// What a scene leads to, in a word; an error is a fault of the library.
fn outcome(text: &[u8], maps: &Path, seconds: f64) -> Result<String, String> {
    let mut scene = match Scene::from_json_within(text, maps) {
        Ok(scene) => scene,
        Err(e) if e.path.is_empty() || e.given.is_empty() || e.allowed.is_empty() => {
            return Err(format!("an error without its parts: {e:?}"));
        }
        Err(_) => return Ok("refused".to_owned()),
    };
    let cells = scene.settings.cells.map(|cells| cells.min(64));
    scene.settings = Settings { seconds, cells, ..scene.settings };
    let settings = scene.settings;
    let steps = solve(&scene.contact, &settings);
    if steps.len() != scene.contact.loading().loads().len() {
        return Err("states are missing".to_owned());
    }
    let text = serde_json::to_vec(&report::json(&scene, &steps)).map_err(|e| e.to_string())?;
    let result: Value = serde_json::from_slice(&text).map_err(|e| format!("the result is no JSON: {e}"))?;
    for step in &steps {
        let (verdict, state) = match step {
            Ok(state) => ("solved", Some(state)),
            Err(e) if e.verdict == Verdict::Inconsistent => return Err(e.to_string()),
            Err(e) if e.reason.is_empty() => return Err(format!("{} without a reason", e.verdict)),
            Err(e) => (e.verdict.word(), e.best.as_deref()),
        };
        let Some(s) = state else { continue };
        let touching = s.force > 0.0;
        let parts = [
            ("force", s.force.is_finite() && s.force >= 0.0),
            ("depth", s.depth.is_finite()),
            ("stiffness", s.stiffness.is_finite() && (s.stiffness > 0.0) == touching),
            ("area", s.patch.area.is_finite() && (s.patch.area > 0.0) == touching),
            ("centroid", s.patch.centroid.is_some() == touching),
            ("mean", s.pressure.mean.is_some_and(|p| p.is_finite() && p > 0.0) == touching),
            ("energy", s.energy.is_none_or(|u| u.is_finite() && u >= 0.0)),
            ("moment", s.moment.iter().flatten().all(|m| m.is_finite())),
            ("max", s.pressure.max.is_none_or(|p| p.is_finite() && p >= 0.0)),
            ("field", s.pressure.field.iter().flat_map(|f| &f.values).all(|p| p.is_finite() && *p >= 0.0)),
            ("error", s.force_error.is_none_or(|e| e.is_finite() && e >= 0.0)),
            (
                "other errors",
                [s.depth_error, s.stiffness_error, s.energy_error, s.area_error, s.pressure.max_error]
                    .into_iter()
                    .flatten()
                    .all(|e| e.is_finite() && e >= 0.0),
            ),
            ("pieces", {
                let sum: f64 = s.patch.pieces.iter().map(|piece| piece.force).sum();
                // An approximate method has them with its boundary.
                (sum - s.force).abs() <= 1e-9 * s.force || s.origin == Origin::Approximate && s.patch.pieces.is_empty()
            }),
            ("tolerance", verdict != "solved" || s.force_error.is_none_or(|e| e <= settings.tolerance)),
        ];
        if let Some((part, _)) = parts.iter().find(|(_, holds)| !holds) {
            return Err(format!("{verdict}, but {part} is missing or wrong: {s:?}"));
        }
    }
    let verdict = result["verdict"].as_str().ok_or("no verdict")?;
    Ok(verdict.to_owned())
}

/// Scenes after which a long run says how far it is.
const SAID: u64 = 50_000;

fn run(first: u64, count: u64, seed: u64, threads: usize, limit: f64) -> Tally {
    let maps = tempfile::tempdir().unwrap();
    for (name, bytes) in scenes::MAPS {
        std::fs::write(maps.path().join(name), bytes).unwrap();
    }
    std::panic::set_hook(Box::new(|_| ()));
    let (tally, next, idle) = (Mutex::new(Tally::default()), AtomicU64::new(first), AtomicU64::new(0));
    let running: Vec<Mutex<Option<(Instant, u64)>>> = (0..threads).map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        for mine in &running {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        *mine.lock().unwrap() = None;
                        idle.fetch_add(1, Ordering::Relaxed);
                        break;
                    }
                    if number % SAID == SAID - 1 {
                        eprintln!("{} scenes so far", number + 1 - first);
                    }
                    // A fault of the generator is one of the test, and told like the others.
                    let Ok(text) = catch_unwind(|| drawn(seed, number)) else {
                        tally.lock().unwrap().faults.push(format!("scene {number} of seed {seed} cannot be drawn"));
                        continue;
                    };
                    *mine.lock().unwrap() = Some((Instant::now(), number));
                    let started = cpu_seconds();
                    let found = catch_unwind(AssertUnwindSafe(|| outcome(&text, maps.path(), limit)));
                    let seconds = cpu_seconds() - started;
                    let shown = || String::from_utf8_lossy(&text).into_owned();
                    let mut tally = tally.lock().unwrap();
                    let fault = match found {
                        Ok(Ok(word)) => {
                            *tally.outcomes.entry(word).or_default() += 1;
                            (seconds > HANGS).then(|| format!("took {seconds:.1} CPU seconds"))
                        }
                        Ok(Err(fault)) => Some(fault),
                        Err(panic) => {
                            let text = panic.downcast_ref::<String>().cloned();
                            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                            Some(format!("panicked: {}", text.unwrap_or_default()))
                        }
                    };
                    if let Some(fault) = fault {
                        eprintln!("scene {number} of seed {seed}: {fault}\n{}", shown());
                        tally.faults.push(format!("scene {number} of seed {seed}: {fault}\n{}", shown()));
                    }
                    tally.slowest.push((seconds, number, shown()));
                    tally.slowest.sort_by(|a, b| b.0.total_cmp(&a.0));
                    tally.slowest.truncate(8);
                }
            });
        }
        // What hangs for good is named while it does.
        scope.spawn(|| {
            let mut named = None;
            while idle.load(Ordering::Relaxed) < threads as u64 {
                std::thread::sleep(Duration::from_millis(500));
                for place in &running {
                    if let Some((since, number)) = *place.lock().unwrap()
                        && since.elapsed() > Duration::from_secs(60)
                        && named != Some(number)
                    {
                        eprintln!(
                            "scene {number} runs for a minute:\n{}",
                            String::from_utf8_lossy(&drawn(seed, number))
                        );
                        named = Some(number);
                    }
                }
            }
        });
    });
    drop(std::panic::take_hook());
    tally.into_inner().unwrap()
}

/// CPU seconds of this thread.
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn told(tally: &Tally) {
    println!("{:?}", tally.outcomes);
    for (seconds, number, text) in &tally.slowest {
        println!("{seconds:.2} CPU s: scene {number}: {text}");
    }
}

#[test]
fn changed_scenes_are_answered_or_refused() {
    let tally = run(0, 4000, 20_260_801, 2, SECONDS);
    told(&tally);
    assert!(tally.faults.is_empty(), "{} faults: {:?}", tally.faults.len(), tally.faults.first());
    // Far from all are refused or out of time.
    let solved = tally.outcomes.get("solved").copied().unwrap_or(0);
    assert!(solved > 400, "{solved} solved");
}

#[test]
#[ignore = "as long as FUZZ_SCENES says; run by hand"]
fn as_many_changed_scenes_as_asked_for() {
    let number = |name: &str, unless: u64| std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(unless);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = number("FUZZ_THREADS", threads as u64) as usize;
    let limit = number("FUZZ_MILLISECONDS", 50) as f64 / 1e3;
    let tally = run(number("FUZZ_FIRST", 0), number("FUZZ_SCENES", 100_000), number("FUZZ_SEED", 1), threads, limit);
    told(&tally);
    assert!(tally.faults.is_empty(), "{} faults: {:?}", tally.faults.len(), tally.faults.first());
}
