//! The threads that evaluate terrain, apart from those that answer requests.

use crate::geometry::Stop;
use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind},
};
use tokio::sync::oneshot;

/// Of a thread for jobs, which evaluates programmes on top of what it was waiting in. Only what is used of it takes memory.
const STACK_BYTES: usize = 16 << 20;

/// A task panicked; it was logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an evaluation panicked")]
pub(super) struct Panicked;

/// A pool of threads for evaluation.
pub(super) struct Compute(rayon::ThreadPool);

impl Compute {
    /// Starts `threads` threads; 0 for one a processor.
    pub(super) fn new(name: &'static str, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(move |i| format!("{name}-{i}")).build().map(Self)
    }

    /// The same for work that nobody waits for: where the system knows of priorities, its threads run when no others want to.
    pub(super) fn last(name: &'static str, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let named = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(move |i| format!("{name}-{i}"));
        named.start_handler(|_| give_way()).stack_size(STACK_BYTES).build().map(Self)
    }

    /// How many threads it has.
    pub(super) fn threads(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs a task on the pool.
    pub(super) fn spawn(&self, task: impl FnOnce() + Send + 'static) {
        self.0.spawn(task);
    }

    /// Runs a task on the pool and waits for its result.
    pub(super) async fn run<T: Send + 'static>(&self, task: impl FnOnce() -> T + Send + 'static) -> Result<T, Panicked> {
        let (sender, receiver) = oneshot::channel();
        self.spawn(move || {
            // Nobody may be waiting any more.
            let _ = sender.send(caught(task));
        });
        receiver.await.unwrap_or(Err(Panicked))
    }
}

/// Lets other threads go first.
#[cfg(unix)]
fn give_way() {
    if let Err(error) = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Min) {
        tracing::warn!(?error, "a thread for jobs could not be told to let others go first");
    }
}

#[cfg(not(unix))]
fn give_way() {}

/// Runs a task here; a panic ends it alone.
pub(super) fn caught<T>(task: impl FnOnce() -> T) -> Result<T, Panicked> {
    catch_unwind(AssertUnwindSafe(task)).map_err(|payload| {
        let message = panic_message(&*payload);
        tracing::error!(message, "an evaluation panicked");
        Panicked
    })
}

/// Ends evaluations when who asked for them is gone.
pub(super) struct WhileAsked(Stop);

impl WhileAsked {
    pub(super) fn new() -> Self {
        Self(Stop::new())
    }

    /// What is set then.
    pub(super) fn stop(&self) -> Stop {
        self.0.clone()
    }
}

impl Drop for WhileAsked {
    fn drop(&mut self) {
        self.0.set();
    }
}

/// What a panic said, if it was text.
pub(super) fn panic_message(payload: &(dyn Any + Send)) -> &str {
    payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
