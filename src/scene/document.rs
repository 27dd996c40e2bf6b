//! A JSON document as it was written: order of keys kept, duplicate keys refused, every error with its path.

use std::cell::RefCell;
use std::fmt;

use serde::de::{self, DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use serde_json::Number;

use crate::error::InputError;

/// A JSON value. Unlike [`serde_json::Value`] it keeps the order of keys, and no key stands twice in an object.
#[derive(Debug, Clone, PartialEq)]
pub enum Json {
    /// null
    Null,
    /// true or false
    Bool(bool),
    /// A finite number.
    Number(Number),
    /// A string.
    String(String),
    /// A list.
    Array(Vec<Json>),
    /// Keys with their values, in the order they were written.
    Object(Vec<(String, Json)>),
}

/// The name of the document as a whole in an error.
pub(crate) const ROOT: &str = "$";

impl Json {
    /// Reads a document; a byte order mark before it is passed over.
    ///
    /// # Errors
    /// Where the text is not UTF-8 (byte offset), not JSON (line and column), nested deeper than 127 levels, or
    /// where a key stands twice. The path leads to the value that could not be read.
    pub fn parse(text: &[u8]) -> Result<Self, InputError> {
        let body = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let skipped = text.len() - body.len();
        let body = std::str::from_utf8(body).map_err(|e| {
            let at = skipped + e.valid_up_to();
            InputError::new(ROOT, format!("byte {:#04x} at offset {at}", text[at]), "JSON in UTF-8")
        })?;
        let path = RefCell::new(Vec::new());
        let mut reader = serde_json::Deserializer::from_str(body);
        let read = AtPath(&path).deserialize(&mut reader).and_then(|value| reader.end().map(|()| value));
        read.map_err(|e| fault(&e, body, &path.borrow()))
    }

    /// The value under this key of an object.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&Self> {
        match self {
            Self::Object(entries) => entries.iter().find(|(k, _)| k == key).map(|(_, value)| value),
            _ => None,
        }
    }

    /// The value in a few words, for an error.
    pub(crate) fn brief(&self) -> String {
        match self {
            Self::Null => "null".into(),
            Self::Bool(b) => b.to_string(),
            Self::Number(n) => n.to_string(),
            Self::String(s) => quoted(s),
            Self::Array(items) => match items.len() {
                0 => "an empty list".into(),
                n => format!("a list of {n}"),
            },
            Self::Object(entries) if entries.is_empty() => "an empty object".into(),
            Self::Object(entries) => {
                let keys: Vec<_> = entries.iter().take(4).map(|(key, _)| key.escape_debug().to_string()).collect();
                let more = if entries.len() > 4 { ", ..." } else { "" };
                format!("an object with {}{more}", shortened(&keys.join(", ")))
            }
        }
    }
}

/// A string in quotes on one line, cut where it is long.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", shortened(&text.escape_debug().to_string()))
}

fn shortened(text: &str) -> String {
    /// Longer values are cut: the message is one line.
    const LONGEST: usize = 60;
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    text.chars().take(LONGEST).chain("...".chars()).collect()
}

/// What the parser of JSON found wrong, with the piece of text it stands at.
fn fault(error: &serde_json::Error, text: &str, path: &[String]) -> InputError {
    let (line, column) = (error.line(), error.column());
    let place = joined(path);
    let message = error.to_string();
    let message = message.split(" at line ").next().unwrap_or_default();
    let at = format!("(line {line}, column {column})");
    if message.starts_with(TWICE) {
        return InputError::new(place, format!("this key a second time {at}"), "each key once");
    }
    if message.starts_with("recursion limit") {
        let place = format!("{} ...", joined(&path[..path.len().min(3)]));
        return InputError::new(place, format!("a nesting of more than 127 levels {at}"), "at most 127 levels");
    }
    let row = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    match number_like(row, column) {
        Some(word) => InputError::new(place, format!("{word} {at}"), "a finite number, or another JSON value"),
        None => InputError::new(place, format!("text that is not JSON {at}: {message}"), "a JSON document"),
    }
}

/// The word around this column if it tries to be a number: NaN, -Infinity, 1e999.
fn number_like(row: &str, column: usize) -> Option<&str> {
    let part = |c: u8| c.is_ascii_alphanumeric() || matches!(c, b'+' | b'-' | b'.');
    let bytes = row.as_bytes();
    // The parser stops on the first wrong byte, or on the last of the number.
    let on = [column.saturating_sub(1), column].into_iter().find(|&k| bytes.get(k).copied().is_some_and(part))?;
    let from = (0..=on).rev().take_while(|&k| part(bytes[k])).last()?;
    let to = (on..bytes.len()).take_while(|&k| part(bytes[k])).last()?;
    let word = row.get(from..=to)?;
    word.parse::<f64>().is_ok_and(|x| !x.is_finite()).then_some(word)
}

fn joined(path: &[String]) -> String {
    match path.concat() {
        place if place.is_empty() => ROOT.into(),
        place => place.strip_prefix('.').map(str::to_owned).unwrap_or(place),
    }
}

const TWICE: &str = "duplicate key";

/// Reads a value and leaves the path to it behind when it fails.
#[derive(Clone, Copy)]
struct AtPath<'a>(&'a RefCell<Vec<String>>);

impl AtPath<'_> {
    fn inside<T, E>(self, step: String, read: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        self.0.borrow_mut().push(step);
        let value = read()?;
        self.0.borrow_mut().pop();
        Ok(value)
    }
}

impl<'de> DeserializeSeed<'de> for AtPath<'_> {
    type Value = Json;

    fn deserialize<D: de::Deserializer<'de>>(self, from: D) -> Result<Json, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for AtPath<'_> {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::Number(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::Number(value.into()))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Json, E> {
        Number::from_f64(value).map(Json::Number).ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E>(self, value: &str) -> Result<Json, E> {
        Ok(Json::String(value.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Json, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = self.inside(format!("[{}]", items.len()), || list.next_element_seed(self))? {
            items.push(item);
        }
        Ok(Json::Array(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Json, A::Error> {
        let mut entries: Vec<(String, Json)> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        while let Some(key) = map.next_key::<String>()? {
            let value = self.inside(step(&key), || {
                if seen.insert(key.clone()) { map.next_value_seed(self) } else { Err(de::Error::custom(TWICE)) }
            })?;
            entries.push((key, value));
        }
        Ok(Json::Object(entries))
    }
}

/// One step of a path: `.key`, in brackets and quotes where the key is not a plain word.
fn step(key: &str) -> String {
    format!(".{}", key_in_path(key))
}

/// A key as it stands in a path.
pub(crate) fn key_in_path(key: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '$';
    if !key.is_empty() && key.len() <= 40 && key.chars().all(plain) { key.to_owned() } else { quoted(key) }
}

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Null => to.serialize_unit(),
            Self::Bool(value) => to.serialize_bool(*value),
            Self::Number(value) => value.serialize(to),
            Self::String(value) => to.serialize_str(value),
            Self::Array(items) => to.collect_seq(items),
            Self::Object(entries) => to.collect_map(entries.iter().map(|(key, value)| (key, value))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &[u8]) -> InputError {
        Json::parse(text).unwrap_err()
    }

    #[test]
    fn order_and_numbers_survive() {
        let text = r#"{"z":1,"a":[0.1,-2,1e300,true,null],"m":{"k":"\u00b5"}}"#;
        assert_eq!(
            serde_json::to_string(&Json::parse(text.as_bytes()).unwrap()).unwrap(),
            text.replace("\\u00b5", "µ").replace("1e300", "1e+300")
        );
    }

    #[test]
    fn duplicates_and_infinities_are_found_where_they_stand() {
        assert_eq!(refused(br#"{"gap": {"radius": 1, "radius": 2}}"#).path, "gap.radius");
        assert_eq!(refused(br#"{"gap": {"radii": [1, 1e999]}}"#).path, "gap.radii[1]");
        assert!(refused(br#"{"gap": {"radii": [1, NaN]}}"#).given.starts_with("NaN (line 1, column"));
        assert!(refused(br#"{"x": -Infinity}"#).given.starts_with("-Infinity"));
    }

    #[test]
    fn encoding_and_nesting() {
        assert!(Json::parse(b"\xef\xbb\xbf{}").is_ok());
        assert_eq!(refused(b"{\"a\": \"\xff\"}").given, "byte 0xff at offset 7");
        assert_eq!(refused(&b"[".repeat(100_000)).allowed, "at most 127 levels");
    }
}
