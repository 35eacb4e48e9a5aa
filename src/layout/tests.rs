//! Layouts against the plain reference, to the bit.

use super::*;
use crate::{
    geometry::{Along, Axis, Curve, Detail, Elevation, Filter, Rectangle, Shape, Window},
    noise::Isa,
    programme::{Frame, Programme},
};
use std::{collections::BTreeMap, sync::Arc};

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

fn programme(text: &str) -> Programme {
    Programme::parse(text).expect("valid")
}

/// One of many attributes: all values, weights, sides, levels and roles.
fn attribute(random: &mut Random) -> Attribute {
    let range = if random.below(12) == 0 { f64::INFINITY } else { random.within(3.0, 160.0) };
    let weight = match random.below(5) {
        0 => Weight::Linear,
        1 => Weight::sharp(),
        2 | 3 => Weight::Smooth { width: random.within(1.0, 60.0) },
        _ => Weight::Custom(Expression::parse("minus(1, divide(d, 40))").expect("valid")),
    };
    let frame = Frame { seed: 4, scale: 90.0, origin: [10.0, -3.0] };
    let terrain = |over_shape| Arc::new(TerrainValue { programme: programme("fbm(1, 2, 3)"), frame, amplitude: 70.0, datum: 20.0, over_shape });
    let profile = Value::Profile([[-20.0, 9.0], [0.0, 4.0], [12.0, 0.0]].into());
    let (name, value) = match random.below(10) {
        0..3 => ("elevation", Value::Shape),
        3 => ("elevation", Value::Number(random.within(-50.0, 900.0))),
        4 => ("elevation", Value::Terrain(terrain(random.below(2) == 0))),
        5 => ("water_depth", profile),
        6 => ("water_depth", Value::Expression(Expression::parse("max(0, minus(4, multiply(d, 0.5)))").expect("valid"))),
        7 => ("colour", Value::Vector([random.unit(), random.unit(), random.unit()].into())),
        _ => ("material", Value::Name(["rock", "sand", "grass", "snow"][random.below(4)].into())),
    };
    let attribute = Attribute::new(name, value, weight, range).on([Side::Inside, Side::Inside, Side::Inside, Side::Outside, Side::Edge][random.below(5)]);
    let attribute = attribute.with_priority([0, 0, 0, 1, 3][random.below(5)]);
    let attribute = Attribute { fade: (random.below(3) == 0 && range.is_finite()).then(|| range * 0.6), ..attribute };
    if name != "material" && random.below(5) == 0 { attribute.as_channel(random.within(0.0, 9.0)) } else { attribute }
}

/// A star-shaped ring.
fn ring(random: &mut Random, centre: [f64; 2], radius: f64, count: usize) -> Vec<[f64; 2]> {
    let mut ring: Vec<[f64; 2]> = (0..count)
        .map(|i| {
            let (angle, radius) = (std::f64::consts::TAU * i as f64 / count as f64, radius * random.within(0.6, 1.0));
            [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
        })
        .collect();
    ring.push(ring[0]);
    ring
}

fn curve(shape: Shape, change: impl Fn(Curve) -> Curve) -> Shape {
    match shape {
        Shape::Line(curve) => Shape::Line(change(curve)),
        Shape::Polygon(curve) => Shape::Polygon(change(curve)),
        other => other,
    }
}

/// One of all kinds of shapes within 400 m of a centre.
fn shape(random: &mut Random, centre: [f64; 2]) -> Shape {
    let at = [centre[0] + random.within(-400.0, 400.0), centre[1] + random.within(-400.0, 400.0)];
    let (shape, large) = match random.below(8) {
        0 => return Shape::point(at, Some(random.within(0.0, 500.0))).expect("valid"),
        1 => return Shape::circle(at, random.within(5.0, 80.0), Some(random.within(0.0, 500.0))).expect("valid"),
        2..5 => {
            let count = [2, 2, 3, 5, 70][random.below(5)];
            let vertices = (0..count).map(|_| [at[0] + random.within(-90.0, 90.0), at[1] + random.within(-90.0, 90.0)]).collect();
            let elevations = (0..count).map(|_| random.within(0.0, 800.0)).collect();
            (Shape::line(vertices, Elevation::Vertices(elevations)).expect("valid"), count > 10)
        }
        _ => {
            let count = [3, 5, 12, 80][random.below(4)];
            let radius = random.within(30.0, 150.0);
            let mut rings = vec![ring(random, at, radius, count)];
            if random.below(2) == 0 {
                rings.push(ring(random, at, radius * 0.2, 5));
            }
            let total = rings.iter().map(Vec::len).sum();
            let elevation =
                if random.below(2) == 0 { Elevation::Constant(30.0) } else { Elevation::Vertices((0..total).map(|_| random.within(0.0, 90.0)).collect()) };
            (Shape::polygon(rings, elevation).expect("a star does not cross itself"), count > 20)
        }
    };
    let levels = [0, 0, 1, 4, 7][random.below(5)];
    let shape = curve(shape, |curve| curve.along([Along::Chord, Along::Arc][levels % 2]));
    if levels == 0 {
        return shape;
    }
    let detail = Detail::new(if large { 2 } else { levels as u8 }, random.within(0.02, 0.3), random.below(1 << 20) as u64).expect("valid");
    let shape = shape.detailed(detail).expect("it has edges");
    if random.below(3) == 0 { curve(shape, |curve| curve.expanded().expect("few vertices")) } else { shape }
}

fn features(random: &mut Random, centre: [f64; 2], count: usize) -> Vec<Feature> {
    let sets: Vec<Arc<AttributeSet>> = (0..8)
        .map(|_| {
            let attributes = (0..1 + random.below(4)).map(|_| attribute(random)).collect();
            Arc::new(AttributeSet::new(attributes).expect("valid"))
        })
        .collect();
    (0..count).map(|_| Feature::new(shape(random, centre), Arc::clone(&sets[random.below(8)])).expect("shapes have elevations")).collect()
}

fn options(random: &mut Random) -> Options {
    let defaults = if random.below(2) == 0 { BTreeMap::new() } else { BTreeMap::from([("colour".to_owned(), vec![0.1, 0.2, 0.3])]) };
    Options { mix: [Mix::Max, Mix::Sum][random.below(2)], sea_level: (random.below(2) == 0).then_some(35.0), defaults }
}

/// The terrain over a window, point by point.
fn reference(layout: &Layout, window: &Window, base: Option<&[f32]>) -> LayoutSurface {
    let selection = layout.everything();
    let mut all = LayoutSurface::new(layout, &selection, 0);
    let points = window.rows.coordinates().flat_map(|y| window.columns.coordinates().map(move |x| [x, y]));
    for (i, p) in points.enumerate() {
        let one = layout.at(p, window.spacing(), window.filter, base.map(|base| base[i]), &selection);
        all.elevation.extend(one.elevation);
        all.water_depth.extend(one.water_depth);
        for (all, one) in all.fields.iter_mut().zip(one.fields) {
            match (all, one) {
                (FieldSurface::Numbers(all), FieldSurface::Numbers(one)) => all.extend(one),
                (FieldSurface::Names { heaviest, fractions }, FieldSurface::Names { heaviest: one, fractions: shares }) => {
                    heaviest.extend(one);
                    fractions.extend(shares);
                }
                _ => panic!("fields of different kinds"),
            }
        }
    }
    all
}

fn base(window: &Window) -> Vec<f32> {
    (0..window.samples()).map(|i| (i % 97) as f32 * 3.0).collect()
}

/// Where two surfaces differ.
fn difference(one: &LayoutSurface, other: &LayoutSurface) -> Option<String> {
    let first = |one: &[f32], other: &[f32]| one.iter().zip(other).position(|(a, b)| a.to_bits() != b.to_bits());
    if let Some(i) = first(&one.elevation, &other.elevation) {
        return Some(format!("elevation {i}: {} and {}", one.elevation[i], other.elevation[i]));
    }
    if let Some(i) = first(&one.water_depth, &other.water_depth) {
        return Some(format!("depth {i}: {} and {}", one.water_depth[i], other.water_depth[i]));
    }
    (one.fields != other.fields).then(|| "fields".to_owned())
}

#[test]
fn blocks_are_the_reference_to_the_bit_on_every_instruction_set() {
    for case in 0..60 {
        let mut random = Random(case);
        let centre = [[0.0, 0.0], [1e7, -3e6], [7e11, 2e10]][case as usize % 3];
        let count = 3 + random.below(12);
        let layout = Layout::new(features(&mut random, centre, count), options(&mut random)).expect("valid");
        let (spacing, filter) = ([2.0, 7.0, 25.0, 0.4][random.below(4)], [Filter::Exact, Filter::Band][random.below(2)]);
        let corner = [centre[0] + random.within(-300.0, 100.0), centre[1] + random.within(-300.0, 100.0)];
        let area = [corner[0], corner[1], corner[0] + spacing * 37.0, corner[1] + spacing * 35.0];
        let window = Window::area(area, spacing, filter, 1 << 20).expect("valid");
        let heights = base(&window);
        let below = (case % 4 != 0).then_some(&*heights);
        let plain = reference(&layout, &window, below);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            let blocks = layout.sample_on(isa, &window, below, &layout.everything());
            assert_eq!(difference(&blocks, &plain), None, "case {case} on {}", isa.name());
        }
    }
}

#[test]
fn debug_single() {
    for case in 0..60 {
        let mut random = Random(case);
        let fs = features(&mut random, [0.0, 0.0], 8);
        for f in fs {
            let layout = Layout::new(vec![f.clone()], Options::default()).expect("valid");
            let window = Window::area([-100.0, -100.0, 100.0, 100.0], 6.0, Filter::Exact, 1 << 20).expect("valid");
            let plain = reference(&layout, &window, None);
            let blocks = layout.sample_on(Isa::Baseline, &window, None, &layout.everything());
            if let Some(d) = difference(&blocks, &plain) {
                println!(
                    "{d}\n{:?}\n{:?}",
                    f.shape().curve().map(|c| (c.vertices().len(), c.detail().cloned(), c.stride(), c.is_closed(), c.way())),
                    f.attributes()
                );
            }
        }
    }
}
