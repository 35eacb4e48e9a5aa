//! Numbers as `GeoJSON` writes them.

use serde::{Serialize, Serializer};

/// A number that is written without a point where it has no fraction; both zeros are 0.
#[derive(Clone, Copy)]
pub(super) struct Plain(pub f64);

impl Serialize for Plain {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let number = self.0;
        if number.fract() == 0.0 && number.abs() < 9_007_199_254_740_992.0 { serializer.serialize_i64(number as i64) } else { serializer.serialize_f64(number) }
    }
}
