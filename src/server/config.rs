//! Configuration: defaults, then a TOML file, then environment variables, then flags.

use serde::{Deserialize, Serialize};
use std::{net::SocketAddr, path::PathBuf};

/// Prefix of environment variables: `TERRANE_SERVER__LISTEN` is `listen` in `[server]`.
const PREFIX: &str = "TERRANE_";

/// What joins section and key in a variable's name. Variables without it are not ours, prefix or not: container platforms set `TERRANE_PORT` and the like.
const JOINT: &str = "__";

/// All configuration of `terrane serve`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Where to listen and where to keep data.
    pub server: ServerConfig,
    /// What is kept in memory.
    pub cache: CacheConfig,
    /// What one request may ask for.
    pub limits: LimitsConfig,
}

/// Where to listen and where to keep data.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ServerConfig {
    /// Address and port; port 0 takes a free one.
    pub listen: SocketAddr,
    /// The folder for worlds.
    pub data: PathBuf,
    /// Threads that evaluate tiles, 0 … 1024; 0 takes one a processor.
    pub threads: usize,
    /// The URL that clients reach the server by, base path included; empty: from each request's Host header.
    pub public_url: String,
    /// How many proxies stand before the server, 0 … 16: so many last addresses of `X-Forwarded-For` are believed.
    pub proxies: usize,
    /// Whether anybody may read, or only who has a key.
    pub reads: Reads,
    /// Seconds that requests under way get to finish after SIGTERM, 0 … 3600.
    pub drain_seconds: u64,
    /// Connections at a time, 1 … 1000000; others wait.
    pub connections: usize,
}

/// Who may read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reads {
    /// Anybody.
    #[default]
    Open,
    /// Who has a key.
    Keys,
}

/// What is kept in memory.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct CacheConfig {
    /// Bytes of encoded tiles.
    pub tile_bytes: u64,
    /// Bytes of encoded tiles on disk, in the folder of the worlds, 134217728 … 2^48; 0 is none. Needs the feature `disk`.
    pub disk_bytes: u64,
    /// Old revisions kept compiled, 1 … 100000.
    pub old_revisions: usize,
}

/// What one request may ask for.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LimitsConfig {
    /// Bytes of a world document, 1 … 16777216.
    pub world_bytes: usize,
    /// Bytes of features in one request, 1 … 536870912.
    pub feature_bytes: usize,
    /// Milliseconds that a tile may wait for a thread before it is refused with 503, 1 … 600000; the first 24 wait however long it takes.
    pub queue_ms: u64,
    /// Requests under way at a time, 1 … 1000000; others are refused with 503.
    pub requests: usize,
    /// Requests of one client in 10 s, 0 … 1000000; then it gets 429. 0 is without limit, as this machine is.
    pub client_requests: u64,
    /// Seconds of predicted evaluation of one client in 10 s, 0 … 100000; then it gets 429. 0 is without limit, as this machine is.
    pub client_seconds: u64,
    /// Samples of one export, 1 … 536870912; meshes have 2^22 at most.
    pub export_samples: u64,
    /// Seconds of predicted evaluation of one export on one thread, 1 … 86400.
    pub export_seconds: u64,
    /// Exports under way at a time, 1 … 1000; others are refused with 503.
    pub exports: usize,
    /// Jobs that wait at a time, 1 … 1000; others are refused with 503.
    pub jobs: usize,
    /// Seconds in which the whole head of a request must be there, also that of the next one on a connection, 1 … 3600.
    pub head_seconds: u64,
    /// Seconds in which a peer that is waited for must send or take 512 bytes a second, 1 … 3600.
    pub stall_seconds: u64,
}

impl Default for ServerConfig {
    fn default() -> Self {
        let listen = SocketAddr::from(([127, 0, 0, 1], 8080));
        Self {
            listen,
            data: "./data-store".into(),
            threads: 0,
            public_url: String::new(),
            proxies: 0,
            reads: Reads::Open,
            drain_seconds: 10,
            connections: 4096,
        }
    }
}

impl Default for CacheConfig {
    fn default() -> Self {
        Self { tile_bytes: 268_435_456, disk_bytes: 0, old_revisions: 256 }
    }
}

impl Default for LimitsConfig {
    fn default() -> Self {
        Self {
            world_bytes: 1_048_576,
            feature_bytes: 536_870_912,
            queue_ms: 250,
            requests: 1024,
            client_requests: 2000,
            client_seconds: 20,
            export_samples: 268_435_456,
            export_seconds: 600,
            exports: 4,
            jobs: 64,
            head_seconds: 20,
            stall_seconds: 20,
        }
    }
}

/// Why a configuration cannot be used; every problem found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("configuration:\n  {}", .0.join("\n  "))]
pub struct ConfigError(pub Vec<String>);

impl Config {
    /// Reads configuration from TOML text (a file's, or none) and environment variables.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown, or a value is of the wrong type or out of range.
    pub fn load(toml: &str, environment: impl Iterator<Item = (String, String)>) -> Result<Self, ConfigError> {
        let mut table: toml::Table = toml.parse().map_err(|error: toml::de::Error| ConfigError(vec![error.to_string().trim_end().to_owned()]))?;
        let mut problems = Vec::new();
        for (name, value) in environment {
            if let Some(path) = name.strip_prefix(PREFIX).filter(|path| path.contains(JOINT))
                && let Err(problem) = overlay(&mut table, &name, path, &value)
            {
                problems.push(problem);
            }
        }
        match serde_path_to_error::deserialize::<_, Config>(table) {
            Ok(config) => {
                problems.extend(config.problems());
                if problems.is_empty() { Ok(config) } else { Err(ConfigError(problems)) }
            }
            Err(error) => {
                problems.push(format!("{}: {}", error.path(), error.inner().message()));
                Err(ConfigError(problems))
            }
        }
    }

    /// Checks every value's range.
    ///
    /// # Errors
    /// If a value is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let problems = self.problems();
        if problems.is_empty() { Ok(()) } else { Err(ConfigError(problems)) }
    }

    fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let mut range = |key: &str, value: u64, min: u64, max: u64| {
            if !(min..=max).contains(&value) {
                problems.push(format!("{key}: must be {min} … {max}, got {value}"));
            }
        };
        range("server.threads", self.server.threads as u64, 0, 1024);
        range("server.drain_seconds", self.server.drain_seconds, 0, 3600);
        range("cache.old_revisions", self.cache.old_revisions as u64, 1, 100_000);
        range("limits.world_bytes", self.limits.world_bytes as u64, 1, 16_777_216);
        range("limits.feature_bytes", self.limits.feature_bytes as u64, 1, 536_870_912);
        range("limits.queue_ms", self.limits.queue_ms, 1, 600_000);
        range("server.connections", self.server.connections as u64, 1, 1_000_000);
        range("limits.requests", self.limits.requests as u64, 1, 1_000_000);
        range("limits.export_samples", self.limits.export_samples, 1, 536_870_912);
        range("limits.export_seconds", self.limits.export_seconds, 1, 86_400);
        range("limits.exports", self.limits.exports as u64, 1, 1_000);
        range("limits.jobs", self.limits.jobs as u64, 1, 1_000);
        range("limits.client_requests", self.limits.client_requests, 0, 1_000_000);
        range("limits.client_seconds", self.limits.client_seconds, 0, 100_000);
        range("server.proxies", self.server.proxies as u64, 0, 16);
        range("limits.head_seconds", self.limits.head_seconds, 1, 3600);
        range("limits.stall_seconds", self.limits.stall_seconds, 1, 3600);
        if self.cache.disk_bytes > 0 {
            range("cache.disk_bytes", self.cache.disk_bytes, 134_217_728, 1 << 48);
        }
        let url = &self.server.public_url;
        if !(url.is_empty() || url.parse::<axum::http::Uri>().is_ok_and(|uri| uri.host().is_some() && matches!(uri.scheme_str(), Some("http" | "https")))) {
            problems.push(format!("server.public_url: must be an http or https URL, got {url:?}"));
        }
        problems
    }
}

/// Puts an environment variable's value into the table.
fn overlay(table: &mut toml::Table, name: &str, path: &str, value: &str) -> Result<(), String> {
    let path = path.to_lowercase();
    let known = toml::Table::try_from(Config::default()).unwrap_or_default();
    let (section, key) = path.split_once(JOINT).unwrap_or((&path, ""));
    let Some(default) = known.get(section).and_then(|section| section.get(key)) else { return Err(format!("{name}: there is no key {key} in [{section}]")) };
    let parsed = match default {
        toml::Value::Integer(_) => {
            value.parse().map(toml::Value::Integer).map_err(|error| format!("{name}: must be a whole number, got {value:?} ({error})"))?
        }
        _ => toml::Value::String(value.to_owned()),
    };
    let section = table.entry(section).or_insert_with(|| toml::Value::Table(toml::Table::new()));
    if let toml::Value::Table(section) = section {
        section.insert(key.to_owned(), parsed);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(toml: &str, environment: &[(&str, &str)], expected: &str) {
        let environment = environment.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        let got =
            Config::load(toml, environment).map_or_else(|error| error.to_string(), |config| format!("{} {}", config.server.listen, config.cache.tile_bytes));
        assert_eq!(got, expected);
    }

    #[test]
    fn the_file_in_the_repository_holds_the_defaults() {
        let shipped = include_str!("../../config/terrane.toml");
        assert_eq!(Config::load(shipped, std::iter::empty()).expect("valid"), Config::default());
        let named: toml::Table = shipped.parse().expect("TOML");
        assert_eq!(named, toml::Table::try_from(Config::default()).expect("a table"), "every key stands in the file");
    }

    #[test]
    fn the_environment_comes_over_the_file() {
        check("", &[("HOME", "/"), ("TERRANE_LOG", "debug"), ("TERRANE_PORT", "tcp://10.0.0.1:80")], "127.0.0.1:8080 268435456");
        check("[server]\nlisten = \"127.0.0.1:1\"", &[("TERRANE_SERVER__LISTEN", "0.0.0.0:99"), ("TERRANE_CACHE__TILE_BYTES", "5")], "0.0.0.0:99 5");
    }

    #[test]
    fn what_is_wrong_is_named() {
        check(
            "[server]\nlistn = 1",
            &[],
            "configuration:\n  server.listn: unknown field `listn`, expected one of `listen`, `data`, `threads`, `public_url`, `proxies`, `reads`, `drain_seconds`, `connections`",
        );
        check(
            "[server]\nthreads = 5000\npublic_url = \"ftp://x\"\n[limits]\nworld_bytes = 0",
            &[("TERRANE_SERVER__PORT", "1")],
            "configuration:\n  TERRANE_SERVER__PORT: there is no key port in [server]\n  server.threads: must be 0 … 1024, got 5000\n  limits.world_bytes: must be 1 … 16777216, got 0\n  server.public_url: must be an http or https URL, got \"ftp://x\"",
        );
        check(
            "",
            &[("TERRANE_CACHES__TILE_BYTES", "1"), ("TERRANE_CACHE__TILE_BYTES", "many")],
            "configuration:\n  TERRANE_CACHES__TILE_BYTES: there is no key tile_bytes in [caches]\n  TERRANE_CACHE__TILE_BYTES: must be a whole number, got \"many\" (invalid digit found in string)",
        );
        assert!(Config::load("[server", std::iter::empty()).is_err());
    }
}
