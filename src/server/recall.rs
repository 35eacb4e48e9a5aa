//! Tiles in memory that were asked for by the same address before: answered without reading the address again, as long as the world is what it was.

use super::{
    access::{Peer, admits},
    headers::is_fresh,
    observe::{Asked, answered, request_id},
    router::router,
    state::App,
    tiles::TYPICAL_BYTES,
    worlds::Live,
};
use crate::world::Fingerprint;
use axum::{
    Router,
    body::Body,
    extract::Request,
    http::{HeaderMap, Method, StatusCode, Uri, header},
    response::Response,
};
use quick_cache::sync::Cache;
use std::{
    convert::Infallible,
    pin::Pin,
    sync::{Arc, LazyLock, Weak},
    task::{Context, Poll},
    time::Instant,
};
use tower::{Service, ServiceExt};

/// What the answer to a tile's address follows from. Its handler says so in the extensions of the answer, unless it follows from headers, too.
#[derive(Clone)]
pub(super) struct Origin {
    /// The world as it is now, also where the answer is of an older revision.
    pub world: Weak<Live>,
    pub fingerprint: Fingerprint,
    /// The entity tag without quotes.
    pub tag: String,
}

/// An answer but for its body.
struct Recalled {
    origin: Origin,
    headers: HeaderMap,
}

/// Answers by the addresses that they were given to.
pub(super) struct Recall(Cache<Box<str>, Arc<Recalled>>);

impl Recall {
    /// Of as many tiles as a cache of so many bytes has.
    pub(super) fn new(cache_bytes: u64) -> Self {
        Self(Cache::new((cache_bytes / TYPICAL_BYTES).max(1) as usize))
    }

    fn keep(&self, address: &Uri, origin: Origin, headers: &HeaderMap) {
        let mut headers = headers.clone();
        headers.remove("server-timing");
        if let Some(address) = address.path_and_query() {
            self.0.insert(address.as_str().into(), Arc::new(Recalled { origin, headers }));
        }
    }

    fn find(&self, address: &Uri) -> Option<Arc<Recalled>> {
        self.0.get(address.path_and_query()?.as_str())
    }
}

/// The whole service: what every request meets first.
#[derive(Clone)]
pub struct Front {
    app: App,
    router: Router,
}

impl Front {
    /// The service over a state.
    #[must_use]
    pub fn new(app: App) -> Self {
        Self { router: router(app.clone()), app }
    }

    /// What the router would answer, headers and all, where that is at hand and the client may have it.
    pub(super) fn recall<B>(&self, request: &axum::http::Request<B>, peer: Option<Peer>) -> Option<Response> {
        /// That of tiles.
        static ROUTE: LazyLock<Arc<str>> = LazyLock::new(|| "/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}".into());
        let (begun, state, asked) = (Instant::now(), &self.app.0, request.headers());
        if request.method() != Method::GET {
            return None;
        }
        let recalled = state.recall.find(request.uri())?;
        let Recalled { origin, headers } = &*recalled;
        let tile = state.tiles.in_memory(&origin.fingerprint)?;
        if !state.worlds.shelf.is_current(&origin.world) || !admits(&self.app, request, peer) {
            return None;
        }
        let mut response = Response::new(Body::empty());
        *response.headers_mut() = headers.clone();
        if asked.contains_key(header::IF_NONE_MATCH) && is_fresh(asked, &origin.tag) {
            *response.status_mut() = StatusCode::NOT_MODIFIED;
            for name in [header::CONTENT_TYPE, header::CONTENT_LENGTH] {
                response.headers_mut().remove(name);
            }
        } else {
            state.metrics.looked_up("hit");
            *response.body_mut() = Body::from(tile);
        }
        let asked = Asked { begun, method: "GET", route: Arc::clone(&ROUTE), path: request.uri().path(), id: request_id(asked) };
        answered(&self.app, &asked, &mut response);
        Some(response)
    }

    /// What the router answers.
    pub(super) async fn answer(&self, request: Request) -> Response {
        // A signature must be looked at every time.
        let is_signed = request.uri().query().is_some_and(|query| query.contains("signature"));
        let address = (request.method() == Method::GET && !is_signed).then(|| request.uri().clone());
        let Ok(mut response) = self.router.clone().oneshot(request).await;
        if let Some(origin) = response.extensions_mut().remove::<Origin>()
            && let Some(address) = address
            && response.status() == StatusCode::OK
        {
            self.app.0.recall.keep(&address, origin, response.headers());
        }
        response
    }
}

impl Service<Request> for Front {
    type Response = Response;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response, Infallible>> + Send>>;

    fn poll_ready(&mut self, _: &mut Context) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: Request) -> Self::Future {
        if let Some(response) = self.recall(&request, None) {
            return Box::pin(std::future::ready(Ok(response)));
        }
        let front = self.clone();
        Box::pin(async move { Ok(front.answer(request).await) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        server::{Config, Reads},
        store::{Scope, Store},
    };
    use axum::{
        body::to_bytes,
        http::{HeaderName, HeaderValue},
    };
    use sha2::{Digest, Sha256};
    use tempfile::TempDir;

    type Headers = [(&'static str, &'static str)];

    struct Server {
        front: Front,
        _folder: TempDir,
    }

    impl Server {
        async fn start(change: impl FnOnce(&mut Config)) -> Self {
            Self::over(tempfile::tempdir().expect("a folder"), change).await
        }

        async fn over(folder: TempDir, change: impl FnOnce(&mut Config)) -> Self {
            let mut config = Config::default();
            config.server.data = folder.path().to_path_buf();
            change(&mut config);
            Self { front: Front::new(App::load(&config).await.expect("a server")), _folder: folder }
        }

        /// What the router answers.
        async fn made(&self, method: Method, path: &str, headers: &Headers, body: &str) -> Plain {
            plain(self.front.answer(request(method, path, headers, body)).await).await
        }

        async fn recalled(&self, path: &str, headers: &Headers) -> Option<Plain> {
            match self.front.recall(&request(Method::GET, path, headers, ""), None) {
                Some(response) => Some(plain(response).await),
                None => None,
            }
        }

        fn counted(&self, line: &str) -> bool {
            let levels = crate::server::metrics::Levels { waiting: [("visible", 0); 2], evaluating: 0, cached_tiles: 0, cached_bytes: 0, worlds: 0 };
            self.front.app.0.metrics.text(&levels).expect("text").lines().any(|counted| counted == line)
        }
    }

    type Plain = (StatusCode, Vec<(HeaderName, HeaderValue)>, String);

    fn request(method: Method, path: &str, headers: &Headers, body: &str) -> Request {
        let mut request = Request::builder().method(method).uri(path).header("host", "localhost");
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        request.body(Body::from(body.to_owned())).expect("a request")
    }

    /// An answer but for what differs from one to the next.
    async fn plain(response: Response) -> Plain {
        let (mut parts, body) = response.into_parts();
        let id = parts.headers.remove("x-request-id").expect("an id");
        if id.as_bytes().starts_with(b"mine") {
            parts.headers.insert("x-request-id", id);
        }
        parts.headers.remove("server-timing");
        if parts.status == StatusCode::NOT_MODIFIED {
            // The router counts the bytes that there are, which then are not told.
            parts.headers.remove(header::CONTENT_LENGTH);
        }
        let mut headers: Vec<_> = parts.headers.into_iter().filter_map(|(name, value)| Some((name?, value))).collect();
        headers.sort_by(|one, other| one.0.as_str().cmp(other.0.as_str()));
        let body = to_bytes(body, usize::MAX).await.expect("a body");
        (parts.status, headers, Sha256::digest(&body).iter().map(|byte| format!("{byte:02x}")).collect())
    }

    const TILE: &str = "/worlds/hills/web/terrarium/9/256/255.png";

    #[tokio::test]
    async fn what_is_recalled_is_what_the_router_answers() {
        let server = Server::start(|_| {}).await;
        let revision = server.front.app.0.worlds.shelf.get("hills").expect("a world").world.revision().to_string();
        let pinned = TILE.replace("hills", &format!("hills@{revision}"));
        let others = ["/worlds/hills/web/contours/9/256/255.mvt?filter=exact", "/worlds/hills/metric/r32/3/1/0@33.bin?rows=south&order=be"];
        for path in [TILE, &pinned].into_iter().chain(others) {
            assert_eq!(server.recalled(path, &[]).await, None, "nobody has asked for it");
            let first = server.made(Method::GET, path, &[], "").await;
            let tag = first.1.iter().find(|(name, _)| *name == header::ETAG).expect("a tag").1.clone();
            let tag: &'static str = Box::leak(tag.to_str().expect("text").to_owned().into_boxed_str());
            let cases: [&Headers; 7] = [
                &[],
                &[("x-request-id", "mine")],
                &[("origin", "https://maps.example.org"), ("access-control-request-headers", "x")],
                &[("if-none-match", tag)],
                &[("if-none-match", "\"a\", W/\"b\""), ("range", "bytes=0-9")],
                &[("if-none-match", "*"), ("x-request-id", "mine too")],
                &[("authorization", "Bearer of nothing"), ("priority", "u=5"), ("accept", "text/plain")],
            ];
            for headers in cases {
                let recalled = server.recalled(path, headers).await.expect("asked for before");
                assert_eq!(recalled, server.made(Method::GET, path, headers, "").await, "{path} {headers:?}");
            }
            assert_eq!(server.recalled(path, &[]).await, Some(first));
        }
        let route = r#"terrane_requests_total{method="GET",route="/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}",status="#;
        assert!(server.counted(&format!("{route}\"200\"}} 48")) && server.counted(&format!("{route}\"304\"}} 16")), "one series for both");
        assert!(server.counted("terrane_tile_lookups_total{result=\"hit\"} 45"));
    }

    #[tokio::test]
    async fn nothing_is_recalled_of_what_may_differ() {
        let server = Server::start(|_| {}).await;
        for path in ["/worlds/hills/geo/quantized-mesh/3/8/4.terrain", "/worlds/hills/metric/r32/3/1/0@33.json", "/worlds/hills", "/worlds/hills/web/terrarium"]
        {
            assert_eq!(server.made(Method::GET, path, &[], "").await.0, StatusCode::OK);
            assert_eq!(server.recalled(path, &[]).await, None, "{path}");
        }
        assert_eq!(server.made(Method::HEAD, TILE, &[], "").await.0, StatusCode::OK);
        assert_eq!(server.made(Method::GET, TILE, &[("if-none-match", "*")], "").await.0, StatusCode::NOT_MODIFIED);
        assert_eq!(server.recalled(TILE, &[]).await, None, "there was no body");
    }

    #[tokio::test]
    async fn a_world_that_changed_is_forgotten() {
        let server = Server::start(|_| {}).await;
        let put = async |seed: u64| {
            let world = format!(r#"{{"seed":{seed},"base":{{"programme":"fbm(1, 2, 8)","scale":20000}}}}"#);
            let (status, headers, _) = server.made(Method::PUT, "/worlds/mine", &[], &world).await;
            assert!(status.is_success());
            let tag = headers.iter().find(|(name, _)| *name == header::ETAG).expect("a tag").1.clone();
            tag.to_str().expect("text").trim_matches('"').to_owned()
        };
        let revision = put(1).await;
        let paths = ["mine".to_owned(), format!("mine@{revision}")].map(|world| TILE.replace("hills", &world));
        let ask = async || [server.made(Method::GET, &paths[0], &[], "").await, server.made(Method::GET, &paths[1], &[], "").await];
        let old = ask().await;
        put(2).await;
        for path in &paths {
            assert_eq!(server.recalled(path, &[]).await, None);
        }
        let new = ask().await;
        assert!(new[0].2 != old[0].2 && new[1] == old[1]);
        for (path, new) in paths.iter().zip(new) {
            assert_eq!(server.recalled(path, &[]).await, Some(new));
        }
        assert!(server.made(Method::DELETE, "/worlds/mine", &[], "").await.0.is_success());
        for path in &paths {
            assert_eq!(server.recalled(path, &[]).await, None);
        }
        let server = Server::start(|config| config.cache.tile_bytes = 70_000).await;
        assert_eq!(server.made(Method::GET, TILE, &[], "").await.0, StatusCode::OK);
        assert_eq!(server.recalled(TILE, &[]).await, None, "its bytes have no room");
    }

    #[tokio::test]
    async fn what_is_recalled_is_paid_for_and_needs_its_key() {
        let server = Server::start(|config| {
            config.server.proxies = 1;
            config.limits.client_requests = 4;
        })
        .await;
        let client: &Headers = &[("x-forwarded-for", "192.0.2.1")];
        assert_eq!(server.made(Method::GET, TILE, client, "").await.0, StatusCode::OK);
        for _ in 0..3 {
            assert!(server.recalled(TILE, client).await.is_some());
        }
        assert_eq!(server.recalled(TILE, client).await, None);
        assert_eq!(server.made(Method::GET, TILE, client, "").await.0, StatusCode::TOO_MANY_REQUESTS);

        let folder = tempfile::tempdir().expect("a folder");
        let store = Store::open(folder.path()).await.expect("a store");
        let (_, secret) = store.add_key("test", Scope::Read).await.expect("a key");
        store.close().await;
        drop(store);
        let key: &Headers = &[("authorization", Box::leak(format!("Bearer {secret}").into_boxed_str()))];
        let server = Server::over(folder, |config| config.server.reads = Reads::Keys).await;
        assert_eq!(server.made(Method::GET, TILE, key, "").await.0, StatusCode::OK);
        assert!(server.recalled(TILE, key).await.is_some());
        assert_eq!(server.recalled(TILE, &[]).await, None);
        assert_eq!(server.made(Method::GET, TILE, &[], "").await.0, StatusCode::UNAUTHORIZED);
    }
}
