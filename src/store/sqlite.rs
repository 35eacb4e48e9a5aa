//! The embedded store: one `SQLite` file, write-ahead log, every commit synced to disk before it is acknowledged.

use super::StoreError;
use crate::world::{Document, Revision};
use sqlx::{
    Row, Sqlite, SqlitePool, Transaction,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous},
};
use std::{
    fs::{File, OpenOptions, TryLockError},
    path::Path,
    sync::Arc,
    time::Duration,
};

/// The layout of the tables below, kept in `PRAGMA user_version`.
const LAYOUT: i64 = 1;

/// Append-only: a document is stored once under its content's name, and every save or deletion of a world is a row; a deletion has no revision.
const TABLES: &str = "
    CREATE TABLE document (revision TEXT PRIMARY KEY, body TEXT NOT NULL) STRICT;
    CREATE TABLE history (
        world TEXT NOT NULL,
        number INTEGER NOT NULL,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        revision TEXT REFERENCES document (revision),
        PRIMARY KEY (world, number)
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 1;
";

/// What a write demands of the world's present state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// Nothing.
    #[default]
    Any,
    /// That there is no such world (`If-None-Match: *`).
    Absent,
    /// That there is such a world (`If-Match: *`).
    Present,
    /// That it is at one of these revisions (`If-Match`).
    At(Vec<String>),
}

impl Condition {
    fn check(&self, head: Option<&str>) -> Result<(), StoreError> {
        let holds = match self {
            Condition::Any => true,
            Condition::Absent => head.is_none(),
            Condition::Present => head.is_some(),
            Condition::At(revisions) => head.is_some_and(|head| revisions.iter().any(|revision| revision == head)),
        };
        if holds { Ok(()) } else { Err(StoreError::Condition(head.map(str::to_owned))) }
    }
}

/// A world's present document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredWorld {
    /// Its name.
    pub name: String,
    /// Its document.
    pub body: String,
}

/// What a save did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// A new world.
    Created,
    /// A new revision.
    Changed,
    /// Nothing: the world was at that revision.
    Unchanged,
}

/// One line of a world's history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RevisionEntry {
    /// Counts the saves and deletions of a name from 1.
    pub number: i64,
    /// When it was saved, RFC 3339, UTC.
    pub time: String,
    /// The name of the content.
    pub revision: String,
}

/// Worlds in an `SQLite` file.
#[derive(Clone, Debug)]
pub struct Store {
    pool: SqlitePool,
    /// Held by the one server that writes here, for as long as it lives.
    _lock: Option<Arc<File>>,
}

impl Store {
    /// Opens the store in a folder for its one server, making both where they are missing.
    ///
    /// # Errors
    /// If the folder cannot be made or another server uses it, or the database cannot be opened or is of a newer layout.
    pub async fn open(folder: &Path) -> Result<Self, StoreError> {
        let failed = |source| StoreError::Folder { path: folder.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let lock = OpenOptions::new().create(true).truncate(false).write(true).open(folder.join("terrane.lock")).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StoreError::InUse(folder.display().to_string())),
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let options = options(folder).create_if_missing(true).journal_mode(SqliteJournalMode::Wal).synchronous(SqliteSynchronous::Full);
        let pool = SqlitePoolOptions::new().max_connections(4).connect_with(options).await?;
        let store = Self { pool, _lock: Some(Arc::new(lock)) };
        store.lay_out().await?;
        Ok(store)
    }

    /// Opens a store that there is, for reading, beside a server or without one.
    ///
    /// # Errors
    /// If there is no database in the folder, or it is of a newer layout.
    pub async fn open_read_only(folder: &Path) -> Result<Self, StoreError> {
        let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options(folder).read_only(true)).await?;
        let found: i64 = sqlx::query_scalar("PRAGMA user_version").fetch_one(&pool).await?;
        if found == LAYOUT { Ok(Self { pool, _lock: None }) } else { Err(StoreError::Newer { found, known: LAYOUT }) }
    }

    async fn lay_out(&self) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        let found: i64 = sqlx::query_scalar("PRAGMA user_version").fetch_one(&mut *transaction).await?;
        match found {
            0 => {
                sqlx::raw_sql(TABLES).execute(&mut *transaction).await?;
            }
            LAYOUT => {}
            _ => return Err(StoreError::Newer { found, known: LAYOUT }),
        }
        Ok(transaction.commit().await?)
    }

    /// A transaction that holds the write lock from its start, so that what it reads stays true until it commits.
    async fn begin(&self) -> Result<Transaction<'static, Sqlite>, StoreError> {
        Ok(self.pool.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// True if nothing was ever saved.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn is_empty(&self) -> Result<bool, StoreError> {
        let rows: i64 = sqlx::query_scalar("SELECT count(*) FROM (SELECT 1 FROM history LIMIT 1)").fetch_one(&self.pool).await?;
        Ok(rows == 0)
    }

    /// Every world's present document, by name.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn worlds(&self) -> Result<Vec<StoredWorld>, StoreError> {
        let newest = "SELECT world, body FROM history h JOIN document USING (revision)
            WHERE number = (SELECT max(number) FROM history WHERE world = h.world) ORDER BY world";
        let rows = sqlx::query(newest).fetch_all(&self.pool).await?;
        rows.iter().map(|row| Ok(StoredWorld { name: row.try_get("world")?, body: row.try_get("body")? })).collect()
    }

    /// Appends a revision of a world; on return it is on disk.
    ///
    /// # Errors
    /// If the condition does not hold or the database fails; then nothing is stored.
    pub async fn save(&self, world: &str, document: &Document, condition: &Condition) -> Result<Saved, StoreError> {
        let revision = document.revision();
        let mut transaction = self.begin().await?;
        let (number, head) = head(&mut transaction, world).await?;
        condition.check(head.as_deref())?;
        if head.as_deref() == Some(revision.as_str()) {
            return Ok(Saved::Unchanged);
        }
        let insert = sqlx::query("INSERT INTO document (revision, body) VALUES (?, ?) ON CONFLICT DO NOTHING");
        insert.bind(revision.as_str()).bind(document.to_json()).execute(&mut *transaction).await?;
        append(&mut transaction, world, number + 1, Some(&revision)).await?;
        transaction.commit().await?;
        Ok(if head.is_none() { Saved::Created } else { Saved::Changed })
    }

    /// Takes a world out of the catalogue; its history stays.
    ///
    /// # Errors
    /// If there is no such world, the condition does not hold, or the database fails.
    pub async fn delete(&self, world: &str, condition: &Condition) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        let (number, head) = head(&mut transaction, world).await?;
        if head.is_none() {
            return Err(StoreError::UnknownWorld(world.to_owned()));
        }
        condition.check(head.as_deref())?;
        append(&mut transaction, world, number + 1, None).await?;
        Ok(transaction.commit().await?)
    }

    /// Every saved revision of a world, newest last.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn revisions(&self, world: &str) -> Result<Vec<RevisionEntry>, StoreError> {
        let saves = "SELECT number, time, revision FROM history WHERE world = ? AND revision IS NOT NULL ORDER BY number";
        let rows = sqlx::query(saves).bind(world).fetch_all(&self.pool).await?;
        rows.iter().map(|row| Ok(RevisionEntry { number: row.try_get("number")?, time: row.try_get("time")?, revision: row.try_get("revision")? })).collect()
    }

    /// The document of one of a world's revisions.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn document(&self, world: &str, revision: &Revision) -> Result<Option<String>, StoreError> {
        let body = "SELECT body FROM document JOIN history USING (revision) WHERE world = ? AND revision = ? LIMIT 1";
        Ok(sqlx::query_scalar(body).bind(world).bind(revision.as_str()).fetch_optional(&self.pool).await?)
    }

    /// Closes the database; what was acknowledged is on disk with or without this.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}

fn options(folder: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new().filename(folder.join("terrane.sqlite")).foreign_keys(true).busy_timeout(Duration::from_secs(5)).pragma("trusted_schema", "OFF")
}

/// The number of a world's last row and its present revision.
async fn head(transaction: &mut Transaction<'static, Sqlite>, world: &str) -> Result<(i64, Option<String>), StoreError> {
    let last = "SELECT number, revision FROM history WHERE world = ? ORDER BY number DESC LIMIT 1";
    match sqlx::query(last).bind(world).fetch_optional(&mut **transaction).await? {
        Some(row) => Ok((row.try_get("number")?, row.try_get("revision")?)),
        None => Ok((0, None)),
    }
}

async fn append(transaction: &mut Transaction<'static, Sqlite>, world: &str, number: i64, revision: Option<&Revision>) -> Result<(), StoreError> {
    let insert = sqlx::query("INSERT INTO history (world, number, revision) VALUES (?, ?, ?)");
    insert.bind(world).bind(number).bind(revision.map(Revision::as_str)).execute(&mut **transaction).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(seed: u64) -> Document {
        Document::parse(format!(r#"{{"seed":{seed},"base":{{"programme":"x","scale":1}}}}"#).as_bytes()).expect("valid")
    }

    #[tokio::test]
    async fn revisions_are_appended_and_survive_reopening() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(&folder.path().join("deep/data")).await.expect("opens");
        assert!(store.is_empty().await.expect("reads"));
        let (one, two) = (document(1), document(2));
        for (document, saved) in [(&one, Saved::Created), (&one, Saved::Unchanged), (&two, Saved::Changed), (&one, Saved::Changed)] {
            assert_eq!(store.save("a", document, &Condition::Any).await.expect("saves"), saved);
        }
        let reader = Store::open_read_only(&folder.path().join("deep/data")).await.expect("opens beside it");
        assert_eq!(reader.worlds().await.expect("reads").len(), 1);
        assert!(matches!(Store::open(&folder.path().join("deep/data")).await, Err(StoreError::InUse(_))));
        store.close().await;
        drop(store);
        let store = Store::open(&folder.path().join("deep/data")).await.expect("reopens");
        let names: Vec<_> = store.revisions("a").await.expect("reads").into_iter().map(|entry| (entry.number, entry.revision)).collect();
        let (first, second) = (one.revision().to_string(), two.revision().to_string());
        assert_eq!(names, [(1, first.clone()), (2, second), (3, first)]);
        assert_eq!(store.worlds().await.expect("reads"), [StoredWorld { name: "a".into(), body: one.to_json() }]);
        assert_eq!(store.document("a", &two.revision()).await.expect("reads"), Some(two.to_json()));
        assert_eq!(store.document("b", &two.revision()).await.expect("reads"), None);
    }

    #[tokio::test]
    async fn conditions_are_checked_against_the_present_state() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        let at = |document: &Document| Condition::At(vec![document.revision().to_string()]);
        assert!(matches!(store.save("a", &document(1), &Condition::Present).await, Err(StoreError::Condition(None))));
        store.save("a", &document(1), &Condition::Absent).await.expect("absent");
        assert!(matches!(store.save("a", &document(2), &Condition::Absent).await, Err(StoreError::Condition(Some(_)))));
        assert!(matches!(store.save("a", &document(2), &at(&document(3))).await, Err(StoreError::Condition(Some(_)))));
        store.save("a", &document(2), &at(&document(1))).await.expect("at revision 1");
        assert!(matches!(store.delete("a", &at(&document(1))).await, Err(StoreError::Condition(_))));
        store.delete("a", &at(&document(2))).await.expect("at revision 2");
        assert!(matches!(store.delete("a", &Condition::Any).await, Err(StoreError::UnknownWorld(_))));
        assert!(store.worlds().await.expect("reads").is_empty() && !store.is_empty().await.expect("reads"));
        assert_eq!(store.save("a", &document(2), &Condition::Absent).await.expect("again"), Saved::Created);
        assert_eq!(store.revisions("a").await.expect("reads").last().map(|entry| entry.number), Some(4));
    }

    #[tokio::test]
    async fn a_newer_layout_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        sqlx::query("PRAGMA user_version = 99").execute(&store.pool).await.expect("sets");
        store.close().await;
        drop(store);
        assert!(matches!(Store::open(folder.path()).await, Err(StoreError::Newer { found: 99, known: 1 })));
    }
}
