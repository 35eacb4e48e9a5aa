//! Archives of tiles that are `SQLite` files: `MBTiles` 1.3.

use super::StoreError;
use sqlx::{
    ConnectOptions, Connection, SqliteConnection,
    sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous},
};
use std::path::Path;
use tokio::runtime::{Builder, Runtime};

/// What tells tools that such a file is one: "MPBX".
const APPLICATION: i64 = 0x4d50_4258;

/// An archive that is written once, tile by tile; it is of no use before it is finished. It waits for its database, so it must not be used on tokio's threads.
#[derive(Debug)]
pub struct MbTiles {
    runtime: Runtime,
    connection: SqliteConnection,
}

impl MbTiles {
    /// Begins an archive, of which the file must not be there, with names and values of its metadata.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create(path: &Path, metadata: &[(&str, String)]) -> Result<Self, StoreError> {
        let runtime = Builder::new_current_thread().build().map_err(StoreError::Archive)?;
        // A file that is not finished is thrown away, so nothing needs to be rolled back or synced before its end.
        let options = SqliteConnectOptions::new().filename(path).create_if_missing(true).page_size(4096).journal_mode(SqliteJournalMode::Off);
        let connection = runtime.block_on(async {
            let mut connection = options.synchronous(SqliteSynchronous::Off).connect().await?;
            for statement in [
                &format!("PRAGMA application_id = {APPLICATION}"),
                "BEGIN EXCLUSIVE",
                "CREATE TABLE metadata (name TEXT, value TEXT)",
                "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB)",
            ] {
                sqlx::query(sqlx::AssertSqlSafe(statement.to_owned())).execute(&mut connection).await?;
            }
            for (name, value) in metadata {
                sqlx::query("INSERT INTO metadata (name, value) VALUES (?, ?)").bind(*name).bind(value).execute(&mut connection).await?;
            }
            Ok::<_, sqlx::Error>(connection)
        })?;
        Ok(Self { runtime, connection })
    }

    /// Adds a tile; rows count from the north. The file's bytes follow from the order of tiles.
    ///
    /// # Errors
    /// If the database fails, as it does where the disk is full.
    pub fn put(&mut self, z: u8, x: u32, y: u32, tile: &[u8]) -> Result<(), StoreError> {
        // Rows of the format count from the south.
        let row = (1_i64 << z) - 1 - i64::from(y);
        let insert = sqlx::query("INSERT INTO tiles (zoom_level, tile_column, tile_row, tile_data) VALUES (?, ?, ?, ?)").bind(z).bind(x).bind(row).bind(tile);
        self.runtime.block_on(insert.execute(&mut self.connection))?;
        Ok(())
    }

    /// Makes the index and ends the archive.
    ///
    /// # Errors
    /// As [`MbTiles::put`].
    pub fn finish(mut self) -> Result<(), StoreError> {
        self.runtime.block_on(async {
            for statement in ["CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row)", "COMMIT"] {
                sqlx::query(statement).execute(&mut self.connection).await?;
            }
            self.connection.close().await
        })?;
        Ok(())
    }
}
