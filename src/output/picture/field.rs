//! Nodal fields that a picture shows by colors, and vector fields that it shows by arrows.

use crate::dynamics::{BodyFields, LocalFrame, NODE_FIELDS, NodeField, field_dimension};

/// A nodal field that a picture can show, of vectors the length: an index into [`NODE_FIELDS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Field(usize);

impl Default for Field {
    fn default() -> Self {
        Field::from_name("von_mises").unwrap_or(Field(0))
    }
}

impl Field {
    /// Names of the fields that every recording has and every report offers.
    pub const BASIC: [&'static str; 13] = [
        "von_mises",
        "pressure",
        "contact_pressure",
        "displacement",
        "velocity",
        "plastic_strain",
        "slip",
        "stress_xx",
        "stress_yy",
        "stress_zz",
        "stress_xy",
        "stress_yz",
        "stress_xz",
    ];

    /// Returns the field with a name of scripts.
    pub fn from_name(name: &str) -> Option<Self> {
        NODE_FIELDS.iter().position(|field| field.name == name && field.has_size()).map(Field)
    }

    /// All fields, the basic ones first.
    pub fn all() -> Vec<Field> {
        let is_further = |field: &Field| !Field::BASIC.contains(&field.name());
        let further = (0..NODE_FIELDS.len()).map(Field).filter(|field| field.of().has_size()).filter(is_further);
        Field::BASIC.iter().filter_map(|name| Field::from_name(name)).chain(further).collect()
    }

    /// Names of all fields in scripts, the basic ones first.
    pub fn names() -> Vec<&'static str> {
        Field::all().into_iter().map(Field::name).collect()
    }

    fn of(self) -> &'static NodeField {
        &NODE_FIELDS[self.0]
    }

    /// Name of the field in scripts.
    pub fn name(self) -> &'static str {
        self.of().name
    }

    /// Name of the quantity from which the field follows, such as `stress` or `strain`.
    pub fn source(self) -> &'static str {
        self.of().source()
    }

    /// True if the field depends on the local frame.
    pub fn is_local(self) -> bool {
        self.of().is_local()
    }

    /// Name of the field in words.
    pub fn words(self) -> &'static str {
        self.of().words
    }

    /// Dimension of the field.
    pub fn dimension(self) -> &'static str {
        self.of().dimension()
    }

    /// Names of the values 1, 2, … of a field of categories; 0 is none of these.
    pub fn kinds(self) -> &'static [&'static str] {
        if ["slip", "contact_state"].contains(&self.name()) { &["sticks", "slides"] } else { &[] }
    }

    /// Value of the field at a node, with the frame to which components refer.
    pub fn value(self, body: &BodyFields, node: usize, frame: &LocalFrame) -> f64 {
        self.of().size(body, node, frame)
    }

    /// True if a body has the field: a rigid body has no stresses and strains.
    pub fn is_of(self, body: &BodyFields) -> bool {
        !(body.is_rigid && self.of().is_of_deformation())
    }
}

/// A nodal field that a picture can show by arrows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vectors {
    /// Displacement from the undeformed position.
    Displacement,
    /// Velocity.
    Velocity,
    /// Contact force.
    ContactForce,
    /// Contact pressure on the secondary surface.
    ContactPressure,
}

impl Vectors {
    /// All vector fields with their names in scripts and in words.
    pub const ALL: &'static [(&'static str, &'static str, Vectors)] = &[
        ("displacement", "displacement", Vectors::Displacement),
        ("velocity", "velocity", Vectors::Velocity),
        ("contact_force", "contact force", Vectors::ContactForce),
        ("contact_pressure", "contact pressure", Vectors::ContactPressure),
    ];

    /// Field of the lengths of the vectors.
    pub fn field(self) -> Option<Field> {
        Vectors::ALL.iter().find(|row| row.2 == self).and_then(|row| Field::from_name(row.0))
    }

    /// Name of the vector field in words.
    pub fn words(self) -> &'static str {
        Vectors::ALL.iter().find(|row| row.2 == self).map_or("", |row| row.1)
    }

    /// Dimension of the vector field.
    pub fn dimension(self) -> &'static str {
        field_dimension(Vectors::ALL.iter().find(|row| row.2 == self).map_or("", |row| row.0))
    }

    /// Vector at a node.
    pub fn value(self, body: &BodyFields, node: usize) -> [f64; 3] {
        match self {
            Vectors::Displacement => body.displacement[node],
            Vectors::Velocity => body.velocity[node],
            Vectors::ContactForce => body.contact_force[node],
            Vectors::ContactPressure => {
                let force = body.contact_pressing[node];
                let size = force[0].hypot(force[1]).hypot(force[2]);
                let share = if size > 0.0 { body.contact_pressure[node] / size } else { 0.0 };
                force.map(|component| share * component)
            }
        }
    }

    /// True if arrows end at their node (contact force and pressure); otherwise they begin there.
    pub fn ends_at_node(self) -> bool {
        matches!(self, Vectors::ContactForce | Vectors::ContactPressure)
    }
}
