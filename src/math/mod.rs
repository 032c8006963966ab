//! Floor 0: numbers that are computed together, sizes of vectors, symmetric tensors, parameter descriptions, threads, and every tolerance.

pub mod catalogue;
pub mod curves;
pub mod digits;
pub mod lanes;
pub mod minimize;
pub mod norms;
pub(crate) mod principal;
pub mod signals;
pub mod simd;
pub mod tensor;
pub mod tolerances;
pub mod workers;
