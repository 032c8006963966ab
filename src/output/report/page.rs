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

/// Bytes of stills that are compressed together.
const CHUNK: usize = 2 << 20;
/// How far a half plane is drawn, in extents of the bodies.
const REACH: f64 = 50.0;

/// The same in space, from the middle of the bodies.
const REACH_IN_SPACE: f64 = 1.0;

/// Everything that a report tells.
pub struct Report<'a> {
    /// Name of the simulation.
    pub name: String,
    /// How the run ended; `None` while it goes on.
    pub outcome: Option<String>,
    /// Whether it ended as it should.
    pub is_well: bool,
    /// Version of the program.
    pub version: String,
    /// Names and texts of the script and its modules, the script first.
    pub scripts: Vec<(String, String)>,
    /// Values of `param(...)` by name.
    pub parameters: BTreeMap<String, Value>,
    /// What there is, how it is held and loaded, how it is integrated.
    pub tables: Vec<ReportTable>,
    /// What the user was warned of, and what is remarkable about the run.
    pub warnings: Vec<String>,
    /// Names and values of the history's columns in the rows of `rows`; NaN where there is no value.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Numbers of these rows among all, ascending.
    pub rows: Vec<usize>,
    /// Rows of the whole history.
    pub row_count: usize,
    /// Names of the contacts.
    pub contacts: Vec<String>,
    /// The bodies.
    pub bodies: &'a [BodyDefinition],
    /// What is recorded of each.
    pub skins: &'a [Skin],
    /// The stills, in the order of time.
    pub stills: &'a [&'a Still],
    /// The different shapes of rigid obstacles.
    pub obstacles: Vec<PlacedObstacle>,
}

/// The page of a run.
pub fn report(report: &Report) -> Vec<u8> {
    page(report, Value::Null)
}

/// The page of a run; one that follows it where there is something in `live`, which tells it how.
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
    fill(&report.name, &data, &blobs)
}

/// Numbers as the page reads them.
pub fn bytes_of(numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// The stills in groups of about the same size.
fn chunks<'a>(stills: &'a [&'a Still]) -> Vec<&'a [&'a Still]> {
    let size = stills.iter().map(|still| still.bytes().len()).max().unwrap_or(0).max(1);
    stills.chunks((CHUNK / size).max(1)).collect()
}

/// Arrays of all bodies one after the other, and what tells their lengths.
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
            "cells": body.mesh.cell_count(), "flows": skin.flows,
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
        "scripts": scripts.collect::<Vec<_>>(), "parameters": report.parameters, "tables": report.tables, "warnings": report.warnings,
        "columns": report.columns.iter().map(|(name, _)| name).collect::<Vec<_>>(), "rows": report.rows.len(),
        "row_count": report.row_count, "contacts": report.contacts, "dimension": dimension, "bodies": bodies,
        "fields": fields(report.skins, report.stills), "stills": stills.collect::<Vec<_>>(), "chunks": chunks,
        "pressing": pressing(report.stills),
        "walls": report.obstacles.iter().map(wall).collect::<Vec<_>>(),
        "colors": (0..256).map(|k| viridis(f64::from(k) / 255.0).map(f64::round)).collect::<Vec<_>>(),
    })
}

/// The fields by which a picture may be colored, with their ranges in all stills.
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

/// Longest vector of contact pressure in all stills.
pub fn pressing(stills: &[&Still]) -> f64 {
    stills.iter().map(|still| still.pressing).fold(0.0, f64::max)
}

/// Puts everything into the template.
fn fill(name: &str, data: &Value, blobs: &[(String, String)]) -> Vec<u8> {
    let is_live = data.get("live").is_some();
    let json = data.to_string().replace('<', "\\u003c");
    let mut page = String::with_capacity(1 << 20);
    let mut rest = PAGE;
    // One pass from the left, so that nothing that was put in is looked at again.
    while let Some(start) = rest.find("{{") {
        let Some(length) = rest[start..].find("}}") else { break };
        page.push_str(&rest[..start]);
        match &rest[start + 2..start + length] {
            "title" => page.push_str(&escaped(name)),
            "style" => page.push_str(STYLE),
            // What follows a run asks the server that gave the page, and nobody else.
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
