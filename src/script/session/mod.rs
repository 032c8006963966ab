//! A session that runs scripts: the engine with its scope and its host, modules, the prompt, the reference, script tests.

#[cfg(test)]
mod argument_tests;
pub mod calls;
pub mod codes;
pub mod compile;
pub mod completion;
pub mod cursor;
pub mod declarations;
pub mod document;
pub mod engine;
pub mod exchange;
pub mod formatting;
pub mod grammar;
pub mod help;
pub mod imports;
pub mod inspection;
pub mod interactive;
#[cfg(test)]
mod interactive_tests;
pub mod modules;
pub mod pages;
pub mod ranking;
pub mod record;
pub mod reference;
#[allow(clippy::module_inception)] // folder and module have one name
pub mod session;
pub mod shown;
pub mod statements;
pub mod synonyms;
pub mod testing;
pub mod words;
pub mod worker;
