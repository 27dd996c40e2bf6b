//! How many of the contacts that engineers and experimenters ask for get their number, and at what cost? Draws scenes by lot, family by
//! family, solves each within a limit of CPU seconds, and tabulates answers, times, and errors where the force is known by itself.
//!
//! ```sh
//! cargo run --release --example practitioners -- [scenes: 60] [seed: 1] [CPU seconds a scene: 10] [only this family]
//! ```
//!
//! After the table follow the scenes without an answer and the slowest ones, one a line as `contact-patch batch` reads them.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use contact_patch::{Scene, solve};
use serde_json::{Value, json};

/// A scene, its family, and its force where that is known.
struct Drawn {
    family: &'static str,
    scene: Value,
    truth: Option<f64>,
}

/// What became of it.
struct Outcome {
    family: &'static str,
    line: String,
    /// CPU seconds.
    seconds: f64,
    verdict: String,
    /// The error of the force over the stated one.
    off: Option<f64>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut given = std::env::args().skip(1);
    let mut number = |default: f64| given.next().map_or(Ok(default), |text| text.parse());
    let (count, seed, limit) = (number(60.0)? as u64, number(1.0)? as u64, number(10.0)?);
    let only = given.next();
    let mut outcomes = Vec::new();
    for k in 0..count {
        let drawn = draw(&mut Lot::new(seed, k));
        if only.as_deref().is_none_or(|only| only == drawn.family) {
            outcomes.push(run(drawn, limit)?);
        }
    }
    print!("{}", table(&mut outcomes));
    Ok(())
}

/// Solves one scene.
fn run(drawn: Drawn, limit: f64) -> Result<Outcome, Box<dyn std::error::Error>> {
    let line = drawn.scene.to_string();
    let mut scene = Scene::from_json(line.as_bytes())?;
    scene.settings.seconds = limit;
    scene.settings.threads = 1;
    let before = cpu_seconds();
    let states = solve(&scene.contact, &scene.settings);
    let seconds = cpu_seconds() - before;
    let failed = states.iter().find_map(|state| state.as_ref().err());
    let verdict = failed.map_or("solved".to_owned(), |e| e.verdict.to_string());
    let off = match (drawn.truth, states.first()) {
        (Some(truth), Some(Ok(state))) => state.force_error.map(|error| (state.force / truth - 1.0).abs() / error),
        _ => None,
    };
    Ok(Outcome { family: drawn.family, line, seconds, verdict, off })
}

/// CPU time of this process, to the tick of the system's clock.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    use std::time::{SystemTime, UNIX_EPOCH};
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

fn table(outcomes: &mut [Outcome]) -> String {
    let mut out = String::new();
    let mut families: Vec<&str> = outcomes.iter().map(|o| o.family).collect();
    families.sort_unstable();
    families.dedup();
    let mut row = |name: &str, of: &[&Outcome]| {
        let mut times: Vec<f64> = of.iter().map(|o| o.seconds).collect();
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times[((times.len() as f64 * share) as usize).min(times.len() - 1)];
        let answered = of.iter().filter(|o| o.verdict == "solved").count();
        let off = of.iter().filter_map(|o| o.off).reduce(f64::max).map_or("-".to_owned(), |off| format!("{off:.2}"));
        let rate = 100.0 * answered as f64 / of.len() as f64;
        let _ = writeln!(
            out,
            "{name:16} {:5} {rate:9.1} % {:9.3} {:9.3} {:9.3}   {off:>8}",
            of.len(),
            at(0.5),
            at(0.95),
            at(1.0)
        );
    };
    row("all", &outcomes.iter().collect::<Vec<_>>());
    for family in families {
        row(family, &outcomes.iter().filter(|o| o.family == family).collect::<Vec<_>>());
    }
    let header = "family           count  answered    median      95 %     worst   error/stated (CPU seconds)\n";
    let mut out = format!("{header}{out}\n");
    outcomes.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    for o in outcomes.iter().filter(|o| o.verdict != "solved") {
        let _ = writeln!(out, "// {} {:.2} s\n{}", o.verdict, o.seconds, o.line);
    }
    for o in outcomes.iter().filter(|o| o.verdict == "solved").take(10) {
        let _ = writeln!(out, "// {:.2} s\n{}", o.seconds, o.line);
    }
    out
}

/// Numbers by lot (a linear congruential generator, Knuth).
struct Lot(u64);

impl Lot {
    fn new(seed: u64, scene: u64) -> Self {
        let mut lot = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ scene.wrapping_mul(0xd134_2543_de82_ef95));
        for _ in 0..4 {
            lot.next();
        }
        lot
    }

    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Evenly in the logarithm.
    fn size(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.next())
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

fn draw(lot: &mut Lot) -> Drawn {
    let length = lot.size(1e-5, 0.1);
    let e_star = lot.size(1e6, 2e11);
    let (family, mut gap, loading, truth) = match lot.below(13) {
        0 => roller(lot, length, "rollers, sharp"),
        1 => roller(lot, length, "rollers, crowned"),
        2 => roller(lot, length, "rollers, log"),
        3 => worn(lot, length),
        4 => blunt(lot, length),
        5 | 6 => tilted(lot, length),
        7 => ring(lot, length),
        8 => level(lot, length),
        9 => tips(lot, length),
        10 => waves(lot, length),
        11 => list(lot, length),
        _ => known(lot, length),
    };
    if lot.below(2) == 0 && loading.get("tilt").is_none() && loading.get("through").is_none() {
        gap["rotate"] = json!(lot.between(0.0, 360.0));
    }
    let mut loading = loading;
    if let Some(force) = loading["force"].as_f64() {
        loading["force"] = json!(force * e_star * length * length);
    }
    let scene = json!({"name": family, "effective_modulus": e_star, "gap": gap, "loading": loading});
    Drawn { family, scene, truth: truth.map(|force| force * e_star * length * length) }
}

type Parts = (&'static str, Value, Value, Option<f64>);

/// Depth, or force in units of E* length^2.
fn load(lot: &mut Lot, length: f64, depths: [f64; 2], forces: [f64; 2]) -> Value {
    if lot.below(4) == 0 {
        json!({"force": lot.size(forces[0], forces[1])})
    } else {
        json!({"depth": length * lot.size(depths[0], depths[1])})
    }
}

fn rectangle(a: f64, b: f64) -> Value {
    json!({"polygon": [[-a, -b], [a, -b], [a, b], [-a, b]]})
}

fn roller(lot: &mut Lot, length: f64, family: &'static str) -> Parts {
    let (radius, half) = (length * lot.between(0.2, 1.5), 0.5 * length * lot.between(1.0, 3.0));
    let across = format!("x^2/{:e}", 2.0 * radius);
    let expression = match family {
        "rollers, sharp" => across,
        "rollers, crowned" => format!("{across} + y^2/{:e}", 2.0 * length * lot.size(20.0, 2000.0)),
        // Lundberg's profile.
        _ => format!("{across} - {:e}*ln(1 - (y/{:e})^2)", length * lot.size(1e-5, 1e-3), 1.0001 * half),
    };
    let gap = json!({"kind": "formula", "expression": expression, "region": rectangle(0.9 * radius, half)});
    (family, gap, load(lot, length, [1e-5, 1e-2], [1e-5, 1e-2]), None)
}

fn worn(lot: &mut Lot, length: f64) -> Parts {
    let gap = match lot.below(3) {
        0 => json!({"kind": "berkovich", "flat": length * lot.size(1e-3, 1.0)}),
        1 => json!({"kind": "vickers", "flat": length * lot.size(1e-3, 1.0)}),
        _ => json!({"kind": "pyramid", "faces": 3 + lot.below(6), "inclination": lot.between(5.0, 45.0),
                    "flat": length * lot.size(1e-3, 1.0)}),
    };
    ("worn indenters", gap, load(lot, length, [1e-4, 0.5], [1e-4, 0.3]), None)
}

fn blunt(lot: &mut Lot, length: f64) -> Parts {
    let (tip, slope) = (length * lot.between(0.05, 0.5), lot.between(0.1, 1.0));
    let gap = match lot.below(3) {
        // A rounded cone, a rounded wedge of two directions, a tip with a flat spot.
        0 => json!({"kind": "formula", "expression": format!("{slope}*(sqrt(r^2 + {:e}) - {tip:e})", tip * tip)}),
        1 => {
            let other = lot.between(0.1, 1.0);
            let root = |v: char, s: f64| format!("{s}*(sqrt({v}^2 + {:e}) - {tip:e})", tip * tip);
            json!({"kind": "formula", "expression": format!("{} + {}", root('x', slope), root('y', other))})
        }
        _ => json!({"kind": "revolved", "points": [[0.0, 0.0], [tip, 0.0], [tip + length, slope * length]]}),
    };
    ("blunt tips", gap, load(lot, length, [1e-4, 0.2], [1e-4, 0.1]), None)
}

/// A polygon of half size about `length`.
fn polygon(lot: &mut Lot, length: f64) -> Vec<[f64; 2]> {
    let t = lot.between(0.1, 0.4);
    let unit: Vec<[f64; 2]> = match lot.below(7) {
        0 => {
            let b = lot.size(0.05, 1.0);
            vec![[-1.0, -b], [1.0, -b], [1.0, b], [-1.0, b]]
        }
        1 => vec![
            [-1.0, 1.0],
            [-1.0, 1.0 - t],
            [-t, 1.0 - t],
            [-t, -1.0],
            [t, -1.0],
            [t, 1.0 - t],
            [1.0, 1.0 - t],
            [1.0, 1.0],
        ],
        2 => vec![
            [-1.0, -1.0],
            [1.0, -1.0],
            [1.0, 1.0],
            [1.0 - t, 1.0],
            [1.0 - t, -1.0 + t],
            [-1.0 + t, -1.0 + t],
            [-1.0 + t, 1.0],
            [-1.0, 1.0],
        ],
        3 => vec![[-1.0, -1.0], [1.0, -1.0], [1.0, -1.0 + t], [-1.0 + t, -1.0 + t], [-1.0 + t, 1.0], [-1.0, 1.0]],
        4 => (0..10)
            .map(|k| turned(if k % 2 == 0 { 1.0 } else { lot.between(0.4, 0.7) }, TAU * k as f64 / 10.0))
            .collect(),
        5 => {
            let n = 3 + lot.below(6);
            (0..n).map(|k| turned(lot.between(0.7, 1.0), TAU * k as f64 / n as f64)).collect()
        }
        _ => {
            // A C-ring.
            let (n, inner, open) = (16 + lot.below(40), lot.between(0.6, 0.9), lot.between(0.3, 2.0));
            let at = |k: usize| (TAU - open) * k as f64 / n as f64;
            (0..=n).map(|k| turned(1.0, at(k))).chain((0..=n).rev().map(|k| turned(inner, at(k)))).collect()
        }
    };
    unit.into_iter().map(|p| p.map(|c| c * length)).collect()
}

fn turned(r: f64, angle: f64) -> [f64; 2] {
    [r * angle.cos(), r * angle.sin()]
}

/// Points of an ellipse.
fn rim(semi_axes: [f64; 2]) -> Vec<[f64; 2]> {
    (0..64).map(|k| turned(1.0, TAU * f64::from(k) / 64.0)).map(|[u, v]| [semi_axes[0] * u, semi_axes[1] * v]).collect()
}

fn tilted(lot: &mut Lot, length: f64) -> Parts {
    // The corners, or some of the rim.
    let (outline, corners) = match lot.below(6) {
        0 => (json!({"disc": length}), rim([length; 2])),
        1 => {
            let semi_axes = [length, length * lot.between(0.2, 1.0)];
            (json!({"ellipse": semi_axes}), rim(semi_axes))
        }
        _ => {
            let corners = polygon(lot, length);
            (json!({"polygon": corners}), corners)
        }
    };
    let gap = json!({"kind": "flat", "outline": outline});
    let turn = lot.next();
    let [u, v] = turned(1.0, TAU * turn);
    let loading = if lot.below(2) == 0 {
        let depth = length * lot.size(1e-6, 1e-3);
        let tilt = depth / length * lot.size(0.02, 3.0);
        json!({"depth": depth, "tilt": [tilt * u, tilt * v]})
    } else {
        // Between the middle and a corner: a line of action beside the material has no equilibrium.
        let (off, n) = (lot.size(0.03, 0.6), corners.len() as f64);
        let middle = [0, 1].map(|m| corners.iter().map(|c| c[m] / n).sum::<f64>());
        let corner = corners[(turn * n) as usize];
        let through = [0, 1].map(|m| middle[m] + off * (corner[m] - middle[m]));
        json!({"force": lot.size(1e-6, 1e-3), "through": through})
    };
    ("tilted flats", gap, loading, None)
}

fn ring(lot: &mut Lot, length: f64) -> Parts {
    let inner = length * lot.between(0.3, 0.95);
    let gap = match lot.below(5) {
        0 => json!({"kind": "revolved", "points": [[inner, 0.0], [length, 0.0]]}),
        1 => {
            json!({"kind": "formula", "expression": format!("(r - {length:e})^2/{:e}", 2.0 * length * lot.size(0.02, 0.5))})
        }
        2 => json!({"kind": "formula", "expression": format!("0*sqrt(r - {inner:e})"), "region": {"disc": length}}),
        3 => json!({"kind": "formula", "expression": format!("(hypot(x, {}*y) - {length:e})^2/{:e}",
                    lot.between(0.8, 1.2), 2.0 * length * lot.size(0.1, 0.5))}),
        _ => {
            let rise = 1e-3 * length;
            json!({"kind": "formula", "expression": format!("{rise:e}*(1 - r^2/{:e})", length * length), "region": {"disc": length}})
        }
    };
    ("rings", gap, load(lot, length, [1e-5, 3e-3], [1e-5, 3e-3]), None)
}

fn level(lot: &mut Lot, length: f64) -> Parts {
    let gap = json!({"kind": "flat", "outline": {"polygon": polygon(lot, length)}});
    ("level flats", gap, load(lot, length, [1e-6, 1e-3], [1e-6, 1e-3]), None)
}

fn tips(lot: &mut Lot, length: f64) -> Parts {
    let apart = lot.between(0.1, 2.0);
    let tip = |lot: &mut Lot| {
        let at = [0, 1].map(|_| length * lot.between(-apart, apart));
        match lot.below(3) {
            0 => json!({"kind": "cone", "inclination": lot.between(5.0, 30.0), "at": at}),
            1 => json!({"kind": "pyramid", "faces": 4, "inclination": lot.between(5.0, 30.0), "at": at}),
            _ => {
                json!({"kind": "paraboloid", "radii": [length * lot.between(0.2, 2.0), length * lot.between(0.2, 2.0)], "at": at})
            }
        }
    };
    let all: Vec<Value> = (0..2 + lot.below(4)).map(|_| tip(lot)).collect();
    ("several tips", json!({"kind": "min", "of": all}), load(lot, length, [1e-4, 0.1], [1e-4, 0.05]), None)
}

fn waves(lot: &mut Lot, length: f64) -> Parts {
    let [p, q] = [0, 1].map(|_| lot.between(3.0, 40.0) / length);
    let height = length * lot.size(1e-4, 1e-2);
    let expression = format!(
        "x^2/{:e} + y^2/{:e} + {height:e}*cos({p:e}*x)*cos({q:e}*y)",
        2.0 * length,
        2.0 * length * lot.between(1.0, 3.0)
    );
    ("waves", json!({"kind": "formula", "expression": expression}), load(lot, length, [1e-3, 0.1], [1e-4, 0.05]), None)
}

fn list(lot: &mut Lot, length: f64) -> Parts {
    let (_, gap, _, _) = match lot.below(3) {
        0 => worn(lot, length),
        1 => blunt(lot, length),
        _ => roller(lot, length, "rollers, crowned"),
    };
    let depths: Vec<f64> = (0..4).map(|_| length * lot.size(1e-4, 0.1)).collect();
    ("lists", gap, json!({"depths": depths}), None)
}

/// Gaps whose force is known, written so that the formula for it does not apply, or has to be found; in units of E* length^2.
fn known(lot: &mut Lot, length: f64) -> Parts {
    let depth = lot.size(1e-4, 1e-2);
    let loading = json!({"depth": depth * length});
    let (gap, truth) = match lot.below(4) {
        // A flat square of half side `length`: 1.152298 (side) d, level or tilted as far as it touches everywhere.
        0 => (json!({"kind": "flat", "outline": rectangle(length, length)}), 2.0 * 1.152_298 * depth),
        1 => {
            let gap = json!({"kind": "flat", "outline": rectangle(length, length)});
            let [u, v] = turned(depth * lot.between(0.01, 0.2), TAU * lot.next());
            return ("known", gap, json!({"depth": depth * length, "tilt": [u, v]}), Some(2.0 * 1.152_298 * depth));
        }
        // A ball in a region that ends beyond the contact (Hertz).
        2 => {
            let gap = json!({"kind": "formula", "expression": format!("(x^2 + y^2)/{:e}", 2.0 * length), "region": rectangle(length, length)});
            (gap, 4.0 / 3.0 * depth.powf(1.5))
        }
        // The lower of two equal cones at one place (Love).
        _ => {
            let cone = json!({"kind": "cone", "inclination": 20.0});
            let force = 2.0 / PI * depth * depth / 20.0_f64.to_radians().tan();
            (json!({"kind": "min", "of": [cone, cone]}), force)
        }
    };
    ("known", gap, loading, Some(truth))
}
