//! One generation by itself: named by what it follows from, bred from without those before it.

use super::{
    lattice,
    line::{Line, Node},
    population::Lines,
    settings::{Feedback, Ground, HISTORY_FORM, MAX_HISTORY},
    state::State,
    terrain::AdaptiveTerrain,
};
use crate::evolve::record::RecordError;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// The form of [`Generation::to_bytes`].
const BYTES_FORM: u8 = 1;

/// A generation of an adaptive terrain.
///
/// Its hash names all that it follows from: of the first that is the ground, of others the generation before and the feedback. The same feedback of the same generation
/// is the same generation; another makes a branch.
///
/// ```
/// use terrane::evolve::{Feedback, Generation, Ground};
/// let first = Generation::first(&Ground { seed: 7, ..Ground::default() })?;
/// let next = first.next(&Feedback::point([400.0, 900.0]))?;
/// assert_eq!((next.number(), next.hash().len()), (1, 32));
/// let same = Generation::from_bytes(first.ground(), next.hash(), 1, &next.to_bytes())?;
/// assert_eq!(same, next);
/// # Ok::<(), terrane::evolve::RecordError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Generation {
    ground: Arc<Ground>,
    number: usize,
    hash: String,
    state: State,
}

/// The first 32 hex digits of SHA-256 of something's canonical JSON (RFC 8785).
fn name(content: &impl Serialize) -> String {
    // What is named has only string keys and finite numbers.
    let canonical = serde_json_canonicalizer::to_vec(content).unwrap_or_default();
    Sha256::digest(canonical).iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

impl Ground {
    /// The hash of its first generation, without breeding it.
    #[must_use]
    pub fn hash(&self) -> String {
        #[derive(Serialize)]
        struct First<'a> {
            form: u32,
            ground: &'a Ground,
        }
        name(&First { form: HISTORY_FORM, ground: self })
    }
}

impl Generation {
    /// The first generation of a ground.
    ///
    /// # Errors
    /// If a number of the ground is not what it must be.
    pub fn first(ground: &Ground) -> Result<Self, RecordError> {
        ground.check("")?;
        Ok(Self { number: 0, hash: ground.hash(), state: State::first(ground), ground: Arc::new(ground.clone()) })
    }

    /// Breeds the generation after this one.
    ///
    /// # Errors
    /// If the feedback lies off the terrain or is not what it must be otherwise, or this is the last generation that there can be.
    pub fn next(&self, feedback: &Feedback) -> Result<Self, RecordError> {
        #[derive(Serialize)]
        struct Next<'a> {
            parent: &'a str,
            feedback: &'a Feedback,
        }
        feedback.check(&self.ground, "")?;
        if self.number >= MAX_HISTORY {
            return Err(RecordError::new("", format!("the terrain has all {MAX_HISTORY} generations it can have: go back, or begin another")));
        }
        let number = self.number + 1;
        let state = self.state.next(&self.ground, number, feedback)?;
        Ok(Self { ground: Arc::clone(&self.ground), number, hash: name(&Next { parent: &self.hash, feedback }), state })
    }

    /// The root mean square of what this generation's heights are off the mean of those that a feedback asks for.
    ///
    /// # Errors
    /// If a point lies off the terrain.
    pub fn deviation(&self, feedback: &Feedback) -> Result<f64, RecordError> {
        Ok(self.state.terrain.deviation(self.wanted(feedback)?))
    }

    /// The mean of the heights that a feedback asks for, in metres: its own, and those at its points now.
    ///
    /// # Errors
    /// If a point lies off the terrain.
    pub fn wanted(&self, feedback: &Feedback) -> Result<f64, RecordError> {
        let above = self.state.wanted(&self.ground, feedback)?;
        Ok(self.ground.mean + above.iter().sum::<f64>() / above.len().max(1) as f64)
    }

    /// The ground that it is a generation of.
    #[must_use]
    pub fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// How many generations came before it.
    #[must_use]
    pub fn number(&self) -> usize {
        self.number
    }

    /// The name of all that it follows from: 32 hex digits.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Its heights in the plane.
    #[must_use]
    pub fn terrain(&self) -> &AdaptiveTerrain {
        &self.state.terrain
    }

    /// What the next generation is bred of: of every tree how many nodes it has, of all nodes their subtrees and heights, and what the lattice's heights differ from
    /// those that the lines make by themselves, in bits, which is 0 wherever nothing was kept from changing. Little-endian; it packs well.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let lines = &self.state.lines;
        let nodes = || lines.iter().flat_map(|line| &line.0);
        let mut bytes = vec![BYTES_FORM];
        bytes.extend(lines.iter().flat_map(|line| (line.0.len() as u32).to_le_bytes()));
        bytes.extend(nodes().map(|node| node.arity));
        bytes.extend(nodes().flat_map(|node| node.height.to_le_bytes()));
        let made = lattice::heights(&self.ground, lines);
        bytes.extend(self.state.terrain.nodes().iter().zip(made).flat_map(|(height, made)| (height.to_bits() ^ made.to_bits()).to_le_bytes()));
        bytes
    }

    /// The generation of [`Generation::to_bytes`].
    ///
    /// # Errors
    /// If the bytes are not those of a generation of this ground.
    pub fn from_bytes(ground: &Arc<Ground>, hash: &str, number: usize, bytes: &[u8]) -> Result<Self, RecordError> {
        let wrong = || RecordError::new("", "is not the state of a generation of this ground");
        let mut bytes = Reader(bytes);
        ground.check("/ground")?;
        if bytes.take(1) != Some(&[BYTES_FORM]) {
            return Err(wrong());
        }
        let lines = lines(ground, &mut bytes).ok_or_else(wrong)?;
        let mut heights = lattice::heights(ground, &lines);
        let differ = bytes.words(heights.len()).filter(|_| bytes.0.is_empty()).ok_or_else(wrong)?;
        for (height, differ) in heights.iter_mut().zip(differ) {
            *height = f32::from_bits(height.to_bits() ^ differ);
        }
        let [low, high] = ground.range.map(|bound| bound as f32);
        if !heights.iter().all(|height| (low..=high).contains(height)) {
            return Err(wrong());
        }
        let state = State { terrain: AdaptiveTerrain::new(ground, heights.into()), lines };
        Ok(Self { ground: Arc::clone(ground), number, hash: hash.to_owned(), state })
    }
}

/// The lines of a ground; `None` if the bytes are not such.
fn lines(ground: &Ground, bytes: &mut Reader) -> Option<Lines> {
    let counts: Vec<usize> = bytes.words(ground.populations * ground.lines)?.map(|count| count as usize).collect();
    if !counts.iter().all(|count| (2..=ground.nodes).contains(count)) {
        return None;
    }
    let all: usize = counts.iter().sum();
    let arities = bytes.take(all)?;
    let mut nodes = arities.iter().zip(bytes.words(all)?).map(|(&arity, bits)| Node { arity, height: f32::from_bits(bits) });
    counts.into_iter().map(|count| Line::read(nodes.by_ref().take(count).collect()).map(Arc::new)).collect()
}

/// Bytes that are left.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, left) = self.0.split_at_checked(count)?;
        self.0 = left;
        Some(taken)
    }

    fn words(&mut self, count: usize) -> Option<impl Iterator<Item = u32> + use<'a>> {
        Some(self.take(count.checked_mul(4)?)?.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)))
    }
}
