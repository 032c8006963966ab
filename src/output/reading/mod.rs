//! Reading of files of a run: tables, lists of frames, frames, the whole folder. All lengths and counts in a file are checked against its
//! bytes, because a run may have been killed and files may have been edited.

pub mod columns;
pub mod error;
pub mod fields;
pub mod folder;
pub mod frames;
#[cfg(feature = "formats")]
pub mod parquet_table;
pub mod table;
pub mod tags;
