//! The bodies of a scene.

use serde::Deserialize;

use super::decode::decode;
use super::document::{Json, quoted};
use super::fault::unknown;
use super::words;
use crate::error::InputError;
use crate::problem::{Body, EffectiveModulus};

/// A body: its Young's or shear modulus with Poisson's ratio, or "rigid".
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum BodyForm {
    Young(YoungForm),
    Shear(ShearForm),
    YoungLetters(YoungLettersForm),
    ShearLetters(ShearLettersForm),
    Rigid(RigidForm),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct YoungForm {
    /// Young's modulus E > 0, in units of stress.
    #[serde(alias = "E")]
    youngs_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[serde(alias = "nu")]
    poissons_ratio: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ShearForm {
    /// Shear modulus mu > 0, in units of stress.
    #[serde(alias = "G")]
    shear_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[serde(alias = "nu")]
    poissons_ratio: f64,
}

/// The same in the letters of the field.
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) struct YoungLettersForm {
    /// Young's modulus E > 0, in units of stress.
    #[schemars(rename = "E")]
    youngs_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[schemars(rename = "nu")]
    poissons_ratio: f64,
}

/// The same in the letters of the field.
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) struct ShearLettersForm {
    /// Shear modulus mu > 0, in units of stress.
    #[schemars(rename = "G")]
    shear_modulus: f64,
    /// Poisson's ratio, greater than -1 and at most 0.5.
    #[schemars(rename = "nu")]
    poissons_ratio: f64,
}

/// A body that does not deform.
#[cfg(test)]
#[derive(schemars::JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[expect(dead_code, reason = "this form is only for the JSON Schema")]
pub(super) enum RigidForm {
    Rigid,
}

/// The body at `path`; errors name the key as it was written.
fn body(value: &Json, path: &str) -> Result<Body, InputError> {
    let has = |key: &str| value.get(key).is_some() || words::letter_of(key).is_some_and(|k| value.get(k).is_some());
    let body = match value {
        Json::String(word) if word == "rigid" => return Ok(Body::RIGID),
        Json::String(word) if strsim::jaro_winkler(word, "rigid") < 0.8 => {
            let allowed = "numbers, as there is no table of materials: {\"youngs_modulus\": 2.1e11, \"poissons_ratio\": 0.3} is steel \
                           in Pa; or \"rigid\"";
            return Err(InputError::new(path, quoted(word), allowed));
        }
        Json::String(word) => return Err(unknown(path.into(), quoted(word), word, &["rigid"])),
        Json::Object(_) if has("shear_modulus") && has("youngs_modulus") => {
            return Err(InputError::new(
                path,
                "both youngs_modulus and shear_modulus",
                "one of the two, with poissons_ratio",
            ));
        }
        Json::Object(_) if has("shear_modulus") => {
            let ShearForm { shear_modulus, poissons_ratio } = decode(value, path)?;
            Body::elastic_in_shear(shear_modulus, poissons_ratio)
        }
        Json::Object(_) => {
            let YoungForm { youngs_modulus, poissons_ratio } = decode(value, path)?;
            Body::elastic(youngs_modulus, poissons_ratio)
        }
        other => {
            let allowed = "{youngs_modulus, poissons_ratio}, {shear_modulus, poissons_ratio} or \"rigid\"";
            return Err(InputError::new(path, other.brief(), allowed));
        }
    };
    body.map_err(|e| match words::letter_of(&e.path).filter(|letter| value.get(letter).is_some()) {
        Some(letter) => InputError { path: format!("{path}.{letter}"), ..e },
        None => e.within(path),
    })
}

/// E* from `bodies` or `effective_modulus`.
pub(super) fn modulus(bodies: Option<&Json>, e_star: Option<f64>) -> Result<EffectiveModulus, InputError> {
    match (bodies, e_star) {
        (Some(_), Some(_)) => Err(InputError::new(
            "effective_modulus",
            "a modulus of the pair beside bodies",
            "either bodies or effective_modulus",
        )),
        (None, Some(e_star)) => EffectiveModulus::from_e_star(e_star),
        (None, None) => {
            Err(InputError::new("bodies", "nothing", "one or two bodies, or effective_modulus in their place"))
        }
        (Some(Json::Array(items)), None) => match items.as_slice() {
            [one] => EffectiveModulus::of_pair(body(one, "bodies[0]")?, Body::RIGID)
                .map_err(|e| InputError { given: "one rigid body".into(), ..e }),
            [one, other] => EffectiveModulus::of_pair(body(one, "bodies[0]")?, body(other, "bodies[1]")?),
            _ => Err(InputError::new("bodies", format!("a list of {}", items.len()), "one or two bodies")),
        },
        (Some(other), None) => {
            let allowed = "a list of one or two bodies, in brackets: [{\"youngs_modulus\": E, \"poissons_ratio\": nu}, \"rigid\"]";
            Err(InputError::new("bodies", other.brief(), allowed))
        }
    }
}
