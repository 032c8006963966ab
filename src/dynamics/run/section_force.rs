//! Force and moment that two parts of a body exert on each other across a section.
//!
//! A plane parts the undeformed cells by their centroids. The section consists of the facets between both parts, and its force is the sum
//! of the forces with which the cells in front of the plane act on the nodes of the section: those of their stresses, their weight and
//! their inertia. These are the forces of the equations of motion, so that they balance loads, reactions and inertia of either part; an
//! integral of smoothed stresses does not.

use std::collections::BTreeMap;

use super::engine::Engine;
use crate::bodies::{Elements, Space, nodal_areas};
use crate::dynamics::parts::nodal::{add_force, add_moment};
use crate::mesh::{Boundary, Facet, Mesh};

/// Force and moment of the material in front of a section on the material behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionForce {
    /// The force `[force]`, per thickness in the plane, of the whole circumference of a body of revolution.
    pub force: [f64; 3],
    /// The moment about the origin `[force * length]`; in the plane only the third component.
    pub moment: [f64; 3],
    /// The moment about the center `[force * length]`.
    pub moment_at_center: [f64; 3],
    /// Centroid of the section at its present position `[length]`.
    pub center: [f64; 3],
    /// Undeformed measure of the section `[length]`, in space and of a body of revolution its area.
    pub area: f64,
}

/// Facets of the cells in front of a plane that they share with cells behind it; `None` if all cells are on one side.
fn section(mesh: &Mesh, is_front: &[bool]) -> Option<Vec<Facet>> {
    let mut facets: BTreeMap<Vec<u32>, Facet> = BTreeMap::new();
    let mut found = Vec::new();
    for (cell, (kind, _)) in (0u32..).zip(mesh.cells_with_kinds()) {
        for local in 0..kind.facets().len() {
            let facet = Facet { cell, local: local as u8 };
            let mut nodes: Vec<u32> = mesh.facet_nodes(facet).collect();
            nodes.sort_unstable();
            let Some(other) = facets.remove(&nodes) else {
                facets.insert(nodes, facet);
                continue;
            };
            match [is_front[other.cell as usize], is_front[cell as usize]] {
                [true, false] => found.push(other),
                [false, true] => found.push(facet),
                _ => {}
            }
        }
    }
    (!found.is_empty()).then_some(found)
}

impl<const D: usize> Engine<D>
where
    Space<D>: Elements<D>,
{
    /// Force of the cells of a body whose undeformed centroids are in front of a plane on the others; `None` if all are on one side.
    pub fn section_force_of(&self, body: usize, point: [f64; 3], normal: [f64; 3]) -> Option<SectionForce> {
        let (definition, body) = (&self.model.bodies[body], &self.system.bodies[body]);
        let (mesh, first) = (&definition.mesh, body.nodes.start);
        let height = |node: u32| (0..3).map(|i| normal[i] * (mesh.points[node as usize][i] - point[i])).sum::<f64>();
        let is_front: Vec<bool> = mesh.cells().map(|cell| cell.iter().map(|&node| height(node)).sum::<f64>() > 0.0).collect();
        let facets = section(mesh, &is_front)?;
        let shares = nodal_areas(mesh, &Boundary::of_facets("", facets), definition.formulation.plane);
        let q = |node: usize| -> [f64; D] { std::array::from_fn(|i| self.state.positions[(first + node) * D + i]) };
        let mut section = SectionForce { area: shares.iter().map(|(_, share)| share).sum(), ..SectionForce::default() };
        let mut is_shared = vec![false; mesh.points.len()];
        for cell in mesh.cells().zip(&is_front).filter(|(_, is_front)| !**is_front).map(|(cell, _)| cell) {
            cell.iter().for_each(|&node| is_shared[node as usize] = true);
        }
        for &(node, share) in &shares {
            q(node as usize).iter().zip(&mut section.center).for_each(|(x, center)| *center += share / section.area * x);
        }
        let mut forces = vec![[0.0; D]; mesh.points.len()];
        let per_mass = |nodes: &[u32], shapes: &[f64]| -> [f64; 3] {
            let mut field = self.model.gravity;
            for (&node, shape) in nodes.iter().zip(shapes) {
                (0..D).for_each(|i| field[i] -= shape * self.state.accelerations[node as usize * D + i]);
            }
            field
        };
        body.elements.visit_forces(self.present(body), &per_mass, &mut |cell, of_cell| {
            if is_front[cell] {
                for (&node, force) in mesh.cell(cell).iter().zip(of_cell) {
                    // Opposite to the internal force, which is on the left side of the equations of motion.
                    (0..D).for_each(|i| forces[node as usize][i] -= force[i]);
                }
            }
        });
        for (node, force) in forces.iter().enumerate().filter(|(node, _)| is_shared[*node]) {
            let x = q(node);
            add_force(&mut section.force, force);
            add_moment(&mut section.moment, &x, force);
            add_moment(&mut section.moment_at_center, &std::array::from_fn::<f64, D, _>(|i| x[i] - section.center[i]), force);
        }
        Some(section)
    }
}
