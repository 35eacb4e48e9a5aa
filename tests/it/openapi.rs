//! The description in `openapi/` and the code must agree, in both directions.

use crate::client::Client;
use axum::http::{Method, StatusCode};
use std::path::Path;
use terrane::{
    geometry::Grid,
    tile::{AreaFormat, Tileset},
};

#[test]
fn the_description_in_the_repository_is_that_of_the_code() {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi/terrane.json");
    let kept = std::fs::read_to_string(&place).unwrap_or_default();
    let code = terrane::server::openapi().to_pretty_json().unwrap() + "\n";
    if kept != code {
        let now = Path::new(env!("CARGO_TARGET_TMPDIR")).join("terrane.json");
        std::fs::write(&now, &code).unwrap();
        panic!("openapi/terrane.json is not what the annotations say; they say what is in {}", now.display());
    }
}

/// Code to description: routes come from annotated handlers alone.
#[test]
fn no_route_is_added_beside_the_description() {
    let router = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/server/router.rs")).unwrap();
    // Two routers of annotated handlers, which differ in what pages of other sites may do.
    let router = router.replace(".merge(questions())", "").replace(".merge(asked)", "");
    for beside in [".route(", ".nest(", ".route_service(", ".merge("] {
        assert!(!router.contains(beside), "router.rs uses {beside}…): register an annotated handler with routes!() instead");
    }
}

/// Description to code: every described operation is answered by its own handler, with a described status.
#[tokio::test]
async fn every_described_operation_is_there() {
    let client = Client::new().await;
    let description = serde_json::to_value(terrane::server::openapi()).unwrap();
    let work = r#"{"paths":{"drawing":{"size":[9,9],"edges":{"random":{"mean":1,"deviation":0}},"sea_level":{"cost":5},
        "strokes":[{"shape":{"geometry":{"type":"Point","coordinates":[4,4]}},"cost":0}]}}}"#;
    let asked = client.send(Method::POST, "/jobs", &[], work).await.json();
    let job = asked["id"].as_str().unwrap().to_owned();
    let raster = loop {
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
        let ended = client.get(&format!("/jobs/{job}")).await.json();
        if let Some(url) = ended["raster"].as_str() {
            break url.rsplit('/').next().unwrap().to_owned();
        }
    };
    let evolution = |generations: u32| {
        format!(
            r#"{{"evolution":{{"settings":{{"population":4,"generations":{generations}}},"aim":{{"samples":16,"wanted":[{{"criterion":{{"roughness":{{"value":0.1}}}}}}]}}}}}}"#
        )
    };
    let bred = client.send(Method::POST, "/jobs", &[], evolution(0)).await.json()["id"].as_str().unwrap().to_owned();
    while client.get(&format!("/jobs/{bred}")).await.json()["state"] != "done" {
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
    }
    let long = client.send(Method::POST, "/jobs", &[], evolution(10_000)).await.json()["id"].as_str().unwrap().to_owned();
    client.put("/breeding/first", r#"{"form":1,"seed":4}"#).await;
    let fill = |template: &str| {
        let job = match template.rsplit('/').next() {
            Some("evolution" | "best.png") => &bred,
            Some("stop" | "resume") => &long,
            _ => &job,
        };
        let filled = [
            ("{world}", "hills"),
            ("{programme}", "hills"),
            ("{grid}", "web"),
            ("{tileset}", "terrarium"),
            ("{id}", "ridge"),
            ("{job}", job),
            ("{player}", "ann"),
            ("{raster}", &raster),
            ("{session}", "first"),
            ("{generation}", "0"),
            ("{individual}", "3"),
            ("{z}", "3"),
            ("{x}", "4"),
            ("{y}", "2.png"),
        ];
        filled.iter().fold(template.to_owned(), |path, (name, value)| path.replace(name, value))
    };
    let mut operations = 0;
    // Deleting last leaves the world to the others.
    for deleting in [false, true] {
        let mut paths: Vec<_> = description["paths"].as_object().unwrap().iter().collect();
        if deleting {
            // What is in a world goes before the world.
            paths.reverse();
        }
        // Events have no end; they have tests of their own.
        for (template, item) in paths.into_iter().filter(|(template, _)| *template != "/events") {
            for method in item.as_object().unwrap().keys().filter(|method| (*method == "delete") == deleting) {
                let method: Method = method.to_uppercase().parse().unwrap();
                let path = fill(template);
                assert!(!path.contains('{'), "{path}: give the parameter a value here");
                let query = match template.rsplit('/').next() {
                    Some("elevation") if method == Method::GET => "?x=0&y=0",
                    Some("profile") => "?line=0,0,9,9",
                    Some("export") => "?bbox=0,0,90,60&spacing=30&format=geotiff",
                    _ => "",
                };
                let document = match template.as_str() {
                    programme if programme.starts_with("/programmes") => r#"{"programme":"x"}"#,
                    features if features.contains("/features") => {
                        r#"{"type":"Feature","id":"ridge","geometry":{"type":"Point","coordinates":[0,0,5]},"properties":{"attributes":[]}}"#
                    }
                    breeding if breeding.starts_with("/breeding") => r#"{"form":1,"seed":4}"#,
                    area if area.ends_with("/accessibility") || area.ends_with("/statistics") => r#"{"bbox":[0,0,900,600],"spacing":30}"#,
                    feedback if feedback.ends_with("/feedback") => r#"{"heights":[140]}"#,
                    generation if generation.ends_with("/generation") => r#"{"generation":0}"#,
                    player if player.ends_with("/{player}") => r#"{"positions":[[9000,0]]}"#,
                    jobs if jobs.starts_with("/jobs") => work,
                    elevation if elevation.ends_with("/elevation") => r#"{"points":[[0,0]]}"#,
                    generate if generate.ends_with("/generate") => r#"{"generate":"landmass","radius":1000}"#,
                    _ => r#"{"seed":1,"base":{"programme":"x","scale":1},"layers":[{"name":"ground","source":{"adaptive":{"ground":{}}}}]}"#,
                };
                let body = if matches!(method, Method::PUT | Method::POST) { document } else { "" };
                let answer = client.send(method.clone(), &format!("{path}{query}"), &[], body).await;
                assert!(answer.status.is_success(), "{method} {path}: {}", answer.status);
                assert_ne!(answer.status, StatusCode::METHOD_NOT_ALLOWED);
                operations += 1;
            }
        }
    }
    assert!(operations >= 39, "{operations}");
}

/// The words of addresses are written once more for the description.
#[test]
fn the_description_names_every_grid_tileset_and_format() {
    let description = serde_json::to_value(terrane::server::openapi()).unwrap();
    let named = |path: &str, parameter: &str| -> Vec<String> {
        let parameters = description["paths"][path]["get"]["parameters"].as_array().unwrap();
        let found = parameters.iter().find(|known| known["name"] == parameter).unwrap();
        serde_json::from_value(found["schema"]["enum"].clone()).unwrap()
    };
    let tile = "/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}";
    assert_eq!(named(tile, "grid"), Grid::ALL.map(Grid::name));
    assert_eq!(named(tile, "tileset"), Tileset::ALL.map(Tileset::name));
    assert_eq!(named("/worlds/{world}/export", "format"), AreaFormat::ALL.map(AreaFormat::name));
}

#[tokio::test]
async fn the_server_gives_its_description() {
    let client = Client::new().await;
    let description = client.get("/openapi.json").await.json();
    assert!(description["openapi"].as_str().unwrap().starts_with("3.1"));
    assert_eq!(description, serde_json::to_value(terrane::server::openapi()).unwrap());
}

#[test]
fn the_manual_names_every_operation() {
    let manual = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/programmes.md")).unwrap();
    for signature in terrane::programme::Signature::all() {
        assert!(manual.contains(&format!("`{}`", signature.usage())), "docs/programmes.md lacks `{}`", signature.usage());
    }
}
