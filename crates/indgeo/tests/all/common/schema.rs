//! Checks JSON against the part of JSON Schema that the published schemas use.

#![allow(clippy::panic, reason = "a test may panic")]

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The published schema of the report of a command.
pub(crate) fn of(command: &str) -> Value {
    let path = folder().join(format!("{command}.schema.json"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Where the schemas are.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema")
}

/// Everything that is wrong with `value`, each with its path. Keywords that are not known here are wrong too.
pub(crate) fn violations(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "$", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, found: &mut Vec<String>) {
    let mut wrong = |what: String| found.push(format!("{at}: {what}"));
    let number = |keyword: &Value| keyword.as_f64().unwrap();
    let mut inner: Vec<(Value, Value, String)> = Vec::new();
    for (keyword, expected) in schema.as_object().unwrap() {
        match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" => {}
            "$ref" => {
                let target = root.pointer(expected.as_str().unwrap().strip_prefix('#').unwrap());
                inner.push((target.unwrap().clone(), value.clone(), at.to_owned()));
            }
            "const" if expected != value => wrong(format!("{value} is not {expected}")),
            "enum" if !expected.as_array().unwrap().contains(value) => {
                wrong(format!("{value} is none of {expected}"));
            }
            "type" if !is_of(expected, value) => wrong(format!("{value} is no {expected}")),
            "minimum" if value.as_f64().is_some_and(|v| v < number(expected)) => {
                wrong(format!("{value} is too small"));
            }
            "maximum" if value.as_f64().is_some_and(|v| v > number(expected)) => {
                wrong(format!("{value} is too large"));
            }
            "minItems" if value.as_array().is_some_and(|v| (v.len() as f64) < number(expected)) => {
                wrong(format!("fewer than {expected} items"));
            }
            "maxItems" if value.as_array().is_some_and(|v| v.len() as f64 > number(expected)) => {
                wrong(format!("more than {expected} items"));
            }
            "const" | "enum" | "type" | "minimum" | "maximum" | "minItems" | "maxItems" => {}
            "items" => {
                for (place, item) in value.as_array().into_iter().flatten().enumerate() {
                    inner.push((expected.clone(), item.clone(), format!("{at}[{place}]")));
                }
            }
            "required" => {
                for name in expected.as_array().unwrap() {
                    if value.get(name.as_str().unwrap()).is_none() {
                        wrong(format!("{name} is missing"));
                    }
                }
            }
            "properties" => {
                for (name, schema) in expected.as_object().unwrap() {
                    if let Some(member) = value.get(name) {
                        inner.push((schema.clone(), member.clone(), format!("{at}.{name}")));
                    }
                }
            }
            "additionalProperties" => {
                let known = schema.get("properties");
                for (name, member) in value.as_object().into_iter().flatten() {
                    if known.and_then(|known| known.get(name)).is_some() {
                    } else if expected == false {
                        wrong(format!("`{name}` is not in the schema"));
                    } else {
                        inner.push((expected.clone(), member.clone(), format!("{at}.{name}")));
                    }
                }
            }
            "allOf" => {
                inner.extend(
                    expected.as_array().unwrap().iter().map(|s| (s.clone(), value.clone(), at.to_owned())),
                );
            }
            "anyOf" => {
                let fits = |schema: &Value| {
                    let mut found = Vec::new();
                    check(root, schema, value, at, &mut found);
                    found.is_empty()
                };
                if !expected.as_array().unwrap().iter().any(fits) {
                    wrong(format!("{value} fits none of the alternatives"));
                }
            }
            other => wrong(format!("the schema uses the keyword `{other}`")),
        }
    }
    for (schema, value, at) in inner {
        check(root, &schema, &value, &at, found);
    }
}

fn is_of(kind: &Value, value: &Value) -> bool {
    match kind {
        Value::Array(kinds) => kinds.iter().any(|kind| is_of(kind, value)),
        _ => match kind.as_str().unwrap() {
            "null" => value.is_null(),
            "boolean" => value.is_boolean(),
            "string" => value.is_string(),
            "number" => value.is_number(),
            "integer" => value.is_u64() || value.is_i64(),
            "array" => value.is_array(),
            "object" => value.is_object(),
            other => panic!("unknown type {other}"),
        },
    }
}
