//! Tests of pictures by the elements of their SVG.

use super::scale::{BANDS, Scale};
use super::*;
use crate::contact::{Obstacle, ObstaclePlacement};
use crate::dynamics::{BodyFields, LocalFrame, PlacedObstacle};
use crate::output::drawing::{png, svg};
use crate::output::samples::{block, ring, well_formed};

/// SVG text of a picture.
fn drawn(bodies: &[BodyFields], options: &PictureOptions) -> String {
    svg(&picture(bodies, &[], options))
}

/// Color in the notation of the text.
fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn of(field: &str) -> Field {
    Field::from_name(field).unwrap()
}

fn panel(field: &str) -> Panel {
    Panel { field: of(field), ..Panel::default() }
}

fn options(field: &str) -> PictureOptions {
    PictureOptions { panels: vec![panel(field)], title: "bearing, t = 0.5".into(), ..PictureOptions::default() }
}

/// Square cell of side 1, translated by (1, 0), with von Mises stresses 0, 0, 4 and 4 at the corners.
fn cell() -> BodyFields {
    let mut body = ring("cell", [1.0, 2.0], [1, 4]);
    let mut mesh = (*body.mesh).clone();
    (mesh.points, mesh.blocks[0].connectivity) =
        (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2, 3]);
    body.displacement = vec![[1.0, 0.0, 0.0]; 4];
    body.stress = [0.0, 0.0, 4.0, 4.0].map(|xx| [xx, 0.0, 0.0, 0.0, 0.0, 0.0]).to_vec();
    body.mesh = mesh.into();
    body
}

#[test]
fn a_cell_is_filled_up_to_each_level() {
    let svg = drawn(&[cell()], &options("von_mises"));
    well_formed(&svg);
    // The body's paths: a fill for every band, the edges, the outline.
    let group = svg.split("<title>cell</title>").nth(1).unwrap().split("</g>").next().unwrap();
    let paths: Vec<&str> = group.lines().filter(|line| line.starts_with("<path")).collect();
    assert_eq!(paths.len(), BANDS + 2);
    // The region above a level has the width of the cell and extends from its upper side down to the level.
    let numbers = |path: &str| -> Vec<i64> {
        let data = path.split('"').nth(1).unwrap().replace('-', " -");
        data.split(|c: char| !(c.is_ascii_digit() || c == '-')).filter_map(|word| word.parse().ok()).collect()
    };
    let extent = |path: &str| {
        let numbers = numbers(path);
        let places = numbers[2..].chunks(2).scan([0, 0], |at, step| {
            *at = [at[0] + step[0], at[1] + step[1]];
            Some(*at)
        });
        let (low, high) = places
            .fold(([0, 0], [0, 0]), |(low, high), at| ([at[0].min(low[0]), at[1].min(low[1])], [at[0].max(high[0]), at[1].max(high[1])]));
        [high[0] - low[0], high[1] - low[1]]
    };
    let whole = extent(paths[0]);
    assert_eq!(whole[0], whole[1]);
    for (band, path) in paths[..BANDS].iter().enumerate() {
        let [width, height] = extent(path);
        let expected = whole[1] as f64 * (1.0 - band as f64 / BANDS as f64);
        // Both ends of a length are rounded to whole units.
        assert!((width - whole[0]).abs() <= 1 && (height as f64 - expected).abs() <= 1.5, "{band}: {width} x {height}, not {expected}");
    }
    assert!(paths[0].contains(&hex(Scale::new([0.0, 4.0], "").color(0, 1.0))));
}

#[test]
fn field_title_and_body_names_are_text() {
    let mut bodies = [ring("outer <ring>", [1.0, 1.5], [3, 20]), ring("inner ring", [0.5, 1.0], [3, 16])];
    for field in Field::all() {
        let (name, words) = (field.name(), field.words());
        let svg = drawn(&bodies, &options(name));
        well_formed(&svg);
        assert!(svg.contains(words) && svg.contains(">bearing, t = 0.5</text>"), "{name}");
        assert!(svg.contains("<title>outer &lt;ring&gt;</title>") && svg.contains("<title>inner ring</title>"));
    }
    assert_eq!(Field::from_name("stress"), None);
    bodies[1].stress[3] = [7.0, 0.0, 0.0, 3.0, 0.0, 0.0];
    assert_eq!(of("pressure").value(&bodies[1], 3, &LocalFrame::default()), -7.0 / 3.0);
    assert_eq!(of("stress_xy").value(&bodies[1], 3, &LocalFrame::default()), 3.0);
}

#[test]
fn what_sticks_and_what_slides_has_a_color_and_a_name() {
    let mut body = cell();
    body.contact_slip = vec![0.0; 4];
    let drawn_with = |body: &BodyFields| drawn(std::slice::from_ref(body), &options("slip"));
    let inside = |svg: &str| svg.split("</title>").nth(1).unwrap().split("</g>").next().unwrap().to_string();
    let scale = Scale::of_kinds(of("slip").kinds(), "");
    let colors = [1, 2].map(|kind| hex(scale.kind_color(kind)));
    assert!(colors.iter().all(|color| !inside(&drawn_with(&body)).contains(color)));
    (body.contact_slip[0], body.contact_slip[1]) = (1.0, 2.0);
    let svg = drawn_with(&body);
    well_formed(&svg);
    assert!(colors.iter().all(|color| inside(&svg).contains(color)), "{svg}");
    assert!(svg.contains(">sticks</text>") && svg.contains(">slides</text>"));
}

#[test]
fn a_constant_field_has_one_color_and_a_range_makes_pictures_comparable() {
    let mut body = cell();
    body.stress = [3.0, 3.0 * (1.0 + 1e-15), 3.0, 3.0].map(|xx| [xx, 0.0, 0.0, 0.0, 0.0, 0.0]).to_vec();
    let fills = |svg: &str| svg.split("</title>").nth(1).unwrap().split("</g>").next().unwrap().matches("fill=\"#").count();
    assert_eq!(fills(&drawn(&[body.clone()], &options("von_mises"))), 1);
    let ranged =
        drawn(&[body], &PictureOptions { panels: vec![Panel { range: Some([0.0, 3.0]), ..panel("von_mises") }], ..options("von_mises") });
    assert!(ranged.split("</title>").nth(1).unwrap().contains(&hex(Scale::new([0.0, 3.0], "").color(BANDS - 1, 1.0))));
}

#[test]
fn broken_bodies_make_a_picture_all_the_same() {
    let mut body = ring("ring", [1.0, 1.5], [3, 20]);
    well_formed(&drawn(&[], &options("von_mises")));
    body.stress[0] = [f64::NAN; 6];
    body.velocity[5] = [f64::INFINITY; 3];
    body.displacement[7] = [f64::NAN; 3];
    body.displacement[8] = [1e300, 0.0, 0.0];
    for name in Field::names() {
        well_formed(&drawn(std::slice::from_ref(&body), &options(name)));
    }
    let mut point = cell();
    point.displacement = point.mesh.points.iter().map(|x| x.map(|x| -x)).collect();
    well_formed(&drawn(&[point], &options("velocity")));
}

#[test]
fn a_fine_mesh_costs_hardly_more_than_a_coarse_one() {
    let size = |refine: usize| drawn(&[ring("ring", [1.0, 1.5], [10 * refine, 48 * refine])], &options("von_mises")).len();
    let (coarse, fine) = (size(1), size(8));
    // Sixty-four times the cells: smoother contours, but no cell edges.
    assert!(coarse < 80_000 && fine < 2 * coarse, "{coarse} and {fine} bytes");
}

#[test]
fn a_block_in_space_shows_three_sides() {
    let mut body = block([1, 1, 1], [1.0, 1.0, 1.0]);
    body.displacement = vec![[0.0; 3]; 8];
    let svg = drawn(&[body], &options("stress_xx"));
    well_formed(&svg);
    assert_eq!(svg.matches("stroke-opacity").count(), 3, "one set of edges for each visible facet");
    // The corner toward the viewer has three sides in common; the three facets have equal angles to the view.
    well_formed(&drawn(&[block([6, 2, 2], [3.0, 1.0, 1.0])], &options("von_mises")));
}

fn at(translation: [f64; 3]) -> ObstaclePlacement {
    ObstaclePlacement { translation, ..ObstaclePlacement::default() }
}

#[test]
fn obstacles_are_seen_with_their_names() {
    let obstacle = |name: &str, shape| PlacedObstacle { name: name.into(), shape, place: at([0.0, -0.1, 0.0]) };
    let ground = obstacle("ground", Obstacle::HalfPlane { point: [0.0, -1.6], normal: [0.0, 1.0] });
    let seal = obstacle("groove <seal>", Obstacle::Polyline { points: vec![[-3.0, 0.0], [-2.0, 0.0], [-2.0, 1.0]] });
    let bodies = [ring("ring", [1.0, 1.5], [3, 20])];
    let text = svg(&picture(&bodies, &[ground.clone(), seal], &options("von_mises")));
    well_formed(&text);
    assert!(text.contains("<title>ground</title>") && text.contains("<title>groove &lt;seal&gt;</title>"));
    // A moved obstacle is drawn at another place.
    let moved = PlacedObstacle { place: at([0.0, -0.4, 0.0]), ..ground.clone() };
    let wall = |obstacle: PlacedObstacle| svg(&picture(&bodies, &[obstacle], &options("von_mises"))).len();
    assert!(wall(ground.clone()) > drawn(&bodies, &options("von_mises")).len());
    assert_ne!(picture(&bodies, &[moved], &options("von_mises")), picture(&bodies, std::slice::from_ref(&ground), &options("von_mises")));
    // Far below, the obstacle is not part of the picture: the bodies are drawn at unchanged size.
    let far = PlacedObstacle { place: at([0.0, -1e6, 0.0]), ..ground };
    let size = |text: &str| text.lines().next().unwrap().to_string();
    let text = svg(&picture(&bodies, &[far], &options("von_mises")));
    assert_eq!(size(&text), size(&drawn(&bodies, &options("von_mises"))));
}

#[test]
fn what_is_asked_for_is_drawn_and_nothing_else() {
    let bodies = [ring("ring", [1.0, 1.5], [3, 20])];
    let plain = PictureOptions { is_meshed: false, measure: Measure::Nothing, ..options("von_mises") };
    let text = drawn(&bodies, &plain);
    assert!(!text.contains("stroke-opacity") && !text.contains("dasharray"));
    let with = |change: &dyn Fn(&mut PictureOptions)| {
        let mut options = plain.clone();
        change(&mut options);
        let text = drawn(&bodies, &options);
        well_formed(&text);
        assert!(png(&picture(&bodies, &[], &options)).is_some_and(|bytes| bytes.starts_with(b"\x89PNG")));
        text
    };
    assert!(with(&|options| options.is_meshed = true).contains("stroke-opacity=\"0.28\""));
    assert!(with(&|options| options.is_undeformed_shown = true).contains("dasharray"));
    let arrows = with(&|options| options.vectors = Some((Vectors::Velocity, "m/s".into())));
    assert!(arrows.contains(">velocity up to 1.5 m/s<"), "{arrows}");
    assert!(with(&|options| options.vectors = Some((Vectors::ContactForce, String::new()))).contains(">contact force up to 1.5<"));
    let bar = with(&|options| (options.measure, options.length_unit) = (Measure::Bar, "mm".into()));
    assert!(bar.contains(">1 mm<"), "{bar}");
    let axes = with(&|options| (options.measure, options.length_unit) = (Measure::Axes, "mm".into()));
    assert!(axes.contains(">x [mm]<") && axes.contains(">y [mm]<") && axes.contains(">−1.0<"));
    let unit = with(&|options| options.panels[0].unit = "MPa".into());
    assert!(unit.contains("von Mises stress [MPa]"), "{unit}");
}

#[test]
fn several_fields_share_a_picture() {
    let bodies = [ring("ring", [1.0, 1.5], [3, 20])];
    let options = PictureOptions { panels: vec![panel("von_mises"), panel("velocity"), panel("pressure")], ..options("von_mises") };
    let text = drawn(&bodies, &options);
    well_formed(&text);
    assert!(text.contains("von Mises stress") && text.contains("velocity") && text.contains("pressure (−tr σ / 3)"));
    assert_eq!(text.matches("<title>ring</title>").count(), 3);
}

#[test]
fn bodies_in_space_are_seen_from_where_one_wants() {
    let body = block([6, 2, 2], [3.0, 1.0, 1.0]);
    let from = |name: &str, axis| {
        drawn(std::slice::from_ref(&body), &PictureOptions { view: View::named(name, axis).unwrap(), ..options("von_mises") })
    };
    let top = from("top", 2);
    well_formed(&top);
    assert!([">x</text>", ">y</text>", ">z</text>"].iter().all(|name| top.contains(name)), "the triad has names");
    assert_ne!(top, from("front", 2));
    assert_ne!(from("iso", 1), from("iso", 2));
}

#[test]
fn rigid_bodies_are_gray_where_the_field_is_one_of_deformation() {
    let (soft, rigid) = (cell(), BodyFields { name: "rigid".into(), is_rigid: true, ..cell() });
    let gray = hex(super::plane::WALL);
    let both = drawn(&[soft.clone(), rigid.clone()], &options("von_mises"));
    assert!(both.contains(&gray) && both.contains("von Mises"), "{both}");
    assert!(!drawn(&[soft], &options("von_mises")).contains(&gray));
    // Without a body that has the field there is no color bar.
    let alone = drawn(std::slice::from_ref(&rigid), &options("von_mises"));
    assert!(alone.contains(&gray) && !alone.contains("von Mises"), "{alone}");
    assert!(!drawn(&[rigid], &options("velocity")).contains(&gray));
    let space = BodyFields { is_rigid: true, ..block([1, 1, 1], [1.0, 1.0, 1.0]) };
    assert!(!drawn(&[space], &options("stress_xx")).contains("stress"));
}
