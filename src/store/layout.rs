//! The tables, and how those of older versions become those of this one.

use super::StoreError;
use sqlx::{Executor, Sqlite, SqliteConnection, SqlitePool};

/// The layout of the tables, kept in `PRAGMA user_version`: how many of the steps below were done.
pub(super) const LAYOUT: i64 = STEPS.len() as i64;

/// From each layout to the next. Append-only, as the tables are: a document is stored once under its content's name, and every save or deletion of a name is a
/// row; a deletion has no revision.
const STEPS: [&str; 7] = [
    "
    CREATE TABLE document (revision TEXT PRIMARY KEY, body TEXT NOT NULL) STRICT;
    CREATE TABLE history (
        world TEXT NOT NULL,
        number INTEGER NOT NULL,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        revision TEXT REFERENCES document (revision),
        PRIMARY KEY (world, number)
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 1;
    ",
    // Worlds are no longer the only documents; what was shipped is remembered, so that later versions can tell it from what users made of it.
    "
    ALTER TABLE history RENAME TO history_1;
    CREATE TABLE history (
        kind TEXT NOT NULL,
        name TEXT NOT NULL,
        number INTEGER NOT NULL,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        revision TEXT REFERENCES document (revision),
        PRIMARY KEY (kind, name, number)
    ) STRICT, WITHOUT ROWID;
    INSERT INTO history (kind, name, number, time, revision) SELECT 'world', world, number, time, revision FROM history_1;
    DROP TABLE history_1;
    CREATE TABLE shipped (
        kind TEXT NOT NULL,
        name TEXT NOT NULL,
        revision TEXT NOT NULL REFERENCES document (revision),
        PRIMARY KEY (kind, name)
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 2;
    ",
    // Sets of features, which documents name by content. A set is a list of parts, so that what an edit leaves alone is not stored again.
    "
    CREATE TABLE feature_part (name TEXT PRIMARY KEY, body TEXT NOT NULL) STRICT;
    CREATE TABLE feature_set (name TEXT PRIMARY KEY, attributes TEXT NOT NULL) STRICT;
    CREATE TABLE feature_set_part (
        feature_set TEXT NOT NULL REFERENCES feature_set (name),
        number INTEGER NOT NULL,
        part TEXT NOT NULL REFERENCES feature_part (name),
        PRIMARY KEY (feature_set, number)
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 3;
    ",
    "
    CREATE TABLE key (
        id TEXT PRIMARY KEY,
        name TEXT NOT NULL,
        scope TEXT NOT NULL,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        hash TEXT NOT NULL UNIQUE
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 4;
    ",
    // Rasters under the name of their content, and the jobs that make them under the name of what is asked for.
    "
    CREATE TABLE raster (
        name TEXT PRIMARY KEY,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        head TEXT NOT NULL,
        samples BLOB NOT NULL
    ) STRICT;
    CREATE TABLE job (
        number INTEGER PRIMARY KEY,
        id TEXT NOT NULL UNIQUE,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        work TEXT NOT NULL,
        state TEXT NOT NULL,
        raster TEXT REFERENCES raster (name),
        failure TEXT
    ) STRICT;
    PRAGMA user_version = 5;
    ",
    // Generations of adaptive terrain under the name of what they follow from: of a first one `said` is the ground, of others the feedback; some with all that the next is
    // bred of.
    "
    CREATE TABLE generation (
        hash TEXT PRIMARY KEY,
        number INTEGER NOT NULL,
        parent TEXT REFERENCES generation (hash),
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        said TEXT NOT NULL,
        deviation REAL,
        state BLOB
    ) STRICT;
    PRAGMA user_version = 6;
    ",
    // What jobs of many steps go on from, replaced at every step, and their history, which stays.
    "
    CREATE TABLE job_checkpoint (
        job TEXT PRIMARY KEY REFERENCES job (id) ON DELETE CASCADE,
        step INTEGER NOT NULL,
        steps INTEGER NOT NULL,
        found TEXT NOT NULL,
        state BLOB NOT NULL
    ) STRICT;
    CREATE TABLE job_step (
        job TEXT NOT NULL REFERENCES job (id) ON DELETE CASCADE,
        number INTEGER NOT NULL,
        line TEXT NOT NULL,
        PRIMARY KEY (job, number)
    ) STRICT, WITHOUT ROWID;
    PRAGMA user_version = 7;
    ",
];

/// What lets a connection that may not write read layout 1 as this one.
const READ_LAYOUT_1: &str = "CREATE TEMP VIEW history AS SELECT 'world' AS kind, world AS name, number, time, revision FROM main.history";

/// What lets it read layouts before the third: there are no sets of features.
const READ_LAYOUT_2: &str = "
    CREATE TEMP TABLE feature_set (name TEXT, attributes TEXT);
    CREATE TEMP TABLE feature_set_part (feature_set TEXT, number INTEGER, part TEXT);
    CREATE TEMP TABLE feature_part (name TEXT, body TEXT);
";

/// What lets it read layouts before the fifth: there are no rasters.
const READ_LAYOUT_4: &str = "CREATE TEMP TABLE raster (name TEXT, time TEXT, head TEXT, samples BLOB)";

/// What lets it read layouts before the sixth: nothing evolves.
const READ_LAYOUT_5: &str = "CREATE TEMP TABLE generation (hash TEXT, number INTEGER, parent TEXT, time TEXT, said TEXT, deviation REAL, state BLOB)";

async fn found(connection: impl Executor<'_, Database = Sqlite>) -> Result<i64, StoreError> {
    let found = sqlx::query_scalar("PRAGMA user_version").fetch_one(connection).await?;
    if (0..=LAYOUT).contains(&found) { Ok(found) } else { Err(StoreError::Newer { found, known: LAYOUT }) }
}

/// Brings the tables to this version's layout, inside a transaction.
pub(super) async fn lay_out(transaction: &mut SqliteConnection) -> Result<(), StoreError> {
    let found = found(&mut *transaction).await?;
    for step in &STEPS[found as usize..] {
        sqlx::raw_sql(*step).execute(&mut *transaction).await?;
    }
    Ok(())
}

/// Whether the tables are of this version's layout.
pub(super) async fn check_current(pool: &SqlitePool) -> Result<(), StoreError> {
    let found = found(pool).await?;
    if found == LAYOUT { Ok(()) } else { Err(StoreError::Older { found, known: LAYOUT }) }
}

/// Lets a connection that may not write read tables of this version's layout or of an older one.
pub(super) async fn read_as_laid_out(connection: &mut SqliteConnection) -> Result<(), StoreError> {
    let found = found(&mut *connection).await?;
    if found == 1 {
        sqlx::raw_sql(READ_LAYOUT_1).execute(&mut *connection).await?;
    }
    if found < 3 {
        sqlx::raw_sql(READ_LAYOUT_2).execute(&mut *connection).await?;
    }
    if found < 5 {
        sqlx::raw_sql(READ_LAYOUT_4).execute(&mut *connection).await?;
    }
    if found < 6 {
        sqlx::raw_sql(READ_LAYOUT_5).execute(connection).await?;
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Makes the tables of an older version.
    pub(in crate::store) async fn lay_out_as(connection: &mut SqliteConnection, layout: usize) {
        for step in &STEPS[..layout] {
            sqlx::raw_sql(*step).execute(&mut *connection).await.expect("laid out");
        }
    }
}
