//! Connections: accepted, held to deadlines, and let go.

use super::{
    access::Peer,
    error::ApiError,
    metrics::Metrics,
    pace::{PacedBody, PacedStream},
    recall::Front,
};
use axum::{body::Body, extract::Request, response::IntoResponse};
use hyper::{body::Incoming, server::conn::http1, service::service_fn};
use hyper_util::{
    rt::{TokioIo, TokioTimer},
    server::graceful::GracefulShutdown,
};
use std::{convert::Infallible, io, net::IpAddr, pin::pin, sync::Arc, time::Duration};
use tokio::{
    net::{TcpListener, TcpStream},
    sync::{OwnedSemaphorePermit, Semaphore},
};

/// Bytes that the head of a request may have.
const HEAD_BYTES: usize = 64 * 1024;

/// How long to wait when the system has no room for another connection.
const NO_ROOM: Duration = Duration::from_millis(100);

/// What connections are held to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Connections at a time; others wait in the system's queue.
    pub connections: usize,
    /// Requests under way at a time; others are refused.
    pub requests: usize,
    /// The whole head of a request must be there so soon after the connection or the answer before it.
    pub head: Duration,
    /// How long a peer may send or take almost nothing.
    pub stall: Duration,
}

/// Everything that serves one connection.
#[derive(Clone)]
struct Service {
    front: Front,
    limits: Limits,
    requests: Arc<Semaphore>,
    metrics: Arc<Metrics>,
}

impl Service {
    async fn answer(self, peer: IpAddr, request: hyper::Request<Incoming>) -> Result<axum::response::Response, Infallible> {
        // Whoever asks whether the server lives must not be refused because it is busy.
        let is_health = matches!(request.uri().path(), "/healthz" | "/readyz");
        let room = if is_health { None } else { Some(self.requests.try_acquire_owned()) };
        if let Some(Err(_)) = room {
            self.metrics.refused("requests", 1);
            return Ok(ApiError::Busy.into_response());
        }
        if let Some(response) = self.front.recall(&request, Some(Peer(peer))) {
            return Ok(response);
        }
        let mut request: Request = request.map(|body| Body::new(PacedBody::new(body, self.limits.stall)));
        request.extensions_mut().insert(Peer(peer));
        Ok(self.front.answer(request).await)
    }

    /// Serves a connection until its end.
    fn serve(self, stream: TcpStream, peer: IpAddr, graceful: &GracefulShutdown, room: OwnedSemaphorePermit) {
        // Only a little latency is lost where this fails.
        let _ = stream.set_nodelay(true);
        let io = TokioIo::new(PacedStream::new(stream, self.limits.stall));
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(self.limits.head).max_buf_size(HEAD_BYTES);
        let open = self.metrics.connected();
        let connection = builder.serve_connection(io, service_fn(move |request| self.clone().answer(peer, request)));
        let connection = graceful.watch(connection);
        tokio::spawn(async move {
            // What a peer does wrong is no news.
            if let Err(error) = connection.await {
                tracing::debug!(%error, "a connection ended");
            }
            drop((room, open));
        });
    }
}

/// Serves connections until `stop`, then lets requests under way finish; the caller decides how long it waits for that.
pub(super) async fn serve(listener: TcpListener, front: Front, metrics: Arc<Metrics>, limits: Limits, stop: impl Future<Output = ()>) {
    let service = Service { front, limits, requests: Arc::new(Semaphore::new(limits.requests)), metrics };
    let (room, graceful) = (Arc::new(Semaphore::new(limits.connections)), GracefulShutdown::new());
    let mut stop = pin!(stop);
    loop {
        let accepted = async {
            let room = Arc::clone(&room).acquire_owned().await;
            (listener.accept().await, room)
        };
        tokio::select! {
            () = &mut stop => break,
            accepted = accepted => match accepted {
                (Ok((stream, peer)), Ok(room)) => service.clone().serve(stream, peer.ip(), &graceful, room),
                (Err(error), _) => failed(&error).await,
                // The semaphore is never closed.
                (_, Err(_)) => break,
            },
        }
    }
    drop(listener);
    graceful.shutdown().await;
}

/// A connection that ended before it was accepted is no failure; what else fails may do so again at once.
async fn failed(error: &io::Error) {
    if !matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionAborted | io::ErrorKind::ConnectionReset) {
        tracing::error!(%error, "accepting a connection failed");
        tokio::time::sleep(NO_ROOM).await;
    }
}
