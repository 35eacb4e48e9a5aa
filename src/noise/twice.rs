//! Two vectors side by side as one: while one's operation waits for its operands, the other's computes.

use super::Lanes;
use core::ops::{Add, BitAnd, BitOr, BitXor, Mul, Sub};

/// Vectors of twice the width.
#[derive(Clone, Copy)]
pub(super) struct Twice<L>(pub L);

/// Two vectors.
#[derive(Clone, Copy)]
pub(super) struct Pair<T>(T, T);

macro_rules! pair_operators {
    ($($operator:ident $method:ident),*) => {$(
        impl<T: $operator<Output = T>> $operator for Pair<T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Pair(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    )*};
}

pair_operators!(Add add, Sub sub, Mul mul, BitAnd bitand, BitOr bitor, BitXor bitxor);

/// Methods that do the same with both.
macro_rules! both {
    ($($name:ident $(<const $n:ident: u32>)? ($($argument:ident: $type:ident),*) -> $output:ident;)*) => {$(
        #[inline(always)]
        fn $name $(<const $n: u32>)? (self, $($argument: Self::$type),*) -> Self::$output {
            Pair(self.0.$name $(::<$n>)? ($($argument.0),*), self.0.$name $(::<$n>)? ($($argument.1),*))
        }
    )*};
}

/// Methods that make both from one number.
macro_rules! splat {
    ($($name:ident($type:ty) -> $output:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, value: $type) -> Self::$output {
            Pair(self.0.$name(value), self.0.$name(value))
        }
    )*};
}

/// Methods that load both.
macro_rules! load {
    ($($name:ident($type:ty) -> $output:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, from: &[$type]) -> Self::$output {
            Pair(self.0.$name(from), self.0.$name(&from[L::WIDTH..]))
        }
    )*};
}

/// Methods that store both.
macro_rules! store {
    ($($name:ident($input:ident, $type:ty);)*) => {$(
        #[inline(always)]
        fn $name(self, values: Self::$input, to: &mut [$type]) {
            self.0.$name(values.0, to);
            self.0.$name(values.1, &mut to[L::WIDTH..]);
        }
    )*};
}

impl<L: Lanes> Lanes for Twice<L> {
    const WIDTH: usize = 2 * L::WIDTH;
    const REACH: usize = L::REACH;
    const SPAN: usize = L::SPAN;
    type Single = L;
    type Floats = Pair<L::Floats>;
    type Words = Pair<L::Words>;
    type Doubles = Pair<L::Doubles>;

    #[inline(always)]
    fn single(self) -> L {
        self.0
    }

    splat! {
        splat(f32) -> Floats;
        splat_words(u32) -> Words;
        splat_doubles(f64) -> Doubles;
    }

    load! {
        load(f32) -> Floats;
        load_words(u32) -> Words;
        load_doubles(f64) -> Doubles;
    }

    store! {
        store(Floats, f32);
        store_words(Words, u32);
        store_doubles(Doubles, f64);
    }

    both! {
        abs(a: Floats) -> Floats;
        sqrt(a: Floats) -> Floats;
        smaller(a: Floats, b: Floats) -> Floats;
        larger(a: Floats, b: Floats) -> Floats;
        where_less(a: Floats, b: Floats, yes: Floats, no: Floats) -> Floats;
        to_words(a: Floats) -> Words;
        to_floats(a: Words) -> Floats;
        shl<const N: u32>(a: Words) -> Words;
        shr<const N: u32>(a: Words) -> Words;
        sar<const N: u32>(a: Words) -> Words;
        truncate(a: Floats) -> Words;
        convert(a: Words) -> Floats;
        low_words(a: Doubles) -> Words;
        high_words(a: Doubles) -> Words;
        least(a: Doubles, b: Doubles) -> Doubles;
        greatest(a: Doubles, b: Doubles) -> Doubles;
        round(a: Doubles) -> Floats;
        divide_doubles(a: Doubles, b: Doubles) -> Doubles;
        sqrt_doubles(a: Doubles) -> Doubles;
        smaller_doubles(a: Doubles, b: Doubles) -> Doubles;
        larger_doubles(a: Doubles, b: Doubles) -> Doubles;
        where_less_doubles(a: Doubles, b: Doubles, yes: Doubles, no: Doubles) -> Doubles;
    }

    #[inline(always)]
    fn any_less(self, a: Self::Floats, b: Self::Floats) -> bool {
        self.0.any_less(a.0, b.0) || self.0.any_less(a.1, b.1)
    }

    #[inline(always)]
    fn permute(self, from: &[f32], index: Self::Words) -> Self::Floats {
        Pair(self.0.permute(from, index.0), self.0.permute(from, index.1))
    }

    #[inline(always)]
    fn permute_two(self, from: [&[f32]; 2], index: Self::Words) -> Self::Floats {
        Pair(self.0.permute_two(from, index.0), self.0.permute_two(from, index.1))
    }

    #[inline(always)]
    fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats {
        Pair(self.0.lookup16(table, index.0), self.0.lookup16(table, index.1))
    }

    #[inline(always)]
    fn sixteenths(self, tables: &[[f32; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] {
        let ([a, b], [c, d]) = (self.0.sixteenths(tables, hash.0), self.0.sixteenths(tables, hash.1));
        [Pair(a, c), Pair(b, d)]
    }

    #[inline(always)]
    fn twelfths(self, tables: &[[f32; 16]; 2], bytes: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] {
        let ([a, b], [c, d]) = (self.0.twelfths(tables, bytes, hash.0), self.0.twelfths(tables, bytes, hash.1));
        [Pair(a, c), Pair(b, d)]
    }

    #[inline(always)]
    fn ends(self, least: [Self::Doubles; 2], greatest: [Self::Doubles; 2]) -> [[f64; 2]; 2] {
        let least = [self.0.least(least[0].0, least[0].1), self.0.least(least[1].0, least[1].1)];
        let greatest = [self.0.greatest(greatest[0].0, greatest[0].1), self.0.greatest(greatest[1].0, greatest[1].1)];
        self.0.ends(least, greatest)
    }
}
