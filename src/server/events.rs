//! What happens on the server, told to all who listen.

use super::budget::Client;
use futures_util::{Stream, stream};
use serde::Serialize;
use std::{
    collections::{HashMap, VecDeque},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use tokio::sync::watch;

/// Events that are kept for those who come back.
const KEPT: usize = 1024;

/// Listeners at a time.
const MAX_LISTENERS: usize = 1024;

/// Listeners at a time from one address.
const MAX_OF_ONE: usize = 64;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", untagged)]
pub(super) enum Event {
    /// A world was saved, or taken out of the catalogue.
    World {
        world: String,
        /// The revision that its name stands for now; none if it is gone.
        revision: Option<String>,
    },
    /// A job began, went on, or ended.
    Job { job: String, state: &'static str, progress: f64 },
}

impl Event {
    /// The word of its kind.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::World { .. } => "world",
            Self::Job { .. } => "job",
        }
    }

    /// Whether somebody wants it who wants those of one world, of one job, or of both.
    fn is_wanted(&self, Wanted { world, job }: &Wanted) -> bool {
        let everything = world.is_none() && job.is_none();
        let of = |wanted: &Option<String>, name: &str| wanted.as_deref() == Some(name);
        everything
            || match self {
                Self::World { world: name, .. } => of(world, name),
                Self::Job { job: name, .. } => of(job, name),
            }
    }
}

/// Which events a listener wants: all, or those of a world, or of a job, or both.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Wanted {
    pub world: Option<String>,
    pub job: Option<String>,
}

/// What a listener hears.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Told {
    /// An event with its id.
    Event(String, Arc<Event>),
    /// Events were missed: what is known may be old. With the id from which on nothing is.
    Reset(String),
}

/// The newest events, oldest first, numbered from the start of the server.
#[derive(Default)]
struct Log {
    /// The number of the first that is kept.
    first: u64,
    kept: VecDeque<Arc<Event>>,
    listeners: HashMap<Client, usize>,
}

impl Log {
    fn end(&self) -> u64 {
        self.first + self.kept.len() as u64
    }
}

/// What all listeners wait for.
#[derive(Clone, Copy, Default)]
struct News {
    end: u64,
    is_closed: bool,
}

/// The events of a server.
pub(super) struct Events {
    /// Tells ids of this run of the server from those of others.
    run: u32,
    log: Mutex<Log>,
    news: watch::Sender<News>,
}

/// A place among the listeners of a server, given back when it is dropped.
struct Seat {
    events: Arc<Events>,
    client: Client,
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut log = self.events.log();
        if let Some(count) = log.listeners.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                log.listeners.remove(&self.client);
            }
        }
    }
}

/// Somebody who listens.
struct Listener {
    seat: Seat,
    wanted: Wanted,
    /// The number of the next event to hear.
    next: u64,
    /// Whether some were missed before that.
    missed: bool,
    news: watch::Receiver<News>,
}

impl Events {
    pub(super) fn new() -> Self {
        // Two runs with one number would tell a listener nothing where it should look anew, once in four thousand million.
        let run = getrandom::u32().unwrap_or_default();
        Self { run, log: Mutex::default(), news: watch::Sender::default() }
    }

    fn log(&self) -> MutexGuard<'_, Log> {
        // It is whole at every point where a holder could panic.
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells all who listen.
    pub(super) fn send(&self, event: Event) {
        let mut log = self.log();
        if log.kept.len() == KEPT {
            log.kept.pop_front();
            log.first += 1;
        }
        log.kept.push_back(Arc::new(event));
        let end = log.end();
        // Told under the lock, so that no number is told after a greater one.
        self.news.send_modify(|news| news.end = end);
    }

    /// Ends all listening: the server is about to stop.
    pub(super) fn close(&self) {
        self.news.send_modify(|news| news.is_closed = true);
    }

    fn id(&self, number: u64) -> String {
        format!("{:08x}-{number}", self.run)
    }

    /// The number after that of an id of this run.
    fn after(&self, id: &str) -> Option<u64> {
        let (run, number) = id.split_once('-')?;
        (u32::from_str_radix(run, 16).ok()? == self.run).then(|| number.parse::<u64>().ok()?.checked_add(1)).flatten()
    }

    /// Events from now on, or from the one after `last`; `None` if there are too many listeners.
    pub(super) fn listen(self: &Arc<Self>, client: &Client, wanted: Wanted, last: Option<&str>) -> Option<impl Stream<Item = Told> + Send + use<>> {
        let mut log = self.log();
        let all: usize = log.listeners.values().sum();
        let own = log.listeners.entry(client.clone()).or_insert(0);
        if all >= MAX_LISTENERS || (*own >= MAX_OF_ONE && *client != Client::Local) {
            return None;
        }
        *own += 1;
        let seat = Seat { events: Arc::clone(self), client: client.clone() };
        let (first, end) = (log.first, log.end());
        let known = last.map(|id| self.after(id).filter(|next| (first..=end).contains(next)));
        let (next, missed) = match known {
            None => (end, false),
            Some(Some(next)) => (next, false),
            Some(None) => (end, true),
        };
        let listener = Listener { seat, wanted, next, missed, news: self.news.subscribe() };
        Some(stream::unfold(listener, |mut listener| async move { listener.hear().await.map(|told| (told, listener)) }))
    }
}

impl Listener {
    /// The next that it wants; `None` at the end.
    async fn hear(&mut self) -> Option<Told> {
        loop {
            if let Some(told) = self.kept() {
                return Some(told);
            }
            let next = self.next;
            let news = *self.news.wait_for(|news| news.is_closed || news.end > next).await.ok()?;
            if news.end <= next {
                return None;
            }
        }
    }

    /// What it has not heard of what is kept.
    fn kept(&mut self) -> Option<Told> {
        let events = &self.seat.events;
        let log = events.log();
        if self.next < log.first || self.missed {
            (self.next, self.missed) = (self.next.max(log.first), false);
            return Some(Told::Reset(events.id(self.next.wrapping_sub(1))));
        }
        while let Some(event) = log.kept.get((self.next - log.first) as usize) {
            self.next += 1;
            if event.is_wanted(&self.wanted) {
                return Some(Told::Event(events.id(self.next - 1), Arc::clone(event)));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::{FutureExt, StreamExt};
    use std::pin::pin;

    fn world(name: &str) -> Event {
        Event::World { world: name.to_owned(), revision: None }
    }

    fn heard(stream: &mut (impl Stream<Item = Told> + Unpin)) -> Vec<String> {
        let mut names = Vec::new();
        while let Some(Some(told)) = stream.next().now_or_never() {
            names.push(match told {
                Told::Event(_, event) => serde_json::to_value(&*event).expect("plain")["world"].as_str().unwrap_or("job").to_owned(),
                Told::Reset(_) => "reset".to_owned(),
            });
        }
        names
    }

    #[tokio::test]
    async fn listeners_hear_what_they_want_and_go_on_where_they_were() {
        let events = Arc::new(Events::new());
        events.send(world("before"));
        let all = events.listen(&Client::Local, Wanted::default(), None).expect("room");
        let one = events.listen(&Client::Local, Wanted { world: Some("b".to_owned()), job: None }, None).expect("room");
        let (mut all, mut one) = (pin!(all), pin!(one));
        for name in ["a", "b", "c"] {
            events.send(world(name));
        }
        events.send(Event::Job { job: "d".to_owned(), state: "done", progress: 1.0 });
        let Some(Told::Event(id, _)) = all.next().await else { panic!("an event") };
        assert_eq!(heard(&mut all), ["b", "c", "job"]);
        assert_eq!(heard(&mut one), ["b"]);
        let mut again = pin!(events.listen(&Client::Local, Wanted::default(), Some(&id)).expect("room"));
        assert_eq!(heard(&mut again), ["b", "c", "job"]);
        let other = Arc::new(Events { run: events.run.wrapping_add(1), ..Events::new() });
        let mut strange = pin!(other.listen(&Client::Local, Wanted::default(), Some(&id)).expect("room"));
        assert_eq!(heard(&mut strange), ["reset"]);
        events.close();
        assert_eq!(all.next().await, None);
    }

    #[tokio::test]
    async fn who_is_slow_is_told_to_look_anew() {
        let events = Arc::new(Events::new());
        let mut slow = pin!(events.listen(&Client::Local, Wanted::default(), None).expect("room"));
        for i in 0..KEPT + 5 {
            events.send(world(&i.to_string()));
        }
        let names = heard(&mut slow);
        assert_eq!((names.len(), names[0].as_str(), names[1].as_str()), (KEPT + 1, "reset", "5"));
        let mut again = pin!(events.listen(&Client::Local, Wanted::default(), Some(&events.id(4))).expect("room"));
        assert_eq!(heard(&mut again)[0], "5", "nothing is missed after a reset");
    }

    #[tokio::test]
    async fn seats_are_few_and_given_back() {
        let events = Arc::new(Events::new());
        let far = Client::at([192, 0, 2, 1].into());
        let listen = |client: &Client| events.listen(client, Wanted::default(), None);
        let mut seats: Vec<_> = (0..MAX_OF_ONE).map(|_| listen(&far).expect("room")).collect();
        assert!(listen(&far).is_none() && listen(&Client::Local).is_some());
        seats.pop();
        seats.push(listen(&far).expect("room again"));
        let near: Vec<_> = (MAX_OF_ONE..MAX_LISTENERS).map(|_| listen(&Client::Local).expect("room")).collect();
        assert!(listen(&Client::Local).is_none());
        drop((seats, near));
        assert!(events.log().listeners.is_empty());
    }
}
