//! Scenes drawn by lot: gaps of every kind and nesting, of sensible sizes, in any units.
//!
//! A scene is drawn from its number alone. Lengths carry the factor `unit`: the same number with another unit is the same contact in
//! other units.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use crate::random::Random;

/// Height maps beside the scenes: name, text. Heights of the upper body, first touch at depth 0.
pub const MAPS: [(&str, &str); 3] = [
    (
        "bump.txt",
        "1.9 1.3 1.0 1.1 1.7\n1.2 0.5 0.3 0.5 1.1\n1.0 0.3 0.0 0.2 0.8\n1.1 0.4 0.2 0.4 1.0\n1.8 1.1 0.9 1.0 1.6\n",
    ),
    (
        "two_bumps.txt",
        "1.4 1.1 1.2 1.5 1.3 1.1 1.4\n1.0 0.3 0.5 1.0 0.6 0.4 1.0\n0.9 0.0 0.4 0.9 0.5 0.1 0.8\n\
         1.0 0.4 0.5 1.1 0.7 0.5 1.1\n1.5 1.2 1.1 1.6 1.3 1.2 1.5\n",
    ),
    ("ridge.txt", "2.0 1.8 1.9 2.1\n0.7 0.5 0.4 0.6\n0.3 0.1 0.0 0.2\n0.8 0.6 0.5 0.5\n1.9 2.0 1.8 1.9\n"),
];

/// The parts of a scene that the laws change.
#[derive(Clone)]
pub struct Drawn {
    pub gap: Value,
    pub loading: Value,
    /// E* of the pair.
    pub modulus: f64,
    /// Entries of "solve".
    pub tolerance: f64,
    pub unit: f64,
}

impl Drawn {
    /// The scene with more entries of "solve" and with outputs.
    pub fn document(&self, solve: &[(&str, Value)], output: &[&str]) -> Value {
        let mut scene = json!({
            "effective_modulus": self.modulus, "gap": self.gap, "loading": self.loading,
            "solve": {"tolerance": self.tolerance}, "output": output,
        });
        for (key, value) in solve {
            scene["solve"][*key] = value.clone();
        }
        scene
    }

    pub fn depth(&self) -> Option<f64> {
        self.loading["depth"].as_f64()
    }

    pub fn tilt(&self) -> Option<[f64; 2]> {
        let tilt = self.loading["tilt"].as_array()?;
        Some([0, 1].map(|k| tilt[k].as_f64().unwrap_or(0.0)))
    }
}

/// The contact of a number, with lengths in units of 1/`unit` and E* = `modulus`.
pub fn drawn(mut random: Random, unit: f64, modulus: f64) -> Drawn {
    let random = &mut random;
    let gap = gap(random, unit, 2);
    let depth = unit * 10f64.powf(random.between(-2.5, -0.4));
    let loading = match random.below(7) {
        0 => {
            let angle = TAU * random.next();
            let tilt = depth / unit * random.between(0.05, 0.5);
            json!({"depth": depth, "tilt": [tilt * angle.cos(), tilt * angle.sin()]})
        }
        _ => json!({"depth": depth}),
    };
    let tolerance = [1e-2, 3e-3, 1e-3][random.below(3)];
    Drawn { gap, loading, modulus, tolerance, unit }
}

fn point(random: &mut Random, size: f64) -> Value {
    json!([random.between(-size, size), random.between(-size, size)])
}

fn outline(random: &mut Random, unit: f64) -> Value {
    match random.below(4) {
        0 => json!({"disc": unit * random.between(0.3, 1.0)}),
        1 => json!({"ellipse": [unit * random.between(0.3, 1.0), unit * random.between(0.3, 1.0)]}),
        2 => {
            let [a, b] = [unit * random.between(0.3, 1.0), unit * random.between(0.3, 1.0)];
            json!({"polygon": [[-a, -b], [a, -b], [a, b], [-a, b]]})
        }
        _ => {
            // Star-shaped about its middle.
            let corners = 3 + random.below(5);
            let corner = |k: usize, r: f64| {
                let angle = TAU * k as f64 / corners as f64;
                json!([unit * r * angle.cos(), unit * r * angle.sin()])
            };
            let points: Vec<Value> = (0..corners).map(|k| corner(k, random.between(0.4, 1.0))).collect();
            json!({"polygon": points})
        }
    }
}

/// A gap that rises to about `unit` within about `unit`; `nested` levels of sums and minima.
pub fn gap(random: &mut Random, unit: f64, nested: usize) -> Value {
    let mut gap = match random.below(if nested == 0 { 12 } else { 17 }) {
        0 => json!({"kind": "paraboloid", "radii": [unit * random.between(0.3, 2.0), unit * random.between(0.3, 6.0)]}),
        1 => json!({"kind": "sphere", "radius": unit * random.between(0.8, 4.0)}),
        2 => json!({"kind": "cone", "inclination": random.between(10.0, 60.0)}),
        3 => {
            let exponent = random.between(0.7, 6.0);
            json!({"kind": "power", "coefficient": random.between(0.3, 2.0) * unit.powf(1.0 - exponent),
                   "exponent": exponent})
        }
        4 => json!({"kind": "pyramid", "faces": 3 + random.below(6), "inclination": random.between(10.0, 60.0)}),
        5 => json!({"kind": "pyramid", "faces": 3 + random.below(6), "inclination": random.between(10.0, 60.0),
                    "flat": unit * random.between(0.05, 0.8)}),
        6 => {
            let planes = 3 + random.below(6);
            let plane = |k: usize, random: &mut Random| {
                let angle = TAU * (k as f64 + random.between(-0.2, 0.2)) / planes as f64;
                let slope = random.between(0.3, 1.5);
                json!([slope * angle.cos(), slope * angle.sin(), unit * random.between(-0.1, 0.1)])
            };
            let planes: Vec<Value> = (0..planes).map(|k| plane(k, random)).collect();
            json!({"kind": "polyhedron", "planes": planes})
        }
        7 => json!({"kind": "flat", "outline": outline(random, unit)}),
        8 => {
            let (mut r, mut z) = (if random.next() < 0.2 { random.between(0.1, 0.4) } else { 0.0 }, 0.0);
            let mut points = vec![json!([unit * r, 0.0])];
            for k in 0..1 + random.below(4) {
                // Flat at first, or hollow, now and then.
                let rise = if k == 0 && random.next() < 0.3 { 0.0 } else { random.between(-0.02, 0.6) };
                (r, z) = (r + random.between(0.1, 0.6), z + rise);
                points.push(json!([unit * r, unit * z]));
            }
            json!({"kind": "revolved", "points": points})
        }
        9 | 10 => formula(random, unit),
        11 => {
            let [x, y] = [unit * random.between(0.2, 0.5), unit * random.between(0.2, 0.5)];
            json!({"kind": "height_map", "file": MAPS[random.below(MAPS.len())].0, "spacing": [x, y], "scale": unit,
                   "surface": "upper", "interpolation": "linear"})
        }
        12..15 => {
            let parts: Vec<Value> = (0..1 + random.below(3)).map(|_| self::gap(random, unit, nested - 1)).collect();
            json!({"kind": "sum", "of": parts})
        }
        _ => {
            // Side by side, some far apart.
            let apart = random.between(0.2, 3.0);
            let parts: Vec<Value> = (0..1 + random.below(4))
                .map(|_| {
                    let mut part = self::gap(random, unit, nested - 1);
                    part["at"] = point(random, apart * unit);
                    part
                })
                .collect();
            json!({"kind": "min", "of": parts})
        }
    };
    if random.next() < 0.3 {
        gap["at"] = point(random, 0.3 * unit);
    }
    if random.next() < 0.3 {
        gap["rotate"] = json!(360.0 * random.next());
    }
    gap
}

fn formula(random: &mut Random, unit: f64) -> Value {
    let [a, b, c] = [random.between(0.3, 2.0), random.between(0.3, 2.0), random.between(-0.25, 0.25)];
    let [m, n] = [random.between(1.0, 4.0), random.between(0.6, 2.0)];
    let of = match random.below(12) {
        0 => format!("{a}*X^2 + {b}*Y^2 + {c}*X*Y"),
        1 => format!("{a}*X^2 + {b}*abs(Y)^{m}"),
        2 => format!("({a}*abs(X)^{m} + {b}*abs(Y)^{m})^{n}"),
        3 => format!("{a}*X^2 + {b}*X^4 + {b}*Y^2 + {c}*X^3"),
        4 => format!("max({a}*abs(X), {b}*abs(Y))"),
        5 => format!("max(0, R - {}) + {b}*R^2", 0.3 * a),
        6 => format!("{b}*(R - {})^2", 0.4 * a),
        7 => format!("{a}*R^2*(1 + {c}*cos(3*theta))"),
        8 => format!("{a}*abs(X) + {b}*Y^2"),
        9 => format!("{a}*(cosh(X) - 1) + {b}*Y^2"),
        10 => format!("{a}*X^2/2 + 0*Y"),
        _ => format!("{a}*R^2 + {}*(1 - cos({}*X)*cos({}*Y))", 0.02 * b, 4.0 * m, 6.0 * n),
    };
    let own = |name: &str| if unit == 1.0 { name.to_owned() } else { format!("({name}/{unit:e})") };
    let of = of.replace('X', &own("x")).replace('Y', &own("y")).replace('R', &own("r"));
    let expression = if unit == 1.0 { of.clone() } else { format!("{unit:e}*({of})") };
    let mut gap = json!({"kind": "formula", "expression": expression});
    if random.next() < 0.3 || of.contains("0*") && of.ends_with(&format!("0*{}", own("y"))) {
        gap["region"] = outline(random, unit);
    }
    gap
}
