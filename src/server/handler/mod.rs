//! The handlers: extract, one call, answer.

pub(super) mod accessibility;
pub(super) mod adaptive;
pub(super) mod breeding;
pub(super) mod catalog;
pub(super) mod description;
mod document;
pub(super) mod elevation;
pub(super) mod event;
pub(super) mod evolution;
pub(super) mod export;
pub(super) mod feature;
pub(super) mod feature_edit;
pub(super) mod health;
pub(super) mod job;
pub(super) mod layer;
pub(super) mod programme;
pub(super) mod raster;
pub(super) mod shader;
pub(super) mod tile;
pub(super) mod viewer;
pub(super) mod world;
