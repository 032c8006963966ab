//! The parts of the page that are the same for every run.

/// The page with places for all others.
pub const PAGE: &str = include_str!("assets/page.html");
/// How it looks.
pub const STYLE: &str = include_str!("assets/style.css");
/// Its program, in the order in which one part needs another.
pub const PROGRAM: [&str; 6] = [
    include_str!("assets/base.js"),
    include_str!("assets/data.js"),
    include_str!("assets/scene.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/main.js"),
];
/// What a page has before the last part of its program where it follows a run.
pub const FOLLOWING: &str = include_str!("assets/follow.js");
/// What is shown before a run has a simulation to follow.
pub const WAITING: &str = include_str!("assets/waiting.html");
