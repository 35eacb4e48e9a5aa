//! The vectors of x86-64 processors: AVX2 and AVX-512.
//!
//! Tokens and vectors of a set exist only where the processor has it: whoever makes the first token vouches for that, and everything else comes from a token.
//! This is why the intrinsics may be called.

use super::lanes::Lanes;
use core::{
    arch::x86_64::{
        __m256, __m256d, __m256i, __m512, __m512d, __m512i, _CMP_LT_OQ, _mm_cvtsd_f64, _mm_loadu_si128, _mm_max_pd, _mm_min_pd, _mm_unpackhi_pd,
        _mm256_add_epi32, _mm256_add_pd, _mm256_add_ps, _mm256_and_ps, _mm256_and_si256, _mm256_blendv_pd, _mm256_blendv_ps, _mm256_broadcastsi128_si256,
        _mm256_castpd_ps, _mm256_castpd256_pd128, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvtpd_ps,
        _mm256_cvttps_epi32, _mm256_div_pd, _mm256_extractf128_pd, _mm256_loadu_pd, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_loadu2_m128, _mm256_max_pd,
        _mm256_max_ps, _mm256_min_pd, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_pd, _mm256_mul_ps, _mm256_mulhi_epu16, _mm256_mullo_epi32, _mm256_or_si256,
        _mm256_permute4x64_epi64, _mm256_permutevar8x32_ps, _mm256_set_m128, _mm256_set1_epi16, _mm256_set1_epi32, _mm256_set1_pd, _mm256_set1_ps,
        _mm256_shuffle_epi8, _mm256_shuffle_ps, _mm256_slli_epi32, _mm256_sllv_epi32, _mm256_sqrt_pd, _mm256_sqrt_ps, _mm256_srav_epi32, _mm256_srli_epi32,
        _mm256_srlv_epi32, _mm256_storeu_pd, _mm256_storeu_ps, _mm256_storeu_si256, _mm256_sub_epi32, _mm256_sub_pd, _mm256_sub_ps, _mm256_unpackhi_pd,
        _mm256_unpacklo_pd, _mm256_xor_ps, _mm256_xor_si256, _mm512_abs_ps, _mm512_add_epi32, _mm512_add_pd, _mm512_add_ps, _mm512_and_si512,
        _mm512_castpd_si512, _mm512_castpd512_pd256, _mm512_castps_si512, _mm512_castps256_ps512, _mm512_castsi512_ps, _mm512_cmp_pd_mask, _mm512_cmp_ps_mask,
        _mm512_cvtepi32_ps, _mm512_cvtpd_ps, _mm512_cvttps_epi32, _mm512_div_pd, _mm512_extractf64x4_pd, _mm512_insertf32x8, _mm512_loadu_pd, _mm512_loadu_ps,
        _mm512_loadu_si512, _mm512_mask_blend_pd, _mm512_mask_blend_ps, _mm512_max_pd, _mm512_max_ps, _mm512_min_pd, _mm512_min_ps, _mm512_mul_pd,
        _mm512_mul_ps, _mm512_mulhi_epu16, _mm512_mullo_epi32, _mm512_or_si512, _mm512_permutex2var_epi32, _mm512_permutex2var_ps, _mm512_permutexvar_ps,
        _mm512_set1_epi16, _mm512_set1_epi32, _mm512_set1_pd, _mm512_set1_ps, _mm512_setr_epi32, _mm512_slli_epi32, _mm512_sqrt_pd, _mm512_sqrt_ps,
        _mm512_srai_epi32, _mm512_srli_epi32, _mm512_storeu_pd, _mm512_storeu_ps, _mm512_storeu_si512, _mm512_sub_epi32, _mm512_sub_pd, _mm512_sub_ps,
        _mm512_xor_si512,
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
    const REACH: usize = 8;
    const SPAN: usize = 4;
    type Single = Self;
    type Floats = Vector<__m256>;
    type Words = Vector<__m256i>;
    type Doubles = Vector<[__m256d; 2]>;

    #[inline(always)]
    fn single(self) -> Self {
        self
    }

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
        fn round(self, a: Self::Doubles) -> Self::Floats = Vector(_mm256_set_m128(_mm256_cvtpd_ps(a.0[1]), _mm256_cvtpd_ps(a.0[0])));
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
        fn permute_two(self, from: [&[f32]; 2], index: Self::Words) -> Self::Floats = {
            let from = _mm256_loadu2_m128(from[1][..4].as_ptr(), from[0][..4].as_ptr());
            Vector(_mm256_permutevar8x32_ps(from, index.0))
        };
        fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats = {
            let (low, high) = (self.permute(&table[..8], index), self.permute(&table[8..], index));
            // The fourth bit, moved to the top, chooses.
            Vector(_mm256_blendv_ps(low.0, high.0, _mm256_castsi256_ps(self.shl::<28>(index).0)))
        };
        fn sixteenths(self, tables: &[[f32; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            // Of each table the first eight; the top bit tells the negatives.
            let (index, sign) = (_mm256_srli_epi32::<28>(hash.0), _mm256_castsi256_ps(_mm256_and_si256(hash.0, _mm256_set1_epi32(i32::MIN))));
            let (first, second) = (_mm256_permutevar8x32_ps(self.load(&tables[0]).0, index), _mm256_permutevar8x32_ps(self.load(&tables[1]).0, index));
            [Vector(_mm256_xor_ps(first, sign)), Vector(_mm256_xor_ps(second, sign))]
        };
        fn twelfths(self, tables: &[[f32; 16]; 2], bytes: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            // The number stands in the top byte; the other bytes' top bits are set, which answers zero.
            let number = _mm256_slli_epi32::<8>(_mm256_mulhi_epu16(hash.0, _mm256_set1_epi16(12)));
            let number = _mm256_or_si256(number, _mm256_set1_epi32(0x0080_8080));
            let first = _mm256_broadcastsi128_si256(_mm_loadu_si128(bytes[0].as_ptr().cast()));
            let second = _mm256_broadcastsi128_si256(_mm_loadu_si128(bytes[1].as_ptr().cast()));
            let half = self.splat(tables[0][0] * 0.5);
            let (first, second) = (_mm256_shuffle_epi8(first, number), _mm256_shuffle_epi8(second, number));
            [Vector(_mm256_castsi256_ps(first)) * half, Vector(_mm256_castsi256_ps(second)) * half]
        };
        fn low_words(self, a: Self::Doubles) -> Self::Words = {
            // Shuffling leaves the two halves' pairs alternating.
            let words = _mm256_shuffle_ps::<0b10_00_10_00>(_mm256_castpd_ps(a.0[0]), _mm256_castpd_ps(a.0[1]));
            Vector(_mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_castps_si256(words)))
        };
        fn high_words(self, a: Self::Doubles) -> Self::Words = {
            let words = _mm256_shuffle_ps::<0b11_01_11_01>(_mm256_castpd_ps(a.0[0]), _mm256_castpd_ps(a.0[1]));
            Vector(_mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_castps_si256(words)))
        };
        fn least(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm256_min_pd(a.0[0], b.0[0]), _mm256_min_pd(a.0[1], b.0[1])]);
        fn greatest(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm256_max_pd(a.0[0], b.0[0]), _mm256_max_pd(a.0[1], b.0[1])]);
        fn ends(self, least: [Self::Doubles; 2], greatest: [Self::Doubles; 2]) -> [[f64; 2]; 2] = {
            let [u, v] = [_mm256_min_pd(least[0].0[0], least[0].0[1]), _mm256_min_pd(least[1].0[0], least[1].0[1])];
            let both = _mm256_min_pd(_mm256_unpacklo_pd(u, v), _mm256_unpackhi_pd(u, v));
            let least = _mm_min_pd(_mm256_castpd256_pd128(both), _mm256_extractf128_pd::<1>(both));
            let [u, v] = [_mm256_max_pd(greatest[0].0[0], greatest[0].0[1]), _mm256_max_pd(greatest[1].0[0], greatest[1].0[1])];
            let both = _mm256_max_pd(_mm256_unpacklo_pd(u, v), _mm256_unpackhi_pd(u, v));
            let greatest = _mm_max_pd(_mm256_castpd256_pd128(both), _mm256_extractf128_pd::<1>(both));
            [
                [_mm_cvtsd_f64(least), _mm_cvtsd_f64(_mm_unpackhi_pd(least, least))],
                [_mm_cvtsd_f64(greatest), _mm_cvtsd_f64(_mm_unpackhi_pd(greatest, greatest))],
            ]
        };
    }
}

impl Lanes for Avx512 {
    const WIDTH: usize = 16;
    const REACH: usize = 16;
    const SPAN: usize = 16;
    type Single = Self;
    type Floats = Vector<__m512>;
    type Words = Vector<__m512i>;
    type Doubles = Vector<[__m512d; 2]>;

    #[inline(always)]
    fn single(self) -> Self {
        self
    }

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
        fn round(self, a: Self::Doubles) -> Self::Floats = {
            let (low, high) = (_mm512_castps256_ps512(_mm512_cvtpd_ps(a.0[0])), _mm512_cvtpd_ps(a.0[1]));
            Vector(_mm512_insertf32x8::<1>(low, high))
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
        fn permute_two(self, from: [&[f32]; 2], index: Self::Words) -> Self::Floats
            = Vector(_mm512_permutex2var_ps(self.load(from[0]).0, index.0, self.load(from[1]).0));
        fn lookup16(self, table: &[f32; 16], index: Self::Words) -> Self::Floats = Vector(_mm512_permutexvar_ps(index.0, self.load(table).0));
        fn sixteenths(self, tables: &[[f32; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            let index = Vector(_mm512_srli_epi32::<28>(hash.0));
            [self.permute(&tables[0], index), self.permute(&tables[1], index)]
        };
        fn twelfths(self, tables: &[[f32; 16]; 2], _bytes: &[[u8; 16]; 2], hash: Self::Words) -> [Self::Floats; 2] = {
            let index = self.shr::<16>(Vector(_mm512_mulhi_epu16(hash.0, _mm512_set1_epi16(12))));
            [self.permute(&tables[0], index), self.permute(&tables[1], index)]
        };
        fn low_words(self, a: Self::Doubles) -> Self::Words = {
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            Vector(_mm512_permutex2var_epi32(_mm512_castpd_si512(a.0[0]), even, _mm512_castpd_si512(a.0[1])))
        };
        fn high_words(self, a: Self::Doubles) -> Self::Words = {
            let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            Vector(_mm512_permutex2var_epi32(_mm512_castpd_si512(a.0[0]), odd, _mm512_castpd_si512(a.0[1])))
        };
        fn least(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm512_min_pd(a.0[0], b.0[0]), _mm512_min_pd(a.0[1], b.0[1])]);
        fn greatest(self, a: Self::Doubles, b: Self::Doubles) -> Self::Doubles = Vector([_mm512_max_pd(a.0[0], b.0[0]), _mm512_max_pd(a.0[1], b.0[1])]);
        fn ends(self, least: [Self::Doubles; 2], greatest: [Self::Doubles; 2]) -> [[f64; 2]; 2] = {
            let [u, v] = [_mm512_min_pd(least[0].0[0], least[0].0[1]), _mm512_min_pd(least[1].0[0], least[1].0[1])];
            let u = Vector([_mm512_castpd512_pd256(u), _mm512_extractf64x4_pd::<1>(u)]);
            let v = Vector([_mm512_castpd512_pd256(v), _mm512_extractf64x4_pd::<1>(v)]);
            let least = [u, v];
            let [u, v] = [_mm512_max_pd(greatest[0].0[0], greatest[0].0[1]), _mm512_max_pd(greatest[1].0[0], greatest[1].0[1])];
            let u = Vector([_mm512_castpd512_pd256(u), _mm512_extractf64x4_pd::<1>(u)]);
            let v = Vector([_mm512_castpd512_pd256(v), _mm512_extractf64x4_pd::<1>(v)]);
            Avx2(()).ends(least, [u, v])
        };
    }
}
