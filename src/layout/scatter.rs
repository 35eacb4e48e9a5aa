//! Endless layouts: the plane divided into cells, each with features of its own out of a hash.
//!
//! A cell's island stays within its cell, shelf and all, so a sample asks one cell only. Generated cells are kept in a bounded map, which decides about time alone:
//! what a cell holds follows from the seed and its place.
//!
//! Far out a tile would reach millions of cells. From half of `far_spacing` on a cell fades, by the spacing of the samples alone, into its *far form*: the outline
//! and the mean height at every distance from the coast, both as samples of that size see them. From [`CONSTANT`] on, about four samples a cell, there are the
//! means of the whole layer, and no cell is asked at all.

mod far;
mod options;
mod output;

use super::{
    ContentHash, FieldSurface, Layout, LayoutSurface, Options, Selection,
    generate::{GenerateError, Ground, Island, Stream, check},
};
use crate::{
    geometry::{Filter, PLANE_LIMIT, Rectangle, Stop, Window},
    noise,
};
use far::Far;
use lru::LruCache;
pub use options::ScatterOptions;
use options::{check_sizes, content};
use output::{Output, Sample};
use std::{
    num::NonZeroUsize,
    ops::Range,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// Cells that are kept: an island of a thousand features takes about a megabyte.
const KEPT: NonZeroUsize = NonZeroUsize::new(128).expect("not 0");

/// Cells a sample at which the far form begins to fade into the layer's means, and at which nothing else is left: a tile of 256 samples and an apron of one touches
/// at most 64 × 64 cells.
const CONSTANT: [f64; 2] = [0.06, 0.24];

/// Islands whose features are shown at a time.
const MOST_ISLANDS: i64 = 16;

/// How far land can reach beyond its greatest corner, as a share: the midpoints of its first edges move outwards by a fifth of an edge.
const BULGE: f64 = 1.2;

/// Metres from the land over which the shelf goes down to what is beneath, as a multiple of the rivers' spacing: where the sea's own profile ends.
const SHELF: f64 = 4.0;

/// The part of the shelf, from the coast on, that is all the island's: the true coast may lie there.
const BEACH: f64 = 0.3;

/// Nanoseconds to generate an island for every place of a river, and to evaluate a sample of it near and far.
const PLACE_NS: f64 = 90_000.0;
const NEAR_NS: f64 = 400.0;
const FAR_NS: f64 = 150.0;
/// Nanoseconds to lay out a cell's far form.
const FAR_CELL_NS: f64 = 3_000.0;

/// Places of rivers that the widest tile of `TILE` samples that sees islands from near may have to generate.
const MOST_PLACES: f64 = 100_000.0;
const TILE: f64 = 512.0;

/// Places of rivers of an island, about.
fn places(island: &Island) -> f64 {
    let across = island.landmass.radius / island.rivers.spacing;
    core::f64::consts::PI * across * across
}

/// What a cell holds, or nothing.
type Content = Arc<OnceLock<Option<Arc<Layout>>>>;

/// Islands without end.
#[derive(Debug)]
pub struct Scatter {
    options: ScatterOptions,
    template: Island,
    /// Metres from the centre that land can reach, and that the shelf goes on, at scale 1.
    land: f64,
    shelf: f64,
    materials: Box<[Box<str>]>,
    content: ContentHash,
    far: Far,
    cells: Mutex<LruCache<[i64; 2], Content>>,
}

/// Where the island of a cell lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    centre: [f64; 2],
    scale: f64,
    seed: u64,
    /// Metres from the centre from which on there is nothing of the island.
    reach: f64,
    /// Metres from the coast from which on there is nothing of the island.
    shelf: f64,
}

impl Place {
    /// How much of the island shows at a signed distance from the coast as it is seen from afar: all of it on land, nothing where the shelf ends.
    fn share(&self, distance: f64) -> f64 {
        let t = ((self.shelf - distance) / (self.shelf * (1.0 - BEACH))).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

/// How much of each form samples see.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Forms {
    /// The far form against the near one.
    far: f64,
    /// The layer's means against both.
    constant: f64,
}

/// Columns or rows of a window that lie in one row or column of cells.
type Run = (i64, Range<usize>);

impl Scatter {
    /// Checks the options and measures the template.
    ///
    /// # Errors
    /// An option or a parameter outside its range, or islands that do not fit into a cell; the place begins with `scatter.` or the generator's name.
    pub fn new(template: Island, options: ScatterOptions) -> Result<Self, GenerateError> {
        check("scatter.chance", options.chance, 0.0..=1.0)?;
        check("scatter.scale[0]", options.scale[0], 0.01..=100.0)?;
        check("scatter.scale[1]", options.scale[1], options.scale[0]..=100.0)?;
        check("scatter.far_spacing", options.far_spacing, options.cell / 65_536.0..=options.cell / 16.0)?;
        let land = template.landmass.radius * (1.0 + template.landmass.variation) * BULGE;
        let shelf = SHELF * template.rivers.spacing;
        // Half a cell must hold land and shelf of the largest island.
        check("scatter.cell", options.cell, 2.0 * (land + shelf) * options.scale[1]..=PLANE_LIMIT / 1024.0)?;
        check_sizes(&template, &options)?;
        // Heights of a massif count from what lies beneath.
        let options = if template.ground == Ground::Massif { ScatterOptions { sea_level: 0.0, ..options } } else { options };
        let styles = template.styles(0, options.sea_level)?;
        let across = TILE * options.far_spacing / options.cell + 2.0;
        let expected = across * across * options.chance * places(&template);
        if expected > MOST_PLACES {
            return Err(GenerateError::TooMany { place: "scatter.far_spacing", expected, limit: MOST_PLACES as usize });
        }
        let far = Far::new(&template, &styles, &options, [land, shelf])?;
        let cells = Mutex::new(LruCache::new(KEPT));
        let content = content(&template, &options);
        let mut scatter = Self { materials: far.materials.clone(), content, options, template, land, shelf, far, cells };
        scatter.far.means = scatter.means();
        Ok(scatter)
    }

    /// The name of what all cells hold.
    #[must_use]
    pub fn content(&self) -> ContentHash {
        self.content
    }

    /// The materials that islands have, in lexical order.
    #[must_use]
    pub fn materials(&self) -> &[Box<str>] {
        &self.materials
    }

    /// The island of a cell, drawn by lot.
    fn place(&self, cell: [i64; 2]) -> Option<Place> {
        let ScatterOptions { cell: side, seed, chance, scale: [least, most], .. } = self.options;
        let mut stream = Stream::new(noise::key(noise::key(seed, cell[0] as u64), cell[1] as u64), "scatter");
        if stream.unit() >= chance {
            return None;
        }
        let scale = least * libm::pow(most / least, stream.unit());
        let reach = (self.land + self.shelf) * scale;
        let free = (0.5 * side - reach).max(0.0);
        let centre = cell.map(|index| (index as f64 + 0.5) * side + free * stream.between(-1.0, 1.0));
        Some(Place { centre, scale, seed: stream.bits(), reach, shelf: self.shelf * scale })
    }

    /// The features of a cell, from the map or generated now.
    fn cell(&self, cell: [i64; 2], place: &Place) -> Option<Arc<Layout>> {
        let content = {
            let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(cells.get_or_insert(cell, Content::default))
        };
        // Others that want the same cell wait for it; those that want another do not. Sizes and parameters were checked, so that only an island that leaves the
        // plane can fail.
        content.get_or_init(|| self.generate(place).ok().map(Arc::new)).clone()
    }

    fn generate(&self, place: &Place) -> Result<Layout, GenerateError> {
        let mut island = self.template.clone().scaled(place.scale);
        island.landmass.centre = place.centre;
        let styles = island.styles(place.seed, self.options.sea_level)?;
        let features = island.features(place.seed, &styles)?;
        Layout::new(features, Options::default()).map_err(far::no_layout)
    }

    /// How much of each form samples of a window see, by their spacing alone.
    fn forms(&self, spacing: f64, filter: Filter) -> Forms {
        if filter == Filter::Exact {
            return Forms { far: 0.0, constant: 0.0 };
        }
        let part = |from: f64, to: f64| (libm::log2(spacing / from) / libm::log2(to / from)).clamp(0.0, 1.0);
        let ScatterOptions { cell, far_spacing, .. } = self.options;
        Forms { far: part(0.5 * far_spacing, far_spacing), constant: part(CONSTANT[0] * cell, CONSTANT[1] * cell) }
    }

    /// The rows and columns of cells that hold samples.
    fn runs(&self, coordinates: impl Iterator<Item = f64>) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (i, c) in coordinates.enumerate() {
            let cell = (c / self.options.cell).floor() as i64;
            match runs.last_mut() {
                Some((last, range)) if *last == cell => range.end = i + 1,
                _ => runs.push((cell, i..i + 1)),
            }
        }
        runs
    }

    /// How many cells the evaluation of a window asks.
    #[must_use]
    pub fn touched(&self, window: &Window) -> u64 {
        if self.forms(window.spacing(), window.filter).constant >= 1.0 {
            return 0;
        }
        (self.runs(window.rows.coordinates()).len() * self.runs(window.columns.coordinates()).len()) as u64
    }

    /// The islands whose cells meet an area, where filtered samples so far apart show them as they are; none where they would be more than 16.
    #[must_use]
    pub fn islands(&self, area: &Rectangle, spacing: f64) -> Vec<Arc<Layout>> {
        let cells = |axis: usize| [area.min[axis], area.max[axis]].map(|c| (c / self.options.cell).floor() as i64);
        let ([left, right], [bottom, top]) = (cells(0), cells(1));
        let count = (right - left + 1).saturating_mul(top - bottom + 1);
        if self.forms(spacing, Filter::Band).far > 0.0 || count > MOST_ISLANDS {
            return Vec::new();
        }
        let all = (bottom..=top).flat_map(|row| (left..=right).map(move |column| [column, row]));
        all.filter_map(|cell| self.cell(cell, &self.place(cell)?)).collect()
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds, the cells that are kept now counted as there.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        let (forms, samples) = (self.forms(window.spacing(), window.filter), window.samples() as f64);
        if forms.constant >= 1.0 {
            return samples;
        }
        let mut cost = if forms.far > 0.0 { FAR_NS * samples + FAR_CELL_NS * self.touched(window) as f64 } else { 0.0 };
        if forms.far < 1.0 {
            let (rows, columns) = (self.runs(window.rows.coordinates()), self.runs(window.columns.coordinates()));
            let all = (rows.len() * columns.len()) as f64;
            let kept = if all <= KEPT.get() as f64 {
                let cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
                rows.iter().flat_map(|row| columns.iter().map(move |column| [column.0, row.0])).filter(|cell| cells.contains(cell)).count() as f64
            } else {
                0.0
            };
            cost += NEAR_NS * samples + (all - kept) * self.options.chance * places(&self.template) * PLACE_NS;
        }
        cost
    }

    /// The terrain over a window, the numbers of materials, and the shares of all materials ([`Scatter::materials`], all of a sample together), which sum to 1 or 0;
    /// `base` is what is beneath, `wanted` whether the cover of water, the numbers and the shares are wanted. When `stop` is set, what is left stays as it is beneath.
    ///
    /// # Panics
    /// If the base has not one elevation a sample.
    #[must_use]
    pub fn sample(&self, window: &Window, base: &[f32], wanted: [bool; 3], stop: &Stop) -> (LayoutSurface, Vec<u16>, Vec<f32>) {
        let [cover, materials, shares] = wanted;
        assert!(base.len() == window.samples(), "one elevation a sample");
        let size = |wanted: bool| if wanted { base.len() } else { 0 };
        let fields = Vec::new();
        let (dry, water_cover) = (vec![0.0; size(cover)], vec![0.0; size(cover)]);
        let surface = LayoutSurface { elevation: base.to_vec(), water_depth: vec![0.0; base.len()], water_cover, dry, fields };
        let forms = self.forms(window.spacing(), window.filter);
        let names = self.materials.len();
        let mut out = Output {
            surface,
            materials: vec![0; size(materials)],
            shares: vec![0.0; size(shares) * names],
            names,
            columns: window.columns.len(),
            stop: stop.clone(),
        };
        if forms.constant < 1.0 {
            let columns = self.runs(window.columns.coordinates());
            for row in self.runs(window.rows.coordinates()) {
                for column in &columns {
                    if stop.is_set() {
                        break;
                    }
                    self.sample_cell(window, [&row, column], forms, &mut out);
                }
            }
        }
        if forms.constant > 0.0 {
            self.sample_means(base, forms.constant, &mut out);
        }
        (out.surface, out.materials, out.shares)
    }

    /// The samples of one cell.
    fn sample_cell(&self, window: &Window, [row, column]: [&Run; 2], forms: Forms, out: &mut Output) {
        let cell = [column.0, row.0];
        let Some(place) = self.place(cell) else { return };
        let part = window.part([row.1.start, row.1.len()], [column.1.start, column.1.len()]);
        let within = part.bounds();
        if !Rectangle::around(&[place.centre]).grown(place.reach).meets(&within) {
            return;
        }
        let near = if forms.far < 1.0 { self.cell(cell, &place).map(|layout| self.near(&layout, &part, out)) } else { None };
        let far = self.far.cell(&self.template, &place, self.options.sea_level);
        let spacing = window.spacing();
        for (i, y) in part.rows.coordinates().enumerate() {
            for (j, x) in part.columns.coordinates().enumerate() {
                let (from, to) = (i * part.columns.len() + j, (row.1.start + i) * out.columns + column.1.start + j);
                let distance = far.distance([x, y]);
                let share = place.share(distance);
                if share == 0.0 {
                    continue;
                }
                let mut island = near.as_ref().map_or(Sample::default(), |(near, materials, _)| Sample {
                    elevation: near.elevation[from].into(),
                    depth: near.water_depth[from].into(),
                    cover: near.water_cover.get(from).map_or(0.0, |&cover| cover.into()),
                    dry: 0.0,
                    material: materials.get(from).copied().unwrap_or(0),
                });
                if forms.far > 0.0 {
                    island = island.mixed(&far.sample(distance, spacing), forms.far);
                }
                if self.template.ground == Ground::Massif {
                    island.elevation += f64::from(out.surface.elevation[to]);
                }
                out.put(to, &island, share);
                let own = near.as_ref().map_or(&[][..], |(_, _, shares)| shares.get(from * self.materials.len()..).unwrap_or_default());
                out.put_shares(to, own, far.material(distance, spacing), [forms.far, share]);
            }
        }
    }

    /// The generated terrain of a cell; where no feature says anything there is the sea's floor.
    fn near(&self, layout: &Layout, part: &Window, out: &Output) -> (LayoutSurface, Vec<u16>, Vec<f32>) {
        let number = layout.fields().iter().position(|field| *field.name == *"material");
        let fields = number.filter(|_| !out.materials.is_empty() || !out.shares.is_empty()).into_iter().collect();
        let selection = Selection { fields, cover: !out.surface.water_cover.is_empty(), fractions: !out.shares.is_empty(), stop: out.stop.clone() };
        let mut surface = layout.sample(part, far::beneath(&self.template, part.samples()).as_deref(), &selection);
        let Some(FieldSurface::Names { heaviest, fractions }) = surface.fields.pop() else { return (surface, Vec::new(), Vec::new()) };
        // An island may know fewer materials than all do together.
        let names = number.map(|number| &layout.fields()[number].kind);
        let Some(super::FieldKind::Names(names)) = names else { return (surface, Vec::new(), Vec::new()) };
        let numbers: Vec<u16> = names.iter().map(|name| self.materials.partition_point(|known| known < name) as u16 + 1).collect();
        let materials = heaviest.iter().map(|&own| if own == 0 { 0 } else { numbers[usize::from(own) - 1] }).collect();
        let mut shares = vec![0.0; if out.shares.is_empty() { 0 } else { part.samples() * self.materials.len() }];
        for (all, own) in shares.chunks_exact_mut(self.materials.len().max(1)).zip(fractions.chunks_exact(names.len().max(1))) {
            own.iter().zip(&numbers).for_each(|(&share, &number)| all[usize::from(number) - 1] = share);
        }
        (surface, materials, shares)
    }

    /// Fades into the means of the whole layer.
    fn sample_means(&self, base: &[f32], part: f64, out: &mut Output) {
        let means = &self.far.means;
        for (i, &base) in base.iter().enumerate() {
            if self.template.ground == Ground::Massif {
                out.put(i, &Sample { elevation: f64::from(base) + means.elevation, ..Sample::default() }, part);
                continue;
            }
            let sea = if f64::from(base) < self.options.sea_level { 1.0 } else { 0.0 };
            let elevation = f64::from(base) * (1.0 - means.share) + means.elevation;
            let cover = sea * (1.0 - means.share) + means.cover;
            let mean = Sample { elevation, depth: 0.0, cover, dry: 1.0 - cover, material: 0 };
            out.put(i, &mean, part);
        }
    }

    /// The means over some cells of what islands make of the plane.
    fn means(&self) -> far::Means {
        /// Cells a side, and samples a side of each.
        const CELLS: i64 = 8;
        const SAMPLES: i64 = 16;
        let mut means = far::Means::default();
        let side = self.options.cell / SAMPLES as f64;
        for cell in (0..CELLS * CELLS).map(|i| [i % CELLS, i / CELLS]) {
            let Some(place) = self.place(cell) else { continue };
            let island = self.far.cell(&self.template, &place, self.options.sea_level);
            for sample in (0..SAMPLES * SAMPLES).map(|i| [i % SAMPLES, i / SAMPLES]) {
                let p = [0, 1].map(|axis| cell[axis] as f64 * self.options.cell + (sample[axis] as f64 + 0.5) * side);
                let distance = island.distance(p);
                let (share, sample) = (place.share(distance), island.sample(distance, side));
                means.share += share;
                means.elevation += share * sample.elevation;
                means.cover += share * sample.cover;
            }
        }
        let all = (CELLS * CELLS * SAMPLES * SAMPLES) as f64;
        far::Means { share: means.share / all, elevation: means.elevation / all, cover: means.cover / all }
    }
}
