//! The vectors of x86-64 processors: AVX2 and AVX-512.
//!
//! Tokens and vectors of a set exist only where the processor has it: whoever makes the first token vouches for that, and everything else comes from a token.
//! This is why the intrinsics may be called.

use super::lanes::{Lanes, WHOLE, WHOLE_HIGH};
use core::{
    arch::x86_64::{
        __m256, __m256d, __m256i, __m512, __m512d, __m512i, _CMP_LT_OQ, _MM_FROUND_TO_NEG_INF, _mm_loadu_si128, _mm256_add_epi32, _mm256_add_pd, _mm256_add_ps,
        _mm256_and_ps, _mm256_and_si256, _mm256_blendv_pd, _mm256_blendv_ps, _mm256_broadcastsi128_si256, _mm256_castpd_ps, _mm256_castps_pd,
        _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvtpd_ps, _mm256_cvttps_epi32, _mm256_div_pd,
        _mm256_floor_pd, _mm256_loadu_pd, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_max_pd, _mm256_max_ps, _mm256_min_pd, _mm256_min_ps, _mm256_movemask_ps,
        _mm256_mul_pd, _mm256_mul_ps, _mm256_mulhi_epu16, _mm256_mullo_epi32, _mm256_or_si256, _mm256_permute4x64_pd, _mm256_permutevar8x32_ps,
        _mm256_set_m128, _mm256_set1_epi16, _mm256_set1_epi32, _mm256_set1_pd, _mm256_set1_ps, _mm256_shuffle_epi8, _mm256_shuffle_ps, _mm256_slli_epi32,
        _mm256_sllv_epi32, _mm256_sqrt_pd, _mm256_sqrt_ps, _mm256_srav_epi32, _mm256_srlv_epi32, _mm256_storeu_pd, _mm256_storeu_ps, _mm256_storeu_si256,
        _mm256_sub_epi32, _mm256_sub_pd, _mm256_sub_ps, _mm256_xor_si256, _mm512_abs_ps, _mm512_add_epi32, _mm512_add_pd, _mm512_add_ps, _mm512_and_si512,
        _mm512_broadcast_f32x8, _mm512_broadcast_i32x4, _mm512_castpd_si512, _mm512_castps_si512, _mm512_castps256_ps512, _mm512_castsi512_ps,
        _mm512_cmp_pd_mask, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_cvtpd_ps, _mm512_cvttps_epi32, _mm512_div_pd, _mm512_insertf32x8, _mm512_loadu_pd,
        _mm512_loadu_ps, _mm512_loadu_si512, _mm512_mask_blend_pd, _mm512_mask_blend_ps, _mm512_max_pd, _mm512_max_ps, _mm512_min_pd, _mm512_min_ps,
        _mm512_mul_pd, _mm512_mul_ps, _mm512_mulhi_epu16, _mm512_mullo_epi32, _mm512_or_si512, _mm512_permutex2var_epi32, _mm512_permutexvar_ps,
        _mm512_roundscale_pd, _mm512_set1_epi16, _mm512_set1_epi32, _mm512_set1_pd, _mm512_set1_ps, _mm512_setr_epi32, _mm512_shuffle_epi8, _mm512_slli_epi32,
        _mm512_sqrt_pd, _mm512_sqrt_ps, _mm512_srai_epi32, _mm512_srli_epi32, _mm512_storeu_pd, _mm512_storeu_ps, _mm512_storeu_si512, _mm512_sub_epi32,
        _mm512_sub_pd, _mm512_sub_ps, _mm512_xor_si512,
    },
    ops::{Add, BitAnd, BitOr, BitXor, Mul, Sub},
};

/// 256-bit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

/// 512-bit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx512(());

impl Avx2 {
    /// The first token.
    ///
    /// # Safety
    /// The processor must have AVX2.
    #[inline(always)]
    pub(super) unsafe fn assume() -> Self {
        Self(())
    }
}

impl Avx512 {
    /// The first token.
    ///
    /// # Safety
    /// The processor must have AVX-512 F, VL, BW and DQ.
    #[inline(always)]
    pub(super) unsafe fn assume() -> Self {
        Self(())
    }
}

/// A vector that only its token makes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vector<T>(T);

macro_rules! operators {
    ($vector:ty: $($operator:ident $method:ident $intrinsic:ident),*) => {$(
        impl $operator for Vector<$vector> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: vectors exist only where the processor has their set.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )*};
}

operators!(__m256: Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps);
operators!(__m512: Add add _mm512_add_ps, Sub sub _mm512_sub_ps, Mul mul _mm512_mul_ps);
operators!(__m256i: Add add _mm256_add_epi32, Sub sub _mm256_sub_epi32, Mul mul _mm256_mullo_epi32);
operators!(__m256i: BitAnd bitand _mm256_and_si256, BitOr bitor _mm256_or_si256, BitXor bitxor _mm256_xor_si256);
operators!(__m512i: Add add _mm512_add_epi32, Sub sub _mm512_sub_epi32, Mul mul _mm512_mullo_epi32);
operators!(__m512i: BitAnd bitand _mm512_and_si512, BitOr bitor _mm512_or_si512, BitXor bitxor _mm512_xor_si512);

macro_rules! pair_operators {
    ($vector:ty: $($operator:ident $method:ident $intrinsic:ident),*) => {$(
        impl $operator for Vector<[$vector; 2]> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: vectors exist only where the processor has their set.
                Self(unsafe { [$intrinsic(self.0[0], other.0[0]), $intrinsic(self.0[1], other.0[1])] })
            }
        }
    )*};
}

pair_operators!(__m256d: Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd);
pair_operators!(__m512d: Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd);

/// Methods whose bodies are calls of intrinsics.
macro_rules! lanes {
    ($(fn $name:ident $(<const $n:ident: u32>)? ($this:ident $(, $argument:ident: $type:ty)*) $(-> $output:ty)? = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name $(<const $n: u32>)? ($this, $($argument: $type),*) $(-> $output)? {
            // SAFETY: the token says that the processor has the set; where memory is read or written, the slice was just cut to the vector's length.
            unsafe { $body }
        }
    )*};
}

impl Lanes for Avx2 {
    const WIDTH: usize = 8;
    type Floats = Vector<__m256>;
    type Words = Vector<__m256i>;
    type Doubles = Vector<[__m256d; 2]>;

    lanes! {
        fn splat(self, value: f32) -> Self::Floats = Vector(_mm256_set1_ps(value));
        fn load(self, from: &[f32]) -> Self::Floats = Vector(_mm256_loadu_ps(from[..8].as_ptr()));
        fn store(self, values: Self::Floats, to: &mut [f32]) = _mm256_storeu_ps(to[..8].as_mut_ptr(), values.0);
        fn splat_words(self, value: u32) -> Self::Words = Vector(_mm256_set1_epi32(value as i32));
        fn load_words(self, from: &[u32]) -> Self::Words = Vector(_mm256_loadu_si256(from[..8].as_ptr().cast()));
        fn store_words(self, values: Self::Words, to: &mut [u32]) = _mm256_storeu_si256(to[..8].as_mut_ptr().cast(), values.0);
        fn splat_doubles(self, value: f64) -> Self::Doubles = Vector([_mm256_set1_pd(value); 2]);
        fn load_doubles(self, from: &[f64]) -> Self::Doubles = Vector([_mm256_loadu_pd(from[..4].as_ptr()), _mm256_loadu_pd(from[4..8].as_ptr())]);
        fn store_doubles(self, values: Self::Doubles, to: &mut [f64]) = {
            _mm256_storeu_pd(to[..4].as_mut_ptr(), values.0[0]);
            _mm256_storeu_pd(to[4..8].as_mut_ptr(), values.0[1]);
        };
        fn divide_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm256_div_pd(a.0[0], b.0[0]), _mm256_div_pd(a.0[1], b.0[1])]);
        fn sqrt_doubles(self, a: Self::Doubles) -> Self::Doubles = Vector([_mm256_sqrt_pd(a.0[0]), _mm256_sqrt_pd(a.0[1])]);
        fn smaller_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm256_min_pd(b.0[0], a.0[0]), _mm256_min_pd(b.0[1], a.0[1])]);
        fn larger_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm256_max_pd(b.0[0], a.0[0]), _mm256_max_pd(b.0[1], a.0[1])]);
        fn where_less_doubles(self, a: Self::Doubles, b: Self::Doubles, yes: Self::Doubles, no: Self::Doubles) -> Self::Doubles = Vector([
            _mm256_blendv_pd(no.0[0], yes.0[0], _mm256_cmp_pd::<_CMP_LT_OQ>(a.0[0], b.0[0])),
            _mm256_blendv_pd(no.0[1], yes.0[1], _mm256_cmp_pd::<_CMP_LT_OQ>(a.0[1], b.0[1])),
        ]);
        fn abs(self, a: Self::Floats) -> Self::Floats = Vector(_mm256_and_ps(a.0, _mm256_castsi256_ps(_mm256_set1_epi32(i32::MAX))));
        fn sqrt(self, a: Self::Floats) -> Self::Floats = Vector(_mm256_sqrt_ps(a.0));
        fn smaller(self, a: Self::Floats, b: Self::Floats) -> Self::Floats = Vector(_mm256_min_ps(b.0, a.0));
        fn larger(self, a: Self::Floats, b: Self::Floats) -> Self::Floats = Vector(_mm256_max_ps(b.0, a.0));
        fn where_less(self, a: Self::Floats, b: Self::Floats, yes: Self::Floats, no: Self::Floats) -> Self::Floats
            = Vector(_mm256_blendv_ps(no.0, yes.0, _mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0)));
        fn any_less(self, a: Self::Floats, b: Self::Floats) -> bool = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a.0, b.0)) != 0;
        fn to_words(self, a: Self::Floats) -> Self::Words = Vector(_mm256_castps_si256(a.0));
        fn to_floats(self, a: Self::Words) -> Self::Floats = Vector(_mm256_castsi256_ps(a.0));
        fn shl<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm256_sllv_epi32(a.0, _mm256_set1_epi32(N as i32)));
        fn shr<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm256_srlv_epi32(a.0, _mm256_set1_epi32(N as i32)));
        fn sar<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm256_srav_epi32(a.0, _mm256_set1_epi32(N as i32)));
        fn truncate(self, a: Self::Floats) -> Self::Words = Vector(_mm256_cvttps_epi32(a.0));
        fn convert(self, a: Self::Words) -> Self::Floats = Vector(_mm256_cvtepi32_ps(a.0));
        fn permute(self, from: &[f32], index: Self::Words) -> Self::Floats = Vector(_mm256_permutevar8x32_ps(self.load(from).0, index.0));
        fn lookup8(self, table: &[f32; 8], index: Self::Words) -> Self::Floats = Vector(_mm256_permutevar8x32_ps(self.load(table).0, index.0));
        fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats = {
            let (low, high) = (self.permute(&table[..8], index), self.permute(&table[8..], index));
            // The fourth bit, moved to the top, chooses.
            Vector(_mm256_blendv_ps(low.0, high.0, _mm256_castsi256_ps(self.shl::<28>(index).0)))
        };
        fn twelfths(self, tables: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            // The number stands in the top byte; the other bytes' top bits are set, which answers zero.
            let number = _mm256_slli_epi32::<8>(_mm256_mulhi_epu16(hash.0, _mm256_set1_epi16(12)));
            let number = _mm256_or_si256(number, _mm256_set1_epi32(0x0080_8080));
            let first = _mm256_broadcastsi128_si256(_mm_loadu_si128(tables[0].as_ptr().cast()));
            let second = _mm256_broadcastsi128_si256(_mm_loadu_si128(tables[1].as_ptr().cast()));
            [Vector(_mm256_castsi256_ps(_mm256_shuffle_epi8(first, number))), Vector(_mm256_castsi256_ps(_mm256_shuffle_epi8(second, number)))]
        };
        fn floor(self, a: Self::Doubles) -> Self::Doubles = Vector([_mm256_floor_pd(a.0[0]), _mm256_floor_pd(a.0[1])]);
        fn round(self, a: Self::Doubles) -> Self::Floats = Vector(_mm256_set_m128(_mm256_cvtpd_ps(a.0[1]), _mm256_cvtpd_ps(a.0[0])));
        fn whole_words(self, a: Self::Doubles) -> [Self::Words; 2] = {
            let [low, high] = (a + self.splat_doubles(WHOLE)).0;
            let (low, high) = (_mm256_castpd_ps(low), _mm256_castpd_ps(high));
            // Even and odd words, put in order: shuffling leaves the two halves' pairs alternating.
            let even = _mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(_mm256_shuffle_ps::<0b10_00_10_00>(low, high)));
            let odd = _mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(_mm256_shuffle_ps::<0b11_01_11_01>(low, high)));
            let (even, odd) = (_mm256_castps_si256(_mm256_castpd_ps(even)), _mm256_castps_si256(_mm256_castpd_ps(odd)));
            [Vector(even), Vector(odd) - self.splat_words(WHOLE_HIGH)]
        };
    }
}

impl Lanes for Avx512 {
    const WIDTH: usize = 16;
    type Floats = Vector<__m512>;
    type Words = Vector<__m512i>;
    type Doubles = Vector<[__m512d; 2]>;

    lanes! {
        fn splat(self, value: f32) -> Self::Floats = Vector(_mm512_set1_ps(value));
        fn load(self, from: &[f32]) -> Self::Floats = Vector(_mm512_loadu_ps(from[..16].as_ptr()));
        fn store(self, values: Self::Floats, to: &mut [f32]) = _mm512_storeu_ps(to[..16].as_mut_ptr(), values.0);
        fn splat_words(self, value: u32) -> Self::Words = Vector(_mm512_set1_epi32(value as i32));
        fn load_words(self, from: &[u32]) -> Self::Words = Vector(_mm512_loadu_si512(from[..16].as_ptr().cast()));
        fn store_words(self, values: Self::Words, to: &mut [u32]) = _mm512_storeu_si512(to[..16].as_mut_ptr().cast(), values.0);
        fn splat_doubles(self, value: f64) -> Self::Doubles = Vector([_mm512_set1_pd(value); 2]);
        fn load_doubles(self, from: &[f64]) -> Self::Doubles = Vector([_mm512_loadu_pd(from[..8].as_ptr()), _mm512_loadu_pd(from[8..16].as_ptr())]);
        fn store_doubles(self, values: Self::Doubles, to: &mut [f64]) = {
            _mm512_storeu_pd(to[..8].as_mut_ptr(), values.0[0]);
            _mm512_storeu_pd(to[8..16].as_mut_ptr(), values.0[1]);
        };
        fn divide_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm512_div_pd(a.0[0], b.0[0]), _mm512_div_pd(a.0[1], b.0[1])]);
        fn sqrt_doubles(self, a: Self::Doubles) -> Self::Doubles = Vector([_mm512_sqrt_pd(a.0[0]), _mm512_sqrt_pd(a.0[1])]);
        fn smaller_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm512_min_pd(b.0[0], a.0[0]), _mm512_min_pd(b.0[1], a.0[1])]);
        fn larger_doubles(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm512_max_pd(b.0[0], a.0[0]), _mm512_max_pd(b.0[1], a.0[1])]);
        fn where_less_doubles(self, a: Self::Doubles, b: Self::Doubles, yes: Self::Doubles, no: Self::Doubles) -> Self::Doubles = Vector([
            _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a.0[0], b.0[0]), no.0[0], yes.0[0]),
            _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a.0[1], b.0[1]), no.0[1], yes.0[1]),
        ]);
        fn abs(self, a: Self::Floats) -> Self::Floats = Vector(_mm512_abs_ps(a.0));
        fn sqrt(self, a: Self::Floats) -> Self::Floats = Vector(_mm512_sqrt_ps(a.0));
        fn smaller(self, a: Self::Floats, b: Self::Floats) -> Self::Floats = Vector(_mm512_min_ps(b.0, a.0));
        fn larger(self, a: Self::Floats, b: Self::Floats) -> Self::Floats = Vector(_mm512_max_ps(b.0, a.0));
        fn where_less(self, a: Self::Floats, b: Self::Floats, yes: Self::Floats, no: Self::Floats) -> Self::Floats
            = Vector(_mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a.0, b.0), no.0, yes.0));
        fn any_less(self, a: Self::Floats, b: Self::Floats) -> bool = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a.0, b.0) != 0;
        fn to_words(self, a: Self::Floats) -> Self::Words = Vector(_mm512_castps_si512(a.0));
        fn to_floats(self, a: Self::Words) -> Self::Floats = Vector(_mm512_castsi512_ps(a.0));
        fn shl<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm512_slli_epi32::<N>(a.0));
        fn shr<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm512_srli_epi32::<N>(a.0));
        fn sar<const N: u32>(self, a: Self::Words) -> Self::Words = Vector(_mm512_srai_epi32::<N>(a.0));
        fn truncate(self, a: Self::Floats) -> Self::Words = Vector(_mm512_cvttps_epi32(a.0));
        fn convert(self, a: Self::Words) -> Self::Floats = Vector(_mm512_cvtepi32_ps(a.0));
        fn permute(self, from: &[f32], index: Self::Words) -> Self::Floats = Vector(_mm512_permutexvar_ps(index.0, self.load(from).0));
        fn lookup8(self, table: &[f32; 8], index: Self::Words) -> Self::Floats = {
            // Twice the same eight, so that the fourth bit does not matter.
            let table = _mm512_broadcast_f32x8(_mm256_loadu_ps(table.as_ptr()));
            Vector(_mm512_permutexvar_ps(index.0, table))
        };
        fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats = Vector(_mm512_permutexvar_ps(index.0, self.load(table).0));
        fn twelfths(self, tables: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            // The number stands in the top byte; the other bytes' top bits are set, which answers zero.
            let number = _mm512_slli_epi32::<8>(_mm512_mulhi_epu16(hash.0, _mm512_set1_epi16(12)));
            let number = _mm512_or_si512(number, _mm512_set1_epi32(0x0080_8080));
            let first = _mm512_broadcast_i32x4(_mm_loadu_si128(tables[0].as_ptr().cast()));
            let second = _mm512_broadcast_i32x4(_mm_loadu_si128(tables[1].as_ptr().cast()));
            [Vector(_mm512_castsi512_ps(_mm512_shuffle_epi8(first, number))), Vector(_mm512_castsi512_ps(_mm512_shuffle_epi8(second, number)))]
        };
        fn floor(self, a: Self::Doubles) -> Self::Doubles = Vector([
            _mm512_roundscale_pd::<_MM_FROUND_TO_NEG_INF>(a.0[0]),
            _mm512_roundscale_pd::<_MM_FROUND_TO_NEG_INF>(a.0[1]),
        ]);
        fn round(self, a: Self::Doubles) -> Self::Floats = {
            let (low, high) = (_mm512_castps256_ps512(_mm512_cvtpd_ps(a.0[0])), _mm512_cvtpd_ps(a.0[1]));
            Vector(_mm512_insertf32x8::<1>(low, high))
        };
        fn whole_words(self, a: Self::Doubles) -> [Self::Words; 2] = {
            let [low, high] = (a + self.splat_doubles(WHOLE)).0;
            let (low, high) = (_mm512_castpd_si512(low), _mm512_castpd_si512(high));
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
            [Vector(_mm512_permutex2var_epi32(low, even, high)), Vector(_mm512_permutex2var_epi32(low, odd, high)) - self.splat_words(WHOLE_HIGH)]
        };
    }
}
