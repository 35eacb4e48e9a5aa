//! The plane and how it is sampled: windows, surfaces, grids, rasters, and the trait every source of terrain implements.

mod grid;
mod mercator;
mod raster;
mod rectangle;
mod shape;
mod stop;
mod surface;
mod window;

pub use grid::{DEGREE, Grid, GridError, MAX_SIDE, MAX_ZOOM, Samples, Tile};
pub use mercator::{MAX_LATITUDE, from_lon_lat, to_lon_lat};
pub use raster::{Lattice, Raster, RasterLevel, coarseness};
pub use rectangle::Rectangle;
pub use shape::{Along, Chord, Curve, Detail, Edge, EdgeDetail, Elevation, MAX_ITERATIONS, MAX_VERTICES, Nearest, Shape, ShapeError, crosses};
pub use stop::{Stop, Until};
pub use surface::{Legend, Source, Surface, SurfaceRows, Wanted};
pub use window::{Axis, Filter, PLANE_LIMIT, Window, WindowError};
