//! Tiles that clients pay for out of their budgets of evaluation.

use super::{
    budget::{Budget, Client},
    error::ApiError,
    extract::Asker,
    state::App,
    tiles::{Made, Order},
};
use crate::{geometry::Stop, tile::TileError};
use std::{
    sync::{Arc, OnceLock},
    time::Instant,
};

/// A tile that is not at hand, at its asker's cost. Whose asking begins no evaluation, because another's tile is the same or the wait would be too long, pays nothing;
/// who leaves while one runs, or whose tile fails, pays for the time until then.
pub(super) async fn bought(
    app: &App,
    asker: Asker,
    order: Order,
    draw: impl FnOnce(&Stop) -> Result<Vec<u8>, TileError> + Send + 'static,
) -> Result<Made, ApiError> {
    asker.pay(app, order.cost_ns)?;
    let Asker(client) = asker;
    let mut payment = Payment { app: app.clone(), client, cost_ns: order.cost_ns, begun: Arc::default(), is_due: false };
    let begun = Arc::clone(&payment.begun);
    let drawn = move |stop: &Stop| {
        begun.get_or_init(Instant::now);
        draw(stop)
    };
    let made = app.0.tiles.get(order, drawn).await?;
    payment.is_due = true;
    Ok(made)
}

/// What a client has paid for a tile; on its end the part that was not used is given back.
struct Payment {
    app: App,
    client: Client,
    cost_ns: f64,
    /// When the evaluation that it pays for began.
    begun: Arc<OnceLock<Instant>>,
    /// Whether all of it was used if any was.
    is_due: bool,
}

impl Payment {
    fn used_ns(&self) -> f64 {
        match self.begun.get() {
            None => 0.0,
            Some(_) if self.is_due => self.cost_ns,
            Some(begun) => self.cost_ns.min(begun.elapsed().as_nanos() as f64),
        }
    }
}

impl Drop for Payment {
    fn drop(&mut self) {
        let unused_ns = self.cost_ns - self.used_ns();
        if unused_ns > 0.0 {
            self.app.0.budgets.give_back(&self.client, Budget::Compute, unused_ns / 1e9);
        }
    }
}
