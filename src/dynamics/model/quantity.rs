//! Named quantities with their dimensions: columns of a history, readings of parts, fields of nodes.

/// Quantity of a result: its name and its dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name, such as `kinetic`.
    pub name: &'static str,
    /// Dimension in space, such as `energy` or `mass * length/time`; `1` for numbers, `rad` for angles. In the plane, forces, energies and
    /// masses are those of a unit thickness.
    pub dimension: &'static str,
}

impl Quantity {
    /// A quantity with its dimension.
    pub const fn new(name: &'static str, dimension: &'static str) -> Self {
        Quantity { name, dimension }
    }

    /// Dimensionless quantity.
    pub const fn number(name: &'static str) -> Self {
        Quantity::new(name, "1")
    }

    /// Names of quantities.
    pub fn names(quantities: &[Quantity]) -> Vec<&'static str> {
        quantities.iter().map(|quantity| quantity.name).collect()
    }
}
