//! Materials of the ground.

use crate::geometry::Surface;

/// Colours of materials whose names say what they look like.
const KNOWN: [(&str, [u8; 3]); 16] = [
    ("ash", [0x6a, 0x66, 0x64]),
    ("clay", [0xb0, 0x7a, 0x58]),
    ("desert", [0xd9, 0xc0, 0x8a]),
    ("forest", [0x4f, 0x77, 0x48]),
    ("grass", [0x86, 0xa3, 0x5c]),
    ("gravel", [0xa8, 0xa2, 0x94]),
    ("heath", [0x8d, 0x86, 0x5e]),
    ("ice", [0xe3, 0xf0, 0xf6]),
    ("lava", [0x4a, 0x42, 0x40]),
    ("mud", [0x80, 0x6a, 0x50]),
    ("rock", [0x8f, 0x84, 0x7a]),
    ("sand", [0xe2, 0xd2, 0xa2]),
    ("silt", [0x9c, 0x8e, 0x72]),
    ("snow", [0xf7, 0xf7, 0xf5]),
    ("soil", [0x7d, 0x62, 0x48]),
    ("swamp", [0x5f, 0x6e, 0x4c]),
];

/// The colour of a material in pictures: one that its name suggests, or one out of its name.
#[must_use]
pub fn material_colour(name: &str) -> [u8; 3] {
    if let Ok(found) = KNOWN.binary_search_by_key(&name, |known| known.0) {
        return KNOWN[found].1;
    }
    let hash = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    // Neither dark nor pale.
    [0, 8, 16].map(|shift| 0x60 + ((hash >> shift) & 0x7f) as u8)
}

/// Numbers of materials, one byte a sample.
pub(super) fn numbers(surface: &Surface) -> Vec<u8> {
    surface.material.iter().map(|&number| u8::try_from(number).unwrap_or(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_material_has_a_colour() {
        assert!(KNOWN.is_sorted_by_key(|known| known.0));
        assert_eq!(material_colour("snow"), [0xf7, 0xf7, 0xf5]);
        assert_ne!(material_colour("north"), material_colour("south"));
    }
}
