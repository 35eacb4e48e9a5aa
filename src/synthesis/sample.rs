//! A sample as it comes from a file, and what can be wrong with one.

use super::grid::SampleGrid;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Where in a file something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// The whole.
    File,
    /// A byte, from 0.
    Byte(usize),
    /// A line, from 1.
    Line(usize),
    /// A tag of a TIFF.
    Tag(u16),
    /// A record of a USGS DEM, from 1.
    Record(usize),
    /// A cell, from 0 at the north-western corner.
    Cell {
        /// From west to east.
        column: usize,
        /// From north to south.
        row: usize,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => f.write_str("file"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
            Place::Line(line) => write!(f, "line {line}"),
            Place::Tag(tag) => write!(f, "tag {tag}"),
            Place::Record(record) => write!(f, "record {record}"),
            Place::Cell { column, row } => write!(f, "column {column}, row {row}"),
        }
    }
}

/// Something wrong with a file of elevations.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize)]
#[error("{name}: {place}: {detail}")]
pub struct SampleError {
    /// What the file is called.
    pub name: String,
    /// Where.
    pub place: Place,
    /// What is wrong and what would be right.
    pub detail: String,
}

impl SampleError {
    pub(super) fn new(name: &str, place: Place, detail: impl Into<String>) -> Self {
        Self { name: name.to_owned(), place, detail: detail.into() }
    }
}

/// Formats of elevations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// TIFF with its place on the ground (OGC 19-008r4).
    Geotiff,
    /// A tile of the Shuttle Radar Topography Mission: 16-bit big-endian metres, named by its south-western corner.
    Hgt,
    /// ASCII DEM of the United States Geological Survey.
    UsgsDem,
    /// ESRI ASCII grid.
    AsciiGrid,
    /// PNG with greys of 16 bits.
    Png16,
    /// Numbers row by row and nothing else.
    Raw,
}

/// What numbers of heights are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// 1 m.
    Metres,
    /// 0.1 m.
    Decimetres,
    /// 0.01 m.
    Centimetres,
    /// 0.3048 m.
    Feet,
    /// 1200 / 3937 m.
    UsSurveyFeet,
}

impl Unit {
    /// Metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        match self {
            Unit::Metres => 1.0,
            Unit::Decimetres => 0.1,
            Unit::Centimetres => 0.01,
            Unit::Feet => 0.3048,
            Unit::UsSurveyFeet => 1200.0 / 3937.0,
        }
    }
}

/// Numbers of raw files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Number {
    /// 16 bits, little-endian.
    U16,
    /// 16 bits, big-endian.
    U16Be,
    /// 16 bits with sign, little-endian.
    I16,
    /// 16 bits with sign, big-endian.
    I16Be,
    /// 32-bit float, little-endian.
    F32,
    /// 32-bit float, big-endian.
    F32Be,
}

impl Number {
    /// How many bytes it has.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Number::U16 | Number::U16Be | Number::I16 | Number::I16Be => 2,
            Number::F32 | Number::F32Be => 4,
        }
    }
}

/// What a format cannot say, or what somebody knows better than the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hints {
    /// By content and name without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<Format>,
    /// Metres between cells, from west to east and from north to south.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<[f64; 2]>,
    /// Of heights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// The number that stands for a void.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub void: Option<f64>,
    /// Of raw files: columns and rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[usize; 2]>,
    /// Of raw files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<Number>,
    /// Of PNG and raw files of unsigned numbers: the metres that 0 and 65535 stand for, in the place of a unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Degrees north of the middle, for spacings in degrees where the file does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latitude: Option<f64>,
}

/// A sample as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// What was recognised.
    pub format: Format,
    /// Elevations; voids are kept.
    pub grid: SampleGrid,
    /// What was taken for granted, in sentences for people.
    pub notes: Vec<String>,
}
