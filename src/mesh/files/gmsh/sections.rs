//! Sections of a Gmsh file in their order.

use super::super::tables::Tables;
use super::super::text::{format_of, shortened};
use super::elements;
use super::source::{Section, Source};
use super::version_4::Entities;
use super::{version_2, version_4};
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Reads the tables of a Gmsh file.
pub(in crate::mesh::files) fn read(content: &[u8]) -> Result<Tables, MeshError> {
    let mut source = Source::new(content);
    let mut version = None;
    let mut seen: Vec<&str> = Vec::new();
    let mut tables = Tables::default();
    let mut entities = None;
    while let Some(line) = source.next()? {
        let Some(name) = line.strip_prefix('$') else {
            let expected = "a section, which begins with a dollar sign";
            return source.fail(match version {
                None => FileProblem::OtherFormat { found: format_of(content) },
                Some(_) => FileProblem::Malformed { expected, found: shortened(line) },
            });
        };
        if matches!(name, "MeshFormat" | "PhysicalNames" | "Entities" | "PartitionedEntities" | "Nodes" | "ParametricNodes" | "Elements") {
            let name = if name == "ParametricNodes" { "Nodes" } else { name };
            if seen.contains(&name) {
                return source.fail(FileProblem::RepeatedSection { section: format!("${name}") });
            }
            seen.push(name);
        }
        read_section(name, &mut version, &mut source, &mut tables, &mut entities)?;
    }
    for (name, section) in [("MeshFormat", "$MeshFormat"), ("Nodes", "$Nodes"), ("Elements", "$Elements")] {
        if !seen.contains(&name) {
            if seen.is_empty() {
                return Err(FileError { at: FilePosition::Line(1), problem: FileProblem::OtherFormat { found: format_of(content) } }.into());
            }
            return source.fail(FileProblem::MissingSection { section });
        }
    }
    if matches!(version, Some(Version::Four)) && entities.is_none() && !tables.names.is_empty() {
        // Without the section of entities, named groups would be lost silently.
        return source.fail(FileProblem::MissingSection { section: "$Entities" });
    }
    Ok(tables)
}

fn read_section(
    name: &str,
    version: &mut Option<Version>,
    source: &mut Source,
    tables: &mut Tables,
    entities: &mut Entities,
) -> Result<(), MeshError> {
    match (name, *version) {
        ("MeshFormat", _) => {
            *version = Some(read_version(source)?);
            tables.is_binary = source.is_binary();
            Ok(())
        }
        ("NOD" | "NOE", _) => source.fail(FileProblem::Version { version: "1".into() }),
        ("PhysicalNames", _) => elements::read_names(source, tables),
        ("Entities" | "PartitionedEntities" | "Nodes" | "ParametricNodes" | "Elements", None) => {
            source.fail(FileProblem::MissingSection { section: "$MeshFormat" })
        }
        ("Entities", Some(Version::Four)) => version_4::read_entities(source, entities),
        ("Nodes", Some(Version::Two)) => version_2::read_nodes(source, tables, "$Nodes"),
        ("ParametricNodes", Some(Version::Two)) => version_2::read_nodes(source, tables, "$ParametricNodes"),
        ("Nodes", Some(Version::Four)) => version_4::read_nodes(source, tables),
        ("Elements", Some(known)) => {
            tables.elements_begin = Some(source.place());
            match known {
                Version::Two => version_2::read_elements(source, tables),
                Version::Four => version_4::read_elements(source, tables, entities),
            }
        }
        ("PartitionedEntities", Some(Version::Four)) => version_4::read_partitioned_entities(source, entities),
        _ => source.skip(name),
    }
}

/// Supported versions.
#[derive(Clone, Copy)]
enum Version {
    Two,
    Four,
}

/// `version file-type data-size`, and in a binary file the number 1.
fn read_version(source: &mut Source) -> Result<Version, MeshError> {
    const EXPECTED: &str = "the version of the format, 0 for ASCII or 1 for binary, and a size";
    let mut section = Section::new("$MeshFormat", source);
    section.announced = 1;
    let mut entry = source.line(&section)?;
    let number: f64 = entry.word(EXPECTED)?;
    let file_type: u64 = entry.word(EXPECTED)?;
    let version = match entry.text().split_ascii_whitespace().next() {
        // Some programs write the version number as 2.2000.
        _ if number == 2.2 => Version::Two,
        _ if number == 4.1 => Version::Four,
        written => return entry.fail(FileProblem::Version { version: shortened(written.unwrap_or_default()) }),
    };
    match file_type {
        0 => {}
        1 => {
            let size = entry.word(EXPECTED)?;
            source.begin_binary(size, matches!(version, Version::Four))?;
        }
        _ => return Err(entry.malformed(EXPECTED)),
    }
    section.found = 1;
    source.close(&section)?;
    Ok(version)
}
