//! Distances at places anywhere.

use super::{
    Feature, Metric,
    crease::Finish,
    nearest::{self, BLOCKS, LANES, Place, Places},
};
use crate::noise::{
    Isa, Kernel, Lanes,
    cells::Lattice,
    metric::{Measure, Measured},
};

/// What is asked for, and on which machine.
#[derive(Clone, Copy)]
pub(in crate::noise) struct Query {
    pub isa: Isa,
    pub metric: Metric,
    pub feature: Feature,
    pub lattice: Lattice,
    /// Side of the square that a sample stands for, in cells; 0 for the value as it is.
    pub extent: f32,
}

impl Query {
    pub(super) fn finish(&self) -> Finish {
        Finish::new(self.feature, self.metric, self.extent)
    }
}

/// The feature at a point.
pub(in crate::noise) fn feature_at(metric: Metric, feature: Feature, lattice: &Lattice, extent: f32, u: f64, v: f64) -> f32 {
    struct At(Finish, usize, u32, Place);
    impl Measured for At {
        type Output = f32;

        fn run<M: Measure>(self, measure: M) -> f32 {
            let At(finish, order, seed, place) = self;
            match order {
                1 => finish.of(measure, nearest::at::<M, 1>(measure, seed, order, place)),
                2 => finish.of(measure, nearest::at::<M, 2>(measure, seed, order, place)),
                _ => finish.of(measure, nearest::at::<M, 4>(measure, seed, order, place)),
            }
        }
    }
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    let place = Place { cell: [column.cell, row.cell], fraction: [column.fraction as f32, row.fraction as f32] };
    metric.measured(At(Finish::new(feature, metric, extent), feature.order(), lattice.seed, place))
}

/// The feature at the points (us, vs).
pub(in crate::noise) fn feature_points(query: &Query, us: &[f64], vs: &[f64], out: &mut [f32]) {
    struct Points<'a>(&'a Query, &'a [f64], &'a [f64], &'a mut [f32]);
    impl Measured for Points<'_> {
        type Output = ();

        fn run<M: Measure>(self, measure: M) {
            let Points(query, us, vs, out) = self;
            match query.feature.order() {
                1 => query.isa.run(FillPoints::<M, 1> { query, measure, us, vs, out }),
                2 => query.isa.run(FillPoints::<M, 2> { query, measure, us, vs, out }),
                _ => query.isa.run(FillPoints::<M, 4> { query, measure, us, vs, out }),
            }
        }
    }
    query.metric.measured(Points(query, us, vs, out));
}

/// [`feature_points`] for one measure and number of neighbours.
struct FillPoints<'a, M, const K: usize> {
    query: &'a Query,
    measure: M,
    us: &'a [f64],
    vs: &'a [f64],
    out: &'a mut [f32],
}

impl<M: Measure, const K: usize> Kernel for FillPoints<'_, M, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { query, measure, us, vs, out } = self;
        let lattice = &query.lattice;
        let mut places = [Places::NONE; BLOCKS];
        for ((us, vs), out) in us.chunks(TOGETHER).zip(vs.chunks(TOGETHER)).zip(out.chunks_mut(TOGETHER)) {
            for (places, (us, vs)) in places.iter_mut().zip(us.chunks(LANES).zip(vs.chunks(LANES))) {
                (places.columns, places.fx) = nearest::locate(lattice, 0, us);
                (places.rows, places.fy) = nearest::locate(lattice, 1, vs);
            }
            fill_places::<M, K>(query, measure, &places, out);
        }
    }
}

/// Samples at places anywhere that are looked at together.
pub(super) const TOGETHER: usize = LANES * BLOCKS;

/// Writes the feature at up to `TOGETHER` places.
#[inline(always)]
pub(super) fn fill_places<M: Measure, const K: usize>(query: &Query, measure: M, places: &[Places; BLOCKS], out: &mut [f32]) {
    let near = nearest::around::<M, K>(measure, query.lattice.seed, query.feature.order(), places, out.len());
    let finish = query.finish();
    for (near, out) in near.iter().zip(out.chunks_mut(LANES)) {
        let values = finish.all(measure, near);
        out.copy_from_slice(&values[..out.len()]);
    }
}
