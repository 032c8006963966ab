//! Unpaired bodies: without an interaction between them they pass through each other. Penetration is detected in the plane and in space, a
//! future collision in the plane only.

use std::sync::Arc;

use super::definitions::Model;
use super::hulls::{BodyHull, Hull, MutualPenetration};
use crate::mesh::Mesh;

/// Names of two bodies.
pub type Names = [String; 2];

/// Pairs of bodies of a model without an interaction between them.
pub struct UnpairedBodies {
    /// Name, first node number and mesh of each body.
    bodies: Vec<(String, usize, Arc<Mesh>)>,
    pairs: Vec<[usize; 2]>,
}

impl UnpairedBodies {
    /// All pairs of bodies of a model without an interaction or a joint.
    pub fn of(model: &Model) -> UnpairedBodies {
        let mut pairs = Vec::new();
        for first in 0..model.bodies.len() {
            let others = first + 1..model.bodies.len();
            let is_unpaired = |&second: &usize| model.between(first, second).is_none() && !model.are_joined(first, second);
            pairs.extend(others.filter(is_unpaired).map(|second| [first, second]));
        }
        let mut first = 0;
        let mut bodies = Vec::new();
        for body in &model.bodies {
            bodies.push((body.name.clone(), first, body.mesh.clone()));
            first += body.mesh.points.len();
        }
        UnpairedBodies { bodies, pairs }
    }

    /// Unpaired bodies that penetrate each other at node positions `q`, with the deepest point of each pair.
    pub fn inside(&self, q: &[f64]) -> Vec<(Names, MutualPenetration)> {
        let hull = |index: usize| {
            let (_, first, mesh) = &self.bodies[index];
            let dimension = mesh.dimension();
            BodyHull::new(index, mesh, &q[dimension * first..dimension * (first + mesh.points.len())])
        };
        let is_one = |index: usize| self.pairs.iter().flatten().any(|&other| other == index);
        let hulls: Vec<Option<BodyHull>> = (0..self.bodies.len()).map(|index| is_one(index).then(|| hull(index))).collect();
        let inside = |&pair: &[usize; 2]| {
            let [Some(first), Some(second)] = pair.map(|index| hulls[index].as_ref()) else { return None };
            Some((pair.map(|index| self.bodies[index].0.clone()), first.inside(second)?))
        };
        self.pairs.iter().filter_map(inside).collect()
    }
}

impl Model {
    /// Unpaired bodies of which the first moves straight towards the second: by its initial velocity, or by gravity if it has none and only
    /// the second is supported; empty in space. The bodies meet only if the run is long enough.
    pub fn meetings(&self) -> Vec<Names> {
        let unpaired = UnpairedBodies::of(self);
        let mut met: Vec<[usize; 2]> = Vec::new();
        if unpaired.pairs.is_empty() || self.dimension() != 2 {
            return Vec::new();
        }
        let hulls: Vec<Hull> = (0..self.bodies.len()).map(|body| self.hull(body)).collect();
        for moving in 0..self.bodies.len() {
            for (other, ray) in (0..self.bodies.len()).filter_map(|other| Some((other, self.approach(moving, other)?))) {
                let is_known = met.iter().any(|pair| pair.contains(&moving) && pair.contains(&other));
                if is_known || self.between(moving, other).is_some() {
                    continue;
                }
                // The first hull along the ray of a node counts: bodies behind another one are not met.
                let meets = hulls[moving].facets.iter().any(|[x, _]| {
                    let ahead = |hull: &Hull| Some((hull.passed(*x, ray)?, hull.body));
                    hulls
                        .iter()
                        .filter_map(ahead)
                        .filter(|(part, body)| *body != moving || *part > 0.0)
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                        .is_some_and(|(_, body)| body == other)
                });
                if meets {
                    met.push([moving, other]);
                }
            }
        }
        met.into_iter().map(|pair| pair.map(|index| self.bodies[index].name.clone())).collect()
    }

    /// Direction in which a body approaches another one at the start; `None` without approach.
    fn approach(&self, moving: usize, other: usize) -> Option<[f64; 2]> {
        let is_guided = self.joints.iter().any(|joint| joint.bodies().any(|body| body == moving));
        if moving == other || is_guided || self.is_held(moving) {
            return None;
        }
        let velocity =
            |body: usize| self.initial_velocities.iter().rfind(|thrown| thrown.body == body).map_or([0.0; 3], |thrown| thrown.linear);
        let (own, others) = (velocity(moving), velocity(other));
        let relative = [own[0] - others[0], own[1] - others[1]];
        let direction = match (relative == [0.0; 2], self.is_held(other)) {
            (false, _) => relative,
            (true, true) => [self.gravity[0], self.gravity[1]],
            (true, false) => return None,
        };
        (direction != [0.0; 2]).then_some(direction)
    }

    fn is_held(&self, body: usize) -> bool {
        self.supports.iter().any(|support| support.on.body == body) || self.prescriptions.iter().any(|given| given.on.body == body)
    }
}

#[cfg(test)]
mod tests {
    use super::super::definitions::{BodyDefinition, InitialVelocity, Support};
    use super::super::interactions::{BodyBoundary, Interaction};
    use super::*;
    use crate::materials::NeoHookean;
    use crate::mesh::{block, rectangle};

    /// A table, a cube 0.5 above it, and a cube beside that one.
    fn scene() -> Model {
        let rubber = NeoHookean { youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 }.material().expect("in range");
        let mut model = Model::default();
        for (name, size, at) in [("table", [6.0, 1.0], [0.0, -1.0]), ("cube", [1.0, 1.0], [1.0, 0.5]), ("die", [1.0, 1.0], [4.0, 0.5])] {
            let mesh = Arc::new(rectangle(size, [3, 2], at).expect("the mesh is sound"));
            model.bodies.push(BodyDefinition {
                name: name.into(),
                mesh,
                material: rubber.clone(),
                formulation: Default::default(),
                rigid: None,
            });
        }
        model.supports.push(Support { on: boundary(&model, 0, "bottom"), components: [true; 3] });
        model
    }

    fn boundary(model: &Model, body: usize, name: &str) -> BodyBoundary {
        BodyBoundary { body, boundary: model.bodies[body].mesh.boundary(name).expect("the mesh has it").clone() }
    }

    fn names(pairs: &[[&str; 2]]) -> Vec<Names> {
        pairs.iter().map(|pair| pair.map(str::to_string)).collect()
    }

    #[test]
    fn what_falls_or_flies_towards_a_stranger_is_told() {
        let mut model = scene();
        assert_eq!(model.meetings(), names(&[]));
        model.gravity = [0.0, -1.0, 0.0];
        assert_eq!(model.meetings(), names(&[["cube", "table"], ["die", "table"]]));
        model.interactions.push(Interaction::contact("floor", boundary(&model, 1, "bottom"), boundary(&model, 0, "top")));
        assert_eq!(model.meetings(), names(&[["die", "table"]]));
        model.gravity = [0.0; 3];
        let throw = |body, x| InitialVelocity { body, linear: [x, 0.0, 0.0], angular: [0.0; 3] };
        model.initial_velocities = vec![throw(1, 2.0)];
        assert_eq!(model.meetings(), names(&[["cube", "die"]]));
        model.initial_velocities = vec![throw(1, -2.0), throw(2, 2.0)];
        assert_eq!(model.meetings(), names(&[]), "they part");
        // Bodies behind another body are not met.
        model.bodies[2].mesh = Arc::new(rectangle([1.0, 1.0], [2, 2], [1.0, 3.0]).expect("the mesh is sound"));
        model.initial_velocities.clear();
        model.gravity = [0.0, -1.0, 0.0];
        assert_eq!(model.meetings(), names(&[]), "the cube is below it, and nobody knows how it will fall");
    }

    #[test]
    fn strangers_are_found_where_they_are() {
        let model = scene();
        let unpaired = UnpairedBodies::of(&model);
        let mut q: Vec<f64> = model.bodies.iter().flat_map(|body| &body.mesh.points).flat_map(|point| [point[0], point[1]]).collect();
        assert!(unpaired.inside(&q).is_empty());
        let first = 2 * model.bodies[0].mesh.points.len();
        let end = first + 2 * model.bodies[1].mesh.points.len();
        q[first..end].iter_mut().skip(1).step_by(2).for_each(|y| *y -= 0.75);
        let found = unpaired.inside(&q);
        assert!(found.len() == 1 && found[0].0 == ["table", "cube"] && (found[0].1.depth - 0.25).abs() < 1e-12);
    }

    #[test]
    fn strangers_in_space_are_found_and_not_foretold() {
        let mut model = scene();
        for (body, height) in model.bodies.iter_mut().zip([-1.0, -0.25, 4.0]) {
            body.mesh = Arc::new(block([1.0; 3], [2; 3], [0.1, 0.2, height]).expect("the mesh is sound"));
        }
        model.gravity = [0.0, 0.0, -1.0];
        assert_eq!(model.meetings(), names(&[]));
        let q: Vec<f64> = model.bodies.iter().flat_map(|body| body.mesh.points.concat()).collect();
        let found = UnpairedBodies::of(&model).inside(&q);
        assert!(found.len() == 1 && found[0].0 == ["table", "cube"] && (found[0].1.depth - 0.25).abs() < 1e-12);
    }
}
