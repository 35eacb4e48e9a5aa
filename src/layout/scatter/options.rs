//! How islands are scattered.

use crate::layout::{
    ContentHash,
    generate::{GenerateError, Island, check},
};
use sha2::{Digest, Sha256};

/// How islands are scattered.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatterOptions {
    /// Side of a cell in metres, 1 … 2^30; the first cell's south-west corner is the origin.
    pub cell: f64,
    /// What all cells are hashed with.
    pub seed: u64,
    /// The share 0 … 1 of the cells that have an island.
    pub chance: f64,
    /// Least and greatest size of an island against the template, 0.01 … 100; sizes are spread evenly over octaves.
    pub scale: [f64; 2],
    /// Metres between samples from which only the far form is seen, up to a sixteenth of a cell.
    pub far_spacing: f64,
    /// Elevation of the sea's surface in metres.
    pub sea_level: f64,
}

/// Ranges in metres of what grows with the size of an island, as its generators check them: the radius of the land, the spacing of rivers, the step of ridges.
const LENGTHS: [[f64; 2]; 3] = [[1.0, 1e7], [1.0, 1e6], [1.0, 1e6]];

/// Checks that islands of the least and of the greatest size can be made: then those of all sizes between can be.
pub(super) fn check_sizes(template: &Island, options: &ScatterOptions) -> Result<(), GenerateError> {
    let lengths = [template.landmass.radius, template.rivers.spacing, template.ridges.step];
    for (place, scale) in ["scatter.scale[0]", "scatter.scale[1]"].into_iter().zip(options.scale) {
        for (length, [least, most]) in lengths.into_iter().zip(LENGTHS) {
            // A length that is wrong at scale 1 is for its generator to name.
            if (least..=most).contains(&length) {
                check(place, scale, least / length..=most / length)?;
            }
        }
    }
    Ok(())
}

/// The name of a template and its options: the hash of their canonical JSON. Seeds are text there, for numbers of JSON cannot tell them all apart.
pub(super) fn content(template: &Island, options: &ScatterOptions) -> ContentHash {
    let Island { landmass, rivers, lakes, ridges, ground } = template;
    let ScatterOptions { cell, seed, chance, scale, far_spacing, sea_level } = options;
    let form = (("scatter 1", landmass, rivers, lakes, ridges, ground), (cell, seed.to_string(), chance, scale, far_spacing, sea_level));
    // All numbers are finite, or an option or a parameter would have been refused.
    let digest = Sha256::digest(serde_json_canonicalizer::to_vec(&form).unwrap_or_default());
    ContentHash(core::array::from_fn(|i| digest[i]))
}
