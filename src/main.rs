//! The command line: arguments and start.

mod command;

use clap::{Parser, Subcommand};
use command::{
    ExportArguments, GalleryArguments, HealthArguments, KeyCommand, MergeArguments, RenderArguments, ServeArguments, check, export, gallery, health, key,
    merge, render, serve,
};
use std::{
    io::{IsTerminal, Write},
    path::PathBuf,
    process::ExitCode,
};
use terrane::noise::Isa;
use tracing_subscriber::EnvFilter;

/// Streams endless, deterministic, generated terrain.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Serve worlds over HTTP
    Serve(ServeArguments),
    /// Ask the server of this machine whether it lives; fails if not
    Health(HealthArguments),
    /// Check a world document and print it completed
    Check {
        /// The document; - for standard input
        file: PathBuf,
    },
    /// Evaluate a window of a world into a file
    Render(RenderArguments),
    /// Make, show and take back the keys of a server, which takes notice, and sign addresses with them
    #[command(subcommand)]
    Key(KeyCommand),
    /// Write a pyramid of tiles to an archive; the same command goes on after any end
    Export(ExportArguments),
    /// Join the parts of an export to an archive
    Merge(MergeArguments),
    /// Draw the terrain that ships with the program as pictures
    Gallery(GalleryArguments),
}

fn main() -> ExitCode {
    let filter = EnvFilter::try_from_env("TERRANE_LOG").unwrap_or_else(|_| EnvFilter::new("info"));
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours);
    if std::env::var("TERRANE_LOG_FORMAT").is_ok_and(|format| format == "json") {
        log.json().init();
    } else {
        log.init();
    }
    let command = Arguments::parse().command;
    let done = Isa::from_environment().map_err(anyhow::Error::msg).and_then(|_| match command {
        Command::Serve(arguments) => serve(arguments).map(|()| ExitCode::SUCCESS),
        Command::Health(arguments) => health(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Check { file } => check(&file).map(|()| ExitCode::SUCCESS),
        Command::Render(arguments) => render(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Export(arguments) => export(&arguments),
        Command::Merge(arguments) => merge(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Gallery(arguments) => gallery(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Key(command) => key(command).map(|()| ExitCode::SUCCESS),
    });
    match done {
        Ok(code) => code,
        Err(error) => {
            // Standard error may be closed; the exit code still says it.
            let _ = writeln!(std::io::stderr(), "error: {}", with_causes(&error));
            ExitCode::FAILURE
        }
    }
}

/// An error and those of its causes that it does not already repeat.
fn with_causes(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            said if said.contains(&cause) => text,
            said => format!("{said}: {cause}"),
        }
    })
}
