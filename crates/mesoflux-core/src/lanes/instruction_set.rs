//! Which vector instructions the kernels use, chosen once at run time.

use super::{Lanes, portable};
#[cfg(target_arch = "x86_64")]
use super::{avx2, avx512};
use std::sync::OnceLock;

/// A set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstructionSet {
    /// What every machine of the architecture has.
    Portable,
    /// AVX2 with FMA: four numbers at once.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512: eight numbers at once.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// Work that is compiled for every instruction set; `run` must be `#[inline(always)]` to become part of its callers.
pub(crate) trait Kernel {
    /// What the work yields.
    type Output;
    /// Does the work.
    fn run<L: Lanes>(self) -> Self::Output;
}

impl InstructionSet {
    /// The widest set that this machine has, unless `MESOFLUX_INSTRUCTIONS` names a lesser one (`portable`, `avx2`).
    pub fn detect() -> Self {
        static DETECTED: OnceLock<InstructionSet> = OnceLock::new();
        *DETECTED.get_or_init(|| {
            let wanted = std::env::var("MESOFLUX_INSTRUCTIONS").unwrap_or_default();
            let available = Self::available();
            let widest = available.last().copied().unwrap_or(Self::Portable);
            available.into_iter().find(|set| set.name() == wanted).unwrap_or(widest)
        })
    }

    /// Every set that this machine has, the widest last.
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("popcnt");
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw");
            let mut sets = vec![Self::Portable];
            if avx2 {
                sets.push(Self::Avx2);
                if avx512 {
                    sets.push(Self::Avx512);
                }
            }
            sets
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![Self::Portable]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        }
    }

    /// Runs a kernel compiled for this set.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Portable => kernel.run::<portable::Portable>(),
            // SAFETY: sets come from `available`, which asked this machine for them.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { with_avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { with_avx512(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,popcnt")]
fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<avx2::Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,popcnt")]
fn with_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<avx512::Avx512>()
}
