//! Features as they are kept: under the name of their content, in parts that edits leave alone, found by id and by place.

use super::{
    collection::Collection,
    drawn::{Drawn, Id},
    problem::{Problems, ReadError},
    sets::Sets,
};
use crate::geometry::Rectangle;
use rayon::prelude::*;
use rstar::{AABB, RTree, primitives};
use sha2::{Digest, Sha256};
use std::{collections::BTreeSet, fmt::Write, io::Read, ops::Range, sync::OnceLock};

/// Features of a part at most.
const LONGEST_PART: usize = 4096;

/// A part ends after a feature whose text hashes to a multiple of this: one edit changes one or two parts of some 256 features.
const PART: u64 = 256;

type Tree = RTree<primitives::GeomWithData<primitives::Rectangle<[f64; 2]>, u32>>;

/// Features that are kept together, each with an id, in their order.
#[derive(Debug)]
pub struct FeatureSet {
    collection: Collection,
    tree: OnceLock<Tree>,
}

/// The texts that a set of features is kept as.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredSet {
    /// The name of the whole: 32 hex digits.
    pub name: String,
    /// The sets of attributes by name, as a JSON object.
    pub attributes: String,
    /// Features one a line, in parts with the names of their contents.
    pub parts: Vec<(String, String)>,
}

/// The first 32 hex digits of SHA-256.
fn name_of(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().take(16).fold(String::new(), |mut name, byte| {
        // Writing to text does not fail.
        let _ = write!(name, "{byte:02x}");
        name
    })
}

/// FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo) with the finaliser of `MurmurHash3` (A. Appleby), for the ends of parts alone.
fn scattered(text: &[u8]) -> u64 {
    let hash = text.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    let hash = (hash ^ (hash >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    let hash = (hash ^ (hash >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    hash ^ (hash >> 33)
}

impl FeatureSet {
    /// Gives features without an id one made of their content, and leaves out sets of attributes that none of them names. What the features say is for
    /// [`Collection::check`] to judge.
    ///
    /// # Errors
    /// If two features have one id.
    pub fn new(mut collection: Collection) -> Result<Self, ReadError> {
        let mut problems = Problems::default();
        collection.check_ids(&mut problems);
        problems.into_result(())?;
        if collection.features.iter().any(|drawn| drawn.id.is_none()) {
            give_ids(&mut collection);
        }
        let mut sets = std::mem::take(&mut collection.sets);
        let used: BTreeSet<&str> = collection.features.iter().flat_map(Drawn::sets).collect();
        sets.retain(|name| used.contains(name));
        collection.sets = sets;
        Ok(Self { collection, tree: OnceLock::new() })
    }

    /// The features with the sets of attributes that they share.
    #[must_use]
    pub fn collection(&self) -> &Collection {
        &self.collection
    }

    /// The place of a feature in the collection.
    #[must_use]
    pub fn position(&self, id: &str) -> Option<usize> {
        self.collection.features.iter().position(|drawn| drawn.id.as_ref().is_some_and(|known| known.is(id)))
    }

    /// The places of all features whose shapes may meet an area, ascending.
    #[must_use]
    pub fn find(&self, area: &Rectangle) -> Vec<u32> {
        let tree = self.tree.get_or_init(|| {
            let object = |(drawn, number): (&Drawn, u32)| {
                let bounds = drawn.bounds();
                primitives::GeomWithData::new(primitives::Rectangle::from_corners(bounds.min, bounds.max), number)
            };
            RTree::bulk_load(self.collection.features.iter().zip(0..).map(object).collect())
        });
        let mut found: Vec<u32> = tree.locate_in_envelope_intersecting(AABB::from_corners(area.min, area.max)).map(|object| object.data).collect();
        found.sort_unstable();
        found
    }

    /// The texts that it is kept as. They follow from the features and their order alone.
    #[must_use]
    pub fn stored(&self) -> StoredSet {
        let attributes = serde_json::to_string(&self.collection.sets).unwrap_or_default();
        // Lines first, on all threads of the present pool; then the parts that they make.
        let lines: Vec<(String, bool)> = self.collection.features.par_iter().map(|drawn| ended(line(drawn))).collect();
        let (mut ranges, mut first) = (Vec::new(), 0);
        for (i, (_, ends)) in lines.iter().enumerate() {
            if *ends || i + 1 - first == LONGEST_PART || i + 1 == lines.len() {
                ranges.push(first..i + 1);
                first = i + 1;
            }
        }
        let part = |range: Range<usize>| {
            let body: String = lines[range].iter().map(|(line, _)| &**line).collect();
            (name_of(body.as_bytes()), body)
        };
        let parts: Vec<(String, String)> = ranges.into_par_iter().map(part).collect();
        let names: Vec<&str> = parts.iter().map(|(name, _)| &**name).collect();
        let name = name_of(format!("terrane features 1\n{attributes}\n{}", names.join("\n")).as_bytes());
        StoredSet { name, attributes, parts }
    }

    /// Reads what was kept.
    ///
    /// # Errors
    /// If the texts are not what [`FeatureSet::stored`] gives.
    pub fn read(stored: &StoredSet) -> Result<Self, ReadError> {
        let sets = Sets::parse(&stored.attributes)?;
        let texts: Vec<&[u8]> = stored.parts.iter().map(|(_, body)| body.as_bytes()).collect();
        let mut collection = Collection::read_lines(Texts { texts, part: 0 })?;
        collection.sets = sets;
        Ok(Self { collection, tree: OnceLock::new() })
    }
}

/// Gives features without an id one made of their content.
fn give_ids(collection: &mut Collection) {
    let mut ids: BTreeSet<String> = collection.features.iter().filter_map(|drawn| Some(drawn.id.as_ref()?.to_string())).collect();
    for drawn in collection.features.iter_mut().filter(|drawn| drawn.id.is_none()) {
        let name = name_of(line(drawn).as_bytes());
        let numbered = |number: u32| if number == 1 { name[..12].to_owned() } else { format!("{}-{number}", &name[..12]) };
        let mut number = 1;
        while !ids.insert(numbered(number)) {
            number += 1;
        }
        drawn.id = Some(Id::Text(numbered(number).into()));
    }
}

/// A feature as one line of text.
fn line(drawn: &Drawn) -> String {
    serde_json::to_string(drawn).unwrap_or_default()
}

/// A line with its end, and whether a part ends after it.
fn ended(mut line: String) -> (String, bool) {
    let ends = scattered(line.as_bytes()).is_multiple_of(PART);
    line.push('\n');
    (line, ends)
}

/// The name of a feature's content: 32 hex digits.
#[must_use]
pub fn name_of_feature(drawn: &Drawn) -> String {
    name_of(line(drawn).as_bytes())
}

impl From<Collection> for FeatureSet {
    /// Features that were checked already.
    fn from(collection: Collection) -> Self {
        Self { collection, tree: OnceLock::new() }
    }
}

/// Texts one after the other.
struct Texts<'a> {
    texts: Vec<&'a [u8]>,
    part: usize,
}

impl Read for Texts<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while let Some(text) = self.texts.get_mut(self.part) {
            let count = text.read(buffer)?;
            if count > 0 || buffer.is_empty() {
                return Ok(count);
            }
            self.part += 1;
        }
        Ok(0)
    }
}
