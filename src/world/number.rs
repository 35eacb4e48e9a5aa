//! Numbers as documents write them.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The greatest seed: 2^53 - 1, what every JSON reader keeps exactly.
pub(super) const MAX_SEED: u64 = (1 << 53) - 1;

/// A whole number, also where it is written as 7.0 or 1e3.
pub(super) fn whole_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    optional_whole_number(deserializer)?.ok_or_else(expected)
}

/// The same, or `null`, which counts as not there.
pub(super) fn optional_whole_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    let Ok(number) = Option::<serde_json::Number>::deserialize(deserializer) else { return Err(expected()) };
    let Some(number) = number else { return Ok(None) };
    let float = number.as_f64().filter(|f| f.fract() == 0.0 && (0.0..18_446_744_073_709_551_616.0).contains(f));
    number.as_u64().or(float.map(|f| f as u64)).map(Some).ok_or_else(expected)
}

fn expected<E: serde::de::Error>() -> E {
    E::custom(format!("expected a whole number 0 … {MAX_SEED}"))
}

/// Numbers without a fraction are written without a point.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands fields over by reference")]
pub(super) fn whole<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if number.fract() == 0.0 && number.abs() < 9_007_199_254_740_992.0 { serializer.serialize_i64(*number as i64) } else { serializer.serialize_f64(*number) }
}

pub(super) fn whole_pair<S: Serializer>(pair: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Whole(#[serde(serialize_with = "whole")] f64);
    pair.map(Whole).serialize(serializer)
}
