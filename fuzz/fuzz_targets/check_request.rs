//! What must hold for any request that writes nothing: its address, query, headers and body. The tests of the package run it over the corpus.

use axum::{
    body::{Body, to_bytes},
    http::{HeaderName, HeaderValue, Method, Request, header},
};
use std::sync::LazyLock;
use tempfile::TempDir;
use terrane::server::{App, Config, Front, Reads};
use tokio::runtime::Runtime;
use tower::ServiceExt;

/// Servers with the example worlds: of one anybody may read, of the other those with a key.
struct Servers {
    runtime: Runtime,
    fronts: [Front; 2],
    /// Kept until the end.
    _folders: [TempDir; 2],
}

static SERVERS: LazyLock<Servers> = LazyLock::new(|| {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let start = |(folder, reads): (&TempDir, Reads)| {
        let mut config = Config::default();
        config.server.data = folder.path().to_path_buf();
        config.server.reads = reads;
        config.server.proxies = 1;
        (config.limits.client_requests, config.limits.client_seconds) = (1_000_000, 0);
        Front::new(runtime.block_on(App::load(&config)).expect("a server"))
    };
    let fronts = [start((&folders[0], Reads::Open)), start((&folders[1], Reads::Keys))];
    Servers { runtime, fronts, _folders: folders }
});

/// Reads a request as it comes over the wire but for its version, with line feeds alone.
fn request(text: &[u8]) -> Option<Request<Vec<u8>>> {
    let end = text.windows(2).position(|pair| pair == b"\n\n");
    let (head, body) = end.map_or((text, &[][..]), |end| (&text[..end], &text[end + 2..]));
    let mut lines = head.split(|byte| *byte == b'\n');
    let first = lines.next()?;
    let space = first.iter().position(|byte| *byte == b' ')?;
    let method = Method::from_bytes(&first[..space]).ok()?;
    let mut request = Request::builder().method(method).uri(&first[space + 1..]).body(body.to_vec()).ok()?;
    for line in lines {
        let colon = line.iter().position(|byte| *byte == b':')?;
        let (name, value) = (HeaderName::from_bytes(&line[..colon]).ok()?, HeaderValue::from_bytes(line[colon + 1..].trim_ascii()).ok()?);
        request.headers_mut().append(name, value);
    }
    Some(request)
}

/// Starts the servers, which also the first request does.
pub(crate) fn start() {
    LazyLock::force(&SERVERS);
}

pub(crate) fn check(data: &[u8]) {
    let Some(mut request) = request(data) else { return };
    // Then nothing is evaluated for a tile or an export, and nothing is written.
    request.headers_mut().insert(header::IF_NONE_MATCH, HeaderValue::from_static("*"));
    request.headers_mut().insert("x-forwarded-proto", HeaderValue::from_static("https"));
    let Servers { runtime, fronts, .. } = &*SERVERS;
    for front in fronts {
        runtime.block_on(answers(front, request.clone()));
    }
}

/// The server answers, and says what is wrong if it does.
async fn answers(front: &Front, request: Request<Vec<u8>>) {
    let (method, uri) = (request.method().clone(), request.uri().clone());
    let Ok(response) = front.clone().oneshot(request.map(Body::from)).await;
    let (status, media_type) = (response.status(), response.headers().get(header::CONTENT_TYPE).cloned());
    assert!(!status.is_server_error() && response.headers().contains_key("x-request-id"), "{method} {uri}: {status}");
    let body = to_bytes(response.into_body(), 1 << 26).await.unwrap_or_else(|error| panic!("{method} {uri}: {error}"));
    if status.is_client_error() && method != Method::HEAD {
        let problem: serde_json::Value = serde_json::from_slice(&body).unwrap_or_else(|error| panic!("{method} {uri}: {error}"));
        assert_eq!(
            (media_type.as_ref().map(HeaderValue::as_bytes), &problem["status"]),
            (Some(&b"application/problem+json"[..]), &status.as_u16().into()),
            "{method} {uri}"
        );
        assert!(problem["detail"].as_str().is_some_and(|detail| !detail.is_empty()), "{method} {uri}: {problem}");
    }
}
