//! Remedies for meshes.

use super::words::ScriptWords;
use crate::mesh::{FileProblem, MeshError};

impl ScriptWords for MeshError {
    fn remedy(&self) -> String {
        match self {
            MeshError::NothingShared => {
                "give both the same nodes along the common side; meshes that do not match are held together by `model.tie`".into()
            }
            MeshError::Unjoined { .. } => {
                "make their nodes one where the mesh is made (in Gmsh `Coherence;` before it is meshed, here `join`), or take what does \
                 not belong together as bodies of their own with `part`"
                    .into()
            }
            MeshError::CrossingSurface { .. } => {
                "a body fills no place twice: mend the surface before it is meshed, or take parts that overlap as bodies of their own with \
                 `part`"
                    .into()
            }
            MeshError::OnAxis { .. } => {
                "move the mesh away from the axis: cells on it would have no volume there; `cylinder`, `sphere` and `torus` have a core of \
                 cells on the axis"
                    .into()
            }
            MeshError::Revolution { .. } => "angles are in radians: write `deg(90)`".into(),
            MeshError::Turn { .. } => "angles are in radians and grow counter-clockwise; for a full turn use `ring`".into(),
            MeshError::OffCircle { .. } => {
                "give a center as far from the start as from the end, or a point `through` which the arc goes".into()
            }
            MeshError::NotLocally { kind: "tet4" | "hex8" | "tet10" | "hex20" | "hex27" } => {
                "refine all of it with `refine()`, or make the mesh finer where it was made; only triangles are refined in places".into()
            }
            MeshError::NotLocally { kind: "quad4" } => {
                "cut them into triangles with `.with_elements(\"tri3\")` before, refine all of it with `refine()`, or make it with \
                 `region` and a `size: |x, y| …`"
                    .into()
            }
            MeshError::NotLocally { .. } => {
                "make it of triangles (`element: \"tri6\"`), refine all of it with `refine()`, or make it with `region` and a `size: |x, \
                 y| …`"
                    .into()
            }
            MeshError::File(error) => match error.problem {
                FileProblem::Unreadable { .. } => "check the path and the rights; paths are relative to the folder of the script".into(),
                FileProblem::Included { .. } => {
                    "put it below the script's folder, or allow its folder with `--allow-read DIR`; its name is relative to the folder of \
                     the file that is read"
                        .into()
                }
                FileProblem::Shells { .. } => {
                    "mesh the volume of a thin part with solid cells; if these cells are meant to be plane ones, write `shells: \"plane\"`"
                        .into()
                }
                FileProblem::Structural { .. } => "take these elements out of the file, or write `skip: \"warn\"`".into(),
                FileProblem::MixedCells { .. } => {
                    "mesh all of it in one order (`Mesh.ElementOrder = 1;` or `2;` in Gmsh), or read each part by itself: `read_mesh(path, \
                     #{ part: \"name\" })`, every instance of an input file with `read_deck`"
                        .into()
                }
                _ => self.hint(),
            },
            MeshError::Included { error, .. } => error.remedy(),
            _ => self.hint(),
        }
    }
}
