//! Tests of the page as bytes: self-contained, safe for any names and texts, and with the numbers of the run.

use std::collections::BTreeMap;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::DeflateDecoder;
use serde_json::Value;

use super::*;
use crate::bodies::Formulation;
use crate::dynamics::{BodyDefinition, LedgerRow, Model, Options, Quantity, Simulation};
use crate::integrators::ENERGY_MOMENTUM;
use crate::materials::NeoHookean;
use crate::output::{Recording, StillOptions};

const EVIL: &str = "</script><script>alert(1)</script><!-- \u{2028} & \" ' {{data}}";

fn four() -> StillOptions {
    StillOptions { most: Some(4), ..StillOptions::default() }
}

fn model() -> Model {
    let mesh = crate::mesh::rectangle([2.0, 1.0], [4, 2], [0.0, 0.0]).unwrap();
    let material = NeoHookean { youngs_modulus: 10.0, poisson_ratio: 0.3, density: 1.0 }.material().unwrap();
    let body = BodyDefinition { name: EVIL.into(), mesh: mesh.into(), material, formulation: Formulation::default(), rigid: None };
    Model { name: EVIL.into(), bodies: vec![body], gravity: [0.0, -1.0, 0.0], ..Model::default() }
}

/// A page of a body that falls for some steps, and its history.
fn page() -> (String, Vec<LedgerRow>) {
    let model = model();
    let mut simulation = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.1)).unwrap();
    let mut recording = Recording::new(&model, &four());
    let mut rows = vec![simulation.row().clone()];
    recording.begin(&simulation, 0);
    for _ in 0..9 {
        simulation.step(None, &mut |row| rows.push(row.clone())).unwrap();
        recording.advanced(&simulation, rows.len() - 1);
    }
    let stills: Vec<_> = recording.stills().iter().map(|still| &**still).collect();
    let names = Quantity::names(&LedgerRow::columns(2));
    let columns = names.iter().map(|name| (name.to_string(), rows.iter().map(|row| row.column(name).unwrap()).collect()));
    let report = Report {
        name: EVIL.into(),
        outcome: Some(EVIL.into()),
        is_well: true,
        version: "0".into(),
        scripts: vec![(EVIL.into(), EVIL.into())],
        parameters: BTreeMap::from([(EVIL.to_string(), Value::from(EVIL))]),
        summary: vec![[EVIL.into(), EVIL.into()]],
        tables: vec![ReportTable { title: EVIL.into(), head: vec![EVIL.into()], rows: vec![vec![EVIL.into()]] }],
        warnings: vec![EVIL.into()],
        printed: vec![EVIL.into()],
        pictures: vec![ReportPicture { path: EVIL.into(), bytes: Some(EVIL.into()) }],
        columns: columns.collect(),
        rows: (0..rows.len()).collect(),
        row_count: rows.len(),
        contacts: Vec::new(),
        bodies: &model.bodies,
        skins: recording.bodies(),
        shown: &StillOptions::default(),
        stills: &stills,
        obstacles: Vec::new(),
        units: None,
        marks: marks(&model, recording.bodies()),
    };
    (String::from_utf8(super::report(&report)).unwrap(), rows)
}

/// Text of the element with an identifier.
fn content<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.find(&format!(" id=\"{id}\">")).unwrap() + id.len() + 7;
    &page[start..start + page[start..].find("</script>").unwrap()]
}

fn unpacked(page: &str, id: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    DeflateDecoder::new(&*STANDARD.decode(content(page, id)).unwrap()).read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let (page, _) = page();
    // The namespace of SVG is not an address that is requested.
    let page = page.replace("\"http://www.w3.org/2000/svg\"", "");
    for word in ["http:", "https:", "src=", "@import", "url(", "fetch(", "XMLHttpRequest", "import(", "file:"] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'"), "the browser is told so, too");
}

#[test]
fn names_and_texts_stay_texts() {
    let (page, _) = page();
    assert_eq!(
        page.matches("alert(1)").count(),
        page.matches("\\u003cscript>alert(1)").count() + page.matches("&lt;script&gt;alert(1)").count()
    );
    let data: Value = serde_json::from_str(content(&page, "data")).unwrap();
    for text in [&data["name"], &data["outcome"], &data["scripts"][0]["text"], &data["warnings"][0], &data["bodies"][0]["name"]] {
        assert_eq!(text, EVIL);
    }
    assert_eq!(page.matches("<script").count(), page.matches("</script>").count());
    assert!(!page.contains("innerHTML") && !page.contains("document.write"), "the program makes texts only");
}

#[test]
fn numbers_are_those_of_the_run_to_the_last_bit() {
    let (page, rows) = page();
    let numbers: Vec<f64> = unpacked(&page, "history").chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
    let names = Quantity::names(&LedgerRow::columns(2));
    assert_eq!(numbers.len(), names.len() * rows.len());
    for (values, name) in numbers.chunks(rows.len()).zip(names) {
        for (value, row) in values.iter().zip(&rows) {
            assert_eq!(value.to_bits(), row.column(name).unwrap().to_bits(), "{name}");
        }
    }
}

#[test]
fn stills_are_the_motion_to_the_last_of_65535_parts() {
    let (page, rows) = page();
    let data: Value = serde_json::from_str(content(&page, "data")).unwrap();
    let stills = data["stills"].as_array().unwrap();
    let kept: Vec<f64> = stills.iter().map(|still| still["time"].as_f64().unwrap()).collect();
    let expected: Vec<f64> = [0, 4, 8].map(|row: usize| rows[row].time).to_vec();
    assert_eq!(kept, expected, "after nine steps every fourth is kept where four are allowed");
    assert_eq!(data["chunks"], serde_json::json!([3]));
    // The body falls as a whole: its displacement is -t^2/2 everywhere, exactly with the midpoint rule.
    let bytes = unpacked(&page, "stills-0");
    let (nodes, components) = (15, 8);
    let size = components * (8 + 2 * nodes) + 4;
    assert_eq!(bytes.len(), 3 * size);
    for (still, time) in bytes.chunks(size).zip(kept) {
        let number = |place: usize| f64::from(f32::from_le_bytes(still[4 * place..4 * place + 4].try_into().unwrap()));
        let fall = -0.5 * time * time;
        assert!((number(2) - fall).abs() <= 1e-6 * fall.abs() + 1e-9 && (number(3) - fall).abs() <= 1e-6 * fall.abs() + 1e-9);
        assert!((number(6) + time).abs() <= 1e-6, "velocity");
    }
}

#[test]
fn a_recording_goes_on_from_its_copy_to_the_same_page() {
    let model = model();
    let mut simulation = Simulation::new(&model, Options::new(&ENERGY_MOMENTUM, 0.1)).unwrap();
    let mut recording = Recording::new(&model, &four());
    recording.begin(&simulation, 0);
    let mut copy = None;
    for row in 1..=13 {
        simulation.step(None, &mut |_| ()).unwrap();
        recording.advanced(&simulation, row);
        let other: &mut Recording = copy.get_or_insert_with(|| recording.clone());
        if row > 1 {
            // Encoded and decoded at every step.
            *other = postcard::from_bytes(&postcard::to_stdvec(other).unwrap()).unwrap();
            other.advanced(&simulation, row);
        }
    }
    assert_eq!(copy.unwrap(), recording);
    assert!(recording.stills().len() <= 4);
    recording.keep(5);
    assert!(recording.stills().iter().all(|still| still.row < 5));
}
