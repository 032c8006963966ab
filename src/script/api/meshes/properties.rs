//! Properties of a mesh: counts, names, quality.

use super::handle::MeshHandle;
use crate::mesh::Mesh;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let property = |name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Mesh) -> Dynamic| {
        property_of::<MeshHandle>(Topic::Meshes, name)
            .summary(summary)
            .returns(returns)
            .see_also(&["quality"])
            .example(format!("let plate = rectangle(#{{ size: [2.0, 1.0], cells: [8, 4] }}); print(plate.{name});"))
            .body(move |_, handle| Ok(read(&handle.mesh())))
    };
    vec![
        property("nodes", "the number of nodes", "int", |mesh| Dynamic::from(mesh.points.len() as i64)),
        property("cells", "the number of cells", "int", |mesh| Dynamic::from(mesh.cell_count() as i64)),
        property("dimension", "the dimension of its space, 2 or 3", "int", |mesh| Dynamic::from(mesh.dimension() as i64)),
        property("boundaries", "the names of its boundaries", "Array", |mesh| {
            array_of(mesh.boundaries.iter().map(|boundary| boundary.name.clone()))
        }),
        property("parts", "the names of its parts", "Array", |mesh| array_of(mesh.parts.iter().map(|(name, _)| name.clone()))),
        quality(),
    ]
}

fn quality() -> Function {
    method_of::<MeshHandle>(Topic::Meshes, "quality")
        .summary(
            "a map with `cells`, `nodes`, `measure` (area or volume), `worst` (smallest scaled Jacobian, 1 for right angles), \
             `worst_place`, `aspect_ratio`, `shortest_edge`",
        )
        .returns("Map")
        .see_also(&["refine"])
        .example("let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); print(plate.quality().aspect_ratio);")
        .body(|_, mesh| {
            let quality = mesh.mesh().quality();
            let place: Array = quality.worst_place.iter().map(|&coordinate| Dynamic::from(coordinate)).collect();
            Ok(map_of([
                ("cells", (quality.cells as i64).into()),
                ("nodes", (quality.nodes as i64).into()),
                ("measure", quality.measure.into()),
                ("worst", quality.smallest_scaled_jacobian.into()),
                ("worst_place", place.into()),
                ("aspect_ratio", quality.aspect_ratio.into()),
                ("shortest_edge", quality.shortest_edge.into()),
            ]))
        })
}
