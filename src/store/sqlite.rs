//! The embedded store: one `SQLite` file, write-ahead log, every commit synced to disk before it is acknowledged.

use super::{Content, Kind, NewGeneration, StoreError, feature_set, generations, layout};
use crate::{layout::geojson::StoredSet, world::Revision};
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

/// What a write demands of a name's present state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// Nothing.
    #[default]
    Any,
    /// That there is no such document (`If-None-Match: *`).
    Absent,
    /// That there is such a document (`If-Match: *`).
    Present,
    /// That it is at one of these revisions (`If-Match`).
    At(Vec<String>),
}

impl Condition {
    /// Whether it holds for what is at a revision, or is not there.
    #[must_use]
    pub fn holds(&self, head: Option<&str>) -> bool {
        match self {
            Condition::Any => true,
            Condition::Absent => head.is_none(),
            Condition::Present => head.is_some(),
            Condition::At(revisions) => head.is_some_and(|head| revisions.iter().any(|revision| revision == head)),
        }
    }

    fn check(&self, kind: Kind, head: Option<&str>) -> Result<(), StoreError> {
        if self.holds(head) { Ok(()) } else { Err(StoreError::Condition { kind, revision: head.map(str::to_owned) }) }
    }
}

/// What a document names, to be stored with it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// A set of features.
    pub set: Option<&'a StoredSet>,
    /// Generations of adaptive terrain, each after those before it.
    pub generations: &'a [NewGeneration],
}

/// What a name stands for now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredDocument {
    /// Its name.
    pub name: String,
    /// Its document.
    pub body: String,
}

/// What a save did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// A new document.
    Created,
    /// A new revision.
    Changed,
    /// Nothing: the document was at that revision.
    Unchanged,
}

/// One line of a name's history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RevisionEntry {
    /// Counts the saves and deletions of a name from 1.
    pub number: i64,
    /// When it was saved, RFC 3339, UTC.
    pub time: String,
    /// The name of the content.
    pub revision: String,
}

/// Documents in an `SQLite` file.
#[derive(Clone, Debug)]
pub struct Store {
    pub(super) pool: SqlitePool,
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
        let mut transaction = store.begin().await?;
        layout::lay_out(&mut transaction).await?;
        transaction.commit().await?;
        Ok(store)
    }

    /// Opens the store in a folder for its keys, beside a server or without one.
    ///
    /// # Errors
    /// As [`Store::open`], but for another server that uses the folder.
    pub async fn open_beside(folder: &Path) -> Result<Self, StoreError> {
        match Self::open(folder).await {
            // That server has brought the tables to its layout.
            Err(StoreError::InUse(_)) => {
                let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options(folder).synchronous(SqliteSynchronous::Full)).await?;
                layout::check_current(&pool).await?;
                Ok(Self { pool, _lock: None })
            }
            opened => opened,
        }
    }

    /// Opens a store that there is, for reading, beside a server or without one.
    ///
    /// # Errors
    /// If there is no database in the folder, or it is of a newer layout.
    pub async fn open_read_only(folder: &Path) -> Result<Self, StoreError> {
        // One connection that stays: what it reads older layouts through is its own.
        let pool = SqlitePoolOptions::new().max_connections(1).idle_timeout(None).max_lifetime(None).connect_with(options(folder).read_only(true)).await?;
        layout::read_as_laid_out(&mut *pool.acquire().await?).await?;
        Ok(Self { pool, _lock: None })
    }

    /// A transaction that holds the write lock from its start, so that what it reads stays true until it commits.
    pub(super) async fn begin(&self) -> Result<Transaction<'static, Sqlite>, StoreError> {
        Ok(self.pool.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// True if nothing of a kind was ever saved.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn is_empty(&self, kind: Kind) -> Result<bool, StoreError> {
        let rows: i64 =
            sqlx::query_scalar("SELECT count(*) FROM (SELECT 1 FROM history WHERE kind = ? LIMIT 1)").bind(kind.noun()).fetch_one(&self.pool).await?;
        Ok(rows == 0)
    }

    /// Every present document of a kind, by name.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn documents(&self, kind: Kind) -> Result<Vec<StoredDocument>, StoreError> {
        let newest = "SELECT name, body FROM history h JOIN document USING (revision)
            WHERE kind = ? AND number = (SELECT max(number) FROM history WHERE kind = h.kind AND name = h.name) ORDER BY name";
        let rows = sqlx::query(newest).bind(kind.noun()).fetch_all(&self.pool).await?;
        rows.iter().map(|row| Ok(StoredDocument { name: row.try_get("name")?, body: row.try_get("body")? })).collect()
    }

    /// Appends a revision under a name; on return it is on disk.
    ///
    /// # Errors
    /// If the condition does not hold or the database fails; then nothing is stored.
    pub async fn save(&self, name: &str, content: impl Into<Content>, condition: &Condition) -> Result<Saved, StoreError> {
        self.save_with(name, content, Beside::default(), condition).await
    }

    /// As [`Store::save`], together with what the document names: all or nothing.
    ///
    /// # Errors
    /// As [`Store::save`].
    pub async fn save_with(&self, name: &str, content: impl Into<Content>, beside: Beside<'_>, condition: &Condition) -> Result<Saved, StoreError> {
        let content = content.into();
        let mut transaction = self.begin().await?;
        let (number, head) = head(&mut transaction, content.kind, name).await?;
        condition.check(content.kind, head.as_deref())?;
        if head.as_deref() == Some(content.revision.as_str()) {
            return Ok(Saved::Unchanged);
        }
        if let Some(set) = beside.set {
            feature_set::put(&mut transaction, set).await?;
        }
        generations::put(&mut transaction, beside.generations).await?;
        put(&mut transaction, name, number + 1, &content).await?;
        transaction.commit().await?;
        Ok(if head.is_none() { Saved::Created } else { Saved::Changed })
    }

    /// Saves what ships with the program under a name that was never used, or over what an earlier version shipped. What users saved or deleted under that name
    /// stays as they left it.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn ship(&self, name: &str, content: impl Into<Content>) -> Result<(), StoreError> {
        let content = content.into();
        let (kind, revision) = (content.kind, content.revision.as_str());
        let mut transaction = self.begin().await?;
        let (number, head) = head(&mut transaction, kind, name).await?;
        let last = sqlx::query_scalar("SELECT revision FROM shipped WHERE kind = ? AND name = ?");
        let last: Option<String> = last.bind(kind.noun()).bind(name).fetch_optional(&mut *transaction).await?;
        let untouched = if number == 0 { last.is_none() } else { head.is_some() && head == last };
        if !untouched || last.as_deref() == Some(revision) {
            return Ok(());
        }
        put(&mut transaction, name, number + 1, &content).await?;
        let record = sqlx::query("INSERT INTO shipped (kind, name, revision) VALUES (?, ?, ?) ON CONFLICT DO UPDATE SET revision = excluded.revision");
        record.bind(kind.noun()).bind(name).bind(revision).execute(&mut *transaction).await?;
        Ok(transaction.commit().await?)
    }

    /// Takes a name out of use; its history stays.
    ///
    /// # Errors
    /// If there is no such document, the condition does not hold, or the database fails.
    pub async fn delete(&self, kind: Kind, name: &str, condition: &Condition) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        let (number, head) = head(&mut transaction, kind, name).await?;
        if head.is_none() {
            return Err(StoreError::Unknown { kind, name: name.to_owned() });
        }
        condition.check(kind, head.as_deref())?;
        append(&mut transaction, kind, name, number + 1, None).await?;
        Ok(transaction.commit().await?)
    }

    /// Every saved revision of a name, newest last.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn revisions(&self, kind: Kind, name: &str) -> Result<Vec<RevisionEntry>, StoreError> {
        let saves = "SELECT number, time, revision FROM history WHERE kind = ? AND name = ? AND revision IS NOT NULL ORDER BY number";
        let rows = sqlx::query(saves).bind(kind.noun()).bind(name).fetch_all(&self.pool).await?;
        rows.iter().map(|row| Ok(RevisionEntry { number: row.try_get("number")?, time: row.try_get("time")?, revision: row.try_get("revision")? })).collect()
    }

    /// The document of one of a name's revisions.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn document(&self, kind: Kind, name: &str, revision: &Revision) -> Result<Option<String>, StoreError> {
        let body = "SELECT body FROM document JOIN history USING (revision) WHERE kind = ? AND name = ? AND revision = ? LIMIT 1";
        Ok(sqlx::query_scalar(body).bind(kind.noun()).bind(name).bind(revision.as_str()).fetch_optional(&self.pool).await?)
    }

    /// Closes the database; what was acknowledged is on disk with or without this.
    pub async fn close(&self) {
        self.pool.close().await;
    }
}

fn options(folder: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new().filename(folder.join("terrane.sqlite")).foreign_keys(true).busy_timeout(Duration::from_secs(5)).pragma("trusted_schema", "OFF")
}

/// The number of a name's last row and its present revision.
async fn head(transaction: &mut Transaction<'static, Sqlite>, kind: Kind, name: &str) -> Result<(i64, Option<String>), StoreError> {
    let last = "SELECT number, revision FROM history WHERE kind = ? AND name = ? ORDER BY number DESC LIMIT 1";
    match sqlx::query(last).bind(kind.noun()).bind(name).fetch_optional(&mut **transaction).await? {
        Some(row) => Ok((row.try_get("number")?, row.try_get("revision")?)),
        None => Ok((0, None)),
    }
}

/// Stores a document and makes it the present one of a name.
async fn put(transaction: &mut Transaction<'static, Sqlite>, name: &str, number: i64, content: &Content) -> Result<(), StoreError> {
    let insert = sqlx::query("INSERT INTO document (revision, body) VALUES (?, ?) ON CONFLICT DO NOTHING");
    insert.bind(content.revision.as_str()).bind(&content.body).execute(&mut **transaction).await?;
    append(transaction, content.kind, name, number, Some(&content.revision)).await
}

async fn append(transaction: &mut Transaction<'static, Sqlite>, kind: Kind, name: &str, number: i64, revision: Option<&Revision>) -> Result<(), StoreError> {
    let insert = sqlx::query("INSERT INTO history (kind, name, number, revision) VALUES (?, ?, ?, ?)");
    insert.bind(kind.noun()).bind(name).bind(number).bind(revision.map(Revision::as_str)).execute(&mut **transaction).await?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Document, Preset};

    fn document(seed: u64) -> Document {
        Document::parse(format!(r#"{{"seed":{seed},"base":{{"programme":"x","scale":1}}}}"#).as_bytes()).expect("valid")
    }

    #[tokio::test]
    async fn revisions_are_appended_and_survive_reopening() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(&folder.path().join("deep/data")).await.expect("opens");
        assert!(store.is_empty(Kind::World).await.expect("reads"));
        let (one, two) = (document(1), document(2));
        for (document, saved) in [(&one, Saved::Created), (&one, Saved::Unchanged), (&two, Saved::Changed), (&one, Saved::Changed)] {
            assert_eq!(store.save("a", document, &Condition::Any).await.expect("saves"), saved);
        }
        let reader = Store::open_read_only(&folder.path().join("deep/data")).await.expect("opens beside it");
        assert_eq!(reader.documents(Kind::World).await.expect("reads").len(), 1);
        assert!(matches!(Store::open(&folder.path().join("deep/data")).await, Err(StoreError::InUse(_))));
        store.close().await;
        drop(store);
        let store = Store::open(&folder.path().join("deep/data")).await.expect("reopens");
        let names: Vec<_> = store.revisions(Kind::World, "a").await.expect("reads").into_iter().map(|entry| (entry.number, entry.revision)).collect();
        let (first, second) = (one.revision().to_string(), two.revision().to_string());
        assert_eq!(names, [(1, first.clone()), (2, second), (3, first)]);
        assert_eq!(store.documents(Kind::World).await.expect("reads"), [StoredDocument { name: "a".into(), body: one.to_json() }]);
        assert_eq!(store.document(Kind::World, "a", &two.revision()).await.expect("reads"), Some(two.to_json()));
        assert_eq!(store.document(Kind::World, "b", &two.revision()).await.expect("reads"), None);
    }

    #[tokio::test]
    async fn conditions_are_checked_against_the_present_state() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        let at = |document: &Document| Condition::At(vec![document.revision().to_string()]);
        assert!(matches!(store.save("a", &document(1), &Condition::Present).await, Err(StoreError::Condition { revision: None, .. })));
        store.save("a", &document(1), &Condition::Absent).await.expect("absent");
        assert!(matches!(store.save("a", &document(2), &Condition::Absent).await, Err(StoreError::Condition { revision: Some(_), .. })));
        assert!(matches!(store.save("a", &document(2), &at(&document(3))).await, Err(StoreError::Condition { revision: Some(_), .. })));
        store.save("a", &document(2), &at(&document(1))).await.expect("at revision 1");
        assert!(matches!(store.delete(Kind::World, "a", &at(&document(1))).await, Err(StoreError::Condition { .. })));
        store.delete(Kind::World, "a", &at(&document(2))).await.expect("at revision 2");
        assert!(matches!(store.delete(Kind::World, "a", &Condition::Any).await, Err(StoreError::Unknown { .. })));
        assert!(store.documents(Kind::World).await.expect("reads").is_empty() && !store.is_empty(Kind::World).await.expect("reads"));
        assert_eq!(store.save("a", &document(2), &Condition::Absent).await.expect("again"), Saved::Created);
        assert_eq!(store.revisions(Kind::World, "a").await.expect("reads").last().map(|entry| entry.number), Some(4));
    }

    #[tokio::test]
    async fn a_newer_layout_is_left_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        sqlx::query("PRAGMA user_version = 99").execute(&store.pool).await.expect("sets");
        store.close().await;
        drop(store);
        assert!(matches!(Store::open(folder.path()).await, Err(StoreError::Newer { found: 99, known: layout::LAYOUT })));
    }

    fn preset(seed: u64) -> Preset {
        Preset::parse(format!(r#"{{"seed":{seed},"programme":"x"}}"#).as_bytes()).expect("valid")
    }

    #[tokio::test]
    async fn kinds_have_names_of_their_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        assert_eq!(store.save("a", &document(1), &Condition::Absent).await.expect("saves"), Saved::Created);
        assert!(store.is_empty(Kind::Programme).await.expect("reads"));
        assert_eq!(store.save("a", &preset(1), &Condition::Absent).await.expect("saves"), Saved::Created);
        store.delete(Kind::World, "a", &Condition::Any).await.expect("deletes");
        let left = store.documents(Kind::Programme).await.expect("reads");
        assert_eq!(left, [StoredDocument { name: "a".into(), body: preset(1).to_json() }]);
        assert!(store.documents(Kind::World).await.expect("reads").is_empty());
    }

    #[tokio::test]
    async fn a_folder_of_the_first_layout_opens_with_everything_in_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let options = options(folder.path()).create_if_missing(true).journal_mode(SqliteJournalMode::Wal);
        let old = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.expect("opens");
        layout::tests::lay_out_as(&mut old.acquire().await.expect("a connection"), 1).await;
        for (number, seed) in [(1, Some(1)), (2, None), (3, Some(2))] {
            let document = seed.map(document);
            if let Some(document) = &document {
                let insert = sqlx::query("INSERT INTO document (revision, body) VALUES (?, ?)");
                insert.bind(document.revision().to_string()).bind(document.to_json()).execute(&old).await.expect("writes");
            }
            let insert = sqlx::query("INSERT INTO history (world, number, time, revision) VALUES ('a', ?, 'then', ?)");
            insert.bind(number).bind(document.map(|document| document.revision().to_string())).execute(&old).await.expect("writes");
        }
        old.close().await;

        let expected = [StoredDocument { name: "a".into(), body: document(2).to_json() }];
        let reader = Store::open_read_only(folder.path()).await.expect("opens for reading as it is");
        assert_eq!(reader.documents(Kind::World).await.expect("reads"), expected);
        assert!(reader.documents(Kind::Programme).await.expect("reads").is_empty());
        reader.close().await;
        for _ in 0..2 {
            let store = Store::open(folder.path()).await.expect("opens");
            assert_eq!(store.documents(Kind::World).await.expect("reads"), expected);
            let history = store.revisions(Kind::World, "a").await.expect("reads");
            let entry = |number, seed| RevisionEntry { number, time: "then".into(), revision: document(seed).revision().to_string() };
            assert_eq!(history, [entry(1, 1), entry(3, 2)]);
            store.save("b", &preset(1), &Condition::Any).await.expect("takes what is new");
            store.close().await;
        }
    }

    #[tokio::test]
    async fn what_ships_reaches_old_stores_and_leaves_users_their_own() {
        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("opens");
        let seed = async |name: &str| {
            let all = store.documents(Kind::Programme).await.expect("reads");
            all.iter().find(|document| document.name == name).map(|document| Preset::parse(document.body.as_bytes()).expect("valid").seed)
        };
        store.save("own", &preset(50), &Condition::Any).await.expect("saves");
        // The first version ships 1, the second 2, the third 3.
        for version in 1..=3 {
            for name in ["plain", "edited", "deleted", "own"] {
                store.ship(name, &preset(version)).await.expect("ships");
                store.ship(name, &preset(version)).await.expect("a restart ships nothing new");
            }
            if version == 1 {
                store.save("edited", &preset(60), &Condition::Present).await.expect("edits");
                store.delete(Kind::Programme, "deleted", &Condition::Present).await.expect("deletes");
            }
        }
        assert_eq!((seed("plain").await, seed("edited").await, seed("deleted").await, seed("own").await), (Some(3), Some(60), None, Some(50)));
        assert_eq!(store.revisions(Kind::Programme, "plain").await.expect("reads").len(), 3);
    }
}
