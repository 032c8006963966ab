//! Buffers of numbers aligned to cache lines, reused by successive factorizations.

use std::collections::TryReserveError;

/// Number of `f64` in a cache line of 64 bytes.
const LINE: usize = 8;

/// Reserve for later enlargement: one part in `SLACK` of the buffer's length.
const SLACK: usize = 16;

/// Buffer of numbers that starts at a cache line.
#[derive(Debug, Default)]
pub(super) struct AlignedBuffer {
    storage: Vec<f64>,
    offset: usize,
    length: usize,
}

impl AlignedBuffer {
    /// Resizes the buffer to at least `length` numbers; its values are lost.
    pub(super) fn resize(&mut self, length: usize) -> Result<(), TryReserveError> {
        if self.storage.len() < length + LINE {
            // The old buffer is freed first, since both buffers together would be the peak memory of the run.
            self.storage = Vec::new();
            let mut storage = Vec::new();
            // A reserve avoids new allocations: structures grow slightly while surfaces slide, and first access to new memory pages is
            // slow.
            let length = length + length / SLACK + LINE;
            storage.try_reserve_exact(length)?;
            storage.resize(length, 0.0);
            self.offset = storage.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
            self.storage = storage;
        }
        self.length = length;
        Ok(())
    }

    pub(super) fn all(&self) -> &[f64] {
        &self.storage[self.offset..][..self.length]
    }

    pub(super) fn all_mut(&mut self) -> &mut [f64] {
        &mut self.storage[self.offset..][..self.length]
    }
}
