//! Coordinates of any depth, read into flat lists as they come.

use super::{number::Plain, problem::Problems};
use serde::{
    Serialize, Serializer,
    de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor},
    ser::SerializeSeq,
};
use std::{fmt, ops::Range};

/// Most vertices of one feature, and of all features that are read at a time.
pub const MOST_VERTICES: [usize; 2] = [250_000, 20_000_000];

/// Most levels of lists: those of a polygon, one for several of them, and one to tell them from deeper ones.
const DEEPEST: usize = 5;

/// The positions of a geometry.
#[derive(Debug, Default)]
pub(super) struct Coordinates {
    pub positions: Vec<[f64; 2]>,
    /// Third coordinates, of as many positions as have them.
    pub elevations: Vec<f64>,
    /// The positions of each list of positions.
    pub lists: Vec<Range<usize>>,
    /// How many lists a position stands in.
    pub depth: Option<usize>,
    /// The first vertex that has an elevation while the first has none, or the other way round.
    pub uneven: Option<usize>,
    /// Vertices, also those beyond the most that are kept.
    pub vertices: usize,
    /// Numbers of the position being read.
    numbers: Vec<f64>,
}

impl Coordinates {
    /// Where a vertex stands below `coordinates`.
    pub(super) fn pointer(&self, vertex: usize) -> String {
        let list = self.lists.iter().position(|list| list.contains(&vertex));
        match (self.depth, list) {
            (Some(0), _) => String::new(),
            (Some(2), Some(list)) => format!("/{list}/{}", vertex - self.lists[list].start),
            _ => format!("/{vertex}"),
        }
    }
}

/// Reads coordinates; what is wrong but can be passed over is added to the problems, with the vertex.
pub(super) struct CoordinatesSeed<'a> {
    pub into: &'a mut Coordinates,
    pub problems: &'a mut Problems,
    pub level: usize,
}

impl CoordinatesSeed<'_> {
    fn deeper(&mut self) -> CoordinatesSeed<'_> {
        CoordinatesSeed { into: self.into, problems: self.problems, level: self.level + 1 }
    }

    /// Something that is no number where one should be.
    fn wrong(&mut self, what: &str) {
        let vertex = self.into.vertices;
        self.problems.add("", format!("vertex {vertex}: a coordinate must be a number, got {what}"));
        self.into.numbers.push(f64::NAN);
    }

    /// Ends a list that holds numbers.
    fn end_position(&mut self) {
        let into = &mut *self.into;
        let vertex = into.vertices;
        into.vertices += 1;
        let depth = self.level;
        if *into.depth.get_or_insert(depth) != depth {
            self.problems.add("", format!("vertex {vertex}: stands in {depth} lists, the first vertex in {}", into.depth.unwrap_or_default()));
        }
        if vertex >= MOST_VERTICES[0] {
            if vertex == MOST_VERTICES[0] {
                self.problems.add("", format!("vertex {vertex}: is the first beyond the {vertex} vertices that a feature may have: part it into several"));
            }
            return;
        }
        match into.numbers[..] {
            [x, y] => into.positions.push([x, y]),
            [x, y, elevation] => {
                into.positions.push([x, y]);
                into.elevations.push(elevation);
            }
            _ => {
                let got = into.numbers.len();
                self.problems.add("", format!("vertex {vertex}: a position is [x, y] or [x, y, elevation] in metres, got {got} numbers"));
                into.positions.push([f64::NAN; 2]);
            }
        }
        if into.uneven.is_none() && !into.elevations.is_empty() && into.elevations.len() != into.positions.len() {
            into.uneven = Some(vertex);
        }
    }
}

impl<'de> DeserializeSeed<'de> for CoordinatesSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for CoordinatesSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("coordinates")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        if self.level > DEEPEST {
            self.problems.add("", format!("vertex {}: the coordinates are nested too deeply", self.into.vertices));
            while list.next_element::<IgnoredAny>()?.is_some() {}
            return Ok(());
        }
        let start = self.into.positions.len();
        self.into.numbers.clear();
        while list.next_element_seed(self.deeper())?.is_some() {}
        if !self.into.numbers.is_empty() {
            self.end_position();
            self.into.numbers.clear();
        } else if self.into.depth.is_none_or(|depth| depth == self.level + 1) {
            self.into.lists.push(start..self.into.positions.len());
        }
        Ok(())
    }

    fn visit_f64<E>(self, number: f64) -> Result<(), E> {
        // A position has three numbers at most; one more tells that there are too many.
        if self.into.numbers.len() < 4 {
            self.into.numbers.push(number);
        }
        Ok(())
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<(), E> {
        self.visit_f64(number as f64)
    }

    fn visit_unit<E>(mut self) -> Result<(), E> {
        self.wrong("null");
        Ok(())
    }

    fn visit_bool<E>(mut self, value: bool) -> Result<(), E> {
        self.wrong(&value.to_string());
        Ok(())
    }

    fn visit_str<E>(mut self, text: &str) -> Result<(), E> {
        self.wrong(&format!("{:?}", text.chars().take(64).collect::<String>()));
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        self.wrong("an object");
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(())
    }
}

/// A position as it is written.
pub(super) struct Position(pub [f64; 2], pub Option<f64>);

impl Serialize for Position {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self([x, y], elevation) = self;
        let mut list = serializer.serialize_seq(None)?;
        for number in [*x, *y].into_iter().chain(*elevation) {
            list.serialize_element(&Plain(number))?;
        }
        list.end()
    }
}
