//! Why a step failed: what a user can look at after the error.

/// What made a step fail.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum FailureCause {
    /// The contact state of some nodes changed in every one of the last iterations.
    CyclingContact {
        /// Name of the contact pair.
        contact: String,
        /// Nodes that changed in each of the last iterations, at least.
        changing: usize,
        /// Secondary nodes of the pair.
        nodes: usize,
    },
    /// The residual fell too slowly or not at all.
    SlowConvergence,
    /// The iterates grew without bound.
    Divergence,
    /// A cell turned inside out.
    InvertedCell {
        /// Name of the body.
        body: String,
        /// Cell number in its mesh.
        cell: usize,
        /// Smallest determinant of the deformation gradient in it.
        determinant: f64,
        /// Center of the cell in the undeformed body `[length]`.
        center: [f64; 3],
    },
    /// The linear system could not be solved.
    SingularSystem {
        /// What the solver said.
        reason: String,
    },
    /// Bodies moved farther in the step than the search for contact reaches.
    TooFast {
        /// Name of the contact pair.
        contact: String,
    },
}

/// One Newton iteration of the step that failed.
#[derive(Clone, Debug, PartialEq)]
pub struct IterationReport {
    /// Largest component of the residual `[force]`.
    pub residual: f64,
    /// Force below which it would have been small enough.
    pub target: f64,
    /// Largest violation of the contact conditions over what is tolerated.
    pub gap_violation: f64,
    /// Contact nodes that changed their state.
    pub changes: usize,
    /// Active contact nodes.
    pub active: usize,
    /// Body with the largest residual.
    pub body: String,
    /// Node of that body's mesh.
    pub node: usize,
    /// Contact pair with the largest violation.
    pub contact: Option<String>,
}

/// The report on a step that failed for good.
#[derive(Clone, Debug, PartialEq)]
pub struct FailureReport {
    /// Time at its beginning `[time]`.
    pub time: f64,
    /// Its number.
    pub step: usize,
    /// Size of the last try `[time]`; 0 in `settle`.
    pub dt: f64,
    /// How often it had been halved.
    pub halvings: usize,
    /// What made it fail.
    pub cause: FailureCause,
    /// The iterations of the last try.
    pub iterations: Vec<IterationReport>,
}

impl FailureReport {
    /// The cause with its numbers, one sentence.
    pub fn explanation(&self) -> String {
        let residual = self.iterations.last().map_or(String::new(), |last| {
            format!(
                "; after {} iterations the largest residual is {:.1e} at node {} of body \"{}\" (target {:.1e})",
                self.iterations.len() - 1,
                last.residual,
                last.node,
                last.body,
                last.target
            )
        });
        match &self.cause {
            FailureCause::CyclingContact { contact, changing, nodes } => {
                format!(
                    "the contact state of {changing} or more of {nodes} nodes of contact \"{contact}\" changed in every iteration{residual}"
                )
            }
            FailureCause::SlowConvergence => format!("the residual did not become small{residual}"),
            FailureCause::Divergence => format!("the iterates grew without bound{residual}"),
            FailureCause::InvertedCell { body, cell, determinant, center } => format!(
                "cell {cell} of body \"{body}\", at ({:.4}, {:.4}, {:.4}) when undeformed, turned inside out (det F = {determinant:.2e})",
                center[0], center[1], center[2]
            ),
            FailureCause::SingularSystem { reason } => format!("{reason} in the tangent of the step"),
            FailureCause::TooFast { contact } => {
                format!("the bodies of contact \"{contact}\" moved farther in one step than the search for contact reaches")
            }
        }
    }

    /// How to mend it; `smaller` says how a smaller step is asked for.
    pub(super) fn cure(&self, smaller: &str) -> String {
        match &self.cause {
            FailureCause::CyclingContact { .. } => format!("{smaller}; surfaces should slide by less than two facets per step"),
            FailureCause::InvertedCell { .. } => format!("{smaller}, a finer mesh there, or a smaller load"),
            FailureCause::SingularSystem { .. } => {
                "hold every body against rigid motion with `fix`, and name each contact pair and each support only once".into()
            }
            FailureCause::Divergence => format!("{smaller}, or apply the load more slowly"),
            FailureCause::SlowConvergence | FailureCause::TooFast { .. } => smaller.into(),
        }
    }
}
