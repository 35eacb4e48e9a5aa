//! How far long work is, for whoever watches: a bar on a terminal, a plain line now and then elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::{
    io::{IsTerminal, Write},
    time::{Duration, Instant},
};

/// Between two plain lines.
const PLAIN: Duration = Duration::from_secs(10);

/// Counts tiles.
pub(crate) struct Progress {
    /// On a terminal.
    bar: Option<ProgressBar>,
    label: String,
    total: u64,
    /// Tiles that were there before.
    first: u64,
    start: Instant,
    said: Instant,
}

impl Progress {
    /// For `total` tiles, some of which are there already.
    pub(crate) fn new(label: &str, first: u64, total: u64) -> Self {
        let now = Instant::now();
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {human_pos} of {human_len} tiles, {per_sec}, {eta} left");
            let bar = ProgressBar::new(total).with_style(style.unwrap_or_else(|_unread| ProgressStyle::default_bar())).with_message(label.to_owned());
            // What was there before says nothing of how fast it goes now.
            bar.set_position(first);
            bar.reset_eta();
            bar
        });
        Self { bar, label: label.to_owned(), total, first, start: now, said: now }
    }

    /// So many tiles are there now.
    pub(crate) fn at(&mut self, done: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        } else if self.said.elapsed() >= PLAIN {
            self.said = Instant::now();
            let rate = (done - self.first) as f64 / self.start.elapsed().as_secs_f64();
            let left = (self.total - done) as f64 / rate.max(1e-9);
            // Standard error may be closed.
            let _ = writeln!(std::io::stderr(), "{}: {done} of {} tiles, {rate:.1} a second, {left:.0} s left", self.label, self.total);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            // What is said next stands below it.
            bar.abandon();
        }
    }
}
