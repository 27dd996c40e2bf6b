//! From a JSON value to a typed one, with errors that say where, what was given and what is allowed.
//!
//! A [`serde::Deserializer`] over [`Json`] whose error is an [`InputError`]: the structures of a scene are declared
//! once, and that declaration is also what the JSON Schema is made from.
//!
//! That of [`serde_json::Value`] would not do: its errors are sentences in the words of Rust, without the value that was given, and
//! serde reads an object by its key `kind` through a buffer in which paths are lost.

use std::marker::PhantomData;

use serde::de::value::StrDeserializer;
use serde::de::{self, Deserialize, DeserializeSeed, VariantAccess, Visitor};

use super::document::{Json, ROOT, key_in_path, quoted};
use super::fault::{Fault, unknown};
use super::words;
use crate::error::InputError;

/// Reads a `T`; `path` leads to `value` in the document.
pub(super) fn decode<'a, T: Deserialize<'a>>(value: &'a Json, path: &str) -> Result<T, InputError> {
    decoded(Decoder::from(value), path)
}

/// Reads an enum of one structure a kind from an object, whose key `tag` names the kind; the keys in `read` are passed over.
pub(super) fn decode_kind<'a, T: Deserialize<'a>>(
    value: &'a Json,
    path: &str,
    tag: &'static str,
    read: &'a [&'static str],
) -> Result<T, InputError> {
    decoded(Decoder { value, read, tag: Some(tag), state: None }, path)
}

/// Reads a `T` from the result of one state of loading: what is a list with an entry a state is read as that entry, which of how
/// many `state` says.
pub(crate) fn decode_state<'a, T: Deserialize<'a>>(
    result: &'a Json,
    state: Option<[usize; 2]>,
) -> Result<T, InputError> {
    decoded(Decoder { state, ..Decoder::from(result) }, ROOT)
}

fn decoded<'a, T: Deserialize<'a>>(from: Decoder<'a>, path: &str) -> Result<T, InputError> {
    read(PhantomData, from, "").map_err(|fault| {
        let error = match fault.key {
            // The keys that were read already are known too.
            Some((key, known)) => {
                let known: Vec<&str> = from.read.iter().chain(known).copied().collect();
                unknown(key_in_path(&key), fault.error.given, &key, &known)
            }
            None => fault.error,
        };
        match path {
            ROOT if error.path.is_empty() => InputError { path: ROOT.into(), ..error },
            ROOT => error,
            path => error.within(path),
        }
    })
}

/// Reads what `seed` asks for; an error is within `step`, and shows the value where it shows nothing yet.
fn read<'a, S: DeserializeSeed<'a>>(seed: S, from: Decoder<'a>, step: &str) -> Result<S::Value, Fault> {
    seed.deserialize(from).map_err(|mut fault| {
        if fault.error.given.is_empty() {
            fault.error.given = from.value.brief();
        }
        if step.is_empty() { fault } else { fault.error.within(step).into() }
    })
}

#[derive(Clone, Copy)]
struct Decoder<'a> {
    value: &'a Json,
    /// Keys of this object that were read already.
    read: &'a [&'static str],
    /// The key of this object that names the variant of an enum.
    tag: Option<&'static str>,
    /// Which of how many entries of a list is meant.
    state: Option<[usize; 2]>,
}

/// The name of a type that stands for one entry of a list, see [`decode_state`].
const ENTRY: &str = "Entry";

impl<'a> From<&'a Json> for Decoder<'a> {
    fn from(value: &'a Json) -> Self {
        Self { value, read: &[], tag: None, state: None }
    }
}

/// Whole numbers that an f64 holds exactly.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

impl<'a> de::Deserializer<'a> for Decoder<'a> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Null => visitor.visit_unit(),
            Json::Bool(b) => visitor.visit_bool(*b),
            Json::Number(n) => match (n.as_u64(), n.as_i64(), n.as_f64()) {
                (Some(n), _, _) => visitor.visit_u64(n),
                (_, Some(n), _) => visitor.visit_i64(n),
                // A whole number may be written as 1e3 or 3.0.
                (_, _, Some(x)) if x.fract() == 0.0 && x.is_sign_positive() && x < LARGEST_WHOLE => {
                    visitor.visit_u64(x as u64)
                }
                (_, _, x) => visitor.visit_f64(x.unwrap_or(f64::NAN)),
            },
            Json::String(s) => visitor.visit_borrowed_str(s),
            Json::Array(items) => visitor.visit_seq(Items { items, next: 0 }),
            Json::Object(entries) => visitor.visit_map(Entries { entries, outer: self, value: None }),
        }
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Json::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
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
        if let Some(tag) = self.tag {
            return visitor.visit_enum(self.kind(tag, known)?);
        }
        match self.value {
            Json::String(word) => visitor.visit_enum(Variant::Word(word)),
            Json::Object(entries) if entries.len() == 1 => {
                visitor.visit_enum(Variant::Key(&entries[0].0, Self::from(&entries[0].1)))
            }
            other => {
                let forms: Vec<String> = known.iter().map(|form| words::shown(form)).collect();
                Err(Fault::new("", other.brief(), format!("one of: {}", forms.join(", "))))
            }
        }
    }

    serde::forward_to_deserialize_any! {
        <W: Visitor<'a>>
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple_struct map identifier
    }
}

impl<'a> Decoder<'a> {
    /// The variant that the key `tag` of this object names.
    fn kind(self, tag: &str, known: &[&str]) -> Result<Variant<'a>, Fault> {
        let Json::Object(_) = self.value else {
            return Err(Fault::new("", self.value.brief(), format!("an object with the key {tag}")));
        };
        let given = match self.value.get(tag) {
            Some(Json::String(word)) => return Ok(Variant::Tagged(word, self)),
            Some(other) => other.brief(),
            None if self.value.get("type").is_some() => "nothing (\"type\" stands in its place)".into(),
            None => "nothing".into(),
        };
        Err(Fault::new(tag, given, format!("one of: {}", known.join(", "))))
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
        let step = format!("[{}]", self.next);
        self.next += 1;
        read(seed, Decoder::from(item), &step).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len() - self.next)
    }
}

struct Entries<'a> {
    entries: &'a [(String, Json)],
    /// The object that they are of.
    outer: Decoder<'a>,
    value: Option<(&'a str, &'a Json)>,
}

impl<'a> de::MapAccess<'a> for Entries<'a> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'a>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        while let Some(((key, value), rest)) = self.entries.split_first() {
            self.entries = rest;
            if !self.outer.read.contains(&key.as_str()) {
                self.value = Some((key, value));
                return seed.deserialize(StrDeserializer::new(key)).map(Some);
            }
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let Some((key, value)) = self.value.take() else { return Err(de::Error::custom("a key before its value")) };
        read(seed, Decoder { state: self.outer.state, ..Decoder::from(value) }, &key_in_path(key))
    }
}

/// One of several forms.
enum Variant<'a> {
    /// A word alone.
    Word(&'a str),
    /// `{word: value}`.
    Key(&'a str, Decoder<'a>),
    /// An object with the word among its keys.
    Tagged(&'a str, Decoder<'a>),
}

impl<'a> de::EnumAccess<'a> for Variant<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'a>>(self, seed: V) -> Result<(V::Value, Self), Fault> {
        let (Self::Word(word) | Self::Key(word, _) | Self::Tagged(word, _)) = self;
        let which = seed.deserialize(StrDeserializer::new(word)).map_err(|fault: Fault| match self {
            Self::Word(_) => fault,
            Self::Key(..) => Fault::new(key_in_path(word), "an unknown key", fault.error.allowed),
            Self::Tagged(_, Decoder { tag, .. }) => fault.error.within(tag.unwrap_or_default()).into(),
        })?;
        Ok((which, self))
    }
}

impl<'a> VariantAccess<'a> for Variant<'a> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        let Self::Key(word, value) = self else { return Ok(()) };
        let allowed = format!("the word {} alone, without an object around it", quoted(word));
        Err(Fault::new(key_in_path(word), value.value.brief(), allowed))
    }

    fn newtype_variant_seed<T: DeserializeSeed<'a>>(self, seed: T) -> Result<T::Value, Fault> {
        match self {
            Self::Word(word) => {
                let allowed = format!("the word with its numbers, in braces: {}", words::shown(word));
                Err(Fault::new("", format!("the word {} alone", quoted(word)), allowed))
            }
            Self::Key(word, value) => read(seed, value, &key_in_path(word)),
            Self::Tagged(_, whole) => read(seed, whole, ""),
        }
    }

    // Forms hold one value, or none.
    fn tuple_variant<V: Visitor<'a>>(self, _: usize, _: V) -> Result<V::Value, Fault> {
        Err(de::Error::custom("another form"))
    }

    fn struct_variant<V: Visitor<'a>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Fault> {
        Err(de::Error::custom("another form"))
    }
}
