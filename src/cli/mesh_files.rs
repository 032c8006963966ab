//! Description and pictures of mesh files by `conserva info`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::columns::short;
use crate::mesh::{self, FileNote, Mesh, MeshError, ReadOptions, below_folder_of};
use crate::output::{picture_of_boundaries, png, svg};
use crate::script::{Class, Diagnostic};

/// Labels and values that describe a file, in the order of output.
type Facts = Vec<(&'static str, Value)>;

fn refused(path: &Path, error: &MeshError) -> Box<Diagnostic> {
    let message = Diagnostic::error(Class::Script, format!("\"{}\": {error}", path.display())).code(error.code());
    let message = error.included_file().into_iter().fold(message, |message, file| message.cause(format!("it is in {}", file.display())));
    let message = error.place().into_iter().fold(message, |message, place| message.cause(format!("it shows {place}")));
    Box::new(message.hint(error.hint()))
}

fn read(path: &Path) -> Result<(Mesh, Vec<FileNote>), Box<Diagnostic>> {
    let find = below_folder_of(path);
    mesh::read_mesh_with(path, ReadOptions::default(), Some(&find)).map_err(|error| refused(path, &error))
}

/// Number of cells of each kind.
fn cells_of(mesh: &Mesh) -> String {
    mesh.blocks.iter().map(|block| format!("{} of {}", block.count(), block.kind.name())).collect::<Vec<_>>().join(", ")
}

/// Describes a mesh file: cells, bounding box, boundaries, parts, and changes made by the reader.
pub fn mesh(path: &Path) -> Result<Facts, Box<Diagnostic>> {
    let (mesh, notes) = read(path)?;
    let mut ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for point in &mesh.points {
        for i in 0..3 {
            ends[0][i] = ends[0][i].min(point[i]);
            ends[1][i] = ends[1][i].max(point[i]);
        }
    }
    let box_of = |end: [f64; 3]| end[..mesh.dimension()].iter().map(|&x| short(x)).collect::<Vec<_>>().join(", ");
    let mut facts: Facts = vec![
        ("cells", cells_of(&mesh).into()),
        ("nodes", mesh.points.len().into()),
        ("box", format!("[{}] to [{}]", box_of(ends[0]), box_of(ends[1])).into()),
        (if mesh.dimension() == 2 { "area" } else { "volume" }, mesh.measure().into()),
    ];
    let pieces = mesh.connected_cells().len();
    if pieces > 1 {
        facts.push(("connected pieces", pieces.into()));
    }
    let mut boundaries = vec![json!(["boundary", "facets", "nodes"])];
    boundaries.extend(mesh.boundaries.iter().map(|of| json!([of.name, of.facets.len(), mesh.boundary_nodes(of).len()])));
    if !mesh.boundaries.is_empty() {
        facts.push(("boundaries", boundaries.into()));
    }
    let mut parts = vec![json!(["part", "cells"])];
    parts.extend(mesh.parts.iter().map(|(name, cells)| json!([name, cells.len()])));
    if !mesh.parts.is_empty() {
        facts.push(("parts", parts.into()));
    }
    if !notes.is_empty() {
        facts.push(("notes", notes.iter().map(ToString::to_string).collect::<Vec<_>>().into()));
    }
    Ok(facts)
}

/// Draws a mesh file into a file (by default the name of the mesh file with extension `.png`); returns the path of the picture.
pub fn draw(path: &Path, kind: &str, picture: Option<PathBuf>) -> Result<PathBuf, Box<Diagnostic>> {
    let error = |title: String| Diagnostic::error(Class::Script, title);
    if kind != "mesh" {
        let title = format!("\"{}\" is no mesh file, and only those are drawn", path.display());
        return Err(Box::new(error(title).hint("name a mesh file, such as `part.msh` or `part.inp`, or leave out `--picture`")));
    }
    let named = path.file_name().unwrap_or_default();
    let picture = picture.unwrap_or_else(|| Path::new(named).with_extension("png"));
    let drawing = picture_of_boundaries(&read(path)?.0, &named.to_string_lossy());
    let bytes = match picture.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
        Some("svg") => Some(svg(&drawing).into_bytes()),
        Some("png") => png(&drawing),
        _ => {
            let title = format!("\"{}\" is neither a `.png` nor a `.svg` file", picture.display());
            return Err(Box::new(error(title).hint("give the picture one of these endings")));
        }
    };
    let written = bytes.ok_or("it is too large".to_string()).and_then(|bytes| std::fs::write(&picture, bytes).map_err(|e| e.to_string()));
    match written {
        Ok(()) => Ok(picture),
        Err(cause) => {
            let title = format!("the picture {} cannot be written", picture.display());
            Err(Box::new(error(title).cause(cause).hint("choose another path")))
        }
    }
}
