//! `contact-patch batch --table`, and the library's tables behind it.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::{Command, Output};

use contact_patch::gap::Paraboloid;
use contact_patch::scene::{Given, Json};
use contact_patch::table::{Column, Template, WRONG_SCENE};
use contact_patch::{Interrupt, Scene, solve};

const SCENE: &str =
    r#"{"effective_modulus": 2.0, "gap": {"kind": "paraboloid", "radii": [1.0, 1.0]}, "loading": {"depth": 1.0}}"#;

fn run(directory: &Path, rows: &str, scene: &str, more: &[&str]) -> Output {
    std::fs::write(directory.join("rows.csv"), rows).unwrap();
    std::fs::write(directory.join("scene.json"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_contact-patch"));
    command.args(["batch", "--table", "rows.csv", "--template", "scene.json"]).args(more);
    command.current_dir(directory).output().unwrap()
}

fn text(output: &Output) -> (String, String, Option<i32>) {
    let lossy = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (lossy(&output.stdout), lossy(&output.stderr), output.status.code())
}

#[test]
fn rows_are_scenes_alone() {
    let depths: Vec<f64> = (-3..40).map(|k| 0.03 * f64::from(k)).collect();
    let radii: Vec<f64> = (0..43).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
    let outputs = ["force", "stiffness", "patch.area", "moment[0]", "pressure.max", "origin.kind"];
    let template = Template::new(SCENE.as_bytes(), &["/loading/depth", "/gap/radii/1"], &outputs).unwrap();
    let columns = [Column::Numbers(&depths), Column::Numbers(&radii)];
    let [one, three] = [1, 3].map(|threads| template.solve(&columns, threads, None).unwrap());
    for (k, (depth, radius)) in depths.iter().zip(&radii).enumerate() {
        let text = SCENE
            .replace("\"depth\": 1.0", &format!("\"depth\": {depth}"))
            .replace("[1.0, 1.0]", &format!("[1.0, {radius}]"));
        let scene = Scene::from_json(text.as_bytes()).unwrap();
        let alone = solve(&scene.contact, &scene.settings).remove(0).unwrap();
        let wanted = [
            Some(alone.force),
            Some(alone.stiffness),
            Some(alone.patch.area),
            alone.moment.map(|m| m[0]),
            alone.pressure.max,
        ];
        for (column, wanted) in one.numbers.iter().zip(wanted) {
            assert_eq!(column[k].to_bits(), wanted.unwrap_or(f64::NAN).to_bits());
        }
        assert_eq!(one.words[5][k].as_deref(), Some(alone.origin.kind()));
    }
    assert_eq!(one.verdicts, three.verdicts);
    assert!((0..5).all(|c| one.numbers[c].iter().zip(&three.numbers[c]).all(|(a, b)| a.to_bits() == b.to_bits())));
}

#[test]
fn parts_that_no_column_changes_are_kept_and_others_read_again() {
    let given = Given::default().gap("bowl", Paraboloid::new([1.0, 1.0]).unwrap());
    let text = br#"{"effective_modulus": 1.0, "gap": {"kind": "given", "name": "bowl"}, "loading": {"depth": 1.0}}"#;
    let columns = ["/effective_modulus", "/loading/depth"];
    let template = Template::new(text, &columns, &["force"]).unwrap().with(given);
    let answers =
        template.solve(&[Column::Numbers(&[0.75, 1.5, 0.75]), Column::Numbers(&[1.0, 1.0, 4.0])], 1, None).unwrap();
    for (force, wanted) in answers.numbers[0].iter().zip([1.0, 2.0, 8.0]) {
        assert!((force / wanted - 1.0).abs() < 1e-12);
    }
}

#[test]
fn an_interrupt_leaves_rows_unanswered() {
    let interrupt = Interrupt::new();
    interrupt.set();
    let template = Template::new(SCENE.as_bytes(), &["/loading/depth"], &["force"]).unwrap();
    let answers = template.solve(&[Column::Numbers(&[1.0; 100])], 2, Some(&interrupt)).unwrap();
    assert!(answers.verdicts.iter().all(|v| *v == "interrupted") && answers.numbers[0].iter().all(|f| f.is_nan()));
}

#[test]
fn wrong_cells_are_wrong_rows_and_a_wrong_template_is_an_error() {
    let word = |w: &str| Json::String(w.to_owned());
    let template = Template::new(SCENE.as_bytes(), &["/gap/kind"], &["force", "reason"]).unwrap();
    let kinds = [word("paraboloid"), word("parabolid"), Json::Null, word("paraboloid")];
    let answers = template.solve(&[Column::Values(&kinds)], 1, None).unwrap();
    assert_eq!(answers.verdicts, ["solved", WRONG_SCENE, WRONG_SCENE, "solved"]);
    assert!(answers.words[1][1].as_deref().unwrap().starts_with("gap.kind"));
    assert_eq!(answers.numbers[0][0], answers.numbers[0][3]);
    let misspelt = SCENE.replace("radii", "radius");
    let refused = Template::new(misspelt.as_bytes(), &["/loading/depth"], &[]).unwrap().solve(
        &[Column::Numbers(&[1.0])],
        1,
        None,
    );
    assert_eq!(refused.unwrap_err().path, "gap.radius");
    for (columns, outputs, path) in [
        (["/loading/nowhere/depth"], ["force"], "column"),
        (["depth"], ["force"], "column"),
        (["/loading/depth"], ["farce"], "outputs"),
    ] {
        assert_eq!(Template::new(SCENE.as_bytes(), &columns, &outputs).err().unwrap().path, path);
    }
}

#[test]
fn a_csv_comes_back_with_answers_in_order() {
    let directory = tempfile::tempdir().unwrap();
    let mut rows = "name,/loading/depth\n".to_owned();
    // More than a block of rows.
    for k in 0..5000 {
        rows.push_str(&format!("\"row, {k}\",{}\n", 1.0 + 1e-4 * f64::from(k)));
    }
    rows.push_str("bad,deep\nempty,\n");
    let (out, err, code) =
        text(&run(directory.path(), &rows, SCENE, &["--outputs", "force,depth,reason", "--jobs", "2"]));
    assert_eq!((err.as_str(), code), ("", Some(0)));
    let mut reader = csv::Reader::from_reader(out.as_bytes());
    assert_eq!(reader.headers().unwrap(), vec!["name", "/loading/depth", "force", "depth", "reason", "verdict"]);
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(records.len(), 5002);
    for (k, record) in records[..5000].iter().enumerate() {
        assert_eq!(&record[0], format!("row, {k}"));
        let [depth, force, echo] = [1, 2, 3].map(|c| record[c].parse::<f64>().unwrap());
        assert_eq!(depth, echo);
        assert!((force / (8.0 / 3.0 * depth.powf(1.5)) - 1.0).abs() < 1e-12);
        assert_eq!((&record[4], &record[5]), ("", "solved"));
    }
    for record in &records[5000..] {
        assert_eq!((&record[2], &record[5]), ("", WRONG_SCENE));
        assert!(record[4].contains("loading.depth"));
    }
    let (_, _, code) = text(&run(directory.path(), "/loading/depth\nx\n", SCENE, &["--strict"]));
    assert_eq!(code, Some(1));
}

#[test]
fn wrong_tables_are_refused_in_one_message() {
    let directory = tempfile::tempdir().unwrap();
    let long = "/loading/depth\n1\n1,2\n";
    for (rows, scene, more, told) in [
        ("depth\n1\n", SCENE, &[][..], "JSON pointer"),
        ("/loading/depth\n1\n", "{", &[], "not JSON"),
        ("/loading/depth\n1\n", r#"{"gap": 1, "loading": {}}"#, &[], "bodies"),
        ("/loading/depth\n1\n", SCENE, &["--outputs", "farce"], "farce"),
        ("/loading/depth,force\n1,2\n", SCENE, &["--outputs", "force"], "--outputs"),
        (long, SCENE, &[], "rows.csv"),
        ("/loading/depth\n1\n", SCENE, &["-o", "rows.csv"], "which is read"),
        ("/loading/depth\n1\n", SCENE, &["-o", "scene.json"], "which is read"),
        ("/loading/depth\n1\n", SCENE, &["--seconds", "-1"], "--seconds"),
    ] {
        let (_, err, code) = text(&run(directory.path(), rows, scene, more));
        assert_eq!(code, Some(2), "{rows} {err}");
        assert!(err.contains(told) && err.trim_end().lines().count() == 1, "{err}");
    }
    let output =
        Command::new(env!("CARGO_BIN_EXE_contact-patch")).args(["batch", "--table", "x.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
