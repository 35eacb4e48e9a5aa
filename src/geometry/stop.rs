//! Work that may be given up.

use super::{Legend, Source, Surface, Window};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Says to an evaluation under way that nobody wants its result any more. Evaluations look at it every row or block; what they then leave is to be thrown away.
///
/// ```
/// use terrane::geometry::Stop;
/// let (never, stop) = (Stop::never(), Stop::new());
/// stop.clone().set();
/// assert!(stop.is_set() && !never.is_set());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Stop(Option<Arc<AtomicBool>>);

impl Stop {
    /// One that can be set.
    #[must_use]
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// One that is never set.
    #[must_use]
    pub const fn never() -> Self {
        Self(None)
    }

    /// Asks for the end, if it can be asked for; all clones say so from now on.
    pub fn set(&self) {
        if let Some(stop) = &self.0 {
            stop.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the end was asked for.
    #[must_use]
    pub fn is_set(&self) -> bool {
        self.0.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

/// Equal if they are set together.
impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (own, other) => own.is_none() && other.is_none(),
        }
    }
}

impl Eq for Stop {}

/// A source whose evaluations are given up when asked.
#[derive(Clone, Debug)]
pub struct Until<S> {
    /// What is evaluated.
    pub source: S,
    /// What ends it.
    pub stop: Stop,
}

impl<S: Source> Source for Until<S> {
    fn legend(&self) -> Legend {
        self.source.legend()
    }

    fn sample(&self, window: &Window, surface: &mut Surface) {
        surface.stop = self.stop.clone();
        self.source.sample(window, surface);
    }
}

impl<S: Source> Source for &S {
    fn legend(&self) -> Legend {
        (**self).legend()
    }

    fn sample(&self, window: &Window, surface: &mut Surface) {
        (**self).sample(window, surface);
    }
}
