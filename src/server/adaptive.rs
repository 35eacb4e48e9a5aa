//! Ground that evolves while it is used: feedback breeds a generation, and a revision of the world pins it. One at a time each world.

use super::{
    error::{ApiError, Entry},
    events::Event,
    extract::Asker,
    parts::New,
    players::Held,
    shelf::Shelved,
    state::App,
    worlds::Live,
};
use crate::{
    evolve::{Feedback, Generation, Ground, RecordError},
    geometry::{Filter, Rectangle},
    store::{Beside, Condition, Kind, NewGeneration},
    world::{Document, Layer},
};
use axum::body::Bytes;
use serde_json::Value;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// Changes that wait at most, of all worlds together.
const MOST_WAITING: usize = 256;

/// What waits to be bred.
pub(super) struct Feeding(Arc<Semaphore>);

impl Feeding {
    pub(super) fn new() -> Self {
        Self(Arc::new(Semaphore::new(MOST_WAITING)))
    }
}

/// What somebody said by being there.
pub(super) struct Said {
    pub layer: Option<String>,
    pub feedback: Feedback,
    /// Whether the places of all players count as points, too.
    pub players: bool,
}

/// Which generation is gone to.
pub(super) enum Target {
    /// One of the same ground.
    Hash(String),
    /// One on the way to that which is shown.
    Number(usize),
}

/// A layer of a world shows another generation.
pub(super) struct Shown {
    pub live: Arc<Live>,
    pub layer: String,
    pub generation: Arc<Generation>,
    /// Least x, least y, greatest x, greatest y of what changed for samples as far apart as nodes, in metres; none if nothing did.
    pub changed: Option<[f64; 4]>,
    /// What its heights are off those that were asked for.
    pub deviation: Option<f64>,
}

/// Something wrong in what was said.
pub(super) fn invalid(pointer: &str, detail: impl Into<String>) -> ApiError {
    ApiError::InvalidFeedback(vec![Entry::pointer(pointer.to_owned(), detail)])
}

fn wrong(error: RecordError) -> ApiError {
    invalid(&error.at, error.message)
}

/// The layers of a world that evolve.
pub(super) fn layers(document: &Document) -> impl Iterator<Item = (usize, &Layer, &Arc<Generation>)> {
    document.layers.iter().enumerate().filter_map(|(i, layer)| Some((i, layer, layer.generation()?)))
}

/// The grounds of a world by the names of their layers.
pub(super) fn grounds(document: &Document) -> Vec<(&str, &Ground)> {
    layers(document).map(|(_, layer, generation)| (&*layer.name, &**generation.ground())).collect()
}

/// The layer of a name, or the only one that evolves; why there is none.
pub(super) fn chosen<'a>(document: &'a Document, name: Option<&str>) -> Result<(usize, &'a Layer, &'a Arc<Generation>), String> {
    let mut all = layers(document);
    let names = || format!("{:?}", layers(document).map(|(_, layer, _)| &*layer.name).collect::<Vec<_>>());
    match name {
        Some(name) => {
            all.find(|(_, layer, _)| layer.name == name).ok_or_else(|| format!("must be the name of an adaptive layer, of {}; got {name:?}", names()))
        }
        None => match (all.next(), all.next()) {
            (Some(only), None) => Ok(only),
            (Some(_), Some(_)) => Err(format!("is needed: the world has several adaptive layers, {}", names())),
            (None, _) => Err("the world has no adaptive layer".to_owned()),
        },
    }
}

/// What a change holds of a world: its turn, its players, itself.
struct Turn {
    live: Arc<Live>,
    players: Held,
}

async fn turn(app: &App, name: &str, condition: &Condition) -> Result<Turn, ApiError> {
    let players = app.0.players.hold(name).await;
    let live = Live::shelf(app).get(name).ok_or_else(|| ApiError::absent("world", format!("no world is named {name:?}")))?;
    if !condition.holds(Some(live.revision().as_str())) {
        return Err(ApiError::PreconditionFailed(format!("the world is at revision {}, not what the request's condition asks for", live.revision())));
    }
    Ok(Turn { live, players })
}

/// Runs a change on a task of its own: once begun it ends, whether or not the client stays.
async fn in_turn<F: Future<Output = Result<Shown, ApiError>> + Send + 'static>(
    app: &App,
    change: impl FnOnce(App) -> F + Send + 'static,
) -> Result<Shown, ApiError> {
    let Ok(waiting) = Arc::clone(&app.0.adaptive.0).try_acquire_owned() else { return Err(ApiError::Busy) };
    let app = app.clone();
    let task = tokio::spawn(async move {
        let _waiting = waiting;
        change(app).await
    });
    match task.await {
        Ok(changed) => changed,
        Err(error) => Err(ApiError::internal("changing a generation", &error)),
    }
}

/// Breeds a generation of a world's layer and saves the revision of the world that shows it. Where anything fails, nothing is changed.
pub(super) async fn feed(app: &App, asker: Asker, name: String, said: Said, condition: Condition) -> Result<Shown, ApiError> {
    in_turn(app, move |app| async move {
        let _editing = app.0.editing.begin(&name).await;
        let Turn { live, mut players } = turn(&app, &name, &condition).await?;
        let Said { layer, mut feedback, players: as_players } = said;
        let (i, layer, old) = chosen(live.document(), layer.as_deref()).map_err(|detail| invalid("/layer", detail))?;
        if as_players {
            let area = old.terrain().area();
            let before = feedback.points.len();
            feedback.points.extend(players.positions().filter(|&position| area.holds(position)));
            if feedback.points.len() == before {
                return Err(invalid("/players", "no player is on the ground of the layer"));
            }
        }
        (feedback.ways, feedback.margin) = players.ways(&layer.name);
        asker.pay(&app, feedback.cost_ns(old.ground()))?;
        let bred = bred(&app, Arc::clone(old), feedback).await?;
        let changed = save(&app, &live, (i, &layer.name), old, bred).await?;
        let names: Vec<&str> = layers(live.document()).map(|(_, layer, _)| &*layer.name).collect();
        players.rest(&layer.name, &names);
        Ok(changed)
    })
    .await
}

/// A generation with what is stored of it.
struct Bred {
    generation: Arc<Generation>,
    new: Vec<NewGeneration>,
    area: Rectangle,
    deviation: Option<f64>,
}

fn difference(old: &Generation, new: &Generation) -> Rectangle {
    let area = old.terrain().area();
    old.terrain().changed(new.terrain(), old.ground().cell, Filter::Band).meet(&area)
}

async fn bred(app: &App, old: Arc<Generation>, feedback: Feedback) -> Result<Bred, ApiError> {
    let breeding = app.0.queries.run(move || {
        let wanted = old.wanted(&feedback)?;
        let next = old.next(&feedback)?;
        let deviation = next.terrain().deviation(wanted);
        let stored = NewGeneration::bred(&next, old.hash(), &feedback, deviation);
        // The first is stored with the second.
        let new = if old.number() == 0 { vec![NewGeneration::first(old.ground()), stored] } else { vec![stored] };
        Ok(Bred { area: difference(&old, &next), generation: Arc::new(next), new, deviation: Some(deviation) })
    });
    breeding.await?.map_err(wrong)
}

/// Saves the revision of a world that shows another generation, with what is new of that: both or neither.
async fn save(app: &App, live: &Live, (i, layer): (usize, &str), old: &Arc<Generation>, bred: Bred) -> Result<Shown, ApiError> {
    let Bred { generation, new, area, deviation } = bred;
    let shelf = Live::shelf(app);
    let mut document = serde_json::to_value(live.document()).map_err(|error| ApiError::internal("writing a world", &error))?;
    match document.pointer_mut(&format!("/layers/{i}/source/adaptive/generation")) {
        Some(pinned) => *pinned = Value::from(generation.hash()),
        None => return Err(ApiError::Internal),
    }
    let parsed = shelf.parse(Bytes::from(document.to_string()), Some(New::Generation(Arc::clone(&generation)))).await?;
    let document = parsed.map_err(|error| ApiError::document(Kind::World, error))?;
    let condition = Condition::At(vec![live.revision().to_string()]);
    let (_, live) = shelf.save_with(&live.name, document, Beside { generations: &new, ..Beside::default() }, &condition).await?;
    let changed = generation.hash() != old.hash() && area.min[0] <= area.max[0] && area.min[1] <= area.max[1];
    let changed = changed.then(|| [area.min[0], area.min[1], area.max[0], area.max[1]]);
    let told = Event::Generation {
        world: live.name.clone(),
        layer: layer.to_owned(),
        number: generation.number(),
        hash: generation.hash().to_owned(),
        revision: live.revision().to_string(),
        changed,
    };
    if generation.hash() != old.hash() {
        app.0.events.send(told);
    }
    Ok(Shown { live, layer: layer.to_owned(), generation, changed, deviation })
}

/// Shows another generation of a world's layer that was bred before. Refused while a player is there.
pub(super) async fn go_to(app: &App, name: String, layer: Option<String>, target: Target, condition: Condition) -> Result<Shown, ApiError> {
    in_turn(app, move |app| async move {
        let _editing = app.0.editing.begin(&name).await;
        let Turn { live, players } = turn(&app, &name, &condition).await?;
        let (i, layer, old) = chosen(live.document(), layer.as_deref()).map_err(|detail| invalid("/layer", detail))?;
        if let Some(player) = players.near(old.ground()) {
            return Err(promised(player, &layer.name));
        }
        let generation = found(&app, old, target).await?;
        let compared = (Arc::clone(old), Arc::clone(&generation));
        let area = app.0.queries.run(move || difference(&compared.0, &compared.1)).await?;
        save(&app, &live, (i, &layer.name), old, Bred { generation, new: Vec::new(), area, deviation: None }).await
    })
    .await
}

/// Says that somebody is there.
fn promised(player: &str, layer: &str) -> ApiError {
    ApiError::Conflict(format!(
        "The player {player:?} is on the ground of the layer {layer:?}, and nothing may change around players: wait until all have left."
    ))
}

/// A generation of the same ground.
async fn found(app: &App, of: &Arc<Generation>, target: Target) -> Result<Arc<Generation>, ApiError> {
    let hash = match target {
        Target::Hash(hash) => hash,
        Target::Number(number) if number == of.number() => of.hash().to_owned(),
        Target::Number(0) => of.ground().hash(),
        Target::Number(number) => {
            let way = app.0.store.generations(of.hash()).await?;
            let there = way.into_iter().find(|entry| usize::try_from(entry.number) == Ok(number));
            there
                .ok_or_else(|| invalid("/generation", format!("must be 0 … {}, a generation on the way to this one, or a hash; got {number}", of.number())))?
                .hash
        }
    };
    if hash == of.hash() {
        return Ok(Arc::clone(of));
    }
    if hash == of.ground().hash() {
        let ground = Arc::clone(of.ground());
        return Ok(Arc::new(app.0.queries.run(move || Generation::first(&ground)).await?.map_err(wrong)?));
    }
    let known = app.0.parts.generation(&app.0.queries, &hash).await?;
    known
        .filter(|known| known.ground() == of.ground())
        .ok_or_else(|| invalid("/generation", format!("no stored generation of this ground has the hash {hash:?}")))
}

/// Whether a world may become another: not while a player is on ground that would be another generation.
pub(super) fn check_change(live: &Live, new: &Document, players: &Held) -> Result<(), ApiError> {
    for (_, layer, old) in layers(live.document()) {
        let kept = layers(new).any(|(_, other, generation)| other.name == layer.name && generation.hash() == old.hash());
        if let Some(player) = players.near(old.ground()).filter(|_| !kept) {
            return Err(promised(player, &layer.name));
        }
    }
    Ok(())
}
