//! What clients may ask for, and from where.

use crate::client::{Answer, Client};
use axum::http::Method;
use std::time::Duration;
use tokio::time::timeout;

const TILE: &str = "/worlds/hills/web/terrarium/9/256/255.png";

async fn from(client: &Client, address: &str, path: &str) -> Answer {
    client.send(Method::GET, path, &[("x-forwarded-for", address)], "").await
}

#[tokio::test]
async fn every_client_has_its_own_budget_of_requests() {
    let client = Client::with(|config| {
        config.server.proxies = 1;
        config.limits.client_requests = 5;
    })
    .await;
    for _ in 0..5 {
        assert_eq!(from(&client, "192.0.2.1", "/worlds").await.status, 200);
    }
    let refused = from(&client, "192.0.2.1", "/worlds").await;
    assert_eq!(refused.problem(), "429 In 10 s one client may have 5 requests; RateLimit says when there are some again.");
    let fields = ["ratelimit-policy", "ratelimit", "retry-after", "access-control-allow-origin"].map(|name| refused.header(name).to_owned());
    assert_eq!(fields, ["\"requests\";q=5;w=10", "\"requests\";r=0;t=2", "2", "*"]);
    // Whom a proxy that is not believed names is nobody; its own word is the last.
    assert_eq!(from(&client, "192.0.2.7, 192.0.2.1", "/worlds").await.status, 429);
    assert_eq!(from(&client, "192.0.2.1, 192.0.2.2", "/worlds").await.status, 200);
    assert_eq!(from(&client, "192.0.2.1", "/healthz").await.status, 200, "the server's health is nobody's budget");
    for _ in 0..20 {
        assert_eq!(client.get("/worlds").await.status, 200, "this machine has no limit");
    }
}

#[tokio::test]
async fn every_client_has_its_own_budget_of_evaluation() {
    let client = Client::with(|config| {
        config.server.proxies = 1;
        config.limits.client_seconds = 1;
    })
    .await;
    let mut refused = None;
    for shift in 0..40 {
        let path = format!("/worlds/alps/profile?line={shift},0,90000,90000&samples=10000");
        let answer = from(&client, "192.0.2.1", &path).await;
        if answer.status == 429 {
            refused = Some(answer);
            break;
        }
        assert_eq!(answer.status, 200);
    }
    let refused = refused.expect("40 profiles are more than a second's worth");
    assert_eq!(refused.problem(), "429 In 10 s one client may have 1 seconds of predicted evaluation; RateLimit says when there are some again.");
    assert!(refused.header("ratelimit").starts_with("\"compute\";r=0;t="), "{}", refused.header("ratelimit"));
    assert_eq!(from(&client, "192.0.2.2", TILE).await.status, 200, "others have their own");
    assert_eq!(from(&client, "192.0.2.1", TILE).await.status, 200, "what is at hand costs nothing");
}

/// One thread, and tiles that are predicted to take more than anybody's budget.
#[tokio::test]
async fn who_leaves_a_tile_that_waits_has_not_paid_for_it() {
    let client = Client::with(|config| {
        config.server.proxies = 1;
        config.server.threads = 1;
        config.limits.client_seconds = 1;
    })
    .await;
    let world = r#"{"seed": 1, "base": {"programme": "erosion(fbm(1, 2, 8))", "scale": 1000}}"#;
    assert_eq!(client.put("/worlds/valleys", world).await.status, 201);
    let costly = |x: usize| format!("/worlds/valleys/metric/r32/9/{x}/0@257.bin?filter=exact");
    let (running, waiting) = (costly(0), costly(1));
    let mut running = Box::pin(from(&client, "192.0.2.1", &running));
    let mut waiting = Box::pin(from(&client, "192.0.2.2", &waiting));
    let soon = Duration::from_millis(100);
    assert!(timeout(soon, &mut running).await.is_err() && timeout(soon, &mut waiting).await.is_err(), "both take seconds");
    let cold = |x: usize| TILE.replace("256", &x.to_string());
    let refused = from(&client, "192.0.2.2", &cold(1)).await;
    assert!(refused.problem().starts_with("429 "), "it has paid for one that waits: {}", refused.problem());
    drop(waiting);
    drop(running);
    assert_eq!(from(&client, "192.0.2.2", &cold(2)).await.status, 200, "all of it came back");
    assert_eq!(from(&client, "192.0.2.1", &cold(3)).await.status, 200, "a fifth of a second was used");
}

#[tokio::test]
async fn pages_of_other_sites_may_read_and_ask_but_not_write() {
    let client = Client::new().await;
    let asked = [("origin", "https://maps.example.org"), ("access-control-request-method", "POST"), ("access-control-request-headers", "content-type")];
    for (path, methods) in [("/worlds/alps/elevation", "GET,HEAD,POST"), ("/worlds", "GET,HEAD"), (TILE, "GET,HEAD"), ("/worlds/alps/features", "GET,HEAD")] {
        let answer = client.send(Method::OPTIONS, path, &asked, "").await;
        assert_eq!((answer.header("access-control-allow-origin"), answer.header("access-control-allow-methods")), ("*", methods), "{path}");
    }
    let answer = client.send(Method::POST, "/worlds/alps/elevation", &asked[..1], r#"{"points": [[0, 0]]}"#).await;
    assert_eq!((answer.status.as_u16(), answer.header("access-control-allow-origin")), (200, "*"));
}
