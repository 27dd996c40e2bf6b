//! Wrong scenes: exit code 2, one line that names the place, nothing on standard output, nothing written.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const GOOD: &str = r#"{
  "name": "good",
  "bodies": [{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"],
  "gap": {"kind": "cone", "inclination": 45.0},
  "loading": {"depth": -1e-6},
  "solve": {"method": "auto", "tolerance": 1e-3},
  "output": ["patch"]
}"#;

const BODIES: &str = r#""bodies": [{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"]"#;
const GAP: &str = r#""gap": {"kind": "cone", "inclination": 45.0}"#;
const LOADING: &str = r#""loading": {"depth": -1e-6}"#;
const SOLVE: &str = r#""solve": {"method": "auto", "tolerance": 1e-3}"#;
const OUTPUT: &str = r#""output": ["patch"]"#;

/// What is replaced in the good scene, by what, and the path that the message has to name.
const WRONG: &[(&str, &str, &str)] = &[
    // Keys: missing, unknown, doubled, together.
    (GAP, r#""gap2": 1"#, "gap2"),
    ("\"name\": \"good\",\n", "\"nam\": \"good\",\n", "nam"),
    (LOADING, r#""loading": {}"#, "loading"),
    (LOADING, r#""loading": {"depth": 1, "force": 1}"#, "loading"),
    (LOADING, r#""loading": {"depth": 1, "depth": 2}"#, "loading.depth"),
    (LOADING, r#""loading": {"dept": 1}"#, "loading.dept"),
    (LOADING, r#""loading": {"depth": 1}, "loading": {"depth": 1}"#, "loading"),
    (BODIES, r#""bodies": ["rigid"], "effective_modulus": 1"#, "effective_modulus"),
    (BODIES, r#""name2": 1"#, "name2"),
    (BODIES, r#""bodies": null"#, "bodies"),
    (GAP, r#""gap": {"inclination": 45.0}"#, "gap.kind"),
    (GAP, r#""gap": {"kind": "cone"}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "cone", "inclination": 45.0, "rotat": 3}"#, "gap.rotat"),
    (GAP, r#""gap": {"kind": "kone", "inclination": 45.0}"#, "gap.kind"),
    (SOLVE, r#""solve": {"metod": "qp"}"#, "solve.metod"),
    (SOLVE, r#""solve": {"method": "qpp"}"#, "solve.method"),
    (OUTPUT, r#""output": ["patches"]"#, "output[0]"),
    (OUTPUT, r#""output": ["patch", 3]"#, "output[1]"),
    (OUTPUT, r#""output": "patch""#, "output"),
    // Types.
    (BODIES, r#""bodies": "rigid""#, "bodies"),
    (BODIES, r#""bodies": {"youngs_modulus": 1, "poissons_ratio": 0.3}"#, "bodies"),
    (BODIES, r#""bodies": [[]]"#, "bodies[0]"),
    (BODIES, r#""effective_modulus": "1""#, "effective_modulus"),
    (GAP, r#""gap": "cone""#, "gap"),
    (GAP, r#""gap": null"#, "gap"),
    (GAP, r#""gap": {"kind": 3}"#, "gap.kind"),
    (GAP, r#""gap": {"kind": "cone", "inclination": true}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "cone", "inclination": "45"}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "paraboloid", "radii": 1}"#, "gap.radii"),
    (GAP, r#""gap": {"kind": "paraboloid", "radii": [1]}"#, "gap.radii"),
    (GAP, r#""gap": {"kind": "paraboloid", "radii": [1, 2, 3]}"#, "gap.radii"),
    (GAP, r#""gap": {"kind": "cone", "inclination": 45.0, "at": [0, "x"]}"#, "gap.at[1]"),
    (GAP, r#""gap": {"kind": "polyhedron", "planes": [[0, 0, 0], [1, 2]]}"#, "gap.planes[1]"),
    (LOADING, r#""loading": 1"#, "loading"),
    (LOADING, r#""loading": {"depth": [1]}"#, "loading.depth"),
    (LOADING, r#""loading": {"depths": 1}"#, "loading.depths"),
    (LOADING, r#""loading": {"depths": [1, false]}"#, "loading.depths[1]"),
    (LOADING, r#""loading": {"depth_range": {"to": 1, "steps": 2.5}}"#, "loading.depth_range.steps"),
    ("\"name\": \"good\"", "\"name\": 7", "name"),
    // Values.
    (BODIES, r#""bodies": []"#, "bodies"),
    (BODIES, r#""bodies": ["rigid"]"#, "bodies"),
    (BODIES, r#""bodies": ["rigid", "rigid"]"#, "bodies"),
    (BODIES, r#""bodies": ["rigid", "rigid", "rigid"]"#, "bodies"),
    (BODIES, r#""bodies": ["rigit"]"#, "bodies[0]"),
    (BODIES, r#""bodies": [{"youngs_modulus": 1, "poissons_ratio": 0.6}]"#, "bodies[0].poissons_ratio"),
    (BODIES, r#""bodies": ["rigid", {"youngs_modulus": 1, "poissons_ratio": -1}]"#, "bodies[1].poissons_ratio"),
    (BODIES, r#""bodies": [{"youngs_modulus": 0, "poissons_ratio": 0.3}]"#, "bodies[0].youngs_modulus"),
    (BODIES, r#""bodies": [{"shear_modulus": -1, "poissons_ratio": 0.3}]"#, "bodies[0].shear_modulus"),
    (BODIES, r#""bodies": [{"shear_modulus": 1, "youngs_modulus": 1, "poissons_ratio": 0.3}]"#, "bodies[0]"),
    (BODIES, r#""bodies": [{"youngs_modulus": 1}]"#, "bodies[0].poissons_ratio"),
    (BODIES, r#""effective_modulus": 0"#, "effective_modulus"),
    (GAP, r#""gap": {"kind": "cone", "inclination": 0}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "cone", "inclination": 90}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "cone", "inclination": -45}"#, "gap.inclination"),
    (GAP, r#""gap": {"kind": "pyramid", "faces": 1, "inclination": 45}"#, "gap.faces"),
    (GAP, r#""gap": {"kind": "pyramid", "faces": -3, "inclination": 45}"#, "gap.faces"),
    (GAP, r#""gap": {"kind": "pyramid", "faces": 3, "inclination": 45, "flat": 0}"#, "gap.flat"),
    (GAP, r#""gap": {"kind": "paraboloid", "radii": [0, 1]}"#, "gap.radii[0]"),
    (GAP, r#""gap": {"kind": "paraboloid", "radii": [1, -1]}"#, "gap.radii[1]"),
    (GAP, r#""gap": {"kind": "sphere", "radius": 0}"#, "gap.radius"),
    (GAP, r#""gap": {"kind": "power", "coefficient": 0, "exponent": 2}"#, "gap.coefficient"),
    (GAP, r#""gap": {"kind": "power", "coefficient": 1, "exponent": -2}"#, "gap.exponent"),
    (GAP, r#""gap": {"kind": "polyhedron", "planes": []}"#, "gap.planes"),
    (GAP, r#""gap": {"kind": "flat", "outline": {"disc": -1}}"#, "gap.outline.disc"),
    (GAP, r#""gap": {"kind": "flat", "outline": {"disk": 1}}"#, "gap.outline.disk"),
    (GAP, r#""gap": {"kind": "flat", "outline": {"polygon": [[0, 0], [1, 0]]}}"#, "gap.outline.polygon"),
    (GAP, r#""gap": {"kind": "revolved", "points": [[0, 0], [-1, 1]]}"#, "gap.points[1][0]"),
    (GAP, r#""gap": {"kind": "sum", "of": []}"#, "gap.of"),
    (
        GAP,
        r#""gap": {"kind": "min", "of": [{"kind": "sphere", "radius": 1}, {"kind": "sphere", "radius": -1}]}"#,
        "gap.of[1].radius",
    ),
    (
        GAP,
        r#""gap": {"kind": "sum", "of": [{"kind": "sum", "of": [{"kind": "sphere", "radios": 1}]}]}"#,
        "gap.of[0].of[0].radios",
    ),
    (LOADING, r#""loading": {"depths": []}"#, "loading.depths"),
    (LOADING, r#""loading": {"force": -1}"#, "loading.force"),
    (LOADING, r#""loading": {"forces": [1, -1]}"#, "loading.forces[1]"),
    (LOADING, r#""loading": {"force": 1, "through": [0, 0], "moment": [0, 0]}"#, "loading"),
    (LOADING, r#""loading": {"force": 1, "tilt": [0, 0]}"#, "loading.tilt"),
    (LOADING, r#""loading": {"depth_range": {"to": 1, "steps": 0}}"#, "loading.depth_range.steps"),
    (LOADING, r#""loading": {"depth_range": {"to": 1, "steps": 1e12}}"#, "loading.depth_range.steps"),
    (SOLVE, r#""solve": {"cells": 1000000000}"#, "solve.cells"),
    (SOLVE, r#""solve": {"cells": 1e9}"#, "solve.cells"),
    (SOLVE, r#""solve": {"cells": 0}"#, "solve.cells"),
    (SOLVE, r#""solve": {"tolerance": 0}"#, "solve.tolerance"),
    (SOLVE, r#""solve": {"tolerance": 1}"#, "solve.tolerance"),
    (SOLVE, r#""solve": {"kernel": "mean"}"#, "solve.kernel"),
    (SOLVE, r#""solve": {"boundary": {"fourier": -1}}"#, "solve.boundary.fourier"),
    (SOLVE, r#""solve": {"boundary": {"circle": 1}}"#, "solve.boundary.circle"),
    // Not numbers, not JSON.
    ("45.0", "NaN", "gap.inclination"),
    ("45.0", "Infinity", "gap.inclination"),
    ("45.0", "-Infinity", "gap.inclination"),
    ("45.0", "1e999", "gap.inclination"),
    ("45.0", "-1e999", "gap.inclination"),
    ("45.0", "45.0.0", "gap"),
    ("45.0}", "45.0", "$"),
    ("\"patch\"]\n}", "\"patch\"]", "$"),
    ("\"patch\"]\n}", "\"patch\"]\n} {}", "$"),
];

fn run(scene: &Path, directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .args(["solve", "--json", "out.json", "--csv", "out.csv"])
        .arg(scene)
        .current_dir(directory)
        .output()
        .unwrap()
}

/// One line on stderr that starts with the file and the path; exit code 2; nothing anywhere else.
fn refused(content: &[u8], path: &str) -> String {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("scene.json"), content).unwrap();
    let output = run(Path::new("scene.json"), directory.path());
    let (told, shown) = (
        String::from_utf8(output.stderr).unwrap(),
        String::from_utf8_lossy(content).chars().take(400).collect::<String>(),
    );
    assert_eq!(output.status.code(), Some(2), "{shown}: {told}");
    assert!(
        told.starts_with(&format!("scene.json: {path}: given ")) && told.contains("; allowed: "),
        "{shown}: {told}"
    );
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(told.len() < 600, "{told}");
    assert!(output.stdout.is_empty());
    let left: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(left, ["scene.json"]);
    told
}

#[test]
fn every_wrong_scene_is_refused_by_the_path_of_what_is_wrong() {
    assert!(WRONG.len() >= 60);
    for (part, by, path) in WRONG {
        assert!(GOOD.contains(part), "{part}");
        refused(GOOD.replace(part, by).as_bytes(), path);
    }
}

#[test]
fn the_good_scene_is_solved() {
    let directory = tempfile::tempdir().unwrap();
    for start in ["", "\u{feff}"] {
        fs::write(directory.path().join("scene.json"), format!("{start}{GOOD}")).unwrap();
        let output = run(Path::new("scene.json"), directory.path());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(directory.path().join("out.json").exists());
    }
}

#[test]
fn an_unknown_key_is_answered_with_the_nearest_known_one() {
    let told =
        refused(GOOD.replace(GAP, r#""gap": {"kind": "cone", "inclinaton": 45.0}"#).as_bytes(), "gap.inclinaton");
    assert!(told.contains("did you mean \"inclination\"?"), "{told}");
    let told = refused(
        GOOD.replace(GAP, r#""gap": {"kind": "cone", "inclination": 45.0, "rotat": 3}"#).as_bytes(),
        "gap.rotat",
    );
    assert!(told.contains("did you mean \"rotate\"?"), "{told}");
}

#[test]
fn what_is_not_a_scene_at_all() {
    refused(b"", "$");
    refused(b"[]", "$");
    refused(b"null", "$");
    refused(b"7", "$");
    assert!(refused(b"{\"name\": \"\xff\"}", "$").contains("offset 10"));
    assert!(refused(b"{\n\n  \"name\": x}", "name").contains("line 3, column 11"));
    assert!(refused(format!("{{\"name\": {}}}", "[".repeat(1_000_000)).as_bytes(), "name[0][0] ...").contains("127"));
    refused("{\"name\": \"a\u{0}\"}".as_bytes(), "name");
    refused(b"{\"two\\nlines\": 1}", "\"two\\nlines\"");
}

#[test]
fn files_that_cannot_be_read() {
    let directory = tempfile::tempdir().unwrap();
    for (file, what) in [("absent.json", "no such file"), (".", "a directory")] {
        let output = run(Path::new(file), directory.path());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(what) && told.lines().count() == 1, "{told}");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    }
}
