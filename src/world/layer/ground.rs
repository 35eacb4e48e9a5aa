//! The terrain of a layer, whatever its source.

use super::detail::Detail;
use crate::{
    evolve::Generation,
    geometry::{Raster, Rectangle, Stop, Window},
    layout::{ContentHash, FieldKind, FieldSurface, Layout, LayoutSurface, Scatter, Selection, geojson::FeatureSet},
    paths::{Endless, ShadowTerrain},
    world::revision::Revision,
};
use std::sync::Arc;

/// The terrain of a layer.
#[derive(Clone, Debug)]
pub(super) enum Ground {
    /// Features in their places.
    Layout {
        layout: Arc<Layout>,
        /// Whether what is below the layer is the base of the merge.
        over_base: bool,
        /// The features that generators made, as they would be raised.
        generated: Arc<FeatureSet>,
    },
    /// Features without end.
    Scatter(Arc<Scatter>),
    /// Heights on what is beneath, and what lies between their nodes.
    Raised(Arc<Raised>, Option<Arc<Detail>>),
}

/// Heights, and what names all of them.
#[derive(Debug)]
pub(super) struct Raised {
    pub heights: Heights,
    pub form: String,
}

/// Metres above what is beneath, or, of shadow pictures and of ground that evolves, in its place.
#[derive(Debug)]
pub(super) enum Heights {
    Finite(Arc<Raster>),
    Endless(Box<Endless>),
    Shadow(ShadowTerrain),
    Adaptive(Arc<Generation>),
}

impl Raised {
    /// Lays the heights over elevations. Stopped, they are not whole.
    fn lay(&self, window: &Window, stop: &Stop, out: &mut [f32]) {
        match &self.heights {
            Heights::Finite(raster) => raster.add(window, stop, out),
            Heights::Endless(endless) => endless.add(window, stop, out),
            Heights::Shadow(terrain) => terrain.lay(window, stop, out),
            Heights::Adaptive(generation) => generation.terrain().write(window, stop, out),
        }
    }

    fn cost_ns(&self, window: &Window) -> f64 {
        match &self.heights {
            Heights::Finite(raster) => raster.cost_ns(window),
            Heights::Endless(endless) => endless.cost_ns(window),
            Heights::Shadow(terrain) => terrain.cost_ns(window),
            Heights::Adaptive(generation) => generation.terrain().cost_ns(window),
        }
    }

    fn reaches(&self, area: &Rectangle) -> bool {
        match &self.heights {
            Heights::Finite(raster) => raster.bounds().meets(area),
            Heights::Endless(_) => true,
            Heights::Shadow(terrain) => terrain.bounds().meets(area),
            Heights::Adaptive(generation) => generation.terrain().area().meets(area),
        }
    }
}

/// The number of a material field, if there is one.
fn material(layout: &Layout) -> Option<(usize, &[Box<str>])> {
    layout.fields().iter().enumerate().find_map(|(i, field)| match &field.kind {
        FieldKind::Names(names) if *field.name == *"material" => Some((i, &**names)),
        _ => None,
    })
}

impl Ground {
    /// What it is beside its features.
    pub(super) fn form(&self) -> String {
        match self {
            Self::Layout { layout, over_base, .. } => format!("layout {over_base} {:?}", layout.options()),
            Self::Scatter(_) => "scatter".to_owned(),
            Self::Raised(raised, detail) => {
                let detail = detail.as_ref().map(|detail| format!(" {}", Revision::of(detail.base())));
                format!("{}{}", raised.form, detail.unwrap_or_default())
            }
        }
    }

    /// The generation of ground that evolves.
    pub(super) fn generation(&self) -> Option<&Arc<Generation>> {
        match self {
            Self::Raised(raised, _) => match &raised.heights {
                Heights::Adaptive(generation) => Some(generation),
                _ => None,
            },
            _ => None,
        }
    }

    /// The materials it knows of, in lexical order.
    pub(super) fn materials(&self) -> &[Box<str>] {
        match self {
            Self::Layout { layout, .. } => material(layout).map_or(&[], |(_, names)| names),
            Self::Scatter(scatter) => scatter.materials(),
            Self::Raised(..) => &[],
        }
    }

    /// The name of what can change terrain in an area; `None` if nothing can.
    pub(super) fn content_in(&self, area: &Rectangle) -> Option<ContentHash> {
        match self {
            Self::Layout { layout, .. } => layout.content_in(area),
            Self::Scatter(scatter) => Some(scatter.content()),
            // The form names all of it.
            Self::Raised(raised, _) => raised.reaches(area).then_some(ContentHash([0; 16])),
        }
    }

    /// Whether anything can change terrain in an area.
    pub(super) fn reaches(&self, area: &Rectangle) -> bool {
        match self {
            Self::Layout { layout, .. } => layout.reaches(area),
            Self::Scatter(_) => true,
            Self::Raised(raised, _) => raised.reaches(area),
        }
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    pub(super) fn cost_ns(&self, window: &Window) -> f64 {
        match self {
            Self::Layout { layout, .. } => layout.cost_ns(window),
            Self::Scatter(scatter) => scatter.cost_ns(window),
            Self::Raised(raised, detail) => raised.cost_ns(window) + detail.as_ref().map_or(0.0, |detail| detail.cost_ns(window)),
        }
    }

    /// The terrain over a window, with the numbers of materials and the shares of all materials if they are wanted.
    pub(super) fn sample(&self, window: &Window, base: &[f32], [cover, materials, shares]: [bool; 3], stop: &Stop) -> (LayoutSurface, Vec<u16>, Vec<f32>) {
        match self {
            Self::Layout { layout, over_base, .. } => {
                let fields = material(layout).filter(|_| materials || shares).map(|(number, _)| number).into_iter().collect();
                let selection = Selection { fields, cover, fractions: shares, stop: stop.clone() };
                let mut surface = layout.sample(window, over_base.then_some(base), &selection);
                let (heaviest, fractions) = match surface.fields.pop() {
                    Some(FieldSurface::Names { heaviest, fractions }) => (heaviest, fractions),
                    _ => (vec![0; if materials { window.samples() } else { 0 }], Vec::new()),
                };
                (surface, if materials { heaviest } else { Vec::new() }, fractions)
            }
            Self::Scatter(scatter) => scatter.sample(window, base, [cover, materials, shares], stop),
            Self::Raised(raised, detail) => {
                let mut elevation = base.to_vec();
                if let Some(detail) = detail {
                    let mut heights = vec![0.0; elevation.len()];
                    raised.lay(window, stop, &mut heights);
                    if matches!(raised.heights, Heights::Adaptive(_)) {
                        // There is ground everywhere: it carries all of the detail.
                        elevation.copy_from_slice(&heights);
                        heights.fill(f32::INFINITY);
                    } else {
                        elevation.iter_mut().zip(&heights).for_each(|(elevation, height)| *elevation += height);
                    }
                    detail.add(window, &heights, stop, &mut elevation);
                } else {
                    raised.lay(window, stop, &mut elevation);
                }
                let samples = window.samples();
                let of = |wanted: bool| if wanted { vec![0.0; samples] } else { Vec::new() };
                let names = if materials { vec![0; samples] } else { Vec::new() };
                (LayoutSurface { elevation, water_depth: vec![0.0; samples], water_cover: of(cover), dry: Vec::new(), fields: Vec::new() }, names, Vec::new())
            }
        }
    }
}
