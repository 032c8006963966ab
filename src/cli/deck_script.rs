//! Generates a first script from a deck of Abaqus or CalculiX, for `conserva new --from`.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::ops::RangeInclusive;

use crate::mesh::{Deck, DeckBoundary};

/// Densities of solids `[kg/m^3]`.
const DENSITIES: RangeInclusive<f64> = 10.0..=25_000.0;
/// Density of 1 t/mm^3 `[kg/m^3]`.
const TONS: f64 = 1e12;

/// Names that are not available for variables of the script.
const TAKEN: &[&str] = &[
    "deck",
    "scene",
    "sim",
    "material",
    "let",
    "const",
    "if",
    "else",
    "switch",
    "do",
    "while",
    "loop",
    "until",
    "for",
    "in",
    "continue",
    "break",
    "return",
    "throw",
    "try",
    "catch",
    "fn",
    "private",
    "import",
    "export",
    "as",
    "global",
    "true",
    "false",
    "this",
    "is",
    "var",
    "static",
    "shared",
    "sync",
    "async",
    "await",
    "yield",
    "default",
    "void",
    "null",
    "nil",
    "print",
    "debug",
    "type_of",
    "call",
    "curry",
    "eval",
    "goto",
    "exit",
    "match",
    "case",
    "public",
    "protected",
    "new",
    "use",
    "with",
    "module",
    "package",
    "super",
    "thread",
    "spawn",
    "go",
];

/// Returns a variable for each part: its name in lower case.
fn variables(deck: &Deck) -> Vec<String> {
    let mut taken: BTreeSet<String> = TAKEN.iter().map(|word| word.to_string()).collect();
    let variable = |name: &str| {
        let letters = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' });
        let word = letters.collect::<String>().trim_matches('_').to_string();
        let word = if word.starts_with(|first: char| first.is_ascii_alphabetic()) { word } else { format!("part_{word}") };
        let mut free = word.clone();
        let mut count = 1;
        while !taken.insert(free.clone()) {
            count += 1;
            free = format!("{word}_{count}");
        }
        free
    };
    deck.parts.iter().map(|part| part.name.as_str()).map(variable).collect()
}

/// Returns a text in quotation marks.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Returns the script of a deck; `path` is the path of the deck from the script, `name` that of the scenario.
pub fn script_of(deck: &Deck, path: &str, name: &str) -> String {
    let variables = variables(deck);
    let variable = |part: &str| deck.parts.iter().position(|known| known.name == part).map_or("body", |index| &variables[index]);
    let boundary = |of: &DeckBoundary| format!("{}.boundary({})", variable(&of.part), quoted(&of.boundary));
    let mut text = format!("// {name}: the bodies of {path}. Replace this line by what the scenario is about.\n");
    text += "// Units are those of the deck; `dt` and the acceleration of gravity are guesses.\n";
    let mut say = |line: String| writeln!(text, "{line}").unwrap_or_default();
    say(format!("let deck = read_deck({});", quoted(path)));
    let known = |material: &str| deck.materials.iter().any(|known| known.name == material && !known.properties.is_empty());
    let is_missing = deck.parts.iter().any(|part| !matches!(&part.materials[..], [material] if known(material)));
    if is_missing {
        say("// The deck does not say what all bodies are made of; this is steel in mm, t, s, MPa.".into());
        say("let material = neo_hookean(#{ youngs_modulus: 210e3, poisson_ratio: 0.3, density: 7.8e-9 });".into());
    }
    for part in deck.parts.iter().filter(|part| part.materials.len() > 1) {
        let materials: Vec<String> = part.materials.iter().map(|name| quoted(name)).collect();
        say(format!("// {} is made of {} in the deck, and a body has one material:", quoted(&part.name), materials.join(", ")));
        say("// `deck.parts[name].part(set)` is a part of it as a mesh of its own, and `scene.tie` holds bodies together.".into());
    }
    say(format!("let scene = model({});", quoted(name)));
    for (part, variable) in deck.parts.iter().zip(&variables) {
        let material = match &part.materials[..] {
            [material] if known(material) => format!("deck.materials[{}]", quoted(material)),
            _ => "material".into(),
        };
        let part = quoted(&part.name);
        say(format!("let {variable} = scene.add_body({part}, deck.parts[{part}], {material});"));
    }
    for held in &deck.held {
        say(format!("scene.fix({});", boundary(held)));
    }
    if deck.held.is_empty() {
        say("// The deck holds nothing: `scene.fix(body.boundary(\"name\"));` holds a boundary.".into());
    }
    for (index, pair) in deck.pairs.iter().enumerate() {
        let (secondary, primary) = (boundary(&pair.secondary), boundary(&pair.primary));
        let (function, name) = if pair.is_tied { ("tie", "tie") } else { ("add_contact", "contact") };
        say(format!("scene.{function}(\"{name} {}\", #{{ secondary: {secondary}, primary: {primary} }});", index + 1));
    }
    if deck.pairs.is_empty() && deck.parts.len() > 1 {
        say("// The deck has no contact pairs; `print(deck.boundaries)` lists what may touch:".into());
        say("// scene.add_contact(\"contact\", #{ secondary: one.boundary(\"name\"), primary: other.boundary(\"name\") });".into());
    }
    let dimension = deck.parts.iter().map(|part| part.mesh.dimension()).max().unwrap_or(2);
    let size = deck.parts.iter().flat_map(|part| part.mesh.points.as_flattened()).fold(0.0, |most: f64, x| most.max(x.abs()));
    // densities in t/mm^3 go with lengths in mm
    let densities = deck.materials.iter().flat_map(|of| &of.properties).filter(|property| property.keyword == "DENSITY");
    let is_in_millimeters =
        is_missing || densities.filter_map(|of| of.numbers.first()).any(|density| DENSITIES.contains(&(TONS * density)));
    let gravity = if is_in_millimeters { 9810.0 } else { 9.81 };
    // Time of a free fall of about the size of the model, `sqrt(size / g)`.
    let fall = if size > 0.0 { (size / gravity).sqrt() } else { 1.0 };
    say(format!("scene.gravity([0.0, {}-{gravity:?}]);", if dimension == 2 { "" } else { "0.0, " }));
    say(format!("let sim = simulate(scene, #{{ integrator: energy_momentum(), dt: param(\"dt\", {:.1e}) }});", fall / 200.0));
    say("sim.step(200);".into());
    say("print(sim);".into());
    text
}
