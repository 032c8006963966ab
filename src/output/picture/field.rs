//! Nodal fields that a picture shows by colors, and vector fields that it shows by arrows.

use crate::dynamics::{BodyFields, LocalFrame, POINT_FIELDS, PointField, PointValue, field_dimension};

/// Name of the acceleration in scripts and in words.
const ACCELERATION: &str = "acceleration";

/// A nodal field that a picture can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Field {
    /// Von Mises stress.
    #[default]
    VonMises,
    /// Hydrostatic pressure.
    Pressure,
    /// Contact pressure.
    ContactPressure,
    /// Magnitude of the displacement.
    Displacement,
    /// Magnitude of the velocity.
    Velocity,
    /// Equivalent plastic strain.
    PlasticStrain,
    /// Stick or slip of contact nodes, as in [`BodyFields::contact_slip`].
    Slip,
    /// A component of the Cauchy stress, as an index into [`BodyFields::stress`].
    Stress(Component),
    /// Magnitude of the acceleration.
    Acceleration,
    /// A field of numbers that follows from the values at a point, as an index into [`POINT_FIELDS`].
    Point(usize),
}

/// A component of a symmetric stress, in the order of [`BodyFields::stress`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Component {
    /// xx
    Xx,
    /// yy
    Yy,
    /// zz
    Zz,
    /// xy
    Xy,
    /// yz
    Yz,
    /// xz
    Xz,
}

impl Field {
    /// Fields of recordings and reports, with their names in scripts and their titles.
    pub const ALL: &'static [(&'static str, &'static str, Field)] = &[
        ("von_mises", "von Mises stress", Field::VonMises),
        ("pressure", "pressure (−tr σ / 3)", Field::Pressure),
        ("contact_pressure", "contact pressure", Field::ContactPressure),
        ("displacement", "displacement", Field::Displacement),
        ("velocity", "velocity", Field::Velocity),
        ("plastic_strain", "plastic strain", Field::PlasticStrain),
        ("slip", "stick and slip", Field::Slip),
        ("stress_xx", "stress xx", Field::Stress(Component::Xx)),
        ("stress_yy", "stress yy", Field::Stress(Component::Yy)),
        ("stress_zz", "stress zz", Field::Stress(Component::Zz)),
        ("stress_xy", "stress xy", Field::Stress(Component::Xy)),
        ("stress_yz", "stress yz", Field::Stress(Component::Yz)),
        ("stress_xz", "stress xz", Field::Stress(Component::Xz)),
    ];

    /// Returns the field with a name of scripts.
    pub fn from_name(name: &str) -> Option<Self> {
        let own = Field::ALL.iter().find(|row| row.0 == name).map(|row| row.2);
        own.or((name == ACCELERATION).then_some(Field::Acceleration)).or_else(|| PointField::number_named(name).map(Field::Point))
    }

    /// Names of all fields in scripts.
    pub fn names() -> Vec<&'static str> {
        let is_further =
            |field: &&PointField| matches!(field.value, PointValue::Number(_)) && Field::ALL.iter().all(|row| row.0 != field.name);
        let further = POINT_FIELDS.iter().filter(is_further).map(|field| field.name);
        Field::ALL.iter().map(|row| row.0).chain([ACCELERATION]).chain(further).collect()
    }

    /// True if the field follows from the recorded stress, strain and motion.
    pub fn is_recorded(self) -> bool {
        match self {
            Field::Point(index) => POINT_FIELDS[index].is_of_stress,
            field => field != Field::Acceleration,
        }
    }

    /// Name of the field in words.
    pub fn words(self) -> &'static str {
        match self {
            Field::Acceleration => ACCELERATION,
            Field::Point(index) => POINT_FIELDS[index].words,
            _ => Field::ALL.iter().find(|row| row.2 == self).map_or("", |row| row.1),
        }
    }

    /// Dimension of the field.
    pub fn dimension(self) -> &'static str {
        let name = match self {
            Field::Acceleration => ACCELERATION,
            Field::Point(index) => POINT_FIELDS[index].name,
            _ => Field::ALL.iter().find(|row| row.2 == self).map_or("", |row| row.0),
        };
        field_dimension(name)
    }

    /// Names of the values 1, 2, … of a field of categories; 0 is none of these.
    pub fn kinds(self) -> &'static [&'static str] {
        if self == Field::Slip { &["sticks", "slides"] } else { &[] }
    }

    /// Value of the field at a node, with the frame to which components refer.
    pub fn value(self, body: &BodyFields, node: usize, frame: &LocalFrame) -> f64 {
        let length = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
        match self {
            Field::VonMises => body.von_mises(node),
            Field::Pressure => body.pressure(node),
            Field::ContactPressure => body.contact_pressure[node],
            Field::Displacement => length(body.displacement[node]),
            Field::Velocity => length(body.velocity[node]),
            Field::PlasticStrain => body.plastic_strain[node],
            Field::Slip => body.contact_slip[node],
            Field::Stress(component) => body.stress[node][component as usize],
            Field::Acceleration => length(body.acceleration[node]),
            Field::Point(index) => POINT_FIELDS[index].number(&body.at(node), frame),
        }
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
    pub(crate) fn ends_at_node(self) -> bool {
        matches!(self, Vectors::ContactForce | Vectors::ContactPressure)
    }
}
