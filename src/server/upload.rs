//! Features in a request's body, read while they come.

use super::{error::ApiError, features::invalid, state::App};
use crate::layout::geojson::{Collection, ReadError};
use axum::body::{Body, Bytes};
use futures_util::StreamExt;
use std::io::{self, Read};
use tokio::sync::mpsc;

/// Pieces of a body that wait to be read.
const WAITING: usize = 16;

/// Reads a body of features; it is never whole in memory.
pub(super) async fn read(app: &App, body: Body) -> Result<Collection, ApiError> {
    let (sender, receiver) = mpsc::channel(WAITING);
    let reading = tokio::task::spawn_blocking(move || Collection::read(Pieces { receiver, piece: Bytes::new(), ended: false }));
    let (limit, mut length, mut stream) = (app.0.feature_bytes, 0, body.into_data_stream());
    while let Some(piece) = stream.next().await {
        let piece = piece.map_err(|error| ApiError::BadRequest(format!("The body could not be read: {error}."), Vec::new()))?;
        length += piece.len();
        if length > limit {
            return Err(ApiError::TooLarge(limit));
        }
        // The reader stops early where it finds no more than problems.
        if sender.send(Some(piece)).await.is_err() {
            break;
        }
    }
    // A body that breaks off is told from one that ends.
    let _ = sender.send(None).await;
    match reading.await {
        Ok(Ok(collection)) => Ok(collection),
        Ok(Err(ReadError::Invalid(problems))) => Err(invalid(problems)),
        Ok(Err(ReadError::Io(error))) => Err(ApiError::BadRequest(format!("The body could not be read: {error}."), Vec::new())),
        Err(error) => Err(ApiError::internal("reading features", &error)),
    }
}

/// The pieces of a body as something to read from.
struct Pieces {
    receiver: mpsc::Receiver<Option<Bytes>>,
    piece: Bytes,
    /// Once the end was read it stays the end, however often it is asked for.
    ended: bool,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.piece.is_empty() && !self.ended {
            match self.receiver.blocking_recv() {
                Some(Some(piece)) => self.piece = piece,
                Some(None) => self.ended = true,
                None => return Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
            }
        }
        let count = buffer.len().min(self.piece.len());
        buffer[..count].copy_from_slice(&self.piece.split_to(count));
        Ok(count)
    }
}
