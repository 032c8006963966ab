//! Parts of the page that are equal for every run.

/// Head of a template.
pub const HEAD: &str = include_str!("assets/head.html");
/// Body of the template of a page.
pub const PAGE: &str = include_str!("assets/page.html");
/// Body of the template of a page of several runs.
pub const COMPARISON: &str = include_str!("assets/compare.html");
/// Style sheet of the page.
pub const STYLE: &str = include_str!("assets/style.css");
/// Parts of the page's program, in the order of their dependencies.
pub const PROGRAM: [&str; 9] = [
    include_str!("assets/base.js"),
    include_str!("assets/data.js"),
    include_str!("assets/scene.js"),
    include_str!("assets/marks.js"),
    include_str!("assets/steer.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/tables.js"),
    include_str!("assets/nodes.js"),
    include_str!("assets/theme.js"),
];
/// Last part of the program of a page.
pub const LAST: &str = include_str!("assets/main.js");
/// Last part of the program of a page of several runs.
pub const LAST_OF_SEVERAL: &str = include_str!("assets/compare.js");
/// Part of the program that follows a run; inserted before the last part.
pub const FOLLOWING: &str = include_str!("assets/follow.js");
/// Page shown until a run has a simulation.
pub const WAITING: &str = include_str!("assets/waiting.html");
