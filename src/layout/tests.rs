//! Layouts against the plain reference, to the bit.

use super::*;
use crate::{
    geometry::{Along, Curve, Detail, Elevation, Filter, Rectangle, Shape, Window},
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
    let attribute = Attribute { fade: (random.below(3) == 0 && range.is_finite()).then_some(range * 0.6), ..attribute };
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
            let attributes = (0..=random.below(4)).map(|_| attribute(random)).collect();
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
        all.water_cover.extend(one.water_cover);
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

fn window(random: &mut Random, filter: Filter) -> Window {
    let (x, y) = (random.within(-300.0, 0.0), random.within(-300.0, 0.0));
    Window::area([x, y, x + 500.0, y + 450.0], 5.0, filter, 1 << 20).expect("valid")
}

/// Neither the order of the features, nor the partition of the window, nor the thread that a part is evaluated on changes a bit.
#[test]
fn order_partition_and_threads_do_not_change_a_bit() {
    for case in 100..112 {
        let mut random = Random(case);
        let mut all = features(&mut random, [0.0, 0.0], 40);
        // Two of the same are two.
        all.push(all[0].clone());
        let options = options(&mut random);
        let window = window(&mut random, [Filter::Exact, Filter::Band][case as usize % 2]);
        let heights = base(&window);
        let layout = Layout::new(all.clone(), options.clone()).expect("valid");
        let whole = layout.sample(&window, Some(&heights), &layout.everything());
        for i in (1..all.len()).rev() {
            all.swap(i, random.below(i + 1));
        }
        let shuffled = Layout::new(all, options).expect("valid");
        assert_eq!(shuffled.sample(&window, Some(&heights), &shuffled.everything()), whole);
        for (threads, rows) in [(1, 1), (2, 13), (5, 40)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let bands: Vec<usize> = (0..window.rows.len()).step_by(rows).collect();
            let columns = window.columns.len();
            let elevations: Vec<f32> = pool.install(|| {
                use rayon::prelude::*;
                let band = |&first: &usize| {
                    let count = rows.min(window.rows.len() - first);
                    let heights = &heights[first * columns..(first + count) * columns];
                    layout.sample(&window.band(first, count), Some(heights), &Selection::default()).elevation
                };
                bands.par_iter().flat_map_iter(band).collect()
            });
            assert_eq!(elevations, whole.elevation, "{threads} threads, {rows} rows at a time");
        }
    }
}

#[test]
fn a_layout_made_on_many_threads_is_the_same() {
    let mut random = Random(31);
    let (all, options) = (features(&mut random, [0.0, 0.0], 60), options(&mut random));
    let (one, many) = (Layout::new(all.clone(), options.clone()).expect("valid"), Layout::new_parallel(all, options).expect("valid"));
    let everywhere = |layout: &Layout| layout.content_in(&Rectangle::EVERYTHING);
    assert_eq!((one.features(), one.fields(), everywhere(&one)), (many.features(), many.fields(), everywhere(&many)));
    let window = window(&mut random, Filter::Exact);
    assert_eq!(one.sample(&window, None, &one.everything()), many.sample(&window, None, &many.everything()));
}

/// What is not selected has no influence on what is.
#[test]
fn a_selection_changes_no_value() {
    let mut random = Random(5);
    let layout = Layout::new(features(&mut random, [0.0, 0.0], 40), options(&mut random)).expect("valid");
    let window = window(&mut random, Filter::Exact);
    let (all, less) = (layout.sample(&window, None, &layout.everything()), layout.sample(&window, None, &Selection::default()));
    assert_eq!((all.elevation, all.water_depth), (less.elevation, less.water_depth));
    assert!(less.fields.is_empty() && !all.fields.is_empty());
}

/// An area finds every feature that any of its points finds, and a point every feature that has influence there.
#[test]
fn areas_find_what_their_points_find() {
    let mut random = Random(6);
    let layout = Layout::new(features(&mut random, [0.0, 0.0], 300), Options::default()).expect("valid");
    let (mut around, mut here, mut met) = (Vec::new(), Vec::new(), 0);
    for _ in 0..40 {
        let min = [random.within(-500.0, 500.0), random.within(-500.0, 500.0)];
        let area = Rectangle { min, max: min.map(|c| c + 60.0) };
        layout.find(&area, &mut around);
        assert!(around.is_sorted());
        for _ in 0..20 {
            let p = [random.within(min[0], min[0] + 60.0), random.within(min[1], min[1] + 60.0)];
            layout.find(&Rectangle { min: p, max: p }, &mut here);
            met += here.len();
            assert!(here.iter().all(|number| around.binary_search(number).is_ok()), "an area finds less than its point");
            for (feature, number) in layout.features().iter().zip(0..) {
                let distance = feature.shape().nearest(p, 0.0).distance;
                assert!(distance > feature.attributes().reach() || here.binary_search(&number).is_ok(), "a feature {distance} m away is not found");
            }
        }
    }
    assert!(met > 10_000, "{met} features were found");
}

fn line(ends: [[f64; 2]; 2], elevations: [f64; 2]) -> Shape {
    Shape::line(ends.to_vec(), Elevation::Vertices(elevations.into())).expect("valid")
}

fn feature(shape: Shape, attributes: Vec<Attribute>) -> Feature {
    Feature::new(shape, Arc::new(AttributeSet::new(attributes).expect("valid"))).expect("valid")
}

fn height(layout: &Layout, x: f64, y: f64, base: Option<f32>) -> f32 {
    layout.at([x, y], 1.0, Filter::Exact, base, &Selection::default()).elevation[0]
}

/// The formulas of the specification with numbers by hand.
#[test]
fn levels_coverage_and_mixes_are_as_written() {
    let ends = |y: f64| [[-1e4, y], [1e4, y]];
    let flat = |y, elevation, attribute| feature(line(ends(y), [elevation; 2]), vec![attribute]);
    let linear = |range| Attribute::elevation(Weight::Linear, range);
    // Two lines 100 m apart: the weighted average of the paper's equation 2.1.
    let layout = |features| Layout::new(features, Options::default()).expect("valid");
    let two = layout(vec![flat(0.0, 100.0, linear(200.0)), flat(100.0, 300.0, linear(200.0))]);
    let expected = (0.85 * 100.0 + 0.65 * 300.0) / (0.85 + 0.65);
    assert!((f64::from(height(&two, 0.0, 30.0, None)) - expected).abs() < 1e-4);
    // One line over a base of 10 m: all of it up to 150 m away, half way down to 175 m, none from 200 m on.
    let one = layout(vec![flat(0.0, 100.0, linear(200.0))]);
    assert_eq!([0.0, 150.0, 175.0, 200.0, 300.0].map(|y| height(&one, 0.0, y, Some(10.0))), [100.0, 100.0, 55.0, 10.0, 10.0]);
    assert_eq!([199.0, 300.0].map(|y| height(&one, 0.0, y, None)), [100.0, 0.0]);
    // A higher level by its largest weight, or by the sum of its weights.
    let over = |mix| {
        let upper = |y| flat(y, 500.0, linear(100.0).with_priority(1));
        Layout::new(vec![upper(0.0), upper(1.0)], Options { mix, ..Options::default() }).expect("valid")
    };
    assert_eq!(height(&over(Mix::Max), 0.0, 50.0, Some(0.0)), 500.0 * 0.51);
    assert_eq!(height(&over(Mix::Sum), 0.0, 50.0, Some(0.0)), 500.0);
    assert_eq!(height(&over(Mix::Sum), 0.0, 80.0, Some(0.0)), 500.0 * 0.41);
}

/// A channel beside a ridge keeps its own elevation: merged like a ridge, a bed between high ridges would be lifted.
#[test]
fn channels_are_exact_and_lakes_stand_above_rivers() {
    let ridge = |y: f64| feature(line([[-500.0, y], [500.0, y]], [900.0; 2]), vec![Attribute::elevation(Weight::sharp(), 400.0)]);
    let smooth = || Weight::Smooth { width: 5.0 };
    let bed = Attribute::elevation(smooth(), 60.0).as_channel(4.0);
    let water = Attribute::water_depth(&[[0.0, 3.0], [4.0, 0.0]], Weight::Linear, 6.0);
    let river = feature(line([[-400.0, 0.0], [400.0, 0.0]], [100.0, 20.0]), vec![bed.clone(), water]);
    let lake = Shape::circle([0.0, 0.0], 50.0, Some(55.0)).expect("valid");
    let layout = Layout::new(vec![ridge(20.0), ridge(-20.0), river.clone()], Options::default()).expect("valid");
    let mut last = f32::INFINITY;
    for i in 0..=800 {
        let x = f64::from(i) - 400.0;
        let sample = layout.at([x, 0.0], 1.0, Filter::Exact, Some(700.0), &Selection::default());
        let (ground, surface) = (sample.elevation[0], sample.elevation[0] + sample.water_depth[0]);
        assert!((f64::from(ground) - (57.0 - x * 0.1)).abs() < 1e-3, "the bed at {x} is at {ground}");
        assert!(surface <= last, "water runs uphill at {x}");
        last = surface;
    }
    let with_lake = vec![ridge(20.0), river, feature(lake, vec![bed.with_priority(1)])];
    let layout = Layout::new(with_lake, Options::default()).expect("valid");
    let flat: Vec<f32> = [-40.0, 0.0, 30.0].map(|x| height(&layout, x, 9.0, Some(0.0))).into();
    assert_eq!(flat, [55.0; 3], "a lake is flat");
}

#[test]
fn names_go_by_weight_and_ties_by_name() {
    let named = |name: &str, x: f64| feature(Shape::point([x, 0.0], None).expect("valid"), vec![Attribute::material(name, Weight::Linear, 100.0)]);
    let layout = Layout::new(vec![named("sand", 0.0), named("rock", 0.0), named("grass", 60.0), named("grass", 60.0)], Options::default()).expect("valid");
    let at = |x: f64| match &layout.at([x, 0.0], 1.0, Filter::Exact, None, &layout.everything()).fields[0] {
        FieldSurface::Names { heaviest, fractions } => (heaviest[0], fractions.clone()),
        FieldSurface::Numbers(_) => panic!("names"),
    };
    assert_eq!(at(0.0), (2, vec![(0.8 / 2.8) as f32, (1.0 / 2.8) as f32, (1.0 / 2.8) as f32]), "rock before sand");
    assert_eq!((at(60.0).0, at(500.0)), (1, (0, vec![0.0; 3])));
}

#[test]
fn water_stands_up_to_the_level_of_the_sea() {
    let shape = line([[0.0, 0.0], [100.0, 0.0]], [-30.0; 2]);
    let options = Options { sea_level: Some(5.0), ..Options::default() };
    let layout = Layout::new(vec![feature(shape, vec![Attribute::elevation(Weight::Linear, 50.0)])], options).expect("valid");
    let sample = layout.at([50.0, 0.0], 1.0, Filter::Exact, Some(90.0), &Selection::default());
    assert_eq!((sample.elevation[0], sample.water_depth[0]), (-30.0, 35.0));
}

/// Seen from afar a feature whose range the samples cannot carry fades, without a step.
#[test]
fn features_fade_with_the_spacing() {
    let layout = Layout::new(vec![feature(line([[-1e6, 0.0], [1e6, 0.0]], [100.0; 2]), vec![Attribute::elevation(Weight::Linear, 50.0)])], Options::default());
    let layout = layout.expect("valid");
    let seen = |spacing: f64| layout.at([0.0, 0.0], spacing, Filter::Band, Some(0.0), &Selection::default()).elevation[0];
    assert_eq!((seen(10.0), seen(25.0), seen(200.0)), (100.0, 100.0, 0.0));
    let heights: Vec<f32> = (0..2_000).map(|i| seen(25.0 + f64::from(i) * 0.1)).collect();
    assert!(heights.windows(2).all(|pair| pair[1] <= pair[0] && pair[0] - pair[1] < 0.5), "it does not fade evenly");
}

#[test]
fn what_is_wrong_is_named() {
    let set = |attribute| AttributeSet::new(vec![attribute]).expect_err("wrong").to_string();
    let good = || Attribute::elevation(Weight::Linear, 10.0);
    assert!(set(Attribute { range: -1.0, ..good() }).contains("range"));
    assert!(set(Attribute { fade: Some(11.0), ..good() }).contains("fade"));
    assert!(set(Attribute::new("Big", Value::Number(1.0), Weight::Linear, 1.0)).contains("lower-case"));
    assert!(set(Attribute::new("a", Value::Number(f64::NAN), Weight::Linear, 1.0)).contains("value"));
    assert!(set(Attribute::new("a", Value::Profile([[1.0, 0.0], [1.0, 2.0]].into()), Weight::Linear, 1.0)).contains("ascending"));
    assert!(set(Attribute::material("rock", Weight::Linear, 1.0).as_channel(1.0)).contains("channels"));
    let bare = Shape::point([0.0, 0.0], None).expect("valid");
    let elevation = Arc::new(AttributeSet::new(vec![good()]).expect("valid"));
    assert_eq!(Feature::new(bare.clone(), elevation), Err(FeatureError::NoElevation("elevation".to_owned())));
    let number = |value| feature(bare.clone(), vec![Attribute::new("a", value, Weight::Linear, 1.0)]);
    let mixed = vec![number(Value::Number(1.0)), number(Value::Name("b".into()))];
    assert_eq!(Layout::new(mixed, Options::default()).expect_err("wrong"), LayoutError::Kinds("a".to_owned()));
    let defaults = BTreeMap::from([("a".to_owned(), vec![1.0, 2.0])]);
    let options = Options { defaults, ..Options::default() };
    assert_eq!(Layout::new(vec![number(Value::Number(1.0))], options).expect_err("wrong"), LayoutError::Default("a".to_owned()));
}
