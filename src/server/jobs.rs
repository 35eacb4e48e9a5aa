//! Long work: asked for once, done on threads of its own, kept in the store step by step until it is done.

use super::{
    compute::{Compute, Panicked},
    error::ApiError,
    events::{Event, Events},
};
use crate::{
    geometry::Stop,
    store::{JobEntry, JobState, Step, Store, StoreError, pack},
    world::{Checkpoint, Course, DocumentError, Share, StoredRaster, Turn, Work},
};
use std::{
    collections::VecDeque,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    time::{Duration, Instant},
};
use tokio::{sync::Notify, task::JoinHandle};

/// How often at most the progress of a job is told.
const TELLING: Duration = Duration::from_millis(250);

/// How long work of many steps goes on before it lets what waits go first.
const PATIENCE: Duration = Duration::from_secs(2);

/// A job that is not ended.
pub(super) struct Task {
    id: String,
    work: Work,
    stop: Stop,
    steps: AtomicUsize,
    done: AtomicUsize,
    /// When its progress was told last.
    told: Mutex<Option<Instant>>,
}

/// How far a job is.
pub(super) enum Progress {
    Waiting,
    /// The share that is done of what is not done step by step.
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
    /// Held while a job is asked for, laid aside or forgotten, so that the store and the queue say the same.
    changes: tokio::sync::Mutex<()>,
    /// Most that wait.
    most: usize,
}

/// How a job's time on the threads ended.
enum End {
    /// What it came to is stored.
    Done,
    /// Others go first now.
    GaveWay,
    /// It was laid aside, forgotten, or is to go on when the server is there again.
    Stopped,
    Failed(String),
}

/// What a turn came to, ready to be stored.
enum Made {
    Raster(Box<StoredRaster>),
    /// A step, and how to go on after it.
    Step(Box<Step>, Option<Course>),
}

impl Task {
    fn new(id: String, work: Work) -> Arc<Self> {
        Arc::new(Self { id, work, stop: Stop::new(), steps: AtomicUsize::new(0), done: AtomicUsize::new(0), told: Mutex::new(None) })
    }

    /// Takes a turn; `None` if it was stopped.
    fn turn(&self, course: Course, events: &Events) -> Result<Option<Made>, String> {
        let made = course.turn(&self.stop, &|share| self.progress(share, events));
        let step = |checkpoint: &Checkpoint, course: Option<Course>| {
            let step = step(checkpoint, course.is_none()).map_err(|error| error.to_string())?;
            Ok::<_, String>(Made::Step(Box::new(step), course))
        };
        Ok(match made.map_err(|error| error.to_string())? {
            None => None,
            Some(Turn::Raster(raster)) => Some(Made::Raster(Box::new(StoredRaster::of(&raster)))),
            Some(Turn::On(course, checkpoint)) => Some(step(&checkpoint, Some(course))?),
            Some(Turn::Found(checkpoint)) => Some(step(&checkpoint, None)?),
        })
    }

    /// Notes what is done, and tells it if it was not told just now.
    fn progress(&self, Share { done, of }: Share, events: &Events) {
        self.steps.store(of, Ordering::Relaxed);
        // Threads may say so out of turn.
        self.done.fetch_max(done, Ordering::Relaxed);
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.is_none_or(|told| told.elapsed() >= TELLING) {
            *told = Some(Instant::now());
            events.send(Event::Job { job: self.id.clone(), state: "running", progress: self.share() });
        }
    }

    fn share(&self) -> f64 {
        let (done, steps) = (self.done.load(Ordering::Relaxed), self.steps.load(Ordering::Relaxed));
        if steps == 0 { 0.0 } else { done as f64 / steps as f64 }
    }
}

/// A checkpoint as the store keeps it.
fn step(checkpoint: &Checkpoint, is_last: bool) -> Result<Step, serde_json::Error> {
    Ok(Step {
        number: checkpoint.step as i64,
        of: checkpoint.steps as i64,
        line: serde_json::to_string(&checkpoint.line)?,
        found: serde_json::to_string(&checkpoint.found)?,
        state: if is_last { Vec::new() } else { pack(&checkpoint.state) },
        is_last,
    })
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
            self.tell(&task, "running");
            let end = self.work(&task).await.unwrap_or_else(|error| {
                tracing::error!(job = task.id, %error, "a job could not be stored: it goes on from its last checkpoint when the server starts");
                End::Stopped
            });
            match &end {
                End::Done => self.events.send(Event::Job { job: task.id.clone(), state: "done", progress: 1.0 }),
                End::GaveWay => self.tell(&task, "waiting"),
                End::Stopped => self.tell(&task, "stopped"),
                End::Failed(failure) => {
                    tracing::warn!(job = task.id, failure, "a job failed");
                    match self.store.fail(&task.id, failure).await {
                        Ok(()) => self.tell(&task, "failed"),
                        Err(error) => {
                            tracing::error!(job = task.id, %error, "the end of a job could not be stored: it will be done again when the server starts");
                        }
                    }
                }
            }
            let mut open = self.open();
            open.running = None;
            if matches!(end, End::GaveWay) && !task.stop.is_set() {
                open.waiting.push_back(task);
            }
        }
    }

    fn tell(&self, task: &Task, state: &'static str) {
        self.events.send(Event::Job { job: task.id.clone(), state, progress: task.share() });
    }

    /// Does a job until it ends or others should go first; every step is stored before the next begins.
    async fn work(&self, task: &Arc<Task>) -> Result<End, StoreError> {
        // Those that asked for it may have laid it aside and asked again, while it came to its end.
        if self.store.job(&task.id).await?.is_none_or(|entry| entry.state != JobState::Open) {
            return Ok(End::Stopped);
        }
        let mut course = match self.begin(task).await? {
            Ok(course) => course,
            Err(failure) => return Ok(End::Failed(failure)),
        };
        let begun = Instant::now();
        loop {
            let (working, events) = (Arc::clone(task), Arc::clone(&self.events));
            let made = self.compute.run(move || working.turn(course, &events)).await;
            let made = made.unwrap_or_else(|Panicked| Err("the evaluation failed; the server's log says why".to_owned()));
            course = match made {
                Err(failure) => return Ok(End::Failed(failure)),
                Ok(None) => return Ok(End::Stopped),
                Ok(Some(Made::Raster(raster))) => {
                    self.store.finish(&task.id, &raster).await?;
                    return Ok(End::Done);
                }
                Ok(Some(Made::Step(step, next))) => {
                    let is_waited_for = self.store.advance(&task.id, &step).await?;
                    if is_waited_for && next.is_some() {
                        task.progress(Share { done: step.number as usize, of: step.of as usize }, &self.events);
                    }
                    match next {
                        None => return Ok(End::Done),
                        Some(_) if !is_waited_for || task.stop.is_set() => return Ok(End::Stopped),
                        Some(next) => next,
                    }
                }
            };
            if begun.elapsed() >= PATIENCE && !self.open().waiting.is_empty() {
                return Ok(End::GaveWay);
            }
        }
    }

    /// A job from its checkpoint, or from its beginning.
    async fn begin(&self, task: &Arc<Task>) -> Result<Result<Course, String>, StoreError> {
        let state = self.store.state(&task.id).await?;
        let begin = async |state: Option<Vec<u8>>| {
            let task = Arc::clone(task);
            let begun = self.compute.run(move || task.work.begin(state.as_deref())).await;
            begun.unwrap_or_else(|Panicked| Err(DocumentError::Syntax("the server's log says why".to_owned())))
        };
        let is_new = state.is_none();
        match begin(state).await {
            Ok(course) => Ok(Ok(course)),
            Err(error) if is_new => Ok(Err(error.to_string())),
            Err(error) => {
                tracing::warn!(job = task.id, %error, "a checkpoint is not one of this version: the job begins anew");
                self.store.rewind(&task.id).await?;
                Ok(begin(None).await.map_err(|error| error.to_string()))
            }
        }
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
        let events = Arc::clone(events);
        let shared = Arc::new(Shared { store, compute, events, open: Mutex::new(open), changed: Notify::new(), closing: AtomicBool::new(false) });
        let runner = tokio::spawn(Arc::clone(&shared).run());
        Ok(Self { shared, runner: Mutex::new(Some(runner)), changes: tokio::sync::Mutex::new(()), most })
    }

    /// Asks for work; on return that is on disk. What was asked for before is not asked for again, unless it failed; what was laid aside goes on.
    pub(super) async fn ask(&self, work: Work) -> Result<JobEntry, ApiError> {
        let id = work.id().to_string();
        let _change = self.changes.lock().await;
        let known = self.shared.store.job(&id).await?;
        // What takes no room in the queue is always answered.
        let takes_room = known.is_none_or(|entry| matches!(entry.state, JobState::Stopped | JobState::Failed(_)));
        if takes_room && self.shared.open().waiting.len() >= self.most {
            return Err(ApiError::Queued);
        }
        let entry = self.shared.store.ask(&id, &work.to_json().to_string()).await?;
        if entry.state == JobState::Open {
            let mut open = self.shared.open();
            let Open { waiting, running } = &mut *open;
            if !running.iter().chain(waiting.iter()).any(|task| task.id == id && !task.stop.is_set()) {
                let task = Task::new(id, work);
                if let Some([done, of]) = entry.steps {
                    task.done.store(done as usize, Ordering::Relaxed);
                    task.steps.store(of as usize, Ordering::Relaxed);
                }
                self.shared.tell(&task, "waiting");
                waiting.push_back(task);
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

    /// Lays a job aside: what it does is given up, what its checkpoint has stays. `None` if there is no such job.
    pub(super) async fn lay_aside(&self, id: &str) -> Result<Option<JobEntry>, StoreError> {
        let _change = self.changes.lock().await;
        let entry = self.shared.store.lay_aside(id).await?;
        self.give_up(id);
        Ok(entry)
    }

    /// Forgets a job, and ends it if it is under way. `false` if there is none.
    pub(super) async fn forget(&self, id: &str) -> Result<bool, StoreError> {
        let _change = self.changes.lock().await;
        let known = self.shared.store.forget(id).await?;
        self.give_up(id);
        Ok(known)
    }

    /// Takes a job off the threads.
    fn give_up(&self, id: &str) {
        let mut open = self.shared.open();
        for task in open.waiting.iter().filter(|task| task.id == id) {
            self.shared.tell(task, "stopped");
        }
        open.waiting.retain(|task| task.id != id);
        if let Some(task) = open.running.as_ref().filter(|task| task.id == id) {
            task.stop.set();
        }
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
