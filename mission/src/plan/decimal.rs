//! Single-precision parameters as the shortest decimals that mean the same, and back.

use serde_json::Value;

use super::error::Fault;

/// The double whose shortest decimal is that of `value`: 0.1 and not 0.10000000149.
pub(super) fn widened(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

/// As JSON: infinities, which it does not know, as text; NaN as null.
pub(super) fn to_json(value: f32) -> Value {
    if value.is_finite() {
        Value::from(widened(value))
    } else if value.is_nan() {
        Value::Null
    } else {
        Value::from(value.to_string())
    }
}

/// A parameter out of JSON.
pub(super) fn from_json(value: &Value) -> Result<f32, Fault> {
    let narrow = match value {
        Value::Null => Some(f32::NAN),
        Value::Number(number) => number.as_f64().map(|value| value as f32).filter(|value| value.is_finite()),
        Value::String(text) if text == "inf" => Some(f32::INFINITY),
        Value::String(text) if text == "-inf" => Some(f32::NEG_INFINITY),
        _ => None,
    };
    narrow.ok_or_else(|| Fault::Number {
        column: "a parameter",
        found: super::excerpt(&value.to_string()),
        expected: "a number of the size MAVLink carries, or null",
    })
}
