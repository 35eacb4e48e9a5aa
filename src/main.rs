//! The command line: arguments and start.

mod command;

use clap::{Parser, Subcommand};
use command::{RenderArguments, ServeArguments, check, render, serve};
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
    /// Check a world document and print it completed
    Check {
        /// The document; - for standard input
        file: PathBuf,
    },
    /// Evaluate a window of a world into a file
    Render(RenderArguments),
}

fn main() -> ExitCode {
    let filter = EnvFilter::try_from_env("TERRANE_LOG").unwrap_or_else(|_| EnvFilter::new("info"));
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours).init();
    let command = Arguments::parse().command;
    let done = Isa::from_environment().map_err(anyhow::Error::msg).and_then(|_| match command {
        Command::Serve(arguments) => serve(arguments),
        Command::Check { file } => check(&file),
        Command::Render(arguments) => render(&arguments),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
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
