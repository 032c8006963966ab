//! A hose pressed flat between two rigid planes until its inner wall touches itself.
//!
//! Exact laws: the work of the planes (booked as work of loads) equals the stored energy plus the energy dissipated by `gap`; the planes
//! are mirror images, so the transverse momentum stays zero. The inner wall does not penetrate itself: the height of the hose is at least
//! its two walls.

use std::sync::Arc;

use conserva::contact::{MORTAR, NODE_TO_SEGMENT, Obstacle};
use conserva::dynamics::{Interaction, Partner, Ramp};
use conserva::integrators::ENERGY_MOMENTUM;
use conserva::materials::NeoHookean;
use conserva::mesh::ring;

use crate::common::{Builder, run, worst};

#[test]
fn the_inner_wall_touches_itself_and_the_ledger_closes() {
    for method in [&MORTAR, &NODE_TO_SEGMENT] {
        let mut builder = Builder::default();
        let mesh = ring(0.8, 1.0, [2, 48], [0.0; 2], 0.05).expect("the mesh is sound");
        let hose =
            builder.body("hose", mesh, &NeoHookean { youngs_modulus: 1e3, poisson_ratio: 0.3, density: 0.1 }.material().expect("in range"));
        for (name, side) in [("upper plane", 1.0), ("lower plane", -1.0)] {
            let outer = builder.boundary(hose, "outer");
            let plane = Obstacle::HalfPlane { point: [0.0, 1.001 * side], normal: [0.0, -side] };
            let press = Ramp { start: 0.0, end: 1.0, value: -0.81 * side };
            let partner = Partner::Obstacle { shape: plane, motion: [None, Some(Arc::new(press)), None], turn: None };
            builder.model.add_interaction(Interaction::new(name, outer, partner));
        }
        let surface = builder.boundary(hose, "inner");
        builder.model.add_interaction(Interaction { method, ..Interaction::new("inner wall", surface, Partner::Itself) });
        let mut sim = builder.simulate(&ENERGY_MOMENTUM, 0.005);
        let rows = run(&mut sim, 1.0);
        let last = &rows[rows.len() - 1];
        let work: f64 = rows[1..].iter().map(|row| row.load_work).sum();
        let booked: f64 = rows[1..].iter().map(|row| row.contact_work).sum();
        let wall = sim.contact("inner wall").expect("it is there");
        let touching = wall.active.iter().filter(|active| **active).count();
        println!(
            "{method:?}: work {work:.4}, stored {:.4}, lost {:.2e}, {touching} nodes of the inner wall, \
             {} iterations, {} halvings in {} steps, defect {:.1e}",
            last.total(),
            -booked,
            rows[1..].iter().map(|row| row.newton_iterations).sum::<usize>(),
            rows[1..].iter().map(|row| row.halvings).sum::<usize>(),
            rows.len() - 1,
            worst(&rows, |row| row.energy_defect)
        );
        assert!(touching > 0, "{method:?}");
        assert!(worst(&rows, |row| row.energy_defect) < 1e-11 * last.total(), "{:.1e}", worst(&rows, |row| row.energy_defect));
        assert!((last.total() - work - booked).abs() < 1e-9 * last.total(), "{} {work} {booked}", last.total());
        assert!(worst(&rows, |row| row.momentum_defect) < 1e-11 && worst(&rows, |row| row.angular_momentum_defect) < 1e-11);
        // The upper half of the inner wall stays above the lower one. The mesh is not symmetric, so the line of contact is slightly off the
        // middle, but far less than the thickness of 0.2 that a penetration would cause.
        assert!(worst(&rows, |row| row.max_penetration) < 0.01, "{method:?}: {}", worst(&rows, |row| row.max_penetration));
        let inner = sim.fields().remove(0);
        let low =
            (0..48).filter(|&node| inner.mesh.points[node][1] > 0.3).map(|node| inner.position(node)[1]).fold(f64::INFINITY, f64::min);
        assert!(low > -0.02, "{method:?}: {low}");
    }
}
