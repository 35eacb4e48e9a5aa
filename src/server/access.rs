//! Who may do what: keys, and where a request comes from.

use super::{
    budget::{Budget, Client},
    config::Reads,
    error::ApiError,
    signed::Signed,
    state::App,
};
use crate::store::{Scope, Store, StoreError, hash_of};
use arc_swap::{ArcSwap, Guard};
use axum::{
    extract::{Request, State},
    http::{self, HeaderMap, HeaderValue, Method, header, uri::Authority},
    middleware::Next,
    response::{IntoResponse, Response},
};
use std::{
    collections::HashMap,
    net::IpAddr,
    sync::Arc,
    time::{Duration, Instant},
};

/// How old what is known of the keys may be: so soon a key that was made or taken back beside the server counts.
const MAX_AGE: Duration = Duration::from_secs(1);

/// What keys guard; the rest is the viewer, the description of the interface, and the server's health.
const GUARDED: [&str; 9] = ["/worlds", "/catalog", "/wmts", "/programmes", "/breeding", "/jobs", "/rasters", "/events", "/metrics"];

/// The keys of a server, which `terrane key` changes beside it.
pub(super) struct Keys {
    store: Store,
    known: ArcSwap<Known>,
}

/// Scopes by the hashes of secrets.
struct Known {
    scopes: HashMap<String, Scope>,
    since: Instant,
}

impl Keys {
    pub(super) async fn load(store: Store) -> Result<Self, StoreError> {
        let known = Known::load(&store).await?;
        Ok(Self { store, known: ArcSwap::from_pointee(known) })
    }

    /// What is known of the keys, if it is new enough.
    fn fresh(&self) -> Option<Guard<Arc<Known>>> {
        Some(self.known.load()).filter(|known| known.since.elapsed() < MAX_AGE)
    }

    async fn known(&self) -> Result<Arc<Known>, StoreError> {
        if let Some(known) = self.fresh() {
            return Ok(Guard::into_inner(known));
        }
        let known = Arc::new(Known::load(&self.store).await?);
        self.known.store(Arc::clone(&known));
        Ok(known)
    }
}

impl Known {
    async fn load(store: &Store) -> Result<Self, StoreError> {
        let since = Instant::now();
        Ok(Self { scopes: store.keys().await?.into_iter().map(|key| (key.hash, key.scope)).collect(), since })
    }
}

/// Lets a request through that may do what it asks for.
pub(super) async fn guard(State(app): State<App>, mut request: Request, next: Next) -> Response {
    match admit(&app, &mut request).await {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    }
}

/// Finds out who asks, and whether it may ask for this now.
async fn admit(app: &App, request: &mut Request) -> Result<(), ApiError> {
    let (known, signed) = (app.0.keys.known().await?, Signed::take(request)?);
    let peer = request.extensions().get().copied();
    let (client, allowed) = check(app, &known, request, peer, signed.as_ref());
    if is_guarded(request.uri().path()) {
        app.0.budgets.take(&client, Budget::Requests, 1.0, Instant::now())?;
    }
    allowed?;
    request.extensions_mut().insert(client);
    if let Some(signed) = signed {
        request.extensions_mut().insert(signed);
    }
    Ok(())
}

/// Whether a request for what is guarded may be answered at once. If not, nothing is taken from its client's budget, and [`guard`] says why or finds out.
pub(super) fn admits<B>(app: &App, request: &http::Request<B>, peer: Option<Peer>) -> bool {
    let Some(known) = app.0.keys.fresh() else { return false };
    let (client, allowed) = check(app, &known, request, peer, None);
    allowed.is_ok() && app.0.budgets.take(&client, Budget::Requests, 1.0, Instant::now()).is_ok()
}

/// Who asks, and whether its key or its place allows this.
fn check<B>(app: &App, known: &Known, request: &http::Request<B>, peer: Option<Peer>, signed: Option<&Signed>) -> (Client, Result<(), ApiError>) {
    let (path, headers) = (request.uri().path(), request.headers());
    let client = client(known, headers, peer, app.0.proxies);
    let allowed = match (needed(request.method(), path, app.0.reads), signed) {
        (None, _) => Ok(()),
        (Some(Scope::Read), Some(signed)) if bearer(headers).is_none() => signed.check(path, known.scopes.keys()),
        (Some(needed), _) => may(app, needed, headers, known),
    };
    (client, allowed)
}

/// The other end of a request's connection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer(pub IpAddr);

/// Whose budgets a request uses: those of its key, or those of where it comes from, as the proxies that are believed have it.
fn client(known: &Known, headers: &HeaderMap, peer: Option<Peer>, proxies: usize) -> Client {
    if let Some(hash) = bearer(headers).map(hash_of).filter(|hash| known.scopes.contains_key(hash)) {
        return Client::Key(hash);
    }
    let forwarded = || {
        let lists = headers.get_all("x-forwarded-for").iter().filter_map(|list| list.to_str().ok());
        let addresses: Vec<&str> = lists.flat_map(|list| list.split(',')).map(str::trim).collect();
        addresses.get(addresses.len().checked_sub(proxies)?)?.parse::<IpAddr>().ok()
    };
    let address = if proxies == 0 { None } else { forwarded() };
    address.or(peer.map(|Peer(address)| address)).map_or(Client::Local, Client::at)
}

fn may(app: &App, needed: Scope, headers: &HeaderMap, known: &Known) -> Result<(), ApiError> {
    if let Some(secret) = bearer(headers) {
        let scope = known.scopes.get(&hash_of(secret)).ok_or(ApiError::Unauthorized("There is no such key, or it was taken back."))?;
        return if *scope >= needed { Ok(()) } else { Err(ApiError::Scope(needed)) };
    }
    if !matches!(needed, Scope::Play | Scope::Write) || !known.scopes.is_empty() {
        return Err(ApiError::Unauthorized("This needs a key (Authorization: Bearer KEY) or a signed address."));
    }
    if !app.0.is_local || !is_local(headers) {
        return Err(ApiError::ReadOnly);
    }
    if is_cross_site(headers) { Err(ApiError::CrossSite) } else { Ok(()) }
}

/// What a request's key must be for; `None` where it needs none.
pub(super) fn needed(method: &Method, path: &str, reads: Reads) -> Option<Scope> {
    match *method {
        Method::OPTIONS => None,
        Method::GET | Method::HEAD => (reads == Reads::Keys && is_guarded(path)).then_some(if path == "/metrics" { Scope::Admin } else { Scope::Read }),
        // Questions that are too long for an address.
        Method::POST if path.starts_with("/worlds/") && ["/elevation", "/accessibility", "/statistics"].iter().any(|question| path.ends_with(question)) => {
            (reads == Reads::Keys).then_some(Scope::Read)
        }
        _ if is_play(path) => Some(Scope::Play),
        _ => Some(Scope::Write),
    }
}

/// Whether a path is one that players write to.
fn is_play(path: &str) -> bool {
    let Some((_, rest)) = path.strip_prefix("/worlds/").and_then(|path| path.split_once('/')) else { return false };
    rest == "feedback" || rest.starts_with("players/")
}

/// Whether a path is one of what keys and budgets guard.
fn is_guarded(path: &str) -> bool {
    GUARDED.iter().any(|guarded| path.strip_prefix(guarded).is_some_and(|rest| rest.is_empty() || rest.starts_with('/')))
}

/// The secret of a key.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, secret) = headers.get(header::AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| secret.trim())
}

/// Whether a request was made to this machine by its own name and came through no proxy. A name that merely resolves to this machine may be a stranger's.
fn is_local(headers: &HeaderMap) -> bool {
    let proxied = ["forwarded", "via", "x-forwarded-for", "x-forwarded-host", "x-forwarded-proto", "x-real-ip"].iter().any(|name| headers.contains_key(*name));
    let authority = headers.get(header::HOST).and_then(|host| host.to_str().ok()).and_then(|host| host.parse::<Authority>().ok());
    let loopback = authority.is_some_and(|authority| {
        let host = authority.host();
        host == "localhost" || host.trim_matches(['[', ']']).parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
    });
    loopback && !proxied
}

/// Whether a browser says that the page behind a request is not one of this server's.
fn is_cross_site(headers: &HeaderMap) -> bool {
    let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
    let host = headers.get(header::HOST).map(HeaderValue::as_bytes);
    let origin = headers.get(header::ORIGIN).map(HeaderValue::as_bytes);
    let own = origin.is_none_or(|origin| host.is_some_and(|host| origin.strip_prefix(b"http://") == Some(host)));
    !own || !matches!(site, None | Some(b"same-origin" | b"none"))
}
