//! The words of addresses, queries and headers, as `OpenAPI` describes them.
#![expect(dead_code, reason = "for the description alone; requests are read by crate::server::address and crate::server::extract")]

use utoipa::{IntoParams, ToSchema};

/// A name of a document.
#[derive(ToSchema)]
#[schema(pattern = "^[a-z0-9][a-z0-9-]{0,62}$")]
pub(super) struct Name(String);

/// The name of a content.
#[derive(ToSchema)]
#[schema(pattern = "^[0-9a-f]{32}$")]
pub(super) struct HashName(String);

/// The condition of a deletion or an addition.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
pub(super) struct MatchCondition {
    /// Entity tags in quotes with commas between them, one of which what is there must have; or `*`: something must be there.
    #[param(rename = "If-Match", value_type = String, required = false, pattern = r#"^(\*|"[!#-~]*"(, *"[!#-~]*")*)$"#)]
    if_match: Option<String>,
}

/// The conditions of a save; one of them at a time.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
pub(super) struct SaveConditions {
    /// Entity tags in quotes with commas between them, one of which what is there must have; or `*`: something must be there.
    #[param(rename = "If-Match", value_type = String, required = false, pattern = r#"^(\*|"[!#-~]*"(, *"[!#-~]*")*)$"#)]
    if_match: Option<String>,
    /// `*`: nothing must be there.
    #[param(rename = "If-None-Match", value_type = String, required = false, pattern = r"^\*$")]
    if_none_match: Option<String>,
}

/// Row, samples and extension of a tile.
#[derive(ToSchema)]
#[schema(pattern = r"^-?[0-9]{1,64}(@(2x|[0-9]{1,4}))?\.(png|webp|bin|json|mvt|terrain)$")]
pub(super) struct TileFile(String);

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum RoundingName {
    Steps,
    Spacing,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum GridName {
    Web,
    Geo,
    Metric,
}

/// A grid on the globe.
#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum GlobeGridName {
    Web,
    Geo,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum TilesetName {
    Terrarium,
    TerrainRgb,
    Fit,
    Height16,
    R16,
    R32,
    Hillshade,
    Slope,
    Normals,
    Water,
    Materials,
    Weights,
    Relief,
    Contours,
    Features,
    QuantizedMesh,
}

/// A tileset that `MapLibre` reads heights from.
#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum HeightsName {
    Terrarium,
    TerrainRgb,
    Fit,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum SurfaceName {
    Ground,
    Water,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum FilterName {
    Band,
    Exact,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum ImageName {
    Png,
    Webp,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum ByteOrderName {
    Le,
    Be,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum RowOrderName {
    North,
    South,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum AreaFormatName {
    Geotiff,
    R16,
    R32,
    Png16,
    Obj,
    Gltf,
}

#[derive(ToSchema)]
#[schema(rename_all = "kebab-case")]
pub(super) enum RegistrationName {
    Centres,
    Vertices,
}
