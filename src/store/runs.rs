//! Jobs and the rasters that they make.

use super::{Store, StoreError};
use crate::world::StoredRaster;
use sqlx::{AssertSqlSafe, Row, Sqlite, Transaction, sqlite::SqliteRow};

/// How far a job is, as the store knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JobState {
    /// It waits, or is under way.
    Open,
    /// It was laid aside, and goes on when it is asked for again.
    Stopped,
    /// It made the raster of this name; without one, its checkpoint holds what was found.
    Done(Option<String>),
    /// It failed, and will not be tried again by itself.
    Failed(String),
}

impl JobState {
    /// Its name in one word.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            JobState::Open => "open",
            JobState::Stopped => "stopped",
            JobState::Done(_) => "done",
            JobState::Failed(_) => "failed",
        }
    }
}

/// A job as the store keeps it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobEntry {
    /// The name of what is asked for: 32 hex digits.
    pub id: String,
    /// When it was asked for, RFC 3339, UTC.
    pub time: String,
    /// What is asked for, as JSON.
    pub work: String,
    /// How far it is.
    pub state: JobState,
    /// Steps done and steps there are at most, as its checkpoint has them.
    pub steps: Option<[i64; 2]>,
}

/// A raster as lists name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RasterEntry {
    /// The name of its content: 32 hex digits.
    pub name: String,
    /// When it was stored, RFC 3339, UTC.
    pub time: String,
    /// What is known of it without its heights, as JSON.
    pub head: String,
}

fn job(row: &SqliteRow) -> Result<JobEntry, sqlx::Error> {
    let state: String = row.try_get("state")?;
    let state = match state.as_str() {
        "done" => JobState::Done(row.try_get("raster")?),
        "failed" => JobState::Failed(row.try_get("failure")?),
        "stopped" => JobState::Stopped,
        _ => JobState::Open,
    };
    let steps: [Option<i64>; 2] = [row.try_get("step")?, row.try_get("steps")?];
    let steps = if let [Some(step), Some(steps)] = steps { Some([step, steps]) } else { None };
    Ok(JobEntry { id: row.try_get("id")?, time: row.try_get("time")?, work: row.try_get("work")?, state, steps })
}

/// Jobs with how far their checkpoints are.
const JOBS: &str = "SELECT job.*, step, steps FROM job LEFT JOIN job_checkpoint ON job_checkpoint.job = job.id";

impl Store {
    /// Stores a job; one that failed is asked for anew, one that was stopped goes on, one that is known otherwise stays as it is. On return it is on disk.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn ask(&self, id: &str, work: &str) -> Result<JobEntry, StoreError> {
        let mut transaction = self.begin().await?;
        sqlx::query("DELETE FROM job WHERE id = ? AND state = 'failed'").bind(id).execute(&mut *transaction).await?;
        let insert = sqlx::query("INSERT INTO job (id, work, state) VALUES (?, ?, 'open') ON CONFLICT DO NOTHING");
        insert.bind(id).bind(work).execute(&mut *transaction).await?;
        sqlx::query("UPDATE job SET state = 'open' WHERE id = ? AND state = 'stopped'").bind(id).execute(&mut *transaction).await?;
        let entry = sqlx::query(AssertSqlSafe(format!("{JOBS} WHERE id = ?"))).bind(id).fetch_one(&mut *transaction).await?;
        transaction.commit().await?;
        Ok(job(&entry)?)
    }

    /// A job.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn job(&self, id: &str) -> Result<Option<JobEntry>, StoreError> {
        let row = sqlx::query(AssertSqlSafe(format!("{JOBS} WHERE id = ?"))).bind(id).fetch_optional(&self.pool).await?;
        Ok(row.as_ref().map(job).transpose()?)
    }

    /// The newest jobs first, at most so many.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn jobs(&self, most: u32) -> Result<Vec<JobEntry>, StoreError> {
        let rows = sqlx::query(AssertSqlSafe(format!("{JOBS} ORDER BY number DESC LIMIT ?"))).bind(most).fetch_all(&self.pool).await?;
        Ok(rows.iter().map(job).collect::<Result<_, _>>()?)
    }

    /// The jobs that are not ended, in the order in which they were asked for.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn open_jobs(&self) -> Result<Vec<JobEntry>, StoreError> {
        let rows = sqlx::query(AssertSqlSafe(format!("{JOBS} WHERE job.state = 'open' ORDER BY number"))).fetch_all(&self.pool).await?;
        Ok(rows.iter().map(job).collect::<Result<_, _>>()?)
    }

    /// Ends a job with what it made: both are stored or neither. What nobody waits for any more is not stored.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn finish(&self, id: &str, raster: &StoredRaster) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        put_raster(&mut transaction, raster).await?;
        let update = sqlx::query("UPDATE job SET state = 'done', raster = ? WHERE id = ? AND state = 'open'");
        let updated = update.bind(&raster.name).bind(id).execute(&mut *transaction).await?;
        if updated.rows_affected() == 1 {
            transaction.commit().await?;
        }
        Ok(())
    }

    /// Ends a job that failed.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn fail(&self, id: &str, failure: &str) -> Result<(), StoreError> {
        sqlx::query("UPDATE job SET state = 'failed', failure = ? WHERE id = ? AND state = 'open'").bind(failure).bind(id).execute(&self.pool).await?;
        Ok(())
    }

    /// Lays a job aside that is open; its checkpoint stays. Answers the job as it is then, if there is one.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn lay_aside(&self, id: &str) -> Result<Option<JobEntry>, StoreError> {
        sqlx::query("UPDATE job SET state = 'stopped' WHERE id = ? AND state = 'open'").bind(id).execute(&self.pool).await?;
        self.job(id).await
    }

    /// Forgets a job; what it made stays. `false` if there is none.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn forget(&self, id: &str) -> Result<bool, StoreError> {
        Ok(sqlx::query("DELETE FROM job WHERE id = ?").bind(id).execute(&self.pool).await?.rows_affected() > 0)
    }

    /// The stored raster of a name.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn raster(&self, name: &str) -> Result<Option<StoredRaster>, StoreError> {
        let row = sqlx::query("SELECT head, samples FROM raster WHERE name = ?").bind(name).fetch_optional(&self.pool).await?;
        let read = |row: SqliteRow| Ok(StoredRaster { name: name.to_owned(), head: row.try_get("head")?, samples: row.try_get("samples")? });
        Ok(row.map(read).transpose().map_err(|error: sqlx::Error| error)?)
    }

    /// The newest rasters first, at most so many.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn rasters(&self, most: u32) -> Result<Vec<RasterEntry>, StoreError> {
        let rows = sqlx::query("SELECT name, time, head FROM raster ORDER BY time DESC, name LIMIT ?").bind(most).fetch_all(&self.pool).await?;
        let entry = |row: &SqliteRow| Ok(RasterEntry { name: row.try_get("name")?, time: row.try_get("time")?, head: row.try_get("head")? });
        Ok(rows.iter().map(entry).collect::<Result<_, sqlx::Error>>()?)
    }
}

/// Stores a raster; one that is there already stays.
async fn put_raster(transaction: &mut Transaction<'static, Sqlite>, raster: &StoredRaster) -> Result<(), StoreError> {
    let insert = sqlx::query("INSERT INTO raster (name, head, samples) VALUES (?, ?, ?) ON CONFLICT DO NOTHING");
    insert.bind(&raster.name).bind(&raster.head).bind(&raster.samples).execute(&mut **transaction).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Lattice, Raster};

    #[tokio::test]
    async fn jobs_end_once_and_outlive_the_program() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        let asked = |id: &str| (id.to_owned(), format!("{{\"for\": \"{id}\"}}"));
        let (a, b) = (asked("a"), asked("b"));
        assert_eq!(store.ask(&a.0, &a.1).await.expect("asked").state, JobState::Open);
        store.ask(&b.0, &b.1).await.expect("asked");
        store.close().await;
        drop(store);
        let store = Store::open(folder.path()).await.expect("reopens");
        let open: Vec<_> = store.open_jobs().await.expect("reads").into_iter().map(|entry| (entry.id, entry.work)).collect();
        assert_eq!(open, [a.clone(), b.clone()]);
        let raster = StoredRaster::of(&Raster::new(Lattice { origin: [0.0, 0.0], first: [0, 0], spacing: 1.0 }, 2, vec![1.0; 4]));
        store.finish(&a.0, &raster).await.expect("finished");
        assert_eq!(store.raster(&raster.name).await.expect("reads"), Some(raster.clone()));
        store.fail(&a.0, "too late").await.expect("no matter");
        assert_eq!(store.job(&a.0).await.expect("reads").map(|entry| entry.state), Some(JobState::Done(Some(raster.name.clone()))));
        assert_eq!(store.ask(&a.0, &a.1).await.expect("known").state, JobState::Done(Some(raster.name.clone())));
        store.fail(&b.0, "broken").await.expect("failed");
        assert_eq!(store.jobs(1).await.expect("reads")[0].state, JobState::Failed("broken".to_owned()));
        assert_eq!(store.ask(&b.0, &b.1).await.expect("anew").state, JobState::Open);
        assert!(store.forget(&b.0).await.expect("forgotten") && !store.forget(&b.0).await.expect("gone"));
        let other = StoredRaster::of(&Raster::new(Lattice { origin: [0.0, 0.0], first: [0, 0], spacing: 1.0 }, 2, vec![2.0; 4]));
        store.finish(&b.0, &other).await.expect("nobody waits");
        assert_eq!(store.raster(&other.name).await.expect("reads"), None);
        assert_eq!(store.rasters(10).await.expect("reads").len(), 1);
    }
}
