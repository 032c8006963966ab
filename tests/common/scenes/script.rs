//! A scene in the script language.

use std::fmt::Write;

use super::geometry::Point;
use super::{Body, Scene, Shape, Wall};

impl Scene {
    /// The scene as a script that runs it and prints the change of its energy. Mirrored bodies have the original shape.
    pub fn script(&self) -> String {
        let mut text = format!("// Scene {} ({:?}): what `cargo example scenes` found, as a script.\n", self.seed, self.kind);
        let mut line = |words: String| writeln!(text, "{words}").expect("a string takes everything");
        line(format!("let m = model(\"scene {}\");", self.seed));
        for (k, body) in self.bodies.iter().enumerate() {
            let [modulus, ratio, density] = body.constants;
            let material = format!("{}(#{{ youngs_modulus: {modulus:?}, poisson_ratio: {ratio:?}, density: {density:?} }})", body.law);
            line(format!("let b{k} = m.add_body(\"body {k}\", {}, {material});", mesh(body)));
            line(format!("m.initial_velocity(b{k}, #{{ linear: {:?}, angular: {:?} }});", body.velocity, body.spin));
            line(format!("let h{k} = b{k}.boundary_where(\"hull\", |x, y| true);"));
        }
        line(format!("m.gravity({:?});", self.gravity));
        let method = format!("{}()", self.method.name);
        let rules = format!("update: \"{}\", friction: {:?}", self.rule.name, self.friction);
        for k in 0..self.bodies.len() {
            if k > 0 {
                let primary: Vec<String> = (0..k).map(|other| format!("h{other}")).collect();
                line(format!(
                    "m.add_contact(\"contact {k}\", #{{ secondary: h{k}, primary: [{}], method: {method}, {rules} }});",
                    primary.join(", ")
                ));
            }
            for (number, wall) in self.walls.iter().enumerate() {
                line(format!(
                    "m.add_contact(\"wall {number} and body {k}\", #{{ secondary: h{k}, primary: {}, {rules} }});",
                    obstacle(wall)
                ));
            }
        }
        line(format!("let sim = simulate(m, #{{ integrator: energy_momentum(), dt: {:?} }});", self.dt));
        line("let start = sim.energy.total;".into());
        line("let most = start;".into());
        line("sim.on_step(|s| if s.energy.total > most { most = s.energy.total; });".into());
        line(format!("sim.run_to({:?});", self.dt * self.steps as f64));
        line("print(`energy ${start} at the start, at most ${most}, ${sim.energy.total} at the end`);".into());
        text
    }
}

fn points(points: &[Point]) -> String {
    let points: Vec<String> = points.iter().map(|point| format!("{point:?}")).collect();
    format!("[{}]", points.join(", "))
}

fn mesh(body: &Body) -> String {
    let shape = match &body.shape {
        Shape::Rectangle { size, cells } => {
            format!("rectangle(#{{ size: {size:?}, cells: {cells:?}, origin: [{:?}, {:?}] }})", -0.5 * size[0], -0.5 * size[1])
        }
        Shape::Disk { radius, cells } => format!("disk(#{{ radius: {radius:?}, cells: {cells:?} }})"),
        Shape::Ring { radii: [inner, outer], cells } => {
            format!("ring(#{{ inner_radius: {inner:?}, outer_radius: {outer:?}, cells: {cells:?} }})")
        }
        Shape::Polygon { corners, size } => format!("polygon(#{{ points: {}, size: {size:?} }})", points(corners)),
    };
    format!("{shape}.rotate({:?}).translate({:?})", body.angle, body.center)
}

fn obstacle(wall: &Wall) -> String {
    match wall {
        Wall::Plane { point, normal } => format!("rigid_plane(#{{ point: {point:?}, normal: {normal:?} }})"),
        Wall::Disk { center, radius } => format!("rigid_disk(#{{ center: {center:?}, radius: {radius:?} }})"),
        Wall::Ring { center, radius } => format!("rigid_ring(#{{ center: {center:?}, radius: {radius:?} }})"),
        Wall::Polyline { points: corners } => format!("rigid_polyline(#{{ points: {} }})", points(corners)),
    }
}
