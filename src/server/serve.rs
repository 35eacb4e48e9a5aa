//! From configuration to a listening server, and to its end.

use super::{
    config::{Config, LimitsConfig, Reads},
    connections::{self, Limits},
    recall::Front,
    state::{App, StartError},
};
use std::{sync::Arc, time::Duration};
use tokio::{net::TcpListener, signal, sync::watch};

/// Open files for anything but connections.
const OTHER_FILES: usize = 64;

/// Serves until SIGINT or SIGTERM, then lets requests under way finish within the drain time or until it is asked again.
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
        let reads = if config.server.reads == Reads::Open { "reads are open, writes need" } else { "reads and writes need" };
        tracing::info!("other machines reach this address: {reads} a key (terrane key new)");
    }

    tell("READY=1");
    let (stops, mut stopped) = watch::channel(false);
    let stopping = app.clone();
    tokio::spawn(async move {
        stop_signal().await;
        stopping.drain();
        tracing::info!("stopping: finishing requests under way");
        tell("STOPPING=1");
        // Those who listen may have ended.
        let _ = stops.send(true);
    });
    let mut stop = stopped.clone();
    let stop = async move {
        // An error means that nobody will ever say so.
        if stop.wait_for(|stop| *stop).await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    let late = async {
        if stopped.wait_for(|stop| *stop).await.is_err() {
            std::future::pending::<()>().await;
        }
        tokio::select! {
            () = tokio::time::sleep(Duration::from_secs(config.server.drain_seconds)) => tracing::info!("the drain time is over"),
            () = stop_signal() => tracing::info!("asked again to stop"),
        }
    };
    tokio::select! {
        () = connections::serve(listener, Front::new(app.clone()), Arc::clone(&app.0.metrics), limits(config), stop) => {}
        () = late => {}
    }
    app.close().await;
    tracing::info!("stopped");
    Ok(())
}

/// Tells the service manager that started the server how it is, if one did and asks for that (`sd_notify`, `Type=notify`).
#[cfg(unix)]
fn tell(state: &str) {
    if let Err(error) = sd_notify::notify(&[sd_notify::NotifyState::Custom(state)]) {
        tracing::warn!(%error, "the service manager could not be told {state}");
    }
}

#[cfg(not(unix))]
fn tell(_: &str) {}

/// What connections are held to. Every connection needs an open file.
fn limits(config: &Config) -> Limits {
    let wanted = config.server.connections;
    let files = rlimit::increase_nofile_limit((wanted + OTHER_FILES) as u64).unwrap_or(u64::MAX);
    let connections = wanted.min(usize::try_from(files).unwrap_or(usize::MAX).saturating_sub(OTHER_FILES)).max(1);
    if connections < wanted {
        tracing::warn!("the system allows {files} open files, which is enough for {connections} connections, not for {wanted}");
    }
    let LimitsConfig { requests, head_seconds, stall_seconds, .. } = config.limits;
    Limits { connections, requests, head: Duration::from_secs(head_seconds), stall: Duration::from_secs(stall_seconds) }
}

/// Waits for SIGINT or SIGTERM.
pub async fn stop_signal() {
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
