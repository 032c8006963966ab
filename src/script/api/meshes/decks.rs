//! Decks of Abaqus and CalculiX: a mesh for each body, its materials, and interactions.

use super::handle::MeshHandle;
use super::reader::{included, notes_warned, read_failure, read_options, readable, reading_parameters};
use crate::materials::{Material, MaterialRow};
use crate::mesh::{self, Deck, DeckBoundary, DeckMaterial, DeckProperty};
use crate::script::api::materials::MaterialHandle;
use crate::script::language::diagnostics::Diagnostic;
use crate::script::language::prelude::*;

/// Ratio of bulk to shear modulus that replaces the incompressibility of a material.
const HARDLY_COMPRESSIBLE: f64 = 1000.0;

/// Function `read_deck` of scripts.
pub fn read_deck() -> Function {
    let density = Parameter::number("density", "mass/volume", Interval::Positive, "density of materials for which the file has none");
    let mut options = reading_parameters();
    options.push(density.otherwise("1, with a warning"));
    function(Topic::Meshes, "read_deck")
        .summary(
            "the bodies of an Abaqus or CalculiX input file as a map: `parts`, a mesh for each instance (without instances: for each \
             connected piece) by its name, with the sets and surfaces that lie in it as boundaries; `boundaries`, for each name of a \
             boundary the names of the parts that have it; `materials` by their names (`*ELASTIC` is `saint_venant_kirchhoff`, \
             `*HYPERELASTIC` the law of its name); `sections`, the name of the material of each part that has one alone; `pairs`, contact \
             pairs and ties as maps with `secondary`, `primary` (each `[part, boundary]`) and `tied`; `held`, boundaries that are held in \
             all directions, each `[part, boundary]`",
        )
        .parameters(vec![
            Parameter::text("path", "the file, below the script's folder or a folder that `--allow-read` names"),
            Parameter::options("how it is read").otherwise("its defaults").keys(options),
        ])
        .see_also(&["read_mesh", "pieces", "add_body"])
        .example("expect_error(|| read_deck(\"missing.inp\"), \"there is no file\");")
        .body(|call| {
            let argument = call.argument("path");
            let (path, options) = (argument.text()?, call.options("options")?);
            let file = readable(&argument, &path)?;
            let find = |name: &str| included(call, &file, name);
            let deck = mesh::read_deck(&file, read_options(&options)?, Some(&find));
            let deck = deck.map_err(|error| read_failure(&argument, &path, &file, &error))?;
            notes_warned(call, &path, &deck.notes);
            Ok(value_of(call, &options, deck)?)
        })
}

fn value_of(call: &Call, options: &Options, deck: Deck) -> Result<Map, Failure> {
    let mut boundaries = Map::new();
    for part in &deck.parts {
        for boundary in &part.mesh.boundaries {
            let parts = boundaries.entry(boundary.name.as_str().into()).or_insert_with(|| Array::new().into());
            if let Some(mut parts) = parts.write_lock::<Array>() {
                parts.push(part.name.clone().into());
            }
        }
    }
    let mut materials = Map::new();
    for material in &deck.materials {
        if let Some(made) = material_of(call, options, material)? {
            materials.insert(material.name.as_str().into(), Dynamic::from(MaterialHandle(made)));
        }
    }
    let place = |of: &DeckBoundary| Dynamic::from_array(vec![of.part.clone().into(), of.boundary.clone().into()]);
    let pair = |pair: &mesh::DeckPair| {
        map_of([("secondary", place(&pair.secondary)), ("primary", place(&pair.primary)), ("tied", pair.is_tied.into())])
    };
    let (pairs, held): (Array, Array) = (deck.pairs.iter().map(pair).collect(), deck.held.iter().map(place).collect());
    let mut sections = Map::new();
    let mut parts = Map::new();
    for part in deck.parts {
        if let [material] = &part.materials[..] {
            sections.insert(part.name.as_str().into(), material.clone().into());
        }
        parts.insert(part.name.as_str().into(), Dynamic::from(MeshHandle::new(part.mesh)));
    }
    let entries: [(&str, Dynamic); 6] = [
        ("parts", parts.into()),
        ("boundaries", boundaries.into()),
        ("materials", materials.into()),
        ("sections", sections.into()),
        ("pairs", pairs.into()),
        ("held", held.into()),
    ];
    Ok(entries.into_iter().map(|(name, value)| (name.into(), value)).collect())
}

/// A law with its constants except the density.
struct Constants {
    law: &'static str,
    values: Vec<f64>,
    is_incompressible: bool,
}

/// Returns the material of a deck; `None`, with a warning, if its law is not supported.
fn material_of(call: &Call, options: &Options, material: &DeckMaterial) -> Result<Option<Material>, Failure> {
    let warn = |title: String, code: &'static str, hint: &str| {
        call.host.warn(Diagnostic::warning(title, call.place(&Target::Argument(0))).code(code).hint(hint));
    };
    let name = &material.name;
    let property = |keyword: &str| material.properties.iter().find(|property| property.keyword == keyword);
    let found = property("HYPERELASTIC").and_then(hyperelastic).or_else(|| property("ELASTIC").and_then(elastic));
    let Some(Constants { law, mut values, is_incompressible }) = found else {
        let what = if property("ELASTIC").or(property("HYPERELASTIC")).is_some() { "a law that is not read" } else { "no elastic law" };
        warn(format!("the material \"{name}\" has {what}"), "C0291", "make it with a material function such as `neo_hookean`");
        return Ok(None);
    };
    if is_incompressible {
        let title = format!("the material \"{name}\" is incompressible in the file");
        warn(title, "C0292", "its bulk modulus is 1000 times its shear modulus here; make another material where that matters");
    }
    let given = options.argument("density");
    let density = match property("DENSITY").and_then(|property| property.numbers.first().copied()) {
        Some(density) => density,
        None if given.is_given() => given.number()?,
        None => {
            let title = format!("the material \"{name}\" has no density in the file; 1 is taken");
            warn(title, "C0293", "write `read_deck(path, #{ density: 7.8e-9 })`; equilibria do not depend on it");
            1.0
        }
    };
    values.push(density);
    let row: Option<&'static MaterialRow> = crate::materials::CATALOGUE.iter().find(|row| row.name == law && row.is_usual());
    match row.map(|row| Material::new(row, &values)) {
        Some(Ok(material)) => Ok(Some(material)),
        Some(Err(error)) => {
            warn(format!("the material \"{name}\" cannot be made: {error}"), "C0294", "correct its constants in the file");
            Ok(None)
        }
        None => Ok(None),
    }
}

fn elastic(property: &DeckProperty) -> Option<Constants> {
    let is_isotropic = property.parameters.iter().all(|(name, value)| name != "TYPE" || value.starts_with("ISO"));
    match property.numbers[..] {
        [modulus, ratio, ..] if is_isotropic => {
            Some(Constants { law: "saint_venant_kirchhoff", values: vec![modulus, ratio], is_incompressible: false })
        }
        _ => None,
    }
}

/// Returns the constants of a hyperelastic law: those of its potential, then `D1` with the bulk modulus `2/D1` (Abaqus Analysis User's
/// Guide, section 22.5.1). Ogden's potential is `2 mu/alpha^2 (…)` in Abaqus and `mu/alpha (…)` here.
fn hyperelastic(property: &DeckProperty) -> Option<Constants> {
    let has = |name: &str| property.parameters.iter().any(|(known, _)| known.replace(['-', ' '], "") == name);
    if has("TESTDATAINPUT") || has("USER") {
        return None;
    }
    let order = property.parameters.iter().find(|(name, _)| name == "N").map_or(Some(1), |(_, value)| value.parse::<usize>().ok())?;
    let number = |place: usize| property.numbers.get(place).copied().unwrap_or(0.0);
    let reduced = |order: usize| -> (_, Vec<f64>, f64, f64) {
        let c = |place: usize| if place < order { number(place) } else { 0.0 };
        ("yeoh", vec![c(0), c(1), c(2)], number(order), 2.0 * number(0))
    };
    let (law, mut values, d, shear) = if has("NEOHOOKE") {
        reduced(1)
    } else if has("YEOH") {
        reduced(3)
    } else if has("REDUCEDPOLYNOMIAL") && order <= 3 {
        reduced(order)
    } else if has("OGDEN") && order <= 3 {
        let term = |p: usize| if p < order { (number(2 * p), number(2 * p + 1)) } else { (0.0, 2.0) };
        let terms = [term(0), term(1), term(2)];
        let shear = terms.iter().map(|(mu, _)| mu).sum();
        ("ogden", terms.iter().flat_map(|(mu, alpha)| [2.0 * mu / alpha, *alpha]).collect(), number(2 * order), shear)
    } else if has("ARRUDABOYCE") {
        ("arruda_boyce", vec![number(0), number(1)], number(2), number(0))
    } else if has("MOONEYRIVLIN") || order == 1 && !has("OGDEN") && !has("MARLOW") && !has("VANDERWAALS") {
        ("mooney_rivlin", vec![number(0), number(1)], number(2), 2.0 * (number(0) + number(1)))
    } else {
        return None;
    };
    values.push(if d == 0.0 { HARDLY_COMPRESSIBLE * shear } else { 2.0 / d });
    Some(Constants { law, values, is_incompressible: d == 0.0 })
}
