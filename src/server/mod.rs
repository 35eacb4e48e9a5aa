//! HTTP: parse, call, answer.

mod access;
mod address;
mod compute;
mod config;
mod connections;
mod editing;
mod embedded;
mod error;
mod exports;
mod extract;
mod features;
mod handler;
mod headers;
mod library;
mod metrics;
mod observe;
mod pace;
mod router;
mod schema;
mod search;
mod serve;
mod sets;
mod shelf;
mod sidecar;
mod state;
mod style;
mod tilejson;
mod tiles;
mod upload;
mod vocabulary;
mod wmts;
mod worlds;

pub use config::{CacheConfig, Config, ConfigError, LimitsConfig, Reads, ServerConfig};
pub use router::{openapi, router};
pub use serve::{serve, stop_signal};
pub use state::App;
