//! What is wrong with a value, in the words of users: [`InputError`] as an error of serde.

use std::fmt::Display;

use serde::de::{self, Unexpected};

use super::document::{key_in_path, quoted};
use super::words;
use crate::error::InputError;

/// An unknown key or word, with the nearest known one.
pub(super) fn unknown(path: String, given: impl Display, word: &str, known: &[&str]) -> InputError {
    let all = known.join(", ");
    if let Some(meaning) = words::meant(word, known) {
        return InputError::new(path, given, format!("{meaning}. Known here: {all}"));
    }
    let nearest = known.iter().map(|k| (strsim::jaro_winkler(word, k), *k)).max_by(|a, b| a.0.total_cmp(&b.0));
    let allowed = match nearest {
        // Below this the likeness is chance.
        Some((likeness, key)) if likeness > 0.7 => format!("did you mean \"{key}\"? Known here: {all}"),
        _ => format!("one of: {all}"),
    };
    InputError::new(path, given, allowed)
}

/// An error of decoding.
#[derive(Debug)]
pub(super) struct Fault {
    pub error: InputError,
    /// A key of the outermost object that is not among the known ones.
    pub key: Option<(String, &'static [&'static str])>,
}

impl Fault {
    pub fn new(path: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        InputError::new(path, given, allowed).into()
    }
}

impl From<InputError> for Fault {
    fn from(error: InputError) -> Self {
        Self { error, key: None }
    }
}

impl std::error::Error for Fault {}

impl Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.error.fmt(f)
    }
}

impl de::Error for Fault {
    fn custom<T: Display>(message: T) -> Self {
        Self::new("", "", message.to_string())
    }

    fn invalid_type(given: Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        let allowed = match (given, named(expected)) {
            (Unexpected::Str(text), allowed) if allowed == "a number" => words::number_in(text),
            (Unexpected::Str(text), allowed) if allowed == "a list" => {
                format!("a list, in brackets: [{}]", quoted(text))
            }
            (_, allowed) => allowed,
        };
        Self::new("", in_words(&given), allowed)
    }

    fn invalid_value(given: Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        Self::invalid_type(given, expected)
    }

    fn invalid_length(length: usize, expected: &dyn de::Expected) -> Self {
        Self::new("", format!("a list of {length}"), named(expected))
    }

    fn unknown_variant(word: &str, known: &'static [&'static str]) -> Self {
        unknown(String::new(), quoted(word), word, known).into()
    }

    fn unknown_field(key: &str, known: &'static [&'static str]) -> Self {
        let error = unknown(key_in_path(key), "an unknown key", key, known);
        Self { error, key: Some((key.to_owned(), known)) }
    }

    fn missing_field(key: &'static str) -> Self {
        Self::new(key, "nothing", words::required(key))
    }

    /// A document has each key once: this one stands there by its letter, too.
    fn duplicate_field(key: &'static str) -> Self {
        let letter = words::letter_of(key).unwrap_or(key);
        Self::new("", format!("both {letter} and {key}"), "one of the two: they are the same")
    }
}

fn in_words(given: &Unexpected<'_>) -> String {
    match given {
        Unexpected::Bool(b) => b.to_string(),
        Unexpected::Unsigned(n) => n.to_string(),
        Unexpected::Signed(n) => n.to_string(),
        Unexpected::Float(x) => format!("{x:?}"),
        Unexpected::Str(s) => quoted(s),
        Unexpected::Unit | Unexpected::Option => "null".into(),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "an object".into(),
        other => other.to_string(),
    }
}

/// The words of a user for those of Rust.
fn named(expected: &dyn de::Expected) -> String {
    match expected.to_string().as_str() {
        "f64" => "a number".into(),
        "usize" | "u64" | "u32" => "a whole number, 0 or more".into(),
        "a sequence" => "a list".into(),
        "an array of length 2" => "a list of 2 numbers".into(),
        "an array of length 3" => "a list of 3 numbers".into(),
        words if words.starts_with("struct ") || words == "a map" => "an object".into(),
        words => words.to_owned(),
    }
}
