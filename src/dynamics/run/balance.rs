//! Balance of forces at rest, evaluated for every connected component of nodes relative to its own forces.
//!
//! For a component with free rigid motions, the resultant and torque along these motions are compared with the sum of the loads, reactions
//! or contact forces on this component, then the force on each node with the largest of these forces. A stiff or heavy body elsewhere thus
//! conceals no imbalance. Damping does not count as a force.
//!
//! A rigid motion is `u = t + w x (q - c)/r` with the component's mass center `c` and radius `r`: all its components are lengths.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::bodies::{Elements, Space};
use crate::dynamics::model::definitions::Model;
use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::contact_pair::PairKind;
use crate::dynamics::parts::rigid_body::RigidBody;
use crate::dynamics::step::equations::Equations;
use crate::dynamics::step::iterate::Forces;
use crate::math::norms::largest_size;
use crate::math::tolerances;

/// Displacement relative to the model extent by which the resistance of force elements is tested; small, so that no spring reaches its rest
/// length.
const GLANCE: f64 = 0.01;

/// Least load assigned to a rigid body, relative to the largest load: links without loads of their own made the equations of a slider-crank
/// singular.
const MOVED_ALONG: f64 = 0.01;

/// Admissible displacement of a rigid body with joints in a step, relative to its extent: half a radian. With a full radian a chain of six
/// links finds no equilibrium.
const SWING: f64 = 0.5;

/// Number of rigid motions in space; in the plane there are three.
const MOTIONS: usize = 6;

/// Connected components of a model.
pub struct Balance {
    pub components: Vec<Component>,
}

/// A component of connected nodes.
pub struct Component {
    pub body: usize,
    nodes: Vec<usize>,
    /// Square of the frequency of the slowest elastic motion: wave speed over the extent of the component.
    pub frequency_squared: f64,
    /// Mass of a rigid body.
    rigid_mass: Option<f64>,
    modulus: f64,
    /// Largest modulus times the aspect ratio of the cells, for the round-off of forces: strain errors scale with the shortest edge, forces
    /// with the longest.
    stiffness: f64,
    extent: f64,
    /// Admissible displacement of a rigid body with joints in a step; infinite for others.
    pub turn_bound: f64,
    /// Largest distance from the axis of a body of revolution.
    radius: f64,
}

/// Unbalanced forces of a state.
pub struct Imbalance {
    /// Largest resultant or torque relative to its tolerance.
    pub of_sums: f64,
    /// Largest nodal force relative to its tolerance.
    pub of_nodes: f64,
    /// True if round-off can explain the whole imbalance.
    pub is_round_off: bool,
    /// True if no displacement exceeds round-off of the first ones, which explains the whole imbalance, and neither loads nor contacts act.
    pub is_returned: bool,
    pub components: Vec<UnbalancedForce>,
}

/// Unbalanced forces on a component.
pub struct UnbalancedForce {
    /// Largest of resultant, torque over radius and nodal forces, relative to the sum of the forces on the component.
    pub relative: f64,
    /// Displacement of the component's center by a step of unit damping, where supports leave it free.
    pub shift: [f64; 3],
    /// Largest displacement of a node by the rotation about the center in such a step.
    pub turn: f64,
}

impl Imbalance {
    /// Largest unbalanced force relative to its tolerance.
    pub fn excess(&self) -> f64 {
        self.of_sums.max(self.of_nodes)
    }
}

impl UnbalancedForce {
    /// Length of the shift.
    pub fn shift_size(&self) -> f64 {
        self.shift.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// True if both components have equal displacements within round-off.
    fn is_as(&self, other: &UnbalancedForce) -> bool {
        let apart: f64 = self.shift.iter().zip(&other.shift).map(|(a, b)| (a - b).powi(2)).sum();
        self.shift_size() > 0.0 && apart.sqrt() <= tolerances::ALIKE * self.shift_size()
    }
}

impl Component {
    /// Nodes of the component, including followers of a rigid body.
    fn whole<const D: usize>(&self, equations: &Equations<D>) -> Box<dyn Iterator<Item = usize> + '_> {
        if self.rigid_mass.is_some() { Box::new(equations.bodies[self.body].nodes.clone()) } else { Box::new(self.nodes.iter().copied()) }
    }

    /// Sum of the force magnitudes on the nodes of the component.
    fn load<const D: usize>(&self, forces: &Forces) -> f64 {
        let on_node = |&node: &usize| (node * D..(node + 1) * D).map(|k| forces.without_contact[k].abs().max(forces.contact[k].abs()));
        self.nodes.iter().flat_map(on_node).sum()
    }

    /// Least damping that keeps the rigid motions of the component regular: a small fraction of its stiffness; for a rigid body a fraction
    /// of its load, at least `MOVED_ALONG` of the `largest` load, because the accuracy of its constraint forces depends on the damping.
    pub fn least_damping<const D: usize>(&self, forces: &Forces, largest: f64) -> f64 {
        let Some(mass) = self.rigid_mass else { return tolerances::LEAST_DAMPING * self.frequency_squared };
        let load = self.load::<D>(forces).max(MOVED_ALONG * largest);
        (tolerances::RIGID_DAMPING * load / (mass * self.extent)).max(tolerances::LEAST_DAMPING * self.frequency_squared)
    }
}

impl Balance {
    pub fn new<const D: usize>(equations: &Equations<D>, model: &Model) -> Self {
        let mut components: Vec<Component> = Vec::new();
        for (body, definition) in model.bodies.iter().enumerate() {
            let first = components.len();
            let aspect = definition.mesh.quality().aspect_ratio.max(1.0);
            let mut numbers: Vec<u32> = Vec::new();
            // Followers of a rigid body are fixed in a step, but not by supports.
            let followers: BTreeSet<usize> = equations.bodies[body].rigid.iter().flat_map(RigidBody::followers).collect();
            for node in equations.bodies[body].nodes.clone().filter(|node| !followers.contains(node)) {
                let number = equations.nodes.component_of[node];
                let place = numbers.iter().rposition(|&known| known == number).unwrap_or_else(|| {
                    numbers.push(number);
                    let modulus = model.modulus(body);
                    let own = if definition.rigid.is_some() { modulus } else { definition.material.stiffness() };
                    let stiffness = aspect * own;
                    let rigid_mass = definition.rigid.map(|inertia| inertia.mass);
                    let (frequency_squared, extent, turn_bound, radius) = (0.0, 0.0, f64::INFINITY, 0.0);
                    components.push(Component {
                        body,
                        nodes: Vec::new(),
                        frequency_squared,
                        rigid_mass,
                        modulus,
                        stiffness,
                        extent,
                        turn_bound,
                        radius,
                    });
                    numbers.len() - 1
                });
                components[first + place].nodes.push(node);
            }
            let is_jointed = definition.rigid.is_some() && model.joints.iter().any(|joint| joint.bodies().any(|joined| joined == body));
            for component in &mut components[first..] {
                component.extent = (0..D).map(|i| extent_along::<D>(&equations.nodes.reference, &component.nodes, i)).fold(0.0, f64::max);
                component.turn_bound = if is_jointed { SWING * component.extent } else { f64::INFINITY };
                component.radius = component.nodes.iter().map(|&node| equations.nodes.reference[node * D].abs()).fold(0.0, f64::max);
                component.frequency_squared = component.modulus / definition.material.density() / component.extent.powi(2);
            }
        }
        Balance { components }
    }

    /// Largest load of a rigid body.
    pub fn largest_load<const D: usize>(&self, forces: &Forces) -> f64 {
        self.components.iter().filter(|component| component.rigid_mass.is_some()).map(|one| one.load::<D>(forces)).fold(0.0, f64::max)
    }

    /// Imbalance of the forces of an iterate at rest, without damping; displacements up to `returned` are round-off `[length]`.
    pub fn judge<const D: usize>(&self, equations: &Equations<D>, Pose { q, u }: Pose, forces: &Forces, returned: f64) -> Imbalance
    where
        Space<D>: Elements<D>,
    {
        let is_returned = largest_size(u) <= returned;
        let mut imbalance = Imbalance { of_sums: 0.0, of_nodes: 0.0, is_round_off: true, is_returned, components: Vec::new() };
        let mut motions: Vec<RigidMotions<D>> =
            self.components.iter().map(|component| RigidMotions::new(equations, &component.nodes, q)).collect();
        self.weigh(equations, q, &mut motions);
        for (component, rigid) in self.components.iter().zip(&motions) {
            let (mut loads, mut reactions, mut contacts, mut largest_force) = (0.0, 0.0, 0.0, 0.0f64);
            // Squares of smaller strains are zero: displacements that return to zero need not be balanced beyond.
            let least = f64::MIN_POSITIVE.sqrt() * component.extent;
            let (mut largest, mut reach) = (0.0f64, if equations.depends_on_positions() { component.extent } else { least });
            let mut along = SVector::zeros();
            for &node in &component.nodes {
                for i in 0..D {
                    let k = node * D + i;
                    let force = forces.whole(forces.contact[k] - forces.without_contact[k]);
                    reach = reach.max(u[k].abs()).max(if equations.depends_on_positions() { q[k].abs() } else { 0.0 });
                    let (load, contact) =
                        (forces.whole(forces.load[k].abs()) + equations.nodes.weight[k].abs(), forces.whole(forces.contact[k].abs()));
                    loads += load;
                    contacts += contact;
                    largest_force = largest_force.max(load).max(contact);
                    if equations.supports.fixed[k] {
                        reactions += force.abs();
                        largest_force = largest_force.max(force.abs());
                    } else {
                        largest = largest.max(force.abs());
                        along += rigid.row(q, node, i) * force;
                    }
                }
            }
            let (pushes, motion) = rigid.respond(&along);
            let scale = f64::max(loads, reactions).max(contacts);
            // Axisymmetric forces are those of the whole circumference.
            let around = if equations.nodes.is_axisymmetric { std::f64::consts::TAU * component.radius } else { 1.0 };
            let stiffness = component.stiffness * component.extent.powi(D as i32 - 2) * around;
            let floor = tolerances::FORCE_FLOOR * stiffness * reach;
            imbalance.is_returned &= loads == 0.0 && contacts == 0.0 && largest <= stiffness * returned;
            let (target_of_sums, target) = (tolerances::BALANCE * scale, tolerances::BALANCE * largest_force);
            imbalance.of_sums = imbalance.of_sums.max(pushes / target_of_sums.max(f64::MIN_POSITIVE));
            imbalance.of_nodes = imbalance.of_nodes.max(largest / target.max(f64::MIN_POSITIVE));
            imbalance.is_round_off &= pushes <= target_of_sums.max(floor) && largest <= target.max(floor);
            let relative = if scale > 0.0 { pushes.max(largest) / scale } else { 0.0 };
            let mut shift = [0.0; 3];
            shift[..D].copy_from_slice(&motion.as_slice()[..D]);
            imbalance.components.push(UnbalancedForce { relative, shift, turn: motion.rows(D, motion.len() - D).norm() });
        }
        imbalance
    }

    /// Sets the mass matrix `R^T M R` of rigid motions from the consistent mass: row sums at the masters of a rigid body would have other
    /// moments of inertia, possibly zero or negative.
    fn weigh<const D: usize>(&self, equations: &Equations<D>, q: &[f64], motions: &mut [RigidMotions<D>]) {
        let count = D * (D + 1) / 2;
        let mut masses = vec![DMatrix::zeros(count, count); motions.len()];
        let mut moved = vec![0.0; q.len()];
        for m in 0..count {
            for (component, rigid) in self.components.iter().zip(&*motions) {
                for (node, i) in component.nodes.iter().flat_map(|&node| (0..D).map(move |i| (node, i))) {
                    moved[node * D + i] = rigid.row(q, node, i)[m];
                }
            }
            let momenta = equations.nodes.momenta_of(&moved);
            for ((component, rigid), mass) in self.components.iter().zip(&*motions).zip(&mut masses) {
                for (node, i) in component.nodes.iter().flat_map(|&node| (0..D).map(move |i| (node, i))) {
                    let row = rigid.row(q, node, i);
                    (0..count).for_each(|k| mass[(k, m)] += row[k] * momenta[node * D + i]);
                }
            }
        }
        for (rigid, mass) in motions.iter_mut().zip(masses) {
            rigid.mass = rigid.free.transpose() * mass * &rigid.free;
        }
    }

    /// True if a force element that stores energy, such as a spring, resists or drives a component that moves along its unbalanced forces.
    /// Such a component follows its forces in small steps, because a large step goes past the balance, and a compressed spring would
    /// reverse.
    pub fn is_resisted<const D: usize>(
        &self,
        equations: &Equations<D>,
        memory: &[Vec<f64>],
        (number, pull): (usize, &UnbalancedForce),
        q: &[f64],
    ) -> bool
    where
        Space<D>: Elements<D>,
    {
        let size = pull.shift_size();
        if equations.own_parts == 0 || size == 0.0 {
            return false;
        }
        let mut moved = q.to_vec();
        for node in self.components[number].whole(equations) {
            (0..D).for_each(|i| moved[node * D + i] += GLANCE * equations.nodes.extent / size * pull.shift[i]);
        }
        let displacements =
            |q: &[f64]| -> Vec<f64> { q.iter().zip(&equations.nodes.reference).map(|(q, reference)| q - reference).collect() };
        let (u, moved_u) = (displacements(q), displacements(&moved));
        equations.own_parts(memory).any(|(part, memory)| {
            let [before, after] = [(q, &u), (&moved[..], &moved_u)].map(|(q, u)| part.energy(Pose { q, u }, memory));
            (after - before).abs() > tolerances::ALIKE * before.abs().max(after.abs())
        })
    }

    /// Admissible displacement of each component: a share of the least distance from possible contact partners `[length]`, infinite without
    /// partners. Components with equal unbalanced displacements fall together and do not approach each other.
    pub fn clearances<const D: usize>(&self, equations: &Equations<D>, q: &[f64], pulls: &[UnbalancedForce]) -> Vec<f64> {
        let mut component_of = vec![0; equations.nodes.nodal_mass.len()];
        for (number, component) in self.components.iter().enumerate() {
            component.whole(equations).for_each(|node| component_of[node] = number);
        }
        let mut clearances = vec![f64::INFINITY; self.components.len()];
        let mut together = Vec::new();
        for pair in equations.pairs.iter().filter(|pair| pair.corners.is_none()) {
            let secondary = boxes::<D>(pair.kernel.secondary().nodes(), &component_of, q);
            let primary = boxes::<D>(pair.kernel.primary().nodes(), &component_of, q);
            for (a, low_a, high_a) in &secondary {
                for (b, low_b, high_b) in primary.iter().filter(|(b, ..)| b != a) {
                    if pair.kind == PairKind::Surfaces && pulls[*a].is_as(&pulls[*b]) {
                        together.push((*a, *b));
                        continue;
                    }
                    let apart = (0..D).map(|i| (low_a[i] - high_b[i]).max(low_b[i] - high_a[i]).max(0.0).powi(2)).sum::<f64>().sqrt();
                    clearances[*a] = clearances[*a].min(0.5 * apart);
                    clearances[*b] = clearances[*b].min(0.5 * apart);
                }
            }
            if pair.kind == PairKind::Obstacle {
                // Gaps are integrated over the area of a node: division by this area gives distances.
                let distances = pair.kernel.gap(q).into_iter().zip(pair.kernel.weights()).map(|(gap, weight)| gap / weight);
                // The first constraint of a node measures the distance from the whole obstacle.
                let distances = distances.step_by(pair.kernel.rows_per_node());
                for (distance, &node) in distances.zip(pair.kernel.secondary().nodes()) {
                    let clearance = &mut clearances[component_of[node as usize]];
                    *clearance = clearance.min(0.5 * distance.max(0.0));
                }
            }
        }
        // Components that fall together, directly or through neighbors, get the least clearance of them.
        let mut is_done = false;
        while !is_done {
            is_done = true;
            for &(a, b) in &together {
                let least = clearances[a].min(clearances[b]);
                is_done &= clearances[a] == least && clearances[b] == least;
                (clearances[a], clearances[b]) = (least, least);
            }
        }
        clearances
    }

    /// Adds the displacement of each component to its free nodes.
    pub fn shift<const D: usize>(&self, equations: &Equations<D>, by: &[[f64; 3]], q: &mut [f64]) {
        for (component, by) in self.components.iter().zip(by) {
            for k in component.nodes.iter().flat_map(|&node| node * D..(node + 1) * D).filter(|&k| !equations.supports.fixed[k]) {
                q[k] += by[k % D];
            }
        }
    }

    /// Returns the value of its component for every node.
    pub fn spread(&self, values: &[f64], nodes: usize) -> Vec<f64> {
        let mut of_node = vec![0.0; nodes];
        for (component, value) in self.components.iter().zip(values) {
            component.nodes.iter().for_each(|&node| of_node[node] = *value);
        }
        of_node
    }

    /// Largest displacement of a node of each component.
    pub fn motions<const D: usize>(&self, motion: &[f64]) -> Vec<f64> {
        let of_node = |node: &usize| motion[node * D..(node + 1) * D].iter().map(|x| x * x).sum::<f64>();
        self.components.iter().map(|component| component.nodes.iter().map(of_node).fold(0.0, f64::max).sqrt()).collect()
    }
}

/// Rigid motions of a component: translations, then rotations divided by its radius.
struct RigidMotions<const D: usize> {
    center: [f64; D],
    radius: f64,
    /// Basis of the rigid motions admitted by supports, in columns.
    free: DMatrix<f64>,
    /// Mass matrix of the rigid motions in the basis `free`.
    mass: DMatrix<f64>,
}

impl<const D: usize> RigidMotions<D> {
    fn new(equations: &Equations<D>, nodes: &[usize], q: &[f64]) -> Self {
        let mut rigid = RigidMotions { center: [0.0; D], radius: 0.0, free: DMatrix::zeros(0, 0), mass: DMatrix::zeros(0, 0) };
        let total: f64 = nodes.iter().map(|&node| equations.nodes.nodal_mass[node]).sum();
        for &node in nodes {
            (0..D).for_each(|i| rigid.center[i] += equations.nodes.nodal_mass[node] / total * q[node * D + i]);
        }
        let far = |node: &usize| (0..D).map(|i| (q[node * D + i] - rigid.center[i]).powi(2)).sum::<f64>();
        rigid.radius = nodes.iter().map(far).fold(0.0, f64::max).sqrt();
        let mut held = SMatrix::<f64, MOTIONS, MOTIONS>::zeros();
        for &node in nodes {
            for i in 0..D {
                if equations.supports.fixed[node * D + i] {
                    let row = rigid.row(q, node, i);
                    held += row * row.transpose();
                }
            }
        }
        if equations.nodes.is_axisymmetric {
            // Bodies of revolution only move along their axis without strain.
            let all = nodes.len() as f64;
            (held[(0, 0)], held[(2, 2)]) = (held[(0, 0)] + all, held[(2, 2)] + all);
        }
        let largest = held.trace();
        // In the plane, its three rigid motions only.
        let count = D * (D + 1) / 2;
        let eigen = DMatrix::from(held.view((0, 0), (count, count))).symmetric_eigen();
        let loose: Vec<_> = (0..count).filter(|&m| eigen.eigenvalues[m] <= tolerances::HELD * largest).collect();
        rigid.free = eigen.eigenvectors.select_columns(&loose);
        rigid
    }

    /// Displacements of component `i` of a node by each rigid motion.
    fn row(&self, q: &[f64], node: usize, i: usize) -> SVector<f64, MOTIONS> {
        let arm: [f64; D] = std::array::from_fn(|j| (q[node * D + j] - self.center[j]) / self.radius);
        let mut row = SVector::zeros();
        row[i] = 1.0;
        if D == 2 {
            row[2] = if i == 0 { -arm[1] } else { arm[0] };
        } else {
            // w x arm
            row[D + (i + 1) % 3] = arm[(i + 2) % 3];
            row[D + (i + 2) % 3] = -arm[(i + 1) % 3];
        }
        row
    }

    /// Norm of forces along the free motions, and the displacement by these forces in a step of unit damping.
    fn respond(&self, along: &SVector<f64, MOTIONS>) -> (f64, DVector<f64>) {
        let forces = self.free.transpose() * along.rows(0, self.free.nrows());
        let motion = self.mass.clone().cholesky().map_or_else(|| forces.clone(), |mass| mass.solve(&forces));
        (forces.amax(), &self.free * motion)
    }
}

/// Extent of some nodes along an axis.
fn extent_along<const D: usize>(q: &[f64], nodes: &[usize], i: usize) -> f64 {
    let coordinates = || nodes.iter().map(|node| q[node * D + i]);
    coordinates().fold(f64::NEG_INFINITY, f64::max) - coordinates().fold(f64::INFINITY, f64::min)
}

/// Boxes around the nodes of each component among some nodes.
fn boxes<const D: usize>(nodes: &[u32], component_of: &[usize], q: &[f64]) -> Vec<(usize, [f64; D], [f64; D])> {
    let mut boxes: Vec<(usize, [f64; D], [f64; D])> = Vec::new();
    for node in nodes.iter().map(|&node| node as usize) {
        let x: [f64; D] = std::array::from_fn(|i| q[node * D + i]);
        match boxes.iter_mut().rfind(|(component, ..)| *component == component_of[node]) {
            Some((_, low, high)) => {
                (0..D).for_each(|i| (low[i], high[i]) = (low[i].min(x[i]), high[i].max(x[i])));
            }
            None => boxes.push((component_of[node], x, x)),
        }
    }
    boxes
}
