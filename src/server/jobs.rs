//! Long work: asked for once, done one after the other on threads of its own, kept in the store until it is done.

use super::{
    compute::{Compute, Panicked},
    error::ApiError,
    events::{Event, Events},
};
use crate::{
    geometry::Stop,
    store::{JobEntry, JobState, Store, StoreError},
    world::{StoredRaster, Work},
};
use std::{
    collections::VecDeque,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};
use tokio::{sync::Notify, task::JoinHandle};

/// A job that is not ended.
pub(super) struct Task {
    id: String,
    work: Work,
    stop: Stop,
    steps: AtomicUsize,
    done: AtomicUsize,
}

/// How far a job is.
pub(super) enum Progress {
    Waiting,
    /// The share that is done.
    Running(f64),
}

#[derive(Default)]
struct Open {
    waiting: VecDeque<Arc<Task>>,
    running: Option<Arc<Task>>,
}

struct Shared {
    store: Store,
    compute: Compute,
    events: Arc<Events>,
    open: Mutex<Open>,
    changed: Notify,
    closing: AtomicBool,
}

/// The jobs of a server.
pub(super) struct Jobs {
    shared: Arc<Shared>,
    runner: Mutex<Option<JoinHandle<()>>>,
    /// Most that wait.
    most: usize,
}

/// How a job ended.
enum End {
    Made(Box<StoredRaster>),
    Stopped,
    Failed(String),
}

impl Task {
    fn new(id: String, work: Work) -> Arc<Self> {
        Arc::new(Self { id, work, stop: Stop::new(), steps: AtomicUsize::new(0), done: AtomicUsize::new(0) })
    }

    fn work(&self) -> End {
        let prepared = match self.work.prepare() {
            Ok(prepared) => prepared,
            Err(error) => return End::Failed(error.to_string()),
        };
        self.steps.store(prepared.steps(), Ordering::Relaxed);
        let made = prepared.run(&self.stop, &|done| {
            // Threads may say so out of turn.
            self.done.fetch_max(done, Ordering::Relaxed);
        });
        made.map_or(End::Stopped, |raster| End::Made(Box::new(StoredRaster::of(&raster))))
    }

    fn share(&self) -> f64 {
        let (done, steps) = (self.done.load(Ordering::Relaxed), self.steps.load(Ordering::Relaxed));
        if steps == 0 { 0.0 } else { done as f64 / steps as f64 }
    }
}

impl Shared {
    fn open(&self) -> MutexGuard<'_, Open> {
        // It is whole at every point where a holder could panic.
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does what waits, one after the other, until the server closes.
    async fn run(self: Arc<Self>) {
        while !self.closing.load(Ordering::Relaxed) {
            let next = {
                let mut open = self.open();
                open.running = open.waiting.pop_front();
                open.running.clone()
            };
            let Some(task) = next else {
                self.changed.notified().await;
                continue;
            };
            self.tell(&task.id, "running", 0.0);
            let working = Arc::clone(&task);
            let end = self.compute.run(move || working.work()).await;
            let end = end.unwrap_or_else(|Panicked| End::Failed("the evaluation failed; the server's log says why".to_owned()));
            let (kept, state) = match end {
                End::Made(raster) => (self.store.finish(&task.id, &raster).await, "done"),
                End::Failed(failure) => {
                    tracing::warn!(job = task.id, failure, "a job failed");
                    (self.store.fail(&task.id, &failure).await, "failed")
                }
                // Forgotten, or to be done when the server is there again.
                End::Stopped => (Ok(()), "stopped"),
            };
            let share = if state == "done" { 1.0 } else { task.share() };
            match kept {
                Ok(()) => self.tell(&task.id, state, share),
                Err(error) => {
                    tracing::error!(job = task.id, %error, "the end of a job could not be stored: it will be done again when the server starts");
                }
            }
            self.open().running = None;
        }
    }

    fn tell(&self, job: &str, state: &'static str, progress: f64) {
        self.events.send(Event::Job { job: job.to_owned(), state, progress });
    }
}

impl Jobs {
    /// Takes up the jobs that the store knows to be open.
    pub(super) async fn load(store: Store, compute: Compute, events: &Arc<Events>, most: usize) -> Result<Self, StoreError> {
        let mut open = Open::default();
        for JobEntry { id, work, .. } in store.open_jobs().await? {
            match Work::parse(work.as_bytes()) {
                Ok(work) => open.waiting.push_back(Task::new(id, work)),
                Err(error) => store.fail(&id, &error.to_string()).await?,
            }
        }
        let shared =
            Arc::new(Shared { store, compute, events: Arc::clone(events), open: Mutex::new(open), changed: Notify::new(), closing: AtomicBool::new(false) });
        let runner = tokio::spawn(Arc::clone(&shared).run());
        Ok(Self { shared, runner: Mutex::new(Some(runner)), most })
    }

    /// Asks for work; on return that is on disk. What was asked for before is not asked for again, unless it failed.
    pub(super) async fn ask(&self, work: Work) -> Result<JobEntry, ApiError> {
        let id = work.id().to_string();
        // What is known already takes no room.
        if self.shared.open().waiting.len() >= self.most && self.shared.store.job(&id).await?.is_none() {
            return Err(ApiError::Queued);
        }
        let entry = self.shared.store.ask(&id, &work.to_json().to_string()).await?;
        if entry.state == JobState::Open {
            let mut open = self.shared.open();
            let Open { waiting, running } = &mut *open;
            if !running.iter().chain(waiting.iter()).any(|task| task.id == id && !task.stop.is_set()) {
                waiting.push_back(Task::new(id, work));
                self.shared.changed.notify_one();
            }
        }
        Ok(entry)
    }

    /// How far a job is that is not ended.
    pub(super) fn progress(&self, id: &str) -> Progress {
        let running = self.shared.open().running.clone();
        running.filter(|task| task.id == id).map_or(Progress::Waiting, |task| Progress::Running(task.share()))
    }

    /// Forgets a job, and ends it if it is under way. `false` if there is none.
    pub(super) async fn forget(&self, id: &str) -> Result<bool, StoreError> {
        let known = self.shared.store.forget(id).await?;
        let mut open = self.shared.open();
        open.waiting.retain(|task| task.id != id);
        if let Some(task) = open.running.as_ref().filter(|task| task.id == id) {
            task.stop.set();
        }
        Ok(known)
    }

    /// Ends what is under way, which the store keeps for the next start.
    pub(super) async fn close(&self) {
        self.shared.closing.store(true, Ordering::Relaxed);
        if let Some(task) = &self.shared.open().running {
            task.stop.set();
        }
        self.shared.changed.notify_one();
        let runner = self.runner.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(runner) = runner
            && let Err(error) = runner.await
        {
            tracing::error!(%error, "the jobs ended badly");
        }
    }
}
