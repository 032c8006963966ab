//! Nodal fields of a body at one time, for pictures, files and scripts.

use std::sync::Arc;

use crate::contact::{Obstacle, ObstaclePlacement};
use crate::dynamics::model::joints::Coordinate;
use crate::mesh::Mesh;

/// Nodal fields of one body; every vector has one entry per node of its mesh.
#[derive(Clone, Debug)]
pub struct BodyFields {
    /// Name of the body.
    pub name: String,
    /// Undeformed mesh of the body.
    pub mesh: Arc<Mesh>,
    /// Displacement `[length]`.
    pub displacement: Vec<[f64; 3]>,
    /// Velocity `[length/time]`.
    pub velocity: Vec<[f64; 3]>,
    /// Acceleration `[length/time^2]`: change of the velocity in the last step divided by the step size, 0 at rest.
    pub acceleration: Vec<[f64; 3]>,
    /// Cauchy stress xx, yy, zz, xy, yz, xz `[stress]`, as [`Stresses::at_nodes`](crate::bodies::Stresses::at_nodes) gives it.
    pub stress: Vec<[f64; 6]>,
    /// Green-Lagrange strain xx, yy, zz, xy, yz, xz, recovered at nodes as the stress.
    pub strain: Vec<[f64; 6]>,
    /// Estimated error of the stresses around a node `[stress]`: root mean square of the difference between cell stresses and the
    /// continuous nodal stress (Zienkiewicz and Zhu 1987).
    pub stress_error: Vec<f64>,
    /// True for a rigid body, which has no stresses and strains.
    pub is_rigid: bool,
    /// True for a deformable body whose material flows plastically.
    pub flows: bool,
    /// Equivalent plastic strain, recovered at nodes like the stress and never negative; 0 for materials without plasticity.
    pub plastic_strain: Vec<f64>,
    /// Von Mises' norm of the back stress, recovered at nodes like the stress `[stress]`.
    pub back_stress: Vec<f64>,
    /// Strain energy density per undeformed volume, recovered as the stresses are and never below 0 `[energy/volume]`.
    pub energy_density: Vec<f64>,
    /// Contact pressure `[stress]`: the multiplier of a secondary node, 0 elsewhere.
    pub contact_pressure: Vec<f64>,
    /// Contact gap `[length]`: weighted gap divided by the covered weight of a secondary node; NaN without an opposite facet.
    pub contact_gap: Vec<f64>,
    /// Contact force `[force]` on the nodes of both sides of all contacts, including friction, without ties.
    pub contact_force: Vec<[f64; 3]>,
    /// Contact force `[force]` on the nodes of both sides of all contacts, without friction and ties.
    pub contact_pressing: Vec<[f64; 3]>,
    /// 1 at a secondary node in contact, 0 elsewhere.
    pub contact_active: Vec<f64>,
    /// Contact state of a secondary node, as in [`NodeState`]: 1 stick, 2 slip or contact without friction, 0 elsewhere.
    pub contact_state: Vec<f64>,
    /// 1 at a sticking secondary node, 2 at a slipping one, 0 elsewhere.
    pub contact_slip: Vec<f64>,
}

impl BodyFields {
    /// Current position of a node `[length]`.
    pub fn position(&self, node: usize) -> [f64; 3] {
        let (x, u) = (self.mesh.points[node], self.displacement[node]);
        [x[0] + u[0], x[1] + u[1], x[2] + u[2]]
    }

    /// Stress, strain and history variables at a node.
    pub fn at(&self, node: usize) -> CellStress {
        CellStress {
            position: self.position(node),
            rest: self.mesh.points[node],
            stress: self.stress[node],
            strain: self.strain[node],
            plastic_strain: self.plastic_strain[node],
            back_stress: self.back_stress[node],
            energy: self.energy_density[node],
        }
    }

    /// Pressure at a node, a third of the negative trace of the stress `[stress]`.
    pub fn pressure(&self, node: usize) -> f64 {
        pressure(&self.stress[node])
    }

    /// Von Mises stress at a node `[stress]`.
    pub fn von_mises(&self, node: usize) -> f64 {
        von_mises(&self.stress[node])
    }
}

/// Pressure of a stress xx, yy, zz, xy, yz, xz, a third of its negative trace `[stress]`.
pub fn pressure([xx, yy, zz, ..]: &[f64; 6]) -> f64 {
    -(xx + yy + zz) / 3.0
}

/// Von Mises stress of a stress xx, yy, zz, xy, yz, xz `[stress]`.
pub fn von_mises([xx, yy, zz, xy, yz, xz]: &[f64; 6]) -> f64 {
    let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt()
}

/// Evaluation places of stresses and strains inside of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellPlaces {
    /// One volume-weighted mean for each cell, at its centroid.
    Cells,
    /// Each quadrature point, grouped by cell.
    Points,
}

/// Stress and strain at a place inside of a cell, or at a node.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellStress {
    /// Present position `[length]`.
    pub position: [f64; 3],
    /// Undeformed position `[length]`.
    pub rest: [f64; 3],
    /// Cauchy stress xx, yy, zz, xy, yz, xz `[stress]`.
    pub stress: [f64; 6],
    /// Green-Lagrange strain xx, yy, zz, xy, yz, xz.
    pub strain: [f64; 6],
    /// Equivalent plastic strain.
    pub plastic_strain: f64,
    /// Von Mises' norm of the back stress `[stress]`.
    pub back_stress: f64,
    /// Strain energy density per undeformed volume `[energy/volume]`.
    pub energy: f64,
}

/// Totals of one body at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyTotals {
    /// Mass `[mass]`.
    pub mass: f64,
    /// Kinetic energy `[energy]`.
    pub kinetic: f64,
    /// Strain energy `[energy]`.
    pub strain: f64,
    /// Potential energy of gravity, zero at the origin `[energy]`.
    pub potential: f64,
    /// Linear momentum `[mass * length/time]`.
    pub momentum: [f64; 3],
    /// Angular momentum about the origin; in the plane only the third component.
    pub angular_momentum: [f64; 3],
    /// Estimated error of the stresses relative to their size, as in [`BodyFields::stress_error`].
    pub stress_error: f64,
    /// Center of mass `[length]`.
    pub center: [f64; 3],
}

/// Rigid obstacle with its position at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedObstacle {
    /// Name of the contact; the names of all contacts if several share the obstacle.
    pub name: String,
    /// Shape of the obstacle at its initial place.
    pub shape: Obstacle,
    /// Rotation and translation of the obstacle.
    pub place: ObstaclePlacement,
}

/// Force and moment of a joint on its second body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// The force `[force]`.
    pub force: [f64; 3],
    /// The moment about the joint's point on that body `[force * length]`; in the plane the third component.
    pub moment: [f64; 3],
    /// Time of force and moment, which are means over the last step: its middle for schemes whose forces act there, else its end `[time]`.
    pub time: f64,
    /// Position of the joint's point on the second body `[length]`.
    pub place: [f64; 3],
    /// Free coordinate of the joint with its value; `None` if there is not exactly one.
    pub coordinate: Option<(Coordinate, f64)>,
    /// Work of the drive in the last step; `None` without a drive `[energy]`.
    pub work: Option<f64>,
    /// Friction in the last step; `None` for a joint without friction.
    pub friction: Option<JointFrictionLoad>,
}

/// Friction of a joint in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFrictionLoad {
    /// Friction along the coordinate on the second body, mean over the step: a force, or for an angle a moment; for a ball joint the size
    /// of the moment.
    pub force: f64,
    /// Work in the step, never positive `[energy]`.
    pub work: f64,
}

/// Redundant constraints of a tie or a joint, which depend on other constraints and on supports and are omitted.
#[derive(Clone, Debug, PartialEq)]
pub struct RedundantConstraints {
    /// Name of the tie or joint.
    pub name: String,
    /// True for a joint, false for a tie.
    pub is_joint: bool,
    /// True if the constraint of a drive is redundant.
    pub is_driven: bool,
    /// Number of redundant constraints.
    pub count: usize,
    /// Total number of constraints.
    pub of: usize,
    /// Body, number and reference position `[length]` of the first node with a redundant constraint; `None` for joints.
    pub node: Option<(String, usize, [f64; 3])>,
}

/// Contact and friction state of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeState {
    /// Inactive.
    #[default]
    Open,
    /// Active, sticking.
    Stick,
    /// Active, slipping or without friction.
    Slip,
}

impl NodeState {
    /// Name of the state.
    pub fn name(self) -> &'static str {
        match self {
            NodeState::Open => "open",
            NodeState::Stick => "stick",
            NodeState::Slip => "slip",
        }
    }
}

/// Quantities of a contact pair at one time; every vector has one entry per secondary node, in the order of the nodes along the surface.
#[derive(Clone, Debug)]
pub struct ContactFields {
    /// Positions of the secondary nodes `[length]`.
    pub positions: Vec<[f64; 3]>,
    /// Contact pressure `[stress]`.
    pub pressure: Vec<f64>,
    /// Ratio of the contact force of the node to that of a unit pressure on its covered part `[stress]`.
    pub mean_pressure: Vec<f64>,
    /// Gap `[length]`, NaN where the node faces no other side.
    pub gap: Vec<f64>,
    /// True if the node is in contact.
    pub active: Vec<bool>,
    /// Inactive, sticking or slipping.
    pub state: Vec<NodeState>,
    /// Shear stress of friction on the secondary side, along its tangent with the body on the left; in space its size `[stress]`.
    pub shear: Vec<f64>,
    /// Slip in the last step relative to the other side, along the tangent of `shear`; in space its size `[length]`.
    pub slip: Vec<f64>,
    /// Sum of the sizes of the slips since the start `[length]`.
    pub slip_path: Vec<f64>,
    /// Heat of friction since the start `[energy/length^2]`.
    pub heat: Vec<f64>,
    /// Contact force on each secondary node, including friction `[force]`.
    pub forces: Vec<[f64; 3]>,
    /// Resultant of `forces` `[force]`; for self-contact that of one side only, since each facet pair is counted once.
    pub force: [f64; 3],
    /// Sum of the magnitudes of the normal nodal forces `[force]`.
    pub normal_force: f64,
    /// Contact area of the secondary surface: a length in the plane, an area in space and around an axis.
    pub area: f64,
    /// Number of secondary nodes that slip.
    pub sliding: usize,
}

/// Secondary surface of a contact at one time, for display.
#[derive(Clone, Debug)]
pub struct ContactSurface {
    /// Name of the contact.
    pub name: String,
    /// For each node, in the order of [`ContactFields`], the index of its body in the model and its number in that body's mesh.
    pub nodes: Vec<(usize, usize)>,
    /// Facets of the contact discretization, as indices into `nodes`. In the plane they are straight, with the body on the left; an edge of
    /// second order gives two. In space they have three or four nodes, counter-clockwise as seen from outside.
    pub facets: Vec<Vec<u32>>,
    /// Undeformed positions of the nodes `[length]`.
    pub points: Vec<[f64; 3]>,
    /// Contact quantities at the nodes.
    pub fields: ContactFields,
}

impl ContactFields {
    /// Returns the fields with the nodes in the order `order`.
    pub(super) fn in_order(self, order: &[usize]) -> Self {
        fn sorted<T: Copy>(values: &[T], order: &[usize]) -> Vec<T> {
            order.iter().map(|&index| values[index]).collect()
        }
        ContactFields {
            positions: sorted(&self.positions, order),
            pressure: sorted(&self.pressure, order),
            mean_pressure: sorted(&self.mean_pressure, order),
            gap: sorted(&self.gap, order),
            active: sorted(&self.active, order),
            state: sorted(&self.state, order),
            shear: sorted(&self.shear, order),
            slip: sorted(&self.slip, order),
            slip_path: sorted(&self.slip_path, order),
            heat: sorted(&self.heat, order),
            forces: sorted(&self.forces, order),
            ..self
        }
    }
}
