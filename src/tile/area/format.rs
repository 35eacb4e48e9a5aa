//! The formats of areas.

/// How an area is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AreaFormat {
    /// Metres as f32 with their place on the plane, EPSG:3857.
    GeoTiff,
    /// 65,535 steps over the world's vertical range as little-endian u16, row by row from the north.
    R16,
    /// Metres as little-endian f32, row by row from the north.
    R32,
    /// 65,535 steps over the world's vertical range as grey of 16 bits.
    Png16,
    /// Triangles as text: Wavefront OBJ.
    Obj,
    /// Triangles as one binary file: glTF 2.0 `.glb`.
    Gltf,
}

/// Where the samples of an area stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Registration {
    /// In the middle of pixels that fill the area.
    Centres,
    /// On its edges and between them, so that neighbouring areas share those of their edge.
    Vertices,
}

impl Registration {
    /// The name in URLs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Registration::Centres => "centres",
            Registration::Vertices => "vertices",
        }
    }
}

impl AreaFormat {
    /// Every format.
    pub const ALL: [AreaFormat; 6] = [AreaFormat::GeoTiff, AreaFormat::R16, AreaFormat::R32, AreaFormat::Png16, AreaFormat::Obj, AreaFormat::Gltf];

    /// The name in URLs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            AreaFormat::GeoTiff => "geotiff",
            AreaFormat::R16 => "r16",
            AreaFormat::R32 => "r32",
            AreaFormat::Png16 => "png16",
            AreaFormat::Obj => "obj",
            AreaFormat::Gltf => "gltf",
        }
    }

    /// The format of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// The extension of its files.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            AreaFormat::GeoTiff => "tif",
            AreaFormat::R16 => "r16",
            AreaFormat::R32 => "r32",
            AreaFormat::Png16 => "png",
            AreaFormat::Obj => "obj",
            AreaFormat::Gltf => "glb",
        }
    }

    /// Its media type.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            AreaFormat::GeoTiff => "image/tiff",
            AreaFormat::R16 | AreaFormat::R32 => "application/octet-stream",
            AreaFormat::Png16 => "image/png",
            AreaFormat::Obj => "model/obj",
            AreaFormat::Gltf => "model/gltf-binary",
        }
    }

    /// Format and version of the encoder: what it adds to a file's fingerprint.
    #[must_use]
    pub fn form(self) -> &'static str {
        match self {
            AreaFormat::GeoTiff => "geotiff 1",
            AreaFormat::R16 => "r16 1",
            AreaFormat::R32 => "r32 1",
            AreaFormat::Png16 => "png16 1",
            AreaFormat::Obj => "obj 1",
            AreaFormat::Gltf => "glb 1",
        }
    }

    /// Whether it holds triangles.
    #[must_use]
    pub fn is_mesh(self) -> bool {
        matches!(self, AreaFormat::Obj | AreaFormat::Gltf)
    }

    /// Where its samples stand unless somebody chooses: meshes end where the area does, and meet their neighbours there.
    #[must_use]
    pub fn registration(self) -> Registration {
        if self.is_mesh() { Registration::Vertices } else { Registration::Centres }
    }

    /// Samples needed beyond each side of what is written: normals look at all neighbours.
    #[must_use]
    pub fn apron(self) -> usize {
        usize::from(self.is_mesh())
    }
}
