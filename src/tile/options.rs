//! What clients choose of a tile's bytes, beside its tileset.

/// How the pixels of a picture are packed; nothing is lost in either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Image {
    /// What everything understands.
    #[default]
    Png,
    /// What takes the fewest bytes for the same time.
    Webp,
}

/// Which byte of a raw sample comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// The least.
    #[default]
    Little,
    /// The greatest.
    Big,
}

impl ByteOrder {
    /// The name in sidecars.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ByteOrder::Little => "little",
            ByteOrder::Big => "big",
        }
    }
}

/// Which row of samples comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RowOrder {
    /// The northernmost.
    #[default]
    North,
    /// The southernmost.
    South,
}

impl RowOrder {
    /// The name in URLs and sidecars.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            RowOrder::North => "north",
            RowOrder::South => "south",
        }
    }
}

/// What a mesh holds beside its triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MeshExtensions {
    /// A normal a vertex: `octvertexnormals`.
    pub normals: bool,
    /// Where there is water: `watermask`.
    pub water_mask: bool,
    /// Which tiles there are below: `metadata`.
    pub metadata: bool,
}

impl MeshExtensions {
    /// The names of all.
    pub const NAMES: [&str; 3] = ["octvertexnormals", "watermask", "metadata"];

    /// The extensions of names; others have no meaning.
    pub fn named<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        names.fold(Self::default(), |found, name| Self {
            normals: found.normals || name == Self::NAMES[0],
            water_mask: found.water_mask || name == Self::NAMES[1],
            metadata: found.metadata || name == Self::NAMES[2],
        })
    }

    /// The names of those that are wanted, with hyphens between them.
    #[must_use]
    pub fn list(self) -> String {
        let wanted = Self::NAMES.into_iter().zip([self.normals, self.water_mask, self.metadata]);
        wanted.filter(|(_, wanted)| *wanted).map(|(name, _)| name).collect::<Vec<_>>().join("-")
    }
}

/// To what heights are rounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rounding {
    /// The steps of the encoding.
    #[default]
    Steps,
    /// The greatest power of two of these that is at most a 64th of the samples' spacing, and at most 16 m: pictures of fewer bytes.
    Spacing,
}

/// What clients choose of a tile's bytes; each choice matters to some tilesets alone.
///
/// ```
/// use terrane::tile::{Image, Options};
/// assert_eq!(Options::default().image, Image::Png);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Options {
    /// Of [pictures](crate::tile::Tileset::has_webp).
    pub image: Image,
    /// Of [heights of 24 bits](crate::tile::Tileset::has_rounding).
    pub rounding: Rounding,
    /// Of [raw samples](crate::tile::Tileset::is_raw).
    pub order: ByteOrder,
    /// Of [heights for engines](crate::tile::Tileset::has_sidecar).
    pub rows: RowOrder,
    /// Of `quantized-mesh`.
    pub mesh: MeshExtensions,
}

impl Options {
    /// What they add to a tile's fingerprint: nothing where they are the defaults.
    pub(super) fn form(self) -> String {
        let mut form = String::new();
        if self.image == Image::Webp {
            form += "\nwebp 1";
        }
        if self.rounding == Rounding::Spacing {
            form += "\nrounded 1";
        }
        if self.order == ByteOrder::Big {
            form += "\nbig-endian";
        }
        if self.rows == RowOrder::South {
            form += "\nrows from the south";
        }
        if self.mesh != MeshExtensions::default() {
            form.extend(["\n", &self.mesh.list()]);
        }
        form
    }
}
