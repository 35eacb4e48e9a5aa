//! Vectors of an instruction set's own width, as kernels see them.
//!
//! Every operation is one IEEE operation or one integer operation a lane, so a kernel's results do not depend on the width. [`Plain`] is written with arrays
//! and works everywhere; of width one it turns a kernel into the plain form for a single point.

use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Sub};

/// A token of an instruction set: who holds it may use the set's vectors.
///
/// Whatever takes a token must be `#[inline(always)]`: what is not inlined is compiled for the baseline.
pub trait Lanes: Copy {
    /// Lanes of a vector of floats.
    const WIDTH: usize;
    /// Places of a slice that [`Lanes::permute`] reads.
    const REACH: usize;
    /// Places of each slice that [`Lanes::permute_two`] reads.
    const SPAN: usize;
    /// The set's own vectors.
    type Single: Lanes;
    /// `WIDTH` f32.
    type Floats: Copy + Add<Output = Self::Floats> + Sub<Output = Self::Floats> + Mul<Output = Self::Floats>;
    /// `WIDTH` u32; sums and products wrap.
    type Words: Copy
        + Add<Output = Self::Words>
        + Sub<Output = Self::Words>
        + Mul<Output = Self::Words>
        + BitAnd<Output = Self::Words>
        + BitOr<Output = Self::Words>
        + BitXor<Output = Self::Words>;
    /// `WIDTH` f64.
    type Doubles: Copy + Add<Output = Self::Doubles> + Sub<Output = Self::Doubles> + Mul<Output = Self::Doubles>;

    /// The token of the set's own vectors.
    fn single(self) -> Self::Single;
    /// One value in every lane.
    fn splat(self, value: f32) -> Self::Floats;
    /// The first `WIDTH` values of a slice that has as many.
    fn load(self, from: &[f32]) -> Self::Floats;
    /// Writes the first `WIDTH` values of a slice that has as many.
    fn store(self, values: Self::Floats, to: &mut [f32]);
    /// One word in every lane.
    fn splat_words(self, value: u32) -> Self::Words;
    /// The first `WIDTH` words of a slice that has as many.
    fn load_words(self, from: &[u32]) -> Self::Words;
    /// Writes the first `WIDTH` words of a slice that has as many.
    fn store_words(self, values: Self::Words, to: &mut [u32]);
    /// One value in every lane.
    fn splat_doubles(self, value: f64) -> Self::Doubles;
    /// The first `WIDTH` values of a slice that has as many.
    fn load_doubles(self, from: &[f64]) -> Self::Doubles;

    /// Writes the first `WIDTH` values of a slice that has as many.
    fn store_doubles(self, values: Self::Doubles, to: &mut [f64]);
    /// The nearest floats.
    fn round(self, a: Self::Doubles) -> Self::Floats;
    /// a / b, rounded to nearest.
    fn divide_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// √a, rounded to nearest.
    fn sqrt_doubles(self, a: Self::Doubles) -> Self::Doubles;
    /// b < a ? b : a.
    fn smaller_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// b > a ? b : a.
    fn larger_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// a < b ? yes : no.
    fn where_less_doubles(self, a: Self::Doubles, b: Self::Doubles, yes: Self::Doubles, no: Self::Doubles) -> Self::Doubles;

    /// |a|.
    fn abs(self, a: Self::Floats) -> Self::Floats;
    /// √a, rounded to nearest.
    fn sqrt(self, a: Self::Floats) -> Self::Floats;
    /// b < a ? b : a.
    fn smaller(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// b > a ? b : a.
    fn larger(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a < b ? yes : no.
    fn where_less(self, a: Self::Floats, b: Self::Floats, yes: Self::Floats, no: Self::Floats) -> Self::Floats;
    /// Whether a < b in any lane.
    fn any_less(self, a: Self::Floats, b: Self::Floats) -> bool;
    /// The bits of floats.
    fn to_words(self, a: Self::Floats) -> Self::Words;
    /// The floats of bits.
    fn to_floats(self, a: Self::Words) -> Self::Floats;
    /// Bits moved up.
    fn shl<const N: u32>(self, a: Self::Words) -> Self::Words;
    /// Bits moved down, zeros following.
    fn shr<const N: u32>(self, a: Self::Words) -> Self::Words;
    /// Bits moved down, the top bit following.
    fn sar<const N: u32>(self, a: Self::Words) -> Self::Words;
    /// The whole part of a value in 0 … 2^31; any word for another value.
    fn truncate(self, a: Self::Floats) -> Self::Words;
    /// The float of a word below 2^24.
    fn convert(self, a: Self::Words) -> Self::Floats;

    /// For each lane the value of the first `REACH` of a slice that its word, taken modulo `REACH`, names.
    fn permute(self, from: &[f32], index: Self::Words) -> Self::Floats;
    /// For each lane one of the first `SPAN` values of two slices: its word's lowest bits, as many as `SPAN` needs, name the place and the next bit the slice.
    fn permute_two(self, from: [&[f32]; 2], index: Self::Words) -> Self::Floats;
    /// For each lane the value that its word's low four bits name.
    fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats;
    /// For each lane the values of two tables that its word's top four bits name; the last eight of each table are the first eight's negatives.
    fn sixteenths(self, tables: &[[f32; 16]; 2], hash: Self::Words) -> [Self::Floats; 2];
    /// For each lane the values of two tables that the word's high half times 12 / 2^16 names: zero, or the first value or its negative. Of each value divided by
    /// half the first, only the top byte is not zero, and is given too.
    fn twelfths(self, tables: &[[f32; 16]; 2], bytes: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2];

    /// The low words of bits.
    fn low_words(self, a: Self::Doubles) -> Self::Words;
    /// The high words of bits.
    fn high_words(self, a: Self::Doubles) -> Self::Words;
    /// The lesser of finite numbers.
    fn least(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// The greater of finite numbers.
    fn greatest(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles;
    /// The least of each of two vectors, and the greatest of each of two others, all numbers being finite.
    fn ends(self, least: [Self::Doubles; 2], greatest: [Self::Doubles; 2]) -> [[f64; 2]; 2];
}

/// Vectors as arrays of N.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain<const N: usize>;

/// N values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Array<T, const N: usize>(pub [T; N]);

macro_rules! array_operator {
    ($operator:ident, $method:ident, $type:ty, |$a:ident, $b:ident| $value:expr) => {
        impl<const N: usize> $operator for Array<$type, N> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Array(core::array::from_fn(|i| {
                    let ($a, $b) = (self.0[i], other.0[i]);
                    $value
                }))
            }
        }
    };
}

array_operator!(Add, add, f32, |a, b| a + b);
array_operator!(Sub, sub, f32, |a, b| a - b);
array_operator!(Mul, mul, f32, |a, b| a * b);
array_operator!(Add, add, f64, |a, b| a + b);
array_operator!(Sub, sub, f64, |a, b| a - b);
array_operator!(Mul, mul, f64, |a, b| a * b);
array_operator!(Add, add, u32, |a, b| a.wrapping_add(b));
array_operator!(Sub, sub, u32, |a, b| a.wrapping_sub(b));
array_operator!(Mul, mul, u32, |a, b| a.wrapping_mul(b));
array_operator!(BitAnd, bitand, u32, |a, b| a & b);
array_operator!(BitOr, bitor, u32, |a, b| a | b);
array_operator!(BitXor, bitxor, u32, |a, b| a ^ b);

impl<T: Copy, const N: usize> Array<T, N> {
    #[inline(always)]
    fn map<U>(self, function: impl Fn(T) -> U) -> Array<U, N> {
        Array(core::array::from_fn(|i| function(self.0[i])))
    }

    #[inline(always)]
    fn zip<U>(self, other: Self, function: impl Fn(T, T) -> U) -> Array<U, N> {
        Array(core::array::from_fn(|i| function(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn read(from: &[T]) -> Self {
        let from = &from[..N];
        Array(core::array::from_fn(|i| from[i]))
    }
}

impl<const N: usize> Lanes for Plain<N> {
    const WIDTH: usize = N;
    const REACH: usize = N;
    const SPAN: usize = 4;
    type Single = Self;
    type Floats = Array<f32, N>;
    type Words = Array<u32, N>;
    type Doubles = Array<f64, N>;

    #[inline(always)]
    fn single(self) -> Self {
        self
    }

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Floats {
        Array([value; N])
    }

    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::Floats {
        Array::read(from)
    }

    #[inline(always)]
    fn store(self, values: Self::Floats, to: &mut [f32]) {
        to[..N].copy_from_slice(&values.0);
    }

    #[inline(always)]
    fn splat_words(self, value: u32) -> Self::Words {
        Array([value; N])
    }

    #[inline(always)]
    fn load_words(self, from: &[u32]) -> Self::Words {
        Array::read(from)
    }

    #[inline(always)]
    fn store_words(self, values: Self::Words, to: &mut [u32]) {
        to[..N].copy_from_slice(&values.0);
    }

    #[inline(always)]
    fn splat_doubles(self, value: f64) -> Self::Doubles {
        Array([value; N])
    }

    #[inline(always)]
    fn load_doubles(self, from: &[f64]) -> Self::Doubles {
        Array::read(from)
    }

    #[inline(always)]
    fn store_doubles(self, values: Self::Doubles, to: &mut [f64]) {
        to[..N].copy_from_slice(&values.0);
    }

    #[inline(always)]
    fn round(self, a: Self::Doubles) -> Self::Floats {
        a.map(|a| a as f32)
    }

    #[inline(always)]
    fn divide_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles {
        a.zip(b, |a, b| a / b)
    }

    #[inline(always)]
    fn sqrt_doubles(self, a: Self::Doubles) -> Self::Doubles {
        a.map(f64::sqrt)
    }

    #[inline(always)]
    fn smaller_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles {
        a.zip(b, |a, b| if b < a { b } else { a })
    }

    #[inline(always)]
    fn larger_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles {
        a.zip(b, |a, b| if b > a { b } else { a })
    }

    #[inline(always)]
    fn where_less_doubles(self, a: Self::Doubles, b: Self::Doubles, yes: Self::Doubles, no: Self::Doubles) -> Self::Doubles {
        Array(core::array::from_fn(|i| if a.0[i] < b.0[i] { yes.0[i] } else { no.0[i] }))
    }

    #[inline(always)]
    fn abs(self, a: Self::Floats) -> Self::Floats {
        a.map(f32::abs)
    }

    #[inline(always)]
    fn sqrt(self, a: Self::Floats) -> Self::Floats {
        a.map(f32::sqrt)
    }

    #[inline(always)]
    fn smaller(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        a.zip(b, |a, b| if b < a { b } else { a })
    }

    #[inline(always)]
    fn larger(self, a: Self::Floats, b: Self::Floats) -> Self::Floats {
        a.zip(b, |a, b| if b > a { b } else { a })
    }

    #[inline(always)]
    fn where_less(self, a: Self::Floats, b: Self::Floats, yes: Self::Floats, no: Self::Floats) -> Self::Floats {
        Array(core::array::from_fn(|i| if a.0[i] < b.0[i] { yes.0[i] } else { no.0[i] }))
    }

    #[inline(always)]
    fn any_less(self, a: Self::Floats, b: Self::Floats) -> bool {
        let mut any = 0;
        for i in 0..N {
            any |= u8::from(a.0[i] < b.0[i]);
        }
        any != 0
    }

    #[inline(always)]
    fn to_words(self, a: Self::Floats) -> Self::Words {
        a.map(f32::to_bits)
    }

    #[inline(always)]
    fn to_floats(self, a: Self::Words) -> Self::Floats {
        a.map(f32::from_bits)
    }

    #[inline(always)]
    fn shl<const BITS: u32>(self, a: Self::Words) -> Self::Words {
        a.map(|a| a << BITS)
    }

    #[inline(always)]
    fn shr<const BITS: u32>(self, a: Self::Words) -> Self::Words {
        a.map(|a| a >> BITS)
    }

    #[inline(always)]
    fn sar<const BITS: u32>(self, a: Self::Words) -> Self::Words {
        a.map(|a| (a as i32 >> BITS) as u32)
    }

    #[inline(always)]
    fn truncate(self, a: Self::Floats) -> Self::Words {
        a.map(|a| a as i32 as u32)
    }

    #[inline(always)]
    fn convert(self, a: Self::Words) -> Self::Floats {
        a.map(|a| a as i32 as f32)
    }

    #[inline(always)]
    fn permute(self, from: &[f32], index: Self::Words) -> Self::Floats {
        let from = &from[..N];
        index.map(|index| from[index as usize % N])
    }

    #[inline(always)]
    fn permute_two(self, from: [&[f32]; 2], index: Self::Words) -> Self::Floats {
        index.map(|index| from[(index >> 2 & 1) as usize][(index & 3) as usize])
    }

    #[inline(always)]
    fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats {
        index.map(|index| table[(index & 15) as usize])
    }

    #[inline(always)]
    fn sixteenths(self, tables: &[[f32; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] {
        [hash.map(|hash| tables[0][(hash >> 28) as usize]), hash.map(|hash| tables[1][(hash >> 28) as usize])]
    }

    #[inline(always)]
    fn twelfths(self, tables: &[[f32; 16]; 2], _: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] {
        let index = hash.map(|hash| ((hash >> 16) * 12) >> 16);
        [index.map(|index| tables[0][index as usize]), index.map(|index| tables[1][index as usize])]
    }

    #[inline(always)]
    fn low_words(self, a: Self::Doubles) -> Self::Words {
        a.map(|a| a.to_bits() as u32)
    }

    #[inline(always)]
    fn high_words(self, a: Self::Doubles) -> Self::Words {
        a.map(|a| (a.to_bits() >> 32) as u32)
    }

    #[inline(always)]
    fn least(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles {
        a.zip(b, |a, b| if b < a { b } else { a })
    }

    #[inline(always)]
    fn greatest(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles {
        a.zip(b, |a, b| if b > a { b } else { a })
    }

    #[inline(always)]
    fn ends(self, least: [Self::Doubles; 2], greatest: [Self::Doubles; 2]) -> [[f64; 2]; 2] {
        let least = least.map(|a| a.0.into_iter().fold(a.0[0], |least, a| if a < least { a } else { least }));
        let greatest = greatest.map(|a| a.0.into_iter().fold(a.0[0], |greatest, a| if a > greatest { a } else { greatest }));
        [least, greatest]
    }
}
