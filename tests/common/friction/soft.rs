//! Soft bodies with friction in space, each scene with five step sizes: from 1e-2 to 1e-5, and steps that choose theirs.

use std::f64::consts::TAU;

use super::{Case, figures, pick, random_of, scaled, whole};
use crate::common::Random;

/// Step sizes of each scene, the largest first.
pub const SIZES: [&str; 5] = ["1e-2", "1e-3", "1e-4", "1e-5", "auto()"];

/// Case of a seed: scene `seed / 5` with the step size `seed % 5`.
pub fn case(seed: u64) -> Case {
    let mut random = random_of(seed / SIZES.len() as u64);
    let size = SIZES[(seed % SIZES.len() as u64) as usize];
    let of = pick(&mut random, &[cube, cube, ball, pair, pair, on_obstacle]);
    let (kind, name, model, mass) = of(&mut random);
    let figures = figures(mass);
    let script = format!("{model}let sim = simulate(m, #{{ integrator: energy_momentum(), dt: {size} }});\nsim.step(40);\n{figures}");
    Case { kind: kind.into(), name: format!("dt {size}, {name}"), script, expected: Vec::new() }
}

/// Kind, parameters, lines of the model and mass of a scene.
type Scene = (&'static str, String, String, f64);

fn law(random: &mut Random) -> String {
    let law = pick(random, &["neo_hookean", "neo_hookean", "saint_venant_kirchhoff", "hencky"]);
    let (modulus, ratio) = (scaled(random, 200.0, 1e6), pick(random, &[0.0, 0.3, 0.4]));
    format!("{law}(#{{ youngs_modulus: {modulus:.4e}, poisson_ratio: {ratio:.1}, density: 1.0 }})")
}

fn element(random: &mut Random) -> &'static str {
    pick(random, &["hex8", "hex8", "tet4", "hex27", "tet10"])
}

/// Options of a contact, and the coefficient.
fn contact(random: &mut Random) -> String {
    let (mu, rule) = (scaled(random, 0.05, 1.0), pick(random, &["persistency", "persistency", "gap", "velocity"]));
    format!("friction: {mu:.4e}, update: \"{rule}\"")
}

fn velocity(random: &mut Random) -> String {
    let (v, towards, down) = (scaled(random, 0.05, 2.0), random.between(0.0, TAU), random.between(0.0, 1.0));
    let spin: [f64; 3] = std::array::from_fn(|_| 2.0 * random.next());
    format!("#{{ linear: [{:.4e}, {:.4e}, {:.4e}], angular: {spin:.4?} }}", v * towards.cos(), v * towards.sin(), -down)
}

const GRAVITY: &str = "m.gravity([0.5, 0.2, -9.81]);\n";

/// A cube on a plane.
fn cube(random: &mut Random) -> Scene {
    let (cells, element, law, contact): ([usize; 3], _, _, _) =
        (std::array::from_fn(|_| whole(random, 1, 3)), element(random), law(random), contact(random));
    let (velocity, gap) = (velocity(random), pick(random, &[0.0, 1e-5, 1e-3]));
    let model = format!(
        "let m = model(\"cube\");\n\
         let b = m.add_body(\"b\", block(#{{ size: [0.6, 0.5, 0.5], cells: {cells:?}, origin: [-0.3, -0.25, {gap:e}], \
         element: \"{element}\" }}), {law});\n{GRAVITY}m.initial_velocity(b, {velocity});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary_where(\"skin\", |x, y, z| true), \
         primary: rigid_plane(#{{ point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] }}), {contact} }});\n"
    );
    ("cube", format!("{cells:?} {element}, gap {gap:e}, {law}, {contact}, {velocity}"), model, 0.15)
}

/// A ball that slides and rolls.
fn ball(random: &mut Random) -> Scene {
    let (element, law, contact, velocity) = (pick(random, &["hex8", "tet4"]), law(random), contact(random), velocity(random));
    let model = format!(
        "let m = model(\"ball\");\nlet b = m.add_body(\"b\", sphere(#{{ radius: 0.5, cells: [1, 8], element: \"{element}\" }})\
         .translate([0.0, 0.0, 0.501]), {law});\n{GRAVITY}m.initial_velocity(b, {velocity});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary_where(\"skin\", |x, y, z| true), \
         primary: rigid_plane(#{{ point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] }}), {contact} }});\n"
    );
    ("ball", format!("{element}, {law}, {contact}, {velocity}"), model, 0.5)
}

/// A body, soft or rigid, on a soft plate.
fn pair(random: &mut Random) -> Scene {
    let cells: [[usize; 2]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| whole(random, 1, 4)));
    let elements = [element(random), element(random)];
    let laws = [law(random), law(random)];
    let (contact, velocity, yaw) = (contact(random), velocity(random), random.between(0.0, TAU));
    let method = pick(random, &["mortar()", "mortar()", "dual_mortar()", "node_to_segment()"]);
    let is_rigid = random.next() > 0.4;
    let mesh = format!(
        "block(#{{ size: [0.5, 0.5, 0.4], cells: [{}, {}, 1], origin: [-0.25, -0.25, 0.0], element: \"{}\" }}).rotate({yaw:.4})",
        cells[0][0], cells[0][1], elements[0]
    );
    let body = if is_rigid {
        format!("m.add_rigid_body(\"b\", {mesh}, #{{ density: 1.0 }})")
    } else {
        format!("m.add_body(\"b\", {mesh}, {})", laws[0])
    };
    let model = format!(
        "let m = model(\"pair\");\nlet b = {body};\n\
         let p = m.add_body(\"p\", block(#{{ size: [1.2, 1.2, 0.3], cells: [{}, {}, 1], origin: [-0.6, -0.6, -0.3], \
         element: \"{}\" }}), {});\n\
         m.fix(p.boundary(\"back\"));\n{GRAVITY}m.initial_velocity(b, {velocity});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary_where(\"skin\", |x, y, z| true), \
         primary: p.boundary_where(\"skin\", |x, y, z| true), {contact}, method: {method} }});\n",
        cells[1][0], cells[1][1], elements[1], laws[1]
    );
    let name = format!("{cells:?} {elements:?}, {}, {contact}, {method}, {velocity}", laws.join(" "));
    (if is_rigid { "rigid on soft" } else { "soft on soft" }, name, model, 0.1)
}

/// A block thrown along a sphere, a cylinder or a box.
fn on_obstacle(random: &mut Random) -> Scene {
    let (cells, element, law, contact, velocity) = (whole(random, 1, 4), element(random), law(random), contact(random), velocity(random));
    let obstacle = pick(
        random,
        &[
            "rigid_sphere(#{ center: [0.02, 0.01, -0.5], radius: 0.5 })",
            "rigid_cylinder(#{ point: [0.0, 0.05, -0.3], axis: [0.3, 1.0, 0.0], radius: 0.3 })",
            "rigid_box(#{ origin: [-0.1, -0.8, -1.0], size: [0.4, 1.0, 1.0] })",
        ],
    );
    let model = format!(
        "let m = model(\"obstacle\");\nlet b = m.add_body(\"b\", block(#{{ size: [0.8, 0.8, 0.2], cells: [{cells}, {cells}, 1], \
         origin: [-0.4, -0.4, 0.0005], element: \"{element}\" }}), {law});\n{GRAVITY}m.initial_velocity(b, {velocity});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary_where(\"skin\", |x, y, z| true), primary: {obstacle}, {contact} }});\n"
    );
    ("on an obstacle", format!("{cells} {element}, {obstacle}, {law}, {contact}, {velocity}"), model, 0.13)
}
