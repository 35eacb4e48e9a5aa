//! Peers that send or take almost nothing while a connection waits for them.

use axum::body::{Bytes, HttpBody};
use hyper::body::{Frame, Incoming, SizeHint};
use std::{
    io,
    pin::Pin,
    task::{Context, Poll, ready},
    time::Duration,
};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    time::{Instant, Sleep},
};

/// Bytes a second that a peer must move at least while it is waited for.
const LEAST_RATE: u64 = 512;

/// Counts the time that a peer is waited for, and what it moves: it must move enough within every span of waiting.
#[derive(Debug)]
struct Pace {
    span: Duration,
    /// Waited within this span before the present wait.
    waited: Duration,
    moved: u64,
    since: Option<Instant>,
    timer: Pin<Box<Sleep>>,
}

impl Pace {
    fn new(span: Duration) -> Self {
        Self { span, waited: Duration::ZERO, moved: 0, since: None, timer: Box::pin(tokio::time::sleep(span)) }
    }

    fn least(&self) -> u64 {
        (self.span.as_secs_f64() * LEAST_RATE as f64) as u64
    }

    /// The peer has moved some bytes; it is waited for no longer.
    fn moved(&mut self, bytes: usize) {
        if let Some(since) = self.since.take() {
            self.waited += since.elapsed();
        }
        self.moved += bytes as u64;
        if self.moved >= self.least() {
            (self.waited, self.moved) = (Duration::ZERO, 0);
        }
    }

    /// The peer is waited for; ready when it was too slow.
    fn wait(&mut self, context: &mut Context) -> Poll<io::Error> {
        if self.since.is_none() {
            let now = Instant::now();
            self.since = Some(now);
            self.timer.as_mut().reset(now + self.span.saturating_sub(self.waited));
        }
        ready!(self.timer.as_mut().poll(context));
        Poll::Ready(io::Error::new(io::ErrorKind::TimedOut, format!("the peer moved fewer than {} bytes in {:?}", self.least(), self.span)))
    }
}

/// A stream whose peer must take what is written.
#[derive(Debug)]
pub(super) struct PacedStream<S> {
    stream: S,
    pace: Pace,
}

impl<S> PacedStream<S> {
    pub(super) fn new(stream: S, span: Duration) -> Self {
        Self { stream, pace: Pace::new(span) }
    }

    fn written(&mut self, context: &mut Context, result: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        match result {
            Poll::Ready(Ok(bytes)) => self.pace.moved(bytes),
            Poll::Ready(Err(_)) => {}
            Poll::Pending => return self.pace.wait(context).map(Err),
        }
        result
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for PacedStream<S> {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context, buffer: &mut ReadBuf) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for PacedStream<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.written(context, result)
    }

    fn poll_write_vectored(mut self: Pin<&mut Self>, context: &mut Context, slices: &[io::IoSlice]) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.written(context, result)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

/// A body whose sender must go on.
#[derive(Debug)]
pub(super) struct PacedBody {
    body: Incoming,
    pace: Pace,
}

impl PacedBody {
    pub(super) fn new(body: Incoming, span: Duration) -> Self {
        Self { body, pace: Pace::new(span) }
    }
}

impl HttpBody for PacedBody {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        match Pin::new(&mut self.body).poll_frame(context) {
            Poll::Ready(frame) => {
                let bytes = frame.as_ref().and_then(|frame| frame.as_ref().ok()?.data_ref()).map_or(0, Bytes::len);
                self.pace.moved(bytes);
                Poll::Ready(frame.map(|frame| frame.map_err(Into::into)))
            }
            Poll::Pending => self.pace.wait(context).map(|error| Some(Err(error.into()))),
        }
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    const SPAN: Duration = Duration::from_secs(10);

    #[tokio::test(start_paused = true)]
    async fn a_peer_that_takes_nothing_or_drips_is_given_up() {
        for (drip, every) in [(0, 1000), (1, 100), (400, 1000)] {
            let (near, mut far) = duplex(64);
            let reader = tokio::spawn(async move {
                let mut buffer = vec![0; drip.max(1)];
                loop {
                    tokio::time::sleep(Duration::from_millis(every)).await;
                    if drip > 0 && far.read_exact(&mut buffer).await.is_err() {
                        return;
                    }
                }
            });
            let start = Instant::now();
            let error = PacedStream::new(near, SPAN).write_all(&vec![0; 1 << 20]).await.expect_err("too slow");
            assert_eq!(error.kind(), io::ErrorKind::TimedOut);
            assert!((SPAN..SPAN + Duration::from_secs(2)).contains(&start.elapsed()), "{drip}: {:?}", start.elapsed());
            reader.abort();
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_peer_that_keeps_up_is_not_and_rests_do_not_count() {
        let (near, mut far) = duplex(64);
        tokio::spawn(async move {
            let mut buffer = [0; 64];
            while far.read_exact(&mut buffer).await.is_ok() {
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        });
        let mut stream = PacedStream::new(near, SPAN);
        for _ in 0..4 {
            stream.write_all(&vec![0; 1 << 15]).await.expect("640 bytes a second are enough");
            tokio::time::sleep(3 * SPAN).await;
        }
    }
}
