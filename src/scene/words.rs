//! The words of users for those of a scene: what is meant, and how it is written here.

/// A word, the known word that it stands for, and what to say.
type Meaning = (&'static str, &'static str, &'static str);

/// Words that are used in the field, or in other programs, for what a scene calls otherwise.
const MEANINGS: &[Meaning] = &[
    ("cylinder", "paraboloid", "a cylinder is {\"kind\": \"paraboloid\", \"radii\": [R, \"flat\"]}"),
    ("roller", "profile", "a roller is a \"paraboloid\" with two radii, or a \"profile\" with a rolling radius"),
    ("wheel", "profile", "a wheel is a \"profile\" with its rolling \"radius\""),
    ("rail", "profile", "a rail is a \"profile\" with \"surface\": \"lower\""),
    ("ball", "sphere", "a ball is {\"kind\": \"sphere\", \"radius\": R}"),
    ("hertz", "closed_form", "Hertz's formula is one of those of \"closed_form\""),
    ("ellipsoid", "paraboloid", "an ellipsoid is {\"kind\": \"paraboloid\", \"radii\": [R1, R2]} near its pole"),
    ("parabola", "paraboloid", "a parabola of revolution is {\"kind\": \"paraboloid\", \"radii\": [R, R]}"),
    ("wedge", "pyramid", "a wedge is {\"kind\": \"pyramid\", \"faces\": 2, \"inclination\": degrees}"),
    ("punch", "flat", "a flat punch is {\"kind\": \"flat\", \"outline\": {...}}"),
    ("expression", "formula", "a formula is {\"kind\": \"formula\", \"expression\": \"x^2/2 + y^2/2\"}"),
    ("function", "formula", "a function is {\"kind\": \"formula\", \"expression\": \"x^2/2 + y^2/2\"}"),
    ("surface", "height_map", "a measured surface is a \"height_map\""),
    ("map", "height_map", "a measured surface is a \"height_map\""),
    ("circle", "disc", "a circle is {\"disc\": radius}"),
    ("disk", "disc", "a disc is {\"disc\": radius}"),
    ("rectangle", "polygon", "a rectangle is a polygon: {\"polygon\": [[x, y], ...]} with its four corners"),
    ("square", "polygon", "a square is a polygon: {\"polygon\": [[x, y], ...]} with its four corners"),
    ("diameter", "radius", "write \"radius\", half the diameter"),
    ("radius", "outline", "write \"outline\": {\"disc\": radius}"),
    ("angle", "inclination", "write \"inclination\", the angle between a face and the surface in degrees"),
    ("face_angle", "inclination", "write \"inclination\", 90 degrees less the angle between a face and the axis"),
    ("sides", "faces", "write \"faces\""),
    ("load", "force", "write \"force\""),
    ("p", "force", "write \"force\""),
    ("indentation", "depth", "write \"depth\""),
    ("displacement", "depth", "write \"depth\""),
    ("approach", "depth", "write \"depth\""),
    ("pressure", "force", "a contact is loaded by \"force\" or \"depth\"; the pressure is an answer"),
    ("parts", "of", "write \"of\": [gap, ...]"),
    ("gaps", "of", "write \"of\": [gap, ...]"),
    ("formula", "expression", "write \"expression\": \"x^2/2 + y^2/2\""),
    ("data", "points", "write \"points\" or \"file\""),
    ("e_star", "effective_modulus", "write \"effective_modulus\""),
    ("estar", "effective_modulus", "write \"effective_modulus\""),
    (
        "material",
        "youngs_modulus",
        "there is no table of materials: write the numbers, \"youngs_modulus\" (E) and \"poissons_ratio\" (nu)",
    ),
    ("young", "youngs_modulus", "write \"youngs_modulus\", or E"),
    ("poisson", "poissons_ratio", "write \"poissons_ratio\", or nu"),
    ("v", "poissons_ratio", "write \"poissons_ratio\", or nu"),
    ("mu", "shear_modulus", "write \"shear_modulus\", or G"),
    ("accuracy", "tolerance", "write \"tolerance\""),
    ("precision", "tolerance", "write \"tolerance\""),
    ("grid", "cells", "write \"cells\", the number along the longer side"),
    ("resolution", "cells", "write \"cells\", the number along the longer side"),
    ("mesh", "cells", "write \"cells\", the number along the longer side"),
    ("timeout", "seconds", "write \"seconds\""),
];

/// The letters of the field for keys of a body.
const LETTERS: [(&str, &str); 3] = [("E", "youngs_modulus"), ("nu", "poissons_ratio"), ("G", "shear_modulus")];

/// The letter that may stand for a key.
pub(super) fn letter_of(key: &str) -> Option<&'static str> {
    LETTERS.iter().find(|(_, long)| *long == key).map(|(letter, _)| *letter)
}

/// What to say of a word that stands for a known one.
pub(super) fn meant(word: &str, known: &[&str]) -> Option<&'static str> {
    let word = word.to_ascii_lowercase();
    MEANINGS.iter().find(|(used, for_it, _)| *used == word && known.contains(for_it)).map(|m| m.2)
}

/// One of several forms, as it is written.
pub(super) fn shown(form: &str) -> String {
    match form {
        "disc" => "{\"disc\": radius}".into(),
        "ellipse" => "{\"ellipse\": [a, b]}".into(),
        "polygon" => "{\"polygon\": [[x, y], ...]}".into(),
        "fourier" => "{\"fourier\": order}".into(),
        word => format!("\"{word}\""),
    }
}

/// What a key that is missing would say.
pub(super) fn required(key: &str) -> String {
    let what = match key {
        "poissons_ratio" => "Poisson's ratio, \"poissons_ratio\" or nu, stands beside the modulus: 0.3 for steel",
        "youngs_modulus" => "Young's modulus, \"youngs_modulus\" or E, stands beside Poisson's ratio",
        "outline" => "the edge of the punch: {\"disc\": radius}, {\"ellipse\": [a, b]} or {\"polygon\": [[x, y], ...]}",
        "inclination" => "the angle between a face and the surface, in degrees",
        "surface" => "\"upper\" or \"lower\": whose heights the file holds; heights count upwards",
        "along" => "\"x\" or \"y\": the axis along which the profile is straight, or rolled",
        "faces" => "the number of faces, 2 (a wedge) or more",
        "radii" => "the relative radii of curvature [R1, R2] along x and y; \"flat\" for a straight one",
        "radius" => "the radius, in the scene's unit of length",
        "expression" => "the gap as a formula in x, y, r and theta: \"x^2/2 + y^2/2\"",
        "file" => "the name of the file, relative to the scene",
        "gap" => "the initial gap of the bodies: {\"kind\": ..., ...}",
        "loading" => {
            "one of {\"depth\": d}, {\"force\": P}, {\"depths\": [...]}, {\"forces\": [...]}, {\"depth_range\": {...}}"
        }
        _ => return "this key is required".into(),
    };
    format!("this key is required: {what}")
}

/// What to write in place of a text where a number belongs.
pub(super) fn number_in(text: &str) -> String {
    let text = text.trim();
    if text.parse::<f64>().is_ok_and(f64::is_finite) {
        return format!("a number without quotes: {text}");
    }
    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
    let head = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.').trim();
    let number = Some(head)
        .filter(|head| !head.is_empty() && head.chars().all(digits))
        .and_then(|head| head.parse::<f64>().ok());
    match number {
        Some(value) if text.ends_with('%') => format!("a number without quotes or per cent: {}", value / 100.0),
        Some(_) => "a number without quotes or unit, in units that agree with one another (SI: m, N, Pa)".into(),
        None => "a number".into(),
    }
}
