//! Properties of a mesh: counts, names, quality.

use rhai::{Array, Dynamic, Map};

use super::handle::MeshHandle;
use crate::mesh::Mesh;
use crate::script::language::function::{Form, Function, Topic, body};
use crate::script::language::handle::Handle;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    let receiver = MeshHandle::receiver();
    let property = |name: &'static str, summary: &'static str, returns: &'static str, read: fn(&Mesh) -> Dynamic| Function {
        name,
        form: Form::Property(receiver),
        topic: Topic::Meshes,
        summary,
        parameters: Vec::new(),
        returns,
        example: format!("let plate = rectangle(#{{ size: [2.0, 1.0], cells: [8, 4] }}); print(plate.{name});").into(),
        see_also: &["quality"],
        body: body(move |call| Ok(read(&call.receiver::<MeshHandle>().mesh()))),
    };
    vec![
        property("nodes", "the number of nodes", "int", |mesh| Dynamic::from(mesh.points.len() as i64)),
        property("cells", "the number of cells", "int", |mesh| Dynamic::from(mesh.cell_count() as i64)),
        property("dimension", "the dimension of its space, 2 or 3", "int", |mesh| Dynamic::from(mesh.dimension() as i64)),
        property("boundaries", "the names of its boundaries", "Array", |mesh| {
            mesh.boundaries.iter().map(|boundary| Dynamic::from(boundary.name.clone())).collect::<Array>().into()
        }),
        property("parts", "the names of its parts", "Array", |mesh| {
            mesh.parts.iter().map(|(name, _)| Dynamic::from(name.clone())).collect::<Array>().into()
        }),
        quality(),
    ]
}

fn quality() -> Function {
    Function {
        name: "quality",
        form: Form::Method(MeshHandle::receiver()),
        topic: Topic::Meshes,
        summary: "a map with `cells`, `nodes`, `measure` (area or volume), `worst` (smallest scaled Jacobian, 1 for right \
                  angles), `worst_place`, `aspect_ratio`, `shortest_edge`",
        parameters: Vec::new(),
        returns: "Map",
        example: "let plate = rectangle(#{ size: [2.0, 1.0], cells: [8, 4] }); print(plate.quality().aspect_ratio);".into(),
        see_also: &["refine"],
        body: body(|call| {
            let quality = call.receiver::<MeshHandle>().mesh().quality();
            let place: Array = quality.worst_place.iter().map(|&coordinate| Dynamic::from(coordinate)).collect();
            let entries: [(&str, Dynamic); 7] = [
                ("cells", (quality.cells as i64).into()),
                ("nodes", (quality.nodes as i64).into()),
                ("measure", quality.measure.into()),
                ("worst", quality.smallest_scaled_jacobian.into()),
                ("worst_place", place.into()),
                ("aspect_ratio", quality.aspect_ratio.into()),
                ("shortest_edge", quality.shortest_edge.into()),
            ];
            Ok(entries.into_iter().map(|(name, value)| (name.into(), value)).collect::<Map>().into())
        }),
    }
}
