use super::*;
use crate::geometry::{Legend, SurfaceRows};

/// A slope with waves: every sample follows from its coordinates alone.
struct Waves;

impl Source for Waves {
    fn legend(&self) -> Legend {
        Legend { range: [-2_000.0, 2_000.0], ..Legend::default() }
    }

    fn sample(&self, window: &Window, surface: &mut Surface) {
        let columns = surface.columns;
        for SurfaceRows { elevation, water_depth, .. } in surface.bands_mut(window.rows.len()) {
            for (i, height) in elevation.iter_mut().enumerate() {
                let (x, y) = (window.columns.coordinate((i % columns) as i64), window.rows.coordinate((i / columns) as i64));
                *height = (x * 0.25 + libm::sin(x / 90.0) * libm::cos(y / 70.0) * 300.0) as f32;
                if let Some(depth) = water_depth.get_mut(i) {
                    *depth = (100.0 - *height).max(0.0);
                }
            }
        }
    }
}

fn request(format: AreaFormat) -> AreaRequest {
    let registration = format.registration();
    AreaRequest { bbox: [-700.0, -400.0, 900.0, 500.0], spacing: 12.5, filter: Filter::Exact, registration, height: Height::Ground, format }
}

fn bytes(area: &Area) -> Vec<u8> {
    let mut out = Vec::new();
    write_area(&Waves, area, &mut out).expect("written");
    out
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four"))).collect()
}

fn whole(window: &Window) -> Surface {
    let mut surface = Surface::of(window);
    Waves.sample(window, &mut surface);
    surface
}

#[test]
fn cuts_and_threads_change_no_byte() {
    for format in AreaFormat::ALL {
        let area = request(format).area(1 << 20).expect("valid");
        let expected = bytes(&area);
        for (rows, columns, threads) in [(1, 1, 3), (1, 1000, 1), (7, 50, 2), (64, 33, 5), (1000, 1000, 1)] {
            let cut = Area { cut: Cut::into(area.cut.window, rows, columns), ..area };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            assert!(pool.install(|| bytes(&cut)) == expected, "{format:?} in parts of {rows} × {columns}");
        }
    }
}

#[test]
fn lengths_are_known_before_the_samples() {
    for format in AreaFormat::ALL {
        let area = request(format).area(1 << 20).expect("valid");
        let length = AreaWriter::new(&area, &Waves.legend()).expect("a writer").length();
        match format {
            AreaFormat::Png16 | AreaFormat::Obj => assert_eq!(length, None),
            _ => assert_eq!(length, Some(bytes(&area).len() as u64), "{format:?}"),
        }
    }
}

#[test]
fn samples_are_those_of_one_evaluation() {
    for registration in [Registration::Centres, Registration::Vertices] {
        let area = AreaRequest { registration, ..request(AreaFormat::R32) }.area(1 << 20).expect("valid");
        assert_eq!(floats(&bytes(&area)), whole(area.window()).elevation);
        assert_eq!(area.covered(), [-700.0, -400.0, 900.0, 500.0]);
        let area = AreaRequest { registration, height: Height::Water, ..request(AreaFormat::R32) }.area(1 << 20).expect("valid");
        let water: Vec<f32> = whole(area.window()).elevation.into_iter().map(|height| height.max(100.0)).collect();
        let near = floats(&bytes(&area)).iter().zip(&water).all(|(got, want)| (got - want).abs() < 1e-3);
        assert!(near, "the water's surface");
    }
}

/// Position, normal and texture's coordinates of every vertex, and triangles, of a `.glb` read by its own description.
fn read_glb(bytes: &[u8]) -> (serde_json::Value, [Vec<f32>; 3], Vec<u32>) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
    assert_eq!((&bytes[..4], word(4), word(8) as usize), (&b"glTF"[..], 2, bytes.len()));
    let room = word(12) as usize;
    assert_eq!((&bytes[16..20], room % 4, &bytes[24 + room..28 + room]), (&b"JSON"[..], 0, &b"BIN\0"[..]));
    let description: serde_json::Value = serde_json::from_slice(&bytes[20..20 + room]).expect("JSON");
    let buffer = &bytes[28 + room..];
    assert_eq!(word(20 + room) as usize, buffer.len());
    assert_eq!(description["buffers"][0]["byteLength"], buffer.len());
    let view = |i: usize| {
        let [from, length] = ["byteOffset", "byteLength"].map(|key| description["bufferViews"][i][key].as_u64().expect("a number") as usize);
        &buffer[from..from + length]
    };
    let (positions, normals, texture) = (floats(view(0)), floats(view(1)), floats(view(2)));
    let triangles = view(3).chunks_exact(4).map(|bytes| u32::from_le_bytes(bytes.try_into().expect("four"))).collect();
    (description, [positions, normals, texture], triangles)
}

#[test]
fn meshes_face_up_within_their_bounds_and_stand_where_the_samples_do() {
    let area = request(AreaFormat::Gltf).area(1 << 20).expect("valid");
    let (description, [positions, normals, texture], triangles) = read_glb(&bytes(&area));
    let surface = whole(area.window());
    let at = |vertex: usize| [0, 1, 2].map(|axis| positions[vertex * 3 + axis]);
    assert_eq!((positions.len(), normals.len(), texture.len()), (surface.elevation.len() * 3, surface.elevation.len() * 3, surface.elevation.len() * 2));
    for (vertex, &height) in surface.elevation.iter().enumerate() {
        let [row, column] = [vertex / surface.columns, vertex % surface.columns].map(|i| i as i64);
        let plane = [area.window().columns.coordinate(column) - 100.0, height.into(), 50.0 - area.window().rows.coordinate(row)];
        assert_eq!(at(vertex).map(f64::from), plane, "x east, y up, z south, from the middle");
        let normal = &normals[vertex * 3..][..3];
        assert!((normal.iter().map(|part| part * part).sum::<f32>() - 1.0).abs() < 1e-5 && normal[1] > 0.0);
    }
    for axis in 0..3 {
        let along = positions.iter().skip(axis).step_by(3);
        let ends = along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &c| [low.min(c), high.max(c)]);
        let said = ["min", "max"].map(|end| description["accessors"][0][end][axis].as_f64().expect("a number") as f32);
        assert_eq!(said, ends, "axis {axis}");
    }
    assert_eq!(triangles.len(), (surface.columns - 1) * (surface.rows - 1) * 6);
    for triangle in triangles.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| at(triangle[i] as usize));
        let [u, v] = [b, c].map(|end| [end[0] - a[0], end[1] - a[1], end[2] - a[2]]);
        assert_eq!(u[2] * v[0] - u[0] * v[2], 12.5 * 12.5, "anticlockwise from above, each half a cell");
    }
    assert_eq!((&texture[..2], &texture[texture.len() - 2..]), (&[0.0, 0.0][..], &[1.0, 1.0][..]));
}

#[test]
fn normals_follow_the_ground_and_the_texts_of_both_meshes_agree() {
    let (glb, obj) = [AreaFormat::Gltf, AreaFormat::Obj].map(|format| request(format).area(1 << 20).expect("valid")).into();
    let (_, [positions, normals, _], triangles) = read_glb(&bytes(&glb));
    let text = String::from_utf8(bytes(&obj)).expect("text");
    let numbers = |prefix: &str| -> Vec<f32> {
        let lines = text.lines().filter_map(|line| line.strip_prefix(prefix)?.strip_prefix(' '));
        lines.flat_map(str::split_whitespace).map(|word| word.split("//").next().unwrap_or(word).parse().expect("a number")).collect()
    };
    assert!(text.starts_with("# Terrain over -700,-400,900,500: x to the east, y up, z to the south, metres from 100,50,0\n"));
    assert_eq!(numbers("v"), positions);
    assert!(numbers("vn").iter().zip(&normals).all(|(text, normal)| (text - normal).abs() < 1e-4));
    assert_eq!(numbers("f"), triangles.iter().map(|vertex| (vertex + 1) as f32).collect::<Vec<_>>());
    // Where the ground rises to the east the normal leans to the west.
    let rises = positions.chunks_exact(3).zip(positions.chunks_exact(3).skip(1)).zip(normals.chunks_exact(3));
    let leans = rises.filter(|((here, east), _)| (east[1] - here[1]).abs() > 5.0 && east[0] > here[0]);
    let right = leans.clone().filter(|((here, east), normal)| (east[1] > here[1]) == (normal[0] < 0.0)).count();
    assert!(right * 100 > leans.count() * 97);
}

#[test]
fn what_no_file_can_hold_is_refused() {
    let refused = |change: fn(&mut AreaRequest), format| {
        let mut request = request(format);
        change(&mut request);
        request.area(1 << 28).expect_err("refused").to_string()
    };
    assert_eq!(refused(|request| request.spacing = 0.0, AreaFormat::R32), "spacing must be a positive number of metres, got 0");
    assert_eq!(refused(|request| request.spacing = 0.01, AreaFormat::R32), "14400000000 samples are more than the 268435456 allowed");
    let thin = |request: &mut AreaRequest| (request.bbox, request.spacing) = ([0.0, 0.0, 200_000.0, 2.0], 1.0);
    assert_eq!(refused(thin, AreaFormat::GeoTiff), "200000 × 2 samples are more than 131072 a side");
    let large = |request: &mut AreaRequest| (request.bbox, request.spacing) = ([0.0, 0.0, 2048.0, 2048.0], 1.0);
    assert_eq!(refused(large, AreaFormat::Gltf), "4198401 vertices are more than the 4194304 of a mesh");
    let line = |request: &mut AreaRequest| (request.spacing, request.registration) = (900.0, Registration::Centres);
    assert_eq!(refused(line, AreaFormat::Obj), "a mesh has at least 2 × 2 vertices");
}
