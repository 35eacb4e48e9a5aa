//! Fields at positions of any order, as warped coordinates are, and their slopes.

use super::{
    Basis, Field, Isa, Kernel, Lanes,
    aligned::AlignedArray,
    cells::{Axis, Fade, Lattice},
    field::Octave,
    fractal::{State, Step, with_step},
    gradient_lanes::{Blender, IPerlin, Noise, OPerlin},
    lanes::Plain,
    number::{Dual, Real},
    rows::{add_noise, finish},
};

impl Basis {
    /// Whether fields of it have slopes: where it is gradient noise.
    #[must_use]
    pub fn has_slopes(self) -> bool {
        matches!(self, Basis::OPerlin | Basis::IPerlin | Basis::Blender)
    }
}

impl Field {
    /// Writes the values at positions, the same bits as [`Field::at`].
    ///
    /// # Panics
    /// If the slices' lengths differ.
    pub fn points(&self, isa: Isa, us: &[f64], vs: &[f64], out: &mut [f32]) {
        assert!(us.len() == out.len() && vs.len() == out.len(), "{} and {} coordinates for {} values", us.len(), vs.len(), out.len());
        match self.basis {
            Basis::OPerlin => isa.run(Points { field: self, noise: OPerlin, us, vs, out }),
            Basis::IPerlin => isa.run(Points { field: self, noise: IPerlin, us, vs, out }),
            Basis::Blender => isa.run(Points { field: self, noise: Blender, us, vs, out }),
            _ => isa.run(CellularPoints { field: self, isa, us, vs, out }),
        }
    }

    /// How fast the value grows along u and along v, a programme unit; zero without slopes. Where a step clamps, it has none.
    #[must_use]
    pub fn slopes_at(&self, u: f64, v: f64) -> [f32; 2] {
        let dual = match self.basis {
            Basis::OPerlin => self.dual_at(OPerlin, u, v),
            Basis::IPerlin => self.dual_at(IPerlin, u, v),
            Basis::Blender => self.dual_at(Blender, u, v),
            _ => return [0.0; 2],
        };
        dual.slopes.map(|slope| slope.0[0])
    }

    fn dual_at<N: Noise>(&self, _: N, u: f64, v: f64) -> Dual<Plain<1>> {
        let one = Plain::<1>;
        let mut state = self.before(one);
        for octave in &self.octaves {
            let ((_, x), (_, y)) = (octave.lattice.axis_at(one, N::FADE, 0, u), octave.lattice.axis_at(one, N::FADE, 1, v));
            let dual = N::dual(one, one.splat(N::scale() * octave.amplitude), &x, &y);
            let noise = per_unit(one, dual, octave.lattice.frequency);
            state = with_step!(&octave.step, step => step.after(one, noise, state));
        }
        self.after(one, state)
    }

    /// Writes the slopes at positions, the same bits as [`Field::slopes_at`].
    ///
    /// # Panics
    /// If the slices' lengths differ.
    pub fn slope_points(&self, isa: Isa, us: &[f64], vs: &[f64], du: &mut [f32], dv: &mut [f32]) {
        let lengths = [us.len(), vs.len(), du.len(), dv.len()];
        assert!(lengths.iter().all(|&length| length == lengths[0]), "slices of {lengths:?}");
        match self.basis {
            Basis::OPerlin => isa.run(Slopes { field: self, noise: OPerlin, us, vs, du, dv }),
            Basis::IPerlin => isa.run(Slopes { field: self, noise: IPerlin, us, vs, du, dv }),
            Basis::Blender => isa.run(Slopes { field: self, noise: Blender, us, vs, du, dv }),
            _ => {
                du.fill(0.0);
                dv.fill(0.0);
            }
        }
    }
}

/// Slopes a cell, times `frequency` cells a unit.
#[inline(always)]
fn per_unit<L: Lanes>(lanes: L, dual: Dual<L>, frequency: f64) -> Dual<L> {
    let frequency = lanes.splat(frequency as f32);
    Dual { value: dual.value, slopes: [dual.slopes[0] * frequency, dual.slopes[1] * frequency] }
}

/// Positions that are taken through an octave together.
const BLOCK: usize = 256;

/// How far a block lies from the origin.
#[derive(Clone, Copy, PartialEq)]
enum Reach {
    /// Cells' numbers fit 32 bits.
    Near,
    /// They fit 52 bits.
    Middle,
    /// Or not, or there is no such place.
    Far,
}

impl Reach {
    #[inline(always)]
    fn of(field: &Field, us: &[f64], vs: &[f64]) -> Self {
        // Bits of magnitudes are in the magnitudes' order, and those of what is no number beyond all.
        let magnitude = |greatest: u64, c: &f64| greatest.max(c.to_bits() & (u64::MAX >> 1));
        let greatest = f64::from_bits(vs.iter().fold(us.iter().fold(0, magnitude), magnitude));
        if field.octaves.iter().all(|octave| octave.lattice.is_near(greatest)) {
            Reach::Near
        } else if field.octaves.iter().all(|octave| octave.lattice.holds(greatest)) {
            Reach::Middle
        } else {
            Reach::Far
        }
    }
}

/// A vector of coordinates, of which the last is repeated where there are fewer.
#[inline(always)]
fn load<L: Lanes>(lanes: L, from: &[f64]) -> L::Doubles {
    if from.len() >= L::WIDTH {
        return lanes.load_doubles(from);
    }
    let mut padded = [from[from.len() - 1]; 16];
    padded[..from.len()].copy_from_slice(from);
    lanes.load_doubles(&padded)
}

/// Writes as many values as there is room for.
#[inline(always)]
fn store<L: Lanes>(lanes: L, values: L::Floats, to: &mut [f32]) {
    if to.len() >= L::WIDTH {
        return lanes.store(values, to);
    }
    let mut padded = [0.0; 16];
    lanes.store(values, &mut padded);
    let count = to.len();
    to.copy_from_slice(&padded[..count]);
}

/// Where a block's positions lie in an octave's lattice, along one axis.
struct Places {
    keys: [[u32; BLOCK]; 2],
    fractions: AlignedArray<BLOCK>,
    fades: AlignedArray<BLOCK>,
}

impl Places {
    fn new() -> Self {
        Self { keys: [[0; BLOCK]; 2], fractions: AlignedArray([0.0; BLOCK]), fades: AlignedArray([0.0; BLOCK]) }
    }

    #[inline(always)]
    fn locate<L: Lanes, const NEAR: bool>(&mut self, lanes: L, lattice: &Lattice, fade: Fade, axis: usize, coordinates: &[f64]) {
        let [near, far] = &mut self.keys;
        let keys = near.chunks_exact_mut(L::WIDTH).zip(far.chunks_exact_mut(L::WIDTH));
        let places = self.fractions.0.chunks_exact_mut(L::WIDTH).zip(self.fades.0.chunks_exact_mut(L::WIDTH));
        for (coordinates, ((near, far), (fraction, fade_of))) in coordinates.chunks_exact(L::WIDTH).zip(keys.zip(places)) {
            let axis = lattice.axis::<L, NEAR>(lanes, fade, axis, lanes.load_doubles(coordinates));
            lanes.store_words(axis.keys[0], near);
            lanes.store_words(axis.keys[1], far);
            lanes.store(axis.fraction, fraction);
            lanes.store(axis.fade, fade_of);
        }
    }

    #[inline(always)]
    fn axis<L: Lanes>(&self, lanes: L, start: usize) -> Axis<L> {
        Axis {
            keys: [lanes.load_words(&self.keys[0][start..]), lanes.load_words(&self.keys[1][start..])],
            fraction: lanes.load(&self.fractions.0[start..]),
            fade: lanes.load(&self.fades.0[start..]),
            turn: lanes.splat(0.0),
        }
    }
}

/// [`Field::points`].
///
/// Octave by octave, and in each first where positions lie, then the noise there: short loops, whose steps do not wait for each other.
struct Points<'a, N> {
    field: &'a Field,
    noise: N,
    us: &'a [f64],
    vs: &'a [f64],
    out: &'a mut [f32],
}

impl<N: Noise> Kernel for Points<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { field, noise, us, vs, out } = self;
        let (mut x, mut y) = (Places::new(), Places::new());
        let (mut padded_us, mut padded_vs) = ([0.0; BLOCK], [0.0; BLOCK]);
        for ((us, vs), out) in us.chunks(BLOCK).zip(vs.chunks(BLOCK)).zip(out.chunks_mut(BLOCK)) {
            let reach = Reach::of(field, us, vs);
            if reach == Reach::Far {
                out.iter_mut().zip(us.iter().zip(vs)).for_each(|(out, (&u, &v))| *out = field.at(u, v));
                continue;
            }
            // What follows the last position to make whole vectors is located too, but not used.
            padded_us[..us.len()].copy_from_slice(us);
            padded_vs[..vs.len()].copy_from_slice(vs);
            let count = us.len().next_multiple_of(L::WIDTH);
            let (mut values, mut openings) = (AlignedArray([field.start; BLOCK]), AlignedArray([1.0; BLOCK]));
            for octave in &field.octaves {
                if reach == Reach::Near {
                    x.locate::<L, true>(lanes, &octave.lattice, N::FADE, 0, &padded_us[..count]);
                    y.locate::<L, true>(lanes, &octave.lattice, N::FADE, 1, &padded_vs[..count]);
                } else {
                    x.locate::<L, false>(lanes, &octave.lattice, N::FADE, 0, &padded_us[..count]);
                    y.locate::<L, false>(lanes, &octave.lattice, N::FADE, 1, &padded_vs[..count]);
                }
                let scale = N::scale() * octave.amplitude;
                let (values, openings) = (&mut values.0[..count], &mut openings.0[..count]);
                with_step!(&octave.step, step => add(lanes, noise, *step, scale, [&x, &y], values, openings));
            }
            if let Some(tail) = &field.tail {
                finish(lanes, *tail, &mut values.0[..count], &openings.0[..count]);
            }
            out.copy_from_slice(&values.0[..out.len()]);
        }
    }
}

/// [`Field::points`] of cellular noise: each octave is written to a buffer, from where its step takes it.
struct CellularPoints<'a> {
    field: &'a Field,
    isa: Isa,
    us: &'a [f64],
    vs: &'a [f64],
    out: &'a mut [f32],
}

impl Kernel for CellularPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { field, isa, us, vs, out } = self;
        for ((us, vs), out) in us.chunks(BLOCK).zip(vs.chunks(BLOCK)).zip(out.chunks_mut(BLOCK)) {
            let (mut noise, mut openings) = (AlignedArray([0.0; BLOCK]), AlignedArray([1.0; BLOCK]));
            let mut values = AlignedArray([field.start; BLOCK]);
            for octave in &field.octaves {
                field.basis.cellular_points(isa, octave, us, vs, &mut noise.0[..us.len()]);
                noise.0.iter_mut().for_each(|noise| *noise *= octave.amplitude);
                with_step!(&octave.step, step => add_noise(lanes, *step, &noise.0, &mut values.0, &mut openings.0));
            }
            if let Some(tail) = &field.tail {
                finish(lanes, *tail, &mut values.0, &openings.0);
            }
            out.copy_from_slice(&values.0[..us.len()]);
        }
    }
}

/// Adds an octave to positions.
#[inline(always)]
fn add<L: Lanes, N: Noise, S: Step>(lanes: L, _: N, step: S, scale: f32, [x, y]: [&Places; 2], values: &mut [f32], openings: &mut [f32]) {
    let scale = lanes.splat(scale);
    let states = values.chunks_exact_mut(L::WIDTH).zip(openings.chunks_exact_mut(L::WIDTH));
    for (at, (value, opening)) in states.enumerate() {
        let noise = N::value(lanes, scale, &x.axis(lanes, at * L::WIDTH), &y.axis(lanes, at * L::WIDTH));
        let state = State::load::<S>(lanes, value, opening);
        step.after(lanes, Real(noise), state).store::<S>(lanes, value, opening);
    }
}

/// [`Field::slope_points`].
struct Slopes<'a, N> {
    field: &'a Field,
    noise: N,
    us: &'a [f64],
    vs: &'a [f64],
    du: &'a mut [f32],
    dv: &'a mut [f32],
}

impl<N: Noise> Kernel for Slopes<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { field, noise, us, vs, du, dv } = self;
        let blocks = us.chunks(BLOCK).zip(vs.chunks(BLOCK)).zip(du.chunks_mut(BLOCK).zip(dv.chunks_mut(BLOCK)));
        for ((us, vs), (du, dv)) in blocks {
            if Reach::of(field, us, vs) == Reach::Far {
                for ((&u, &v), (du, dv)) in us.iter().zip(vs).zip(du.iter_mut().zip(dv)) {
                    [*du, *dv] = field.slopes_at(u, v);
                }
                continue;
            }
            let vectors = us.chunks(L::WIDTH).zip(vs.chunks(L::WIDTH)).zip(du.chunks_mut(L::WIDTH).zip(dv.chunks_mut(L::WIDTH)));
            for ((us, vs), (du, dv)) in vectors {
                let dual = through(lanes, field, noise, load(lanes, us), load(lanes, vs));
                store(lanes, dual.slopes[0], du);
                store(lanes, dual.slopes[1], dv);
            }
        }
    }
}

/// A vector of positions through all octaves.
#[inline(always)]
fn through<L: Lanes, N: Noise>(lanes: L, field: &Field, _: N, u: L::Doubles, v: L::Doubles) -> Dual<L> {
    let mut state = field.before(lanes);
    for Octave { lattice, amplitude, step, .. } in &field.octaves {
        let (x, y) = (lattice.axis::<L, false>(lanes, N::FADE, 0, u), lattice.axis::<L, false>(lanes, N::FADE, 1, v));
        let noise = per_unit(lanes, N::dual(lanes, lanes.splat(N::scale() * amplitude), &x, &y), lattice.frequency);
        state = with_step!(step, step => step.after(lanes, noise, state));
    }
    field.after(lanes, state)
}
