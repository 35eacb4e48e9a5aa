//! Instruction sets: kernels are compiled once for each and chosen when the program runs.
//!
//! No kernel's result depends on the set: each arithmetic step is one IEEE operation in all of them, so wider registers change the time and no bit. A test runs
//! every set that the machine has.

use super::lanes::{Lanes, Plain};
#[cfg(target_arch = "x86_64")]
use super::x86::{Avx2, Avx512};
use std::sync::OnceLock;

/// An instruction set that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Isa {
    /// What every machine of the target has: SSE2 on x86-64, NEON on aarch64.
    Baseline,
    /// 256-bit registers.
    Avx2,
    /// 512-bit registers: AVX-512 F, VL, BW and DQ.
    Avx512,
}

impl Isa {
    /// Every set, the widest last.
    pub const ALL: [Isa; 3] = [Isa::Baseline, Isa::Avx2, Isa::Avx512];

    /// The name in `TERRANE_ISA`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Isa::Baseline => "baseline",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }

    /// Whether this machine has it.
    #[must_use]
    pub fn is_available(self) -> bool {
        match self {
            Isa::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Isa::Avx2 | Isa::Avx512 => false,
        }
    }

    /// The widest set of this machine, or the one that the environment variable `TERRANE_ISA` names, found once.
    ///
    /// # Panics
    /// If the name is unknown or not this machine's. Programs call [`Isa::from_environment`] first, which says so as an error.
    #[must_use]
    pub fn active() -> Self {
        static ACTIVE: OnceLock<Isa> = OnceLock::new();
        *ACTIVE.get_or_init(|| Self::from_environment().expect("a set that this machine has").unwrap_or_else(Self::widest))
    }

    fn widest() -> Self {
        Self::ALL.into_iter().filter(|isa| isa.is_available()).max().unwrap_or(Isa::Baseline)
    }

    /// The set that `TERRANE_ISA` names, `None` if it is not set.
    ///
    /// # Errors
    /// If the name is unknown or the set is not this machine's; the text says which there are.
    pub fn from_environment() -> Result<Option<Self>, String> {
        let Some(name) = std::env::var_os("TERRANE_ISA") else { return Ok(None) };
        let found = Self::ALL.into_iter().find(|isa| isa.is_available() && *isa.name() == name);
        found.map(Some).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.into_iter().filter(|isa| isa.is_available()).map(Isa::name).collect();
            format!("TERRANE_ISA: this machine has {}, got {}", names.join(", "), name.display())
        })
    }

    /// Runs a kernel compiled for this set; for the baseline where the machine does not have the set.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the processor has the features, which is all that the callee asks for.
            Isa::Avx2 if self.is_available() => unsafe { with_avx2(kernel) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Isa::Avx512 if self.is_available() => unsafe { with_avx512(kernel) },
            _ => kernel.run(Plain::<BASELINE_WIDTH>),
        }
    }
}

/// A loop that is worth compiling for every instruction set. `run` must be `#[inline(always)]`, and so must all that it calls: what is not inlined is compiled for
/// the baseline.
pub trait Kernel {
    /// What the loop answers.
    type Output;

    /// The loop. Plain loops, which the compiler makes wide, have no use for the lanes.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Lanes of the baseline: those of SSE2 and NEON.
const BASELINE_WIDTH: usize = 4;

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: this function has the feature.
    kernel.run(unsafe { Avx2::assume() })
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq")]
fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
    // SAFETY: this function has the features.
    kernel.run(unsafe { Avx512::assume() })
}
