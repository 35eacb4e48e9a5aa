//! How well genes fit the pattern that they follow (Saunders 2006, Eq. IV.13 and on).

use super::{
    gene::{Gene, Layout},
    pattern::STEP,
    source::{Means, Scales, Source, TypeSources},
};
use core::f64::consts::{FRAC_PI_2, PI};

/// Slopes below this share of the type's have no direction.
const FLAT: f64 = 0.01;

/// σ of elevation and slope as a share of the type's range.
const QUARTER: f64 = 0.25;

/// How well a gene fits, each 0 … 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fit {
    /// Of the means of elevation.
    pub(super) mean: f64,
    /// Of the slopes of means.
    pub(super) slope: f64,
    /// Of their directions; 1 where the pattern is flat.
    pub(super) angle: f64,
    /// Of all, half of it over the gene and half over its ninths.
    pub(super) value: f64,
}

/// What a gene is to fit.
#[derive(Clone, Debug)]
pub(super) struct Target {
    whole: (f32, [f32; 2]),
    ninths: [(f32, [f32; 2]); 9],
    /// Means over cells of the level before, less those of the gene.
    cells: Vec<f32>,
}

/// The middles of a gene's ninths.
fn ninths(layout: &Layout) -> impl Iterator<Item = [i32; 2]> {
    let step = (layout.side() as i32 / 3).max(1);
    (0..9).map(move |i| [(i % 3 - 1) * step, (i / 3 - 1) * step])
}

/// Places a cell of the level before apart.
fn lattice(layout: &Layout) -> impl Iterator<Item = [i32; 2]> {
    let half = ((layout.reach - 1) / STEP) as i32;
    (-half..=half).flat_map(move |y| (-half..=half).map(move |x| [x * STEP as i32, y * STEP as i32]))
}

impl Target {
    /// Of a pattern at a gene.
    pub(super) fn new(pattern: &Scales, layout: &Layout, gene: usize) -> Self {
        let [x, y] = layout.middle(gene).map(|c| c as isize);
        let at = |means: &Means, [dx, dy]: [i32; 2]| {
            let cell = means.cell(x + dx as isize, y + dy as isize);
            (means.mean[cell], means.gradient[cell])
        };
        let whole = at(&pattern.gene, [0, 0]);
        let mut places = ninths(layout);
        let ninths = core::array::from_fn(|_| at(&pattern.part, places.next().unwrap_or_default()));
        let cells: Vec<f32> = lattice(layout).map(|place| at(&pattern.cell, place).0).collect();
        Self { whole, ninths, cells: levelled(cells) }
    }

    /// The mean elevation that is wanted, metres.
    pub(super) fn mean(&self) -> f32 {
        self.whole.0
    }

    /// The slope that is wanted, and its direction, if it has one.
    pub(super) fn slope(&self, kind: &TypeSources) -> (f64, Option<f64>) {
        slope_of(self.whole.1, kind)
    }
}

/// Heights less their mean.
fn levelled(mut heights: Vec<f32>) -> Vec<f32> {
    let mean = heights.iter().sum::<f32>() / heights.len().max(1) as f32;
    for height in &mut heights {
        *height -= mean;
    }
    heights
}

fn slope_of([x, y]: [f32; 2], kind: &TypeSources) -> (f64, Option<f64>) {
    let (x, y) = (f64::from(x), f64::from(y));
    let slope = (x * x + y * y).sqrt();
    (slope, (slope >= FLAT * kind.steepest).then(|| libm::atan2(y, x)))
}

/// An angle between -π and π.
pub(super) fn wrapped(angle: f64) -> f64 {
    let turns = libm::round(angle / (2.0 * PI));
    angle - turns * 2.0 * PI
}

/// G of a difference.
fn projection(difference: f64, sigma: f64) -> f64 {
    let x = difference / sigma;
    libm::exp(-0.5 * x * x)
}

/// The mean and the gradient of a gene around an offset from its middle, as they will lie on the ground.
fn of_gene(gene: &Gene, source: &Source, means: &Means, direction: [f32; 2], [x, y]: [i32; 2]) -> (f32, [f32; 2]) {
    let [dx, dy] = gene.place(direction, [x as f32, y as f32]);
    let cell = means.cell((gene.column + libm::roundf(dx) as i32) as isize, (gene.row + libm::roundf(dy) as i32) as isize);
    let middle = &source.scales.gene;
    let own = middle.mean[middle.cell(gene.column as isize, gene.row as isize)];
    let height = means.mean[cell];
    (height + gene.offset + (gene.scale - 1.0) * (height - own), gene.gradient(direction, means.gradient[cell]))
}

fn compare((height, gradient): (f32, [f32; 2]), (wanted, pattern): (f32, [f32; 2]), kind: &TypeSources) -> [Option<f64>; 3] {
    let ((slope, angle), (wanted_slope, wanted_angle)) = (slope_of(gradient, kind), slope_of(pattern, kind));
    let angle = wanted_angle.map(|wanted| angle.map_or(0.0, |angle| projection(wrapped(angle - wanted), FRAC_PI_2)));
    [Some(projection(f64::from(height) - f64::from(wanted), QUARTER * kind.range)), Some(projection(slope - wanted_slope, QUARTER * kind.steepest)), angle]
}

/// The mean of what there is.
fn mean(parts: impl Iterator<Item = [Option<f64>; 3]>) -> f64 {
    let (sum, count) = parts.flatten().flatten().fold((0.0, 0.0), |(sum, count), part| (sum + part, count + 1.0));
    if count > 0.0 { sum / count } else { 1.0 }
}

impl Fit {
    /// Of a gene of a type.
    pub(super) fn new(gene: &Gene, kind: &TypeSources, target: &Target, layout: &Layout) -> Self {
        let (source, direction) = (&kind.sources[gene.sample as usize], gene.direction());
        let whole = compare(of_gene(gene, source, &source.scales.gene, direction, [0, 0]), target.whole, kind);
        let parts =
            ninths(layout).zip(&target.ninths).map(|(place, wanted)| compare(of_gene(gene, source, &source.scales.part, direction, place), *wanted, kind));
        let value = 0.5 * mean([whole].into_iter()) + 0.5 * mean(parts);
        Self { mean: whole[0].unwrap_or(1.0), slope: whole[1].unwrap_or(1.0), angle: whole[2].unwrap_or(1.0), value }
    }
}

/// How far the shape of a gene is from what is wanted, m² a cell of the level before: what is chosen by where a fitness of nearly 1 tells nothing any more.
pub(super) fn misfit(gene: &Gene, kind: &TypeSources, target: &Target, layout: &Layout) -> f64 {
    let (source, direction) = (&kind.sources[gene.sample as usize], gene.direction());
    let heights = lattice(layout).map(|place| of_gene(gene, source, &source.scales.cell, direction, place).0);
    let (mut count, mut sum, mut squares) = (0.0_f32, 0.0_f32, 0.0_f32);
    let mut first = None;
    for (height, wanted) in heights.zip(&target.cells) {
        let difference = height - wanted;
        let difference = difference - *first.get_or_insert(difference);
        count += 1.0;
        sum += difference;
        squares += difference * difference;
    }
    f64::from((squares - sum * sum / count) / count)
}

/// The offset with which the mean of a gene is the one wanted.
pub(super) fn fitting_offset(gene: &Gene, kind: &TypeSources, target: &Target) -> f32 {
    let means = &kind.sources[gene.sample as usize].scales.gene;
    target.mean() - means.mean[means.cell(gene.column as isize, gene.row as isize)]
}

/// The factor of the scale and the turn with which the slope of a gene's means is the one wanted, as far as there are such.
pub(super) fn fitting_slope(gene: &Gene, kind: &TypeSources, target: &Target) -> (Option<f64>, Option<f64>) {
    let means = &kind.sources[gene.sample as usize].scales.gene;
    let own = gene.gradient(gene.direction(), means.gradient[means.cell(gene.column as isize, gene.row as isize)]);
    let ((slope, angle), (wanted, wanted_angle)) = (slope_of(own, kind), target.slope(kind));
    let factor = (slope > 0.0 && angle.is_some()).then(|| wanted / slope);
    (factor, angle.zip(wanted_angle).map(|(own, wanted)| wrapped(own - wanted)))
}
