//! XDMF with HDF5: a series as a list in XML (`fields.xdmf`) with its numbers in one HDF5 file for each frame (`fields_000000.h5`).
//!
//! For programs that read HDF5 and not VTK (h5py, MATLAB, Julia), and for meshio and ParaView as well. Every file includes the grid, so
//! that each is complete by itself. Symmetric tensors are in the order xx, xy, xz, yy, yz, zz. (XDMF model and format, version 3; cells of
//! several kinds are written as `Mixed`.)

use std::fmt::Write as _;

use hdf5_pure::{AttrValue, FileBuilder};

use crate::elements::CellKind;

use super::markup::escaped;
use super::reading::fields::{ArrayRead, FieldsRead, Numbers, Section};

/// Name of the unit of an array in both files.
const UNITS: &str = "units";

/// VTK's number of a polyline.
const POLYLINE: u8 = 3;

/// Returns XDMF's number and name of a cell type, by VTK's number, and its number of nodes.
fn kind_of(vtk: u8) -> Result<(i64, &'static str, usize), String> {
    if vtk == POLYLINE {
        return Ok((2, "Polyline", 2));
    }
    let row = CellKind::ALL.iter().map(|kind| kind.row()).find(|row| row.vtk_type == vtk);
    row.map(|row| (row.xdmf.0, row.xdmf.1, row.nodes)).ok_or_else(|| format!("cells of VTK's kind {vtk} have no name in XDMF"))
}

/// Topology of a frame: name, and connectivity with its width.
struct Topology {
    name: &'static str,
    numbers: Vec<i64>,
    width: usize,
}

fn topology(frame: &FieldsRead) -> Result<Topology, String> {
    let mut kinds: Vec<u8> = frame.cells().map(|(kind, _)| kind).collect();
    kinds.dedup();
    if let [one] = kinds[..] {
        let (_, name, width) = kind_of(one)?;
        return Ok(Topology { name, numbers: frame.cells().flat_map(|(_, nodes)| nodes.iter().copied()).collect(), width });
    }
    let mut numbers = Vec::new();
    for (vtk, nodes) in frame.cells() {
        numbers.push(kind_of(vtk)?.0);
        if vtk == POLYLINE {
            numbers.push(nodes.len() as i64);
        }
        numbers.extend(nodes);
    }
    Ok(Topology { name: "Mixed", width: 1, numbers })
}

/// Returns the HDF5 file of a frame: `points`, `topology`, and every field as a data set with its name.
///
/// # Errors
/// The HDF5 writer refuses the data; the text gives the reason.
pub fn hdf5(frame: &FieldsRead) -> Result<Vec<u8>, String> {
    let mut file = FileBuilder::new();
    let topology = topology(frame)?;
    let rows = (topology.numbers.len() / topology.width) as u64;
    let shape = if topology.width > 1 { vec![rows, topology.width as u64] } else { vec![rows] };
    file.create_dataset("topology").with_i64_data(&topology.numbers).with_shape(&shape);
    for array in frame.arrays.iter().filter(|array| array.section != Section::Cells) {
        let shape = shape_of(array);
        let dataset = file.create_dataset(&dataset_of(array));
        if !array.unit.is_empty() {
            dataset.set_attr(UNITS, AttrValue::String(array.unit.clone()));
        }
        match &array.numbers {
            Numbers::Reals(values) if array.components == 6 => dataset.with_f64_data(&as_tensors(values)).with_shape(&shape),
            Numbers::Reals(values) => dataset.with_f64_data(values).with_shape(&shape),
            Numbers::Integers(values) => dataset.with_i64_data(values).with_shape(&shape),
        };
    }
    file.finish().map_err(|error| error.to_string())
}

/// Reorders symmetric tensors xx, yy, zz, xy, yz, xz to XDMF's order xx, xy, xz, yy, yz, zz.
fn as_tensors(values: &[f64]) -> Vec<f64> {
    values.chunks_exact(6).flat_map(|tensor| [0, 3, 5, 1, 4, 2].map(|component| tensor[component])).collect()
}

fn shape_of(array: &ArrayRead) -> Vec<u64> {
    let rows = (array.numbers.len() / array.components) as u64;
    if array.components > 1 { vec![rows, array.components as u64] } else { vec![rows] }
}

/// Returns the name of an array's data set; a field of cells may have the name of a field of points.
fn dataset_of(array: &ArrayRead) -> String {
    match array.section {
        Section::Points => "points".into(),
        Section::CellData => format!("cell_{}", array.name),
        _ => array.name.clone(),
    }
}

/// Returns the XML of a frame in the list; `file` is the path of its HDF5 file relative to the list.
///
/// # Errors
/// Cells without a name in XDMF.
pub fn grid(frame: &FieldsRead, time: f64, file: &str) -> Result<String, String> {
    let Topology { name, numbers, width } = topology(frame)?;
    let file = escaped(file);
    let item = |kind: &str, shape: &[u64], dataset: &str| {
        let shape: Vec<String> = shape.iter().map(u64::to_string).collect();
        let shape = shape.join(" ");
        format!("<DataItem DataType=\"{kind}\" Precision=\"8\" Dimensions=\"{shape}\" Format=\"HDF\">{file}:/{dataset}</DataItem>")
    };
    let mut text = String::new();
    let _ = writeln!(text, "      <Grid Name=\"grid\" GridType=\"Uniform\">\n        <Time Value=\"{time:?}\"/>");
    let rows = (numbers.len() / width) as u64;
    let shape = if width > 1 { vec![rows, width as u64] } else { vec![rows] };
    let nodes = if name == "Polyline" { " NodesPerElement=\"2\"" } else { "" };
    let data = item("Int", &shape, "topology");
    let _ = writeln!(
        text,
        "        <Topology TopologyType=\"{name}\" NumberOfElements=\"{}\"{nodes}>\n          {data}\n        </Topology>",
        frame.cells
    );
    for array in frame.arrays.iter().filter(|array| array.section != Section::Cells) {
        let kind = if matches!(array.numbers, Numbers::Reals(_)) { "Float" } else { "Int" };
        let data = item(kind, &shape_of(array), &dataset_of(array));
        let told = |unit: &str| format!("<Information Name=\"{UNITS}\" Value=\"{}\"/>\n          ", escaped(unit));
        let unit = if array.unit.is_empty() { String::new() } else { told(&array.unit) };
        if array.section == Section::Points {
            let _ = writeln!(text, "        <Geometry GeometryType=\"XYZ\">\n          {unit}{data}\n        </Geometry>");
            continue;
        }
        let rank = match array.components {
            1 => "Scalar",
            3 => "Vector",
            6 => "Tensor6",
            _ => "Matrix",
        };
        let center = if array.section == Section::CellData { "Cell" } else { "Node" };
        let _ = writeln!(
            text,
            "        <Attribute Name=\"{}\" AttributeType=\"{rank}\" Center=\"{center}\">\n          {unit}{data}\n        </Attribute>",
            array.name
        );
    }
    text.push_str("      </Grid>\n");
    Ok(text)
}

/// Returns the list of a series from the XML of its frames.
pub fn xdmf(grids: &[String]) -> String {
    let head = "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n    \
                <Grid Name=\"series\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
    format!("{head}{}    </Grid>\n  </Domain>\n</Xdmf>\n", grids.concat())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::reading::fields::fields_of;
    use super::super::samples::{block, ring};
    use super::super::vtu::Frame;
    use super::*;

    #[test]
    fn data_sets_hold_the_arrays_bit_by_bit() {
        let read = |frame: Frame| fields_of(Path::new("x"), &frame.encode()).unwrap();
        let bodies = [ring("ring", [1.0, 1.5], [2, 8]), block([1, 1, 1], [1.0; 3])];
        let mixed = read(Frame::new(0.5, &bodies));
        let file = hdf5_pure::File::from_bytes(hdf5(&mixed).unwrap()).unwrap();
        let stress = file.dataset("stress").unwrap();
        assert_eq!(stress.shape().unwrap(), [mixed.points as u64, 6]);
        let tensors = bodies.iter().flat_map(|body| &body.stress).flat_map(|&[xx, yy, zz, xy, yz, xz]| [xx, xy, xz, yy, yz, zz]);
        assert_eq!(stress.read_f64().unwrap(), tensors.collect::<Vec<_>>());
        let numbers = file.dataset("topology").unwrap().read_i64().unwrap();
        assert_eq!((numbers.len(), numbers[0], numbers[16 * 5]), (16 * 5 + 9, 5, 9));
        let one = read(Frame::new(0.5, &bodies[..1]));
        let text = xdmf(&[grid(&one, 0.5, "fields/a&b.h5").unwrap()]);
        assert!(text.contains("TopologyType=\"Quadrilateral\" NumberOfElements=\"16\""), "{text}");
        assert!(text.contains("Dimensions=\"16 4\" Format=\"HDF\">fields/a&amp;b.h5:/topology</DataItem>"), "{text}");
        assert!(text.contains("<Attribute Name=\"body\" AttributeType=\"Scalar\" Center=\"Cell\">"), "{text}");
    }
}
