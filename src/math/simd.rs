//! Running a kernel with the instructions that the processor has: the one place with `unsafe`.
//!
//! The program is compiled for every x86-64 processor. A kernel written on [`super::lanes::Lanes`] is compiled twice, once plain and once
//! with AVX2 and FMA allowed, and the choice is made here at run time (three to four times faster where the instructions exist; wider ones
//! gain nothing). Results differ in the last bits between processors with and without these instructions; on one kind they are the same.

/// A computation that is compiled for more than one instruction set. `run` must be `#[inline(always)]`, and so must all it calls.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// Computes; `FMA` says whether a fused multiply-add is one instruction.
    fn run<const FMA: bool>(self) -> Self::Output;
}

/// Runs a kernel with the best instructions at hand.
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma")]
        fn with_avx2<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<true>()
        }
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
            // SAFETY: `with_avx2` requires AVX2 and FMA, and both were just detected on this processor; it has no other requirement.
            return unsafe { with_avx2(kernel) };
        }
    }
    kernel.run::<false>()
}
