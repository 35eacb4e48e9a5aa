//! The built viewer; nothing but a marker where it was not built.

/// Files of `web/dist`.
#[derive(rust_embed::RustEmbed)]
#[folder = "web/dist"]
pub(super) struct Viewer;
