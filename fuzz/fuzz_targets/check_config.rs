//! What must hold for any text that is taken as a configuration and its variables of the environment. The tests of the package run it over the corpus.

use terrane::server::Config;

/// Lines that begin with `$` are variables of the environment.
pub(crate) fn check(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let (variables, lines): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('$'));
    let variables = variables.iter().filter_map(|line| line[1..].split_once('=')).map(|(name, value)| (name.to_owned(), value.to_owned()));
    match Config::load(&lines.join("\n"), variables) {
        Ok(config) => config.check().expect("what was loaded was checked"),
        Err(error) => assert!(!error.0.is_empty() && error.0.iter().all(|problem| !problem.is_empty())),
    }
}
