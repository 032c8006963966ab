//! Runs kernels with the instruction set of the processor.
//!
//! On x86-64 kernels use AVX2 and FMA (processors since about 2013; three to four times faster), by the crate `pulp`. With the feature
//! `portable` a second version of every kernel without these instructions is compiled and selected at run time; without the feature,
//! processors that lack them are not supported ([`is_supported`]): the second version takes a sixth of the build time. Other architectures
//! have the portable version only. Wider registers gave no speed on the processors measured: a tile of 8 x 4 numbers keeps the multipliers
//! equally busy. Results differ in the last bits between both versions, not between processors with one version.

#[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
use pulp::Scalar256b;
use pulp::{NullaryFnOnce, Simd, WithSimd};

/// A computation on [`super::lanes::Lanes`] that is compiled for more than one instruction set. `run` must be `#[inline(always)]`, and so
/// must all it calls.
pub trait Kernel {
    /// Result of the kernel.
    type Output;
    /// Computes the result; with `FMA` a fused multiply-add is one instruction.
    fn run<const FMA: bool>(self) -> Self::Output;
}

struct WithFma<K>(K);

impl<K: Kernel> NullaryFnOnce for WithFma<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.0.run::<true>()
    }
}

/// Instruction set of this processor on which the last bits of results depend.
pub fn instructions() -> String {
    #[cfg(target_arch = "x86_64")]
    {
        // faer, the fallback of the linear solver, also uses AVX-512 if available.
        let wide = std::arch::is_x86_feature_detected!("avx512f");
        let known = [(pulp::x86::V3::try_new().is_some(), "AVX2 and FMA"), (wide, "AVX-512")];
        let found: Vec<&str> = known.into_iter().filter(|(there, _)| *there).map(|(_, name)| name).collect();
        format!("x86-64 with {}", if found.is_empty() { "no wide registers".into() } else { found.join(", ") })
    }
    #[cfg(not(target_arch = "x86_64"))]
    std::env::consts::ARCH.into()
}

/// True if the program has kernels for this processor; without them, computations panic.
pub fn is_supported() -> bool {
    #[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
    return pulp::x86::V3::try_new().is_some();
    #[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
    true
}

/// Instruction set used by kernels.
#[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
#[inline]
fn registers() -> pulp::x86::V3 {
    pulp::x86::V3::try_new().expect("a processor with AVX2 and FMA, or the feature `portable`")
}

/// Runs a kernel with the best instruction set of the processor.
#[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    registers().vectorize(WithFma(kernel))
}

/// Runs a kernel with the best instruction set of the processor.
#[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
#[inline]
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(WithFma(kernel));
    }
    plain(kernel)
}

/// Runs a kernel without special instructions. Never inlined: a batch fills much of a thread's stack, and the version that is not chosen
/// must not add its own frame.
#[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
#[inline(never)]
fn plain<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<false>()
}

/// Runs a computation on registers of four numbers.
#[cfg(all(target_arch = "x86_64", not(feature = "portable")))]
#[inline]
pub(crate) fn with_registers<K: WithSimd>(kernel: K) -> K::Output {
    Simd::vectorize(registers(), kernel)
}

/// Runs a computation on registers of four numbers: AVX2 registers if the processor has them, otherwise plain numbers.
#[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
#[inline]
pub(crate) fn with_registers<K: WithSimd>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return Simd::vectorize(simd, kernel);
    }
    kernel.with_simd(Scalar256b)
}
