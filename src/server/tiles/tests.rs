use super::{queue::ALWAYS, *};
use crate::{
    geometry::{Filter, Grid, Rectangle, Samples, Tile},
    world::{Document, World},
};
use futures_util::FutureExt;
use std::sync::mpsc;

/// A service of one or more threads where a tile may wait `queue_ms`.
fn tiles(threads: usize, queue_ms: u64) -> Tiles {
    Tiles::new(Compute::new("test", threads).expect("threads"), Arc::new(Metrics::new()), 1 << 26, queue_ms)
}

/// Long enough for any test.
const PATIENT: u64 = 600_000;

fn world(seed: u64) -> World {
    World::new(Document::parse(format!(r#"{{"seed":{seed},"base":{{"programme":"x","scale":1}}}}"#).as_bytes()).expect("valid"))
}

/// A tile that is predicted to take a second.
fn order(x: i64) -> Order {
    let world = world(1);
    let fingerprint = world.fingerprint("test", &Rectangle::EMPTY, Grid::Web, Tile { z: 9, x, y: 0 }, Samples::Centres(256), Filter::Band);
    Order { fingerprint, revision: world.revision().clone(), class: Class::Visible, cost_ns: 1e9, kind: ["test", "programme"] }
}

fn bytes(value: u8) -> impl FnOnce(&Stop) -> Result<Vec<u8>, TileError> {
    move |_| Ok(vec![value])
}

/// What makes a tile once its gate is opened; it says when it has begun.
fn gated() -> (underway::Make, mpsc::Sender<()>, oneshot::Receiver<()>) {
    let ((open, gate), (begins, begun)) = (mpsc::channel(), oneshot::channel());
    let make = move |_: &Stop| {
        // Some tests do not wait for it.
        let _ = begins.send(());
        gate.recv_timeout(Duration::from_mins(1)).expect("opened");
        Ok(vec![7; 100])
    };
    (Box::new(make), open, begun)
}

fn shown(outcome: &Outcome) -> Result<u8, TileFailure> {
    outcome.as_ref().map(|made| made.bytes[0]).map_err(|failure| *failure)
}

#[tokio::test]
async fn identical_concurrent_requests_evaluate_once() {
    let tiles = tiles(2, PATIENT);
    let (make, open, _begun) = gated();
    let first = tiles.get(order(1), make);
    let others = (0..50).map(|_| tiles.get(order(1), |_| panic!("one evaluation is enough")));
    let (first, others, ()) = tokio::join!(first, futures_util::future::join_all(others), async { open.send(()).expect("somebody waits") });
    assert!(others.iter().all(|other| *other == first) && first.is_ok());
    assert_eq!(tiles.shared.metrics.evaluations(), 1);
    assert_eq!(tiles.cached(&order(1).fingerprint).await.expect("cached").len(), 100);
}

/// One leaves a tile that is being evaluated, one a tile that still waits for its turn; others want both.
#[tokio::test]
async fn a_caller_that_leaves_takes_nothing_from_others() {
    let tiles = tiles(1, PATIENT);
    let (make, open, begun) = gated();
    let mut running = Box::pin(tiles.get(order(2), make));
    tokio::select! {
        _ = &mut running => panic!("the gate is closed"),
        begun = begun => begun.expect("it begins"),
    }
    let mut late = Box::pin(tiles.get(order(2), bytes(2)));
    let mut queued = Box::pin(tiles.get(order(10), bytes(10)));
    let mut other = Box::pin(tiles.get(order(10), bytes(11)));
    assert!((&mut late).now_or_never().is_none() && (&mut queued).now_or_never().is_none() && (&mut other).now_or_never().is_none());
    drop((running, queued));
    open.send(()).expect("still under way");
    let (late, other) = tokio::join!(late, other);
    assert_eq!((shown(&late), shown(&other)), (Ok(7), Ok(10)));
    assert_eq!(tiles.shared.metrics.evaluations(), 2);
}

#[tokio::test]
async fn a_tile_that_nobody_waits_for_is_given_up_whether_it_has_begun_or_not() {
    let tiles = tiles(1, PATIENT);
    let ((begins, begun), (ends, ended)) = (oneshot::channel(), oneshot::channel());
    let mut running = Box::pin(tiles.get(order(6), move |stop: &Stop| {
        begins.send(()).expect("the test waits");
        while !stop.is_set() {
            std::thread::yield_now();
        }
        ends.send(()).expect("the test waits");
        Ok(vec![6])
    }));
    tokio::select! {
        _ = &mut running => panic!("it ends when it is stopped"),
        begun = begun => begun.expect("it begins"),
    }
    let mut queued = Box::pin(tiles.get(order(7), bytes(7)));
    assert!((&mut queued).now_or_never().is_none());
    assert_eq!(tiles.load(), (1, [1, 0]));
    drop(queued);
    assert_eq!(tiles.load(), (1, [0, 0]));
    drop(running);
    // One that comes while the other still runs is one of its own.
    assert_eq!(shown(&tiles.get(order(6), bytes(60)).await), Ok(60));
    ended.await.expect("stopped");
    assert_eq!(shown(&tiles.get(order(7), bytes(70)).await), Ok(70));
    assert_eq!((tiles.load(), tiles.shared.metrics.evaluations()), ((0, [0, 0]), 2), "what was given up is not kept");
}

#[tokio::test]
async fn what_is_visible_comes_before_what_may_be() {
    let tiles = tiles(1, PATIENT);
    let (make, open, begun) = gated();
    let mut busy = Box::pin(tiles.get(order(0), make));
    tokio::select! {
        _ = &mut busy => panic!("the gate is closed"),
        begun = begun => begun.expect("it begins"),
    }
    let ended = Arc::new(Mutex::new(Vec::new()));
    let get = |x: i64, class: Class| {
        let ended = Arc::clone(&ended);
        let make = move |_: &Stop| {
            ended.lock().expect("the list").push(x);
            Ok(vec![1])
        };
        tiles.get(Order { class, ..order(x) }, make)
    };
    let (early, raised) = (get(1, Class::Prefetch), get(2, Class::Prefetch));
    let (visible, raising) = (get(3, Class::Visible), get(2, Class::Visible));
    let all = async { tokio::join!(early, raised, visible, raising) };
    let (_, _, ()) = tokio::join!(busy, all, async { open.send(()).expect("it waits") });
    assert_eq!(*ended.lock().expect("the list"), [3, 2, 1]);
}

#[tokio::test]
async fn the_largest_tile_is_cached_on_a_machine_with_many_cores() {
    let tiles = Tiles::new(Compute::new("test", 1).expect("threads"), Arc::new(Metrics::new()), 1 << 28, 1);
    tiles.get(order(9), |_| Ok(vec![0; 1025 * 1025 * 4])).await.expect("made");
    assert!(tiles.cached(&order(9).fingerprint).await.is_some());
}

#[tokio::test]
async fn a_revision_that_panics_is_set_aside_and_no_other() {
    let tiles = tiles(1, PATIENT);
    for x in 0..3 {
        assert_eq!(shown(&tiles.get(order(x), |_| panic!("on purpose")).await), Err(TileFailure::Failed));
    }
    assert_eq!(shown(&tiles.get(order(3), bytes(3)).await), Err(TileFailure::SetAside));
    let other = Order { revision: world(2).revision().clone(), ..order(4) };
    assert_eq!(shown(&tiles.get(other, bytes(4)).await), Ok(4));
}

/// Tiles that are predicted to take a second each: so many wait as always may, no more, and they are served.
#[tokio::test]
async fn a_full_queue_refuses_at_once() {
    let tiles = tiles(1, 250);
    let (make, open, begun) = gated();
    let mut busy = Box::pin(tiles.get(order(0), make));
    tokio::select! {
        _ = &mut busy => panic!("the gate is closed"),
        begun = begun => begun.expect("it begins"),
    }
    let waiting = (1..=ALWAYS as i64).map(|x| {
        let mut tile = Box::pin(tiles.get(order(x), bytes(1)));
        assert!((&mut tile).now_or_never().is_none(), "it waits");
        tile
    });
    let waiting: Vec<_> = waiting.collect();
    assert_eq!(tiles.get(order(100), bytes(1)).now_or_never().map(|outcome| shown(&outcome)), Some(Err(TileFailure::Overloaded)));
    let free = Order { class: Class::Prefetch, ..order(101) };
    let mut free = Box::pin(tiles.get(free, bytes(1)));
    assert!((&mut free).now_or_never().is_none(), "each class has a lane of its own");
    open.send(()).expect("it waits");
    assert_eq!(shown(&busy.await), Ok(7));
    assert!(futures_util::future::join_all(waiting).await.iter().all(Result::is_ok));
}

#[test]
fn the_newest_comes_first_when_the_oldest_is_late() {
    let (start, patience) = (Instant::now(), Duration::from_secs(10));
    let at = |seconds: u64| start + Duration::from_secs(seconds);
    let fingerprint = |x: usize| order(x as i64).fingerprint;
    let mut queue = queue::Queue::default();
    for x in 0..=ALWAYS + 1 {
        queue.push(Class::Visible, fingerprint(x), 1.0, at(u64::from(x > 0)));
    }
    let mut next = |seconds| {
        let queue::Taken { next, expired } = queue.take(at(seconds), patience);
        (next, expired)
    };
    assert_eq!(next(5), (Some(fingerprint(0)), vec![]), "half is not over");
    assert_eq!(next(7), (Some(fingerprint(ALWAYS + 1)), vec![]));
    assert_eq!(next(12), (Some(fingerprint(1)), vec![]), "so many may wait however long it takes");
    queue.push(Class::Visible, fingerprint(50), 1.0, at(12));
    queue.push(Class::Visible, fingerprint(51), 1.0, at(12));
    let queue::Taken { next, expired } = queue.take(at(12), patience);
    assert_eq!((next, expired), (Some(fingerprint(3)), vec![fingerprint(2)]));
    assert_eq!((queue.waiting(Class::Visible), queue.ahead_ns(Class::Prefetch)), (ALWAYS - 1, (ALWAYS - 1) as f64));
}

/// Tiles over a disk cache in a folder.
#[cfg(feature = "disk")]
async fn over(folder: &std::path::Path, bytes: u64) -> Tiles {
    let mut tiles = tiles(1, PATIENT);
    tiles.keep_on_disk(folder, bytes).await.expect("a folder");
    tiles
}

#[cfg(feature = "disk")]
#[tokio::test]
async fn tiles_on_disk_outlive_the_process_and_are_whole_or_not_there() {
    let (folder, bytes) = (tempfile::tempdir().expect("a folder"), 1 << 27);
    let content = |n: i64| (0..50_000).map(|i| ((i * (2 * n + 1)) >> 3) as u8).collect::<Vec<_>>();
    let first = over(folder.path(), bytes).await;
    for n in 0..20 {
        first.get(order(n), move |_| Ok(content(n))).await.expect("made");
    }
    first.close().await;
    let second = over(folder.path(), bytes).await;
    for n in 0..20 {
        assert_eq!(second.cached(&order(n).fingerprint).await.as_deref(), Some(&content(n)[..]), "{n}");
    }
    assert!(second.cached(&order(20).fingerprint).await.is_none());
    second.close().await;
    // Every page of some files is damaged.
    let mut damaged = 0;
    for entry in std::fs::read_dir(folder.path().join(bytes.to_string())).expect("a folder") {
        let path = entry.expect("an entry").path();
        let mut file = std::fs::read(&path).expect("a file");
        for page in file.chunks_mut(4096).filter(|page| page.iter().any(|byte| *byte != 0)) {
            page[2000] ^= 1;
            damaged += 1;
        }
        std::fs::write(&path, &file).expect("written");
    }
    let third = over(folder.path(), bytes).await;
    for n in 0..20 {
        assert!(third.cached(&order(n).fingerprint).await.is_none_or(|tile| tile == content(n)), "{n}");
    }
    third.close().await;
    assert!(damaged > 20 * 50_000 / 4096, "{damaged}");
    let fourth = over(folder.path(), 2 * bytes).await;
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1, "one of another size is thrown away");
    assert!(fourth.cached(&order(0).fingerprint).await.is_none());
}
