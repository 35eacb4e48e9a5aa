//! Features that are read and written together.

use super::{
    coordinates::MOST_VERTICES,
    drawn::Drawn,
    lines::{self, Rest},
    problem::{Problem, Problems, ReadError},
    read::{Form, Reader, TopSeed},
    sets::Sets,
};
use crate::layout::{ContentHash, Feature};
use rayon::prelude::*;
use serde::{Serialize, Serializer, de::DeserializeSeed, ser::SerializeMap};
use serde_json::Deserializer;
use std::{
    borrow::Cow,
    collections::BTreeMap,
    io::{BufRead, BufReader, Read},
    sync::Arc,
};

/// Most features that are read at a time, and that they may become by their detail.
pub const MOST_FEATURES: usize = 2_000_000;

/// Fewer features than these are not worth other threads.
const FEW: usize = 1024;

/// Features that are made at a time before they are taken: what one makes may be large.
const AT_ONCE: usize = 4096;

/// Features with the sets of attributes that they share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collection {
    /// Sets of attributes by name.
    pub sets: Sets,
    /// The features, in the order they were drawn in.
    pub features: Vec<Drawn>,
    form: Option<Form>,
}

impl Collection {
    /// Features with sets of attributes.
    #[must_use]
    pub fn new(sets: Sets, features: Vec<Drawn>) -> Self {
        Self { sets, features, form: Some(Form::Collection) }
    }

    /// Reads a Feature, a `FeatureCollection`, or one Feature a line (newline-delimited, or RFC 8142). Attributes are looked up later, by [`Collection::features`].
    ///
    /// # Errors
    /// If it cannot be read or is not JSON, or with every problem found.
    pub fn read(source: impl Read) -> Result<Self, ReadError> {
        let (mut reader, mut source) = (Reader::default(), Plain(source));
        let Rest { bytes, ended, lines } = lines::read(&mut reader, &mut source).map_err(ReadError::Io)?;
        if reader.count == 0 || !bytes.trim_ascii().is_empty() {
            // What is in memory is read faster from there.
            if ended {
                Self::read_on(&mut reader, Deserializer::from_slice(&bytes), lines)?;
            } else {
                let source = BufReader::with_capacity(1 << 16, bytes.chain(source));
                Self::read_on(&mut reader, Deserializer::from_reader(source), lines)?;
            }
        }
        let Reader { features, sets, mut problems, form, .. } = reader;
        let read = Self { sets, features, form };
        read.check_ids(&mut problems);
        problems.into_result(read)
    }

    /// Reads what follows so many lines, in order.
    fn read_on<'a>(reader: &mut Reader, mut deserializer: Deserializer<impl serde_json::de::Read<'a>>, lines: usize) -> Result<(), ReadError> {
        loop {
            if let Err(error) = TopSeed(reader).deserialize(&mut deserializer) {
                if error.is_io() {
                    return Err(ReadError::Io(error.into()));
                }
                reader.stop(&told(&error, lines));
                break;
            }
            match deserializer.end() {
                Ok(()) => break,
                Err(error) if error.is_io() => return Err(ReadError::Io(error.into())),
                Err(_) if reader.form == Some(Form::Collection) => {
                    reader.problems.add("", "something follows the FeatureCollection");
                    break;
                }
                // Another line.
                Err(_) if reader.problems.is_full() || reader.count > MOST_FEATURES => break,
                Err(_) => {}
            }
        }
        Ok(())
    }

    /// Reads features one a line; there may be none.
    pub(super) fn read_lines(source: impl Read) -> Result<Self, ReadError> {
        let mut source = BufReader::new(source);
        match source.fill_buf() {
            Ok([]) => Ok(Self::default()),
            Ok(_) => Self::read(source),
            Err(error) => Err(ReadError::Io(error)),
        }
    }

    /// Reads text.
    ///
    /// # Errors
    /// As [`Collection::read`].
    pub fn parse(json: &str) -> Result<Self, ReadError> {
        Self::read(json.as_bytes())
    }

    /// Features as they would be drawn, with names for their sets of attributes made of their content; `None` if one has its detail expanded.
    #[must_use]
    pub fn of(features: &[Feature]) -> Option<Self> {
        let (mut names, mut sets): (BTreeMap<ContentHash, Arc<str>>, Sets) = Default::default();
        let drawn = features.iter().map(|feature| {
            let set = feature.attributes();
            let name = names.entry(set.hash()).or_insert_with(|| {
                let hex: String = set.hash().0[..6].iter().map(|byte| format!("{byte:02x}")).collect();
                let name: Arc<str> = format!("set-{hex}").into();
                sets.insert(&name, Arc::clone(set));
                name
            });
            Drawn::of(feature, Some(Arc::clone(name)))
        });
        let drawn: Option<Vec<Drawn>> = drawn.collect();
        Some(Self::new(sets, drawn?))
    }

    /// The features of a layout that the drawn ones stand for. Sets that have no name here are looked up in `outer`.
    ///
    /// # Errors
    /// With every problem found: a name that no set has, an elevation that an attribute needs, detail that a shape cannot have.
    pub fn features(&self, outer: &Sets) -> Result<Vec<Feature>, ReadError> {
        let mut all = Vec::with_capacity(self.features.len());
        self.each(outer, |made| made, |made| all.extend(made))?;
        Ok(all)
    }

    /// Checks what [`Collection::features`] would make, without keeping it.
    ///
    /// # Errors
    /// As [`Collection::features`].
    pub fn check(&self, outer: &Sets) -> Result<(), ReadError> {
        self.each(outer, drop, drop)
    }

    /// Makes the features, some at a time on all threads of the present pool; `keep` makes of those of one that was drawn what `take` gets, in order.
    fn each<T: Send>(&self, outer: &Sets, keep: impl Fn(Vec<Feature>) -> T + Sync, mut take: impl FnMut(T)) -> Result<(), ReadError> {
        let (mut problems, mut count, mut vertices) = (Problems::default(), 0, 0);
        let make = |drawn: &Drawn| {
            let made = drawn.features([&self.sets, outer])?;
            let vertices = made.iter().map(|feature| feature.shape().curve().map_or(1, |curve| curve.vertices().len())).sum::<usize>();
            Ok((made.len(), vertices, keep(made)))
        };
        let mut number = 0;
        'all: for some in self.features.chunks(AT_ONCE) {
            let made: Vec<Result<_, (&'static str, String)>> = match some.len() {
                0..FEW => some.iter().map(make).collect(),
                _ => some.par_iter().map(make).collect(),
            };
            for made in made {
                match made {
                    Ok((features, corners, made)) => {
                        count += features;
                        vertices += corners;
                        if count > MOST_FEATURES || vertices > 2 * MOST_VERTICES[1] {
                            let most = 2 * MOST_VERTICES[1];
                            let detail = format!("{}: its detail makes more than {MOST_FEATURES} features or {most} vertices of all", self.label(number));
                            problems.add(self.pointer(number), detail);
                            break 'all;
                        }
                        take(made);
                    }
                    Err((place, detail)) => problems.add(format!("{}{place}", self.pointer(number)), format!("{}: {detail}", self.label(number))),
                }
                if problems.is_full() {
                    break 'all;
                }
                number += 1;
            }
        }
        problems.into_result(())
    }

    fn label(&self, number: usize) -> String {
        self.features[number].id.as_ref().map_or_else(|| format!("feature number {number}"), |id| format!("feature {:?}", id.to_string()))
    }

    /// A JSON pointer to a feature in what was read.
    #[must_use]
    pub fn pointer(&self, number: usize) -> String {
        Reader::pointer(self.form, self.features.len() == 1, number)
    }

    /// Finds ids that two features have.
    pub(super) fn check_ids(&self, problems: &mut Problems) {
        let mut ids: Vec<(Cow<str>, usize)> = self.features.iter().zip(0..).filter_map(|(drawn, i)| Some((drawn.id.as_ref()?.text(), i))).collect();
        if ids.len() < FEW {
            ids.sort_unstable();
        } else {
            ids.par_sort_unstable();
        }
        for pair in ids.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let (id, first, second) = (&pair[0].0, pair[0].1, pair[1].1);
            problems.add(format!("{}/id", self.pointer(second)), format!("feature {id:?}: feature number {first} has this id already"));
        }
    }

    /// Takes in another collection's features and sets. A set whose name stands for something else here gets a new name.
    pub fn append(&mut self, other: Self) {
        let mut names = BTreeMap::new();
        for (name, set) in other.sets.iter() {
            let mut new = name.to_owned();
            let mut number = 2;
            while self.sets.get(&new).is_some_and(|known| known.hash() != set.hash()) {
                let kept: String = name.chars().take(50).collect();
                new = format!("{kept}-{number}");
                number += 1;
            }
            if new != name {
                names.insert(name.into(), new.as_str().into());
            }
            self.sets.insert(&new, Arc::clone(set));
        }
        self.form = Some(Form::Collection);
        self.features.extend(other.features.into_iter().map(|mut drawn| {
            drawn.rename(&names);
            drawn
        }));
    }
}

impl Serialize for Collection {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("type", "FeatureCollection")?;
        if !self.sets.is_empty() {
            map.serialize_entry("attributes", &self.sets)?;
        }
        map.serialize_entry("features", &self.features)?;
        map.end()
    }
}

/// What the JSON reader says of what follows so many lines.
fn told(error: &serde_json::Error, lines: usize) -> String {
    let (text, place) = (error.to_string(), format!(" at line {} column {}", error.line(), error.column()));
    let what = text.strip_suffix(&place).map_or_else(|| text.clone(), |what| format!("{what} at line {} column {}", error.line() + lines, error.column()));
    format!("not JSON as GeoJSON needs it: {what} (numbers must be finite; NaN and Infinity are none)")
}

/// Features one a line may have record separators before them (RFC 8142), which are white space here.
struct Plain<R>(R);

impl<R: Read> Read for Plain<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.read(buffer)?;
        for byte in &mut buffer[..count] {
            if *byte == 0x1e {
                *byte = b'\n';
            }
        }
        Ok(count)
    }
}

impl From<ReadError> for Vec<Problem> {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Io(error) => vec![Problem { pointer: String::new(), detail: format!("reading failed: {error}") }],
            ReadError::Invalid(problems) => problems,
        }
    }
}
