//! The page of a run: its data put into the template.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::assets::{FOLLOWING, PAGE, PROGRAM, STYLE};
use super::blob::blob;
use super::geometry::Surface;
use super::tables::ReportTable;
use crate::dynamics::{BodyDefinition, PlacedObstacle};
use crate::output::colormap::viridis;
use crate::output::markup::escaped;
use crate::output::obstacle_surfaces::ObstacleSurface;
use crate::output::obstacles::{Surroundings, Wall};
use crate::output::picture::{Component, Field};
use crate::output::recording::{Skin, Still};
use crate::output::units::{ListedUnits, pretty};

/// Size of groups of stills that are compressed together `[bytes]`.
const CHUNK: usize = 2 << 20;
/// Half length of the line by which a half plane is drawn, relative to the extent of the bodies.
const REACH: f64 = 50.0;

/// Size of unbounded obstacles in space, from the center of the bodies, relative to their extent.
const REACH_IN_SPACE: f64 = 1.0;

/// Content of a report.
pub struct Report<'a> {
    /// Name of the simulation.
    pub name: String,
    /// Outcome of the run in words; `None` while the run goes on.
    pub outcome: Option<String>,
    /// True if the run ended as intended.
    pub is_well: bool,
    /// Version of the program.
    pub version: String,
    /// Names and texts of the script and its modules, the script first.
    pub scripts: Vec<(String, String)>,
    /// Values of `param(...)` by name.
    pub parameters: BTreeMap<String, Value>,
    /// Lines at the top of the page: what was computed, how it ended, peaks, energy; empty while the run goes on.
    pub summary: Vec<[String; 2]>,
    /// Tables of the model: bodies, supports, loads, time integration; results and checks.
    pub tables: Vec<ReportTable>,
    /// Warnings issued to the user, and findings of the run.
    pub warnings: Vec<String>,
    /// Names and values of the history's columns in the rows of `rows`; NaN where there is no value.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Indices in the whole history of the rows in `columns`, ascending.
    pub rows: Vec<usize>,
    /// Number of rows of the whole history.
    pub row_count: usize,
    /// Names of the contacts.
    pub contacts: Vec<String>,
    /// The bodies.
    pub bodies: &'a [BodyDefinition],
    /// Recorded nodes of each body.
    pub skins: &'a [Skin],
    /// The stills, in the order of time.
    pub stills: &'a [&'a Still],
    /// The different shapes of rigid obstacles.
    pub obstacles: Vec<PlacedObstacle>,
    /// Units of columns and fields; `None` where none are declared.
    pub units: Option<ListedUnits>,
}

/// Returns the page of a run.
pub fn report(report: &Report) -> Vec<u8> {
    page(report, Value::Null)
}

/// Returns the page of a run; with `live`, a page that follows the run with these parameters.
pub fn page(report: &Report, live: Value) -> Vec<u8> {
    let mut blobs: Vec<(String, String)> = Vec::new();
    let mut add = |name: &str, bytes: &[u8]| blobs.push((name.into(), blob(bytes)));
    let (geometry, bodies) = geometry(report);
    add("geometry", &geometry);
    add("history", &bytes_of(report.columns.iter().flat_map(|(_, values)| values).copied()));
    let chunks = chunks(report.stills);
    for (number, stills) in chunks.iter().enumerate() {
        let bytes: Vec<u8> = stills.iter().flat_map(|still| still.bytes()).copied().collect();
        add(&format!("stills-{number}"), &bytes);
    }
    let mut data = data(report, &bodies, &chunks.iter().map(|stills| stills.len()).collect::<Vec<_>>());
    if !live.is_null() {
        data["live"] = live;
    }
    if let Some(units) = &report.units {
        let shown =
            |units: &BTreeMap<String, String>| json!(units.iter().map(|(name, unit)| (name, pretty(unit))).collect::<BTreeMap<_, _>>());
        data["units"] = json!({ "columns": shown(&units.columns), "fields": shown(&units.fields) });
    }
    fill(&report.name, &data, &blobs)
}

/// Encodes numbers for the page.
pub fn bytes_of(numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// Divides the stills into groups of about equal size.
fn chunks<'a>(stills: &'a [&'a Still]) -> Vec<&'a [&'a Still]> {
    let size = stills.iter().map(|still| still.bytes().len()).max().unwrap_or(0).max(1);
    stills.chunks((CHUNK / size).max(1)).collect()
}

/// Returns the concatenated arrays of all bodies, and their descriptions with lengths.
fn geometry(report: &Report) -> (Vec<u8>, Vec<Value>) {
    let mut bytes: Vec<u8> = Vec::new();
    let mut bodies = Vec::new();
    for (body, skin) in report.bodies.iter().zip(report.skins) {
        let surface = Surface::new(&body.mesh, skin);
        bytes.extend(surface.points.iter().flatten().flat_map(|&x| (x as f32).to_le_bytes()));
        bytes.extend(surface.triangles.iter().flatten().flat_map(|node| node.to_le_bytes()));
        bytes.extend(surface.edges.iter().chain(&surface.outline).flatten().flat_map(|node| node.to_le_bytes()));
        bytes.extend(surface.tetrahedra.iter().flatten().flat_map(|node| node.to_le_bytes()));
        bodies.push(json!({
            "name": body.name, "nodes": surface.points.len(), "triangles": surface.triangles.len(), "edges": surface.edges.len(),
            "outline": surface.outline.len(), "tetrahedra": surface.tetrahedra.len(),
            "cells": body.mesh.cell_count(), "flows": skin.flows, "rigid": body.rigid.is_some(),
        }));
    }
    (bytes, bodies)
}

fn data(report: &Report, bodies: &[Value], chunks: &[usize]) -> Value {
    let dimension = report.skins.first().map_or(2, |skin| skin.dimension);
    let points = report.bodies.iter().flat_map(|body| body.mesh.points.iter().copied());
    let around = Surroundings::of(points);
    let wall = |obstacle: &PlacedObstacle| {
        if let Some(wall) = Wall::new(obstacle, &around, REACH) {
            return json!({ "name": wall.name, "border": wall.border, "back": wall.back, "closed": wall.is_closed });
        }
        let Some(surface) = ObstacleSurface::new(obstacle, &around, REACH_IN_SPACE) else { return Value::Null };
        let corners = |facet: &Vec<u32>| (2..facet.len()).map(|k| [facet[0], facet[k - 1], facet[k]]).collect::<Vec<_>>();
        let triangles: Vec<[u32; 3]> = surface.facets.iter().flat_map(corners).collect();
        let points: Vec<[f32; 3]> = surface.points.iter().map(|point| point.map(|x| x as f32)).collect();
        json!({ "name": surface.name, "points": points, "triangles": triangles })
    };
    let stills = report.stills.iter().map(|still| {
        let row = report.rows.binary_search(&still.row).unwrap_or_else(|place| place.min(report.rows.len().saturating_sub(1)));
        json!({ "time": still.time, "row": row, "obstacles": still.obstacles })
    });
    let scripts = report.scripts.iter().map(|(name, text)| json!({ "name": name, "text": text }));
    json!({
        "name": report.name, "outcome": report.outcome, "well": report.is_well, "version": report.version,
        "scripts": scripts.collect::<Vec<_>>(), "parameters": report.parameters,
        "summary": report.summary, "tables": report.tables, "warnings": report.warnings,
        "columns": report.columns.iter().map(|(name, _)| name).collect::<Vec<_>>(), "rows": report.rows.len(),
        "row_count": report.row_count, "contacts": report.contacts, "dimension": dimension, "bodies": bodies,
        "fields": fields(report.skins, report.stills), "stills": stills.collect::<Vec<_>>(), "chunks": chunks,
        "pressing": pressing(report.stills),
        "walls": report.obstacles.iter().map(wall).collect::<Vec<_>>(),
        "colors": (0..256).map(|k| viridis(f64::from(k) / 255.0).map(f64::round)).collect::<Vec<_>>(),
    })
}

/// Returns the fields by which a picture may be colored, with their ranges in all stills.
pub fn fields(skins: &[Skin], stills: &[&Still]) -> Vec<Value> {
    let (in_space, flows) = (skins.iter().any(|skin| skin.dimension == 3), skins.iter().any(|skin| skin.flows));
    let is_known = |field: Field| match field {
        Field::Stress(Component::Yz | Component::Xz) => in_space,
        Field::PlasticStrain => flows,
        _ => true,
    };
    let fields = Field::ALL.iter().enumerate().filter(|(_, (.., field))| is_known(*field));
    let field_of = |(index, (name, words, field)): (usize, &(&str, &str, Field))| {
        let ranges = stills.iter().map(|still| still.extremes[index]);
        let [low, high] = ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
        json!({ "name": name, "words": words, "low": low, "high": high, "kinds": field.kinds() })
    };
    fields.map(field_of).collect()
}

/// Returns the largest contact pressure vector in all stills.
pub fn pressing(stills: &[&Still]) -> f64 {
    stills.iter().map(|still| still.pressing).fold(0.0, f64::max)
}

/// Fills the template.
fn fill(name: &str, data: &Value, blobs: &[(String, String)]) -> Vec<u8> {
    let is_live = data.get("live").is_some();
    let json = data.to_string().replace('<', "\\u003c");
    let mut page = String::with_capacity(1 << 20);
    let mut rest = PAGE;
    // One pass from the left, so that inserted texts are not searched again.
    while let Some(start) = rest.find("{{") {
        let Some(length) = rest[start..].find("}}") else { break };
        page.push_str(&rest[..start]);
        match &rest[start + 2..start + length] {
            "title" => page.push_str(&escaped(name)),
            "style" => page.push_str(STYLE),
            // A page that follows a run may connect only to its own server.
            "connections" if is_live => page.push_str("; connect-src 'self'"),
            "program" => {
                let (last, parts) = PROGRAM.split_last().unwrap_or((&"", &[]));
                parts.iter().for_each(|part| page.push_str(part));
                page.push_str(if is_live { FOLLOWING } else { "" });
                page.push_str(last);
            }
            "data" => page.push_str(&json),
            "blobs" => {
                for (name, text) in blobs {
                    page.push_str(&format!("<script type=\"text/plain\" id=\"{name}\">{text}</script>\n"));
                }
            }
            _ => {}
        }
        rest = &rest[start + length + 2..];
    }
    page.push_str(rest);
    page.into_bytes()
}
