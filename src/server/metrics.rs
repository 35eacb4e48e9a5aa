//! What the server counts and measures, for Prometheus.

use super::tiles::Order;
use prometheus_client::{
    encoding::{EncodeLabelSet, text::encode},
    metrics::{counter::Counter, family::Family, gauge::Gauge, histogram::Histogram},
    registry::Registry,
};
use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

/// Upper ends of the buckets of times, in seconds.
const SECONDS: [f64; 14] = [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0];

/// A label and its value.
type Label = [(&'static str, &'static str); 1];

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    method: &'static str,
    route: Arc<str>,
    status: u16,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Route {
    route: Arc<str>,
}

fn times() -> Histogram {
    Histogram::new(SECONDS)
}

type Times<L> = Family<L, Histogram, fn() -> Histogram>;

/// All counts and measures of a server.
pub(super) struct Metrics {
    registry: Registry,
    answers: Family<Answered, Counter>,
    answer_seconds: Times<Route>,
    evaluations: Family<[(&'static str, &'static str); 2], Counter>,
    evaluation_seconds: Times<Label>,
    queue_seconds: Times<Label>,
    lookups: Family<Label, Counter>,
    refusals: Family<Label, Counter>,
    cancellations: Family<Label, Counter>,
    panics: Family<Label, Counter>,
    connections: Gauge,
    waiting: Family<Label, Gauge>,
    evaluating: Gauge,
    cached_tiles: Gauge,
    cached_bytes: Gauge,
    worlds: Gauge,
    made: AtomicU64,
}

/// What is read when somebody asks, rather than counted.
pub(super) struct Levels {
    pub waiting: [(&'static str, usize); 2],
    pub evaluating: usize,
    pub cached_tiles: usize,
    pub cached_bytes: u64,
    pub worlds: usize,
}

impl Metrics {
    pub(super) fn new() -> Self {
        let mut metrics = Self {
            registry: Registry::with_prefix("terrane"),
            answers: Family::default(),
            answer_seconds: Times::new_with_constructor(times),
            evaluations: Family::default(),
            evaluation_seconds: Times::new_with_constructor(times),
            queue_seconds: Times::new_with_constructor(times),
            lookups: Family::default(),
            refusals: Family::default(),
            cancellations: Family::default(),
            panics: Family::default(),
            connections: Gauge::default(),
            waiting: Family::default(),
            evaluating: Gauge::default(),
            cached_tiles: Gauge::default(),
            cached_bytes: Gauge::default(),
            worlds: Gauge::default(),
            made: AtomicU64::new(0),
        };
        let registry = &mut metrics.registry;
        registry.register("requests", "Answers by method, route and status", metrics.answers.clone());
        registry.register("request_seconds", "Time until an answer's head by route", metrics.answer_seconds.clone());
        registry.register("evaluations", "Tiles evaluated by tileset and source", metrics.evaluations.clone());
        registry.register("evaluation_seconds", "Time to evaluate and encode a tile by source", metrics.evaluation_seconds.clone());
        registry.register("queue_seconds", "Time that evaluated tiles waited for a thread by class", metrics.queue_seconds.clone());
        registry.register(
            "tile_lookups",
            "Tiles asked for that were in memory (hit), on disk (disk), under way (joined) or none of these (miss)",
            metrics.lookups.clone(),
        );
        registry.register("refusals", "Requests refused because too much was under way, by reason", metrics.refusals.clone());
        registry.register("cancellations", "Tiles given up because nobody waited for them any more, by state", metrics.cancellations.clone());
        registry.register("panics", "Panics caught, by place", metrics.panics.clone());
        registry.register("connections", "Open connections", metrics.connections.clone());
        registry.register("tiles_waiting", "Tiles that wait for a thread by class", metrics.waiting.clone());
        registry.register("tiles_evaluating", "Tiles being evaluated", metrics.evaluating.clone());
        registry.register("cached_tiles", "Tiles in the memory cache", metrics.cached_tiles.clone());
        registry.register("cached_bytes", "Bytes of tiles in the memory cache", metrics.cached_bytes.clone());
        registry.register("worlds", "Worlds served", metrics.worlds.clone());
        metrics
    }

    pub(super) fn answered(&self, method: &'static str, route: &Arc<str>, status: u16, took: Duration) {
        self.answers.get_or_create(&Answered { method, route: Arc::clone(route), status }).inc();
        self.answer_seconds.get_or_create(&Route { route: Arc::clone(route) }).observe(took.as_secs_f64());
    }

    pub(super) fn evaluated(&self, order: &Order, queued: Duration, evaluated: Duration) {
        let [tileset, source] = order.kind;
        self.made.fetch_add(1, Ordering::Relaxed);
        self.evaluations.get_or_create(&[("tileset", tileset), ("source", source)]).inc();
        self.evaluation_seconds.get_or_create(&[("source", source)]).observe(evaluated.as_secs_f64());
        self.queue_seconds.get_or_create(&[("class", order.class.name())]).observe(queued.as_secs_f64());
    }

    /// How many tiles were evaluated.
    pub(super) fn evaluations(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    pub(super) fn looked_up(&self, result: &'static str) {
        self.lookups.get_or_create(&[("result", result)]).inc();
    }

    pub(super) fn refused(&self, reason: &'static str, count: u64) {
        if count > 0 {
            self.refusals.get_or_create(&[("reason", reason)]).inc_by(count);
        }
    }

    pub(super) fn cancelled(&self, state: &'static str) {
        self.cancellations.get_or_create(&[("state", state)]).inc();
    }

    pub(super) fn panicked(&self, place: &'static str) {
        self.panics.get_or_create(&[("place", place)]).inc();
    }

    /// Counts a connection until what is answered is dropped.
    pub(super) fn connected(self: &Arc<Self>) -> Connected {
        self.connections.inc();
        Connected(Arc::clone(self))
    }

    /// All of it in the text format of `OpenMetrics`.
    pub(super) fn text(&self, levels: &Levels) -> Result<String, fmt::Error> {
        for (class, waiting) in levels.waiting {
            self.waiting.get_or_create(&[("class", class)]).set(waiting as i64);
        }
        self.evaluating.set(levels.evaluating as i64);
        self.cached_tiles.set(levels.cached_tiles as i64);
        self.cached_bytes.set(levels.cached_bytes as i64);
        self.worlds.set(levels.worlds as i64);
        let mut text = String::new();
        encode(&mut text, &self.registry)?;
        Ok(text)
    }
}

/// A connection that is open.
pub(super) struct Connected(Arc<Metrics>);

impl Drop for Connected {
    fn drop(&mut self) {
        self.0.connections.dec();
    }
}
