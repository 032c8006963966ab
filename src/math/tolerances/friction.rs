//! Tolerances of friction and of impacts.

/// Multiplier per slip of tangential rows over that per gap of those that press: it decides whether a row sticks or slides in an iteration.
/// With 1 steps are halved near rest, with 0.01 none is.
pub const TANGENTIAL: f64 = 0.01;

/// Multiplier per slip of the trial of an iteration in space over the stiffness of the node in the step, at least: of 60 random rigid
/// bodies with friction 22 fail with 0.01, 16 with 0.1, 17 with 1.
pub const TRIAL_STIFFNESS: f64 = 0.1;

/// Trial of tangential rows in space over the limit of friction, below which its direction is round-off.
pub const UNDIRECTED: f64 = 1e-12;

/// Round-off of a tangential multiplier in space over its size and its limit, where more rows than motions share a force.
pub const SLIP_NOISE: f64 = 1e-10;

/// Slip in space that is round-off of the positions, over the one that counts as zero. Times the stiffness of the node in the step it is
/// round-off of the multiplier: without this, rigid bodies at rest with steps of 1e-4, piles and arches of rigid bodies fail.
pub const SLIP_ROUND_OFF: f64 = 1e-2;

/// Augmentation of contact rows of a rigid body, at most. Of 60 random bodies with friction 8 fail with 1e2, 5 with 1e3, 4 with 1e4, and
/// with 1e8 gaps of round-off become noise of multipliers.
pub const RIGID_AUGMENTATION: f64 = 1e3;

/// Compliance of a contact row over that of its node from which on it decreases from iteration to iteration while the set stays.
pub const LARGE_COMPLIANCE: f64 = 1e-5;

/// Part of such a compliance that is left in the end. With all of it, multipliers of an arch of 25 rigid stones come nearer to their values
/// by a factor of 0.7 in each iteration; with a tenth, pressures under a flat rigid face are even to 1.2e-9 only.
pub const LEAST_EASED: f64 = 0.25;

/// Augmentation of tangential rows that stick to a node which other rows hold in all directions.
pub const SHARED_AUGMENTATION: f64 = 100.0;

/// The part of that by which such rows go on to give way while their set stays: without any they would be dependent.
pub const LEAST_YIELDING: f64 = 1e-4;

/// Change of a gap in a sweep of the contact rows of an explicit step, relative to the largest gap that was to be closed, below which the
/// sweeps end: what is left is seen by the next step.
pub const PUSHED: f64 = 1e-12;

/// Change of a rate in a sweep over the contacts of an impact, relative to the largest change by one impulse, below which the sweeps end:
/// energy is promised to 1e-11.
pub const IMPULSE: f64 = 1e-15;

/// Slip of an impact that counts as none, relative to the largest rate; friction beyond its cone by as much of it.
pub const IMPACT_SLIP: f64 = 1e-12;

/// Kinetic energy of a motion of all bodies over the energy of the model, up to which closed rigid sides that approach do not collide.
/// Without it a box of 81 nodes at rest on a plane takes minutes with steps that choose their size.
pub const IMPACT_FLOOR: f64 = 1e-17;

/// Energy that an impact may seem to give, relative to what its compression takes: round-off.
pub const IMPACT_ENERGY: f64 = 1e-12;

/// Distance of a shear stress from its limit, relative to it, within which the row is said to slide.
pub const ON_CONE: f64 = 1e-6;
