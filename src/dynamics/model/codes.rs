//! Stable codes of the errors of models and steps.

use super::error::ModelError;
use super::step_error::StepError;

impl ModelError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            ModelError::NoBodies { .. } => "C0101",
            ModelError::DuplicateName { .. } => "C0102",
            ModelError::NoFirstStep => "C0103",
            ModelError::NotRigid { .. } => "C0104",
            ModelError::UnsoundJoint { .. } => "C0105",
            ModelError::Unsound { .. } => "C0106",
            ModelError::OneSidedJoint { .. } => "C0107",
            ModelError::JointApart { .. } => "C0108",
            ModelError::MixedDimensions { .. } => "C0109",
            ModelError::UnknownBoundary { .. } => "C0110",
            ModelError::UnsoundIntegrator { .. } => "C0111",
            ModelError::NoLumpedMass { .. } => "C0112",
            ModelError::NotTaken { .. } => "C0113",
            ModelError::EmptyBoundary { .. } => "C0114",
            ModelError::PointBoundary { .. } => "C0115",
            ModelError::InvertedAtStart { .. } => "C0116",
            ModelError::NotInSpace { .. } => "C0117",
            ModelError::ObstacleDimension { .. } => "C0118",
            ModelError::SelfContact { .. } => "C0119",
            ModelError::SpringOfNoLength { .. } => "C0120",
            ModelError::OpenChamber { .. } => "C0121",
            ModelError::ChamberOfNoVolume { .. } => "C0122",
            ModelError::NoMass { .. } => "C0123",
            ModelError::TooLarge { .. } => "C0124",
            ModelError::Ranks(error) => error.code(),
            ModelError::HeldAndMoved { .. } => "C0125",
            ModelError::RepeatedContact { .. } => "C0126",
            ModelError::TiedContact { .. } => "C0142",
            ModelError::Formulation { source, .. } => source.code(),
            ModelError::MixedSymmetry { .. } => "C0127",
            ModelError::BreaksSymmetry { .. } => "C0128",
            ModelError::InvertedCell { .. } => "C0129",
            ModelError::NoRestitution { .. } => "C0136",
            ModelError::OpenEquality { .. } => "C0143",
            ModelError::NoShape { .. } => "C0147",
            ModelError::OffShape { .. } => "C0148",
        }
    }
}

impl StepError {
    /// Stable code of the error, explained by `conserva doc`.
    pub fn code(&self) -> &'static str {
        match self {
            StepError::Amplitude { .. } => "C0501",
            StepError::TurnsFar { .. } => "C0502",
            StepError::Friction { .. } => "C0503",
            StepError::NotConverged { dt: 0.0, .. } => "C0510",
            StepError::NotConverged { .. } => "C0504",
            StepError::TooLong { .. } => "C0505",
            StepError::RanAway { .. } => "C0506",
            StepError::StillOverlaps { .. } => "C0507",
            StepError::Interrupted { .. } => "C0508",
            StepError::OutOfMemory { .. } => "C0509",
            StepError::Ranks { source, .. } => source.code(),
            StepError::Contradiction { .. } | StepError::Blocked { .. } | StepError::Unyielding { .. } | StepError::Jammed { .. } => {
                "C0511"
            }
        }
    }
}
