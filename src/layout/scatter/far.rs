//! What an island looks like from afar: its outline and the mean height at every distance from the coast.

use super::{Place, ScatterOptions, output::Sample};
use crate::{
    geometry::{Filter, Window, WindowError},
    layout::{
        FieldKind, FieldSurface, Layout, LayoutError, Options, Selection,
        generate::{GenerateError, Ground, Island, Styles},
    },
    noise,
};

/// Islands that are measured, and samples a side of each.
const MEASURED: u64 = 3;
const SIDE: usize = 128;

/// Means over the whole plane, of each sample as much as the island covers it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Means {
    /// How much of the plane islands and their shelves take.
    pub share: f64,
    /// Elevation times that.
    pub elevation: f64,
    /// Share under water times that.
    pub cover: f64,
}

/// The far form of a template.
#[derive(Clone, Debug)]
pub(super) struct Far {
    /// Height above the sea over signed distance from the coast at scale 1, as the integral from the first place to each.
    integral: Vec<f64>,
    /// Metres of the first place, negative inland, and between places.
    first: f64,
    step: f64,
    /// The material that most of the land has.
    material: u16,
    /// All materials that islands have, in lexical order.
    pub materials: Box<[Box<str>]>,
    pub means: Means,
    /// Whether it is land in the sea; else heights above what lies beneath.
    is_island: bool,
}

/// What lies beneath a template where none of its features says anything: of a massif, nothing above the ground.
pub(super) fn beneath(template: &Island, samples: usize) -> Option<Vec<f32>> {
    (template.ground == Ground::Massif).then(|| vec![0.0; samples])
}

/// The far form of one island.
pub(super) struct FarCell<'a> {
    far: &'a Far,
    ring: Vec<[f64; 2]>,
    scale: f64,
    sea_level: f64,
}

impl Far {
    /// Measures islands of a template that lie round the origin; `land` and `shelf` in metres.
    pub(super) fn new(template: &Island, styles: &Styles, options: &ScatterOptions, [land, shelf]: [f64; 2]) -> Result<Self, GenerateError> {
        let half = land + shelf;
        let step = 2.0 * half / SIDE as f64;
        let window = Window::area([-half, -half, half, half], step, Filter::Exact, 1 << 20).map_err(no_window)?;
        let places = (half / step) as usize * 2 + 2;
        let first = -half;
        let mut sums = vec![[0.0; 2]; places];
        let mut weights: Vec<(Box<str>, u64)> = Vec::new();
        let mut island = template.clone();
        island.landmass.centre = [0.0, 0.0];
        for number in 0..MEASURED {
            let seed = noise::key(options.seed, number);
            let layout = Layout::new(island.features(seed, styles)?, Options::default());
            let layout = layout.map_err(no_layout)?;
            let surface =
                layout.sample(&window, beneath(template, window.samples()).as_deref(), &Selection { fractions: false, cover: false, ..layout.everything() });
            let ring = island.landmass.coarse(seed);
            let points = window.rows.coordinates().flat_map(|y| window.columns.coordinates().map(move |x| [x, y]));
            for (p, &elevation) in points.zip(&surface.elevation) {
                let place = ((signed(&ring, p) - first) / step).clamp(0.0, (places - 1) as f64) as usize;
                sums[place][0] += f64::from(elevation) - options.sea_level;
                sums[place][1] += 1.0;
            }
            count(&layout, &surface.fields, &mut weights);
        }
        weights.sort();
        let material = weights.iter().enumerate().max_by_key(|(i, (_, count))| (*count, usize::MAX - i)).map_or(0, |(i, _)| i as u16 + 1);
        let materials = weights.into_iter().map(|(name, _)| name).collect();
        let is_island = template.ground == Ground::Island;
        Ok(Self { integral: integral(&sums, step), first, step, material, materials, means: Means::default(), is_island })
    }

    /// The far form of an island.
    pub(super) fn cell(&self, template: &Island, place: &Place, sea_level: f64) -> FarCell<'_> {
        let mut land = template.landmass.clone();
        (land.centre, land.radius) = (place.centre, land.radius * place.scale);
        FarCell { far: self, ring: land.coarse(place.seed), scale: place.scale, sea_level }
    }

    /// The integral of heights up to a distance; beyond the ends heights are constant.
    fn integral(&self, distance: f64) -> f64 {
        let at = (distance - self.first) / self.step;
        let last = self.integral.len() - 1;
        let index = (at.max(0.0) as usize).min(last - 1);
        self.integral[index] + (self.integral[index + 1] - self.integral[index]) * (at - index as f64)
    }
}

/// The attributes of styles are of the kinds that they always are, so this does not happen.
pub(super) fn no_layout(_: LayoutError) -> GenerateError {
    GenerateError::Seed { place: "scatter.template", index: 0, reason: "makes no layout" }
}

fn no_window(_: WindowError) -> GenerateError {
    GenerateError::Seed { place: "scatter.template", index: 0, reason: "is too small to be measured" }
}

/// Adds how many samples have each material.
fn count(layout: &Layout, surfaces: &[FieldSurface], counts: &mut Vec<(Box<str>, u64)>) {
    let fields = layout.fields().iter().filter(|field| !matches!(&*field.name, "elevation" | "water_depth"));
    for (field, surface) in fields.zip(surfaces).filter(|(field, _)| *field.name == *"material") {
        let (FieldKind::Names(names), FieldSurface::Names { heaviest, .. }) = (&field.kind, surface) else { continue };
        for (name, number) in names.iter().zip(1..) {
            let found = heaviest.iter().filter(|&&own| own == number).count() as u64;
            match counts.iter_mut().find(|(known, _)| known == name) {
                Some((_, count)) => *count += found,
                None => counts.push((name.clone(), found)),
            }
        }
    }
}

/// Integrals of the means of places, from the first place on; places without samples have the mean of the next before them that has some.
fn integral(sums: &[[f64; 2]], step: f64) -> Vec<f64> {
    let first = sums.iter().find(|sum| sum[1] > 0.0).map_or(0.0, |sum| sum[0] / sum[1]);
    let (mut mean, mut total) = (first, 0.0);
    let mut integral = vec![0.0];
    for [sum, count] in sums {
        if *count > 0.0 {
            mean = sum / count;
        }
        total += mean * step;
        integral.push(total);
    }
    integral
}

/// Metres from a ring, negative inside.
fn signed(ring: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let (mut least, mut inside) = (f64::INFINITY, false);
    let mut a = ring[ring.len() - 1];
    for &b in ring {
        let (along, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let square = along[0] * along[0] + along[1] * along[1];
        let t = ((from[0] * along[0] + from[1] * along[1]) / square.max(1e-200)).clamp(0.0, 1.0);
        let (x, y) = (from[0] - along[0] * t, from[1] - along[1] * t);
        least = (x * x + y * y).min(least);
        if (a[1] > p[1]) != (b[1] > p[1]) && from[0] < along[0] * (from[1] / along[1]) {
            inside = !inside;
        }
        a = b;
    }
    if inside { -least.sqrt() } else { least.sqrt() }
}

impl FarCell<'_> {
    /// Metres from the coast, negative on land.
    pub(super) fn distance(&self, p: [f64; 2]) -> f64 {
        signed(&self.ring, p)
    }

    /// What samples of a size in metres see at a distance from the coast: means over it, as if coasts were straight.
    pub(super) fn sample(&self, distance: f64, spacing: f64) -> Sample {
        let (distance, size) = (distance / self.scale, spacing / self.scale);
        let height = (self.far.integral(distance + 0.5 * size) - self.far.integral(distance - 0.5 * size)) / size;
        let cover = (0.5 + distance / size).clamp(0.0, 1.0);
        let material = if cover < 0.5 { self.far.material } else { 0 };
        let [cover, dry] = if self.far.is_island { [cover, 1.0 - cover] } else { [0.0; 2] };
        Sample { elevation: self.sea_level + self.scale * height, depth: 0.0, cover, dry, material }
    }

    /// The material that samples of a size in metres see at a distance from the coast.
    pub(super) fn material(&self, distance: f64, spacing: f64) -> u16 {
        if 0.5 + distance / spacing < 0.5 { self.far.material } else { 0 }
    }
}
