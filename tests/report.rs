//! `contact-patch report`: one page, whole or not at all, that needs nothing else.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use contact_patch::compare::Plan;
use contact_patch::{Scene, report};

fn written(directory: &Path, scene: &str, options: &[&str]) -> Output {
    fs::write(directory.join("scene.json"), scene).unwrap();
    Command::new(env!("CARGO_BIN_EXE_contact-patch"))
        .args(["report", "scene.json", "-o", "report.html"])
        .args(options)
        .current_dir(directory)
        .output()
        .unwrap()
}

/// The page of a scene, and the exit code.
fn page(scene: &str, options: &[&str]) -> (String, Option<i32>) {
    let directory = tempfile::tempdir().unwrap();
    let output = written(directory.path(), scene, options);
    let names: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}: {}", String::from_utf8_lossy(&output.stderr));
    (fs::read_to_string(directory.path().join("report.html")).unwrap(), output.status.code())
}

/// Every tag that is opened is closed, in order: a parser for what the page may hold, void elements apart.
fn well_formed(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html.strip_prefix("<!DOCTYPE html>\n").unwrap();
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("an end of the tag");
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "before {:.80}", rest);
        } else if !tag.ends_with('/') {
            let name = tag.split_whitespace().next().unwrap();
            if name == "style" || name == "script" {
                rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
            }
            if !["meta", "link"].contains(&name) {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

/// Nothing is fetched: the only addresses are the names of SVG's own language, images are in the page, and a policy says so to browsers.
fn self_contained(html: &str) {
    let without = html.replace("http://www.w3.org/2000/svg", "").replace("href=\"data:", "");
    for needle in ["http:", "https:", "@import", "url(", " src=", "href=", "import(", "fetch("] {
        assert!(!without.contains(needle), "{needle}");
    }
    assert!(html.contains("Content-Security-Policy\" content=\"default-src 'none';"));
}

/// Pictures, each for wide and for narrow screens.
fn pictures(html: &str) -> usize {
    let [page, phone] = ["page", "phone"].map(|kind| html.matches(&format!("<svg class=\"{kind}\"")).count());
    assert_eq!(page, phone);
    page
}

#[test]
fn a_page_holds_all_there_is_to_say() {
    let (html, code) = page(
        r#"{"name": "punch <i>&\"1\"</i>", "effective_modulus": 1.0, "loading": {"depth": 1.0},
            "gap": {"kind": "pyramid", "faces": 4, "inclination": 45.0}}"#,
        &["--with", "all", "--author", "A. <B>"],
    );
    assert_eq!(code, Some(0));
    well_formed(&html);
    self_contained(&html);
    assert!(html.contains("punch &lt;i&gt;&amp;&quot;1&quot;&lt;/i&gt;") && !html.contains("<i>"));
    for heading in [
        "Problem",
        "Plan",
        "Result",
        "Patch and section",
        "Force against depth",
        "Every method",
        "Bounds",
        "Cost",
        "How this page was made",
    ] {
        assert!(html.contains(&format!("<h2>{heading}")), "{heading}");
    }
    // Patch, pressure, section, curve, error against time, width of brackets.
    assert_eq!(pictures(&html), 6);
    // Converged by boundary elements: 0.737616; the page shows six digits of an answer good to 1e-3.
    assert!(html.contains("<b>0.737") || html.contains("<b>0.738"));
    for method in ["closed_form", "ritz", "fabrikant", "qp", "fft", "auto"] {
        assert!(html.contains(&format!("<td>{method}</td>")), "{method}");
    }
    assert!(html.contains("@media print") && html.contains("proved"));
    // Who, when, with what, and how again; the scene is folded. Nothing was left out.
    assert!(html.contains("A. &lt;B&gt;") && html.contains(" UTC</td>") && html.contains(env!("CARGO_PKG_VERSION")));
    assert!(html.contains("contact-patch report scene.json -o report.html --with all --author &#39;A. &lt;B&gt;&#39;"));
    assert!(html.contains("<details>\n<summary>") && !html.contains("Not in this report"));
}

#[test]
fn what_costs_more_than_the_answer_is_left_out_and_listed() {
    let (html, code) = page(
        r#"{"effective_modulus": 1.0, "loading": {"force": 1.0}, "units": {"length": "mm", "force": "N"},
            "gap": {"kind": "sum", "of": [{"kind": "sphere", "radius": 1.0}, {"kind": "pyramid", "faces": 4, "inclination": 5.0}]}}"#,
        &[],
    );
    assert_eq!(code, Some(0));
    well_formed(&html);
    self_contained(&html);
    assert!(
        html.contains("<h2>Not in this report") && !html.contains("<h2>Every method") && !html.contains("<h2>Bounds")
    );
    for option in ["--with methods", "--with bounds"] {
        assert!(html.contains(option), "{option}");
    }
    // The picture is there, with the numbers behind it: whole cells of a field between nothing and its largest value.
    assert!(pictures(&html) >= 3);
    let from = html.find("id=\"data\">").unwrap() + 10;
    let data: serde_json::Value =
        serde_json::from_str(&html[from..][..html[from..].find("</script>").unwrap()]).unwrap();
    let cells = data["shape"][0].as_u64().unwrap() * data["shape"][1].as_u64().unwrap();
    for field in ["pressure", "gap"] {
        assert_eq!(data[field].as_str().unwrap().len() as u64, (2 * cells).div_ceil(3) * 4, "{field}");
    }
    assert!(data["most"].as_f64().unwrap() > 0.0 && data["units"]["pressure"] == "MPa");
}

#[test]
fn what_is_not_solved_is_a_page_too() {
    let (html, code) = page(
        r#"{"effective_modulus": 1.0, "gap": {"kind": "pyramid", "faces": 2, "inclination": 45.0},
            "loading": {"depths": [-1.0, 1.0]}}"#,
        &[],
    );
    assert_eq!(code, Some(1));
    well_formed(&html);
    self_contained(&html);
    assert!(html.contains("not solved: unbounded") && pictures(&html) == 0);
}

#[test]
fn lists_forces_and_tilts_have_pages() {
    for (loading, svgs) in [
        (r#"{"forces": [0.5, 1.0]}"#, 6),
        // No curve of a punch that tilts.
        (r#"{"depth": 1.0, "tilt": [0.1, 0.0]}"#, 5),
        (r#"{"depth": -1.0}"#, 0),
    ] {
        let text = format!(
            r#"{{"effective_modulus": 1.0, "gap": {{"kind": "paraboloid", "radii": [1.0, 1.0]}}, "loading": {loading}}}"#
        );
        let scene = Scene::from_json(text.as_bytes()).unwrap();
        let runs = Plan { fft_cells: vec![16, 32], qp_cells: vec![12], repeats: 1, ..Plan::new(scene.settings) };
        let page = report::page(&scene, &runs, &mut |_| ());
        assert!(page.solved, "{loading}");
        well_formed(&page.html);
        self_contained(&page.html);
        assert_eq!(pictures(&page.html), svgs, "{loading}");
    }
}

#[test]
fn wrong_scenes_and_arguments_leave_no_page() {
    const CONE: &str =
        r#"{"effective_modulus": 1.0, "gap": {"kind": "cone", "inclination": 45.0}, "loading": {"depth": 1.0}}"#;
    let directory = tempfile::tempdir().unwrap();
    let output = written(directory.path(), &CONE.replace("cone", "comb"), &[]);
    assert_eq!(output.status.code(), Some(2));
    fs::write(directory.path().join("scene.json"), CONE).unwrap();
    let wrong: [&[&str]; 7] = [
        &["report", "scene.json"],
        &["report", "absent.json", "-o", "report.html"],
        &["report", "scene.json", "-o", "absent/report.html"],
        &["report", "scene.json", "-o", "."],
        &["report", "scene.json", "-o", "report.html", "--threads", "0"],
        &["report", "scene.json", "-o", "report.html", "--tolerance", "-1"],
        &["report", "scene.json", "-o", "report.html", "--with", "everything"],
    ];
    for arguments in wrong {
        let output = Command::new(env!("CARGO_BIN_EXE_contact-patch"))
            .args(arguments)
            .current_dir(directory.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
        assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"), "{arguments:?}");
        let names: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|f| f.unwrap().file_name()).collect();
        assert_eq!(names, ["scene.json"], "{arguments:?}");
    }
}
