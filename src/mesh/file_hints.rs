//! Hints on mending mesh files, one sentence for each problem.

use super::file_error::FileProblem;

impl FileProblem {
    /// Returns a hint on mending the file, one sentence.
    pub fn hint(&self) -> String {
        use FileProblem::*;
        match self {
            Unreadable { .. } => "check the path and the rights",
            NotText => "save the file again as ASCII or as binary: a text file must be UTF-8",
            OtherFormat { found } if found.contains("HDF5") || found.contains("NetCDF") => {
                "convert it to VTU: `meshio convert name.med name.vtu` in a terminal, with the Python package meshio"
            }
            OtherFormat { .. } => {
                "save it as Gmsh MSH 4.1 (`Mesh.MshFileVersion = 4.1;`), as an Abaqus or CalculiX input file (`.inp`), as VTU, VTK, \
                 Medit `.mesh`, UNV, Nastran bulk data or SU2"
            }
            Form { cure, .. } => cure,
            NumberSize { .. } | ByteOrder => "the file is damaged: write it again, or as ASCII (`Mesh.Binary = 0;` in Gmsh)",
            Version { .. } => "save it with `Mesh.MshFileVersion = 4.1;` (or 2.2) in Gmsh",
            Truncated { .. } | MissingSection { .. } => "the file is incomplete: write or copy it again",
            Count { .. }
            | RepeatedSection { .. }
            | DuplicateNode { .. }
            | MissingNode { .. }
            | UnknownEntity { .. }
            | Malformed { .. }
            | Undecodable { .. } => "the file is damaged or was edited by hand: write it again with the program that made it",
            DuplicateElement { .. } => "number the elements of a part without repetition",
            Coordinate { .. } => "give every node finite coordinates",
            DuplicateCell { .. } => "remove one of them; overlapping surfaces in Gmsh are meshed twice unless they are made coherent",
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
            Keyword { keyword, .. } if keyword == "INCLUDE" => "put the lines of the other file in the place of the keyword",
            Keyword { .. } => "write the file again with the nodes and elements themselves",
            Included { .. } => "put it below the folder of the file that includes it",
            Shells { .. } => {
                "mesh the volume of a thin part with solid cells; a plane part is written with plane cells (CPS4, CPE4 or CAX4 in place of \
                 S4)"
            }
            Structural { .. } => "take these elements out of the file, or let them be left out",
            MissingParameter { .. } => "write the parameter behind the keyword, such as `*ELEMENT, TYPE=CPS4`",
            UnknownSet { .. } => "define the set before it is used, or correct its name",
            UnknownMember { .. } => "correct the number, or write the file again with the program that made it",
            UnknownSide { .. } => "sides of plane cells are S1 to S4, of solid cells S1 to S6 (tetrahedra: S4, wedges and pyramids: S5)",
        }
        .into()
    }
}
