//! A frame as a multiblock file (`.vtm`) of VTK: one file for each body, obstacle or contact, as a block with its name.

use std::fmt::Write as _;

use super::markup::escaped;
use super::reading::fields::{ArrayRead, FieldsRead, Numbers, Section};

/// Frame of one part alone, with the nodes of its cells in their order.
pub fn part(frame: &FieldsRead, index: usize) -> FieldsRead {
    let of_cells = frame.array(Section::CellData, &frame.kind).map(|array| &array.numbers);
    let is_of_part = |cell: &usize| of_cells.is_none_or(|numbers| numbers.at(*cell) == index as f64);
    let cells: Vec<usize> = (0..frame.cells).filter(is_of_part).collect();
    let all: Vec<(u8, &[i64])> = frame.cells().collect();
    let mut nodes: Vec<usize> = cells.iter().flat_map(|&cell| all[cell].1.iter().map(|&node| node as usize)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let place = |node: i64| nodes.binary_search(&(node as usize)).unwrap_or_default() as i64;
    let topology = |name: &str| match name {
        "connectivity" => cells.iter().flat_map(|&cell| all[cell].1.iter().map(|&node| place(node))).collect(),
        "types" => cells.iter().map(|&cell| i64::from(all[cell].0)).collect(),
        _ => cells
            .iter()
            .scan(0, |end, &cell| {
                *end += all[cell].1.len() as i64;
                Some(*end)
            })
            .collect(),
    };
    let arrays = frame.arrays.iter().map(|array| {
        let numbers = match array.section {
            Section::Points | Section::PointData => chosen(array, &nodes),
            Section::CellData => chosen(array, &cells),
            Section::Cells => Numbers::Integers(topology(&array.name)),
        };
        ArrayRead { numbers, ..array.clone() }
    });
    FieldsRead {
        time: frame.time,
        kind: frame.kind.clone(),
        parts: frame.parts.get(index).cloned().into_iter().collect(),
        points: nodes.len(),
        cells: cells.len(),
        arrays: arrays.collect(),
    }
}

/// Values of an array at some points or cells.
fn chosen(array: &ArrayRead, places: &[usize]) -> Numbers {
    let entries = places.iter().flat_map(|&place| place * array.components..(place + 1) * array.components);
    match &array.numbers {
        Numbers::Reals(values) => Numbers::Reals(entries.map(|entry| values[entry]).collect()),
        Numbers::Integers(values) => Numbers::Integers(entries.map(|entry| values[entry]).collect()),
    }
}

/// Text of the multiblock file of named blocks with their files.
pub fn vtm(blocks: &[(String, String)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\">\n  \
         <vtkMultiBlockDataSet>\n",
    );
    for (index, (name, file)) in blocks.iter().enumerate() {
        let _ = writeln!(text, "    <DataSet index=\"{index}\" name=\"{}\" file=\"{}\"/>", escaped(name), escaped(file));
    }
    text + "  </vtkMultiBlockDataSet>\n</VTKFile>\n"
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::reading::fields::fields_of;
    use super::super::samples::{block, ring};
    use super::super::vtu::Frame;
    use super::super::vtu_text::vtu_text;
    use super::*;

    #[test]
    fn parts_are_the_frames_of_the_bodies_alone() {
        let bodies = [ring("outer ring", [1.0, 1.5], [3, 8]), block([2, 1, 1], [1.0; 3])];
        let read = |bodies: &[_]| fields_of(Path::new("x"), &Frame::new(0.5, bodies).encode()).unwrap();
        let both = read(&bodies);
        for (index, body) in bodies.iter().enumerate() {
            let alone = read(std::slice::from_ref(body));
            let text = |frame: &FieldsRead| {
                // A part keeps its body number, so that the array `body` differs.
                let arrays = frame.arrays.iter().filter(|array| array.name != "body").cloned().collect();
                vtu_text(&FieldsRead { arrays, ..frame.clone() })
            };
            assert_eq!(text(&part(&both, index)), text(&alone));
        }
        let text = vtm(&[("a \"b\"".into(), "x/0.vtu".into())]);
        assert!(text.contains("<DataSet index=\"0\" name=\"a &quot;b&quot;\" file=\"x/0.vtu\"/>"), "{text}");
    }
}
