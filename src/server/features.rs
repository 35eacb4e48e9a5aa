//! The features of a world as they are changed: read, edited, stored under their content's name, named by a new revision of the world.

use super::{
    error::{ApiError, Entry},
    parts::New,
    shelf::Shelved,
    state::App,
    worlds::Live,
};
use crate::{
    layout::geojson::{Collection, FeatureSet, Problem, Sets},
    store::{Beside, Condition, Kind},
    world,
};
use axum::body::Bytes;
use serde_json::{Value, json};
use std::sync::Arc;

/// The name of the layer that holds features of a world which has none yet.
const LAYER: &str = "features";

/// Where a world's stored set of features stands.
pub(super) struct Place {
    /// The layer and the item of its list; `None` if there is none yet.
    at: Option<(usize, usize)>,
    pub set: Arc<FeatureSet>,
    /// Sets of attributes that the layer gives names to.
    pub outer: Sets,
}

impl Place {
    /// Of the first layer that names a stored set.
    pub(super) fn of(live: &Live) -> Self {
        let mut layers = live.world.document().layers.iter().enumerate();
        let found = layers.find_map(|(i, layer)| layer.stored().map(|(item, set)| (i, item, set, layer)));
        match found {
            Some((layer, item, set, named)) => Self { at: Some((layer, item)), set: Arc::clone(set), outer: named.attributes().clone() },
            None => Self { at: None, set: Arc::new(Collection::default().into()), outer: Sets::default() },
        }
    }

    /// The sets of attributes that new features may name.
    pub(super) fn scope(&self) -> Sets {
        let mut scope = self.outer.clone();
        for (name, set) in self.set.collection().sets.iter() {
            scope.insert(name, Arc::clone(set));
        }
        scope
    }

    /// The world's document with another set in this place.
    fn document(&self, live: &Live, name: &str) -> Option<Value> {
        let mut document = serde_json::to_value(live.world.document()).ok()?;
        let item = json!({"set": name});
        if let Some((layer, i)) = self.at {
            *document.pointer_mut(&format!("/layers/{layer}/source/layout/features/{i}"))? = item;
            return Some(document);
        }
        let layers = document.get_mut("layers")?.as_array_mut()?;
        let taken = |name: &str| layers.iter().any(|layer| layer["name"] == name);
        let mut own = LAYER.to_owned();
        let mut number = 2;
        while taken(&own) {
            own = format!("{LAYER}-{number}");
            number += 1;
        }
        layers.push(json!({"name": own, "source": {"layout": {"features": [item]}}}));
        Some(document)
    }
}

/// Problems of features as the interface tells them.
pub(super) fn invalid(problems: impl Into<Vec<Problem>>) -> ApiError {
    let problems: Vec<Problem> = problems.into();
    ApiError::InvalidFeatures(problems.into_iter().map(|problem| Entry::from(world::Problem::from(problem))).collect())
}

/// Changes a world's features and saves the world's new revision, on a task of its own: once begun it ends, whether or not the client stays.
///
/// `edit` gets the world's features as they are; what it answers is saved and handed back.
pub(super) async fn change<T: Send + 'static>(
    app: &App,
    name: String,
    edit: impl FnOnce(&Live, &Place) -> Result<(Collection, T), ApiError> + Send + 'static,
) -> Result<(Arc<Live>, T), ApiError> {
    let app = app.clone();
    let task = tokio::spawn(async move {
        let _editing = app.0.editing.begin(&name).await;
        let shelf = Live::shelf(&app);
        let live = shelf.get(&name).ok_or_else(|| ApiError::absent("world", format!("no world is named {name:?}")))?;
        let edited = Arc::clone(&live);
        let (set, stored, json, answer) = app
            .0
            .queries
            .run(move || {
                let place = Place::of(&edited);
                let (collection, answer) = edit(&edited, &place)?;
                let set = FeatureSet::new(collection).map_err(invalid)?;
                let stored = set.stored();
                let document = place.document(&edited, &stored.name).ok_or(ApiError::Internal)?;
                Ok::<_, ApiError>((set, stored, document.to_string(), answer))
            })
            .await??;
        let new = Some(New::Set(stored.name.clone(), Arc::new(set)));
        let document = shelf.parse(Bytes::from(json), new).await?.map_err(|error| ApiError::document(Kind::World, error))?;
        let condition = Condition::At(vec![live.revision().to_string()]);
        let (_, live) = shelf.save_with(&name, document, Beside { set: Some(&stored), ..Beside::default() }, &condition).await?;
        Ok((live, answer))
    });
    match task.await {
        Ok(changed) => changed,
        Err(error) => Err(ApiError::internal("changing features", &error)),
    }
}
