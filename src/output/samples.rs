//! Bodies and directories for the tests of this floor.

use std::collections::HashMap;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::RunFiles;
use crate::dynamics::{BodyFields, LedgerRow};
use crate::mesh::{self, Mesh};

/// Temporary directory that is removed at the end of a test.
pub(super) struct Scratch(PathBuf);

impl Deref for Scratch {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// An empty directory of this test alone.
pub(super) fn scratch(test: &str) -> (Scratch, RunFiles) {
    let directory = Scratch(std::env::temp_dir().join(format!("conserva output {} {test}", std::process::id())));
    let _ = std::fs::remove_dir_all(&*directory);
    let files = RunFiles::create(&*directory).expect("the system's directory for temporary files can be written to");
    (directory, files)
}

fn body(name: &str, mesh: Mesh, displacement: impl Fn([f64; 3]) -> [f64; 3], stress: impl Fn([f64; 3]) -> [f64; 6]) -> BodyFields {
    let points = &mesh.points;
    BodyFields {
        name: name.into(),
        displacement: points.iter().map(|&x| displacement(x)).collect(),
        velocity: points.iter().map(|&[x, y, _]| [-y, x, 0.0]).collect(),
        acceleration: vec![[0.0; 3]; points.len()],
        stress: points.iter().map(|&x| stress(x)).collect(),
        strain: vec![[0.0; 6]; points.len()],
        stress_error: vec![0.0; points.len()],
        is_rigid: false,
        flows: false,
        plastic_strain: vec![0.0; points.len()],
        back_stress: vec![0.0; points.len()],
        energy_density: vec![0.0; points.len()],
        contact_pressure: points.iter().map(|x| x[0].max(0.0)).collect(),
        contact_force: points.iter().map(|x| [0.0, x[0].min(0.0), 0.0]).collect(),
        contact_pressing: points.iter().map(|x| [0.0, x[0].min(0.0), 0.0]).collect(),
        contact_active: points.iter().map(|x| f64::from(u8::from(x[0] > 0.0))).collect(),
        contact_state: points.iter().map(|x| f64::from(u8::from(x[0] > 0.0) * 2)).collect(),
        contact_slip: points.iter().map(|x| f64::from(u8::from(x[0] > 0.0) * (1 + u8::from(x[1] > 0.0)))).collect(),
        contact_gap: points.iter().map(|x| if x[0] > 0.0 { 0.0 } else { f64::NAN }).collect(),
        mesh: Arc::new(mesh),
    }
}

/// A ring around the origin, `cells` radially and around, pressed in by `-0.02` and squeezed at two places.
pub(super) fn ring(name: &str, [inner, outer]: [f64; 2], cells: [usize; 2]) -> BodyFields {
    let mesh = mesh::ring(inner, outer, cells, [0.0, 0.0], 0.0).expect("a ring of cells");
    let polar = |[x, y, _]: [f64; 3]| (x.hypot(y), y.atan2(x));
    body(
        name,
        mesh,
        move |x| {
            let (r, phi) = polar(x);
            let u = 0.04 * outer * (2.0 * phi).cos();
            [u * x[0] / r, u * x[1] / r, 0.0]
        },
        move |x| {
            let (r, phi) = polar(x);
            let p = 1e3 * (outer / r).powi(2) * (1.0 + 0.7 * (2.0 * phi).cos() + 0.3 * (5.0 * phi).sin());
            [-p, 0.3 * p, -0.2 * p, 0.1 * p * phi.sin(), 0.0, 0.0]
        },
    )
}

/// A block of hexahedra, twisted about its long axis.
pub(super) fn block(cells: [usize; 3], size: [f64; 3]) -> BodyFields {
    let mesh = mesh::block(size, cells, [0.0; 3]).expect("a block of cells");
    let [a, b, c] = size;
    body(
        "block",
        mesh,
        move |[x, y, z]| {
            let angle = 0.8 * x / a;
            let (y0, z0) = (y - 0.5 * b, z - 0.5 * c);
            [0.0, angle.cos() * y0 - angle.sin() * z0 - y0, angle.sin() * y0 + angle.cos() * z0 - z0]
        },
        move |[x, y, z]| [x, 0.0, 0.0, 3.0 * (y - 0.5 * b), 2.0 * (z - 0.5 * c), 0.0],
    )
}

/// A run in which a torque acts until `t = 0.5` and the energy is constant afterwards.
pub(super) fn rows() -> Vec<LedgerRow> {
    (0..=400)
        .map(|step| {
            let time = step as f64 * 0.005;
            let spin = (time / 0.5).min(1.0).powi(2) * 0.03;
            let wave = 0.004 * (20.0 * time).sin() * (time / 0.5).min(1.0);
            LedgerRow {
                step,
                time,
                dt: if step == 0 { 0.0 } else { 0.005 },
                kinetic: spin + wave,
                strain: 0.02 - wave,
                angular_momentum: [0.0, 0.0, spin],
                newton_iterations: 4,
                active: 40,
                ..LedgerRow::default()
            }
        })
        .collect()
}

/// Checks that a text is well-formed XML without NaN or infinity; returns how often each tag occurs.
pub(super) fn well_formed(svg: &str) -> HashMap<String, usize> {
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "a number that is none");
    let mut open = Vec::new();
    let mut counts = HashMap::new();
    for part in svg.split('<').skip(1) {
        let (tag, text) = part.split_once('>').expect("a tag that ends");
        assert!(!text.contains('>'), "an unescaped > in {text}");
        let name = tag.split_whitespace().next().unwrap_or_default().trim_matches('/').to_string();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        *counts.entry(name.clone()).or_default() += 1;
        if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty() && counts["svg"] == 1);
    counts
}
