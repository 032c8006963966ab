//! VTU: all bodies at one time as a VTK unstructured grid, for ParaView, PyVista and meshio.
//!
//! Points are the *undeformed* positions and `displacement` is a point field, so that ParaView's filter "Warp by Vector" shows the deformed
//! bodies at any magnification. Data follow the XML text as raw little-endian bytes in zlib blocks (VTK file formats, "XML file formats",
//! 2024: appended data with `vtkZLibDataCompressor`). A contact gap without an opposite surface is NaN. Names of the bodies are in a
//! comment, since meshio refuses files with text arrays; the cell field `body` counts bodies from 0.
//!
//! Rigid obstacles are separate files: bands of quadrilaterals behind their borders at their current positions (their points move, without
//! warping). The cell field `obstacle` counts them from 0.
//!
//! Secondary surfaces of contacts are separate files, too: straight facets as lines with the contact fields at their nodes, for each
//! contact alone, whereas the fields of a body have the sum over all contacts. The cell field `contact` counts contacts from 0; `body` and
//! `node` refer to the point in the fields.

use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::{Arc, OnceLock};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::markup::{comment, escaped};
use super::obstacle_surfaces::ObstacleSurface;
use super::obstacles::{Surroundings, Wall};
use super::reading::tags::UNITS_LABEL;
use super::units::ModelUnits;
use crate::dynamics::{BodyFields, ContactFields, ContactSurface, PlacedObstacle, field_dimension, principal};
use crate::elements::CellKind;

/// VTK's number of a line with two nodes.
const LINE: u8 = 3;

/// Number of bytes that are compressed together: the default of VTK, and a multiple of every scalar's size as required by meshio.
const BLOCK: usize = 32768;

/// Half length of the line by which a half plane is drawn, relative to the extent of the bodies: bodies may move along the plane.
const REACH: f64 = 10.0;

/// Size of planes, cylinders and cones in space, from the center of the bodies, relative to their extent.
const REACH_IN_SPACE: f64 = 1.5;

/// Compression level: level 6 makes files 8 % smaller in two to four times the time (bearing and a block of 144 000 cells).
const LEVEL: Compression = Compression::fast();

/// Components of symmetric tensors, in the order of VTK.
const TENSOR: &[&str] = &["xx", "yy", "zz", "xy", "yz", "xz"];

/// Principal values in descending order.
const PRINCIPAL: &[&str] = &["1", "2", "3"];

/// Attributes of the names of an array's components; empty for numbers and vectors.
pub(super) fn component_names(array: &str) -> String {
    let names = match array {
        "stress" | "strain" => TENSOR,
        "principal_stress" => PRINCIPAL,
        _ => &[],
    };
    names.iter().enumerate().map(|(k, name)| format!(" ComponentName{k}=\"{name}\"")).collect()
}

/// Name of the array of positions.
const POINTS: &str = "Points";

/// Tag of an array's unit, as VTK writes its key `vtkDataArray::UNITS_LABEL`; empty without a unit.
pub(super) fn unit_tag(unit: &str) -> String {
    if unit.is_empty() {
        return String::new();
    }
    format!("<InformationKey name=\"{UNITS_LABEL}\" location=\"vtkDataArray\">{}</InformationKey>", escaped(unit))
}

/// A named array of the file.
#[derive(Debug)]
struct Array {
    name: &'static str,
    scalar: &'static str,
    components: usize,
    bytes: Vec<u8>,
    /// Compressed blocks, created on first use.
    packed: OnceLock<Vec<u8>>,
}

impl Array {
    fn new(name: &'static str, scalar: &'static str, components: usize, bytes: Vec<u8>) -> Self {
        Array { name, scalar, components, bytes, packed: OnceLock::new() }
    }

    fn doubles<const N: usize>(name: &'static str, count: usize, values: impl Iterator<Item = [f64; N]>) -> Self {
        let mut bytes = Vec::with_capacity(8 * N * count);
        values.for_each(|value| value.iter().for_each(|number| bytes.extend_from_slice(&number.to_le_bytes())));
        Array::new(name, "Float64", N, bytes)
    }

    fn integers(name: &'static str, values: impl Iterator<Item = i64>) -> Self {
        let mut bytes = Vec::with_capacity(8 * values.size_hint().0);
        values.for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
        Array::new(name, "Int64", 1, bytes)
    }

    fn packed(&self) -> &[u8] {
        self.packed.get_or_init(|| packed(&self.bytes))
    }
}

/// Undeformed bodies, common to all frames of a simulation. The grid is compressed once, by the first frame that is encoded.
#[derive(Debug)]
pub struct Grid {
    /// Kind of the grid's parts: `body` or `obstacle`.
    kind: &'static str,
    names: Vec<String>,
    points: usize,
    cells: usize,
    position: Array,
    topology: Vec<Array>,
    cellwise: Vec<Array>,
}

impl Grid {
    /// Copies the data of the bodies for the files.
    pub fn new(bodies: &[BodyFields]) -> Self {
        let cells = || bodies.iter().flat_map(|body| body.mesh.cells_with_kinds());
        let first_node = |index: usize| bodies[..index].iter().map(|body| body.mesh.points.len()).sum::<usize>() as i64;
        let connectivity = bodies.iter().enumerate().flat_map(|(index, body)| {
            let first = first_node(index);
            body.mesh.connectivity().map(move |node| first + i64::from(node))
        });
        let offsets = cells().scan(0, |end, (_, cell)| {
            *end += cell.len() as i64;
            Some(*end)
        });
        let types = cells().map(|(kind, _)| kind.row().vtk_type).collect();
        let points = bodies.iter().map(|body| body.mesh.points.len()).sum();
        let body = bodies.iter().enumerate().flat_map(|(index, body)| std::iter::repeat_n(index as i64, body.mesh.cell_count()));
        Grid {
            kind: "body",
            names: bodies.iter().map(|body| body.name.clone()).collect(),
            points,
            cells: bodies.iter().map(|body| body.mesh.cell_count()).sum(),
            position: Array::doubles(POINTS, points, bodies.iter().flat_map(|body| body.mesh.points.iter().copied())),
            topology: vec![
                Array::integers("connectivity", connectivity),
                Array::integers("offsets", offsets),
                Array::new("types", "UInt8", 1, types),
            ],
            cellwise: vec![Array::integers("body", body)],
        }
    }
}

impl Grid {
    /// Returns the grid of surfaces with their names, points and facets.
    fn of_surfaces<'a>(kind: &'static str, surfaces: impl Iterator<Item = (&'a str, &'a [[f64; 3]], &'a [Vec<u32>])>) -> Self {
        let (mut names, mut position, mut connectivity) = (Vec::new(), Vec::new(), Vec::new());
        let (mut offsets, mut types, mut number) = (Vec::new(), Vec::new(), Vec::new());
        for (index, (name, points, facets)) in surfaces.enumerate() {
            let first = position.len() as i64;
            names.push(name.to_string());
            position.extend_from_slice(points);
            for facet in facets {
                connectivity.extend(facet.iter().map(|&node| first + i64::from(node)));
                offsets.push(connectivity.len() as i64);
                types.push(match facet.len() {
                    2 => LINE,
                    3 => CellKind::Tri3.row().vtk_type,
                    _ => CellKind::Quad4.row().vtk_type,
                });
                number.push(index as i64);
            }
        }
        Grid {
            kind,
            names,
            points: position.len(),
            cells: types.len(),
            position: Array::doubles(POINTS, position.len(), position.into_iter()),
            topology: vec![
                Array::integers("connectivity", connectivity.into_iter()),
                Array::integers("offsets", offsets.into_iter()),
                Array::new("types", "UInt8", 1, types),
            ],
            cellwise: vec![Array::integers(kind, number.into_iter())],
        }
    }
}

/// All bodies at one time as plain bytes: taking a frame is quick, and another thread can encode and write it.
#[derive(Debug)]
pub struct Frame {
    time: f64,
    grid: Arc<Grid>,
    /// Names of the default scalars, vectors and tensors, for readers that show only one of each.
    shown: &'static str,
    nodal: Vec<Array>,
    /// Units of the values; `None` where none are declared.
    units: Option<Arc<ModelUnits>>,
}

impl Frame {
    /// Copies the data for the file.
    pub fn new(time: f64, bodies: &[BodyFields]) -> Self {
        Frame::on(Arc::new(Grid::new(bodies)), time, bodies)
    }

    /// Returns a frame of rigid obstacles at their positions at `time`, drawn beside bodies as large as `around`.
    pub fn of_obstacles(time: f64, obstacles: &[PlacedObstacle], around: &Surroundings) -> Self {
        let of_wall = |wall: Wall| {
            let pieces: Vec<[[f64; 2]; 4]> = wall.pieces().collect();
            let points = pieces.as_flattened().iter().map(|&[x, y]| [x, y, 0.0]).collect();
            let facets = (0..pieces.len() as u32).map(|piece| (4 * piece..4 * piece + 4).collect()).collect();
            ObstacleSurface { name: wall.name, points, facets }
        };
        let surface = |obstacle: &PlacedObstacle| {
            ObstacleSurface::new(obstacle, around, REACH_IN_SPACE).or_else(|| Wall::new(obstacle, around, REACH).map(of_wall))
        };
        let surfaces: Vec<ObstacleSurface> = obstacles.iter().filter_map(surface).collect();
        let parts = surfaces.iter().map(|surface| (&*surface.name, &*surface.points, &*surface.facets));
        let grid = Grid::of_surfaces("obstacle", parts);
        Frame { time, grid: Arc::new(grid), shown: "", nodal: Vec::new(), units: None }
    }

    /// Returns a frame of the secondary surfaces of contacts.
    pub fn of_contacts(time: f64, surfaces: &[ContactSurface]) -> Self {
        let grid = Grid::of_surfaces("contact", surfaces.iter().map(|surface| (&*surface.name, &*surface.points, &*surface.facets)));
        let count = grid.points;
        let scalars = |name, of: fn(&ContactFields) -> &[f64]| {
            Array::doubles(name, count, surfaces.iter().flat_map(move |surface| of(&surface.fields).iter().map(|&value| [value])))
        };
        let displacement = surfaces.iter().flat_map(|surface| {
            let places = surface.fields.positions.iter().zip(&surface.points);
            places.map(|(now, start)| std::array::from_fn::<f64, 3, _>(|i| now[i] - start[i]))
        });
        let active = surfaces.iter().flat_map(|surface| surface.fields.active.iter().map(|&active| [f64::from(u8::from(active))]));
        let state = surfaces.iter().flat_map(|surface| surface.fields.state.iter().map(|&state| [f64::from(state as u8)]));
        let nodes = || surfaces.iter().flat_map(|surface| &surface.nodes);
        let nodal = vec![
            Array::doubles("displacement", count, displacement),
            scalars("contact_pressure", |fields| &fields.pressure),
            scalars("contact_gap", |fields| &fields.gap),
            Array::doubles("contact_force", count, surfaces.iter().flat_map(|surface| surface.fields.forces.iter().copied())),
            Array::doubles("contact_active", count, active),
            Array::doubles("contact_state", count, state),
            scalars("contact_shear", |fields| &fields.shear),
            scalars("contact_slip", |fields| &fields.slip),
            scalars("contact_slip_path", |fields| &fields.slip_path),
            scalars("contact_heat", |fields| &fields.heat),
            Array::integers("body", nodes().map(|&(body, _)| body as i64)),
            Array::integers("node", nodes().map(|&(_, node)| node as i64)),
        ];
        Frame { time, grid: Arc::new(grid), shown: " Scalars=\"contact_pressure\" Vectors=\"displacement\"", nodal, units: None }
    }

    /// Copies the data for the file, except those in the grid of the bodies.
    pub fn on(grid: Arc<Grid>, time: f64, bodies: &[BodyFields]) -> Self {
        let count = grid.points;
        let scalars = |name, of: fn(&BodyFields) -> &[f64]| {
            Array::doubles(name, count, bodies.iter().flat_map(move |body| of(body).iter().map(|&value| [value])))
        };
        let vectors = |name, of: fn(&BodyFields) -> &[[f64; 3]]| {
            Array::doubles(name, count, bodies.iter().flat_map(move |body| of(body).iter().copied()))
        };
        let von_mises = bodies.iter().flat_map(|body| (0..body.stress.len()).map(|node| [body.von_mises(node)]));
        let principal_stresses = bodies.iter().flat_map(|body| body.stress.iter().map(|stress| principal(stress).values));
        let flow = [scalars("plastic_strain", |body| &body.plastic_strain), scalars("back_stress", |body| &body.back_stress)];
        let mut nodal = vec![
            vectors("displacement", |body| &body.displacement),
            vectors("velocity", |body| &body.velocity),
            vectors("acceleration", |body| &body.acceleration),
            Array::doubles("stress", count, bodies.iter().flat_map(|body| body.stress.iter().copied())),
            Array::doubles("strain", count, bodies.iter().flat_map(|body| body.strain.iter().copied())),
            Array::doubles("principal_stress", count, principal_stresses),
            scalars("energy_density", |body| &body.energy_density),
            Array::doubles("von_mises", count, von_mises),
            scalars("stress_error", |body| &body.stress_error),
            scalars("contact_pressure", |body| &body.contact_pressure),
            scalars("contact_gap", |body| &body.contact_gap),
            vectors("contact_force", |body| &body.contact_force),
            scalars("contact_active", |body| &body.contact_active),
            scalars("contact_state", |body| &body.contact_state),
        ];
        nodal.extend(flow.into_iter().filter(|_| bodies.iter().any(|body| body.flows)));
        Frame { time, grid, shown: " Scalars=\"von_mises\" Vectors=\"displacement\" Tensors=\"stress\"", nodal, units: None }
    }

    /// The frame with the units of its values.
    pub fn in_units(self, units: Option<Arc<ModelUnits>>) -> Self {
        Frame { units, ..self }
    }

    /// Tags of the unit of an array.
    fn unit_tag(&self, name: &str) -> String {
        let dimension = if name == POINTS { "length" } else { field_dimension(name) };
        let unit = self.units.as_ref().map_or(String::new(), |units| units.unit(dimension));
        unit_tag(&unit)
    }

    /// Time of the frame.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Encodes the file.
    pub fn encode(&self) -> Vec<u8> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n",
        );
        let mut blob = Vec::new();
        let mut section = |text: &mut String, tag: &str, arrays: &[Array]| {
            let tag_name = tag.split(' ').next().unwrap_or(tag);
            let _ = writeln!(text, "      <{tag}>");
            for array @ Array { name, scalar, components, .. } in arrays {
                // meshio makes a column matrix of an array with `NumberOfComponents="1"`.
                let mut count = if *components > 1 { format!(" NumberOfComponents=\"{components}\"") } else { String::new() };
                count.push_str(&component_names(name));
                let offset = blob.len();
                let _ = write!(text, "        <DataArray type=\"{scalar}\" Name=\"{name}\"{count} format=\"appended\" offset=\"{offset}\"");
                let unit = self.unit_tag(name);
                let _ = if unit.is_empty() { writeln!(text, "/>") } else { writeln!(text, ">{unit}</DataArray>") };
                blob.extend_from_slice(array.packed());
            }
            let _ = writeln!(text, "      </{tag_name}>");
        };
        for (index, name) in self.grid.names.iter().enumerate() {
            let _ = writeln!(text, "  <!-- {} {index}: {} -->", self.grid.kind, comment(name));
        }
        let _ = writeln!(text, "  <UnstructuredGrid>");
        let _ = writeln!(text, "    <FieldData>");
        let _ = writeln!(
            text,
            "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:?}</DataArray>",
            self.time
        );
        let _ = writeln!(text, "    </FieldData>");
        let _ = writeln!(text, "    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", self.grid.points, self.grid.cells);
        section(&mut text, "Points", std::slice::from_ref(&self.grid.position));
        section(&mut text, "Cells", &self.grid.topology);
        if !self.nodal.is_empty() {
            section(&mut text, &format!("PointData{}", self.shown), &self.nodal);
        }
        section(&mut text, "CellData", &self.grid.cellwise);
        let _ = write!(text, "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _");
        let mut bytes = text.into_bytes();
        bytes.append(&mut blob);
        // meshio cuts the data at the last line end before the closing tag.
        bytes.extend_from_slice(b"\n  </AppendedData>\n</VTKFile>\n");
        bytes
    }
}

/// Encodes an array in VTK's format: number of blocks, size of a block, size of the last one if incomplete, compressed sizes, blocks.
fn packed(bytes: &[u8]) -> Vec<u8> {
    let blocks: Vec<Vec<u8>> = bytes
        .chunks(BLOCK)
        .map(|block| {
            let mut encoder = ZlibEncoder::new(Vec::new(), LEVEL);
            // Writing to memory does not fail.
            let _ = encoder.write_all(block);
            encoder.finish().unwrap_or_default()
        })
        .collect();
    let head = [blocks.len(), BLOCK, bytes.len() % BLOCK];
    let mut packed = Vec::new();
    for number in head.into_iter().chain(blocks.iter().map(Vec::len)) {
        packed.extend_from_slice(&(number as u64).to_le_bytes());
    }
    blocks.iter().for_each(|block| packed.extend_from_slice(block));
    packed
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use flate2::read::ZlibDecoder;

    use super::super::samples::{block, ring};
    use super::*;
    use crate::contact::{Obstacle, ObstaclePlacement};
    use crate::dynamics::NodeState;
    use crate::mesh::read_mesh_bytes;

    /// The bytes of a named array, found by its offset in the text and inflated block by block.
    fn array(file: &[u8], name: &str) -> (usize, Vec<u8>) {
        let start = file.windows(4).position(|window| window == b"   _").unwrap() + 4;
        let text = std::str::from_utf8(&file[..start]).unwrap();
        let tag = text.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
        let attribute =
            |key: &str| tag.split(&format!("{key}=\"")).nth(1).map(|rest| rest.split('"').next().unwrap().parse::<usize>().unwrap());
        let data = &file[start + attribute("offset").unwrap()..];
        let number = |index: usize| u64::from_le_bytes(data[8 * index..8 * index + 8].try_into().unwrap()) as usize;
        let (count, size, last) = (number(0), number(1), number(2));
        let mut at = 8 * (3 + count);
        let mut bytes = Vec::new();
        for index in 0..count {
            let mut inflated = Vec::new();
            ZlibDecoder::new(&data[at..at + number(3 + index)]).read_to_end(&mut inflated).unwrap();
            assert_eq!(inflated.len(), if index + 1 == count && last > 0 { last } else { size });
            bytes.append(&mut inflated);
            at += number(3 + index);
        }
        (attribute("NumberOfComponents").unwrap_or(1), bytes)
    }

    fn doubles(file: &[u8], name: &str) -> Vec<f64> {
        array(file, name).1.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
    }

    fn integers(file: &[u8], name: &str) -> Vec<i64> {
        array(file, name).1.chunks_exact(8).map(|bytes| i64::from_le_bytes(bytes.try_into().unwrap())).collect()
    }

    #[test]
    fn arrays_read_back_bit_by_bit() {
        // Large enough for more than one block per array, with a second body that has its own node numbers.
        let bodies = [ring("outer ring", [1.0, 1.5], [40, 80]), ring("inner -- ring", [0.5, 1.0], [2, 9])];
        let file = Frame::new(0.25, &bodies).encode();
        let joined = |values: fn(&BodyFields) -> Vec<f64>| bodies.iter().flat_map(values).map(f64::to_bits).collect::<Vec<_>>();
        let bits = |name: &str| doubles(&file, name).into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits("Points"), joined(|body| body.mesh.points.concat()));
        assert_eq!(bits("displacement"), joined(|body| body.displacement.concat()));
        assert_eq!(bits("velocity"), joined(|body| body.velocity.concat()));
        assert_eq!(bits("stress"), joined(|body| body.stress.concat()));
        assert_eq!(bits("von_mises"), joined(|body| (0..body.stress.len()).map(|node| body.von_mises(node)).collect()));
        assert_eq!(bits("contact_pressure"), joined(|body| body.contact_pressure.clone()));
        assert_eq!(bits("contact_gap"), joined(|body| body.contact_gap.clone()));
        assert_eq!(bits("contact_force"), joined(|body| body.contact_force.concat()));
        assert_eq!(bits("contact_active"), joined(|body| body.contact_active.clone()));
        let components = ["Points", "displacement", "velocity", "stress", "von_mises", "body"].map(|name| array(&file, name).0);
        assert_eq!(components, [3, 3, 3, 6, 1, 1]);

        let connectivity = integers(&file, "connectivity");
        let first = bodies[0].mesh.points.len() as i64;
        assert_eq!(connectivity.len(), 4 * (40 * 80 + 2 * 9));
        assert_eq!(
            connectivity[4 * 40 * 80..][..4],
            bodies[1].mesh.cell(0).iter().map(|&node| first + i64::from(node)).collect::<Vec<_>>()
        );
        assert_eq!(integers(&file, "offsets").last(), Some(&(connectivity.len() as i64)));
        assert!(array(&file, "types").1.iter().all(|&kind| kind == 9));
        assert_eq!(integers(&file, "body").iter().filter(|&&body| body == 1).count(), 18);
        let text = String::from_utf8_lossy(&file);
        assert!(
            text.contains("<!-- body 0: outer ring -->") && text.contains("Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">0.25<")
        );
        let head = text.split("<AppendedData").next().unwrap();
        assert_eq!(head.matches("--").count(), 4, "only the comments' own hyphens");
    }

    #[test]
    fn frames_on_one_grid_are_the_same_files() {
        let mut bodies = [ring("outer ring", [1.0, 1.5], [4, 8]), ring("inner ring", [0.5, 1.0], [2, 9])];
        let grid = Arc::new(Grid::new(&bodies));
        for time in [0.0, 0.5] {
            bodies[1].displacement[3] = [time, 0.0, -time];
            assert_eq!(Frame::on(grid.clone(), time, &bodies).encode(), Frame::new(time, &bodies).encode());
        }
    }

    #[test]
    fn hexahedra_and_nothing_at_all_are_written_too() {
        let file = Frame::new(0.0, &[block([2, 3, 4], [1.0, 1.0, 1.0])]).encode();
        assert_eq!(array(&file, "types").1, [12; 24]);
        assert_eq!(integers(&file, "offsets")[..3], [8, 16, 24]);
        assert!(String::from_utf8_lossy(&Frame::new(0.0, &[]).encode()).contains("NumberOfPoints=\"0\" NumberOfCells=\"0\""));
    }

    fn moved(translation: [f64; 3]) -> ObstaclePlacement {
        ObstaclePlacement { translation, ..ObstaclePlacement::default() }
    }

    #[test]
    fn obstacles_are_quadrilaterals_that_move() {
        let shape = Obstacle::Polyline { points: vec![[4.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]] };
        let stairs = PlacedObstacle { name: "stairs".into(), shape, place: moved([0.25, 0.0, 0.0]) };
        let ground = Obstacle::HalfPlane { point: [0.0, 0.0], normal: [0.0, 1.0] };
        let ground = PlacedObstacle { name: "ground".into(), shape: ground, place: moved([0.0; 3]) };
        let around = Surroundings::of_bodies(&[ring("ring", [1.0, 1.5], [2, 12])]);
        let file = Frame::of_obstacles(0.5, &[stairs, ground], &around).encode();
        assert_eq!(array(&file, "types").1, [9; 4]);
        assert_eq!(integers(&file, "obstacle"), [0, 0, 0, 1]);
        let bytes = array(&file, "Points").1;
        let number = |k: usize| f64::from_le_bytes(bytes[8 * k..8 * (k + 1)].try_into().unwrap());
        assert_eq!([number(0), number(1), number(2), number(3), number(4)], [4.25, 0.0, 0.0, 2.25, 0.0]);
        let text = String::from_utf8_lossy(&file);
        assert!(text.contains("<!-- obstacle 0: stairs -->") && text.contains("<!-- obstacle 1: ground -->"));
    }

    #[test]
    fn a_frame_reads_back_as_the_meshes_of_its_bodies() {
        for bodies in [
            [ring("outer ring", [1.0, 1.5], [2, 16]), ring("inner: 2", [0.5, 1.0], [1, 9])],
            [block([2, 1, 1], [1.0; 3]), block([1, 2, 3], [9.0; 3])],
        ] {
            let mut bodies = bodies;
            bodies[1].name = "second".into();
            let mesh = read_mesh_bytes(&Frame::new(0.0, &bodies).encode()).unwrap();
            assert_eq!(mesh.parts.len(), 2);
            for body in &bodies {
                let part = mesh.part(&body.name).unwrap();
                assert_eq!((&part.points, &part.blocks), (&body.mesh.points, &body.mesh.blocks), "{}", body.name);
            }
        }
    }

    #[test]
    fn a_smooth_field_is_compressed() {
        let bodies = [ring("ring", [1.0, 1.5], [40, 80])];
        let frame = Frame::new(0.0, &bodies);
        let grid = &frame.grid;
        let arrays = grid.topology.iter().chain(&frame.nodal).chain([&grid.position]).chain(&grid.cellwise);
        let raw: usize = arrays.map(|array| array.bytes.len()).sum();
        let packed = frame.encode().len();
        assert!(3 * packed < 2 * raw, "{packed} of {raw}");
    }

    #[test]
    fn surfaces_are_lines_with_what_contact_does() {
        let surface = |name: &str, body: usize, x: f64| ContactSurface {
            name: name.into(),
            nodes: (0..3).map(|node| (body, 7 - node)).collect(),
            facets: vec![vec![0, 1], vec![1, 2]],
            points: (0..3).map(|node| [x + node as f64, 0.0, 0.0]).collect(),
            fields: ContactFields {
                positions: (0..3).map(|node| [x + node as f64, 0.25, 0.0]).collect(),
                pressure: vec![1.0, 2.0, x],
                gap: vec![0.0, 0.1 + 0.2, f64::NAN],
                mean_pressure: vec![1.0, 2.0, x],
                active: vec![true, true, false],
                state: vec![NodeState::Stick, NodeState::Slip, NodeState::Open],
                shear: vec![0.25, -0.5, 0.0],
                slip: vec![0.0, 0.125, 0.0],
                slip_path: vec![0.0, 0.375, x],
                heat: vec![0.0, 0.75, 0.0],
                forces: vec![[0.0, x, 0.0]; 3],
                force: [0.0, 3.0 * x, 0.0],
                normal_force: 3.0 * x,
                area: 1.0,
                sliding: 1,
            },
        };
        let file = Frame::of_contacts(0.5, &[surface("race", 0, 4.0), surface("lip", 1, 8.0)]).encode();
        assert_eq!(integers(&file, "connectivity"), [0, 1, 1, 2, 3, 4, 4, 5]);
        assert_eq!((integers(&file, "offsets"), array(&file, "types").1), (vec![2, 4, 6, 8], vec![3; 4]));
        assert_eq!((integers(&file, "contact"), integers(&file, "body")), (vec![0, 0, 1, 1], vec![0, 0, 0, 1, 1, 1]));
        assert_eq!(integers(&file, "node"), [7, 6, 5, 7, 6, 5]);
        assert_eq!(doubles(&file, "displacement"), [[0.0, 0.25, 0.0]; 6].concat());
        assert_eq!(doubles(&file, "contact_pressure"), [1.0, 2.0, 4.0, 1.0, 2.0, 8.0]);
        assert_eq!(doubles(&file, "contact_active"), [1.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
        assert!(doubles(&file, "contact_gap")[2].is_nan());
        assert_eq!(doubles(&file, "contact_state"), [1.0, 2.0, 0.0, 1.0, 2.0, 0.0]);
        assert_eq!(doubles(&file, "contact_shear"), [[0.25, -0.5, 0.0]; 2].concat());
        assert_eq!(doubles(&file, "contact_slip_path"), [0.0, 0.375, 4.0, 0.0, 0.375, 8.0]);
        assert_eq!(doubles(&file, "contact_heat"), [[0.0, 0.75, 0.0]; 2].concat());
        assert!(String::from_utf8_lossy(&file).contains("<!-- contact 1: lip -->"));
    }
}
