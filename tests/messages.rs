//! What a user is told: mistakes as they are made, and the sentences that answer them.
#![cfg(all(feature = "scene", feature = "formula"))]

use contact_patch::{Scene, solve};
use serde_json::{Value, json};

fn scene() -> Value {
    json!({
        "bodies": [{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"],
        "gap": {"kind": "sphere", "radius": 0.01},
        "loading": {"depth": 1e-6}
    })
}

/// The scene with some of its keys replaced.
fn with(changes: &Value) -> Vec<u8> {
    let mut scene = scene();
    for (key, value) in changes.as_object().unwrap() {
        scene[key] = value.clone();
    }
    serde_json::to_vec(&scene).unwrap()
}

fn formula(expression: &str) -> Value {
    json!({"gap": {"kind": "formula", "expression": expression}})
}

#[test]
fn thirty_mistakes_are_answered_in_the_words_of_who_made_them() {
    let mistakes: Vec<(Value, &str, &str)> = vec![
        (json!({"gap": {"kind": "flat", "outline": "disc"}}), "gap.outline", "{\"disc\": radius}"),
        (json!({"gap": {"kind": "flat", "outline": 0.1}}), "gap.outline", "{\"polygon\": [[x, y], ...]}"),
        (
            json!({"gap": {"kind": "flat", "outline": {"circle": 1}}}),
            "gap.outline.circle",
            "a circle is {\"disc\": radius}",
        ),
        (json!({"gap": {"kind": "flat", "outline": {"square": 1}}}), "gap.outline.square", "with its four corners"),
        (json!({"gap": {"kind": "flat", "radius": 1}}), "gap.radius", "write \"outline\": {\"disc\": radius}"),
        (json!({"gap": {"kind": "flat"}}), "gap.outline", "the edge of the punch"),
        (json!({"bodies": ["steel", "rigid"]}), "bodies[0]", "there is no table of materials"),
        (json!({"bodies": [{"material": "steel"}]}), "bodies[0].material", "there is no table of materials"),
        (json!({"bodies": [{"E": 210}, "rigid"]}), "bodies[0].poissons_ratio", "0.3 for steel"),
        (json!({"bodies": [{"E": 210, "youngs_modulus": 210, "nu": 0.3}]}), "bodies[0]", "they are the same"),
        (json!({"bodies": [{"E": -1, "nu": 0.3}]}), "bodies[0].E", "greater than 0"),
        (json!({"bodies": [{"G": 8e10, "nu": 0.7}]}), "bodies[0].nu", "0.5"),
        (json!({"bodies": {"E": 1, "nu": 0.3}}), "bodies", "in brackets"),
        (json!({"bodies": [{"E": "210 GPa", "nu": 0.3}]}), "bodies[0].E", "without quotes or unit"),
        (json!({"gap": {"kind": "sphere", "radius": "0.01"}}), "gap.radius", "a number without quotes: 0.01"),
        (json!({"gap": {"kind": "sphere", "diameter": 1}}), "gap.diameter", "half the diameter"),
        (json!({"gap": {"kind": "cylinder", "radius": 1}}), "gap.kind", "\"radii\": [R, \"flat\"]"),
        (json!({"gap": {"kind": "wedge", "inclination": 1}}), "gap.kind", "\"faces\": 2"),
        (json!({"gap": {"type": "sphere", "radius": 1}}), "gap.kind", "one of: paraboloid"),
        (json!({"gap": {"kind": "cone", "angle": 45}}), "gap.angle", "write \"inclination\""),
        (json!({"gap": {"kind": "vickers", "inclination": 22}}), "gap.inclination", "face_angle"),
        (json!({"gap": {"kind": "sum", "parts": []}}), "gap.parts", "write \"of\""),
        (json!({"gap": {"kind": "height_map", "file": "a.txt"}}), "gap.surface", "whose heights the file holds"),
        (json!({"gap": {"kind": "profile", "points": [[0, 0], [1, 1]]}}), "gap.along", "the axis along which"),
        (json!({"gap": {"kind": "profile", "along": "x"}}), "gap.points", "file in their place"),
        (json!({"loading": {"load": 100}}), "loading.load", "write \"force\""),
        (json!({"loading": {"force": "100 N"}}), "loading.force", "without quotes or unit"),
        (json!({"loading": {"indentation": 1}}), "loading.indentation", "write \"depth\""),
        (json!({"solve": {"tolerance": "1%"}}), "solve.tolerance", "per cent: 0.01"),
        (json!({"solve": {"method": "hertz"}}), "solve.method", "closed_form"),
        (json!({"output": "patch"}), "output", "in brackets: [\"patch\"]"),
        (formula("x^2 + if(y > 0, y, 0)"), "gap.expression", "there are no conditions"),
        (formula("if(y, y, 0)"), "gap.expression", "there are no conditions"),
        (formula("y > 0 ? x : 1"), "gap.expression", "there are no conditions"),
        (formula("2x"), "gap.expression", "a product is written with a star"),
        (formula("sin x"), "gap.expression", "sin(...)"),
        (formula("0,5*x^2"), "gap.expression", "a decimal point"),
        (formula("|x|"), "gap.expression", "abs(x)"),
        (formula("x²"), "gap.expression", "x^2"),
        (formula("X^2"), "gap.expression", "did you mean x?"),
        (formula("z = x^2"), "gap.expression", "the gap alone"),
        (formula("a*x^2"), "gap.expression", "others are written as numbers"),
        (formula("arctan(x)"), "gap.expression", "did you mean atan?"),
    ];
    assert!(mistakes.len() >= 30);
    for (changes, path, sentence) in mistakes {
        let error = Scene::from_json(&with(&changes)).expect_err(&changes.to_string());
        assert_eq!(error.path, path, "{changes}: {error}");
        assert!(error.allowed.contains(sentence), "{changes}: {error}");
        // Nothing of the parser's own words.
        let told = error.to_string();
        assert!(!["variant", "struct", "expected struct", "Option", "f64"].iter().any(|w| told.contains(w)), "{told}");
    }
}

#[test]
fn a_contact_without_an_end_is_said_to_be_a_line_contact() {
    for gap in [
        json!({"kind": "pyramid", "faces": 2, "inclination": 20}),
        json!({"kind": "paraboloid", "radii": [0.01, "flat"]}),
        json!({"kind": "profile", "along": "x", "points": [[-1, 1], [0, 0], [1, 1], [2, 4]]}),
        json!({"kind": "formula", "expression": "x**2"}),
    ] {
        for loading in [json!({"depth": 1e-6}), json!({"force": 100})] {
            let scene = Scene::from_json(&with(&json!({"gap": gap, "loading": loading}))).unwrap();
            let unsolved = solve(&scene.contact, &scene.settings).remove(0).expect_err(&gap.to_string());
            assert_eq!(unsolved.verdict.word(), "unbounded", "{gap} {loading}");
            assert!(unsolved.reason.contains("line contacts"), "{gap} {loading}: {}", unsolved.reason);
            let hint = unsolved.hint.unwrap_or_default();
            assert!(hint.contains("a \"sum\" with a body that ends"), "{gap} {loading}: {hint}");
        }
    }
}

#[test]
fn letters_stand_for_the_names_of_moduli() {
    let force = |bodies: Value| {
        let scene = Scene::from_json(&with(&json!({"bodies": bodies}))).unwrap();
        solve(&scene.contact, &scene.settings).remove(0).unwrap().force
    };
    let long = force(json!([{"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}, "rigid"]));
    assert_eq!(force(json!([{"E": 2.1e11, "nu": 0.3}, "rigid"])), long);
    assert_eq!(force(json!([{"E": 2.1e11, "poissons_ratio": 0.3}, "rigid"])), long);
    assert!((force(json!([{"G": 2.1e11 / 2.6, "nu": 0.3}])) / long - 1.0).abs() < 1e-14);
}

#[test]
fn indenters_have_the_angles_of_their_standard() {
    let gap = |gap: Value| Scene::from_json(&with(&json!({"gap": gap}))).unwrap().contact;
    let at = |of: Value, x: f64| contact_patch::Gap::gap(gap(of).gap(), x, 0.0);
    // Along the normal of a face the gap rises by cot(face angle).
    let cot = |degrees: f64| 1.0 / degrees.to_radians().tan();
    assert!((at(json!({"kind": "berkovich"}), 1.0) - cot(65.27)).abs() < 1e-14);
    assert!((at(json!({"kind": "vickers"}), 1.0) - cot(68.0)).abs() < 1e-14);
    assert!((at(json!({"kind": "cube_corner"}), 1.0) - 2f64.sqrt()).abs() < 1e-14);
    assert!((at(json!({"kind": "berkovich", "face_angle": 65.03}), 1.0) - cot(65.03)).abs() < 1e-14);
    // Vickers and Berkovich have the same area at a depth: 4 tan^2 68 and 3 sqrt(3) tan^2 65.27 are 24.5.
    let area = 3.0 * 3f64.sqrt() / cot(65.27).powi(2);
    assert!((area / (4.0 / cot(68.0).powi(2)) - 1.0).abs() < 2e-3);
    let error = Scene::from_json(&with(&json!({"gap": {"kind": "vickers", "face_angle": 90}}))).unwrap_err();
    assert_eq!(error.path, "gap.face_angle");
}
