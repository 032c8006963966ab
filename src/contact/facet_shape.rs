//! Option of a contact: straight facets, or facets that follow the curves through their nodes.

/// Geometry assumed between the nodes of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FacetShape {
    /// Facets carry height profiles of the curve, or curved surface, through their nodes in the reference configuration.
    #[default]
    Curved,
    /// Facets are straight lines, or flat (Hesch and Betsch 2007).
    Straight,
}
