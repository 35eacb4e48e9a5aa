//! Areas as files: what they hold, that they are the world's own samples, and what a client that leaves takes with it.

use crate::client::{Answer, Client, HOST};
use axum::{
    body::Body,
    http::{Method, Request, StatusCode},
};
use futures_util::StreamExt;
use std::{io::Cursor, time::Duration};
use terrane::{
    geometry::{Filter, Window},
    server::Front,
    world::{Document, EXAMPLES, World},
};
use tiff::{
    decoder::{Decoder, DecodingResult},
    tags::Tag,
};
use tower::ServiceExt;
use zune_png::{PngDecoder, zune_core::bytestream::ZCursor, zune_core::result::DecodingResult as Pixels};

fn world(name: &str) -> World {
    let example = EXAMPLES.iter().find(|example| example.name == name).unwrap();
    World::new(Document::parse(example.json.as_bytes()).unwrap())
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

fn shorts(bytes: &[u8]) -> Vec<u16> {
    bytes.chunks_exact(2).map(|bytes| u16::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// An export that must be there.
async fn export(client: &Client, world: &str, query: &str) -> Answer {
    let answer = client.get(&format!("/worlds/{world}/export?{query}")).await;
    assert_eq!(answer.status, StatusCode::OK, "{query}: {}", String::from_utf8_lossy(&answer.body));
    answer
}

/// Windows of several bands and parts, over features and without, filtered and exact.
#[tokio::test]
async fn exports_hold_the_samples_of_one_evaluation() {
    let client = Client::new().await;
    for (name, bbox, spacing, filter) in [
        ("ridges-rivers-and-lakes", [-9_000.0, -7_000.0, 12_000.0, 9_000.0], 20.0, Filter::Band),
        ("archipelago-endless", [-40_000.0, -30_000.0, 40_000.0, 35_000.0], 80.0, Filter::Band),
        ("alps", [1e9, -5e8, 1e9 + 7_000.0, -5e8 + 3_000.0], 7.0, Filter::Exact),
    ] {
        let query = format!("bbox={}&spacing={spacing}&filter={}", bbox.map(|c| c.to_string()).join(","), filter.name());
        let whole = world(name).evaluate(&Window::area(bbox, spacing, filter, 1 << 24).unwrap());
        let raw = export(&client, name, &format!("{query}&format=r32")).await;
        assert_eq!(raw.header("content-length"), raw.body.len().to_string());
        assert!(floats(&raw.body) == whole.elevation, "{name}: bands differ from the whole");
    }
    assert!(client.app.export_parts() > 12, "they had several parts: {}", client.app.export_parts());
}

#[tokio::test]
async fn every_raster_holds_the_same_heights() {
    let client = Client::new().await;
    let query = "bbox=-3000,-2000,5000,4010&spacing=10";
    let heights = floats(&export(&client, "hills", &format!("{query}&format=r32")).await.body);
    assert_eq!(heights.len(), 800 * 601);
    let tiff = export(&client, "hills", &format!("{query}&format=geotiff")).await;
    assert_eq!((tiff.header("content-type"), tiff.header("content-length")), ("image/tiff", tiff.body.len().to_string().as_str()));
    assert_eq!(tiff.header("content-disposition"), r#"attachment; filename="hills_-3000_-2000_5000_4010_10m.tif""#);
    let mut tiff = Decoder::new(Cursor::new(&tiff.body[..])).unwrap();
    assert_eq!(tiff.dimensions().unwrap(), (800, 601));
    assert_eq!(tiff.get_tag_f64_vec(Tag::ModelPixelScaleTag).unwrap(), [10.0, 10.0, 0.0]);
    assert_eq!(tiff.get_tag_f64_vec(Tag::ModelTiepointTag).unwrap(), [0.0, 0.0, 0.0, -3000.0, 4010.0, 0.0]);
    let DecodingResult::F32(values) = tiff.read_image().unwrap() else { panic!("not f32") };
    assert_eq!(values, heights);
    let sixteen = shorts(&export(&client, "hills", &format!("{query}&format=r16")).await.body);
    let document = client.get("/worlds/hills").await.json();
    let [low, high] = ["min", "max"].map(|end| document["elevation"][end].as_f64().unwrap());
    let step = (high - low) / 65_535.0;
    assert!(sixteen.iter().zip(&heights).all(|(&n, &height)| (low + f64::from(n) * step - f64::from(height)).abs() <= step * 0.500_001));
    let png = export(&client, "hills", &format!("{query}&format=png16")).await;
    assert_eq!((png.header("content-type"), png.header("content-length")), ("image/png", ""));
    let mut decoder = PngDecoder::new(ZCursor::new(&png.body[..]));
    let Pixels::U16(pixels) = decoder.decode().unwrap() else { panic!("not 16 bits") };
    assert_eq!((decoder.dimensions(), pixels == sixteen), (Some((800, 601)), true));
}

/// A pixel's value is the elevation in its middle.
#[tokio::test]
async fn pixels_and_vertices_stand_where_the_elevation_is_asked() {
    let client = Client::new().await;
    let query = "bbox=1000,2000,1600,2300&spacing=30&format=r32";
    for (registration, columns, first) in [("centres", 20, [1015.0, 2285.0]), ("vertices", 21, [1000.0, 2300.0])] {
        let heights = floats(&export(&client, "alps", &format!("{query}&registration={registration}")).await.body);
        for (row, column) in [(0, 0), (0, columns - 1), (7, 3)] {
            let (x, y) = (first[0] + 30.0 * column as f64, first[1] - 30.0 * f64::from(row));
            let ground = client.get(&format!("/worlds/alps/elevation?x={x}&y={y}&spacing=30")).await.json();
            assert_eq!(ground["elevation"].as_f64().unwrap() as f32, heights[row as usize * columns + column], "{registration} {row} {column}");
        }
    }
}

#[tokio::test]
async fn water_raises_what_is_exported() {
    let client = Client::new().await;
    let of = async |surface: &str| {
        let query = format!("bbox=-20000,-20000,20000,20000&spacing=200&format=r32&surface={surface}");
        floats(&export(&client, "archipelago", &query).await.body)
    };
    let (ground, water) = (of("ground").await, of("water").await);
    let sea = client.get("/worlds/archipelago").await.json()["sea_level"].as_f64().unwrap() as f32;
    assert!(ground.iter().zip(&water).all(|(ground, water)| (ground.max(sea) - water).abs() < 0.01) && ground != water);
}

#[tokio::test]
async fn meshes_are_models() {
    let client = Client::new().await;
    let query = "bbox=0,0,6000,4000&spacing=50";
    let glb = export(&client, "alps", &format!("{query}&format=gltf")).await;
    assert_eq!((glb.header("content-type"), glb.header("content-length")), ("model/gltf-binary", glb.body.len().to_string().as_str()));
    assert_eq!(glb.header("content-disposition"), r#"attachment; filename="alps_0_0_6000_4000_50m.glb""#);
    assert_eq!((&glb.body[..4], glb.body.len()), (&b"glTF"[..], u32::from_le_bytes(glb.body[8..12].try_into().unwrap()) as usize));
    let obj = export(&client, "alps", &format!("{query}&format=obj")).await;
    let lines = |prefix: &str| obj.body.split(|byte| *byte == b'\n').filter(|line| line.starts_with(prefix.as_bytes())).count();
    assert_eq!((obj.header("content-type"), lines("v "), lines("vn "), lines("f ")), ("model/obj", 121 * 81, 121 * 81, 120 * 80 * 2));
}

#[tokio::test]
async fn heads_and_known_tags_evaluate_nothing() {
    let client = Client::new().await;
    let path = "/worlds/alps/export?bbox=0,0,9000,6000&spacing=10&format=geotiff";
    let head = client.send(Method::HEAD, path, &[], "").await;
    assert_eq!((head.status, head.body.len()), (StatusCode::OK, 0));
    assert!(head.header("content-length").parse::<usize>().unwrap() > 900 * 600 * 4);
    let tag = head.header("etag").to_owned();
    let known = client.send(Method::GET, path, &[("if-none-match", &tag)], "").await;
    assert_eq!((known.status, known.header("etag"), known.header("cache-control")), (StatusCode::NOT_MODIFIED, tag.as_str(), "no-cache"));
    assert_eq!(client.app.export_parts(), 0);
    assert_eq!(client.get(path).await.header("etag"), tag);
    for other in ["&filter=exact", "&surface=water", "&registration=vertices"] {
        assert_ne!(client.send(Method::HEAD, &format!("{path}{other}"), &[], "").await.header("etag"), tag, "{other}");
    }
    let revision = client.get("/worlds/alps").await.header("etag").trim_matches('"').to_owned();
    let pinned = client.send(Method::HEAD, &path.replace("alps", &format!("alps@{revision}")), &[], "").await;
    assert_eq!((pinned.header("etag"), pinned.header("cache-control")), (tag.as_str(), "public, max-age=31536000, immutable"));
}

/// A file of many bands is begun and dropped: only what its first pieces took is evaluated.
#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_leaves_ends_the_evaluation() {
    let client = Client::with(|config| (config.server.threads, config.limits.exports) = (2, 1)).await;
    let path = "/worlds/alps/export?bbox=0,0,1000000,1000000&spacing=125&format=r32";
    let front = Front::new(client.app.clone());
    let ask = || Request::get(path).header("host", HOST).body(Body::empty()).unwrap();
    let mut pieces = front.clone().oneshot(ask()).await.unwrap().into_body().into_data_stream();
    let piece = pieces.next().await.unwrap().unwrap();
    assert!(piece.len() >= 8000 * 4);
    assert_eq!(client.get(path).await.problem(), "503 Too many exports are under way; try again later.");
    drop(pieces);
    let taken = client.app.export_parts();
    tokio::time::sleep(Duration::from_millis(300)).await;
    let parts = 8000_u64.div_ceil(512) * 8000_u64.div_ceil(131);
    assert!(client.app.export_parts() <= taken + 2 && taken < parts / 4, "{taken} and then {} of {parts} parts", client.app.export_parts());
    let again = front.oneshot(ask()).await.unwrap();
    assert_eq!(again.status(), StatusCode::OK, "its place is free again");
}

#[tokio::test]
async fn wrong_exports_are_told_what_would_be_right() {
    let client = Client::with(|config| config.limits.export_seconds = 1).await;
    client.put("/worlds/slow", r#"{"seed":1,"base":{"programme":"erosion(fbm(1, 2, 8))","scale":1000}}"#).await;
    for (query, expected) in [
        ("spacing=1&format=r32", "400 bbox: an area, minx,miny,maxx,maxy in metres, is needed"),
        ("bbox=0,0,9,9&format=r32", "400 spacing: a number of metres between samples is needed"),
        ("bbox=0,0,9,9&spacing=1", "400 format: one of geotiff, r16, r32, png16, obj, gltf is needed"),
        ("bbox=0,0,9,9&spacing=1&format=glb", "400 format: must be one of geotiff, r16, r32, png16, obj, gltf, got \"glb\""),
        ("bbox=0,0,9&spacing=1&format=r32", "400 bbox: must be minx,miny,maxx,maxy in metres within 2^40 of the origin, the least corner first"),
        ("bbox=9,0,0,9&spacing=1&format=r32", "400 bbox: must be minx,miny,maxx,maxy in metres within 2^40 of the origin, the least corner first"),
        (
            "bbox=0,0,9,9&spacing=100&format=r32",
            "400 bbox: the area must have its least corner first and be at least one sample wide and high (minx,miny,maxx,maxy)",
        ),
        ("bbox=0,0,9,9&spacing=-1&format=r32", "400 spacing: spacing must be a positive number of metres, got -1"),
        ("bbox=0,0,9,9&spacing=x&format=r32", "400 spacing: must be a number"),
        ("bbox=0,0,9,9&spacing=1&format=r32&filter=no", "400 filter: must be band or exact, got \"no\""),
        ("bbox=0,0,9,9&spacing=1&format=r32&surface=no", "400 surface: must be ground or water, got \"no\""),
        ("bbox=0,0,9,9&spacing=1&format=obj&registration=no", "400 registration: must be vertices or centres, got \"no\""),
        (
            "bbox=0,0,20000,20000&spacing=1&format=r32",
            "400 spacing: 400000000 samples are more than the 268435456 allowed: ask for a wider spacing or a smaller area",
        ),
        (
            "bbox=0,0,2048,2048&spacing=1&format=gltf",
            "400 spacing: 4198401 vertices are more than the 4194304 of a mesh: ask for a wider spacing, a smaller area or a raster",
        ),
        ("bbox=0,0,200000,10&spacing=1&format=r32", "400 bbox: 200000 × 10 samples are more than 131072 a side"),
    ] {
        assert_eq!(client.get(&format!("/worlds/alps/export?{query}")).await.problem(), expected, "{query}");
    }
    let slow = client.get("/worlds/slow/export?bbox=0,0,8000,8000&spacing=1&format=r32").await.problem();
    assert!(
        slow.starts_with("400 spacing: this would take about ") && slow.ends_with("and 1 s are allowed: ask for a wider spacing or a smaller area"),
        "{slow}"
    );
    assert!(client.get("/worlds/alps/export?bbox=0,0,9,9&spacing=1&format=r32&unit=m").await.problem().starts_with("400 unit: unknown field `unit`"));
    assert_eq!(client.app.export_parts(), 0);
}
