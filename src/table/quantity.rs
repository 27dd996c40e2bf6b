//! What is taken out of a result: a number or a word, named by its place in the result.

use crate::error::InputError;
use crate::report::{self, Step};
use crate::scene::Scene;
use crate::solution::Solution;

type NumberOf = fn(&Solution) -> Option<f64>;
type WordOf = fn(&Step) -> Option<String>;

/// A column of answers.
#[derive(Debug, Clone)]
pub(super) enum Quantity {
    /// A number that every solution has at hand.
    Known(NumberOf),
    /// A number somewhere in the result: the steps of a JSON pointer.
    Elsewhere(String),
    /// A word.
    Word(WordOf),
    /// What is wrong, in a sentence: of a row that is not a scene, too.
    Reason,
}

/// Numbers that are taken without writing the result.
const KNOWN: [(&str, NumberOf); 14] = [
    ("depth", |s| Some(s.depth)),
    ("force", |s| Some(s.force)),
    ("force_error", |s| s.force_error),
    ("stiffness", |s| Some(s.stiffness)),
    ("energy", |s| s.energy),
    ("bracket.lower", |s| s.bracket.as_ref().map(|b| b.lower())),
    ("bracket.upper", |s| s.bracket.as_ref().map(|b| b.upper())),
    ("patch.area", |s| Some(s.patch.area)),
    ("patch.max_radius", |s| Some(s.patch.max_radius)),
    ("patch.centroid[0]", |s| s.patch.centroid.map(|c| c[0])),
    ("patch.centroid[1]", |s| s.patch.centroid.map(|c| c[1])),
    ("pressure.max", |s| s.pressure.max),
    ("pressure.mean", |s| s.pressure.mean),
    ("cost.seconds", |s| Some(s.cost.seconds)),
];

/// Words.
const WORDS: [(&str, WordOf); 5] = [
    ("method", |s| report::numbers(s).map(|s| s.method.name().to_owned())),
    ("evidence", |s| report::numbers(s).filter(|s| s.force_error.is_some()).map(|s| s.evidence().word().to_owned())),
    ("origin.kind", |s| report::numbers(s).map(|s| s.origin.kind().to_owned())),
    ("hint", |s| s.as_ref().err().and_then(|e| e.hint.clone())),
    ("remarks", |s| report::numbers(s).map(|s| s.remarks.join("; ")).filter(|text| !text.is_empty())),
];

/// The name of [`Quantity::Reason`].
const REASON: &str = "reason";

/// The keys of a result that have numbers in them.
const KEYS: [&str; 24] = [
    "area_error",
    "bracket",
    "centre_of_pressure",
    "checks",
    "cost",
    "depth",
    "depth_error",
    "energy",
    "energy_error",
    "force",
    "force_error",
    "gap",
    "grid",
    "map_error",
    "moment",
    "origin",
    "patch",
    "pressure",
    "stiffness",
    "stiffness_error",
    "stiffness_matrix",
    "tilt",
    "touches_edge",
    "validity",
];

impl Quantity {
    /// Reads a name: `force`, `patch.area`, `moment[0]`, `method`, `reason`.
    ///
    /// # Errors
    /// Names `outputs` when a result has no such key.
    pub fn parse(name: &str) -> Result<Self, InputError> {
        if let Some((_, of)) = KNOWN.iter().find(|(known, _)| *known == name) {
            return Ok(Self::Known(*of));
        }
        if let Some((_, of)) = WORDS.iter().find(|(known, _)| *known == name) {
            return Ok(Self::Word(*of));
        }
        if name == REASON {
            return Ok(Self::Reason);
        }
        let steps = name.replace("][", ".").replace('[', ".").replace(']', "");
        let mut split = steps.split('.');
        let first = split.next().unwrap_or_default();
        if KEYS.contains(&first) && split.all(|step| !step.is_empty()) {
            return Ok(Self::Elsewhere(format!("/{}", steps.replace('.', "/"))));
        }
        let known: Vec<&str> = WORDS.iter().map(|(name, _)| *name).chain([REASON]).chain(KEYS).collect();
        let allowed =
            format!("a place in a result, such as force, patch.area or moment[0]; its keys: {}", known.join(", "));
        Err(InputError::new("outputs", super::quoted(name), allowed))
    }
}

impl Quantity {
    /// Whether it is a word, not a number.
    pub fn is_word(&self) -> bool {
        matches!(self, Self::Word(_) | Self::Reason)
    }

    /// The word of an answer.
    pub fn word(&self, step: &Step) -> Option<String> {
        match self {
            Self::Word(of) => of(step),
            Self::Reason => step.as_ref().err().map(|unsolved| unsolved.reason.clone()),
            Self::Known(_) | Self::Elsewhere(_) => None,
        }
    }

    /// The word of a row that has no answer, for this reason.
    pub fn word_without(&self, reason: &str) -> Option<String> {
        matches!(self, Self::Reason).then(|| reason.to_owned())
    }
}

/// The numbers of one answer, in the order of `quantities`; NaN for what it does not have.
pub(super) fn numbers(quantities: &[Quantity], scene: &Scene, step: &Step, to: &mut [f64]) {
    let mut whole = None;
    for (quantity, to) in quantities.iter().zip(to) {
        let number = match quantity {
            Quantity::Known(of) => report::numbers(step).and_then(of),
            Quantity::Word(_) | Quantity::Reason => None,
            Quantity::Elsewhere(pointer) => whole
                .get_or_insert_with(|| {
                    let result = report::json(scene, std::slice::from_ref(step)).without_fields();
                    serde_json::to_value(result).unwrap_or_default()
                })
                .pointer(pointer)
                .and_then(serde_json::Value::as_f64),
        };
        *to = number.filter(|x| x.is_finite()).unwrap_or(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_a_result() {
        let scene = br#"{"effective_modulus": 1.0, "gap": {"kind": "height_map", "file": "bowl", "surface": "upper"},
            "loading": {"force": 1.0}, "solve": {"cells": 16, "tolerance": 0.5}, "output": ["gap", "bracket", "energy"]}"#;
        let heights: Vec<f64> =
            (0..81).map(|k| [k % 9, k / 9].map(|i| (f64::from(i) - 4.0).powi(2)).iter().sum()).collect();
        let heights = crate::gap::Heights::new(heights, [9, 9], [1.0, 1.0]).unwrap();
        let scene = Scene::from_json_with(scene, &crate::scene::Given::default().heights("bowl", heights)).unwrap();
        let step = &crate::solve(&scene.contact, &scene.settings)[0];
        let result = serde_json::to_value(report::json(&scene, std::slice::from_ref(step))).unwrap();
        for (name, of) in KNOWN {
            let pointer = format!("/{}", name.replace(['.', '['], "/").replace(']', ""));
            let written = result.pointer(&pointer).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(written.as_f64(), report::numbers(step).and_then(of), "{name}");
        }
        for key in KEYS {
            // A matrix is given for a punch that is free to tilt.
            assert!(result.get(key).is_some() || key == "stiffness_matrix", "{key}");
        }
    }
}
