//! `terrane serve`.

use super::{config, runtime};
use clap::Args;
use std::{net::SocketAddr, path::PathBuf};
use terrane::server;

#[derive(Args)]
pub(crate) struct ServeArguments {
    /// Address and port [default: 127.0.0.1:8080]
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<SocketAddr>,
    /// Folder for worlds [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Threads that evaluate tiles; 0 takes one a processor [default: 0]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// URL that clients reach the server by, base path included
    #[arg(long, value_name = "URL")]
    public_url: Option<String>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Serves until it is asked to stop.
pub(crate) fn serve(arguments: ServeArguments) -> anyhow::Result<()> {
    let mut config = config(arguments.config.as_deref())?;
    config.server.listen = arguments.listen.unwrap_or(config.server.listen);
    config.server.data = arguments.data.unwrap_or(config.server.data);
    config.server.threads = arguments.threads.unwrap_or(config.server.threads);
    config.server.public_url = arguments.public_url.unwrap_or(config.server.public_url);
    config.check()?;
    Ok(runtime()?.block_on(server::serve(&config))?)
}
