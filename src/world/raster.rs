//! Rasters as they are kept: under the name of their content.

use crate::geometry::{Lattice, Raster};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Most nodes of a raster: 16,384 along both axes.
const MAX_NODES: usize = 1 << 28;

/// What is known of a raster without its heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RasterHead {
    /// Where its nodes lie.
    #[serde(flatten)]
    pub place: Lattice,
    /// Nodes from west to east.
    pub columns: usize,
    /// Nodes from south to north.
    pub rows: usize,
    /// Least and greatest height in metres, 0 among them.
    pub elevation: [f32; 2],
}

impl RasterHead {
    /// Least x, least y, greatest x, greatest y of its nodes, in metres.
    #[must_use]
    pub fn bbox(&self) -> [f64; 4] {
        let Lattice { origin, first, spacing } = self.place;
        let end = |axis: usize, node: i64| origin[axis] + (first[axis] + node) as f64 * spacing;
        [end(0, 0), end(1, 0), end(0, self.columns as i64 - 1), end(1, self.rows as i64 - 1)]
    }
}

impl From<&Raster> for RasterHead {
    fn from(raster: &Raster) -> Self {
        let [columns, rows] = raster.size();
        Self { place: raster.place(), columns, rows, elevation: raster.range() }
    }
}

/// A raster as the store keeps it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredRaster {
    /// The first 32 hex digits of SHA-256 of head and samples.
    pub name: String,
    /// The [head](RasterHead) as JSON.
    pub head: String,
    /// Heights in metres, f32 little-endian, row by row from the north.
    pub samples: Vec<u8>,
}

/// Why a stored raster cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RasterError {
    /// The head is not one of this version.
    #[error("its head: {0}")]
    Head(String),
    /// Heights are missing, or there are too many.
    #[error("its head speaks of {columns} × {rows} nodes, there are {bytes} bytes")]
    Length {
        /// Nodes from west to east.
        columns: usize,
        /// Nodes from south to north.
        rows: usize,
        /// What there is.
        bytes: usize,
    },
    /// The content is not what it is named after.
    #[error("its content is not what it is named after: the store is damaged")]
    Damaged,
}

fn name_of(head: &str, samples: &[u8]) -> String {
    let mut hash = Sha256::new();
    hash.update(head.as_bytes());
    hash.update(samples);
    hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

impl StoredRaster {
    /// What a raster is kept as.
    ///
    /// # Panics
    /// Never: a head is always JSON.
    #[must_use]
    pub fn of(raster: &Raster) -> Self {
        let head = serde_json::to_string(&RasterHead::from(raster)).expect("a head has only string keys and finite numbers");
        let columns = raster.size()[0].max(1);
        let samples: Vec<u8> = raster.values().chunks(columns).rev().flatten().flat_map(|height| height.to_le_bytes()).collect();
        Self { name: name_of(&head, &samples), head, samples }
    }

    /// What is known of it without its heights.
    ///
    /// # Errors
    /// If that is not what this version writes.
    pub fn head(head: &str) -> Result<RasterHead, RasterError> {
        serde_json::from_str(head).map_err(|error| RasterError::Head(error.to_string()))
    }

    /// The raster.
    ///
    /// # Errors
    /// If it is not what this version writes, or not what it is named after.
    pub fn read(&self) -> Result<Raster, RasterError> {
        let RasterHead { place, columns, rows, .. } = Self::head(&self.head)?;
        let nodes = columns.checked_mul(rows).filter(|nodes| (1..=MAX_NODES).contains(nodes));
        if nodes.is_none_or(|nodes| nodes * 4 != self.samples.len()) {
            return Err(RasterError::Length { columns, rows, bytes: self.samples.len() });
        }
        if name_of(&self.head, &self.samples) != self.name {
            return Err(RasterError::Damaged);
        }
        let rows = self.samples.chunks_exact(columns * 4).rev();
        let values = rows.flat_map(|row| row.as_chunks().0).map(|bytes| f32::from_le_bytes(*bytes)).collect();
        Ok(Raster::new(place, columns, values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_raster_is_kept_to_the_bit_under_its_own_name() {
        let place = Lattice { origin: [10.0, -0.1], first: [-2, 3], spacing: 0.1 };
        let raster = Raster::new(place, 3, vec![1.0, 0.1, -3.5, 1e-30, 0.0, 9.75]);
        let stored = StoredRaster::of(&raster);
        assert_eq!(stored.read().expect("whole"), raster);
        assert_eq!(f32::from_le_bytes(stored.samples[..4].try_into().expect("four")), 1e-30, "from the north");
        assert_eq!(StoredRaster::head(&stored.head).expect("a head").bbox(), [10.0 - 0.2, -0.1 + 3.0 * 0.1, 10.0, -0.1 + 4.0 * 0.1]);
        let other = StoredRaster::of(&Raster::new(place, 3, vec![1.0, 0.1, -3.5, 1e-30, 0.0, 9.5]));
        assert_ne!(stored.name, other.name);
        let damaged = StoredRaster { name: stored.name.clone(), ..other };
        assert_eq!(damaged.read(), Err(RasterError::Damaged));
        let short = StoredRaster { samples: stored.samples[4..].to_vec(), ..stored };
        assert_eq!(short.read(), Err(RasterError::Length { columns: 3, rows: 2, bytes: 20 }));
    }
}
