//! The page of a run: its data put into the template.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::assets::{FOLLOWING, LAST, PAGE, PROGRAM};
use super::blob::blob;
use super::geometry::Surface;
use super::marks::Mark;
use super::tables::ReportTable;
use super::template::{TemplateParts, fill};
use crate::dynamics::{BodyDefinition, PlacedObstacle};
use crate::output::colormap::viridis;
use crate::output::obstacle_surfaces::ObstacleSurface;
use crate::output::obstacles::{Surroundings, Wall};
use crate::output::picture::Field;
use crate::output::recording::{Skin, Still};
use crate::output::still_fields::StillOptions;
use crate::output::units::{ListedUnits, pretty};

/// Size of groups of stills (recorded animation frames) that are compressed together `[bytes]`.
const CHUNK: usize = 2 << 20;
/// Half length of the line by which a half plane is drawn, relative to the extent of the bodies.
const REACH: f64 = 50.0;

/// Size of unbounded obstacles in space, from the center of the bodies, relative to their extent.
const REACH_IN_SPACE: f64 = 1.0;

/// Number of the layout of a page's data, by which pages of other versions are refused.
pub const LAYOUT: u64 = 1;

/// Fields that follow from the recorded stress.
const DERIVED: [&str; 4] = ["principal_1", "principal_2", "principal_3", "tresca"];

/// Content of a report.
pub struct Report<'a> {
    /// Name of the simulation.
    pub name: String,
    /// Outcome of the run in words; `None` during the run.
    pub outcome: Option<String>,
    /// True if the run ended as intended.
    pub is_well: bool,
    /// Version of the program.
    pub version: String,
    /// Names and texts of the script and its modules, the script first.
    pub scripts: Vec<(String, String)>,
    /// Values of `param(...)` by name.
    pub parameters: BTreeMap<String, Value>,
    /// Lines at the top of the page: what was computed, how it ended, peaks, energy; empty during the run.
    pub summary: Vec<[String; 2]>,
    /// Tables of the model: bodies, supports, loads, time integration; results and checks.
    pub tables: Vec<ReportTable>,
    /// Warnings issued to the user, and findings of the run.
    pub warnings: Vec<String>,
    /// Lines that the script has printed.
    pub printed: Vec<String>,
    /// Pictures and movies that the script has drawn.
    pub pictures: Vec<ReportPicture>,
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
    /// Content of the stills (recorded animation frames).
    pub shown: &'a StillOptions,
    /// Stills (recorded animation frames) in the order of time.
    pub stills: &'a [&'a Still],
    /// The different shapes of rigid obstacles.
    pub obstacles: Vec<PlacedObstacle>,
    /// Units of columns and fields; `None` where none are declared.
    pub units: Option<ListedUnits>,
    /// Symbols of supports, loads, springs and joints.
    pub marks: Vec<Mark>,
}

/// A picture or movie of the script on the page.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportPicture {
    /// Path below the folder of the run.
    pub path: String,
    /// Content of the file; `None` if the page names the file only, because it is too large or missing.
    pub bytes: Option<Vec<u8>>,
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
    for (number, picture) in report.pictures.iter().enumerate() {
        if let Some(bytes) = &picture.bytes {
            add(&format!("picture-{number}"), bytes);
        }
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
    let is_live = !data["live"].is_null();
    // A page that follows a run may connect only to its own server.
    let connections = if is_live { "; connect-src 'self'" } else { "" };
    let program: Vec<&str> = PROGRAM.into_iter().chain(is_live.then_some(FOLLOWING)).chain([LAST]).collect();
    fill(PAGE, &TemplateParts { title: &report.name, connections, program: &program, data: &data, blobs: &blobs })
}

/// Encodes numbers for the page.
pub fn bytes_of(numbers: impl Iterator<Item = f64>) -> Vec<u8> {
    numbers.flat_map(f64::to_le_bytes).collect()
}

/// Divides the stills (recorded animation frames) into groups of about equal size.
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
        let is_numbered = skin.nodes.len() < body.mesh.points.len();
        if is_numbered {
            bytes.extend(skin.nodes.iter().flat_map(|node| node.to_le_bytes()));
        }
        bodies.push(json!({
            "name": body.name, "nodes": surface.points.len(), "triangles": surface.triangles.len(), "edges": surface.edges.len(),
            "outline": surface.outline.len(), "tetrahedra": surface.tetrahedra.len(),
            "cells": body.mesh.cell_count(), "numbered": is_numbered, "flows": skin.flows,
            "further": skin.further_names(), "rigid": body.rigid.is_some(),
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
    let frame = report.shown.frame;
    let frame = json!({ "center": frame.center, "axis": frame.axis, "direction": frame.direction });
    let kind = |path: &str| path.rsplit_once('.').map_or("", |(_, ending)| ending).to_string();
    let pictures = report.pictures.iter();
    let pictures = pictures.map(|picture| json!({ "path": picture.path, "kind": kind(&picture.path), "shown": picture.bytes.is_some() }));
    json!({
        "layout": LAYOUT, "name": report.name, "outcome": report.outcome, "well": report.is_well, "version": report.version,
        "scripts": scripts.collect::<Vec<_>>(), "parameters": report.parameters,
        "summary": report.summary, "tables": report.tables, "warnings": report.warnings,
        "printed": report.printed, "pictures": pictures.collect::<Vec<_>>(), "marks": report.marks,
        "columns": report.columns.iter().map(|(name, _)| name).collect::<Vec<_>>(), "rows": report.rows.len(),
        "row_count": report.row_count, "contacts": report.contacts, "dimension": dimension, "bodies": bodies,
        "fields": fields(report.skins, report.stills, report.shown), "frame": frame, "stills": stills.collect::<Vec<_>>(), "chunks": chunks,
        "pressing": pressing(report.stills),
        "walls": report.obstacles.iter().map(wall).collect::<Vec<_>>(),
        "colors": (0..256).map(|k| viridis(f64::from(k) / 255.0).map(f64::round)).collect::<Vec<_>>(),
    })
}

/// Returns the fields by which a picture may be colored, the basic ones with their ranges in all stills.
pub fn fields(skins: &[Skin], stills: &[&Still], shown: &StillOptions) -> Vec<Value> {
    let (in_space, flows) = (skins.iter().any(|skin| skin.dimension == 3), skins.iter().any(|skin| skin.flows));
    let is_known = |name: &str| match name {
        "plastic_strain" => flows,
        _ => in_space || !(name.ends_with("_yz") || name.ends_with("_xz")),
    };
    let basic = Field::BASIC.iter().enumerate().filter(|(_, name)| is_known(name));
    let basic = basic.filter_map(|(index, name)| Some((Field::from_name(name)?, Some(index))));
    // The browser computes derived fields from recorded ones, and the ranges of these fields when they are shown.
    let is_offered = |field: &Field| {
        let is_named = shown.fields.contains(field) || DERIVED.contains(&field.name());
        is_named || field.further().is_some() && shown.keeps(*field) && !field.is_local()
    };
    let further = Field::all().into_iter().filter(|field| !Field::BASIC.contains(&field.name()) && is_known(field.name()));
    let further = further.filter(is_offered).map(|field| (field, None));
    let described = |(field, index): (Field, Option<usize>)| {
        let ranges = stills.iter().filter_map(|still| Some(still.extremes[index?]));
        let range = ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], [low, high]| [a.min(low), b.max(high)]);
        let [low, high] = if index.is_some() { range.map(Some) } else { [None; 2] };
        json!({ "name": field.name(), "words": field.words(), "low": low, "high": high, "kinds": field.kinds() })
    };
    basic.chain(further).map(described).collect()
}

/// Returns the length of the longest contact pressure vector in all stills (recorded animation frames).
pub fn pressing(stills: &[&Still]) -> f64 {
    stills.iter().map(|still| still.pressing).fold(0.0, f64::max)
}
