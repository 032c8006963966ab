//! Tolerances of friction and of impacts.

/// Augmentation of tangential constraints (multiplier per slip) relative to that of normal constraints (multiplier per gap); it decides
/// between stick and slip in an iteration. With 1, steps near rest had to be halved; with 0.01, none.
pub const TANGENTIAL: f64 = 0.01;

/// Least multiplier per slip of the trial multiplier, relative to the node's stiffness in the step: of 60 random rigid bodies with friction
/// in space 22 fail with 0.01, 16 with 0.1, 17 with 1.
pub const TRIAL_STIFFNESS: f64 = 0.1;

/// Step size relative to the time in which an elastic wave crosses a cell, below which nodes of contacts with `persistency` bounce from
/// step to step: adhesion under a soft block loses 3 % of its impulse at 0.45, 35 % at 0.13.
pub const BOUNCES: f64 = 0.3;

/// Tangential trial multiplier in space, relative to the friction limit, below which its direction is round-off.
pub const UNDIRECTED: f64 = 1e-12;

/// Round-off of a tangential multiplier in space, relative to its size and its limit, at overconstrained nodes.
pub const SLIP_NOISE: f64 = 1e-10;

/// Slip in space that is round-off of the positions, relative to the slip that counts as zero; times the node's stiffness it is round-off
/// of the multiplier. Without it, rigid bodies at rest with steps of 1e-4, piles and arches of rigid bodies fail.
pub const SLIP_ROUND_OFF: f64 = 1e-2;

/// Largest augmentation of contact constraints of a rigid body against a rigid body or an obstacle. Of 60 random bodies with friction 8
/// fail with 1e2, 5 with 1e3, 4 with 1e4; with 1e8 round-off of gaps becomes noise of multipliers.
pub const RIGID_AUGMENTATION: f64 = 1e3;

/// Compliance of a contact constraint, relative to that of its node, above which the compliance decreases from iteration to iteration while
/// the active set is unchanged.
pub const LARGE_COMPLIANCE: f64 = 1e-5;

/// Smallest ratio of a compliance above [`LARGE_COMPLIANCE`] to its initial value after decreases. With a ratio of 1, errors of the
/// multipliers of an arch of 25 rigid stones decrease by 0.7 per iteration; with 0.1, pressures under a flat rigid face are uniform to
/// 1.2e-9 only.
pub const LEAST_REGULARIZATION_RATIO: f64 = 0.25;

/// Augmentation of a sticking tangential constraint whose node is already fully constrained.
pub const SHARED_AUGMENTATION: f64 = 100.0;

/// Smallest ratio of the tangential compliance of a sticking constraint at a fully constrained node to its initial value, while the active
/// set is unchanged; with zero compliance the constraints would be linearly dependent.
pub const LEAST_STICKING_COMPLIANCE_RATIO: f64 = 1e-4;

/// Change of a gap in a Gauss-Seidel sweep over the contact constraints of an explicit step, relative to the largest gap to be closed,
/// below which the sweeps end; the next step corrects the rest.
pub const PUSHED: f64 = 1e-12;

/// Energy that an impact would give to rigid bodies, relative to the energy scale, above which the impulses of the step are kept: such a
/// gain comes from impulses that friction and joints balance in the step, but not at its end.
pub const JAMMED: f64 = 1e-6;

/// Velocity by an impulse on a rigid body relative to that of a free body with the mass of the model, below which the body counts as held:
/// larger than round-off, less than at a lever of a hundred-thousandth of the radius of gyration about a hinge.
pub const HELD_RESPONSE: f64 = 1e-11;

/// Change of a normal velocity in a Gauss-Seidel sweep over the contacts of an impact, relative to the largest change by one impulse, below
/// which the sweeps end: the energy defect must stay below 1e-11.
pub const IMPULSE: f64 = 1e-15;

/// Slip velocity of an impact that counts as zero, relative to the largest velocity; also the relative tolerance of the friction cone.
pub const IMPACT_SLIP: f64 = 1e-12;

/// Kinetic energy of a common motion of all bodies, relative to the model's energy, below which approaching closed contacts of rigid bodies
/// cause no impact. Without this limit a box of 81 nodes at rest on a plane takes minutes with adaptive steps.
pub const IMPACT_FLOOR: f64 = 1e-17;

/// Apparent energy gain of an impact, relative to the energy of its compression phase, that is round-off.
pub const IMPACT_ENERGY: f64 = 1e-12;

/// Relative distance of the shear stress from the friction limit within which the constraint is reported as slipping.
pub const ON_CONE: f64 = 1e-6;

/// Round-off of gaps relative to positions. Contact force times this times the model size is an energy that no iteration can reduce; bodies
/// at rest have less energy of their own in small steps (`tests/scripts/rigid_friction_in_space.rhai`).
pub const CONTACT_ROUND_OFF: f64 = 4e-15;

/// Proximal regularization of exactly dependent contact constraints, relative to the compliance of their nodes: each iteration reduces the
/// remaining violation to about this fraction.
pub const PROXIMAL_OF_DEPENDENT: f64 = 1e-3;

/// Work of a force, relative to the force times the model size, that is round-off of positions: bodies at rest under large forces do no
/// other work (`tests/scripts/rest.rhai`).
pub const WORK_ROUND_OFF: f64 = 2e-15;

/// Kinetic plus strain energy, relative to the energy that loads add in one step, up to which the bodies count as standing still.
pub const HARDLY_MOVED: f64 = 1e-6;

/// Compliance of unilateral constraints in the velocities at the end of a step, relative to their response by the largest nodal mass, in
/// models whose couplings make constraints dependent. With less, momenta are not balanced to round-off.
pub const RATE_COMPLIANCE: f64 = 0.04;
/// Largest number of repeated solutions that remove the influence of [`RATE_COMPLIANCE`]: each reduces it by the same factor, or by more at
/// nodes of less mass.
pub const RATE_REPETITIONS: usize = 20;
/// Change of the velocities in a repeated solution, relative to the largest, below which the influence of compliances is round-off.
pub const SAME_RATE: f64 = 1e-13;
