//! The world that a command is about.

use super::{config, runtime};
use anyhow::{Context, bail};
use std::{fs, path::Path, sync::Arc};
use terrane::{
    layout::geojson::FeatureSet,
    store::{Kind, Store},
    world::{Document, PartNames, Parts, World},
};

/// A document of JSON that has a name for people.
pub(crate) fn parse(json: &[u8], name: &str) -> anyhow::Result<Document> {
    Document::parse(json).map_err(|error| anyhow::anyhow!("{name}:\n  {}", error.to_string().replace('\n', "\n  ")))
}

/// The document of a file, or of a stored world.
pub(crate) fn world(name: &str, data: Option<&Path>) -> anyhow::Result<World> {
    if Path::new(name).is_file() {
        let json = fs::read(name).with_context(|| format!("reading {name}"))?;
        return Ok(World::new(parse(&json, name)?));
    }
    let folder = data.map_or_else(|| config(None).map(|config| config.server.data), |data| Ok(data.to_path_buf()))?;
    if !folder.join("terrane.sqlite").is_file() {
        bail!("there is no file {name}, and no worlds are stored in {}", folder.display());
    }
    let runtime = runtime()?;
    let store = runtime.block_on(Store::open_read_only(&folder))?;
    let worlds = runtime.block_on(store.documents(Kind::World))?;
    let names: Vec<_> = worlds.iter().map(|world| world.name.as_str()).collect();
    let Some(stored) = worlds.iter().find(|world| world.name == name) else {
        bail!("{name} is neither a file nor one of the worlds in {}: {}", folder.display(), names.join(", "));
    };
    let (mut parts, names) = (Parts::default(), PartNames::in_world(stored.body.as_bytes()));
    for name in names.sets {
        if let Some(stored) = runtime.block_on(store.feature_set(&name))? {
            parts.insert_set(name, Arc::new(FeatureSet::read(&stored)?));
        }
    }
    for name in names.rasters {
        if let Some(stored) = runtime.block_on(store.raster(&name))? {
            let raster = stored.read().with_context(|| format!("the stored raster {name}"))?;
            parts.insert_raster(name, Arc::new(raster));
        }
    }
    for hash in names.generations {
        if let Some(stored) = runtime.block_on(store.generation(&hash))? {
            parts.insert_generation(Arc::new(stored.read().with_context(|| format!("the stored generation {hash}"))?));
        }
    }
    Ok(World::new(Document::parse_stored(stored.body.as_bytes(), &parts).with_context(|| format!("the stored world {name}"))?))
}
