//! Parts of the page that are equal for every run.

/// Template of the page.
pub const PAGE: &str = include_str!("assets/page.html");
/// Style sheet of the page.
pub const STYLE: &str = include_str!("assets/style.css");
/// Parts of the page's program, in the order of their dependencies.
pub const PROGRAM: [&str; 6] = [
    include_str!("assets/base.js"),
    include_str!("assets/data.js"),
    include_str!("assets/scene.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/main.js"),
];
/// Part of the program that follows a run; inserted before the last part of `PROGRAM`.
pub const FOLLOWING: &str = include_str!("assets/follow.js");
/// Page shown until a run has a simulation.
pub const WAITING: &str = include_str!("assets/waiting.html");
