//! From a JSON value to a typed one, with errors that say where, what was given and what is allowed.
//!
//! A [`serde::Deserializer`] over [`Json`] whose error is an [`InputError`]: the structures of a scene are declared
//! once, and that declaration is also what the JSON Schema is made from.

use std::fmt::Display;

use serde::de::value::StrDeserializer;
use serde::de::{self, Deserialize, DeserializeSeed, Unexpected, VariantAccess, Visitor};

use super::document::{Json, ROOT, key_in_path, quoted};
use super::words;
use crate::error::InputError;

/// Reads a `T`; `path` leads to `value` in the document.
pub(super) fn decode<'a, T: Deserialize<'a>>(value: &'a Json, path: &str) -> Result<T, InputError> {
    decode_without(value, path, &[])
}

/// Reads a `T` from the result of one state of loading: what is a list with an entry a state is read as that entry, which of how
/// many `state` says.
pub(crate) fn decode_state<'a, T: Deserialize<'a>>(
    result: &'a Json,
    state: Option<[usize; 2]>,
) -> Result<T, InputError> {
    T::deserialize(Decoder { value: result, read: &[], state }).map_err(|fault| rooted(fault.error))
}

/// Reads a `T` from an object, passing over the keys that were read already.
pub(super) fn decode_without<'a, T: Deserialize<'a>>(
    value: &'a Json,
    path: &str,
    read: &'a [&'static str],
) -> Result<T, InputError> {
    T::deserialize(Decoder { value, read, state: None }).map_err(|fault| {
        let error = match fault.key {
            // The keys that were read already are known too.
            Some((key, known)) => {
                let known: Vec<&str> = read.iter().chain(known).copied().collect();
                unknown(key_in_path(&key), fault.error.given, &key, &known)
            }
            None => fault.error,
        };
        if path == ROOT { rooted(error) } else { error.within(path) }
    })
}

fn rooted(mut error: InputError) -> InputError {
    if error.path.is_empty() {
        error.path = ROOT.into();
    }
    error
}

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

/// [`InputError`] with the face that serde asks for.
#[derive(Debug)]
struct Fault {
    error: InputError,
    /// A key of the outermost object that is not among the known ones.
    key: Option<(String, &'static [&'static str])>,
}

impl Fault {
    fn new(path: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        InputError::new(path, given, allowed).into()
    }

    fn within(self, outer: &str) -> Self {
        self.error.within(outer).into()
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
        Self::new("", "this value", message.to_string())
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
}

fn in_words(given: &Unexpected<'_>) -> String {
    match given {
        Unexpected::Bool(b) => b.to_string(),
        Unexpected::Unsigned(n) => n.to_string(),
        Unexpected::Signed(n) => n.to_string(),
        Unexpected::Float(x) => x.to_string(),
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

#[derive(Clone, Copy)]
struct Decoder<'a> {
    value: &'a Json,
    /// Keys of this object that were read already.
    read: &'a [&'static str],
    /// Which of how many entries of a list is meant.
    state: Option<[usize; 2]>,
}

/// The name of a type that stands for one entry of a list, see [`decode_state`].
const ENTRY: &str = "Entry";

impl<'a> From<&'a Json> for Decoder<'a> {
    fn from(value: &'a Json) -> Self {
        Self { value, read: &[], state: None }
    }
}

/// Whole numbers that an f64 holds exactly.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

impl<'a> Decoder<'a> {
    /// A whole number may be written as 1e3 or 3.0.
    fn whole<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Number(n) if n.is_f64() => match n.as_f64() {
                Some(x) if x.fract() == 0.0 && (0.0..LARGEST_WHOLE).contains(&x) => visitor.visit_u64(x as u64),
                _ => Err(Fault::new("", n, "a whole number, 0 or more")),
            },
            Json::Number(n) if n.as_u64().is_none() => Err(Fault::new("", n, "a whole number, 0 or more")),
            _ => de::Deserializer::deserialize_any(self, visitor),
        }
    }
}

impl<'a> de::Deserializer<'a> for Decoder<'a> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Null => visitor.visit_unit(),
            Json::Bool(b) => visitor.visit_bool(*b),
            Json::Number(n) => match (n.as_u64(), n.as_i64(), n.as_f64()) {
                (Some(n), _, _) => visitor.visit_u64(n),
                (_, Some(n), _) => visitor.visit_i64(n),
                (_, _, x) => visitor.visit_f64(x.unwrap_or(f64::NAN)),
            },
            Json::String(s) => visitor.visit_borrowed_str(s),
            Json::Array(items) => visitor.visit_seq(Items { items, next: 0 }),
            Json::Object(entries) => {
                visitor.visit_map(Entries { entries, read: self.read, state: self.state, value: None })
            }
        }
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_u64<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.whole(visitor)
    }

    fn deserialize_tuple<V: Visitor<'a>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Array(items) if items.len() != length => {
                Err(Fault::new("", self.value.brief(), format!("a list of {length} numbers")))
            }
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_struct<V: Visitor<'a>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            // A list in the order of the keys is not what a scene means.
            Json::Array(_) => Err(Fault::new("", "a list", "an object")),
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'a>>(self, name: &'static str, visitor: V) -> Result<V::Value, Fault> {
        let Some([k, states]) = self.state.filter(|_| name == ENTRY) else {
            return visitor.visit_newtype_struct(self);
        };
        match self.value {
            Json::Array(all) if all.len() == states => visitor.visit_newtype_struct(Self::from(&all[k])),
            other => {
                let allowed = format!("a list of {states}, one entry a state of loading");
                Err(Fault::new("", other.brief(), allowed))
            }
        }
    }

    fn deserialize_ignored_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_unit()
    }

    fn deserialize_enum<V: Visitor<'a>>(
        self,
        _: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            Json::String(word) => visitor.visit_enum(Word(word)),
            Json::Object(entries) if entries.len() == 1 => {
                visitor.visit_enum(Variant { word: &entries[0].0, value: &entries[0].1 })
            }
            other => {
                let forms: Vec<String> = known.iter().map(|form| words::shown(form)).collect();
                Err(Fault::new("", other.brief(), format!("one of: {}", forms.join(", "))))
            }
        }
    }

    serde::forward_to_deserialize_any! {
        <W: Visitor<'a>>
        bool i8 i16 i32 i64 i128 u8 u16 u32 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple_struct map identifier
    }
}

struct Items<'a> {
    items: &'a [Json],
    next: usize,
}

impl<'a> de::SeqAccess<'a> for Items<'a> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some(item) = self.items.get(self.next) else { return Ok(None) };
        let k = self.next;
        self.next += 1;
        seed.deserialize(Decoder::from(item)).map(Some).map_err(|fault| fault.within(&format!("[{k}]")))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len() - self.next)
    }
}

struct Entries<'a> {
    entries: &'a [(String, Json)],
    read: &'a [&'static str],
    state: Option<[usize; 2]>,
    value: Option<(&'a str, &'a Json)>,
}

impl<'a> de::MapAccess<'a> for Entries<'a> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'a>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        while let Some(((key, value), rest)) = self.entries.split_first() {
            self.entries = rest;
            if !self.read.contains(&key.as_str()) {
                self.value = Some((key, value));
                return seed.deserialize(StrDeserializer::new(key)).map(Some);
            }
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let Some((key, value)) = self.value.take() else { return Err(de::Error::custom("a key before its value")) };
        let decoder = Decoder { state: self.state, ..Decoder::from(value) };
        seed.deserialize(decoder).map_err(|fault| fault.within(&key_in_path(key)))
    }
}

/// A word alone, one of several forms.
struct Word<'a>(&'a str);

impl<'a> de::EnumAccess<'a> for Word<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'a>>(self, seed: V) -> Result<(V::Value, Self), Fault> {
        let which = seed.deserialize(StrDeserializer::<Fault>::new(self.0))?;
        Ok((which, self))
    }
}

impl Word<'_> {
    /// A form that has numbers, without them.
    fn alone(&self) -> Fault {
        let allowed = format!("the word with its numbers, in braces: {}", words::shown(self.0));
        Fault::new("", format!("the word {} alone", quoted(self.0)), allowed)
    }
}

impl<'a> VariantAccess<'a> for Word<'a> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, _: T) -> Result<T::Value, Fault> {
        Err(self.alone())
    }

    fn tuple_variant<V: Visitor<'a>>(self, _: usize, _: V) -> Result<V::Value, Fault> {
        Err(self.alone())
    }

    fn struct_variant<V: Visitor<'a>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Fault> {
        Err(self.alone())
    }
}

/// `{word: value}`, one of several forms.
struct Variant<'a> {
    word: &'a str,
    value: &'a Json,
}

impl<'a> de::EnumAccess<'a> for Variant<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'a>>(self, seed: V) -> Result<(V::Value, Self), Fault> {
        let which = seed.deserialize(StrDeserializer::new(self.word)).map_err(|fault: Fault| InputError {
            path: key_in_path(self.word),
            given: "an unknown key".into(),
            ..fault.error
        })?;
        Ok((which, self))
    }
}

impl<'a> VariantAccess<'a> for Variant<'a> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        let allowed = format!("the word {} alone, without an object around it", quoted(self.word));
        Err(Fault::new(key_in_path(self.word), self.value.brief(), allowed))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, Fault> {
        seed.deserialize(Decoder::from(self.value)).map_err(|fault| fault.within(&key_in_path(self.word)))
    }

    fn tuple_variant<V: Visitor<'a>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        de::Deserializer::deserialize_tuple(Decoder::from(self.value), length, visitor)
            .map_err(|fault| fault.within(&key_in_path(self.word)))
    }

    fn struct_variant<V: Visitor<'a>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Fault> {
        de::Deserializer::deserialize_any(Decoder::from(self.value), visitor)
            .map_err(|fault| fault.within(&key_in_path(self.word)))
    }
}
