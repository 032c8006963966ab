//! Fields of nodes by name: one catalogue for scripts, pictures, movies and reports.

use std::sync::LazyLock;

use super::fields::BodyFields;
use super::point_fields::{LocalFrame, POINT_FIELDS, PointField, PointValue, field_dimension};

/// Values of a field at a node.
#[derive(Clone, Copy)]
pub enum NodeValue {
    /// A number.
    Number(fn(&BodyFields, usize) -> f64),
    /// A vector.
    Vector(fn(&BodyFields, usize) -> [f64; 3]),
    /// A field that follows from the values at a point.
    Point(&'static PointField),
}

/// Field of the nodes of a body.
pub struct NodeField {
    /// Name in scripts.
    pub name: &'static str,
    /// Name in words.
    pub words: &'static str,
    /// Values at nodes.
    pub value: NodeValue,
}

impl NodeField {
    const fn number(name: &'static str, words: &'static str, value: fn(&BodyFields, usize) -> f64) -> Self {
        NodeField { name, words, value: NodeValue::Number(value) }
    }

    const fn vector(name: &'static str, words: &'static str, value: fn(&BodyFields, usize) -> [f64; 3]) -> Self {
        NodeField { name, words, value: NodeValue::Vector(value) }
    }

    /// Physical dimension; `1` for pure numbers.
    pub fn dimension(&self) -> &'static str {
        field_dimension(self.name)
    }

    /// Name of the quantity from which the field follows: `stress` for `principal_1`, its own name for `velocity`.
    pub fn source(&self) -> &'static str {
        match self.value {
            NodeValue::Point(field) => field.source,
            NodeValue::Number(_) | NodeValue::Vector(_) => self.name,
        }
    }

    /// True if the field depends on the local frame.
    pub fn is_local(&self) -> bool {
        matches!(self.value, NodeValue::Point(field) if field.is_local)
    }

    /// True if magnitudes of the field can be compared over a body; false for positions, directions, and the gap, which is undefined at
    /// most nodes.
    pub fn has_size(&self) -> bool {
        let is_direction = matches!(self.value, NodeValue::Point(PointField { value: PointValue::Vector(_), dimension: "1", .. }));
        !is_direction && !["position", "contact_gap"].contains(&self.name)
    }

    /// True if the values follow from stresses, strains or their energy, which rigid bodies do not have.
    pub fn is_of_deformation(&self) -> bool {
        matches!(self.value, NodeValue::Point(_)) || self.name == "stress_error"
    }

    /// Number at a node; for a vector field the length of the vector.
    pub fn size(&self, body: &BodyFields, node: usize, frame: &LocalFrame) -> f64 {
        match self.value {
            NodeValue::Number(read) => read(body, node),
            NodeValue::Vector(read) => {
                let [x, y, z] = read(body, node);
                x.hypot(y).hypot(z)
            }
            NodeValue::Point(field) => field.number(&body.at(node), frame),
        }
    }
}

/// All fields of nodes; those that follow from the values at a point are the last ones.
pub static NODE_FIELDS: LazyLock<Vec<NodeField>> = LazyLock::new(|| {
    let nodal = [
        NodeField::vector("position", "position", BodyFields::position),
        NodeField::vector("displacement", "displacement", |body, node| body.displacement[node]),
        NodeField::vector("velocity", "velocity", |body, node| body.velocity[node]),
        NodeField::vector("acceleration", "acceleration", |body, node| body.acceleration[node]),
        NodeField::vector("contact_force", "contact force", |body, node| body.contact_force[node]),
        NodeField::number("contact_pressure", "contact pressure", |body, node| body.contact_pressure[node]),
        NodeField::number("contact_gap", "contact gap", |body, node| body.contact_gap[node]),
        NodeField::number("contact_state", "state of contact", |body, node| body.contact_state[node]),
        NodeField::number("slip", "stick and slip", |body, node| body.contact_slip[node]),
        NodeField::number("stress_error", "estimated error of stress", |body, node| body.stress_error[node]),
    ];
    let of_points = |field: &'static PointField| NodeField { name: field.name, words: field.words, value: NodeValue::Point(field) };
    nodal.into_iter().chain(POINT_FIELDS.iter().map(of_points)).collect()
});
