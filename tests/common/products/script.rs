//! A product as a script of the language.

mod constants;
mod pieces;
mod touching;

use conserva::elements::CellKind;
use conserva::materials;

use super::Named;
use super::catalogue::{is_plane, is_quadratic, wedge_section};
use super::numbers::Numbers;

pub use constants::{TOP, friction_law, obstacle};

/// Methods of a model that support it.
pub const SUPPORTS: [&str; 4] = ["fix", "prescribe", "add_symmetry", "add_periodic"];

/// Force elements for which a script is known.
pub const PARTS: [&str; 12] = [
    "add_spring",
    "add_bolt",
    "add_coupling",
    "add_torsion_spring",
    "add_damper",
    "add_bushing",
    "add_drag",
    "add_damping",
    "add_chamber",
    "add_mass",
    "add_actuator",
    "add_motor",
];

/// Dry friction of joints for which a script is known.
pub const RUBBING: [&str; 3] = ["friction", "friction_moment", "friction_force"];

/// Loads for which a script is known.
pub const LOADS: [&str; 9] =
    ["gravity", "rotating_frame", "initial_displacement", "traction", "force", "pressure", "torque", "body_force", "grow"];

/// Time functions for which a script is known.
pub const AMPLITUDES: [&str; 6] = ["number", "closure", "hat", "ramp", "sine", "table"];

/// Marker in place of a row for which no script is known.
const UNKNOWN: &str = "/* no script is known for this row */";

/// Relative change of the numbers in [`Variant::Nudged`]: above round-off, below every tolerance.
pub const NUDGE: f64 = 1e-12;

/// Change of the coordinates in [`Variant::Nudged`] `[length]`: a hundred times round-off.
const ROUNDED: f64 = 1e-14;

/// Variation of a script relative to that of its product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// No variation.
    Plain,
    /// Bodies in another order, nodes of boxes numbered from the other end.
    Renumbered,
    /// Gap, velocities and loads times `1 + n 1e-12`, coordinates of the mesh with round-off `n 1e-14`, with `n` of either sign.
    Nudged(i32),
}

/// Height, length along x, depth and lowest corner of the body.
pub const SIZE: [f64; 3] = [1.0, 0.6, 0.8];
/// Smallest x of the body.
pub const LEFT: f64 = 0.5;
/// Radii of a round body.
pub const RADII: [f64; 2] = [0.2, 0.4];
/// Center of the body along x.
pub const MIDDLE: f64 = 1.0;
/// Height of the ground point of links above the body's left end.
const ABOVE: f64 = 1.0;

struct Writer<'a> {
    product: Named<'a>,
    numbers: Numbers,
    variant: Variant,
    is_plane: bool,
    gap: f64,
    text: String,
}

/// The script of a product.
pub fn text(product: Named, variant: Variant) -> String {
    let mut writer = Writer::new(product, variant);
    writer.line(&format!("// {product}"));
    writer.declared();
    writer.model();
    writer.simulation();
    writer.told();
    writer.text
}

/// Script that runs a product unchanged and moved.
pub fn moved(product: Named, how: &str) -> String {
    let mut writer = Writer::new(product, Variant::Plain);
    writer.line(&format!("// {product}"));
    writer.declared();
    writer.line("expect_invariant(|| {");
    writer.model();
    writer.simulation();
    writer.line("sim");
    writer.line(&format!("}}, #{{ {how} }});"));
    writer.text
}

/// True if the task of a product is an equilibrium.
pub fn rests(product: Named) -> bool {
    product.is("integrator", &["statics"]) || settles(product) || product.is("task", &["follow_load"])
}

fn settles(product: Named) -> bool {
    product.is("task", &["settle", "settle_without_friction", "buckling"])
}

/// Distance of the body from its partner at the start.
pub fn gap(product: Named, numbers: &Numbers) -> f64 {
    if product.is("partner", &["tie"]) || product.is("enforcement", &["equality"]) {
        0.0
    } else if settles(product) && !product.is("body", &["rigid", "rigid_numbers"]) {
        -0.3 * numbers.gap
    } else {
        numbers.gap
    }
}

impl<'a> Writer<'a> {
    fn new(product: Named<'a>, variant: Variant) -> Self {
        let mut numbers = Numbers::new(product.product.seed);
        if let Variant::Nudged(by) = variant {
            numbers.scale(1.0 + f64::from(by) * NUDGE);
        }
        let gap = gap(product, &numbers);
        Writer { product, numbers, variant, is_plane: is_plane(product.row("cell")), gap, text: String::new() }
    }

    fn line(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    fn is(&self, factor: &str, rows: &[&str]) -> bool {
        self.product.is(factor, rows)
    }

    fn is_round(&self) -> bool {
        self.is("shape", &["round"])
    }

    fn is_axial(&self) -> bool {
        self.is("plane", &["axisymmetric"])
    }

    /// A vector; for bodies of revolution its part along the axis.
    fn vector(&self, x: f64, y: f64) -> String {
        let x = if self.is_axial() { 0.0 } else { x };
        if self.is_plane { format!("[{x:?}, {y:?}]") } else { format!("[{x:?}, {y:?}, 0.0]") }
    }

    /// A point of the body, in space on its front.
    fn point(&self, x: f64, y: f64) -> String {
        if self.is_plane { format!("[{x:?}, {y:?}]") } else { format!("[{x:?}, {y:?}, 0.1]") }
    }

    fn duration(&self) -> f64 {
        self.numbers.dt * self.numbers.steps as f64
    }

    /// A time function with a peak; a number has the peak from the start.
    fn amplitude(&self, peak: f64) -> String {
        let end = self.duration();
        let peak = peak * self.numbers.load;
        match self.product.row("amplitude") {
            "number" => format!("{peak:?}"),
            "closure" => format!("|t| {peak:?} * t / {end:?}"),
            "hat" => format!("hat(0.0, {end:?}, {peak:?})"),
            "ramp" => format!("ramp(0.0, {:?}, {peak:?})", 0.5 * end),
            "sine" => format!("sine({peak:?}, {:?})", 0.25 / end),
            "table" => format!("table([[0.0, 0.0], [{:?}, {peak:?}], [{end:?}, {:?}]])", 0.6 * end, 0.5 * peak),
            _ => UNKNOWN.into(),
        }
    }

    /// A motion with a peak that is zero at the start; of a number, zero throughout.
    fn motion(&self, peak: f64) -> String {
        if self.is("amplitude", &["number"]) { "0.0".into() } else { self.amplitude(peak) }
    }

    fn material(&self, title: &str) -> String {
        if title == "hyperelastic" {
            let energy = "mu/2*(I1bar - 3) + k/2*(J - 1)^2";
            return format!("hyperelastic(#{{ energy: \"{energy}\", mu: 40.0, k: 100.0, density: 1.0 }})");
        }
        if title == "elastic_plastic" {
            let constants = "youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0, yield_stress: 0.8, hardening: 5.0";
            return format!("elastic_plastic(#{{ {constants} }}).back_stress(#{{ modulus: 4.0, recovery: 3.0 }})");
        }
        let row = materials::CATALOGUE.iter().chain(materials::LINEAR).find(|row| row.title() == title).expect("it is of the catalogue");
        let values = row.example(100.0, 1.0);
        let mut keys: Vec<String> = row.parameters.iter().zip(values).map(|(key, value)| format!("{}: {value:?}", key.name)).collect();
        keys.extend(row.volumetric.filter(|form| !form.is_usual()).map(|form| format!("volumetric: \"{}\"", form.name)));
        format!("{}(#{{ {} }})", row.name, keys.join(", "))
    }

    /// Mesh of the body.
    fn mesh(&self) -> String {
        let Variant::Nudged(by) = self.variant else { return self.exact_mesh() };
        // Rotations and other units round every coordinate.
        let moved = |x: &str, y: &str| format!("{x} + {:?} * sin(37.0 * {x} + 91.0 * {y})", f64::from(by) * ROUNDED);
        let [x, y, z] = [moved("x", "y"), moved("y", "x"), moved("z", "y")];
        let places = if self.is_plane { format!("|x, y| [{x}, {y}]") } else { format!("|x, y, z| [{x}, {y}, {z}]") };
        format!("{}.map({places})", self.exact_mesh())
    }

    fn exact_mesh(&self) -> String {
        match wedge_section(self.product.row("cell")) {
            Some(section) => {
                let mesh = if self.is_round() { self.round_mesh(true, section) } else { self.box_mesh(true, section) };
                let depth = SIZE[2];
                format!("{mesh}.extrude(#{{ height: {depth:?}, layers: 1, wedges: true }}).translate([0.0, 0.0, 0.1])")
            }
            None if self.is_round() => self.round_mesh(self.is_plane, self.product.row("cell")),
            None => self.box_mesh(self.is_plane, self.product.row("cell")),
        }
    }

    fn box_mesh(&self, is_plane: bool, cell: &str) -> String {
        let ([width, height, depth], gap) = (SIZE, self.gap);
        let (generator, size, origin, center, axis) = if is_plane {
            ("rectangle", format!("[{width:?}, {height:?}]"), format!("[{LEFT:?}, {gap:?}]"), "", "")
        } else {
            ("block", format!("[{width:?}, {height:?}, {depth:?}]"), format!("[{LEFT:?}, {gap:?}, 0.1]"), ", 0.5", ", [0.0, 0.0, 1.0]")
        };
        let cells = match (is_plane, is_quadratic(cell)) {
            (true, true) => "[2, 1]",
            (true, false) => "[4, 2]",
            (false, true) => "[2, 1, 1]",
            (false, false) => "[2, 2, 1]",
        };
        let middle = gap + 0.5 * height;
        let turn = if self.turns_mesh() { format!(".rotate(PI(), [{MIDDLE:?}, {middle:?}{center}]{axis})") } else { String::new() };
        format!("{generator}(#{{ size: {size}, cells: {cells}, origin: {origin}, element: \"{cell}\" }}){turn}")
    }

    fn round_mesh(&self, is_plane: bool, cell: &str) -> String {
        let ([inner, outer], middle) = (RADII, self.gap + RADII[1]);
        if is_plane {
            let around = if is_quadratic(cell) { 8 } else { 12 };
            format!(
                "ring(#{{ inner_radius: {inner:?}, outer_radius: {outer:?}, cells: [1, {around}], \
                 center: [{MIDDLE:?}, {middle:?}], element: \"{cell}\" }})"
            )
        } else {
            let around = if is_quadratic(cell) { 4 } else { 8 };
            format!("sphere(#{{ radius: {outer:?}, cells: [1, {around}], center: [{MIDDLE:?}, {middle:?}, 0.5], element: \"{cell}\" }})")
        }
    }

    /// True if half a turn renumbers the mesh: a rotated box is the same box, unless it is divided into tetrahedra.
    fn turns_mesh(&self) -> bool {
        self.variant == Variant::Renumbered && !self.is_round() && !self.product.row("cell").starts_with("tet")
    }

    fn body(&mut self) {
        let material = if self.is("body", &["rigid", "rigid_numbers"]) {
            "neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 })".to_string()
        } else {
            self.material(self.product.row("material"))
        };
        self.line(&format!("let stuff = {material};"));
        match self.product.row("body") {
            "viscous" => self.line("let stuff = stuff.viscous(#{ shear_viscosity: 0.2, bulk_viscosity: 0.1 });"),
            "relaxing" => self.line("let stuff = stuff.relaxing(#{ shear_modulus: 20.0, relaxation_time: 0.02 });"),
            _ => {}
        }
        let mesh = self.mesh();
        let mut options: Vec<String> = Vec::new();
        if self.is_plane && !self.is("plane", &["strain"]) {
            options.push(format!("plane: \"{}\"", self.product.row("plane")));
        }
        if !self.is("dilatation", &["default"]) {
            options.push(format!("dilatation: \"{}\"", self.product.row("dilatation")));
        }
        if self.is("body", &["rigid"]) {
            options.push("rigid: true".into());
        }
        let options = if options.is_empty() { String::new() } else { format!(", #{{ {} }}", options.join(", ")) };
        if self.is("body", &["rigid_numbers"]) {
            self.line(&format!("let a = m.add_rigid_body(\"a\", {mesh}, #{{ mass: 0.6 }});"));
        } else {
            self.line(&format!("let a = m.add_body(\"a\", {mesh}, stuff{options});"));
        }
    }

    /// Boundaries of the body: the side of the contact, and the three other sides.
    fn boundaries(&mut self) {
        if self.is_round() {
            let arguments = if self.is_plane { "|x, y|" } else { "|x, y, z|" };
            let high = self.gap + 1.5 * RADII[1];
            self.line("let foot = a.boundary(\"outer\");");
            self.line(&format!("let cap = a.boundary_where(\"cap\", {arguments} y > {high:?});"));
            self.line(&format!("let flank = a.boundary_where(\"flank\", {arguments} x < {:?});", MIDDLE - 0.5 * RADII[1] + 1e-6));
            self.line(&format!("let far = a.boundary_where(\"far\", {arguments} x > {:?});", MIDDLE + 0.5 * RADII[1] - 1e-6));
            return;
        }
        let names = if self.turns_mesh() { ["top", "bottom", "right", "left"] } else { ["bottom", "top", "left", "right"] };
        for (variable, name) in ["foot", "cap", "flank", "far"].iter().zip(names) {
            self.line(&format!("let {variable} = a.boundary(\"{name}\");"));
        }
    }

    /// Declares the units of the script; numbers that are implausible in these units give a warning only.
    fn declared(&mut self) {
        if !self.is("declared", &["none"]) {
            self.line(&format!("units(\"{}\");", self.product.row("declared")));
        }
    }

    fn model(&mut self) {
        self.line("let m = model(\"product\");");
        if self.variant == Variant::Renumbered {
            self.partner();
            self.body();
        } else {
            self.body();
            self.partner();
        }
        self.boundaries();
        let (linear, spin) = (self.vector(self.numbers.slide, -self.numbers.speed), self.numbers.spin);
        let spin = if self.is_axial() { String::new() } else { format!(", angular: {spin:?}") };
        // Statics refuses velocities, with a code.
        if !self.is("integrator", &["statics"]) {
            self.line(&format!("m.initial_velocity(a, #{{ linear: {linear}{spin} }});"));
        }
        self.contact();
        self.part();
        self.joint();
        self.load();
        self.support();
    }

    fn simulation(&mut self) {
        let integrator = self.product.row("integrator");
        let dt = self.numbers.dt;
        if integrator == "central_differences" {
            self.line(&format!("let dt = [{dt:?}, 0.5 * stable_step(m)].reduce(|a, b| if b < a {{ b }} else {{ a }}, 1.0);"));
        } else {
            self.line(&format!("let dt = {dt:?};"));
        }
        let size = if self.is("steps", &["auto"]) { "auto(#{ first: dt })" } else { "dt" };
        let solver = match self.product.row("solver") {
            "auto" => String::new(),
            name => format!(", solver: \"{name}\""),
        };
        self.line(&format!("let sim = simulate(m, #{{ integrator: {integrator}(), dt: {size}, stills: 2{solver} }});"));
        let (end, half) = (self.duration(), 0.5 * self.duration());
        let run = format!("sim.run_to({end:?});");
        let force = self.vector(0.0, 1.0);
        let (point, damped) = (self.point(MIDDLE, self.gap + SIZE[1]), "loss_factor: 0.05");
        let task = match self.product.row("task") {
            "run" => run,
            "settle" => format!("sim.settle();\n{run}"),
            "settle_without_friction" => format!("sim.settle(#{{ friction: false }});\n{run}"),
            "modes" => format!("{run}\nlet modes = sim.modes(#{{ count: 3 }});\nprint(`@modes ${{modes.frequencies}}`);"),
            "harmonic_response" => format!(
                "{run}\nlet answer = sim.harmonic_response(#{{ frequencies: [1.0, 3.0], boundary: foot, force: {force}, {damped} }});\n\
                 print(`@response ${{answer.at(a, {point}).amplitude}}`);"
            ),
            "harmonic_base" => format!(
                "{run}\nlet answer = sim.harmonic_response(#{{ frequencies: [1.0, 3.0], base: {force}, {damped} }});\n\
                 print(`@response ${{answer.at(a, {point}).amplitude}}`);"
            ),
            "buckling" => {
                format!("sim.settle();\nlet buckling = sim.buckling(#{{ count: 1 }});\nprint(`@buckling ${{buckling.factors}}`);\n{run}")
            }
            "follow_load" => format!("let path = sim.follow_load(#{{ load: {end:?}, points: 6 }});\nsim.restore(path.state(-1));"),
            "restore" => format!("let start = sim.save();\nsim.step(3);\nsim.restore(start);\n{run}"),
            "back" => format!("sim.step(3);\nsim.back(2);\n{run}"),
            "branch" => format!("sim.step(2);\nlet other = sim.branch();\nother.step(2);\n{run}"),
            "set" => format!("sim.run_to({half:?});\nsim.set(#{{ dt: 0.5 * dt }});\n{run}"),
            _ => UNKNOWN.into(),
        };
        self.line(&task);
    }

    /// Prints the values at the end, which are compared with the files.
    fn told(&mut self) {
        self.line("print(`@time ${sim.time}`);");
        self.line("print(`@steps ${sim.steps}`);");
        self.line("for name in sim.history.columns { print(`@column ${name}: ${sim.history[name][-1]}`); }");
        self.line("print(`@energy ${[sim.energy.kinetic, sim.energy.strain, sim.energy.potential, sim.energy.total]}`);");
        self.line("print(`@momentum ${sim.momentum}`);");
        self.line("for body in sim.bodies { print(`@displacement ${sim.field(\"displacement\", body)}`); }");
        self.line("for body in sim.bodies { print(`@velocity ${sim.field(\"velocity\", body)}`); }");
        if !self.is("partner", &["none", "tie"]) {
            self.line("let pair = sim.contact(\"pair\");");
            self.line("print(`@pressure ${pair.pressure}`);\nprint(`@shear ${pair.shear}`);\nprint(`@slip ${pair.slip}`);");
            self.line("print(`@gap ${pair.gap}`);\nprint(`@active ${pair.active}`);\nprint(`@state ${pair.state}`);");
        }
        if has_joint(self.product) {
            self.line("print(`@joint ${sim.joint(\"joint\").position}`);");
        }
        self.line("sim.write_fields(\"end.vtu\");");
    }
}

/// Initial position of the joint of a product.
pub fn joint_point(product: Named) -> [f64; 3] {
    Writer::new(product, Variant::Plain).joint_point()
}

/// Dimension of the space of a product.
pub fn dimension(product: Named) -> usize {
    CellKind::ALL.iter().find(|kind| kind.name() == product.row("cell")).map_or(2, |kind| kind.dimension())
}

/// A motion with a peak at a time.
pub fn motion_at(product: Named, peak: f64, time: f64) -> f64 {
    let writer = Writer::new(product, Variant::Plain);
    let (end, peak) = (writer.duration(), peak * writer.numbers.load);
    let linear = |points: &[[f64; 2]]| {
        let piece = points.windows(2).find(|piece| time <= piece[1][0]);
        let last = points[points.len() - 1][1];
        piece.map_or(last, |piece| piece[0][1] + (piece[1][1] - piece[0][1]) * (time - piece[0][0]) / (piece[1][0] - piece[0][0]))
    };
    match product.row("amplitude") {
        "closure" => peak * time / end,
        "hat" => linear(&[[0.0, 0.0], [0.5 * end, peak], [end, 0.0]]),
        "ramp" => linear(&[[0.0, 0.0], [0.5 * end, peak]]),
        "sine" => peak * (2.0 * std::f64::consts::PI * 0.25 / end * time).sin(),
        "table" => linear(&[[0.0, 0.0], [0.6 * end, peak], [end, 0.5 * peak]]),
        _ => 0.0,
    }
}

/// Displacement of the obstacle along y at a time.
pub fn obstacle_offset(product: Named, time: f64) -> f64 {
    if product.is("moving", &["moving"]) { motion_at(product, obstacle_peak(product), time) } else { 0.0 }
}

/// True for a rigid body that a rigid obstacle cannot move: supports or joints determine its motion. No motion of such a body into the
/// obstacle has a solution.
fn is_held_from_obstacle(product: Named) -> bool {
    let is_obstacle = product.row("partner").starts_with("rigid_") && !product.is("partner", &["rigid_body"]);
    let is_held = !product.is("support", &["none"]) || !product.is("joint", &["none"]);
    is_obstacle && is_held && product.is("body", &["rigid", "rigid_numbers"])
}

/// True for a model with a joint. A link or taut cable does not let a rigid body follow a prescribed motion, and is left out.
pub fn has_joint(product: Named) -> bool {
    let is_blocked = product.is("body", &["rigid", "rigid_numbers"])
        && product.is("support", &["prescribe", "prescribe_angle"])
        && product.is("joint", &["link", "cable"]);
    !product.is("joint", &["none"]) && !is_blocked
}

/// Peak of the motion of a moving obstacle along y: towards the body if the body can give way.
fn obstacle_peak(product: Named) -> f64 {
    match is_held_from_obstacle(product) {
        true if product.is("enforcement", &["equality"]) => 0.0,
        true => -0.01,
        false => 0.01,
    }
}

/// Peak of the prescribed motion of the top along y: towards the partner, unless both are rigid.
pub fn prescribed_peak(product: Named) -> f64 {
    if is_held_from_obstacle(product) { 0.02 } else { -0.02 }
}

/// Peak of the prescribed angle of the top `[rad]`; half of the smallest gap is the largest admitted motion of a corner of a rigid body.
fn prescribed_angle(product: Named) -> f64 {
    if is_held_from_obstacle(product) { 0.001 } else { 0.05 }
}
