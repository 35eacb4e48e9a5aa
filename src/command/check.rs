//! `terrane check`.

use super::parse;
use anyhow::Context;
use std::{fs, io::Write, path::Path};

/// Prints a document completed.
pub(crate) fn check(file: &Path) -> anyhow::Result<()> {
    let bytes = if file == Path::new("-") { std::io::read_to_string(std::io::stdin()).map(String::into_bytes) } else { fs::read(file) };
    let document = parse(&bytes.with_context(|| format!("reading {}", file.display()))?, &file.display().to_string())?;
    writeln!(std::io::stdout(), "{}", document.to_json()).context("writing")
}
