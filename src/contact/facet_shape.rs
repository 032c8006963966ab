//! Shape that contact gives to facets between their nodes.

/// Shape of facets between their nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FacetShape {
    /// Height profiles over facets that follow a curve.
    #[default]
    Curved,
    /// Straight facets.
    Straight,
}
