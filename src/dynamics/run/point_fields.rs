//! Fields that follow from stress, strain and history variables at a point: invariants, principal values, components in a local frame.
//!
//! One catalogue for scripts, pictures, probes and paths. Components `r`, `t`, `a` belong to the cylinder about the axis of a
//! [`LocalFrame`]: radial, tangential (counter-clockwise about the axis) and axial.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::fields::{CellStress, pressure, von_mises};
use crate::dynamics::model::quantity::Quantity;

/// Axis of a cylinder and a direction, to which components of tensors refer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    /// A point of the axis `[length]`.
    pub center: [f64; 3],
    /// Direction of the axis, of any length but zero.
    pub axis: [f64; 3],
    /// Direction of components along a line, of any length but zero.
    pub direction: [f64; 3],
}

impl Default for LocalFrame {
    /// The third axis through the origin, the first axis.
    fn default() -> Self {
        LocalFrame { center: [0.0; 3], axis: [0.0, 0.0, 1.0], direction: [1.0, 0.0, 0.0] }
    }
}

impl LocalFrame {
    /// Unit vectors at a position: radial, tangential, axial. On the axis itself the radial direction is one normal to it.
    fn cylinder(&self, position: [f64; 3]) -> [Vector3<f64>; 3] {
        let axis = Vector3::from(self.axis).normalize();
        let arm = Vector3::from(position) - Vector3::from(self.center);
        let radial = arm - axis * axis.dot(&arm);
        let radial = radial.try_normalize(f64::EPSILON * arm.norm()).unwrap_or_else(|| {
            let least = axis.iamin();
            axis.cross(&Vector3::ith(least, 1.0)).cross(&axis).normalize()
        });
        [radial, axis.cross(&radial), axis]
    }

    fn along(&self) -> Vector3<f64> {
        Vector3::from(self.direction).normalize()
    }
}

/// Values of a field at a point.
#[derive(Clone, Copy)]
pub enum PointValue {
    /// A number.
    Number(fn(&CellStress, &LocalFrame) -> f64),
    /// A vector.
    Vector(fn(&CellStress, &LocalFrame) -> [f64; 3]),
}

/// Field that follows from the values at a point.
pub struct PointField {
    /// Name in scripts.
    pub name: &'static str,
    /// Name in words.
    pub words: &'static str,
    /// Physical dimension; `1` for pure numbers.
    pub dimension: &'static str,
    /// Name of the quantity from which the field follows, such as `stress`.
    pub source: &'static str,
    /// True if the field depends on the local frame.
    pub is_local: bool,
    /// Value at a point.
    pub value: PointValue,
}

impl PointField {
    const fn stress(name: &'static str, words: &'static str, value: fn(&CellStress, &LocalFrame) -> f64) -> Self {
        PointField { name, words, dimension: "stress", source: "stress", is_local: false, value: PointValue::Number(value) }
    }

    const fn strain(name: &'static str, words: &'static str, value: fn(&CellStress, &LocalFrame) -> f64) -> Self {
        PointField { name, words, dimension: "1", source: "strain", is_local: false, value: PointValue::Number(value) }
    }

    const fn vector(name: &'static str, words: &'static str, value: fn(&CellStress, &LocalFrame) -> [f64; 3]) -> Self {
        PointField { name, words, dimension: "1", source: "stress", is_local: false, value: PointValue::Vector(value) }
    }

    /// Field that is a quantity of its own, which follows from no other one.
    const fn own(name: &'static str, words: &'static str, dimension: &'static str, value: fn(&CellStress, &LocalFrame) -> f64) -> Self {
        PointField { name, words, dimension, source: name, is_local: false, value: PointValue::Number(value) }
    }

    /// Field in the local frame.
    const fn local(self) -> Self {
        PointField { is_local: true, ..self }
    }

    const fn of(self, dimension: &'static str) -> Self {
        PointField { dimension, ..self }
    }

    /// Number at a point; for a vector field the length of the vector.
    pub fn number(&self, at: &CellStress, frame: &LocalFrame) -> f64 {
        match self.value {
            PointValue::Number(read) => read(at, frame),
            PointValue::Vector(read) => Vector3::from(read(at, frame)).norm(),
        }
    }
}

/// Catalogue of the fields that follow from stress, strain and history variables at a point.
pub static POINT_FIELDS: &[PointField] = &[
    PointField::stress("von_mises", "von Mises stress", |at, _| von_mises(&at.stress)),
    PointField::stress("tresca", "Tresca stress (σ₁ − σ₃)", |at, _| {
        let [first, _, third] = principal(&at.stress).values;
        first - third
    }),
    PointField::stress("pressure", "pressure (−tr σ / 3)", |at, _| pressure(&at.stress)),
    PointField::stress("stress_xx", "stress xx", |at, _| at.stress[0]),
    PointField::stress("stress_yy", "stress yy", |at, _| at.stress[1]),
    PointField::stress("stress_zz", "stress zz", |at, _| at.stress[2]),
    PointField::stress("stress_xy", "stress xy", |at, _| at.stress[3]),
    PointField::stress("stress_yz", "stress yz", |at, _| at.stress[4]),
    PointField::stress("stress_xz", "stress xz", |at, _| at.stress[5]),
    PointField::strain("strain_xx", "strain xx", |at, _| at.strain[0]),
    PointField::strain("strain_yy", "strain yy", |at, _| at.strain[1]),
    PointField::strain("strain_zz", "strain zz", |at, _| at.strain[2]),
    PointField::strain("strain_xy", "strain xy", |at, _| at.strain[3]),
    PointField::strain("strain_yz", "strain yz", |at, _| at.strain[4]),
    PointField::strain("strain_xz", "strain xz", |at, _| at.strain[5]),
    PointField::stress("principal_1", "largest principal stress", |at, _| principal(&at.stress).values[0]),
    PointField::stress("principal_2", "middle principal stress", |at, _| principal(&at.stress).values[1]),
    PointField::stress("principal_3", "least principal stress", |at, _| principal(&at.stress).values[2]),
    PointField::vector("principal_direction_1", "direction of the largest principal stress", |at, _| principal(&at.stress).directions[0]),
    PointField::vector("principal_direction_2", "direction of the middle principal stress", |at, _| principal(&at.stress).directions[1]),
    PointField::vector("principal_direction_3", "direction of the least principal stress", |at, _| principal(&at.stress).directions[2]),
    PointField::strain("principal_strain_1", "largest principal strain", |at, _| principal(&at.strain).values[0]),
    PointField::strain("principal_strain_2", "middle principal strain", |at, _| principal(&at.strain).values[1]),
    PointField::strain("principal_strain_3", "least principal strain", |at, _| principal(&at.strain).values[2]),
    PointField::stress("stress_rr", "radial stress", |at, frame| round(at.position, &at.stress, frame, [0, 0])).local(),
    PointField::stress("stress_tt", "tangential (hoop) stress", |at, frame| round(at.position, &at.stress, frame, [1, 1])).local(),
    PointField::stress("stress_aa", "axial stress", |at, frame| round(at.position, &at.stress, frame, [2, 2])).local(),
    PointField::stress("stress_rt", "shear stress rt", |at, frame| round(at.position, &at.stress, frame, [0, 1])).local(),
    PointField::stress("stress_ta", "shear stress ta", |at, frame| round(at.position, &at.stress, frame, [1, 2])).local(),
    PointField::stress("stress_ra", "shear stress ra", |at, frame| round(at.position, &at.stress, frame, [0, 2])).local(),
    PointField::strain("strain_rr", "radial strain", |at, frame| round(at.rest, &at.strain, frame, [0, 0])).local(),
    PointField::strain("strain_tt", "tangential (hoop) strain", |at, frame| round(at.rest, &at.strain, frame, [1, 1])).local(),
    PointField::strain("strain_aa", "axial strain", |at, frame| round(at.rest, &at.strain, frame, [2, 2])).local(),
    PointField::strain("strain_rt", "shear strain rt", |at, frame| round(at.rest, &at.strain, frame, [0, 1])).local(),
    PointField::strain("strain_ta", "shear strain ta", |at, frame| round(at.rest, &at.strain, frame, [1, 2])).local(),
    PointField::strain("strain_ra", "shear strain ra", |at, frame| round(at.rest, &at.strain, frame, [0, 2])).local(),
    PointField::stress("stress_along", "stress along direction", |at, frame| along(&at.stress, &frame.along())).local(),
    PointField::strain("strain_along", "strain along direction", |at, frame| along(&at.strain, &frame.along())).local(),
    PointField::vector("traction", "stress vector on a plane", |at, frame| (matrix(&at.stress) * frame.along()).into())
        .of("stress")
        .local(),
    PointField::own("energy_density", "strain energy density", "energy/volume", |at, _| at.energy),
    PointField::own("plastic_strain", "equivalent plastic strain", "1", |at, _| at.plastic_strain),
    PointField::own("back_stress", "von Mises norm of the back stress", "stress", |at, _| at.back_stress),
];

/// Fields of nodes that do not follow from the values at a point, tensors, and the fields of secondary surfaces.
pub static NODAL_FIELDS: &[Quantity] = &[
    Quantity::new("position", "length"),
    Quantity::new("displacement", "length"),
    Quantity::new("velocity", "velocity"),
    Quantity::new("acceleration", "length/time^2"),
    Quantity::new("stress", "stress"),
    Quantity::number("strain"),
    Quantity::new("principal_stress", "stress"),
    Quantity::new("stress_error", "stress"),
    Quantity::new("contact_force", "force"),
    Quantity::new("contact_pressure", "stress"),
    Quantity::new("contact_gap", "length"),
    Quantity::number("contact_active"),
    Quantity::number("contact_state"),
    Quantity::new("contact_shear", "stress"),
    Quantity::new("contact_slip", "length"),
    Quantity::new("contact_slip_path", "length"),
    Quantity::new("contact_heat", "energy/area"),
];

/// Physical dimension of a field of nodes or points by its name; `1` for an unknown one.
pub fn field_dimension(name: &str) -> &'static str {
    let of_points = || POINT_FIELDS.iter().find(|field| field.name == name).map(|field| field.dimension);
    NODAL_FIELDS.iter().find(|field| field.name == name).map(|field| field.dimension).or_else(of_points).unwrap_or("1")
}

/// Matrix of a tensor xx, yy, zz, xy, yz, xz.
fn matrix(&[xx, yy, zz, xy, yz, xz]: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Normal component of a tensor along a unit vector.
fn along(tensor: &[f64; 6], direction: &Vector3<f64>) -> f64 {
    direction.dot(&(matrix(tensor) * direction))
}

/// Component of a tensor in the cylindrical frame at a position.
fn round(position: [f64; 3], tensor: &[f64; 6], frame: &LocalFrame, [i, j]: [usize; 2]) -> f64 {
    let axes = frame.cylinder(position);
    axes[i].dot(&(matrix(tensor) * axes[j]))
}

/// Principal values of a symmetric tensor in descending order with their unit directions.
#[derive(Clone, Copy, Debug)]
pub struct Principal {
    /// Principal values.
    pub values: [f64; 3],
    /// Unit directions of the principal values; the largest component of each is positive.
    pub directions: [[f64; 3]; 3],
}

/// Principal values and directions of a tensor xx, yy, zz, xy, yz, xz; NaN if a component is NaN.
pub fn principal(tensor: &[f64; 6]) -> Principal {
    if tensor.iter().any(|component| !component.is_finite()) {
        return Principal { values: [f64::NAN; 3], directions: [[f64::NAN; 3]; 3] };
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = matrix(tensor).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigenvalues[j].total_cmp(&eigenvalues[i]));
    let direction = |k: usize| -> [f64; 3] {
        let vector = eigenvectors.column(k);
        let sign = vector[vector.iamax()].signum();
        std::array::from_fn(|i| sign * vector[i] + 0.0)
    };
    Principal { values: order.map(|k| eigenvalues[k]), directions: order.map(direction) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(position: [f64; 3], stress: [f64; 6]) -> CellStress {
        CellStress { position, rest: position, stress, ..CellStress::default() }
    }

    fn value(name: &str, at: &CellStress, frame: &LocalFrame) -> f64 {
        POINT_FIELDS.iter().find(|field| field.name == name).unwrap().number(at, frame)
    }

    #[test]
    fn principal_values_descend_and_rebuild_the_tensor() {
        let stress = [3.0, -1.0, 0.5, 2.0, -0.7, 1.1];
        let Principal { values, directions } = principal(&stress);
        assert!(values[0] > values[1] && values[1] > values[2]);
        let mut rebuilt = Matrix3::zeros();
        for (value, direction) in values.iter().zip(directions) {
            let n = Vector3::from(direction);
            rebuilt += n * n.transpose() * *value;
            assert!(n.max() >= n.min().abs());
        }
        assert!((rebuilt - matrix(&stress)).norm() < 1e-14);
        assert!(principal(&[f64::NAN; 6]).values[0].is_nan());
    }

    #[test]
    fn the_cylinder_turns_with_the_position_and_with_its_axis() {
        // Hoop stress of 5 about the third axis, at a point at 30 degrees.
        let angle = 30f64.to_radians();
        let (s, c) = angle.sin_cos();
        let stress = [5.0 * s * s, 5.0 * c * c, 0.0, -5.0 * s * c, 0.0, 0.0];
        let here = at([2.0 * c, 2.0 * s, 7.0], stress);
        let frame = LocalFrame::default();
        for (name, expected) in [("stress_rr", 0.0), ("stress_tt", 5.0), ("stress_aa", 0.0), ("stress_rt", 0.0)] {
            assert!((value(name, &here, &frame) - expected).abs() < 1e-14, "{name}");
        }
        let tilted = LocalFrame { center: [1.0, 0.0, 0.0], axis: [0.0, 3.0, 0.0], ..frame };
        let there = at([1.0, 5.0, -2.0], [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
        let all = ["stress_rr", "stress_tt", "stress_aa"].map(|name| value(name, &there, &tilted));
        assert!(all.iter().zip([3.0, 1.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-15), "{all:?}");
        assert!(value("stress_rr", &at([1.0, 9.0, 0.0], there.stress), &tilted).is_finite());
    }
}
