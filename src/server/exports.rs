//! Files of areas, evaluated while their clients take them.

use super::{
    compute::{Compute, WhileAsked},
    config::LimitsConfig,
    error::ApiError,
    worlds::Live,
};
use crate::{
    geometry::{Source, Until},
    tile::{Area, AreaWriter, EncodeError},
};
use axum::body::{Body, Bytes};
use futures_util::{
    Stream, StreamExt,
    stream::{self, BoxStream},
};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// The export service: threads apart from those of tiles, which so never wait behind an export, and bounds of what one may ask for.
pub(super) struct Exports {
    compute: Arc<Compute>,
    under_way: Arc<Semaphore>,
    evaluations: Arc<AtomicU64>,
    /// Most samples of one.
    pub samples: u64,
    /// Most predicted nanoseconds of one.
    pub cost_ns: f64,
}

/// A file that is about to be sent.
pub(super) struct Export {
    live: Arc<Live>,
    area: Area,
    writer: AreaWriter,
    permit: OwnedSemaphorePermit,
}

impl Export {
    /// The length of the file in bytes, where it is known before its samples.
    pub(super) fn length(&self) -> Option<u64> {
        self.writer.length()
    }
}

/// Where a file is.
enum Stage {
    Head,
    Samples,
    Tail,
}

/// A file under way: what was sent, and the bands of rows that come.
struct UnderWay {
    compute: Arc<Compute>,
    /// Away while its threads write.
    writer: Option<AreaWriter>,
    stage: Stage,
    bands: BoxStream<'static, Vec<Result<Vec<f32>, ApiError>>>,
    /// Held till the end.
    _permit: OwnedSemaphorePermit,
}

impl UnderWay {
    /// The next piece of the file that is not empty.
    async fn next(mut self) -> Result<Option<(Bytes, Self)>, ApiError> {
        loop {
            let piece = match self.stage {
                Stage::Head => {
                    self.stage = Stage::Samples;
                    self.write(|writer| Ok(writer.head())).await?
                }
                Stage::Samples => {
                    if let Some(parts) = self.bands.next().await {
                        let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
                        self.write(move |writer| parts.iter().map(|heights| writer.put(heights)).try_fold(Vec::new(), |all, piece| Ok([all, piece?].concat())))
                            .await?
                    } else {
                        self.stage = Stage::Tail;
                        continue;
                    }
                }
                Stage::Tail => match self.write(AreaWriter::tail).await? {
                    Some(piece) => piece,
                    None => return Ok(None),
                },
            };
            if !piece.is_empty() {
                return Ok(Some((piece.into(), self)));
            }
        }
    }

    /// Lets the writer do something on the threads of exports.
    async fn write<T: Send + 'static>(&mut self, work: impl FnOnce(&mut AreaWriter) -> Result<T, EncodeError> + Send + 'static) -> Result<T, ApiError> {
        let Some(mut writer) = self.writer.take() else { return Err(ApiError::Internal) };
        let (writer, made) = self
            .compute
            .run(move || {
                let made = work(&mut writer);
                (writer, made)
            })
            .await?;
        self.writer = Some(writer);
        made.map_err(|error| ApiError::internal("writing an export", &error))
    }
}

impl Exports {
    pub(super) fn new(compute: Compute, limits: &LimitsConfig) -> Self {
        Self {
            compute: Arc::new(compute),
            under_way: Arc::new(Semaphore::new(limits.exports)),
            evaluations: Arc::default(),
            samples: limits.export_samples,
            cost_ns: limits.export_seconds as f64 * 1e9,
        }
    }

    /// How many parts were evaluated since the start.
    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// A file of an area of a world, unless too many are under way. Nothing is evaluated yet.
    pub(super) fn begin(&self, live: Arc<Live>, area: Area) -> Result<Export, ApiError> {
        let Ok(permit) = Arc::clone(&self.under_way).try_acquire_owned() else { return Err(ApiError::Exporting) };
        let writer = AreaWriter::new(&area, &live.world.legend()).map_err(|error| ApiError::internal("beginning an export", &error))?;
        Ok(Export { live, area, writer, permit })
    }

    /// The bytes of the file. They are made as they are asked for: a connection that takes none holds a band of rows and a part for every thread, and lets none
    /// be evaluated; one that is closed drops this, and parts that have not begun never do, and those that have end at their next row.
    pub(super) fn body(&self, export: Export) -> Body {
        let Export { live, area, writer, permit } = export;
        let bands = self.parts(live, area).chunks(area.parts_a_band());
        let under_way = UnderWay { compute: Arc::clone(&self.compute), writer: Some(writer), stage: Stage::Head, bands: bands.boxed(), _permit: permit };
        Body::from_stream(stream::try_unfold(under_way, UnderWay::next).map(|piece| piece.map_err(|_logged| "the export failed; the server's log says why")))
    }

    /// The heights of the parts in their order, a few of them evaluated at a time.
    fn parts(&self, live: Arc<Live>, area: Area) -> impl Stream<Item = Result<Vec<f32>, ApiError>> + use<> {
        let (compute, evaluations, asked) = (Arc::clone(&self.compute), Arc::clone(&self.evaluations), WhileAsked::new());
        let threads = compute.threads();
        let evaluate = move |part| {
            let (compute, live, evaluations, stop) = (Arc::clone(&compute), Arc::clone(&live), Arc::clone(&evaluations), asked.stop());
            let task = move || {
                if stop.is_set() {
                    return None;
                }
                evaluations.fetch_add(1, Ordering::Relaxed);
                Some(area.evaluate(&Until { source: &live.world, stop }, part))
            };
            // Only what nobody waits for is not wanted.
            async move { compute.run(task).await?.ok_or(ApiError::Internal) }
        };
        stream::iter(0..area.parts()).map(evaluate).buffered(threads)
    }
}
