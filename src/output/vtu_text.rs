//! A frame as VTU in plain text, for people and for programs without support of appended data or zlib.
//!
//! Numbers have the fewest digits that read back as the same value; `nan` where there is none (VTK and meshio read it).

use std::fmt::Write as _;

use super::markup::comment;
use super::reading::fields::{ArrayRead, FieldsRead, Numbers, Section};
use super::vtu::{component_names, unit_tag};

/// Values per line of an array with one component.
const PER_LINE: usize = 12;

/// Returns the text of the file.
pub fn vtu_text(frame: &FieldsRead) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    );
    for (index, name) in frame.parts.iter().enumerate() {
        let _ = writeln!(text, "  <!-- {} {index}: {} -->", frame.kind, comment(name));
    }
    text.push_str("  <UnstructuredGrid>\n");
    if let Some(time) = frame.time {
        let tag = "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">";
        let _ = writeln!(text, "    <FieldData>\n      {tag}{time:?}</DataArray>\n    </FieldData>");
    }
    let _ = writeln!(text, "    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", frame.points, frame.cells);
    let sections =
        [("Points", Section::Points), ("Cells", Section::Cells), ("PointData", Section::PointData), ("CellData", Section::CellData)];
    for (tag, section) in sections {
        let _ = writeln!(text, "      <{tag}>");
        frame.arrays.iter().filter(|array| array.section == section).for_each(|array| put(&mut text, array));
        let _ = writeln!(text, "      </{tag}>");
    }
    text.push_str("    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n");
    text
}

fn put(text: &mut String, array: &ArrayRead) {
    let ArrayRead { name, components, numbers, unit, .. } = array;
    let scalar = match numbers {
        Numbers::Reals(_) => "Float64",
        Numbers::Integers(_) if name == "types" => "UInt8",
        Numbers::Integers(_) => "Int64",
    };
    let count = if *components > 1 { format!(" NumberOfComponents=\"{components}\"") } else { String::new() };
    let _ = writeln!(text, "        <DataArray type=\"{scalar}\" Name=\"{name}\"{count}{} format=\"ascii\">", component_names(name));
    let per_line = if *components > 1 { *components } else { PER_LINE };
    for start in (0..numbers.len()).step_by(per_line) {
        text.push_str("         ");
        for index in start..numbers.len().min(start + per_line) {
            let _ = match numbers {
                Numbers::Reals(values) if values[index].is_nan() => write!(text, " nan"),
                Numbers::Reals(values) => write!(text, " {:?}", values[index]),
                Numbers::Integers(values) => write!(text, " {}", values[index]),
            };
        }
        text.push('\n');
    }
    let unit = unit_tag(unit);
    let _ = if unit.is_empty() { writeln!(text, "        </DataArray>") } else { writeln!(text, "          {unit}\n        </DataArray>") };
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::reading::fields::fields_of;
    use super::super::samples::{block, ring};
    use super::super::vtu::Frame;
    use super::*;

    #[test]
    fn text_reads_back_as_the_same_frame() {
        let bytes = Frame::new(0.1 + 0.2, &[ring("outer ring", [1.0, 1.5], [3, 8]), block([2, 1, 1], [1.0; 3])]).encode();
        let frame = fields_of(Path::new("x"), &bytes).unwrap();
        let again = fields_of(Path::new("x"), vtu_text(&frame).as_bytes()).unwrap();
        // NaN differs from itself, so its text is compared.
        assert_eq!(format!("{again:?}"), format!("{frame:?}"));
    }
}
