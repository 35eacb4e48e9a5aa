//! The programme library of a server.

use super::{
    compute::Compute,
    events::Events,
    parts::StoredParts,
    shelf::{LoadError, Shelf, Shelved, shipped},
    state::App,
};
use crate::{
    geometry::{Stop, Until},
    store::{Content, Kind, Store},
    tile::{self, PREVIEW_FORM, TileError},
    world::{DocumentError, Fingerprint, PRESETS, PartNames, Parts, Preset, Revision, Survey, World},
};
use std::sync::Arc;

/// A programme of the library, ready to be shown.
pub(super) struct Shown {
    name: String,
    preset: Preset,
    revision: Revision,
    /// The world that shows it.
    world: World,
}

impl Shelved for Shown {
    const KIND: Kind = Kind::Programme;
    const PATH: &'static str = "programmes";
    type Document = Preset;

    fn parse(json: &[u8], _: &Parts) -> Result<Preset, DocumentError> {
        Preset::parse(json)
    }

    fn parse_stored(json: &[u8], _: &Parts) -> Result<Preset, DocumentError> {
        Preset::parse_stored(json)
    }

    fn named_in(_: &[u8]) -> PartNames {
        PartNames::default()
    }

    fn content(preset: &Preset) -> Content {
        preset.into()
    }

    fn title_of(preset: &Preset) -> Option<&str> {
        preset.title.as_deref()
    }

    fn new(name: &str, preset: Preset) -> Self {
        Self { name: name.to_owned(), revision: preset.revision(), world: World::new(preset.document()), preset }
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn document(&self) -> &Preset {
        &self.preset
    }

    fn revision(&self) -> &Revision {
        &self.revision
    }

    fn shelf(app: &App) -> &Shelf<Self> {
        &app.0.library
    }
}

impl Shown {
    /// The identity of its picture's bytes.
    pub(super) fn preview_fingerprint(&self, pixels: usize) -> Fingerprint {
        self.world.view_fingerprint(PREVIEW_FORM, pixels)
    }

    /// Predicted nanoseconds that its picture takes.
    pub(super) fn preview_cost_ns(&self, pixels: usize) -> f64 {
        Survey::cost_ns(&self.world, pixels)
    }

    /// Its picture: the place that shows most relief, on the calling thread.
    pub(super) fn preview(&self, pixels: usize, stop: &Stop) -> Result<Vec<u8>, TileError> {
        let window = Survey::of(&self.world).window(pixels);
        tile::preview(&Until { source: &self.world, stop: stop.clone() }, &window, self.preset.sea_level)
    }
}

/// Loads the library; what ships with this version and was never there comes first.
pub(super) async fn load(store: Store, compute: Arc<Compute>, parts: Arc<StoredParts>, events: &Arc<Events>) -> Result<Shelf<Shown>, LoadError> {
    for preset in PRESETS {
        store.ship(preset.name, shipped::<Shown>(&compute, preset.name, preset.json).await?.0).await?;
    }
    Shelf::load(store, compute, parts, events).await
}
