//! An input file as one mesh, and as a deck: a mesh for each body with materials, contact pairs and supports.

use super::super::assembly::assemble;
use super::super::options::{FileNote, Includes, ReadOptions, Shells};
use super::contents::Contents;
use super::definitions::DeckMaterial;
use super::reader::read;
use super::sets::key_of;
use crate::mesh::{Mesh, MeshError};

/// A body of a deck: an instance of a part, or a connected piece of a file without instances.
#[derive(Clone, Debug)]
pub struct DeckPart {
    /// Name of the instance.
    pub name: String,
    /// Mesh of the instance, with the sets and surfaces that lie in it.
    pub mesh: Mesh,
    /// Materials of its sections, by their names.
    pub materials: Vec<String>,
}

/// A boundary of a part of a deck.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeckBoundary {
    /// Name of the part.
    pub part: String,
    /// Name of the boundary of its mesh.
    pub boundary: String,
}

/// Two boundaries that touch or are tied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeckPair {
    /// Secondary (slave) boundary.
    pub secondary: DeckBoundary,
    /// Primary (master) boundary.
    pub primary: DeckBoundary,
    /// True if the surfaces are tied.
    pub is_tied: bool,
}

/// An input file of several bodies.
#[derive(Clone, Debug)]
pub struct Deck {
    /// Bodies in the order of the file.
    pub parts: Vec<DeckPart>,
    /// Materials in the order of the file.
    pub materials: Vec<DeckMaterial>,
    /// Contact pairs and ties between boundaries of parts.
    pub pairs: Vec<DeckPair>,
    /// Boundaries that are fixed in all directions.
    pub held: Vec<DeckBoundary>,
    /// Changes made to the content of the file.
    pub notes: Vec<FileNote>,
}

/// The mesh of all parts and instances of a file, and the changes made to the content.
pub(in crate::mesh::files) fn read_whole(
    content: &[u8],
    options: &ReadOptions,
    includes: Includes,
) -> Result<(Mesh, Vec<FileNote>), MeshError> {
    let contents = read(content, includes)?;
    let used = contents.used();
    match contents.tables(&used).and_then(|tables| assemble(tables, options)) {
        Ok((mesh, notes)) => Ok((mesh, contents.notes.into_iter().chain(notes).collect())),
        Err(error) => Err(contents.origins.located(error)),
    }
}

/// The deck that a file describes.
pub(in crate::mesh::files) fn read_deck(content: &[u8], options: &ReadOptions, includes: Includes) -> Result<Deck, MeshError> {
    let contents = read(content, includes)?;
    let mut notes = contents.notes.clone();
    match parts_of(&contents, options, &mut notes) {
        Ok(parts) => Ok(deck_of(contents, parts, notes)),
        Err(error) => Err(contents.origins.located(error)),
    }
}

/// Parts, each with its scope.
fn parts_of(contents: &Contents, options: &ReadOptions, notes: &mut Vec<FileNote>) -> Result<Vec<(usize, DeckPart)>, MeshError> {
    let used = contents.used();
    if used == [0] {
        let (mesh, own) = assemble(contents.tables(&[0])?, options)?;
        notes.extend(own);
        return Ok(pieces_of(contents, &mesh).into_iter().map(|part| (0, part)).collect());
    }
    let mut parts = Vec::new();
    for &scope in &used {
        let own = &contents.scopes[scope];
        // An instance of an analytical rigid body has no cells and is left out.
        let has_cells = own.elements.keys().any(|number| options.shells == Shells::Plane || !own.tables.structural.contains(number));
        if !has_cells && used.len() > 1 {
            notes.extend((scope > 0).then(|| FileNote::WithoutCells(own.name.clone())));
            continue;
        }
        let (mesh, own_notes) = assemble(contents.tables(&[scope])?, options)?;
        notes.extend(own_notes);
        let mut materials: Vec<String> = own.sections.iter().map(|(_, material)| material.clone()).collect();
        materials.dedup();
        let name = if scope == 0 { "assembly".into() } else { own.name.clone() };
        parts.push((scope, DeckPart { name, mesh, materials }));
    }
    Ok(parts)
}

/// Connected components of a mesh without instances. A component has the name of the set of its cells, if there is one.
fn pieces_of(contents: &Contents, mesh: &Mesh) -> Vec<DeckPart> {
    let pieces = mesh.connected_cells();
    let of_piece = |(index, cells): (usize, &Vec<u32>)| {
        let is_same = |(_, set): &&(String, Vec<u32>)| set.len() == cells.len() && cells.iter().all(|cell| set.contains(cell));
        let name = mesh.parts.iter().find(is_same).map_or_else(|| format!("body {}", index + 1), |(name, _)| name.clone());
        let own = mesh.of_cells(cells);
        let has = |set: &str| own.parts.iter().any(|(name, _)| key_of(name) == set);
        let mut materials: Vec<String> =
            contents.scopes[0].sections.iter().filter(|(set, _)| has(set)).map(|(_, material)| material.clone()).collect();
        materials.dedup();
        DeckPart { name, mesh: own, materials }
    };
    pieces.iter().enumerate().map(of_piece).collect()
}

fn deck_of(contents: Contents, mut parts: Vec<(usize, DeckPart)>, notes: Vec<FileNote>) -> Deck {
    // Sections may write the name of a material in another case than its definition; the name of the definition is used.
    for name in parts.iter_mut().flat_map(|(_, part)| &mut part.materials) {
        if let Some(material) = contents.definitions.materials.iter().find(|material| key_of(&material.name) == key_of(name)) {
            name.clone_from(&material.name);
        }
    }
    let boundaries = |name: &str| -> Vec<DeckBoundary> {
        let (scope, own) = contents.in_scope(name);
        let is_meant = |boundary: &str| key_of(boundary) == key_of(own) || key_of(boundary) == key_of(name);
        let of_parts = parts.iter().filter(|(of, _)| scope.is_none_or(|scope| scope == *of));
        let found = of_parts.filter_map(|(_, part)| {
            let boundary = part.mesh.boundaries.iter().find(|boundary| is_meant(&boundary.name))?;
            Some(DeckBoundary { part: part.name.clone(), boundary: boundary.name.clone() })
        });
        found.collect()
    };
    let pairs = contents.definitions.pairs.iter().filter_map(|pair| {
        let [secondary, primary] = [&pair.secondary, &pair.primary].map(|name| boundaries(name).into_iter().next());
        Some(DeckPair { secondary: secondary?, primary: primary?, is_tied: pair.is_tied })
    });
    let dimension = |of: &DeckBoundary| parts.iter().find(|(_, part)| part.name == of.part).map_or(0, |(_, part)| part.mesh.dimension());
    let held = contents.definitions.held.iter();
    let held = held.flat_map(|(name, last)| boundaries(name).into_iter().filter(|of| *last >= dimension(of)));
    let (pairs, held) = (pairs.collect(), held.collect());
    Deck { parts: parts.into_iter().map(|(_, part)| part).collect(), materials: contents.definitions.materials, pairs, held, notes }
}
