//! Sets of features: each part and each set once, under the name of its content.

use super::{Store, StoreError};
use crate::layout::geojson::StoredSet;
use sqlx::{Row, Sqlite, Transaction};

/// Stores a set; what is there already stays.
pub(super) async fn put(transaction: &mut Transaction<'static, Sqlite>, set: &StoredSet) -> Result<(), StoreError> {
    let insert = sqlx::query("INSERT INTO feature_set (name, attributes) VALUES (?, ?) ON CONFLICT DO NOTHING");
    let made = insert.bind(&set.name).bind(&set.attributes).execute(&mut **transaction).await?;
    if made.rows_affected() == 0 {
        return Ok(());
    }
    for ((name, body), number) in set.parts.iter().zip(0_i64..) {
        let insert = sqlx::query("INSERT INTO feature_part (name, body) VALUES (?, ?) ON CONFLICT DO NOTHING");
        insert.bind(name).bind(body).execute(&mut **transaction).await?;
        let insert = sqlx::query("INSERT INTO feature_set_part (feature_set, number, part) VALUES (?, ?, ?)");
        insert.bind(&set.name).bind(number).bind(name).execute(&mut **transaction).await?;
    }
    Ok(())
}

impl Store {
    /// The stored set of features of a name.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn feature_set(&self, name: &str) -> Result<Option<StoredSet>, StoreError> {
        let attributes: Option<String> = sqlx::query_scalar("SELECT attributes FROM feature_set WHERE name = ?").bind(name).fetch_optional(&self.pool).await?;
        let Some(attributes) = attributes else { return Ok(None) };
        let parts = "SELECT name, body FROM feature_set_part JOIN feature_part ON part = name WHERE feature_set = ? ORDER BY number";
        let rows = sqlx::query(parts).bind(name).fetch_all(&self.pool).await?;
        let parts: Result<_, sqlx::Error> = rows.iter().map(|row| Ok((row.try_get("name")?, row.try_get("body")?))).collect();
        Ok(Some(StoredSet { name: name.to_owned(), attributes, parts: parts? }))
    }
}
