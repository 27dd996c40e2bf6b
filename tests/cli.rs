//! The binary as its users call it.
#![cfg(feature = "cli")]

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const CONE: &str = r#"{"effective_modulus": 1.0, "gap": {"kind": "cone", "inclination": 45.0},
    "loading": {"depth": 1.0}, "solve": {"cells": 25, "tolerance": 0.05}}"#;

fn run(arguments: &[&str], directory: &Path, input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .args(arguments)
        .current_dir(directory)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let input = input.to_vec();
    let feeder = std::thread::spawn(move || {
        // The child may end before it has read everything.
        let _ = pipe.write_all(&input);
    });
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    output
}

fn solved(arguments: &[&str], scene: &str) -> Value {
    let output = run(arguments, Path::new("."), scene.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn json_of(scene: &str) -> Value {
    solved(&["solve", "-", "--json", "-"], scene)
}

#[test]
fn one_state_gives_scalars_and_many_give_lists() {
    let one = json_of(CONE);
    assert_eq!(one["verdict"], "solved");
    assert!((one["force"].as_f64().unwrap() - 2.0 / std::f64::consts::PI).abs() < 0.02);
    assert_eq!(one["scene"], serde_json::from_str::<Value>(CONE).unwrap());
    let many = json_of(&CONE.replace(r#""depth": 1.0"#, r#""depths": [-1.0, 1.0]"#));
    assert_eq!(many["force"][0], 0.0);
    assert_eq!(many["force"][1], one["force"]);
    for key in ["method", "depth", "stiffness", "patch", "pressure", "cost", "checks"] {
        assert_eq!(many[key].as_array().unwrap().len(), 2, "{key}");
    }
    assert_eq!(many["verdict"], "solved");
    assert!(many.get("verdicts").is_none());
}

#[test]
fn a_field_covers_its_grid_and_adds_up_to_the_force() {
    let result = json_of(&CONE.replace(r#""solve""#, r#""output": ["pressure", "gap", "patch"], "solve""#));
    let field = &result["pressure"]["field"];
    let [nx, ny] = [0, 1].map(|k| field["shape"][k].as_u64().unwrap() as usize);
    let values: Vec<f64> = field["values"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    assert_eq!(values.len(), nx * ny);
    let cell = field["spacing"][0].as_f64().unwrap() * field["spacing"][1].as_f64().unwrap();
    let force = result["force"].as_f64().unwrap();
    // Sums of a few hundred numbers: rounding only.
    assert!((values.iter().sum::<f64>() * cell - force).abs() < 1e-12 * force);
    assert_eq!(result["gap"]["field"]["values"].as_array().unwrap().len(), nx * ny);
    assert!(!result["patch"]["boundary"].as_array().unwrap().is_empty());
}

#[test]
fn files_are_written_whole_and_nothing_else_is_left() {
    let directory = tempfile::tempdir().unwrap();
    let files = ["solve", "-", "--json", "r.json", "--csv", "r.csv", "--field", "p.npy"];
    let output = run(&files, directory.path(), CONE.as_bytes());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8(output.stdout).unwrap().contains("force"));
    let mut names: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["p.npy", "r.csv", "r.json"]);
    let read = |name: &str| fs::read(directory.path().join(name)).unwrap();
    let result: Value = serde_json::from_slice(&read("r.json")).unwrap();
    let [nx, ny] = [0, 1].map(|k| result["pressure"]["field"]["shape"][k].as_u64().unwrap() as usize);
    let npy = read("p.npy");
    assert!(npy.starts_with(b"\x93NUMPY\x01\x00"));
    assert_eq!((npy.len() - 8 * nx * ny) % 64, 0);
    let csv = String::from_utf8(read("r.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[0].len(), rows[1].len());
    assert_eq!(rows[1][1].parse::<f64>().unwrap(), result["force"].as_f64().unwrap());
}

#[test]
fn options_replace_what_the_scene_says() {
    let coarse = solved(&["solve", "-", "--json", "-", "--cells", "11", "--method", "qp"], CONE);
    assert_eq!(coarse["method"], "qp");
    assert!(coarse["cost"]["unknowns"].as_u64().unwrap() < json_of(CONE)["cost"]["unknowns"].as_u64().unwrap());
}

#[test]
fn wrong_arguments_end_with_2_and_write_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let wrong: [&[&str]; 27] = [
        &[],
        &["solv"],
        &["solve"],
        &["solve", "-", "--tolerance", "2"],
        &["solve", "-", "--tolerance", "NaN"],
        &["solve", "-", "--cells", "0"],
        &["solve", "-", "--method", "magic"],
        &["solve", "-", "--json", "absent/r.json"],
        &["solve", "-", "--json", "-", "--csv", "-"],
        &["batch", "--jobs", "0"],
        &["batch", "--jobs", "many"],
        &["batch", "--tolerance", "0"],
        &["batch", "--cells", "0"],
        &["batch", "scenes.ndjson"],
        &["compare"],
        &["compare", "-", "--cells", "16,0"],
        &["compare", "-", "--qp-cells", "x"],
        &["compare", "-", "--threads", "0"],
        &["compare", "-", "--bracket-cells", "-1"],
        &["compare", "-", "--plot", "c.pdf"],
        &["compare", "-", "--csv", "absent/c.csv"],
        &["compare", "-", "--json", "r", "--csv", "r"],
        &["curve", "-", "--plot", "c.gif"],
        &["curve", "-", "--plot", "absent/c.svg"],
        &["stability", "--only", "no such case"],
        &["schema", "all"],
        &["completions", "tcsh"],
    ];
    for arguments in wrong {
        let output = run(arguments, directory.path(), CONE.as_bytes());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
        assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"), "{arguments:?}");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0, "{arguments:?}");
    }
}

#[test]
fn not_solved_is_exit_code_1_with_a_result() {
    let wedge = CONE.replace(r#"{"kind": "cone""#, r#"{"kind": "pyramid", "faces": 2"#);
    let output = run(&["solve", "-", "--json", "-"], Path::new("."), wedge.as_bytes());
    assert_eq!(output.status.code(), Some(1));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["verdict"], "unbounded");
    assert!(result["reason"].is_string() && result.get("force").is_none());
    let several = wedge.replace(r#""depth": 1.0"#, r#""depths": [-1.0, 1.0]"#);
    let output = run(&["solve", "-", "--json", "-"], Path::new("."), several.as_bytes());
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(result["verdicts"], serde_json::json!(["solved", "unbounded"]));
    assert_eq!(result["force"], serde_json::json!([0.0, null]));
}

#[test]
fn batch_answers_every_line_in_order() {
    let mut input = String::new();
    for k in 0..200 {
        match k % 50 {
            7 => input.push_str("nonsense\n"),
            9 => input.push('\n'),
            _ => input.push_str(&format!(
                "{{\"name\": \"{k}\", \"effective_modulus\": 1, \"gap\": {{\"kind\": \"sphere\", \"radius\": 1}}, \
                 \"loading\": {{\"depth\": {}}}}}\n",
                -k
            )),
        }
    }
    let output = run(&["batch", "--jobs", "3"], Path::new("."), input.as_bytes());
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.ends_with('\n'));
    let answers: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    // Blank lines are passed over, and counted.
    assert_eq!(answers.len(), 196);
    for (k, answer) in (0..200).filter(|k| k % 50 != 9).zip(&answers) {
        if k % 50 == 7 {
            assert_eq!(answer["line"], k + 1);
            assert!(["path", "given", "allowed"].iter().all(|key| answer["error"][key].is_string()));
        } else {
            assert_eq!(answer["scene"]["name"], k.to_string());
        }
    }
    let strict = run(&["batch", "--strict"], Path::new("."), b"nonsense");
    assert_eq!(strict.status.code(), Some(1));
}

#[test]
fn several_scenes_are_answered_in_order() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    for (name, depth) in [("a", 1), ("b", 2), ("c", 3)] {
        let scene = CONE.replace("1.0}, \"solve\"", &format!("{depth}.0}}, \"solve\"")).replacen(
            '{',
            &format!("{{\"name\": \"{name}\", "),
            1,
        );
        fs::write(at.join(format!("{name}.json")), scene.replace("\"depth\": 1.0", &format!("\"depth\": {depth}.0")))
            .unwrap();
    }
    let output = run(&["solve", "a.json", "b.json", "-", "-o", "r.ndjson"], at, &fs::read(at.join("c.json")).unwrap());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.starts_with("a\n") && table.contains("\n\nb\n") && table.contains("\n\nc\n"), "{table}");
    let text = fs::read_to_string(at.join("r.ndjson")).unwrap();
    let forces: Vec<f64> =
        text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["force"].as_f64().unwrap()).collect();
    // Force of a cone: the square of the depth.
    assert!(
        forces.len() == 3 && (forces[1] / forces[0] - 4.0).abs() < 1e-9 && (forces[2] / forces[0] - 9.0).abs() < 1e-9
    );
    for wrong in [
        &["solve", "a.json", "b.json", "--csv", "r.csv"][..],
        &["solve", "a.json", "-", "-"],
        &["solve", "a.json", "b.json", "-o", "b.json"],
        &["solve", "a.json", "absent.json", "-o", "x.ndjson"],
    ] {
        let output = run(wrong, at, b"{}");
        assert!(output.status.code() == Some(2) && output.stdout.is_empty(), "{wrong:?}");
    }
    assert_eq!(fs::read_dir(at).unwrap().count(), 4);
}

#[test]
fn quiet_indented_and_in_colour() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    let quiet = run(&["solve", "-", "--quiet", "-o", "r.json", "--json-pretty"], at, CONE.as_bytes());
    assert!(quiet.status.code() == Some(0) && quiet.stdout.is_empty() && quiet.stderr.is_empty());
    let text = fs::read_to_string(at.join("r.json")).unwrap();
    let plain = json_of(CONE);
    let indented: Value = serde_json::from_str(&text).unwrap();
    assert!(text.lines().count() > 20 && indented["force"] == plain["force"]);
    let curve = run(&["curve", "-", "-q", "--steps", "4"], at, CONE.as_bytes());
    assert!(curve.status.code() == Some(0) && curve.stderr.is_empty() && !curve.stdout.is_empty());
    // What is wrong is said all the same.
    let wrong = run(&["--quiet", "solve", "-"], at, b"{}");
    assert!(wrong.status.code() == Some(2) && !wrong.stderr.is_empty());
    let table = |variables: &[(&str, &str)]| {
        fs::write(at.join("scene.json"), CONE.replacen('{', "{\"name\": \"cone\", ", 1)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_contact-patch"));
        command.args(["solve", "scene.json"]).current_dir(at).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        String::from_utf8(command.envs(variables.iter().copied()).output().unwrap().stdout).unwrap()
    };
    assert!(!table(&[]).contains('\x1b'));
    assert!(table(&[("CLICOLOR_FORCE", "1")]).starts_with("\x1b[1mcone\x1b[0m"));
    assert!(!table(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]).contains('\x1b'));
}

#[test]
fn every_command_has_a_manual_page() {
    let directory = tempfile::tempdir().unwrap();
    let output = run(&["man", "--directory", "."], directory.path(), b"");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for command in
        ["solve", "plan", "compare", "report", "curve", "batch", "check", "stability", "schema", "completions"]
    {
        let page = fs::read_to_string(directory.path().join(format!("contact-patch-{command}.1"))).unwrap();
        assert!(page.contains(".SH SYNOPSIS") && page.contains("\\-\\-help"), "{command}");
        let same = run(&["man", command], directory.path(), b"");
        assert!(same.status.success() && String::from_utf8_lossy(&same.stdout).contains(".SH SYNOPSIS"));
    }
    assert!(String::from_utf8_lossy(&run(&["man"], directory.path(), b"").stdout).contains("contact\\-patch"));
    assert_eq!(run(&["man", "nonsense"], directory.path(), b"").status.code(), Some(2));
}

#[test]
fn pictures_of_every_kind() {
    let directory = tempfile::tempdir().unwrap();
    let at = directory.path();
    let two = CONE
        .replace(r#"{"kind": "cone", "inclination": 45.0}"#, r#"{"kind": "min", "of": [{"kind": "sphere", "radius": 1.0, "at": [-3, 0]}, {"kind": "sphere", "radius": 1.0, "at": [3, 0]}]}"#)
        .replace("\"depth\": 1.0", "\"depth\": 0.2");
    for (kind, said) in [
        ("pressure", "pressure"),
        ("surface", "x (length): "),
        ("gap", "gap left"),
        ("section", "surface under load"),
        ("patch", "patch"),
        ("pieces", "piece 2: 50.000 % of the force"),
        ("curve", "depth"),
    ] {
        let file = format!("{kind}.svg");
        let output = run(&["solve", "-", "-q", "--plot", &file, "--plot-kind", kind], at, two.as_bytes());
        assert_eq!(output.status.code(), Some(0), "{kind}: {}", String::from_utf8_lossy(&output.stderr));
        let text = fs::read_to_string(at.join(&file)).unwrap();
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>") && text.contains(said), "{kind}");
    }
    // Where the error sits; two contacts of three cells each have no bounds by cells, which is said.
    let drawn = |scene: &str, file: &str| {
        run(&["solve", "-", "-q", "--plot", file, "--plot-kind", "error"], at, scene.as_bytes())
    };
    assert!(drawn(CONE, "e.svg").status.success());
    assert!(fs::read_to_string(at.join("e.svg")).unwrap().contains("error of the energy"));
    let refused = drawn(&two, "none.svg");
    assert!(refused.status.code() == Some(2) && !at.join("none.svg").exists());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("no bounds of the energy by cells"));
    // A list is drawn as its states; other pictures are of one state.
    let list = CONE.replace("\"depth\": 1.0", "\"depths\": [0.5, 1.0]");
    assert!(run(&["solve", "-", "--plot", "l.svg"], at, list.as_bytes()).status.success());
    assert_eq!(fs::read_to_string(at.join("l.svg")).unwrap().matches("<circle").count(), 2);
    for (scene, kind) in
        [(&list, "pressure"), (&CONE.replace("\"solve\": {", "\"solve\": {\"method\": \"ritz\", "), "section")]
    {
        let output = run(&["solve", "-", "--plot", "x.svg", "--plot-kind", kind], at, scene.as_bytes());
        assert!(output.status.code() == Some(2) && !at.join("x.svg").exists(), "{kind}");
    }
}

#[test]
fn a_reader_that_leaves_is_not_a_fault() {
    for command in ["solve", "batch", "schema", "completions"] {
        let arguments: &[&str] = match command {
            "solve" => &["solve", "-", "--json", "-"],
            "completions" => &["completions", "bash"],
            other => &[other],
        };
        let mut child = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let _ = child.stdin.take().unwrap().write_all(CONE.replace('\n', " ").as_bytes());
        let output = child.wait_with_output().unwrap();
        assert!(output.stderr.is_empty(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn schema_names_every_kind_and_completions_know_the_commands() {
    let output = run(&["schema"], Path::new("."), b"");
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    for kind in schema["$defs"]["GapForm"]["oneOf"].as_array().unwrap() {
        assert!(kind["properties"]["at"].is_object() && kind["properties"]["kind"]["const"].is_string());
        assert_eq!(kind["additionalProperties"], false);
    }
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = run(&["completions", shell], Path::new("."), b"");
        let script = String::from_utf8_lossy(&output.stdout);
        for command in
            ["solve", "plan", "compare", "report", "curve", "batch", "stability", "schema", "completions", "man"]
        {
            assert!(script.contains(command), "{shell} does not know {command}");
        }
        assert!(script.contains("tolerance") && script.contains("bracket-cells"), "{shell}");
    }
    // Bash takes its script without a word.
    let script = run(&["completions", "bash"], Path::new("."), b"").stdout;
    if let Ok(mut bash) = Command::new("bash").arg("-n").stdin(Stdio::piped()).stderr(Stdio::piped()).spawn() {
        bash.stdin.take().unwrap().write_all(&script).unwrap();
        let output = bash.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_schema_knows_every_key_of_every_shipped_scene() {
    /// Whether the schema has the value's keys somewhere: names of properties, wherever they stand.
    fn names(schema: &Value, into: &mut std::collections::BTreeSet<String>) {
        match schema {
            Value::Object(map) => {
                if let Some(Value::Object(properties)) = map.get("properties") {
                    into.extend(properties.keys().cloned());
                }
                map.values().for_each(|value| names(value, into));
            }
            Value::Array(list) => list.iter().for_each(|value| names(value, into)),
            _ => {}
        }
    }
    fn keys(value: &Value, into: &mut std::collections::BTreeSet<String>) {
        match value {
            Value::Object(map) => {
                into.extend(map.keys().cloned());
                map.values().for_each(|value| keys(value, into));
            }
            Value::Array(list) => list.iter().for_each(|value| keys(value, into)),
            _ => {}
        }
    }
    let schema: Value = serde_json::from_slice(&run(&["schema"], Path::new("."), b"").stdout).unwrap();
    let (mut known, mut used) = Default::default();
    names(&schema, &mut known);
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "json") {
            keys(&serde_json::from_slice(&fs::read(path).unwrap()).unwrap(), &mut used);
        }
    }
    let unknown: Vec<_> = used.difference(&known).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}
