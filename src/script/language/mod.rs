//! The language: descriptions of functions, reading of arguments, messages.
//!
//! The language is independent of the API: types are added through [`handle::Types`], shared data of a topic through [`slots::Slots`].

pub mod arguments;
pub mod arrays;
pub mod callback;
pub mod causes;
pub mod comparison;
pub mod declaration;
pub mod diagnostics;
pub mod digits;
pub mod elementwise;
pub mod explain;
pub mod failure;
pub mod function;
pub mod growth;
pub mod habits;
pub mod handle;
pub mod host;
pub mod keys;
pub mod limits;
pub mod lint;
pub mod message;
pub mod observer;
pub mod parameter;
pub mod plain;
pub mod prelude;
pub mod registry;
pub mod sandbox;
pub mod scan;
pub mod settings;
pub mod slots;
pub mod sources;
pub mod tables;
pub mod thread_bound;
pub mod values;
pub mod wording;
pub mod worker_pool;
