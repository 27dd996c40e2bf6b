//! Nothing in the mechanics knows the axes of the user: a contact that is turned is the same contact, and its answer turns with it.

use contact_patch::{Scene, Solution, solve};
use serde_json::{Value, json};

/// The states of a scene.
fn states(scene: &Value) -> Vec<Solution> {
    let text = scene.to_string();
    let scene = Scene::from_json(text.as_bytes()).unwrap();
    solve(&scene.contact, &scene.settings)
        .into_iter()
        .map(|state| state.unwrap_or_else(|e| panic!("{text}: {e}")))
        .collect()
}

fn rectangle(a: f64, b: f64) -> Vec<[f64; 2]> {
    vec![[-a, -b], [a, -b], [a, b], [-a, b]]
}

fn turned([x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Rollers of radius 1: sharp, crowned, with logarithmic ends, against a ball; under depths and forces.
fn gaps() -> Vec<(Value, Value)> {
    let ended = |expression: &str| json!({"kind": "formula", "expression": expression, "region": {"polygon": rectangle(0.9, 1.5)}});
    let depth = |d: f64| json!({"depth": d});
    let sharp = ended("x^2/2");
    let ball = json!({"kind": "sphere", "radius": 300.0});
    vec![
        (sharp.clone(), depth(1e-3)),
        (ended("x^2/2 + y^2/400"), depth(5e-3)),
        (ended("x^2/2 - 1e-4*ln(1 - (y/1.50015)^2)"), depth(5e-3)),
        (json!({"kind": "sum", "of": [sharp.clone(), ball]}), json!({"force": 1e-2})),
        (sharp, json!({"depths": [1e-3, 2e-3]})),
    ]
}

#[test]
fn a_turned_scene_has_the_answer_of_the_straight_one_turned() {
    for (gap, loading) in gaps() {
        let straight = states(&json!({"effective_modulus": 3.0, "gap": gap, "loading": loading}));
        for degrees in [37.0, 127.0, -80.0] {
            let mut placed = gap.clone();
            placed["rotate"] = json!(degrees);
            placed["at"] = json!([0.2, -0.1]);
            let turned_states = states(&json!({"effective_modulus": 3.0, "gap": placed, "loading": loading}));
            for (a, b) in straight.iter().zip(&turned_states) {
                // The parts of a sum are turned one by one: a rounding may lay another grid.
                let said = a.error().unwrap() + b.error().unwrap();
                let [same, area, place] = if gap["kind"] == "sum" { [said, 0.03, 1e-3] } else { [1e-6, 1e-3, 1e-6] };
                let off = (a.force / b.force - 1.0).abs().max((a.depth / b.depth - 1.0).abs());
                assert!(off < same, "{gap} {degrees}: {off:e}");
                assert!((a.patch.area / b.patch.area - 1.0).abs() < area);
                let (p, q) = (a.patch.centroid.unwrap(), b.patch.centroid.unwrap());
                let p = turned(p, degrees);
                assert!((p[0] + 0.2 - q[0]).hypot(p[1] - 0.1 - q[1]) < place, "{p:?} {q:?}");
                // Its rectangle holds its ends, but for a part of a cell.
                let [min, max] = b.patch.extent().unwrap();
                let [low, high] = a.patch.extent().unwrap();
                let end = turned([0.5 * (low[0] + high[0]), high[1]], degrees);
                let end = [end[0] + 0.2, end[1] - 0.1];
                assert!((0..2).all(|m| min[m] - 2e-2 < end[m] && end[m] < max[m] + 2e-2), "{end:?} {min:?} {max:?}");
            }
        }
    }
}

#[test]
fn a_region_that_is_drawn_turned_is_a_turned_region() {
    let straight = json!({"kind": "formula", "expression": "x^2/2", "region": {"polygon": rectangle(0.9, 1.5)}});
    let (sin, cos) = 37f64.to_radians().sin_cos();
    let corners: Vec<_> = rectangle(0.9, 1.5).into_iter().map(|p| turned(p, 37.0)).collect();
    let drawn =
        json!({"kind": "formula", "expression": format!("({cos}*x + {sin}*y)^2/2"), "region": {"polygon": corners}});
    let force =
        |gap: &Value| states(&json!({"effective_modulus": 1.0, "gap": gap, "loading": {"depth": 1e-3}})).remove(0);
    let (a, b) = (force(&straight), force(&drawn));
    // In axes turned there and back an edge may be a rounding off the cells: then by other grids.
    let said = a.force_error.unwrap() + b.force_error.unwrap();
    assert!((a.force / b.force - 1.0).abs() < said, "{} {}", a.force, b.force);
    let summed = json!({"kind": "sum", "of": [drawn, {"kind": "sphere", "radius": 1e9}]});
    let c = force(&summed);
    assert!((a.force / c.force - 1.0).abs() < a.force_error.unwrap() + c.force_error.unwrap());
}

#[test]
fn tilts_and_moments_turn_with_the_body() {
    let gap = json!({"kind": "formula", "expression": "x^2/2", "region": {"polygon": rectangle(0.9, 1.5)}});
    let tilt = [0.0, 2e-4];
    let scene = |gap: &Value, tilt: [f64; 2]| json!({"effective_modulus": 1.0, "gap": gap, "loading": {"depth": 1e-3, "tilt": tilt}, "output": ["patch"]});
    let a = states(&scene(&gap, tilt)).remove(0);
    let mut placed = gap.clone();
    placed["rotate"] = json!(50.0);
    let b = states(&scene(&placed, turned(tilt, 50.0))).remove(0);
    // Along axes that are exchanged the box around the contact, and with it every grid, may be another.
    let said = a.force_error.unwrap() + b.force_error.unwrap();
    assert!((a.force / b.force - 1.0).abs() < said && said < 2e-3);
    let (m, n) = (turned(a.moment.unwrap(), 50.0), b.moment.unwrap());
    assert!((0..2).all(|k| (m[k] - n[k]).abs() < said * a.force), "{m:?} {n:?}");
    // K of the turned axes: (1, R) K (1, R^T).
    let (k, l) = (a.stiffness_matrix.unwrap(), b.stiffness_matrix.unwrap());
    let column = turned([k[1][0], k[2][0]], 50.0);
    let stiffer = a.stiffness_error.unwrap() + b.stiffness_error.unwrap();
    assert!(stiffer < 0.03 && (k[0][0] / l[0][0] - 1.0).abs() < stiffer);
    assert!((0..2).all(|m| (column[m] - l[m + 1][0]).abs() < stiffer * k[0][0]), "{column:?} {l:?}");
    assert!((k[1][1] + k[2][2] - l[1][1] - l[2][2]).abs() < stiffer * (k[1][1] + k[2][2]));
    // Every point of its boundary lies where the body is.
    for point in b.patch.boundary.unwrap().iter().flatten() {
        let [x, y] = turned(*point, -50.0);
        assert!(x.abs() < 0.2 && y.abs() < 1.5 + 1e-9);
    }
}

#[test]
fn a_field_that_is_asked_for_changes_no_number() {
    // Wide enough that the contact ends inside of the material, and so narrow that it ends at its edges.
    for (b, load) in [(1.5, json!({"depth": 1e-3})), (0.01, json!({"force": 1e-3}))] {
        let gap = json!({"kind": "formula", "expression": "x^2/2 + y^4/3", "region": {"polygon": rectangle(0.9, b)}, "rotate": 20.0});
        let scene = |output: Value| json!({"effective_modulus": 1.0, "gap": gap, "loading": load, "output": output});
        let without = states(&scene(json!(["patch"]))).remove(0);
        let with = states(&scene(json!(["patch", "pressure"]))).remove(0);
        assert_eq!((without.origin, without.turned), (with.origin, with.turned));
        assert!((with.turned.unwrap() - 20f64.to_radians()).abs() < 1e-12);
        assert!(
            (with.force - without.force).abs() <= 1e-6 * with.force
                && (with.depth - without.depth).abs() <= 1e-6 * with.depth
        );
        // Its means carry the load of the cells, at the same place.
        let field = with.pressure.field.unwrap();
        assert!(
            (field.force() / with.force - 1.0).abs() < with.force_error.unwrap().max(with.depth_error.unwrap()) + 1e-2
        );
    }
}

#[test]
fn a_field_has_its_force_along_whatever_axes() {
    let gap =
        json!({"kind": "formula", "expression": "x^2/2", "region": {"polygon": rectangle(0.9, 1.5)}, "rotate": 50.0});
    let scene = json!({"effective_modulus": 1.0, "gap": gap, "loading": {"depth": 1e-3}, "output": ["pressure"], "solve": {"seconds": 1}});
    let state = states(&scene).remove(0);
    let field = state.pressure.field.unwrap();
    assert!((field.force() / state.force - 1.0).abs() < 0.02);
    // Nothing is pressed where the body is not, but for what a cell spreads.
    let room = 2.0 * field.grid.spacing[0].max(field.grid.spacing[1]);
    for k in (0..field.values.len()).filter(|&k| field.values[k] > 0.0) {
        let [x, y] = turned(field.grid.centre_of(k), -50.0);
        assert!(x.abs() < 0.1 + room && y.abs() < 1.5 + room, "{x} {y}");
    }
}
