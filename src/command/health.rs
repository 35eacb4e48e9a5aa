//! `terrane health`.

use super::config;
use anyhow::{Context, ensure};
use clap::Args;
use std::{
    io::{Read, Write},
    net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpStream},
    path::PathBuf,
    time::Duration,
};

/// How long a server may take to answer that it lives.
const PATIENCE: Duration = Duration::from_secs(5);

#[derive(Args)]
pub(crate) struct HealthArguments {
    /// Address and port of the server [default: that of its configuration]
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<SocketAddr>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Fails unless the server of this machine answers that it lives.
pub(crate) fn health(arguments: &HealthArguments) -> anyhow::Result<()> {
    let mut address = arguments.listen.map_or_else(|| config(arguments.config.as_deref()).map(|config| config.server.listen), Ok)?;
    // Who listens everywhere also listens at home.
    match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    let answer = ask(address).with_context(|| format!("asking http://{address}/healthz"))?;
    let line = answer.lines().next().unwrap_or_default();
    ensure!(line.split(' ').nth(1) == Some("200"), "http://{address}/healthz answered {line:?}");
    Ok(())
}

fn ask(address: SocketAddr) -> std::io::Result<String> {
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    write!(stream, "GET /healthz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n")?;
    let mut answer = String::new();
    stream.take(4096).read_to_string(&mut answer)?;
    Ok(answer)
}
