//! What a step starts from, and what opposes the forces in it: inertia, or a damping at rest.

use crate::dynamics::model::part::Pose;
use crate::dynamics::parts::supports::PrescribedUnknown;
use crate::integrators::{Derivative, Scheme};

/// What a step starts from and how it is integrated.
pub struct StepStart<'a> {
    /// Time at the start.
    pub time: f64,
    /// Positions there.
    pub q_0: &'a [f64],
    /// Displacements there.
    pub u_0: &'a [f64],
    /// What parts remember, block by block.
    pub memory: &'a [Vec<f64>],
    /// What opposes the forces.
    pub course: Course<'a>,
}

/// What opposes the forces in a step.
pub enum Course<'a> {
    /// Inertia: time passes.
    Motion(Motion<'a>),
    /// A damping `mu/2 M (q_1 - q_0)` with a factor for each body: time stands still.
    Rest {
        /// The factors.
        damping: &'a [f64],
    },
}

/// A step through time.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    /// The time integrator.
    pub scheme: &'static Scheme,
    /// Size of the step.
    pub dt: f64,
    /// Velocities at the start.
    pub v_0: &'a [f64],
    /// What the scheme remembers of the static forces at the start.
    pub remembered: &'a [f64],
    /// Velocities at the end of the step of the prescribed unknowns, in their order.
    pub prescribed_v_1: &'a [f64],
}

/// Share of the static forces in the equations of a step at rest.
pub const REST_WEIGHT: f64 = 0.5;

impl StepStart<'_> {
    /// Where the nodes are at the start.
    pub fn pose(&self) -> Pose<'_> {
        Pose { q: self.q_0, u: self.u_0 }
    }

    /// Whether time stands still.
    pub fn is_at_rest(&self) -> bool {
        matches!(self.course, Course::Rest { .. })
    }

    /// Factor of a body's mass in the tangent.
    pub fn inertia(&self, body: usize) -> f64 {
        match &self.course {
            Course::Motion(Motion { scheme, dt, .. }) => scheme.kinematics.inertia(*dt),
            Course::Rest { damping } => REST_WEIGHT * damping[body],
        }
    }

    /// How potentials are differentiated.
    pub fn derivative(&self) -> Derivative {
        match &self.course {
            Course::Motion(motion) => motion.scheme.derivative,
            Course::Rest { .. } => Derivative::AT_END,
        }
    }

    /// Share of the static forces of this step in its equations.
    pub fn weight(&self) -> f64 {
        match &self.course {
            Course::Motion(motion) => motion.scheme.weight,
            Course::Rest { .. } => REST_WEIGHT,
        }
    }

    /// Size of the step, 0 at rest.
    pub fn dt(&self) -> f64 {
        match &self.course {
            Course::Motion(motion) => motion.dt,
            Course::Rest { .. } => 0.0,
        }
    }

    /// Time at which loads act.
    pub fn load_time(&self) -> f64 {
        self.time + self.derivative().placement().share * self.dt()
    }

    /// What the mass opposes in a step with that displacement: by the factor of [`Self::inertia`] a force `[length]`.
    pub fn opposed_into(&self, moved: &[f64], prescribed: &[PrescribedUnknown], out: &mut Vec<f64>) {
        out.clear();
        let Course::Motion(motion) = &self.course else {
            out.extend_from_slice(moved);
            return;
        };
        out.extend(moved.iter().zip(motion.v_0).map(|(moved, v_0)| moved - motion.dt * v_0));
        for (prescribed, v_1) in prescribed.iter().zip(motion.prescribed_v_1) {
            out[prescribed.unknown] = motion.scheme.kinematics.motion(v_1 - motion.v_0[prescribed.unknown], motion.dt);
        }
    }
}

impl Motion<'_> {
    /// Velocities after a step with that displacement.
    pub fn velocities(&self, moved: &[f64], prescribed: &[PrescribedUnknown]) -> Vec<f64> {
        let velocity = |(moved, v_0): (&f64, &f64)| self.scheme.kinematics.velocity(*moved, *v_0, self.dt);
        let mut v_1: Vec<f64> = moved.iter().zip(self.v_0).map(velocity).collect();
        for (prescribed, v) in prescribed.iter().zip(self.prescribed_v_1) {
            v_1[prescribed.unknown] = *v;
        }
        v_1
    }
}
