//! From configuration to a listening server, and to its end.

use super::{
    config::Config,
    router,
    state::{App, StartError},
};
use std::{future::IntoFuture, time::Duration};
use tokio::{net::TcpListener, signal, sync::oneshot};

/// Serves until SIGINT or SIGTERM, then lets requests under way finish within the drain time.
///
/// # Errors
/// If the store, the threads or the address cannot be used.
pub async fn serve(config: &Config) -> Result<(), StartError> {
    let app = App::load(config).await?;
    let listen = |source| StartError::Listen { address: config.server.listen, source };
    let listener = TcpListener::bind(config.server.listen).await.map_err(listen)?;
    let address = listener.local_addr().map_err(listen)?;
    tracing::info!("listening on http://{address}");
    if !address.ip().is_loopback() {
        tracing::info!("other machines reach this address, so worlds can only be read: writes answer 403");
    }

    let (drained, draining) = oneshot::channel();
    let stopping = app.clone();
    let stop = async move {
        stop_signal().await;
        stopping.drain();
        tracing::info!("stopping: finishing requests under way");
        let _ = drained.send(());
    };
    let serving = axum::serve(listener, router(app.clone())).with_graceful_shutdown(stop).into_future();
    let deadline = async {
        // Without a signal there is no deadline.
        if draining.await.is_err() {
            std::future::pending::<()>().await;
        }
        tokio::time::sleep(Duration::from_secs(config.server.drain_seconds)).await;
    };
    tokio::select! {
        served = serving => served.map_err(StartError::Serve)?,
        () = deadline => tracing::info!("the drain time is over"),
    }
    app.close().await;
    tracing::info!("stopped");
    Ok(())
}

async fn stop_signal() {
    let interrupt = async {
        if signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    #[cfg(unix)]
    let terminate = async {
        match signal::unix::signal(signal::unix::SignalKind::terminate()) {
            Ok(mut terminate) => {
                terminate.recv().await;
            }
            Err(_) => std::future::pending().await,
        }
    };
    #[cfg(not(unix))]
    let terminate = std::future::pending::<()>();
    tokio::select! {
        () = interrupt => {}
        () = terminate => {}
    }
}
