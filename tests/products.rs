//! Products of the catalogues: every pair of rows that is allowed together in one of some hundred small models, each judged from its files.
//!
//! Any number at random: `cargo run --release --example products -- 1000`.

#[path = "common/mod.rs"]
mod common;
#[path = "common/scenes/geometry.rs"]
#[allow(dead_code)]
mod plane;
#[path = "common/products/mod.rs"]
mod products;
#[path = "common/run_files.rs"]
mod run_files;
#[path = "common/solids.rs"]
#[allow(dead_code)]
mod solids;
#[path = "common/splitmix.rs"]
mod splitmix;
