//! Keys: who may read and write. Only their hashes are kept.

use super::{Store, StoreError};
use hmac::{Hmac, KeyInit, Mac};
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
    /// Play: say where one is, and give feedback to ground that evolves.
    Play,
    /// Save, change and delete worlds, features and programmes.
    Write,
    /// See how the server does.
    Admin,
}

impl Scope {
    const ALL: [Self; 4] = [Self::Read, Self::Play, Self::Write, Self::Admin];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Play => "play",
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
        Self::ALL.into_iter().find(|scope| scope.name() == text).ok_or_else(|| format!("must be read, play, write or admin, got {text:?}"))
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

/// What a signature is taken of: the world's name and the seconds since 1970-01-01 UTC until which it holds.
fn signed(hash: &str, world: &str, expires: u64) -> Hmac<Sha256> {
    let mac = Hmac::<Sha256>::new_from_slice(hash.as_bytes());
    mac.expect("keys of every length do").chain_update(format!("{world}\n{expires}"))
}

/// The signature, in hex digits, with which everything under a world can be read without a key until a time: HMAC-SHA256 (RFC 2104) of `"{world}\n{expires}"`,
/// its key the hash of a key's secret as hex digits.
#[must_use]
pub fn sign(hash: &str, world: &str, expires: u64) -> String {
    signed(hash, world, expires).finalize().into_bytes().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Whether a text is that signature; how long that takes does not tell where it differs.
#[must_use]
pub fn is_signature(hash: &str, world: &str, expires: u64, text: &str) -> bool {
    let digits: Option<Vec<u32>> = text.chars().map(|digit| digit.to_digit(16)).collect();
    let bytes: Vec<u8> = digits.unwrap_or_default().chunks(2).map(|pair| pair.iter().fold(0, |byte, digit| byte << 4 | *digit as u8)).collect();
    text.len() == 64 && signed(hash, world, expires).verify_slice(&bytes).is_ok()
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
