//! Initial values of a step, and the term that balances its forces: inertia, or damping at rest.

use super::scheme_history::SchemeHistory;
use crate::dynamics::model::part::{Iterate, Pose};
use crate::dynamics::parts::contact_pair::ContactPair;
use crate::dynamics::parts::force_shares::ForceShares;
use crate::dynamics::parts::supports::PrescribedUnknown;
use crate::integrators::{Configuration, Derivative, Dissipation, History, REST, Scheme, UpdateCoefficients};

/// State at the start of a step, and the term that balances its forces.
pub struct StepStart<'a> {
    /// Time at the start.
    pub time: f64,
    /// Positions at the start.
    pub q_0: &'a [f64],
    /// Displacements at the start.
    pub u_0: &'a [f64],
    /// History variables of the parts, block by block.
    pub memory: &'a [Vec<f64>],
    /// Term that balances the forces: inertia or damping.
    pub kind: StepKind<'a>,
}

/// Term that balances the forces in a step.
pub enum StepKind<'a> {
    /// Step with inertia.
    Motion(Motion<'a>),
    /// Damping `mu M (q_1 - q_0)` with a factor `mu` for each body, at constant time.
    Rest {
        /// Damping factors of the bodies.
        damping: &'a [f64],
        /// Velocities at which forces are evaluated; `None` in an equilibrium.
        velocities: Option<&'a [f64]>,
    },
}

/// A step through time.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    /// The time integrator.
    pub scheme: &'a Scheme,
    /// Time step size.
    pub dt: f64,
    /// Velocities at the start.
    pub v_0: &'a [f64],
    /// History variables of the scheme.
    pub scheme_history: &'a SchemeHistory,
    /// Velocities of the prescribed unknowns at the end of the step, in their order.
    pub prescribed_v_1: &'a [f64],
}

/// Displacement that brings nodes to rest at the end of a step.
pub struct Stopping {
    /// Displacement in the step with zero velocity at its end, relative to prescribed motions, which continue.
    pub moved: Vec<f64>,
    /// Additional fraction of an obstacle's motion in the step, since the obstacle continues to move.
    pub own: f64,
}

/// Quantities of an iterate passed to force elements, besides positions and displacements.
#[derive(Default)]
pub struct IterateInputs {
    /// Factor of each body's mass in the tangent.
    pub inertia: Vec<f64>,
    /// Positions at which loads act.
    q_test: Vec<f64>,
    /// Velocities at which forces act.
    velocity: Vec<f64>,
}

impl StepStart<'_> {
    /// Positions and displacements at the start.
    pub fn pose(&self) -> Pose<'_> {
        Pose { q: self.q_0, u: self.u_0 }
    }

    /// True at rest, with constant time.
    pub fn is_at_rest(&self) -> bool {
        matches!(self.kind, StepKind::Rest { .. })
    }

    /// Displacement that brings the nodes to rest in a step that moves them by `moved`; `None` at rest.
    pub fn stopping(&self, moved: &[f64], prescribed: &[PrescribedUnknown]) -> Option<Stopping> {
        let StepKind::Motion(motion) = &self.kind else { return None };
        let (slope, mut stopping) = (motion.scheme.velocity.moved, Vec::with_capacity(moved.len()));
        motion.affine_into(UpdateCoefficients { moved: 0.0, ..motion.scheme.velocity }, moved, &mut stopping);
        stopping.iter_mut().for_each(|v| *v *= -motion.dt / slope);
        for (prescribed, v_1) in prescribed.iter().zip(motion.prescribed_v_1) {
            stopping[prescribed.unknown] = moved[prescribed.unknown] - motion.dt / slope * v_1;
        }
        Some(Stopping { moved: stopping, own: 1.0 - 1.0 / slope })
    }

    /// Time integrator of the step; the static scheme at rest.
    fn scheme(&self) -> &Scheme {
        match &self.kind {
            StepKind::Motion(motion) => motion.scheme,
            StepKind::Rest { .. } => &REST,
        }
    }

    /// Factor of a body's mass in the tangent.
    pub fn inertia(&self, body: usize) -> f64 {
        match &self.kind {
            StepKind::Motion(Motion { scheme, dt, .. }) => scheme.inertia(*dt),
            StepKind::Rest { damping, .. } => REST.weight * damping[body],
        }
    }

    /// Algorithmic dissipation of the scheme.
    pub fn dissipation(&self) -> Dissipation {
        self.scheme().dissipation
    }

    /// Algorithmic gradient of potentials.
    pub fn derivative(&self) -> Derivative {
        self.scheme().derivative
    }

    /// Algorithmic gradient of the constraints of `pair`. Multipliers that enter only their own step act at mid-step, at the mean time of
    /// the forces of the other parts: at the end of the step they would exert a moment on a prestressed body that turns.
    pub fn derivative_of(&self, pair: &ContactPair) -> Derivative {
        let scheme = self.scheme();
        if pair.forces_stay_in_step() && scheme.remembers(History::Force) { Derivative::DiscreteGradient } else { scheme.derivative }
    }

    /// Share of the gradient at the end of the step in the algorithmic gradient of `pair`, in addition to [`Self::derivative_of`].
    pub fn end_share_of(&self, pair: &ContactPair) -> f64 {
        let scheme = self.scheme();
        if pair.forces_stay_in_step() && scheme.remembers(History::Force) { 2.0 * scheme.mean_time() - 1.0 } else { 0.0 }
    }

    /// Share of the static forces of this step in its equations.
    pub fn weight(&self) -> f64 {
        self.scheme().weight
    }

    /// Shares of the multipliers of this step in its equations.
    pub fn shares(&self) -> ForceShares {
        ForceShares { lagging: self.weight(), alone: if self.is_at_rest() { REST.weight } else { 1.0 } }
    }

    /// Configuration whose tangents define friction directions: mid-step in a motion.
    pub fn friction_at(&self) -> Configuration {
        if self.is_at_rest() { REST.derivative.placement().test } else { Configuration::Middle }
    }

    /// Weighted force history of earlier steps in this step; empty without history variables.
    pub fn remembered_force(&self) -> impl Iterator<Item = f64> {
        let motion = if let StepKind::Motion(motion) = &self.kind { Some(motion) } else { None };
        motion.into_iter().flat_map(Motion::remembered_force)
    }

    /// Size of the step, 0 at rest.
    pub fn dt(&self) -> f64 {
        match &self.kind {
            StepKind::Motion(motion) => motion.dt,
            StepKind::Rest { .. } => 0.0,
        }
    }

    /// Time at which loads act.
    pub fn load_time(&self) -> f64 {
        self.time + self.derivative().placement().share * self.dt()
    }

    /// Displacement that inertia opposes in a step with the displacement `moved`; times [`Self::inertia`] and the mass it is a force
    /// `[length]`.
    pub fn opposed_into(&self, moved: &[f64], prescribed: &[PrescribedUnknown], out: &mut Vec<f64>) {
        out.clear();
        let StepKind::Motion(motion) = &self.kind else {
            out.extend_from_slice(moved);
            return;
        };
        let Motion { scheme, dt, v_0, prescribed_v_1, .. } = *motion;
        let [of_velocity, of_acceleration] = scheme.drift(dt);
        out.extend(moved.iter().zip(v_0).map(|(moved, v_0)| moved - of_velocity * v_0));
        out.iter_mut().zip(motion.accelerations()).for_each(|(out, a_0)| *out -= of_acceleration * a_0);
        for (prescribed, v_1) in prescribed.iter().zip(prescribed_v_1) {
            out[prescribed.unknown] = scheme.motion(v_1 - v_0[prescribed.unknown], dt);
        }
    }

    /// Evaluates the positions of loads and the velocities of forces at an iterate, if `positions` and `velocities` are given.
    pub fn visit(
        &self,
        q_1: &[f64],
        moved: &[f64],
        prescribed: &[PrescribedUnknown],
        [positions, velocities]: [bool; 2],
        told: &mut IterateInputs,
    ) {
        if positions {
            self.derivative().placement().test.positions_into(self.q_0, q_1, &mut told.q_test);
        }
        if velocities {
            self.velocities_of_forces_into(moved, prescribed, &mut told.velocity);
        }
    }

    /// Iterate as passed to force elements.
    pub fn iterate<'b>(&'b self, q_1: &'b [f64], u_1: &'b [f64], told: &'b IterateInputs) -> Iterate<'b> {
        let velocity_slope = match &self.kind {
            StepKind::Motion(Motion { scheme, dt, .. }) => scheme.velocity_of_forces().moved / dt,
            StepKind::Rest { .. } => 0.0,
        };
        Iterate {
            derivative: self.derivative(),
            weight: self.weight(),
            time: self.load_time(),
            dt: self.dt(),
            q_0: self.q_0,
            q_1,
            u_0: self.u_0,
            u_1,
            q_test: &told.q_test,
            velocity: &told.velocity,
            velocity_slope,
            is_still: matches!(self.kind, StepKind::Rest { velocities: None, .. }),
            inertia: &told.inertia,
        }
    }

    /// Velocities at the time at which the forces of the step act; at its end, prescribed nodes have the rates of their time functions.
    fn velocities_of_forces_into(&self, moved: &[f64], prescribed: &[PrescribedUnknown], out: &mut Vec<f64>) {
        match &self.kind {
            StepKind::Rest { velocities, .. } => {
                out.clear();
                out.resize(moved.len(), 0.0);
                velocities.iter().for_each(|velocities| out.copy_from_slice(velocities));
            }
            StepKind::Motion(motion) => {
                motion.affine_into(motion.scheme.velocity_of_forces(), moved, out);
                if self.derivative().placement().test == Configuration::End {
                    motion.prescribe(prescribed, out);
                }
            }
        }
    }
}

impl Motion<'_> {
    /// Velocities after a step with the displacement `moved`.
    pub fn velocities(&self, moved: &[f64], prescribed: &[PrescribedUnknown]) -> Vec<f64> {
        let mut v_1 = Vec::with_capacity(moved.len());
        self.affine_into(self.scheme.velocity, moved, &mut v_1);
        self.prescribe(prescribed, &mut v_1);
        v_1
    }

    /// Accelerations after a step with the displacement `moved`, for a scheme with accelerations as history variables.
    pub fn accelerations_after(&self, moved: &[f64]) -> Vec<f64> {
        let (row, dt) = (self.scheme.acceleration, self.dt);
        let start = self.v_0.iter().zip(self.accelerations());
        moved.iter().zip(start).map(|(moved, (v_0, a_0))| row.acceleration(*moved, *v_0, *a_0, dt)).collect()
    }

    /// Weighted force history of earlier steps in this step; empty if the scheme has none.
    pub fn remembered_force(&self) -> impl Iterator<Item = f64> {
        let force = if self.scheme.remembers(History::Force) { &self.scheme_history.force.left[..] } else { &[] };
        force.iter().map(|force| self.scheme.lag.used * force)
    }

    /// Accelerations at the start; empty for a scheme without accelerations as history variables.
    fn accelerations(&self) -> &[f64] {
        if self.scheme.remembers(History::Acceleration) { &self.scheme_history.acceleration } else { &[] }
    }

    fn affine_into(&self, row: UpdateCoefficients, moved: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(moved.iter().zip(self.v_0).map(|(moved, v_0)| row.velocity(*moved, *v_0, self.dt)));
        out.iter_mut().zip(self.accelerations()).for_each(|(v, a_0)| *v += row.velocity_by(*a_0, self.dt));
    }

    fn prescribe(&self, prescribed: &[PrescribedUnknown], velocities: &mut [f64]) {
        for (prescribed, v) in prescribed.iter().zip(self.prescribed_v_1) {
            velocities[prescribed.unknown] = *v;
        }
    }
}
