//! Layouts over windows: block by block, one search of the tree a block.

mod write;

use super::{
    Field, Layout, LayoutSurface, Role, Selection, Side, TerrainValue, Value,
    block::{Block, POINTS, SIDE, Values},
    distance::Distances,
    kernels::{Add, Input, Sums},
    path::Frame,
    reference::{Stage, stage},
    term::{Cover, Curve, Term, above_zero, lines},
};
use crate::{
    geometry::{Filter, Shape, Window},
    noise::Isa,
    programme::Tape,
};
use std::collections::BTreeMap;

impl Layout {
    /// The terrain over a window, until the selection's `stop` is set; `base` is the elevation beneath the layout, one a sample row by row from north to south.
    ///
    /// # Panics
    /// If the base has not one elevation a sample.
    #[must_use]
    pub fn sample(&self, window: &Window, base: Option<&[f32]>, selection: &Selection) -> LayoutSurface {
        self.sample_on(Isa::active(), window, base, selection)
    }

    /// As [`Layout::sample`], on a given instruction set: the same bits, in another time.
    ///
    /// # Panics
    /// If the base has not one elevation a sample.
    #[must_use]
    pub fn sample_on(&self, isa: Isa, window: &Window, base: Option<&[f32]>, selection: &Selection) -> LayoutSurface {
        assert!(base.is_none_or(|base| base.len() == window.samples()), "one elevation a sample");
        let mut surface = LayoutSurface::new(self, selection, window.samples());
        let mut evaluation = Evaluation::new(self, isa, window, selection);
        for row in (0..window.rows.len()).step_by(SIDE) {
            for column in (0..window.columns.len()).step_by(SIDE) {
                if selection.stop.is_set() {
                    return surface;
                }
                evaluation.block(window, [row, column]);
                evaluation.write(window.columns.len(), base, &mut surface);
            }
        }
        surface
    }
}

/// One attribute of a set of attributes, for the samples of a window.
struct Prepared<'a> {
    term: Term<'a>,
    field: usize,
    stage: Stage,
    /// The lines of a profile.
    lines: Vec<[f64; 3]>,
    /// The number of its terrain programme.
    terrain: Option<usize>,
}

/// A terrain programme, and its values over the present block.
struct Terrain<'a> {
    value: &'a TerrainValue,
    tape: Tape,
    heights: Box<Values>,
    is_filled: bool,
}

/// A layout and the samples of a window.
struct Evaluation<'a> {
    layout: &'a Layout,
    isa: Isa,
    window: Window,
    /// 0 for the function as it is.
    spacing: f64,
    selection: &'a Selection,
    /// Whether a field is wanted.
    wanted: Vec<bool>,
    /// By number of the set of attributes and whether the shape is a line; made when they are met.
    prepared: BTreeMap<(u32, bool), (Vec<Prepared<'a>>, Vec<Cover>)>,
    /// Shares of the block's samples that water covers.
    cover: Box<Values>,
    terrains: Vec<Terrain<'a>>,
    frame: Frame,
    block: Block,
    distances: Distances,
    sums: BTreeMap<(usize, Stage), Sums>,
    /// Room of sums that were used.
    spare: Vec<Box<Values>>,
    found: Vec<u32>,
    /// Values of expressions.
    custom: Box<Values>,
    values: Box<Values>,
    floats: Vec<f32>,
    positions: Vec<f64>,
}

impl<'a> Evaluation<'a> {
    fn new(layout: &'a Layout, isa: Isa, window: &Window, selection: &'a Selection) -> Self {
        let is_wanted = |(i, field): (usize, &Field)| matches!(&*field.name, "elevation" | "water_depth") || selection.fields.contains(&i);
        let frame = Frame::new(window);
        Self {
            layout,
            isa,
            window: *window,
            spacing: if window.filter == Filter::Band { window.spacing() } else { 0.0 },
            selection,
            wanted: layout.fields.iter().enumerate().map(is_wanted).collect(),
            prepared: BTreeMap::new(),
            cover: Values::new(0.0),
            terrains: Vec::new(),
            frame,
            block: Block::new(),
            distances: Distances::new(frame),
            sums: BTreeMap::new(),
            spare: Vec::new(),
            found: Vec::new(),
            custom: Values::new(0.0),
            values: Values::new(0.0),
            floats: vec![0.0; POINTS],
            positions: vec![0.0; POINTS],
        }
    }

    /// Sums up what all features say over a block.
    fn block(&mut self, window: &Window, first: [usize; 2]) {
        self.block.go(window, &self.frame, first);
        for (_, sums) in std::mem::take(&mut self.sums) {
            self.spare.extend(sums.values.into_iter().chain([sums.weight, sums.most]));
        }
        for terrain in &mut self.terrains {
            terrain.is_filled = false;
        }
        self.cover.0.fill(0.0);
        let mut found = std::mem::take(&mut self.found);
        self.layout.find(&self.block.rectangle(0, POINTS), &mut found);
        for &number in &found {
            self.feature(number as usize);
        }
        self.found = found;
    }

    fn feature(&mut self, number: usize) {
        let (layout, feature) = (self.layout, &self.layout.features[number]);
        let key = (layout.sets[number], matches!(feature.shape(), Shape::Line(_)));
        if !self.prepared.contains_key(&key) {
            let prepared = (self.prepare(number), self.covers(number));
            self.prepared.insert(key, prepared);
        }
        let Some((prepared, covers)) = self.prepared.remove(&key) else { return };
        if !prepared.is_empty() || !covers.is_empty() {
            self.distances.find(self.isa, &self.block, (number as u32, feature), layout.runs.get(&(number as u32)).map(|runs| &**runs), self.spacing);
            if !self.distances.parts.is_empty() {
                for attribute in &prepared {
                    self.add(attribute);
                }
                for cover in &covers {
                    self.add_cover(cover);
                }
            }
        }
        self.prepared.insert(key, (prepared, covers));
    }

    /// The attributes of a feature that are wanted.
    fn prepare(&mut self, number: usize) -> Vec<Prepared<'a>> {
        let layout = self.layout;
        let mut prepared = Vec::new();
        for attribute in layout.features[number].attributes().iter() {
            let field = layout.field(&attribute.name);
            let term = Term::new(attribute, self.spacing);
            if !self.wanted[field] || term.gain == 0.0 {
                continue;
            }
            let lines = if let Value::Profile(pairs) = &attribute.value { lines(pairs).collect() } else { Vec::new() };
            let terrain = if let Value::Terrain(value) = &attribute.value { Some(self.terrain(value)) } else { None };
            let stage = stage(&layout.fields[field], attribute);
            prepared.push(Prepared { term, field, stage, lines, terrain });
        }
        prepared
    }

    /// Where the attributes of a feature put water, if that is wanted.
    fn covers(&self, number: usize) -> Vec<Cover> {
        let feature = &self.layout.features[number];
        let (reach, is_line) = (feature.attributes().reach(), matches!(feature.shape(), Shape::Line(_)));
        let covers = feature.attributes().iter().filter(|_| self.selection.cover);
        covers.filter_map(|attribute| Cover::new(attribute, reach, is_line, self.spacing)).collect()
    }

    /// Takes the greater share of each sample.
    fn add_cover(&mut self, cover: &Cover) {
        for &[start, count] in &self.distances.parts {
            let shares = &mut self.cover.0[start..start + count];
            for (share, &signed) in shares.iter_mut().zip(&self.distances.signed.0[start..start + count]) {
                let own = cover.share(signed);
                *share = if own > *share { own } else { *share };
            }
        }
    }

    fn terrain(&mut self, value: &'a TerrainValue) -> usize {
        let known = self.terrains.iter().position(|terrain| std::ptr::eq(terrain.value, value));
        known.unwrap_or_else(|| {
            let tape = Tape::compile(value.programme.root());
            self.terrains.push(Terrain { value, tape, heights: Values::new(0.0), is_filled: false });
            self.terrains.len() - 1
        })
    }

    /// Adds what an attribute says to the sums of its stage.
    fn add(&mut self, attribute: &Prepared<'a>) {
        let term = &attribute.term;
        let components = if let Stage::Name(_) = attribute.stage { 0 } else { self.layout.fields[attribute.field].kind.components() };
        self.fill_expressions(term);
        if let Some(terrain) = attribute.terrain {
            self.fill_terrain(terrain);
        }
        let spare = &mut self.spare;
        let mut room = || {
            let mut values = spare.pop().unwrap_or_else(|| Values::new(0.0));
            values.0.fill(0.0);
            values
        };
        let sums = self.sums.entry((attribute.field, attribute.stage));
        let sums = sums.or_insert_with(|| Sums { weight: room(), values: (0..components).map(|_| room()).collect(), most: room() });
        let input = match &term.attribute.value {
            Value::Shape => Input::Elevation,
            Value::Number(number) => Input::Numbers(std::slice::from_ref(number)),
            Value::Vector(numbers) => Input::Numbers(numbers),
            Value::Name(_) => Input::Name,
            Value::Profile(pairs) => Input::Profile(pairs[0][1], &attribute.lines),
            Value::Expression(_) => Input::Values(&self.values),
            Value::Terrain(value) => Input::Terrain(&self.terrains[attribute.terrain.unwrap_or(0)].heights, [value.datum, value.amplitude], value.over_shape),
        };
        let custom = matches!(term.curve, Curve::Custom { .. }).then_some(&*self.custom);
        let Distances { signed, elevation, parts, .. } = &self.distances;
        self.isa.run(Add { term, signed, elevation, parts, custom, input, upper: matches!(attribute.stage, Stage::Level(1..)), sums });
    }

    /// Evaluates the expressions of an attribute over the parts that the feature reaches.
    fn fill_expressions(&mut self, term: &Term) {
        if let Curve::Custom { expression, .. } = term.curve {
            let half_width = if let Role::Channel { half_width } = term.attribute.role { half_width } else { 0.0 };
            let side = term.attribute.side;
            let distance = |signed: f64| {
                let d = match side {
                    Side::Inside => above_zero(signed),
                    Side::Outside => above_zero(-signed),
                    Side::Edge => signed.abs(),
                };
                above_zero(d - half_width)
            };
            fill(self.isa, expression, &self.distances, distance, [&mut self.positions, &mut self.custom.0], &mut self.floats);
        }
        if let Value::Expression(expression) = &term.attribute.value {
            fill(self.isa, expression, &self.distances, |signed| signed, [&mut self.positions, &mut self.values.0], &mut self.floats);
        }
    }

    /// Evaluates a terrain programme over the block, unless that was done.
    fn fill_terrain(&mut self, number: usize) {
        let terrain = &mut self.terrains[number];
        if std::mem::replace(&mut terrain.is_filled, true) {
            return;
        }
        let ([rows, columns], first) = (self.block.size, self.block.first);
        let window = self.window.part([first[0], rows], [first[1], columns]);
        let out = &mut self.floats[..rows * columns];
        terrain.tape.evaluate_on(self.isa, &terrain.value.frame, &window, out);
        for (i, height) in terrain.heights.0.iter_mut().enumerate() {
            let [row, column] = super::block::place(i);
            *height = out[row.min(rows - 1) * columns + column.min(columns - 1)].into();
        }
    }
}

/// Evaluates an expression in a function of the signed distance over the parts that a feature reaches.
fn fill(isa: Isa, expression: &super::Expression, distances: &Distances, function: impl Fn(f64) -> f64, [positions, out]: [&mut [f64]; 2], floats: &mut [f32]) {
    for &[start, count] in &distances.parts {
        let range = start..start + count;
        let (positions, floats) = (&mut positions[..count], &mut floats[..count]);
        for (position, &signed) in positions.iter_mut().zip(&distances.signed.0[range.clone()]) {
            *position = function(signed);
        }
        expression.fill(isa, positions, floats);
        for (out, &value) in out[range].iter_mut().zip(&*floats) {
            *out = value.into();
        }
    }
}
