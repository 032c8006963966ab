//! Hints on mending meshes, one sentence for each error.

use super::error::MeshError;

impl MeshError {
    /// Returns a hint on mending the mesh, one sentence.
    pub fn hint(&self) -> String {
        use MeshError::*;
        match self {
            NotPositive { what: "a scale factor", .. } => "scale by positive numbers; a mirrored mesh would be inside out".into(),
            NotPositive { what, .. } => format!("choose {what} greater than 0"),
            NotFinite { what, .. } => format!("give {what} as a finite number"),
            FewCorners { .. } => "name the corners in their order around the polygon, the first one once".into(),
            HoleOutside { .. } => "move it inside, so that its sides meet neither the outline nor another hole".into(),
            JoinedKinds { .. } => "join plane meshes or solid ones, all of first order or all of second order".into(),
            NothingShared => "give both the same nodes along the common side; meshes that do not match are held together by a tie".into(),
            CrossingSides { .. } => "name the corners in their order around the polygon, so that its sides meet at corners only".into(),
            EmptySide { .. } => "leave out one of the two corners".into(),
            NoTriangulation => "check that no two of its sides nearly coincide, or choose smaller cells".into(),
            NotMultiple { count, of, .. } => {
                format!("ask for {} or {}", count / of * of, (count / of + 1) * of).replace("ask for 0 or ", "ask for ")
            }
            TooFewCells { least, .. } => format!("ask for {least} or more"),
            TooManyCells { .. } => "use a coarser mesh".into(),
            Memory { .. } => "use a coarser mesh, or allow the program more memory".into(),
            NoConversion { .. } => {
                "cells of first order become those of second order of their shape, quad4 cells tri3 or tri6 as well, hex8 cells \
                 tetrahedra, wedges or pyramids of either order; make the mesh of those"
                    .into()
            }
            Radii { .. } => "exchange the two radii, or make the ring thicker".into(),
            Turn { .. } => "angles are in radians and grow counter-clockwise; for a full turn make a closed ring".into(),
            OffCircle { .. } => "give a center as far from the start as from the end, or a point through which the arc goes".into(),
            StraightArc => "move the middle point off the line, or use a straight line".into(),
            FewPoints { .. } => "name more points, each once; a closed spline ends at its first point".into(),
            OpenOutline { .. } => "name the curves in their order around the outline".into(),
            CrossingCurves { .. } => "let curves meet at their ends only; where they come close, smaller cells keep them apart".into(),
            UnknownLayers { name, available } => match nearest_name(name, available) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "use one of these names".into(),
            },
            LayersCollide { .. } => "take fewer or thinner layers, or a smaller growth, so that something is left between them".into(),
            LayersCramped { .. } => "take thinner layers, which leave more between them, or smaller cells there".into(),
            LayerCorner { .. } => "layers go round corners of 30 to 330 degrees: round it off, or leave out one of its sides".into(),
            OddLayers { count, .. } => {
                format!("ask for {} layers, name the side that follows, too, or take cells of tri3 or tri6", count + 1)
            }
            NotRefined { .. } => "make the mesh finer where it was made, or fill the place of the pyramids with tetrahedra".into(),
            Unmatched { .. } => {
                "put a layer of pyramids between quadrilaterals and triangles; of second order, faces of 8 nodes meet those of 8 (hex20, \
                 wedge15, pyr13)"
                    .into()
            }
            NotLocally { kind: "tet4" | "hex8" | "tet10" | "hex20" | "hex27" | "wedge6" | "wedge15" | "pyr5" | "pyr13" } => {
                "refine all of it, or make the mesh finer where it was made; only triangles are refined in places".into()
            }
            NotLocally { kind: "quad4" } => {
                "cut them into triangles of tri3 before, refine all of it, or mesh a region with a size of cells that varies".into()
            }
            NotLocally { .. } => "make it of triangles of tri6, refine all of it, or mesh a region with a size of cells that varies".into(),
            Grading { .. } => "choose a ratio nearer to 1, such as 0.1 or 10".into(),
            Extruded { .. } => "extrude a plane mesh".into(),
            LeavesPlane { .. } => "move plane meshes along x and y and turn them about the z axis only".into(),
            NoAxis { .. } => "give a direction with finite components that are not all 0, such as [0, 0, 1]".into(),
            UnknownPart { name, available } => match (nearest_name(name, available), available.is_empty()) {
                (Some(near), _) => format!("did you mean \"{near}\"?"),
                (None, true) => "name the physical surfaces (in space: volumes) in Gmsh with `Physical Surface(\"name\") = {…};`".into(),
                (None, false) => "use one of these names".into(),
            },
            BoundaryExists { .. } => "choose another name".into(),
            InvertedCell { center, inverted, cells, .. } if center.len() == 3 => solid_inside_out(inverted == cells),
            InvertedCell { .. } => {
                "mend the mesh there: nodes of a plane cell run counter-clockwise and its angles stay below 180 degrees".into()
            }
            DegenerateCell { .. } => "mend the mesh there: nodes of a cell must not coincide or lie on one line".into(),
            RepeatedNode { .. } => "give cells and lines distinct nodes; a collapsed quadrilateral is a triangle of its own kind".into(),
            CrowdedFacet { .. } => "remove cells that overlap or that are there twice".into(),
            UnusedNodes { .. } => "remove the nodes, or add the cells that use them".into(),
            BrokenReference { .. } => "renumber the mesh from 0 without gaps".into(),
            File(error) => error.problem.hint(),
            Included { error, .. } => error.hint(),
            solids => solids.hint_of_solids().into(),
        }
    }

    /// Returns the hint for an error of a swept or grown solid, or of the surface of a solid.
    fn hint_of_solids(&self) -> &'static str {
        use MeshError::*;
        match self {
            SweptOver { .. } => "take more layers for a twist; let a path bend less, or make the section narrower where it bends",
            PathPoints { .. } => "name more points; a path that ends at its first point closes",
            CoincidentPathPoints { .. } => "leave out one of the two",
            PathTurns { .. } => "round the bend with more points, or make a mesh for each side of it and join them",
            ClosedChange => "leave these out, or let the way end before its start",
            Lofted { .. } => "make both with the same generator and the same counts of cells, or map one onto the other",
            Revolution { .. } => "angles are in radians",
            OnAxis { .. } => {
                "move the mesh away from the axis: cells on it would have no volume there; solid cylinders, spheres and \
                 rings have generators of their own, with a core of cells on the axis"
            }
            Rounding { .. } => "choose a smaller radius",
            FoldedFacet { .. } => {
                "mend the mesh there: every angle of a facet must be below 180 degrees; the facets of tetrahedra do not fold"
            }
            Unjoined { .. } => {
                "make their nodes one where the mesh is made (in Gmsh `Coherence;` before it is meshed), or take what does \
                 not belong together as bodies of their own, joined by ties or contact"
            }
            CrossingSurface { .. } => {
                "a body fills no place twice: mend the surface before it is meshed, or take parts that overlap as \
                 bodies of their own"
            }
            _ => "",
        }
    }
}

/// Hint on the node order of solid cells.
fn solid_inside_out(are_all: bool) -> String {
    let order = "the first four nodes of a hexahedron (the first three of a tetrahedron) run counter-clockwise as seen from the others";
    match are_all {
        true => format!("{order}: all cells are mirrored, so exchange two of these nodes in each, or scale by -1 where they were made"),
        false => format!("{order}: write the nodes of these cells in that order, or mend the mesh where a corner goes through the others"),
    }
}

/// Most similar name, if any is similar.
fn nearest_name<'a>(name: &str, available: &'a [String]) -> Option<&'a str> {
    let similarity = |other: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let (best, near) = available.iter().map(|other| (similarity(other), other)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    // at least half of the letters agree: `body1` finds `body_1`, unrelated words have no match
    (best >= 0.5).then_some(near.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_part_suggests_the_nearest() {
        let error = MeshError::UnknownPart { name: "body1".into(), available: vec!["body_1".into(), "ring".into()] };
        assert_eq!(error.to_string(), "the mesh has no part \"body1\"; its parts are \"body_1\", \"ring\"");
        assert_eq!(error.hint(), "did you mean \"body_1\"?");
        let unlike = MeshError::UnknownPart { name: "x".into(), available: vec!["body_1".into()] };
        assert_eq!(unlike.hint(), "use one of these names");
    }
}
