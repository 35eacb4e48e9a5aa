//! Generations of adaptive terrain: how each was bred, of some all that the next is bred of.

use super::{Store, StoreError};
use crate::evolve::{Feedback, Generation, Ground, RecordError};
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use sqlx::{Row, Sqlite, Transaction, sqlite::SqliteRow};
use std::{
    io::{Read, Write},
    sync::Arc,
};

/// Of every so many generations the whole state is stored, so that none is more than so many steps away from one.
const WHOLE: usize = 16;

/// Most bytes that a state is unpacked to.
const MAX_STATE: u64 = 1 << 26;

/// A generation to be stored.
#[derive(Clone, Debug, PartialEq)]
pub struct NewGeneration {
    hash: String,
    number: i64,
    parent: Option<String>,
    /// The ground of a first generation, the feedback that others were bred by, as JSON.
    said: String,
    deviation: Option<f64>,
    state: Option<Vec<u8>>,
}

/// A generation as lists name it.
#[derive(Clone, Debug, PartialEq)]
pub struct GenerationEntry {
    /// The name of what it follows from: 32 hex digits.
    pub hash: String,
    /// How many came before it.
    pub number: i64,
    /// When it was stored, RFC 3339, UTC.
    pub time: String,
    /// What it was bred by, as JSON: of lists without the ways of players. `None` of a first generation.
    pub feedback: Option<String>,
    /// What its heights were off those that were asked for, in metres.
    pub deviation: Option<f64>,
}

/// A stored generation with what it is bred again from.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredGeneration {
    /// The ground, as JSON.
    ground: String,
    /// Where to begin: hash, number and packed state; with the first without one.
    begin: Option<(String, usize, Vec<u8>)>,
    /// Hash and feedback of those after that.
    steps: Vec<(String, String)>,
}

/// Why a stored generation cannot be bred again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct GenerationError(String);

impl From<RecordError> for GenerationError {
    fn from(error: RecordError) -> Self {
        Self(error.to_string())
    }
}

fn read<'a, T: serde::Deserialize<'a>>(json: &'a str) -> Result<T, GenerationError> {
    serde_json::from_str(json).map_err(|error| GenerationError(error.to_string()))
}

/// A ground and a feedback have only string keys and finite numbers.
fn written(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

impl NewGeneration {
    /// The first generation of a ground.
    #[must_use]
    pub fn first(ground: &Ground) -> Self {
        Self { hash: ground.hash(), number: 0, parent: None, said: written(ground), deviation: None, state: None }
    }

    /// A generation with what it was bred of and by, and what its heights are off those asked for.
    #[must_use]
    pub fn bred(generation: &Generation, parent: &str, feedback: &Feedback, deviation: f64) -> Self {
        let state = generation.number().is_multiple_of(WHOLE).then(|| packed(&generation.to_bytes()));
        Self {
            hash: generation.hash().to_owned(),
            number: generation.number() as i64,
            parent: Some(parent.to_owned()),
            said: written(feedback),
            deviation: Some(deviation),
            state,
        }
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Memory takes all that is written.
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default()
}

impl StoredGeneration {
    /// The generation, bred again from the last before it that is whole.
    ///
    /// # Errors
    /// If what is stored is not what its names say.
    pub fn read(&self) -> Result<Generation, GenerationError> {
        let ground: Ground = read(&self.ground)?;
        let mut generation = match &self.begin {
            None => Generation::first(&ground)?,
            Some((hash, number, state)) => {
                let mut bytes = Vec::new();
                ZlibDecoder::new(&state[..]).take(MAX_STATE).read_to_end(&mut bytes).map_err(|error| GenerationError(error.to_string()))?;
                Generation::from_bytes(&Arc::new(ground), hash, *number, &bytes)?
            }
        };
        for (hash, feedback) in &self.steps {
            generation = generation.next(&read::<Feedback>(feedback)?)?;
            if generation.hash() != hash {
                return Err(GenerationError(format!("generation {hash} is not what it is named after: the store is damaged")));
            }
        }
        Ok(generation)
    }
}

/// Stores generations; one that is there already stays.
pub(super) async fn put(transaction: &mut Transaction<'static, Sqlite>, generations: &[NewGeneration]) -> Result<(), StoreError> {
    for NewGeneration { hash, number, parent, said, deviation, state } in generations {
        let insert = sqlx::query("INSERT INTO generation (hash, number, parent, said, deviation, state) VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING");
        insert.bind(hash).bind(number).bind(parent).bind(said).bind(deviation).bind(state).execute(&mut **transaction).await?;
    }
    Ok(())
}

impl Store {
    /// The stored generation of a hash.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn generation(&self, hash: &str) -> Result<Option<StoredGeneration>, StoreError> {
        let way = "WITH RECURSIVE way (hash, number, parent, said, state) AS (
                SELECT hash, number, parent, said, state FROM generation WHERE hash = ?
                UNION ALL
                SELECT g.hash, g.number, g.parent, g.said, g.state FROM way JOIN generation g ON g.hash = way.parent WHERE way.state IS NULL
            ) SELECT hash, number, said, state FROM way ORDER BY number";
        let rows = sqlx::query(way).bind(hash).fetch_all(&self.pool).await?;
        let Some((begin, others)) = rows.split_first() else { return Ok(None) };
        let step = |row: &SqliteRow| Ok((row.try_get("hash")?, row.try_get("said")?));
        let steps = others.iter().map(step).collect::<Result<_, sqlx::Error>>()?;
        let Some(state) = begin.try_get("state")? else {
            return Ok(Some(StoredGeneration { ground: begin.try_get("said")?, begin: None, steps }));
        };
        let number: i64 = begin.try_get("number")?;
        let first = "WITH RECURSIVE way (hash, parent, number) AS (
                SELECT hash, parent, number FROM generation WHERE hash = ?
                UNION ALL
                SELECT g.hash, g.parent, g.number FROM way JOIN generation g ON g.hash = way.parent
            ) SELECT said FROM generation WHERE hash = (SELECT hash FROM way WHERE number = 0)";
        let ground = sqlx::query_scalar(first).bind(hash).fetch_one(&self.pool).await?;
        Ok(Some(StoredGeneration { ground, begin: Some((begin.try_get("hash")?, number as usize, state)), steps }))
    }

    /// The generations on the way to one, the first of them first, without the ways of players; none if it is not stored.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn generations(&self, hash: &str) -> Result<Vec<GenerationEntry>, StoreError> {
        self.way_to(hash, "json_remove(said, '$.ways')").await
    }

    /// As [`Store::generations`], with the ways of players; `None` if all feedback together is longer than so many bytes.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn whole_generations(&self, hash: &str, most: u64) -> Result<Option<Vec<GenerationEntry>>, StoreError> {
        let lengths = self.way_to(hash, "length(said)").await?;
        let length: u64 = lengths.iter().filter_map(|entry| entry.feedback.as_ref()?.parse::<u64>().ok()).sum();
        if length > most { Ok(None) } else { self.way_to(hash, "said").await.map(Some) }
    }

    async fn way_to(&self, hash: &str, said: &'static str) -> Result<Vec<GenerationEntry>, StoreError> {
        // The column is one of three that stand above.
        let way = sqlx::AssertSqlSafe(format!(
            "WITH RECURSIVE way (own, parent_of_own) AS (
                SELECT hash, parent FROM generation WHERE hash = ?
                UNION ALL
                SELECT hash, parent FROM way JOIN generation ON hash = parent_of_own
            ) SELECT hash, number, time, deviation, CASE WHEN parent IS NULL THEN NULL ELSE CAST({said} AS TEXT) END AS feedback
              FROM way JOIN generation ON hash = own ORDER BY number"
        ));
        let rows = sqlx::query(way).bind(hash).fetch_all(&self.pool).await?;
        let entry = |row: &SqliteRow| {
            Ok(GenerationEntry {
                hash: row.try_get("hash")?,
                number: row.try_get("number")?,
                time: row.try_get("time")?,
                feedback: row.try_get("feedback")?,
                deviation: row.try_get("deviation")?,
            })
        };
        Ok(rows.iter().map(entry).collect::<Result<_, sqlx::Error>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn generations_are_bred_again_from_what_is_stored() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        let ground = Ground { seed: 3, lines: 9, length: 12, ..Ground::default() };
        let mut generations = vec![Generation::first(&ground).expect("right")];
        let mut new = vec![NewGeneration::first(&ground)];
        for i in 0..40 {
            let last = &generations[i];
            let feedback = Feedback { radius: (i % 2 == 0).then_some(90.0), ..Feedback::point([f64::from(i as u32), 50.0]) };
            let next = last.next(&feedback).expect("on the terrain");
            new.push(NewGeneration::bred(&next, last.hash(), &feedback, 1.5));
            generations.push(next);
        }
        let mut transaction = store.begin().await.expect("begins");
        put(&mut transaction, &new).await.expect("stores");
        put(&mut transaction, &new).await.expect("stores nothing twice");
        transaction.commit().await.expect("commits");
        for generation in &generations[1..] {
            let stored = store.generation(generation.hash()).await.expect("reads").expect("stored");
            assert!(stored.steps.len() < WHOLE && stored.begin.is_some() == (generation.number() >= WHOLE));
            assert_eq!(stored.read().expect("whole"), *generation);
        }
        assert_eq!(store.generation("0").await.expect("reads"), None);
        let all = store.generations(generations[40].hash()).await.expect("reads");
        assert_eq!(all.len(), 41);
        assert_eq!((all[0].feedback.as_ref(), all[0].deviation, &all[7].hash[..]), (None, None, generations[7].hash()));
        assert_eq!(all[2].feedback.as_deref(), Some(r#"{"points":[[1.0,50.0]]}"#));
        assert_eq!(store.whole_generations(generations[40].hash(), 100).await.expect("reads"), None);
        assert_eq!(store.whole_generations(generations[40].hash(), 100_000).await.expect("reads"), Some(all));

        // What is damaged is told.
        let mut stored = store.generation(generations[20].hash()).await.expect("reads").expect("stored");
        stored.steps[1].1 = r#"{"heights":[100]}"#.to_owned();
        assert!(stored.read().expect_err("damaged").to_string().contains("damaged"));
        if let Some((_, _, state)) = &mut stored.begin {
            state.truncate(50);
        }
        assert!(stored.read().is_err());
    }
}
