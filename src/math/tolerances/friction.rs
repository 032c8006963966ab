//! Tolerances of friction and of impacts.

/// Augmentation of tangential constraints (multiplier per slip) relative to that of normal constraints (multiplier per gap), which decides
/// between stick and slip in an iteration. With 1 steps near rest are halved, with 0.01 none is.
pub const TANGENTIAL: f64 = 0.01;

/// Least multiplier per slip of the trial multiplier in space, relative to the node's stiffness in the step: of 60 random rigid bodies with
/// friction 22 fail with 0.01, 16 with 0.1, 17 with 1.
pub const TRIAL_STIFFNESS: f64 = 0.1;

/// Tangential trial multiplier in space, relative to the friction limit, below which its direction is round-off.
pub const UNDIRECTED: f64 = 1e-12;

/// Round-off of a tangential multiplier in space, relative to its size and its limit, at overconstrained nodes.
pub const SLIP_NOISE: f64 = 1e-10;

/// Slip in space that is round-off of the positions, relative to the slip that counts as zero; times the node's stiffness it is round-off
/// of the multiplier. Without it, rigid bodies at rest with steps of 1e-4, piles and arches of rigid bodies fail.
pub const SLIP_ROUND_OFF: f64 = 1e-2;

/// Largest augmentation of contact constraints of a rigid body. Of 60 random bodies with friction 8 fail with 1e2, 5 with 1e3, 4 with 1e4;
/// with 1e8 round-off of gaps becomes noise of multipliers.
pub const RIGID_AUGMENTATION: f64 = 1e3;

/// Compliance of a contact constraint, relative to that of its node, above which it decreases from iteration to iteration while the active
/// set is unchanged.
pub const LARGE_COMPLIANCE: f64 = 1e-5;

/// Remaining share of a compliance above [`LARGE_COMPLIANCE`] after its decrease. With a share of 1, errors of the multipliers of an arch
/// of 25 rigid stones decrease by a factor of 0.7 per iteration; with 0.1, pressures under a flat rigid face are uniform to 1.2e-9 only.
pub const LEAST_EASED: f64 = 0.25;

/// Augmentation of a sticking tangential constraint whose node is already fully constrained.
pub const SHARED_AUGMENTATION: f64 = 100.0;

/// Remaining share of the tangential compliance of a sticking constraint whose node is already fully constrained, while the active set is
/// unchanged; with zero compliance the constraints would be linearly dependent.
pub const LEAST_YIELDING: f64 = 1e-4;

/// Change of a gap in a sweep over the contact constraints of an explicit step, relative to the largest gap to be closed, below which the
/// sweeps end; the next step corrects the rest.
pub const PUSHED: f64 = 1e-12;

/// Change of a rate in a sweep over the contacts of an impact, relative to the largest change by one impulse, below which the sweeps end:
/// the energy defect must stay below 1e-11.
pub const IMPULSE: f64 = 1e-15;

/// Slip rate of an impact that counts as zero, relative to the largest rate; also the relative tolerance of the friction cone.
pub const IMPACT_SLIP: f64 = 1e-12;

/// Kinetic energy of a common motion of all bodies, relative to the model's energy, below which closed rigid sides that approach do not
/// collide. Without it a box of 81 nodes at rest on a plane takes minutes with adaptive steps.
pub const IMPACT_FLOOR: f64 = 1e-17;

/// Apparent energy gain of an impact, relative to the energy of its compression, that is round-off.
pub const IMPACT_ENERGY: f64 = 1e-12;

/// Relative distance of a shear stress from its limit within which the constraint is reported as slipping.
pub const ON_CONE: f64 = 1e-6;

/// Round-off of gaps relative to positions: contact forces times this, times the size of the model, is an energy that no iteration
/// reduces. Bodies at rest have less energy of their own in small steps (`tests/scripts/rigid_friction_in_space.rhai`).
pub const CONTACT_ROUND_OFF: f64 = 4e-15;

/// Proximal term of contact conditions that depend on one another exactly, relative to the compliance of their nodes: each iteration
/// reduces the remaining violation to about this fraction.
pub const PROXIMAL_OF_DEPENDENT: f64 = 1e-3;

/// Work of a force relative to the force times the size of the model that is round-off of positions: bodies at rest under large forces have
/// no other work (`tests/scripts/rest.rhai`).
pub const WORK_ROUND_OFF: f64 = 2e-15;

/// Energy of the bodies relative to the one that loads give them in a step, up to which they count as still.
pub const HARDLY_MOVED: f64 = 1e-6;
