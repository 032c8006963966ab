//! Hints on mending mesh files, one sentence for each problem.

use super::file_error::FileProblem;

impl FileProblem {
    /// Returns a hint on mending the file, one sentence.
    pub fn hint(&self) -> String {
        use FileProblem::*;
        match self {
            Unreadable { .. } => "check the path and the rights",
            NotText => "save the file again as ASCII or as binary: a text file must be UTF-8",
            OtherFormat { found } => hint_of_format(found),
            Form { cure, .. } => cure,
            NumberSize { .. } | ByteOrder => "the file is damaged: write it again, or as ASCII (`Mesh.Binary = 0;` in Gmsh)",
            Version { .. } => "save it with `Mesh.MshFileVersion = 4.1;` (or 2.2) in Gmsh",
            Truncated { .. } | MissingSection { .. } => "the file is incomplete: write or copy it again",
            Count { .. }
            | RepeatedSection { .. }
            | DuplicateNode { .. }
            | MissingNode { .. }
            | UnknownEntity { .. }
            | Undecodable { .. } => "the file is damaged or was edited by hand: write it again with the program that made it",
            Malformed { .. } => "write there what is expected; a file that was not edited by hand is damaged: write or copy it again",
            DuplicateElement { .. } => "number the elements of a part without repetition",
            Coordinate { .. } => "give every node finite coordinates",
            DuplicateCell { .. } => "remove one of them; overlapping surfaces in Gmsh are meshed twice unless they are made coherent",
            Collapsed { smaller, .. } if smaller.is_empty() => "give each cell distinct nodes",
            Collapsed { smaller, .. } if smaller.len() == 1 => "repeat two corners that follow each other, or name distinct nodes",
            Collapsed { .. } => {
                "repeat nodes so that whole edges or faces collapse, of second order with the middle node of each collapsed edge, or \
                 divide the cell where the mesh is made: a hexahedron with one collapsed edge is a wedge and a pyramid"
            }
            FewNodes { .. } => "write all nodes of the element; a line that ends with a comma goes on in the next one",
            UnsupportedCell { kind, .. } if kind.contains("third order") => {
                "mesh with cells of first or second order (`Mesh.ElementOrder = 2;` in Gmsh)"
            }
            UnsupportedCell { .. } => {
                "mesh with cells of first order, or of second order with nodes in the middle of edges alone (`Mesh.ElementOrder = 2;` \
                 with `Mesh.SecondOrderIncomplete = 1;` in Gmsh)"
            }
            UnsupportedType { .. } => {
                "use plane cells (CPS3, CPE4, CPE6, CPS8 with any letters behind), C3D4, C3D5, C3D6, C3D8, C3D10, C3D15, C3D20 or C3D27, \
                 and T3D2 or T3D3 for lines of boundaries"
            }
            MixedCells { .. } => {
                "mesh all of it in one order (`Mesh.ElementOrder = 1;` or `2;` in Gmsh), or save the parts of each order in files of \
                 their own"
            }
            MixedDimensions { .. } => "save plane and solid bodies in files of their own",
            NoCells { .. } => {
                "mesh surfaces (`Mesh 2;` in Gmsh) or volumes (`Mesh 3;`), and put them into a physical group: Gmsh saves nothing else \
                 once there is one"
            }
            StrayFacet { .. } => {
                "take the element out of the group, or mesh the surface that it bounds; curves that are only drawn on top of a surface are \
                 not part of its mesh, and its elements must be of the cells' order"
            }
            NotPlane { .. } => "move the mesh into the plane z = 0, or mesh a volume",
            AmbiguousName { .. } => "give each physical group its own name",
            Keyword { reason, .. } if reason.contains("another file") => "put the lines of the other file in the place of the keyword",
            Keyword { keyword, .. } => hint_of_keyword(keyword),
            Included { reason, .. } if reason.contains("include") && !reason.contains("folder") => {
                "write the lines of the files in fewer files, each included once"
            }
            Included { .. } => "put it below the folder of the file that includes it",
            Shells { .. } => {
                "mesh the volume of a thin part with solid cells; a plane part is written with plane cells (CPS4, CPE4 or CAX4 in place of \
                 S4)"
            }
            Structural { .. } => "take these elements out of the file, or let them be left out",
            MissingParameter { keyword, parameter } => {
                return format!("write the parameter behind the keyword: `*{keyword}, {parameter}=…`");
            }
            UnknownSet { kind, .. } => return format!("define the {kind} before it is used, or correct its name"),
            UnknownMember { .. } => "correct the number, or write the file again with the program that made it",
            UnknownSide { .. } => "sides of plane cells are S1 to S4, of solid cells S1 to S6 (tetrahedra: S4, wedges and pyramids: S5)",
        }
        .into()
    }
}

/// Hint on a file of another format.
fn hint_of_format(found: &str) -> &'static str {
    let is_any = |names: &[&str]| names.iter().any(|name| found.contains(name));
    if is_any(&["HDF5", "NetCDF"]) {
        "convert it to VTU: `meshio convert name.med name.vtu` in a terminal, with the Python package meshio"
    } else if is_any(&["materials and instances"]) {
        "read it as a mesh: only input files of Abaqus and CalculiX have materials and instances"
    } else if is_any(&["STEP", "geometry"]) {
        "mesh it first: `gmsh -3` with its name in a terminal, in the plane `gmsh -2`"
    } else if is_any(&["STL", "OFF", "PLY"]) {
        "the file has a surface without cells: mesh its volume, in Gmsh or in FreeCAD; a rigid surface is an obstacle"
    } else {
        "save it as Gmsh MSH 4.1 (`Mesh.MshFileVersion = 4.1;`), as an Abaqus or CalculiX input file (`.inp`), as VTU, VTK, Medit \
         `.mesh`, UNV, Nastran bulk data or SU2"
    }
}

/// Hint on a keyword of an input file that is not read.
fn hint_of_keyword(keyword: &str) -> &'static str {
    match keyword {
        "INSTANCE" => "give each instance a name of its own, and a part of the file",
        "SURFACE" => "list the sides of all these surfaces under one keyword",
        "PARAMETER" => "write the numbers in the place of the parameters",
        "NODE" | "SYSTEM" => "write all nodes in rectangular, global coordinates",
        _ => "write the file again with the nodes and elements themselves",
    }
}
