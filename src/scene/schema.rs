//! The JSON Schema of a scene, made from the structures that read it.

use schemars::Schema;
use serde_json::{Map, Value, json};

use super::SceneForm;

/// The JSON Schema (draft 2020-12) of a scene file.
#[must_use]
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(SceneForm);
    schema.insert("title".into(), "A scene of contact-patch".into());
    // Which of the two says E* is not said by the fields alone.
    schema.insert("oneOf".into(), json!([{"required": ["bodies"]}, {"required": ["effective_modulus"]}]));
    schema.to_value()
}

/// Adds `at` and `rotate`, which every kind of gap takes, to each kind.
pub(super) fn with_place(schema: &mut Schema) {
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
