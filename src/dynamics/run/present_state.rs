//! Interface to the present state of a simulation in either dimension.

use super::buckling::{Buckling, BucklingError};
use super::fields::{
    BodyFields, BodyTotals, CellPlaces, CellStress, ContactFields, ContactSurface, JointLoad, PlacedObstacle, RedundantConstraints,
};
use super::halvings::Halving;
use super::harmonic::{HarmonicError, HarmonicOptions, HarmonicResponse};
use super::ledger::LedgerRow;
use super::modes::{Modes, ModesError};
use super::options::{Options, Statistics};
use super::paths::{Path, PathError, PathOptions};
use super::report::FailureReport;
use super::run_findings::RunFinding;
use super::section_force::SectionForce;
use super::stable_step::StableStep;
use super::state::State;
use crate::dynamics::model::step_error::StepError;

/// Functions of a simulation besides its steps: output quantities of the present state, analyses about it, its replacement by another
/// state, and records of the run so far. A [`Simulation`](super::simulation::Simulation) dereferences to them.
pub trait PresentState {
    /// Space dimension.
    fn dimension(&self) -> usize;

    /// Options of the simulation.
    fn options(&self) -> &Options;

    /// Number of free displacement components.
    fn unknowns(&self) -> usize;

    /// Slowest natural vibrations about the present state, which remains unchanged: active constraints are tied, viscosity is relaxed,
    /// slipping friction has no effect.
    ///
    /// # Errors
    /// [`ModesError`].
    fn modes(&mut self, count: usize) -> Result<Modes, ModesError>;

    /// Steady vibrations about the present state under an excitation, with the assumptions of [`Self::modes`]; the state remains unchanged.
    ///
    /// # Errors
    /// [`HarmonicError`].
    fn harmonic_response(&mut self, options: &HarmonicOptions) -> Result<HarmonicResponse, HarmonicError>;

    /// Smallest factors of the present load at which the model buckles; the state is unchanged.
    ///
    /// # Errors
    /// [`BucklingError`].
    fn buckling(&mut self, count: usize) -> Result<Buckling, BucklingError>;

    /// Longest stable explicit step about the present state, which is unchanged.
    ///
    /// # Errors
    /// The forces cannot be computed.
    ///
    /// # Panics
    /// With an integrator that solves equations.
    fn stable_step(&mut self) -> Result<StableStep, StepError>;

    /// Follows equilibria along the load, whose parameter is the time of all time functions, from the present state; the simulation remains
    /// unchanged. `told` receives the row of each equilibrium.
    ///
    /// # Errors
    /// [`PathError`].
    fn path(&mut self, options: &PathOptions, told: &mut dyn FnMut(&LedgerRow)) -> Result<Path, PathError>;

    /// Boundary with the largest prescribed displacement at the first step from the present state, and the displacement `[length]`.
    ///
    /// # Errors
    /// A time function failed.
    fn prescribed_jump(&self) -> Result<Option<(String, f64)>, StepError>;

    /// Contact whose adhesion or film acts for too short a time because its nodes bounce in steps of this size, with the time in which an
    /// elastic wave crosses a cell `[time]`.
    fn interrupted_friction(&self) -> Option<(&str, f64)>;

    /// Checks that the sides of all contacts are apart or held by contact forces; `settle` includes this check.
    ///
    /// # Errors
    /// Sides penetrate each other by more than half a facet without contact forces: the deepest place.
    fn check_apart(&self) -> Result<(), StepError>;

    /// Records the motion of a node (bodies one after the other) in every row of the ledger from now on.
    fn watch(&mut self, node: usize);

    /// Indices of the watched nodes, whose motion is recorded in the ledger.
    fn watched(&self) -> &[usize];

    /// Restores a state of this simulation (or of one of the same model).
    ///
    /// # Panics
    /// When the state is of another model (other numbers of nodes or multipliers).
    fn restore(&mut self, state: &State);

    /// Restricts the contact search to pairs of the present state; after a step it includes distant pairs of fast bodies. Fields and gaps
    /// for output depend on the state only after this call; a restored state needs none.
    fn look(&mut self);

    /// Adopts the ledger's row of a later step before its state is restored. No other function may be called before [`Self::restore`].
    fn recall(&mut self, row: &LedgerRow);

    /// Nodal fields of every body.
    fn fields(&self) -> Vec<BodyFields>;

    /// Totals of one body: mass, energies, momenta, center of mass.
    ///
    /// # Panics
    /// The model has no body of that index.
    fn body(&self, body: usize) -> BodyTotals;

    /// Stress and strain inside of the cells of one body, in the order of the cells.
    ///
    /// # Panics
    /// The model has no body of that index.
    fn cell_stresses(&self, body: usize, places: CellPlaces) -> Vec<CellStress>;

    /// Force and moment of the material of a body in front of a plane, which cuts the undeformed body, on the material behind it; `None` if
    /// no two cells are on different sides.
    ///
    /// # Panics
    /// The model has no body of that index.
    fn section_force(&self, body: usize, point: [f64; 3], normal: [f64; 3]) -> Option<SectionForce>;

    /// Ties and joints with redundant constraints, which depend on other constraints and on supports and are omitted.
    fn redundant_constraints(&self) -> Vec<RedundantConstraints>;

    /// Joints that the present velocities violate, with the rate at which the joint would open `[length/time]`.
    fn loose_joints(&self) -> Vec<(String, f64)>;

    /// Force and moment of the joint `name` on its second body; `None` without such a joint.
    fn joint(&self, name: &str) -> Option<JointLoad>;

    /// Rigid obstacles at their present positions.
    fn obstacles(&self) -> Vec<PlacedObstacle>;

    /// Quantities of the contact pair `name`; `None` without such a pair.
    fn contact(&self, name: &str) -> Option<ContactFields>;

    /// Secondary surfaces of all contacts except ties, with contact quantities, in the order of the model.
    fn contact_surfaces(&self) -> Vec<ContactSurface>;

    /// Number of active nodes of each contact pair, in the order of the model.
    fn closed_nodes(&self) -> Vec<usize>;

    /// Multipliers of the last step in every constraint of every contact with friction: normal `[stress]`, and tangential `[stress]`, which
    /// the friction law bounds by the normal one. Corners have forces `[force]`, axisymmetric bodies stresses times circumferences.
    fn friction_multipliers(&self) -> Vec<[f64; 2]>;

    /// Report of the last step that failed after all tries; `None` without a failure.
    fn failure(&self) -> Option<&FailureReport>;

    /// Nodal fields of the iterate at which the last failed step was abandoned; velocities are those of the last accepted state.
    fn failed_fields(&self) -> Option<Vec<BodyFields>>;

    /// Counters and times so far.
    fn statistics(&self) -> Statistics;

    /// Largest memory of each rank of a distributed solver `[bytes]`; empty for others.
    fn rank_bytes(&self) -> &[u64];

    /// Halvings by cause since the simulation was made, including steps halved before an attempt.
    fn halvings(&self) -> &[Halving];

    /// Findings from the initial velocities: contacts whose sides slide so fast that steps would be halved.
    fn findings_at_start(&self) -> Vec<RunFinding>;
}
