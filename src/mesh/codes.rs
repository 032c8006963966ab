//! Stable codes of errors of meshes and mesh files.

use super::error::MeshError;
use super::file_error::{FileError, FileProblem};

impl MeshError {
    /// Returns the stable code of the mesh error, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            MeshError::NotPositive { .. } => "C0201",
            MeshError::NotFinite { .. } => "C0202",
            MeshError::FewCorners { .. } => "C0203",
            MeshError::HoleOutside { .. } => "C0204",
            MeshError::JoinedKinds { .. } => "C0205",
            MeshError::NothingShared => "C0206",
            MeshError::EmptySide { .. } => "C0207",
            MeshError::CrossingSides { .. } => "C0208",
            MeshError::NoTriangulation => "C0209",
            MeshError::NotMultiple { .. } => "C0210",
            MeshError::TooFewCells { .. } => "C0211",
            MeshError::TooManyCells { .. } => "C0212",
            MeshError::Memory { .. } => "C0213",
            MeshError::NoConversion { .. } => "C0214",
            MeshError::Radii { .. } => "C0215",
            MeshError::Turn { .. } => "C0216",
            MeshError::OffCircle { .. } => "C0217",
            MeshError::StraightArc => "C0218",
            MeshError::FewPoints { .. } => "C0219",
            MeshError::OpenOutline { .. } => "C0220",
            MeshError::CrossingCurves { .. } => "C0221",
            MeshError::UnknownLayers { .. } => "C0222",
            MeshError::LayersCollide { .. } => "C0223",
            MeshError::LayersCramped { .. } => "C0224",
            MeshError::LayerCorner { .. } => "C0225",
            MeshError::OddLayers { .. } => "C0226",
            MeshError::NotLocally { .. } => "C0227",
            MeshError::Grading { .. } => "C0228",
            MeshError::Extruded { .. } => "C0229",
            MeshError::SweptOver { .. } => "C0230",
            MeshError::PathPoints { .. } => "C0231",
            MeshError::CoincidentPathPoints { .. } => "C0232",
            MeshError::PathTurns { .. } => "C0233",
            MeshError::ClosedChange => "C0234",
            MeshError::Lofted { .. } => "C0235",
            MeshError::Revolution { .. } => "C0236",
            MeshError::OnAxis { .. } => "C0237",
            MeshError::Rounding { .. } => "C0238",
            MeshError::LeavesPlane { .. } => "C0239",
            MeshError::NoAxis { .. } => "C0240",
            MeshError::UnknownPart { .. } => "C0241",
            MeshError::BoundaryExists { .. } => "C0242",
            MeshError::InvertedCell { .. } => "C0243",
            MeshError::DegenerateCell { .. } => "C0244",
            MeshError::RepeatedNode { .. } => "C0245",
            MeshError::CrowdedFacet { .. } => "C0246",
            MeshError::FoldedFacet { .. } => "C0247",
            MeshError::Unjoined { .. } => "C0248",
            MeshError::CrossingSurface { .. } => "C0249",
            MeshError::UnusedNodes { .. } => "C0250",
            MeshError::BrokenReference { .. } => "C0251",
            MeshError::NotRefined { .. } => "C0252",
            MeshError::Unmatched { .. } => "C0253",
            MeshError::File(error) => error.code(),
            MeshError::Included { error, .. } => error.code(),
        }
    }
}

impl FileError {
    /// Stable code of the problem, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        self.problem.code()
    }
}

impl FileProblem {
    /// Returns the stable code of the file problem, which `conserva doc` explains.
    pub fn code(&self) -> &'static str {
        match self {
            FileProblem::Unreadable { .. } => "C0801",
            FileProblem::NotText => "C0802",
            FileProblem::OtherFormat { .. } => "C0803",
            FileProblem::NumberSize { .. } => "C0804",
            FileProblem::ByteOrder => "C0805",
            FileProblem::Version { .. } => "C0806",
            FileProblem::Truncated { .. } => "C0807",
            FileProblem::Count { .. } => "C0808",
            FileProblem::MissingSection { .. } => "C0809",
            FileProblem::RepeatedSection { .. } => "C0810",
            FileProblem::Malformed { .. } => "C0812",
            FileProblem::Coordinate { .. } => "C0813",
            FileProblem::DuplicateNode { .. } => "C0814",
            FileProblem::DuplicateElement { .. } => "C0815",
            FileProblem::MissingNode { .. } => "C0816",
            FileProblem::DuplicateCell { .. } => "C0817",
            FileProblem::UnsupportedCell { .. } => "C0818",
            FileProblem::UnsupportedType { .. } => "C0819",
            FileProblem::MixedCells { .. } => "C0820",
            FileProblem::MixedDimensions { .. } => "C0821",
            FileProblem::NoCells { .. } => "C0822",
            FileProblem::StrayFacet { .. } => "C0823",
            FileProblem::NotPlane { .. } => "C0824",
            FileProblem::UnknownEntity { .. } => "C0825",
            FileProblem::AmbiguousName { .. } => "C0826",
            FileProblem::Keyword { .. } => "C0827",
            FileProblem::MissingParameter { .. } => "C0828",
            FileProblem::UnknownSet { .. } => "C0829",
            FileProblem::UnknownMember { .. } => "C0830",
            FileProblem::UnknownSide { .. } => "C0831",
            FileProblem::Included { .. } => "C0832",
            FileProblem::Shells { .. } => "C0833",
            FileProblem::Structural { .. } => "C0834",
            FileProblem::Form { .. } => "C0835",
            FileProblem::Undecodable { .. } => "C0836",
            FileProblem::Collapsed { .. } => "C0837",
            FileProblem::FewNodes { .. } => "C0838",
        }
    }
}
