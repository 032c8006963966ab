//! Rigid bodies with friction in space: boxes, pucks, truncated tetrahedra, plates, piles and arches.

use std::f64::consts::{PI, TAU};

use super::{Case, Expected, Pace, figures, pace, pick, random_of, scaled, whole};
use crate::common::Random;

const G: f64 = 9.81;

/// Largest motion of a body at rest, over lengths of about 1.
const REST: f64 = 1e-9;

/// Height of a box's center over its lower face, and the largest offset of the pressure that a single facet of it bears, a sixth of the
/// side.
const HALF_HEIGHT: f64 = 0.25;
const OF_ONE_FACET: f64 = 1.0 / 6.0;

/// Relative error of the distance of a slide against the closed form.
const SLIDE: f64 = 1e-3;

/// Case of a seed.
pub fn case(seed: u64) -> Case {
    let mut random = random_of(seed);
    let of = pick(&mut random, &[slope, slope, slope, braked, braked, puck, puck, tetrahedron, plate, pile, arch]);
    of(&mut random)
}

fn rule(random: &mut Random) -> &'static str {
    pick(random, &["persistency", "persistency", "gap", "velocity"])
}

/// Coefficient that differs from the tangent of the slope, at which rest and sliding meet.
fn coefficient(random: &mut Random, tilt: f64) -> f64 {
    loop {
        let mu = scaled(random, 0.05, 1.0);
        if (mu / tilt.tan() - 1.0).abs() > 0.02 {
            return mu;
        }
    }
}

/// Gravity on a slope with an angle and a direction of descent.
fn gravity(tilt: f64, towards: f64) -> String {
    let down = G * tilt.sin();
    format!("m.gravity([{:e}, {:e}, {:e}]);\n", down * towards.cos(), down * towards.sin(), -G * tilt.cos())
}

const GROUND: &str = "rigid_plane(#{ point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] })";

fn simulate(pace: &Pace) -> String {
    format!(
        "let sim = simulate(m, #{{ integrator: energy_momentum(), dt: {} }});\nlet from = sim.body(b).center;\nsim.run_to({:e});\n",
        pace.text, pace.time
    )
}

/// Lines that print the displacement of the body `b` along a direction and across it.
fn way(towards: f64) -> String {
    let (sin, cos) = towards.sin_cos();
    format!(
        "let to = sim.body(b).center;\nlet dx = to[0] - from[0];\nlet dy = to[1] - from[1];\n\
         print(`figure along ${{dx * {cos:e} + dy * {sin:e}}}`);\nprint(`figure across ${{dy * {cos:e} - dx * {sin:e}}}`);\n"
    )
}

/// Expected motion along a line: rest, or a distance.
fn straight(want: f64, absolute: f64) -> Vec<Expected> {
    let tolerance = REST + SLIDE * want.abs() + absolute;
    vec![Expected { name: "along", value: want, tolerance }, Expected { name: "across", value: 0.0, tolerance: REST + 1e-6 * want.abs() }]
}

fn box_mesh(n: usize, yaw: f64, z: f64) -> String {
    format!("block(#{{ size: [1.0, 1.0, 0.5], cells: [{n}, {n}, 1], origin: [-0.5, -0.5, {z:e}] }}).rotate({yaw:e})")
}

/// A box on a slope, `g (sin - mu cos) t^2/2`.
fn slope(random: &mut Random) -> Case {
    let (n, tilt) = (whole(random, 1, 12), random.between(0.02, 0.7));
    let (mu, yaw, towards) = (coefficient(random, tilt), random.between(0.0, TAU), random.between(0.0, TAU));
    let (rule, pace) = (rule(random), pace(random, 0.3));
    let script = format!(
        "let m = model(\"slope\");\nlet b = m.add_rigid_body(\"b\", {}, #{{ density: 1.0 }});\n{}\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"back\"), primary: {GROUND}, friction: {mu:e}, update: \"{rule}\" }});\n{}{}{}",
        box_mesh(n, yaw, 0.0),
        gravity(tilt, towards),
        simulate(&pace),
        way(towards),
        figures(0.5)
    );
    let want = 0.5 * G * (tilt.sin() - mu * tilt.cos()).max(0.0) * pace.time.powi(2);
    let kind = if want > 0.0 { "slope, slides" } else { "slope, rests" }.to_string();
    let name = format!("n {n}, tan {:.4}, mu {mu:.4}, dt {}, {rule}", tilt.tan(), pace.text);
    Case { kind, name, script, expected: straight(want, 0.0) }
}

/// A box that slides on level ground and stops: `v^2/(2 mu g)`.
fn braked(random: &mut Random) -> Case {
    let (n, mu, v) = (whole(random, 1, 12), scaled(random, 0.05, 1.0), scaled(random, 0.02, 2.0));
    let (yaw, towards, rule, pace) = (random.between(0.0, TAU), random.between(0.0, TAU), rule(random), pace(random, 0.3));
    let script = format!(
        "let m = model(\"braked\");\nlet b = m.add_rigid_body(\"b\", {}, #{{ density: 1.0 }});\n{}\
         m.initial_velocity(b, #{{ linear: [{:e}, {:e}, 0.0] }});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"back\"), primary: {GROUND}, friction: {mu:e}, update: \"{rule}\" }});\n{}{}{}",
        box_mesh(n, yaw, 0.0),
        gravity(0.0, 0.0),
        v * towards.cos(),
        v * towards.sin(),
        simulate(&pace),
        way(towards),
        figures(0.5)
    );
    let time = pace.time.min(v / (mu * G));
    let name = format!("n {n}, mu {mu:.4}, v {v:.3}, dt {}, {rule}", pace.text);
    // The time of the stop is not resolved within a step.
    let way = v * time - 0.5 * mu * G * time * time;
    let expected = straight(way, if pace.dt > 0.0 { 0.5 * mu * G * pace.dt.powi(2) } else { 2.0 * SLIDE * way });
    Case { kind: "braked".into(), name, script, expected }
}

/// A puck that spins, at rest or as it slides: the moment of a disk at rest is `2/3 mu N R`.
fn puck(random: &mut Random) -> Case {
    let (around, mu) = (4 * whole(random, 3, 8), scaled(random, 0.05, 1.0));
    let (v, spin) = (random.between(0.1, 2.0), random.between(-8.0, 8.0));
    let v = pick(random, &[0.0, v]);
    let (rule, pace) = (rule(random), pace(random, 0.2));
    let rings = whole(random, 1, 3);
    let script = format!(
        "let m = model(\"puck\");\n\
         let mesh = cylinder(#{{ radius: 1.0, height: 0.02, cells: [{rings}, {around}, 1] }});\n\
         let b = m.add_rigid_body(\"b\", mesh, #{{ mass: 2.0, inertia: [0.5, 0.5, 1.0], center: [0.0, 0.0, 0.0] }});\n{}\
         m.initial_velocity(b, #{{ linear: [{v:e}, 0.0, 0.0], angular: [0.0, 0.0, {spin:e}] }});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"bottom\"), primary: {GROUND}, friction: {mu:e}, update: \"{rule}\" }});\n{}{}{}",
        gravity(0.0, 0.0),
        simulate(&pace),
        "print(`figure spin ${sim.angular_momentum[2]}`);\nprint(`figure along ${sim.body(b).center[0]}`);\n",
        figures(2.0)
    );
    let mut expected = Vec::new();
    if v == 0.0 {
        let loss = 2.0 / 3.0 * mu * 2.0 * G * pace.time;
        let value = if loss < spin.abs() { spin - loss * spin.signum() } else { 0.0 };
        // The faceted disk has a fraction of the area and moment of the circle.
        let tolerance = if rings >= 2 { 0.06 } else { 0.2 } * loss + 1e-9;
        if value != 0.0 {
            expected.push(Expected { name: "spin", value, tolerance });
        }
        expected.push(Expected { name: "along", value: 0.0, tolerance: REST });
    }
    let name = format!("cells {rings} x {around}, mu {mu:.4}, v {v:.3}, spin {spin:.3}, dt {}, {rule}", pace.text);
    Case { kind: "puck".into(), name, script, expected }
}

/// A truncated tetrahedron on a slope.
fn tetrahedron(random: &mut Random) -> Case {
    let (tilt, towards) = (random.between(0.02, 0.35), random.between(0.0, TAU));
    let (mu, rule, pace) = (coefficient(random, tilt), rule(random), pace(random, 0.3));
    let (size, layers) = (scaled(random, 0.1, 1.2), whole(random, 1, 3));
    let script = format!(
        "let m = model(\"tetrahedron\");\n\
         let base = polygon(#{{ points: [[-0.5, -0.2887], [0.5, -0.2887], [0.0, 0.5774]], size: {size:e}, element: \"tri3\" }});\n\
         let mesh = base.extrude(#{{ height: 0.6, layers: {layers}, scale: 0.2 }});\n\
         let b = m.add_rigid_body(\"b\", mesh, #{{ mass: 0.1, inertia: [0.006, 0.006, 0.008], center: [0.0, 0.0, 0.18] }});\n{}\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"bottom\"), primary: {GROUND}, friction: {mu:e}, update: \"{rule}\" }});\n{}{}{}",
        gravity(tilt, towards),
        simulate(&pace),
        way(towards),
        figures(0.1)
    );
    let want = 0.5 * G * (tilt.sin() - mu * tilt.cos()).max(0.0) * pace.time.powi(2);
    let name = format!("size {size:.3}, layers {layers}, tan {:.4}, mu {mu:.4}, dt {}, {rule}", tilt.tan(), pace.text);
    Case { kind: "tetrahedron".into(), name, script, expected: straight(want, 0.0) }
}

/// A box thrown along a free plate on smooth ground: the plate is taken along until both have the common velocity.
fn plate(random: &mut Random) -> Case {
    let (n, k, mu) = (whole(random, 1, 6), whole(random, 1, 6), scaled(random, 0.05, 1.0));
    let (v, yaw, towards) = (scaled(random, 0.1, 2.0), random.between(0.0, TAU), random.between(0.0, TAU));
    let (rule, pace) = (rule(random), pace(random, 0.15));
    let method = pick(random, &["mortar()", "mortar()", "dual_mortar()"]);
    // One facet with pressures at its corners bears within the inner third only, beyond which strong friction tips the box.
    let n = if mu * HALF_HEIGHT > OF_ONE_FACET { n.max(2) } else { n };
    let script = format!(
        "let m = model(\"plate\");\nlet b = m.add_rigid_body(\"b\", {}, #{{ density: 1.0 }});\n\
         let plate = block(#{{ size: [3.0, 3.0, 0.2], cells: [{k}, {k}, 1], origin: [-1.5, -1.5, -0.2] }});\n\
         let p = m.add_rigid_body(\"p\", plate, #{{ density: 1.0 }});\n{}\
         m.initial_velocity(b, #{{ linear: [{:e}, {:e}, 0.0] }});\n\
         m.add_contact(\"c\", #{{ secondary: b.boundary(\"back\"), primary: p.boundary(\"front\"), friction: {mu:e}, update: \"{rule}\", \
         method: {method} }});\n\
         m.add_contact(\"g\", #{{ secondary: p.boundary(\"back\"), update: \"{rule}\", \
         primary: rigid_plane(#{{ point: [0.0, 0.0, -0.2], normal: [0.0, 0.0, 1.0] }}) }});\n{}{}{}",
        box_mesh(n, yaw, 0.0),
        gravity(0.0, 0.0),
        v * towards.cos(),
        v * towards.sin(),
        simulate(&pace),
        way(towards),
        figures(2.3)
    );
    // Masses 0.5 and 1.8.
    let stop = v / (mu * G * (1.0 + 0.5 / 1.8));
    let (slides, time) = (pace.time.min(stop), pace.time);
    let want = v * slides - 0.5 * mu * G * slides * slides + (time - slides) * v * 0.5 / 2.3;
    let name = format!("n {n} on {k}, mu {mu:.4}, v {v:.3}, dt {}, {rule}, {method}", pace.text);
    let mut expected = straight(want, if pace.dt > 0.0 { mu * G * pace.dt.powi(2) } else { 2.0 * SLIDE * want });
    // Pressures at nodes that lie unevenly on the facets of the plate turn the box.
    expected[1].tolerance += SLIDE * want;
    Case { kind: "plate".into(), name, script, expected }
}

/// Stack of boxes on a slope, at rest or sliding together on the lowest face.
fn pile(random: &mut Random) -> Case {
    let (count, tilt, towards) = (whole(random, 2, 4), random.between(0.02, 0.25), random.between(0.0, TAU));
    let (rule, pace) = (rule(random), pace(random, 0.15));
    let mu = coefficient(random, tilt);
    let between = (1.3 * mu).max(0.4);
    let mut script = format!("let m = model(\"pile\");\n{}", gravity(tilt, towards));
    let mut cells = Vec::new();
    for k in 0..count {
        let (n, yaw) = (whole(random, 1, 5), if random.next() > 0.0 { random.between(0.0, PI) } else { 0.0 });
        cells.push(n);
        let name = if k == 0 { "b".to_string() } else { format!("b{k}") };
        script += &format!("let {name} = m.add_rigid_body(\"{name}\", {}, #{{ density: 1.0 }});\n", box_mesh(n, yaw, 0.5 * k as f64));
        let (primary, mu) = match k {
            0 => (GROUND.to_string(), mu),
            1 => ("b.boundary(\"front\")".into(), between),
            _ => (format!("b{}.boundary(\"front\")", k - 1), between),
        };
        script += &format!(
            "m.add_contact(\"c{k}\", #{{ secondary: {name}.boundary(\"back\"), primary: {primary}, friction: {mu:e}, \
             update: \"{rule}\" }});\n"
        );
    }
    script += &format!("{}{}{}", simulate(&pace), way(towards), figures(0.5 * count as f64));
    let want = 0.5 * G * (tilt.sin() - mu * tilt.cos()).max(0.0) * pace.time.powi(2);
    let name = format!("n {cells:?}, tan {:.4}, mu {mu:.4}, dt {}, {rule}", tilt.tan(), pace.text);
    Case { kind: "pile".into(), name, script, expected: straight(want, 0.0) }
}

/// Semicircular arch of stones at rest, thicker than the thinnest stable arch (0.1075 of the radius; Milankovitch, 1907).
fn arch(random: &mut Random) -> Case {
    let (stones, n, mu) = (whole(random, 3, 9), whole(random, 1, 3), random.between(0.6, 1.0));
    let (rule, pace) = (rule(random), pace(random, 0.1));
    let mut script = format!("let m = model(\"arch\");\n{}let n = {n};\n", gravity(0.0, 0.0));
    script += &format!(
        "let stones = [];\nfor k in 0..{stones} {{\n    \
         let face = arc(#{{ inner_radius: 0.85, outer_radius: 1.15, start_angle: deg(180.0) * k / {stones}, \
         end_angle: deg(180.0) * (k + 1) / {stones}, cells: [n, 1] }});\n    \
         let s = m.add_rigid_body(`s${{k}}`, face.extrude(#{{ height: 0.4, layers: n }}).rotate(deg(90.0), [0.0, 0.0, 0.0], \
         [1.0, 0.0, 0.0]), #{{ density: 1.0 }});\n    \
         let below = if k == 0 {{ {GROUND} }} else {{ stones[k - 1].boundary(\"end\") }};\n    \
         m.add_contact(`c${{k}}`, #{{ secondary: s.boundary(\"start\"), primary: below, friction: {mu:e}, update: \"{rule}\" }});\n    \
         stones.push(s);\n}}\n\
         m.add_contact(\"left\", #{{ secondary: stones[{stones} - 1].boundary(\"end\"), primary: {GROUND}, friction: {mu:e}, \
         update: \"{rule}\" }});\n"
    );
    script += &format!("let b = stones[{}];\n{}{}", stones / 2, simulate(&pace), way(0.0));
    script += "print(`figure sag ${to[2] - from[2]}`);\n";
    script += &figures(0.4 * stones as f64);
    let name = format!("{stones} stones, n {n}, mu {mu:.3}, dt {}, {rule}", pace.text);
    let mut expected = straight(0.0, 0.0);
    expected.push(Expected { name: "sag", value: 0.0, tolerance: REST });
    Case { kind: "arch".into(), name, script, expected }
}
