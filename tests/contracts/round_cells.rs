//! Round meshes of every kind of cell: closed forms of area and volume, nodes on the exact surface.

use std::f64::consts::PI;

use conserva::elements::CellKind;
use conserva::mesh::{Mesh, Round, arc, cylinder, disk, half_disk, hollow_sphere, ring, rounded_block, sphere, torus, tube};

const PLANE_KINDS: [CellKind; 5] = [CellKind::Tri3, CellKind::Quad4, CellKind::Tri6, CellKind::Quad8, CellKind::Quad9];

#[test]
fn round_meshes_of_every_kind_have_their_area_to_the_order_of_the_kind() {
    let center = [0.3, -0.2];
    type Maker<'a> = &'a dyn Fn(usize) -> Mesh;
    let make: [(&str, f64, Maker, Round); 4] = [
        ("ring", 0.75 * PI, &|n| ring(0.5, 1.0, [2 * n, 12 * n], center, 0.1).unwrap(), Round::About(center)),
        ("arc", 0.375, &|n| arc([0.5, 1.0], [0.2, 1.2], [2 * n, 4 * n], center, [1.0, 2.0]).unwrap(), Round::About(center)),
        ("disk", PI, &|n| disk(1.0, [2 * n, 16 * n], center).unwrap(), Round::On(center, 1.0)),
        ("half disk", 0.5 * PI, &|n| half_disk(1.0, [2 * n, 16 * n], center, None).unwrap(), Round::On(center, 1.0)),
    ];
    for (name, area, make, round) in make {
        for kind in PLANE_KINDS {
            let errors = [1, 2].map(|n| {
                let mesh = make(n).with_round_cells(kind, round).unwrap_or_else(|error| panic!("{name} {kind:?}: {error}"));
                assert_eq!(mesh.only_kind(), Some(kind));
                assert_eq!(mesh.defects(), [], "{name} {kind:?}");
                assert_eq!(mesh.boundaries.len(), make(n).boundaries.len());
                (mesh.measure() - area).abs() / area
            });
            // Halving the cell size reduces the error of chords to a quarter, that of parabolas to a sixteenth.
            let rate = (errors[0] / errors[1]).log2();
            let expected = if kind.is_quadratic() { 4.0 } else { 2.0 };
            assert!((rate - expected).abs() < 0.2, "{name} {kind:?}: {errors:?}, order {rate}");
        }
    }
}

#[test]
fn centers_of_curved_faces_lie_on_the_exact_surface() {
    let round = Round::AboutPoint([0.0; 3]);
    let shell = hollow_sphere([0.5, 1.0], [1, 8], [0.0; 3], 1.0).unwrap().with_round_cells(CellKind::Hex27, round).unwrap();
    let base = Round::About([0.0; 2]);
    let pipe = tube([0.5, 1.0], 1.0, [1, 8, 1], [0.0; 3], [1.0; 2]).unwrap().with_round_cells(CellKind::Hex27, base).unwrap();
    let die = rounded_block([1.5; 3], 0.25, [2; 3], [1, 4], [0.0; 3]).unwrap();
    let [low, high] = [0.25, 1.25].map(|x| [x; 3]);
    let die = die.with_round_cells(CellKind::Hex27, Round::OnBlock([low, high], 0.25)).unwrap();
    let from_block = |x: [f64; 3]| (0..3).map(|i| (x[i] - x[i].clamp(low[i], high[i])).powi(2)).sum::<f64>().sqrt();
    let off = |mesh: &Mesh, sides: &[&str], distance: &dyn Fn([f64; 3]) -> f64, radius: f64| {
        let facets = sides.iter().flat_map(|side| &mesh.boundary(side).unwrap().facets);
        let nodes = facets.flat_map(|&facet| mesh.facet_nodes(facet));
        nodes.map(|node| (distance(mesh.points[node as usize]) - radius).abs()).fold(0.0, f64::max)
    };
    let norm = |x: [f64; 3]| x.map(|c| c * c).iter().sum::<f64>().sqrt();
    let radius = |x: [f64; 3]| x[0].hypot(x[1]);
    for (side, r) in [("inner", 0.5), ("outer", 1.0)] {
        assert!(off(&shell, &[side], &norm, r) < 1e-15);
        assert!(off(&pipe, &[side], &radius, r) < 1e-15);
    }
    let sides: Vec<&str> = die.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
    assert!(off(&die, &sides, &from_block, 0.25) < 1e-15, "{}", off(&die, &sides, &from_block, 0.25));
}

#[test]
fn round_solids_of_second_order_have_their_volume_to_the_fourth_order() {
    let (center, base) = ([0.1, 0.2, 0.3], [0.1, 0.2]);
    type Maker<'a> = &'a dyn Fn(usize) -> Mesh;
    let (low, high) = (center, [1.1, 1.2, 1.3]);
    let make: [(&str, f64, Maker, Round); 6] = [
        ("tube", 0.75 * PI, &|n| tube([0.5, 1.0], 1.0, [2, 12 * n, 2], center, [1.0; 2]).unwrap(), Round::About(base)),
        ("cylinder", PI, &|n| cylinder(1.0, 1.0, [2, 12 * n, 2], center, 1.0).unwrap(), Round::On(base, 1.0)),
        ("ball", 4.0 / 3.0 * PI, &|n| sphere(1.0, [2, 12 * n], center, 1.0).unwrap(), Round::OnBlock([center; 2], 1.0)),
        ("shell", 3.5 / 3.0 * PI, &|n| hollow_sphere([0.5, 1.0], [2, 12 * n], center, 1.0).unwrap(), Round::AboutPoint(center)),
        ("ring", 0.32 * PI * PI, &|n| torus(1.0, 0.4, [2, 12 * n, 12 * n], center).unwrap(), Round::Ring(center, [1.0, 0.4])),
        (
            "die",
            2.5 + 3.0 * PI * 0.0625 + PI / 48.0,
            &|n| rounded_block([1.5; 3], 0.25, [2; 3], [2, 4 * n], [-0.15, -0.05, 0.05]).unwrap(),
            Round::OnBlock([low, high], 0.25),
        ),
    ];
    for (name, volume, make, round) in make {
        for kind in [CellKind::Hex8, CellKind::Tet10, CellKind::Hex20, CellKind::Hex27] {
            let errors = [1, 2].map(|n| {
                let mesh = make(n).with_round_cells(kind, round).unwrap_or_else(|error| panic!("{name} {kind:?}: {error}"));
                assert_eq!(mesh.defects(), [], "{name} {kind:?}");
                (mesh.measure() - volume).abs() / volume
            });
            let rate = (errors[0] / errors[1]).log2();
            let least = if kind.is_quadratic() { 3.5 } else { 1.8 };
            assert!(rate > least, "{name} {kind:?}: {errors:?}, order {rate}");
        }
    }
}
