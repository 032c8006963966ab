//! Floor 0 of `ARCHITECTURE.md`: SIMD lanes, vector norms, symmetric tensors, parameter descriptions, signals, minimization, threads, and
//! every tolerance.

pub mod catalogue;
pub mod curves;
pub mod digits;
pub mod lanes;
pub mod minimize;
pub mod norms;
pub mod principal;
pub mod rounds;
pub mod signals;
pub mod simd;
pub mod tensor;
pub mod tolerances;
pub mod workers;
