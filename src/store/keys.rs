//! Keys: who may read and write. Only their hashes are kept.

use super::{Store, StoreError};
use sha2::{Digest, Sha256};
use sqlx::Row;
use std::{fmt, str::FromStr};

/// What secrets begin with, so that tools that look for leaked ones find them.
const PREFIX: &str = "terrane_";

/// Random bytes of a secret: no list of hashes helps to guess it, so that one round of SHA-256 is enough to keep it.
const SECRET_BYTES: usize = 32;

/// What the holder of a key may do; each scope holds those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// Read what there is.
    Read,
    /// Save, change and delete worlds, features and programmes.
    Write,
    /// See how the server does.
    Admin,
}

impl Scope {
    const ALL: [Self; 3] = [Self::Read, Self::Write, Self::Admin];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Write => "write",
            Self::Admin => "admin",
        }
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Scope {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|scope| scope.name() == text).ok_or_else(|| format!("must be read, write or admin, got {text:?}"))
    }
}

/// A key without its secret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyEntry {
    /// What it is called when it is taken back: the first 8 hex digits of its hash.
    pub id: String,
    /// Whose it is.
    pub name: String,
    /// What it is for.
    pub scope: Scope,
    /// When it was made, RFC 3339, UTC.
    pub time: String,
    /// SHA-256 of its secret, in hex digits.
    pub hash: String,
}

/// SHA-256 of a secret, in hex digits.
#[must_use]
pub fn hash_of(secret: &str) -> String {
    Sha256::digest(secret).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Store {
    /// Makes a key and answers its secret, which is kept nowhere.
    ///
    /// # Errors
    /// If the system gives no random bytes or the database fails.
    pub async fn add_key(&self, name: &str, scope: Scope) -> Result<(KeyEntry, String), StoreError> {
        let mut bytes = [0; SECRET_BYTES];
        getrandom::fill(&mut bytes).map_err(|error| StoreError::Random(error.to_string()))?;
        let secret: String = PREFIX.chars().chain(bytes.iter().flat_map(|byte| format!("{byte:02x}").into_bytes()).map(char::from)).collect();
        let (hash, mut transaction) = (hash_of(&secret), self.begin().await?);
        let insert = sqlx::query_scalar("INSERT INTO key (id, name, scope, hash) VALUES (?, ?, ?, ?) RETURNING time");
        let time: String = insert.bind(&hash[..8]).bind(name).bind(scope.name()).bind(&hash).fetch_one(&mut *transaction).await?;
        transaction.commit().await?;
        Ok((KeyEntry { id: hash[..8].to_owned(), name: name.to_owned(), scope, time, hash }, secret))
    }

    /// Every key, oldest first.
    ///
    /// # Errors
    /// If the database fails.
    pub async fn keys(&self) -> Result<Vec<KeyEntry>, StoreError> {
        let rows = sqlx::query("SELECT id, name, scope, time, hash FROM key ORDER BY time, id").fetch_all(&self.pool).await?;
        let entry = |row: &sqlx::sqlite::SqliteRow| {
            let scope: String = row.try_get("scope")?;
            let scope = scope.parse().map_err(|error: String| sqlx::Error::Decode(error.into()))?;
            Ok(KeyEntry { id: row.try_get("id")?, name: row.try_get("name")?, scope, time: row.try_get("time")?, hash: row.try_get("hash")? })
        };
        rows.iter().map(entry).collect()
    }

    /// Takes a key back.
    ///
    /// # Errors
    /// If there is no such key or the database fails.
    pub async fn revoke_key(&self, id: &str) -> Result<(), StoreError> {
        let mut transaction = self.begin().await?;
        let deleted = sqlx::query("DELETE FROM key WHERE id = ?").bind(id).execute(&mut *transaction).await?.rows_affected();
        if deleted == 0 {
            return Err(StoreError::UnknownKey(id.to_owned()));
        }
        Ok(transaction.commit().await?)
    }
}
