//! Names of contents: what puts the terms of sums in an order that nothing else can change.

use super::{Attribute, AttributeSet, ContentHash, Feature, Role, Side, Value, Weight};
use crate::geometry::{Along, Curve, Elevation, Shape};
use sha2::{Digest, Sha256};

/// Bytes in which each number and text has one form.
#[derive(Default)]
struct Bytes(Sha256);

impl Bytes {
    fn tag(&mut self, tag: u8) {
        self.0.update([tag]);
    }

    /// Both zeros are one number.
    fn number(&mut self, number: f64) {
        self.0.update((number + 0.0).to_bits().to_le_bytes());
    }

    fn whole(&mut self, number: u64) {
        self.0.update(number.to_le_bytes());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        self.whole(numbers.len() as u64);
        for &number in numbers {
            self.number(number);
        }
    }

    fn text(&mut self, text: &str) {
        self.whole(text.len() as u64);
        self.0.update(text);
    }

    fn optional(&mut self, number: Option<f64>) {
        self.tag(number.is_some().into());
        self.number(number.unwrap_or(0.0));
    }

    fn finish(self) -> ContentHash {
        let digest = self.0.finalize();
        ContentHash(core::array::from_fn(|i| digest[i]))
    }
}

/// Of one attribute.
pub(super) fn of_attribute(attribute: &Attribute) -> ContentHash {
    let mut bytes = Bytes::default();
    let Attribute { name, value, weight, range, side, fade, priority, role } = attribute;
    bytes.text(name);
    write_value(&mut bytes, value);
    match weight {
        Weight::Linear => bytes.tag(0),
        Weight::Sharp { width, nearest } => {
            bytes.tag(1);
            bytes.numbers(&[*width, *nearest]);
        }
        Weight::Smooth { width } => {
            bytes.tag(2);
            bytes.number(*width);
        }
        Weight::Custom(expression) => {
            bytes.tag(3);
            bytes.text(&expression.canonical());
        }
    }
    bytes.number(*range);
    bytes.tag(match side {
        Side::Inside => 0,
        Side::Outside => 1,
        Side::Edge => 2,
    });
    bytes.optional(*fade);
    bytes.tag(*priority);
    bytes.optional(if let Role::Channel { half_width } = role { Some(*half_width) } else { None });
    bytes.finish()
}

fn write_value(bytes: &mut Bytes, value: &Value) {
    match value {
        Value::Shape => bytes.tag(0),
        Value::Number(number) => {
            bytes.tag(1);
            bytes.number(*number);
        }
        Value::Vector(numbers) => {
            bytes.tag(2);
            bytes.numbers(numbers);
        }
        Value::Name(name) => {
            bytes.tag(3);
            bytes.text(name);
        }
        Value::Profile(pairs) => {
            bytes.tag(4);
            bytes.numbers(pairs.as_flattened());
        }
        Value::Expression(expression) => {
            bytes.tag(5);
            bytes.text(&expression.canonical());
        }
        Value::Terrain(terrain) => {
            bytes.tag(6);
            bytes.text(&terrain.programme.to_string());
            bytes.whole(terrain.frame.seed);
            bytes.numbers(&[terrain.frame.scale, terrain.frame.origin[0], terrain.frame.origin[1], terrain.amplitude, terrain.datum]);
            bytes.tag(terrain.over_shape.into());
        }
    }
}

/// Of attributes in their order.
pub(super) fn of_set(attributes: &[Attribute]) -> ContentHash {
    let mut bytes = Bytes::default();
    for attribute in attributes {
        bytes.0.update(of_attribute(attribute).0);
    }
    bytes.finish()
}

/// Of features in their order.
pub(super) fn of_features<'a>(features: impl Iterator<Item = &'a Feature>) -> ContentHash {
    let mut bytes = Bytes::default();
    for feature in features {
        bytes.0.update(feature.hash().0);
    }
    bytes.finish()
}

/// Of a feature.
pub(super) fn of_feature(shape: &Shape, attributes: &AttributeSet) -> ContentHash {
    let mut bytes = Bytes::default();
    bytes.0.update(attributes.hash().0);
    match shape {
        Shape::Point { at, elevation } => {
            bytes.tag(0);
            bytes.numbers(at);
            bytes.optional(*elevation);
        }
        Shape::Circle { centre, radius, elevation } => {
            bytes.tag(1);
            bytes.numbers(&[centre[0], centre[1], *radius]);
            bytes.optional(*elevation);
        }
        Shape::Line(curve) => {
            bytes.tag(2);
            write_curve(&mut bytes, curve);
        }
        Shape::Polygon(curve) => {
            bytes.tag(3);
            write_curve(&mut bytes, curve);
        }
    }
    bytes.finish()
}

fn write_curve(bytes: &mut Bytes, curve: &Curve) {
    for part in curve.parts() {
        bytes.numbers(part.as_flattened());
    }
    match curve.elevation() {
        Elevation::Absent => bytes.tag(0),
        Elevation::Constant(elevation) => {
            bytes.tag(1);
            bytes.number(*elevation);
        }
        Elevation::Vertices(elevations) => {
            bytes.tag(2);
            bytes.numbers(elevations);
        }
    }
    bytes.tag((curve.way() == Along::Arc).into());
    bytes.whole(curve.stride() as u64);
    bytes.tag(curve.detail().is_some().into());
    if let Some(detail) = curve.detail() {
        bytes.tag(detail.iterations());
        bytes.number(detail.displacement());
        bytes.whole(detail.seed());
    }
}
