//! Tiles on disk, so that they outlive the process and may be more than memory holds.

use crate::world::Fingerprint;
use axum::body::Bytes;
use std::path::Path;

/// Why the disk cannot hold tiles.
#[derive(Debug, thiserror::Error)]
pub enum DiskError {
    /// The program was built without it.
    #[error("cache.disk_bytes is set, but this terrane was built without the feature `disk` (cargo build --release --features disk)")]
    Absent,
    /// The folder or the files cannot be used.
    #[error("the disk cache in {folder}: {message}")]
    Unusable {
        /// Where it is.
        folder: String,
        /// What is wrong.
        message: String,
    },
}

#[cfg(not(feature = "disk"))]
pub(super) enum Disk {}

#[cfg(not(feature = "disk"))]
impl Disk {
    #[expect(clippy::unused_async, reason = "the other one waits")]
    pub(super) async fn open(_: &Path, _: u64) -> Result<Self, DiskError> {
        Err(DiskError::Absent)
    }

    #[expect(clippy::unused_async, reason = "the other one waits")]
    pub(super) async fn get(&self, _: &Fingerprint) -> Option<Bytes> {
        match *self {}
    }

    pub(super) fn put(&self, _: &Fingerprint, _: Bytes) {
        match *self {}
    }

    #[expect(clippy::unused_async, reason = "the other one waits")]
    pub(super) async fn close(&self) {
        match *self {}
    }
}

#[cfg(feature = "disk")]
pub(super) use with_foyer::Disk;

#[cfg(feature = "disk")]
mod with_foyer {
    use super::{Bytes, DiskError, Fingerprint, Path};
    use foyer::{BlockEngineConfig, DeviceBuilder, FsDeviceBuilder, HybridCache, HybridCacheBuilder, Load, RecoverMode};
    use std::{
        fs,
        path::PathBuf,
        sync::atomic::{AtomicBool, AtomicU64, Ordering},
    };

    /// Bytes of memory for what foyer keeps beside the disk; tiles in memory are kept before it.
    const MEMORY: usize = 1 << 20;

    /// Bytes of the disk that are left to others.
    const FLOOR: u64 = 1 << 26;

    /// Tiles between two looks at how full the disk is; those of usual sizes stay below the floor.
    const LOOK: u64 = 256;

    /// Tiles in files of a fixed size altogether, each with a checksum: what was damaged is not found.
    pub(in super::super) struct Disk {
        cache: HybridCache<u128, Bytes>,
        folder: PathBuf,
        count: AtomicU64,
        has_room: AtomicBool,
    }

    impl Disk {
        /// Opens the cache in a folder of its own; one of another size is thrown away.
        pub(in super::super) async fn open(folder: &Path, bytes: u64) -> Result<Self, DiskError> {
            let unusable = |error: &dyn std::fmt::Display| DiskError::Unusable { folder: folder.display().to_string(), message: error.to_string() };
            let own = folder.join(bytes.to_string());
            fs::create_dir_all(&own).map_err(|error| unusable(&error))?;
            for entry in fs::read_dir(folder).map_err(|error| unusable(&error))? {
                let path = entry.map_err(|error| unusable(&error))?.path();
                if path != own {
                    fs::remove_dir_all(&path).map_err(|error| unusable(&error))?;
                }
            }
            let device = FsDeviceBuilder::new(&own).with_capacity(bytes as usize).build().map_err(|error| unusable(&error))?;
            let cache = HybridCacheBuilder::new().memory(MEMORY).with_weighter(|_, tile: &Bytes| tile.len()).storage();
            let cache = cache.with_engine_config(BlockEngineConfig::new(device)).with_recover_mode(RecoverMode::Quiet).build().await;
            let cache = cache.map_err(|error| unusable(&error))?;
            Ok(Self { cache, folder: own, count: AtomicU64::new(0), has_room: AtomicBool::new(true) })
        }

        /// The tile of a fingerprint, if it is there and whole.
        pub(in super::super) async fn get(&self, fingerprint: &Fingerprint) -> Option<Bytes> {
            match self.cache.storage().load(&u128::from(*fingerprint)).await {
                Ok(Load::Entry { value, .. }) => Some(value),
                Ok(Load::Piece { piece, .. }) => Some(piece.value().clone()),
                Ok(Load::Miss | Load::Throttled) => None,
                Err(error) => {
                    tracing::warn!(%error, "the disk cache could not be read");
                    None
                }
            }
        }

        /// Keeps a tile, if the disk keeps up and is not full; it is written after this.
        pub(in super::super) fn put(&self, fingerprint: &Fingerprint, tile: Bytes) {
            if self.count.fetch_add(1, Ordering::Relaxed).is_multiple_of(LOOK) {
                self.look();
            }
            if self.has_room.load(Ordering::Relaxed) {
                self.cache.storage_writer(u128::from(*fingerprint)).insert(tile);
            }
        }

        /// Finds out whether the disk has room.
        fn look(&self) {
            let has_room = fs4::available_space(&self.folder).is_ok_and(|bytes| bytes >= FLOOR);
            match (self.has_room.swap(has_room, Ordering::Relaxed), has_room) {
                (true, false) => tracing::warn!("the disk is full: new tiles are kept in memory alone"),
                (false, true) => tracing::info!("the disk has room again: new tiles are kept on it"),
                _ => {}
            }
        }

        /// Writes what is to be written.
        pub(in super::super) async fn close(&self) {
            if let Err(error) = self.cache.close().await {
                tracing::warn!(%error, "the disk cache could not be closed");
            }
        }
    }
}
