//! Floor 0: numbers that are computed together, sizes of vectors, symmetric tensors, parameter descriptions, threads, and every tolerance of the program.

pub mod catalogue;
pub mod lanes;
pub mod norms;
pub mod simd;
pub mod tensor;
pub mod tolerances;
pub mod workers;
