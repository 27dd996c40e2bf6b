//! The JSON Schema of a scene. It is a file of the crate, so that nobody has to build what makes it; a test makes it from the structures
//! that read a scene, and holds the file against it.

/// The JSON Schema (draft 2020-12) of a scene file.
///
/// ```
/// let schema: serde_json::Value = serde_json::from_str(contact_patch::scene::schema())?;
/// assert_eq!(schema["title"], "A scene of contact-patch");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[must_use]
pub fn schema() -> &'static str {
    include_str!("../../data/scene.schema.json")
}

#[cfg(test)]
pub(super) use made::with_place;

#[cfg(test)]
mod made {
    use std::path::Path;

    use schemars::Schema;
    use serde_json::{Map, Value, json};

    use crate::scene::SceneForm;

    /// The schema of the structures.
    fn schema() -> Value {
        let mut schema = schemars::schema_for!(SceneForm);
        schema.insert("title".into(), "A scene of contact-patch".into());
        // Which of the two says E* is not said by the fields alone.
        schema.insert("oneOf".into(), json!([{"required": ["bodies"]}, {"required": ["effective_modulus"]}]));
        schema.to_value()
    }

    /// Adds `at` and `rotate`, which every kind of gap takes, to each kind.
    pub fn with_place(schema: &mut Schema) {
        let Some(Value::Array(kinds)) = schema.get_mut("oneOf") else { return };
        for kind in kinds {
            if let Some(Value::Object(keys)) = kind.get_mut("properties") {
                add_place(keys);
            }
        }
    }

    fn add_place(keys: &mut Map<String, Value>) {
        let number = json!({"type": "number"});
        keys.insert(
            "at".into(),
            json!({"description": "Where the origin of this gap stands, [x, y].", "type": ["array", "null"],
                   "items": number, "minItems": 2, "maxItems": 2}),
        );
        keys.insert(
            "rotate".into(),
            json!({"description": "Degrees, counter-clockwise, about `at`.", "type": ["number", "null"]}),
        );
    }

    /// Writes the file: `cargo test --release --lib -- --ignored the_file_is_written_anew`.
    #[test]
    #[ignore = "changes a file of the project"]
    fn the_file_is_written_anew() {
        let text = serde_json::to_string_pretty(&schema()).unwrap() + "\n";
        std::fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scene.schema.json"), text).unwrap();
    }

    #[test]
    fn the_file_is_what_the_structures_say() {
        let file: Value = serde_json::from_str(super::schema()).unwrap();
        assert!(file == schema(), "write it anew: cargo test --release --lib -- --ignored the_file_is_written_anew");
    }
}
