//! Scenes drawn by lot: sensible ones of every kind, nesting and loading, then changed until some make no sense.

use serde_json::{Map, Value, json};

use crate::random::Random;

/// Numbers at the ends of what can be written, and some that are special to a formula.
const EXTREME: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    5e-324,
    2.3e-308,
    1e-300,
    1e-160,
    1e-100,
    1e-30,
    1e-13,
    1e-9,
    1e9,
    1e13,
    1e30,
    1e100,
    1e154,
    1e160,
    1e300,
    1.79e308,
    90.0,
    89.999_999_999,
    0.5,
    -1e-9,
];

const EXPRESSIONS: [&str; 28] = [
    "x^2/2 + y^2",
    "r",
    "r^2/(1+r^2)",
    "x^x^x",
    "theta^2+r^2",
    "abs(x)^1.5 + 2*y^2 + 0.3*x*y",
    "max(x, max(-x + 0.5*y, -0.5*x - 2*y))",
    "min(x^2+y^2, (x-3)^2+y^2)",
    "(r-1)^2",
    "0.001*(1-r^2)",
    "-x^2-y^2",
    "sqrt(r)",
    "1/r",
    "exp(r)-1",
    "ln(1+r^2)",
    "sin(20*x)*0.01 + r^2",
    "0*x",
    "x",
    "r^0.05",
    "r^40",
    "abs(abs(abs(x)-1)-1) + y^2",
    "1e300*r^2",
    "1e-300*r^2",
    "r^2 + 1e-9*sin(1e9*x)",
    "tan(r)",
    "min(r, 1e-3) + max(0, r-1)",
    "cos(3*theta)*r^2 + 2*r^2",
    "0/0*x",
];

/// Maps beside the scenes, good and bad.
pub const MAPS: [(&str, &[u8]); 9] = [
    ("bump.txt", b"1 1 1 1\n1 0 0.2 1\n1 0.1 0.3 1\n1 1 1 1\n"),
    ("holes.txt", b"1 nan 1 1\n1 0 0.2 nan\n1 0.1 0.3 1\n1 1 nan 1\n"),
    ("flat.txt", b"0 0\n0 0\n"),
    ("huge.txt", b"1e300 -1e300 0\n1e-300 5e-324 1e308\n0 0 0\n"),
    ("words.txt", b"1 2\nthree 4\n"),
    ("ragged.txt", b"1 2 3\n4 5\n"),
    ("points.xyz", b"0 0 1\n1 0 0\n0 1 0.5\n1 1 1\n2 0 3\n2 1 1\n"),
    ("bad.npy", b"\x93NUMPY\x01\x00\x46\x00{'descr': '<f8', 'descr': '<f4', 'fortran_order': False}       \n"),
    ("empty.txt", b""),
];

/// A number: mostly of size 1, now and then at an end.
fn number(random: &mut Random) -> f64 {
    match (random.next() * 16.0) as u32 {
        0 => EXTREME[pick(random, EXTREME.len())],
        1 => 10f64.powf(-12.0 + 24.0 * random.next()),
        2 => -random.next(),
        3 | 4 => (random.next() * 5.0).ceil(),
        _ => random.between(0.05, 3.05),
    }
}

pub fn pick(random: &mut Random, count: usize) -> usize {
    ((random.next() * count as f64) as usize).min(count - 1)
}

fn pair(random: &mut Random) -> Value {
    json!([number(random) - 1.0, number(random) - 1.0])
}

fn outline(random: &mut Random) -> Value {
    match pick(random, 3) {
        0 => json!({"disc": number(random)}),
        1 => json!({"ellipse": [number(random), number(random)]}),
        _ => {
            let corners = 1 + pick(random, 7);
            let turn = std::f64::consts::TAU / corners as f64;
            let corner = |k: usize, r: f64| json!([r * (turn * k as f64).cos(), r * (turn * k as f64).sin()]);
            let points: Vec<Value> = (0..corners).map(|k| corner(k, number(random))).collect();
            json!({"polygon": points})
        }
    }
}

pub fn gap(random: &mut Random, depth: usize) -> Value {
    let kinds = if depth == 0 { 12 } else { 14 };
    let mut gap = match pick(random, kinds) {
        0 => match pick(random, 3) {
            0 => json!({"kind": "paraboloid", "radii": [number(random), "flat"]}),
            _ => json!({"kind": "paraboloid", "radii": [number(random), number(random)]}),
        },
        1 => json!({"kind": "sphere", "radius": number(random)}),
        2 => json!({"kind": "cone", "inclination": 89.9 * random.next()}),
        3 => json!({"kind": "power", "coefficient": number(random), "exponent": number(random)}),
        4 => {
            let mut punch =
                json!({"kind": "pyramid", "faces": 2 + pick(random, 9), "inclination": 89.9 * random.next()});
            if random.next() < 0.4 {
                punch["flat"] = json!(number(random));
            }
            punch
        }
        5 => {
            let planes: Vec<Value> = (0..1 + pick(random, 8))
                .map(|_| json!([number(random) - 1.0, number(random) - 1.0, 0.1 * number(random)]))
                .collect();
            json!({"kind": "polyhedron", "planes": planes})
        }
        6 => json!({"kind": "flat", "outline": outline(random)}),
        7 => {
            let (mut r, mut z) = (0.0, 0.0);
            let mut points = Vec::new();
            for _ in 0..2 + pick(random, 6) {
                points.push(json!([r, z]));
                (r, z) = (r + number(random).abs(), z + number(random));
            }
            json!({"kind": "revolved", "points": points})
        }
        8 => {
            let mut formula = json!({"kind": "formula", "expression": EXPRESSIONS[pick(random, EXPRESSIONS.len())]});
            if random.next() < 0.4 {
                formula["region"] = outline(random);
            }
            formula
        }
        9 => json!({
            "kind": "height_map", "file": MAPS[pick(random, MAPS.len())].0, "spacing": [number(random), number(random)],
            "surface": if random.next() < 0.5 { "upper" } else { "lower" },
            "interpolation": if random.next() < 0.5 { "cubic" } else { "linear" },
        }),
        10 => {
            let mut y = number(random);
            let points: Vec<Value> = (0..2 + pick(random, 40))
                .map(|_| {
                    y += 0.1 * number(random).abs();
                    json!([y, y * y + 0.05 * random.next()])
                })
                .collect();
            let mut profile =
                json!({"kind": "profile", "points": points, "along": if random.next() < 0.5 { "x" } else { "y" }});
            let more = [
                ("radius", json!(number(random).abs())),
                ("smooth", json!(0.02)),
                ("interpolation", json!("linear")),
                ("surface", json!("lower")),
                ("turn", json!(10.0 * number(random))),
                ("shift", pair(random)),
                ("mirror", json!("both")),
                ("between", json!([-1.0, 1.0])),
                ("unit", json!("mm")),
                ("zero", json!("as_is")),
            ];
            for (key, value) in more {
                if random.next() < if key == "radius" { 0.8 } else { 0.2 } {
                    profile[key] = value;
                }
            }
            profile
        }
        11 => {
            let name = ["berkovich", "vickers", "cube_corner"][pick(random, 3)];
            let mut indenter = json!({"kind": name});
            if random.next() < 0.3 {
                indenter["face_angle"] = json!(89.9 * random.next());
            }
            indenter
        }
        which => {
            let parts: Vec<Value> = (0..1 + pick(random, 3)).map(|_| self::gap(random, depth - 1)).collect();
            json!({"kind": if which == 12 { "sum" } else { "min" }, "of": parts})
        }
    };
    if random.next() < 0.3 {
        gap["at"] = pair(random);
    }
    if random.next() < 0.2 {
        gap["rotate"] = json!(360.0 * random.next());
    }
    gap
}

fn loading(random: &mut Random) -> Value {
    match pick(random, 9) {
        0..3 => json!({"depth": 0.3 * number(random)}),
        3 | 4 => json!({"force": number(random).abs()}),
        5 => json!({"depths": [number(random), 0.1 * number(random), -0.1]}),
        6 => json!({"depth_range": {"to": number(random), "steps": 1 + pick(random, 4)}}),
        7 => json!({"depth": number(random), "tilt": [0.2 * number(random), 0.2 * number(random)]}),
        _ => json!({"force": number(random).abs(), "through": [0.1 * number(random), 0.1 * number(random)]}),
    }
}

/// A scene that makes sense, more or less.
pub fn scene(random: &mut Random) -> Value {
    let mut scene = json!({"gap": gap(random, 3), "loading": loading(random)});
    match pick(random, 4) {
        0 => {
            scene["bodies"] =
                json!([{"youngs_modulus": 1e9 * number(random).abs(), "poissons_ratio": 0.5 * random.next()}, "rigid"])
        }
        _ => scene["effective_modulus"] = json!(number(random).abs()),
    }
    let mut solve = Map::new();
    let methods = ["auto", "auto", "auto", "closed_form", "ritz", "fabrikant", "qp", "fft"];
    solve.insert("method".into(), json!(methods[pick(random, methods.len())]));
    if random.next() < 0.4 {
        solve.insert("cells".into(), json!(1 + pick(random, 24)));
    }
    if random.next() < 0.2 {
        solve.insert("kernel".into(), json!("collocation"));
    }
    let tolerances = [0.1, 0.05, 0.02, 1e-2, 1e-3, 1e-9];
    solve.insert("tolerance".into(), json!(tolerances[pick(random, tolerances.len())]));
    if random.next() < 0.1 {
        let boundaries = [json!("ellipse"), json!("circle"), json!("plan_form"), json!("auto"), json!({"fourier": 2})];
        solve.insert("boundary".into(), boundaries[pick(random, boundaries.len())].clone());
    }
    scene["solve"] = Value::Object(solve);
    let outputs = ["patch", "pressure", "gap", "energy", "curve", "bracket"];
    let wanted: Vec<&str> = outputs.into_iter().filter(|_| random.next() < 0.12).collect();
    scene["output"] = json!(wanted);
    scene
}

/// All places in a document, as paths.
fn places(value: &Value, path: &str, found: &mut Vec<String>) {
    found.push(path.to_owned());
    match value {
        Value::Array(items) => items.iter().enumerate().for_each(|(k, v)| places(v, &format!("{path}/{k}"), found)),
        Value::Object(entries) => entries.iter().for_each(|(key, v)| places(v, &format!("{path}/{key}"), found)),
        _ => {}
    }
}

/// One change: a number, a type, a key, a part put elsewhere.
pub fn change(scene: &mut Value, random: &mut Random) {
    let mut all = Vec::new();
    places(scene, "", &mut all);
    let numbers: Vec<&String> = all.iter().filter(|p| scene.pointer(p).is_some_and(Value::is_number)).collect();
    match pick(random, 10) {
        0..6 if !numbers.is_empty() => {
            let path = numbers[pick(random, numbers.len())].clone();
            if let Some(place) = scene.pointer_mut(&path) {
                *place = json!(EXTREME[pick(random, EXTREME.len())]);
            }
        }
        6 => {
            let words =
                [json!(null), json!(true), json!("x"), json!([]), json!({}), json!([[[]]]), json!(-3), json!(1e308)];
            if let Some(place) = scene.pointer_mut(&all[pick(random, all.len())]) {
                *place = words[pick(random, words.len())].clone();
            }
        }
        7 => {
            let (from, to) = (all[pick(random, all.len())].clone(), all[pick(random, all.len())].clone());
            let part = scene.pointer(&from).cloned().unwrap_or_default();
            // Grown without end it would only be long.
            if part.to_string().len() < 2000
                && let Some(place) = scene.pointer_mut(&to)
            {
                *place = part;
            }
        }
        8 => {
            // There may be no gap any more, nor an object to hold one.
            if let Some(place) = scene.get_mut("gap") {
                let kind = if random.next() < 0.5 { "sum" } else { "min" };
                *place = json!({"kind": kind, "of": [place.take(), gap(random, 0)]});
            }
        }
        _ => {
            let objects: Vec<&String> = all.iter().filter(|p| scene.pointer(p).is_some_and(Value::is_object)).collect();
            if let Some(path) = objects.get(pick(random, objects.len().max(1))).map(|p| (*p).clone())
                && let Some(Value::Object(entries)) = scene.pointer_mut(&path)
                && let Some(key) = entries.keys().nth(pick(random, entries.len().max(1))).cloned()
            {
                let value = entries.remove(&key).unwrap_or_default();
                if random.next() < 0.3 {
                    entries.insert(format!("{key}s"), value);
                }
            }
        }
    }
}

/// The text of a document, now and then broken.
pub fn text(scene: &Value, random: &mut Random) -> Vec<u8> {
    let mut bytes = scene.to_string().into_bytes();
    if random.next() < 0.06 {
        for _ in 0..1 + pick(random, 3) {
            let at = pick(random, bytes.len());
            match pick(random, 5) {
                0 => bytes[at] = (random.next() * 256.0) as u8,
                1 => bytes.truncate(at.max(1)),
                2 => bytes.insert(at, b"{}[],:\"\\0eE-.nN\xff\x00"[pick(random, 17)]),
                3 => drop(bytes.remove(at)),
                _ => {
                    let end = (at + 1 + pick(random, 40)).min(bytes.len());
                    let piece = bytes[at..end].to_vec();
                    bytes.splice(at..at, piece);
                }
            }
            if bytes.is_empty() {
                bytes.push(b' ');
            }
        }
    }
    bytes
}
