//! Reduction of a failing scene that keeps the kind of its failure.

use super::run::{Fault, run};
use super::{Scene, Shape};

/// Smallest scene found with a fault, by removing parts one by one.
///
/// The reduced scene is about as bad as the original: at least half the penetration, a hundredth of the gained or lost energy, so that the
/// reduction does not end at a scene that only just exceeds the limit. The scene ends with its worst step.
pub fn shrink(scene: &Scene, fault: Fault, told: &mut dyn FnMut(&str)) -> Scene {
    let worst = |scene: &Scene| run(scene, &mut |_| ()).findings.into_iter().find(|finding| finding.fault == fault);
    let Some(original) = worst(scene) else { return scene.clone() };
    let enough = original.worst * if fault == Fault::Deep { 0.5 } else { 0.01 };
    let still = |candidate: &Scene| worst(candidate).filter(|finding| fault == Fault::Failed || finding.worst >= enough);
    let mut smallest = Scene { steps: original.worst_step.max(1), ..scene.clone() };
    loop {
        let tried = candidates(&smallest).into_iter().find_map(|(what, candidate)| {
            let sound = moves(&candidate) && candidate.is_free_of_overlap();
            let finding = if sound { still(&candidate) } else { None };
            finding.map(|finding| (what, Scene { steps: finding.worst_step.max(1), ..candidate }))
        });
        let Some((what, candidate)) = tried else { return smallest };
        told(&what);
        smallest = candidate;
    }
}

/// True if a body of the scene moves.
fn moves(scene: &Scene) -> bool {
    scene.gravity_size() > 0.0 || scene.bodies.iter().any(|body| body.velocity != [0.0; 2] || body.spin != 0.0)
}

/// Scenes with one part removed.
fn candidates(scene: &Scene) -> Vec<(String, Scene)> {
    let mut candidates: Vec<(String, Scene)> = Vec::new();
    let mut offer = |what: String, change: &dyn Fn(&mut Scene)| {
        let mut candidate = scene.clone();
        change(&mut candidate);
        if candidate != *scene {
            candidates.push((what, candidate));
        }
    };
    if scene.bodies.len() > 1 {
        for k in 0..scene.bodies.len() {
            offer(format!("without body {k}"), &|scene| drop(scene.bodies.remove(k)));
        }
    }
    for k in 0..scene.walls.len() {
        offer(format!("without wall {k}"), &|scene| drop(scene.walls.remove(k)));
    }
    offer("without gravity".into(), &|scene| scene.gravity = [0.0; 2]);
    for k in 0..scene.bodies.len() {
        offer(format!("without spin of body {k}"), &|scene| scene.bodies[k].spin = 0.0);
        offer(format!("body {k} at rest"), &|scene| scene.bodies[k].velocity = [0.0; 2]);
        offer(format!("coarser body {k}"), &|scene| coarsen(&mut scene.bodies[k].shape));
        offer(format!("body {k} of the common law"), &|scene| scene.bodies[k].law = "neo_hookean");
    }
    candidates
}

/// Reduces the number of cells of a shape.
fn coarsen(shape: &mut Shape) {
    match shape {
        Shape::Rectangle { cells, .. } => *cells = cells.map(|count| count.div_ceil(2)),
        Shape::Disk { cells, .. } => *cells = [cells[0].div_ceil(2), (cells[1] / 8 * 4).max(8)],
        Shape::Ring { cells, .. } => *cells = [cells[0].div_ceil(2), (cells[1] / 2).max(8)],
        Shape::Polygon { corners, size } => {
            let reach = corners.iter().map(|corner| corner[0].hypot(corner[1])).fold(0.0, f64::max);
            *size = (1.5 * *size).min(reach);
        }
    }
}
