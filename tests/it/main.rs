//! Tests of the whole: HTTP without sockets, the real program, golden tiles, the house.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test says what is wrong by failing")]

mod bombs;
mod breeding;
mod client;
mod clients;
mod corpus;
mod costs;
mod determinism;
mod encoding;
mod events;
mod evolution;
mod export;
mod features;
mod formats;
mod golden;
mod grow;
mod hostile;
mod http;
mod jobs;
mod keys;
mod layers;
mod levels;
mod library;
mod load;
mod mesh;
mod openapi;
mod paths;
mod process;
mod program;
mod properties;
mod pyramid;
mod roads;
mod shader;
mod tidy;
mod writes;
