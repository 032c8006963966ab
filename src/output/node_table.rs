//! A frame as a table of its points: position, fields, and the body (or contact) that each belongs to.

use super::reading::fields::{ArrayRead, FieldsRead, Section};
use super::table::{Column, Table};

/// Components of an array by its name and their number.
fn suffixes(array: &ArrayRead) -> &'static [&'static str] {
    match array.components {
        3 if array.name == "principal_stress" => &["_1", "_2", "_3"],
        3 => &["_x", "_y", "_z"],
        6 => &["_xx", "_yy", "_zz", "_xy", "_yz", "_xz"],
        _ => &[""],
    }
}

/// One row for each point: `point`, the number of its part (`body`, `contact`), `x`, `y`, `z` undeformed, then every field of points by
/// components (`velocity_x`, `stress_xx`). What is no number is empty.
pub fn node_table(frame: &FieldsRead) -> Table {
    let count = |name: &str, values: Vec<Option<f64>>| Column { name: name.into(), values, is_count: true };
    let mut columns = vec![count("point", (0..frame.points).map(|point| Some(point as f64)).collect())];
    if let Some(parts) = frame.array(Section::CellData, &frame.kind) {
        let mut part_of = vec![None; frame.points];
        for (cell, (_, nodes)) in frame.cells().enumerate() {
            nodes.iter().for_each(|&node| part_of[node as usize] = Some(parts.numbers.at(cell)));
        }
        let name = if frame.array(Section::PointData, &frame.kind).is_some() { "part" } else { frame.kind.as_str() };
        columns.push(count(name, part_of));
    }
    if let Some(points) = frame.array(Section::Points, "Points") {
        columns.extend(["x", "y", "z"].iter().enumerate().map(|(i, name)| component(points, i, (*name).into())));
    }
    for array in frame.arrays.iter().filter(|array| array.section == Section::PointData) {
        let names = suffixes(array);
        let name = |i: usize| names.get(i).map_or_else(|| format!("{}_{i}", array.name), |end| format!("{}{end}", array.name));
        columns.extend((0..array.components).map(|i| component(array, i, name(i))));
    }
    Table { columns }
}

fn component(array: &ArrayRead, index: usize, name: String) -> Column {
    let values =
        (index..array.numbers.len()).step_by(array.components).map(|at| Some(array.numbers.at(at)).filter(|value| !value.is_nan()));
    Column { name, values: values.collect(), is_count: matches!(array.numbers, super::reading::fields::Numbers::Integers(_)) }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::reading::fields::fields_of;
    use super::super::samples::ring;
    use super::super::vtu::Frame;
    use super::*;

    #[test]
    fn a_row_has_what_the_body_has_at_the_node() {
        let bodies = [ring("outer", [1.0, 1.5], [2, 8]), ring("inner", [0.5, 1.0], [2, 8])];
        let table = node_table(&fields_of(Path::new("x"), &Frame::new(0.0, &bodies).encode()).unwrap());
        let first = bodies[0].mesh.points.len();
        let (row, node) = (first + 5, 5);
        let value = |name: &str| table.column(name).unwrap().values[row];
        assert_eq!((value("point"), value("body")), (Some(row as f64), Some(1.0)));
        assert_eq!([value("x"), value("y")], [0, 1].map(|i| Some(bodies[1].mesh.points[node][i])));
        assert_eq!((value("stress_xy"), value("velocity_y")), (Some(bodies[1].stress[node][3]), Some(bodies[1].velocity[node][1])));
        assert_eq!(value("von_mises"), Some(bodies[1].von_mises(node)));
        assert_eq!(table.rows(), first + bodies[1].mesh.points.len());
    }
}
