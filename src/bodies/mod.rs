//! Floor 4 of `ARCHITECTURE.md`: a body is a mesh with a material. This folder contains the element loop, the mass, and the nodal weights
//! of loads.
//!
//! The loop works on batches of eight elements and combines three independent choices: cell kind (shape functions), material (a virtual
//! call per batch) and time integrator (algorithmic gradient, place of evaluation).

mod assembly;
mod batch;
mod blocks;
mod cells;
mod completion;
mod consistent_mass;
mod dilatation;
mod element_loop;
mod formulation;
mod history;
mod kinds;
mod lumped;
mod physics;
mod point_stresses;
mod recovery;
mod rigid;
mod special;
mod stresses;
mod sums;
mod surface_loads;
mod viscous;
mod workspace;

pub use element_loop::{Advance, BodyState, ElementLoop, FastestCell, ForcePerMass, Inverted, PointStress, Step};
pub use formulation::{Dilatation, Formulation, FormulationError, Plane};
pub use kinds::{Elements, Space};
pub use physics::BodyCells;
pub use recovery::Recovery;
pub use rigid::{BarycentricMap, Inertia, RigidMass};
pub use stresses::{StressError, Stresses};
pub use surface_loads::{face_pressure, face_pressure_arms, nodal_areas, positive_areas, pressure_shares, round_pressure, torque_forces};
