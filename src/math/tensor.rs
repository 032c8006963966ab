//! Symmetric tensors in Mandel components.
