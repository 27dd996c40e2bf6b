//! The laws: what is changed in a scene, and what its force must then be.

use serde_json::{Value, json};

use crate::random::Random;
use crate::scenes::{self, Drawn};

/// A second scene whose force has to agree with that of the first.
pub struct Variant {
    pub scene: Value,
    /// Which state of its loading.
    pub step: usize,
    /// Its force over that of the first.
    pub factor: f64,
}

/// What is known of the first scene once it is solved.
pub struct Known {
    pub force: f64,
    /// A disc about a point that holds the patch.
    pub disc: ([f64; 2], f64),
    pub closed_form: bool,
}

/// Names, in the order of [`variant`].
pub const LAWS: [&str; 16] = [
    "turned",
    "moved",
    "other units",
    "sum of one",
    "min of one",
    "min of twice the same",
    "min with one that does not touch",
    "sum with what ends outside of the patch",
    "list of depths",
    "force given back its depth",
    "tilt 0",
    "tolerance 1e-2",
    "tolerance 1e-3",
    "collocation",
    "grid",
    "quadratic programme",
];

/// The scene that a law compares with; `None` where it says nothing.
pub fn variant(law: &str, first: &Drawn, seed: u64, known: &Known, random: &mut Random) -> Option<Variant> {
    let mut drawn = first.clone();
    let (mut solve, mut step, mut factor) = (Vec::new(), 0, 1.0);
    let wrapped = |kind: &str, parts: &[&Value]| json!({"kind": kind, "of": parts});
    match law {
        "turned" => {
            let turn = 360.0 * random.next();
            let rotated = |p: [f64; 2]| {
                let (sin, cos) = turn.to_radians().sin_cos();
                [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]]
            };
            drawn.gap["at"] = json!(rotated(place(&first.gap)));
            drawn.gap["rotate"] = json!(first.gap["rotate"].as_f64().unwrap_or(0.0) + turn);
            if let Some(tilt) = first.tilt() {
                drawn.loading["tilt"] = json!(rotated(tilt));
            }
        }
        "moved" => {
            let by = [0, 1].map(|_| first.unit * random.between(-2.0, 2.0));
            let at = place(&first.gap);
            drawn.gap["at"] = json!([at[0] + by[0], at[1] + by[1]]);
            if let Some([ax, ay]) = first.tilt() {
                // d + a . (x - by) with d the depth at the new origin.
                drawn.loading["depth"] = json!(first.depth()? - ax * by[0] - ay * by[1]);
            }
        }
        "other units" => {
            let [length, modulus] = [1e-6, 2e11];
            drawn = scenes::drawn(Random(seed), length, modulus);
            factor = length * length * modulus;
        }
        "sum of one" => drawn.gap = wrapped("sum", &[&first.gap]),
        "min of one" => drawn.gap = wrapped("min", &[&first.gap]),
        "min of twice the same" => drawn.gap = wrapped("min", &[&first.gap, &first.gap]),
        "min with one that does not touch" => {
            let high = first.depth()? * random.between(1.5, 4.0);
            if first.tilt().is_some() {
                return None;
            }
            let idle = json!({"kind": "formula", "expression": format!("{high:e} + r^2"), "at": [0.3, -0.2]});
            drawn.gap = wrapped("min", &[&first.gap, &idle]);
        }
        "sum with what ends outside of the patch" => {
            // Material on which there is no pressure may be taken away.
            let (centre, radius) = known.disc;
            let flat = json!({"kind": "flat", "outline": {"disc": radius * random.between(1.2, 1.6)}, "at": centre});
            drawn.gap = wrapped("sum", &[&first.gap, &flat]);
        }
        "list of depths" => {
            let depth = first.depth()?;
            if first.tilt().is_some() {
                return None;
            }
            drawn.loading = json!({"depths": [0.4 * depth, depth, 1.5 * depth]});
            step = 1;
        }
        "force given back its depth" => {
            if first.tilt().is_some() {
                return None;
            }
            drawn.loading = json!({"force": known.force});
        }
        "tilt 0" => {
            if first.tilt().is_some() {
                return None;
            }
            drawn.loading["tilt"] = json!([0.0, 0.0]);
        }
        "tolerance 1e-2" => drawn.tolerance = 1e-2,
        "tolerance 1e-3" => drawn.tolerance = 1e-3,
        "collocation" => solve.push(("kernel", json!("collocation"))),
        "grid" if known.closed_form => solve.push(("method", json!("fft"))),
        "quadratic programme" => {
            drawn.tolerance = 1e-2;
            solve.push(("method", json!("qp")));
        }
        _ => return None,
    }
    Some(Variant { scene: drawn.document(&solve, &[]), step, factor })
}

fn place(gap: &Value) -> [f64; 2] {
    [0, 1].map(|k| gap["at"][k].as_f64().unwrap_or(0.0))
}
