//! How far jobs of many steps are: what they go on from, and their history.

use super::{Store, StoreError};
use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use sqlx::{Row, sqlite::SqliteRow};
use std::io::{Read, Write};

/// A step that a job has done.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Which; the first is 0.
    pub number: i64,
    /// How many there are at most.
    pub of: i64,
    /// What its history has of it, as JSON.
    pub line: String,
    /// What it would come to if it ended here, as JSON.
    pub found: String,
    /// What it goes on from, [packed](pack).
    pub state: Vec<u8>,
    /// Whether it is the last: then the job is done, and its state is not kept.
    pub is_last: bool,
}

/// What is known of a job of many steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Log {
    /// The step of its checkpoint.
    pub step: i64,
    /// What it has found so far, as JSON.
    pub found: String,
    /// Lines of its history.
    pub lines: Vec<String>,
}

/// Compresses a state, which takes a while: not on the threads that answer requests.
#[must_use]
pub fn pack(state: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Nothing fails that writes to memory.
    encoder.write_all(state).and_then(|()| encoder.finish()).unwrap_or_default()
}

impl Store {
    /// Stores a step of an open job: its checkpoint takes the place of the last one, its line is added to the history, both or neither. `false`, and nothing is stored, if
    /// nobody waits for it any more or it does not follow the last one. On return it is on disk.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn advance(&self, id: &str, step: &Step) -> Result<bool, StoreError> {
        let mut transaction = self.begin().await?;
        let follows = "SELECT coalesce((SELECT step FROM job_checkpoint WHERE job = id), -1) = ? - 1 FROM job WHERE id = ? AND state = 'open'";
        let follows: Option<bool> = sqlx::query_scalar(follows).bind(step.number).bind(id).fetch_optional(&mut *transaction).await?;
        if follows != Some(true) {
            return Ok(false);
        }
        let put = "INSERT INTO job_checkpoint (job, step, steps, found, state) VALUES (?, ?, ?, ?, ?)
            ON CONFLICT (job) DO UPDATE SET step = excluded.step, steps = excluded.steps, found = excluded.found, state = excluded.state";
        let state: &[u8] = if step.is_last { &[] } else { &step.state };
        sqlx::query(put).bind(id).bind(step.number).bind(step.of).bind(&step.found).bind(state).execute(&mut *transaction).await?;
        let line = sqlx::query("INSERT INTO job_step (job, number, line) VALUES (?, ?, ?)");
        line.bind(id).bind(step.number).bind(&step.line).execute(&mut *transaction).await?;
        if step.is_last {
            sqlx::query("UPDATE job SET state = 'done' WHERE id = ?").bind(id).execute(&mut *transaction).await?;
        }
        transaction.commit().await?;
        Ok(true)
    }

    /// What an open or stopped job goes on from, unpacked; `None` if it has not begun.
    ///
    /// # Errors
    /// If the database fails, or what it holds is damaged.
    pub async fn state(&self, id: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let packed: Option<Vec<u8>> = sqlx::query_scalar("SELECT state FROM job_checkpoint WHERE job = ?").bind(id).fetch_optional(&self.pool).await?;
        let Some(packed) = packed.filter(|packed| !packed.is_empty()) else { return Ok(None) };
        let mut state = Vec::new();
        ZlibDecoder::new(&*packed).read_to_end(&mut state).map_err(|error| StoreError::Database(sqlx::Error::Decode(Box::new(error))))?;
        Ok(Some(state))
    }

    /// Lets an open job begin anew: its checkpoint and its history are forgotten.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn rewind(&self, id: &str) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        sqlx::query("DELETE FROM job_checkpoint WHERE job = ?").bind(id).execute(&mut *transaction).await?;
        sqlx::query("DELETE FROM job_step WHERE job = ?").bind(id).execute(&mut *transaction).await?;
        transaction.commit().await?;
        Ok(())
    }

    /// What a job has found so far, and the lines of its history from a step on, at most so many: of one moment. `None` if it has not begun.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn log(&self, id: &str, from: i64, most: u32) -> Result<Option<Log>, StoreError> {
        let mut transaction = self.pool.begin().await?;
        let checkpoint = sqlx::query("SELECT step, found FROM job_checkpoint WHERE job = ?").bind(id).fetch_optional(&mut *transaction).await?;
        let Some(checkpoint) = checkpoint else { return Ok(None) };
        let lines = sqlx::query("SELECT line FROM job_step WHERE job = ? AND number >= ? ORDER BY number LIMIT ?");
        let rows = lines.bind(id).bind(from).bind(most).fetch_all(&mut *transaction).await?;
        let lines = rows.iter().map(|row: &SqliteRow| row.try_get("line")).collect::<Result<_, sqlx::Error>>()?;
        Ok(Some(Log { step: checkpoint.try_get("step")?, found: checkpoint.try_get("found")?, lines }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{JobState, layout::tests::lay_out_as};
    use sqlx::{
        Connection, SqliteConnection,
        sqlite::{SqliteConnectOptions, SqliteJournalMode},
    };

    fn step(number: i64, is_last: bool) -> Step {
        let state = format!("state {number} ").repeat(100);
        Step { number, of: 2, line: format!("line {number}"), found: format!("found {number}"), state: pack(state.as_bytes()), is_last }
    }

    #[tokio::test]
    async fn steps_follow_each_other_and_outlive_the_program() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        assert!(!store.advance("a", &step(0, false)).await.expect("nobody waits"));
        store.ask("a", "{}").await.expect("asked");
        assert_eq!((store.state("a").await.expect("reads"), store.log("a", 0, 9).await.expect("reads")), (None, None));
        assert!(!store.advance("a", &step(1, false)).await.expect("too early"));
        assert!(store.advance("a", &step(0, false)).await.expect("stored"));
        assert!(!store.advance("a", &step(0, false)).await.expect("too late"));
        assert!(store.advance("a", &step(1, false)).await.expect("stored"));
        store.close().await;
        drop(store);
        let store = Store::open(folder.path()).await.expect("reopens");
        assert_eq!(store.open_jobs().await.expect("reads")[0].steps, Some([1, 2]));
        assert_eq!(store.state("a").await.expect("reads").expect("kept"), "state 1 ".repeat(100).into_bytes());

        // Laid aside it takes no step; asked for again it goes on.
        assert_eq!(store.lay_aside("a").await.expect("laid").map(|entry| entry.state), Some(JobState::Stopped));
        assert!(!store.advance("a", &step(2, true)).await.expect("nobody waits") && store.open_jobs().await.expect("reads").is_empty());
        assert_eq!(store.ask("a", "{}").await.expect("asked").state, JobState::Open);
        assert!(store.advance("a", &step(2, true)).await.expect("stored"));
        assert_eq!(store.lay_aside("a").await.expect("too late").map(|entry| entry.state), Some(JobState::Done(None)));
        let log = Log { step: 2, found: "found 2".to_owned(), lines: vec!["line 1".to_owned(), "line 2".to_owned()] };
        assert_eq!(store.log("a", 1, 9).await.expect("reads"), Some(log));
        assert_eq!(store.state("a").await.expect("reads"), None, "what is done goes on from nothing");
        assert!(store.forget("a").await.expect("forgotten"));
        assert_eq!(store.log("a", 0, 9).await.expect("reads"), None);
    }

    #[tokio::test]
    async fn a_job_that_begins_anew_or_failed_has_no_past() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        store.ask("a", "{}").await.expect("asked");
        store.advance("a", &step(0, false)).await.expect("stored");
        store.rewind("a").await.expect("rewound");
        assert!(store.advance("a", &step(0, false)).await.expect("stored"));
        store.fail("a", "broken").await.expect("failed");
        assert_eq!(store.ask("a", "{}").await.expect("anew").steps, None);
        assert_eq!(store.log("a", 0, 9).await.expect("reads"), None);
    }

    #[tokio::test]
    async fn stores_of_the_layout_before_keep_their_jobs() {
        let folder = tempfile::tempdir().expect("a folder");
        let options = SqliteConnectOptions::new().filename(folder.path().join("terrane.sqlite")).create_if_missing(true).journal_mode(SqliteJournalMode::Wal);
        let mut connection = SqliteConnection::connect_with(&options).await.expect("connects");
        lay_out_as(&mut connection, 5).await;
        sqlx::raw_sql("INSERT INTO job (id, work, state) VALUES ('a', '{}', 'open')").execute(&mut connection).await.expect("stored");
        connection.close().await.expect("closes");
        let store = Store::open(folder.path()).await.expect("brought up to date");
        assert_eq!(store.open_jobs().await.expect("reads").len(), 1);
        assert!(store.advance("a", &step(0, false)).await.expect("stored"));
    }
}
