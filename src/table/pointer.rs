//! A place in a document: JSON pointers (RFC 6901) into a template.

use crate::error::InputError;
use crate::scene::{Json, Parts};

/// A place that a column fills.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pointer {
    /// As it was written.
    text: String,
    steps: Vec<String>,
}

impl Pointer {
    /// Reads a pointer: `/loading/depth`, `/gap/radii/0`; `~1` stands for `/` and `~0` for `~` in a key.
    ///
    /// # Errors
    /// When it does not begin with a `/`.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let allowed = "a JSON pointer into the template, such as /loading/depth";
        let Some(rest) = text.strip_prefix('/').filter(|rest| !rest.is_empty()) else {
            return Err(InputError::new("column", super::quoted(text), allowed));
        };
        let steps = rest.split('/').map(|step| step.replace("~1", "/").replace("~0", "~")).collect();
        Ok(Self { text: text.to_owned(), steps })
    }

    /// The part of a scene that it changes.
    pub fn part(&self) -> Parts {
        match self.steps[0].as_str() {
            "gap" => Parts { gap: true, ..Parts::default() },
            "loading" => Parts { loading: true, ..Parts::default() },
            _ => Parts { others: true, ..Parts::default() },
        }
    }

    /// The same place as paths in errors say it: `gap.radii[0]`.
    pub fn path(&self, document: &Json) -> String {
        let (mut path, mut at) = (String::new(), Some(document));
        for step in &self.steps {
            match at {
                Some(Json::Array(items)) => {
                    path.push_str(&format!("[{step}]"));
                    at = step.parse().ok().and_then(|k: usize| items.get(k));
                }
                _ => {
                    if !path.is_empty() {
                        path.push('.');
                    }
                    path.push_str(&crate::scene::key_in_path(step));
                    at = at.and_then(|value| value.get(step));
                }
            }
        }
        path
    }

    /// The value at this place of the document, for writing; a last key that is not there yet is put there.
    ///
    /// # Errors
    /// Names the pointer when the way to it is not there.
    pub fn place<'a>(&self, document: &'a mut Json) -> Result<&'a mut Json, InputError> {
        let mut at = document;
        for (k, step) in self.steps.iter().enumerate() {
            let missing = |allowed: String| InputError::new("column", super::quoted(&self.text), allowed);
            let way = format!("/{}", self.steps[..k].join("/"));
            at = match at {
                Json::Object(entries) => {
                    let found = entries.iter().position(|(key, _)| key == step);
                    let last = k + 1 == self.steps.len();
                    if found.is_none() && last {
                        entries.push((step.clone(), Json::Null));
                    }
                    let found = found.or_else(|| last.then(|| entries.len() - 1));
                    let keys = || entries.iter().map(|(key, _)| key.as_str()).collect::<Vec<_>>().join(", ");
                    match found {
                        Some(found) => &mut entries[found].1,
                        None => return Err(missing(format!("a place in the template; {way} has: {}", keys()))),
                    }
                }
                Json::Array(items) => {
                    let length = items.len();
                    let plain = step == "0" || !step.starts_with(['0', '+']);
                    match step.parse().ok().filter(|_| plain).and_then(|k: usize| items.get_mut(k)) {
                        Some(item) => item,
                        None => return Err(missing(format!("a place in the template; {way} is a list of {length}"))),
                    }
                }
                other => return Err(missing(format!("a place in the template; {way} is {}", other.brief()))),
            };
        }
        Ok(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Json {
        Json::parse(br#"{"gap": {"radii": [1, 2], "a/b": 3}, "loading": {}}"#).unwrap()
    }

    #[test]
    fn places_are_found_and_last_keys_made() {
        for (pointer, path) in
            [("/gap/radii/1", "gap.radii[1]"), ("/gap/a~1b", "gap.\"a/b\""), ("/loading/depth", "loading.depth")]
        {
            let mut whole = document();
            let pointer = Pointer::parse(pointer).unwrap();
            assert_eq!(pointer.path(&whole), path);
            *pointer.place(&mut whole).unwrap() = Json::Bool(true);
            assert_eq!(*pointer.place(&mut whole).unwrap(), Json::Bool(true));
            assert_ne!(whole, document());
        }
    }

    #[test]
    fn what_leads_nowhere_is_refused() {
        for pointer in ["depth", "", "/"] {
            assert_eq!(Pointer::parse(pointer).unwrap_err().path, "column");
        }
        for pointer in ["/gap/radii/2", "/gap/radii/01", "/gap/kind/x", "/gap/a~1b/c", "/solve/cells"] {
            let refused = Pointer::parse(pointer).unwrap().place(&mut document()).unwrap_err();
            assert!(refused.given.contains(pointer) && refused.allowed.contains("template"), "{refused}");
        }
    }
}
