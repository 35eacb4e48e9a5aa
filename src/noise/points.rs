//! Fields at positions of any order, as warped coordinates are, and their slopes.

use super::{
    Basis, Field, Isa, Kernel, Lanes,
    aligned::AlignedArray,
    fractal::{Step, with_step},
    gradient_lanes::{Blender, IPerlin, Noise, OPerlin},
    lanes::Plain,
    number::{Dual, Real},
    rows::{add_noise, finish},
    scatter::{BLOCK, Positions, Scratch, per_unit},
    twice::Twice,
};
use std::cell::RefCell;

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
            Basis::OPerlin => SCRATCH.with_borrow_mut(|scratch| isa.run(Points { scratch, field: self, noise: OPerlin, us, vs, out })),
            Basis::IPerlin => SCRATCH.with_borrow_mut(|scratch| isa.run(Points { scratch, field: self, noise: IPerlin, us, vs, out })),
            Basis::Blender => SCRATCH.with_borrow_mut(|scratch| isa.run(Points { scratch, field: self, noise: Blender, us, vs, out })),
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
            let (_, columns, x) = octave.lattice.axis_at(one, N::FADE, 0, u);
            let (_, rows, y) = octave.lattice.axis_at(one, N::FADE, 1, v);
            let corners = N::corners(one, &N::palette(octave.amplitude), columns, rows);
            let noise = per_unit(one, N::dual(one, &corners, &x, &y), octave.lattice.frequency);
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
            Basis::OPerlin => SCRATCH.with_borrow_mut(|scratch| isa.run(Slopes { scratch, field: self, noise: OPerlin, us, vs, du, dv })),
            Basis::IPerlin => SCRATCH.with_borrow_mut(|scratch| isa.run(Slopes { scratch, field: self, noise: IPerlin, us, vs, du, dv })),
            Basis::Blender => SCRATCH.with_borrow_mut(|scratch| isa.run(Slopes { scratch, field: self, noise: Blender, us, vs, du, dv })),
            _ => {
                du.fill(0.0);
                dv.fill(0.0);
            }
        }
    }
}

thread_local! {
    /// Kept from call to call: to clear it each time would take as long as an octave.
    static SCRATCH: RefCell<Box<Scratch>> = RefCell::new(Box::new(Scratch::new()));
}

/// Calls `block` with all positions, block by block, the last incomplete vector filled up: where the block begins, how many positions it has, and the positions.
macro_rules! in_blocks {
    ($lanes:ty, $us:expr, $vs:expr, |$start:ident, $count:ident, $positions:ident| $block:expr) => {{
        let (us, vs, mut $start): (&[f64], &[f64], _) = ($us, $vs, 0);
        let mut padded: [[f64; 32]; 2];
        let whole = us.len() - us.len() % <$lanes>::WIDTH;
        while $start < us.len() {
            let $count = if $start < whole { (whole - $start).min(BLOCK) } else { us.len() - $start };
            let $positions = if $start < whole {
                Positions { us: &us[$start..][..$count], vs: &vs[$start..][..$count] }
            } else {
                padded = [[us[$start]; 32], [vs[$start]; 32]];
                padded[0][..$count].copy_from_slice(&us[$start..]);
                padded[1][..$count].copy_from_slice(&vs[$start..]);
                Positions { us: &padded[0][..<$lanes>::WIDTH], vs: &padded[1][..<$lanes>::WIDTH] }
            };
            $block;
            $start += $count;
        }
    }};
}

/// [`Field::points`].
struct Points<'a, N> {
    scratch: &'a mut Scratch,
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
        if L::WIDTH == 8 { self.run_wide((Twice(lanes), Twice(lanes))) } else { self.run_wide((Twice(lanes), lanes)) }
    }
}

impl<N: Noise> Points<'_, N> {
    #[inline(always)]
    fn run_wide<L: Lanes, G: Lanes>(self, lanes: (L, G)) {
        let Self { scratch, field, noise, us, vs, out } = self;
        in_blocks!(L, us, vs, |start, count, positions| {
            let out = &mut out[start..][..count];
            if scratch.compute::<L, Real<L>, G, N>(lanes, noise, field, positions) {
                out.copy_from_slice(&scratch.values[0].0[..count]);
            } else {
                out.iter_mut().zip(us[start..].iter().zip(&vs[start..])).for_each(|(out, (&u, &v))| *out = field.at(u, v));
            }
        });
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

/// [`Field::slope_points`].
struct Slopes<'a, N> {
    scratch: &'a mut Scratch,
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
        if L::WIDTH == 8 { self.run_wide((Twice(lanes), Twice(lanes))) } else { self.run_wide((Twice(lanes), lanes)) }
    }
}

impl<N: Noise> Slopes<'_, N> {
    #[inline(always)]
    fn run_wide<L: Lanes, G: Lanes>(self, lanes: (L, G)) {
        let Self { scratch, field, noise, us, vs, du, dv } = self;
        in_blocks!(L, us, vs, |start, count, positions| {
            let (du, dv) = (&mut du[start..][..count], &mut dv[start..][..count]);
            if scratch.compute::<L, Dual<L>, G, N>(lanes, noise, field, positions) {
                let [_, slopes @ ..] = &scratch.values;
                du.copy_from_slice(&slopes[0].0[..count]);
                dv.copy_from_slice(&slopes[1].0[..count]);
            } else {
                for ((&u, &v), (du, dv)) in us[start..].iter().zip(&vs[start..]).zip(du.iter_mut().zip(dv)) {
                    [*du, *dv] = field.slopes_at(u, v);
                }
            }
        });
    }
}
