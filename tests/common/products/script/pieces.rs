//! Force elements, joints, loads and supports of the body of a product.

use std::fmt::Write;

use super::{ABOVE, LEFT, MIDDLE, RADII, SIZE, UNKNOWN, Writer, has_joint, prescribed_angle, prescribed_peak, rests};

impl Writer<'_> {
    pub(super) fn part(&mut self) {
        let high = self.gap + SIZE[1];
        let (corner, above) = (self.point(LEFT, high), self.point(LEFT - 0.1, high + 1.0));
        let (low, right) = (self.point(LEFT, self.gap), self.point(LEFT + SIZE[0], self.gap));
        let ends = format!("from: a, from_point: {corner}, to: \"ground\", to_point: {above}");
        let axis = if self.is_plane { "" } else { ", axis: [0.0, 0.0, 1.0]" };
        let text = match self.product.row("part") {
            "none" => return,
            "add_spring" => format!("m.add_spring(\"part\", #{{ {ends}, stiffness: 5.0, rest_length: 0.9 }});"),
            "add_bolt" => {
                let locked = 0.5 * self.duration();
                format!("m.add_bolt(\"part\", #{{ {ends}, preload: 0.1, stiffness: 5.0, locked_at: {locked:?} }});")
            }
            "add_coupling" => {
                self.line(&format!("let grip = m.add_rigid_body(\"grip\", {}, #{{ density: 1.0 }});", self.block([-2.0, 2.0])));
                "m.add_coupling(\"part\", #{ boundary: far, to: grip });".into()
            }
            "add_torsion_spring" => {
                format!("m.add_torsion_spring(\"part\", #{{ from: a, from_points: [{low}, {right}], to: \"ground\", stiffness: 2.0 }});")
            }
            "add_damper" => format!("m.add_damper(\"part\", #{{ {ends}, coefficient: 0.5 }});"),
            "add_bushing" => {
                let [stiffness, damping] = if self.is_plane {
                    ["[50.0, 80.0, 5.0]", "[0.5, 0.8, 0.05]"]
                } else {
                    ["[50.0, 80.0, 60.0, 5.0, 6.0, 7.0]", "[0.5, 0.8, 0.5, 0.05, 0.05, 0.05]"]
                };
                let point = self.point(MIDDLE, high);
                format!(
                    "m.add_bushing(\"part\", #{{ from: a, to: \"ground\", point: {point}, stiffness: {stiffness}, damping: {damping} }});"
                )
            }
            "add_drag" => "m.add_drag(\"part\", #{ boundary: cap, coefficient: 0.2 });".into(),
            "add_damping" => "m.add_damping(a, #{ mass: 0.5, stiffness: 1e-3 });".into(),
            "add_chamber" => {
                "m.add_chamber(\"part\", #{ boundaries: a.boundary(\"inner\"), pressure: 1.0, exponent: 1.4, ambient: 1.0 });".into()
            }
            "add_mass" => format!("m.add_mass(\"part\", #{{ body: a, point: {corner}, mass: 0.05 }});"),
            "add_actuator" => format!("m.add_actuator(\"part\", #{{ {ends}, force: {} }});", self.amplitude(0.5)),
            "add_motor" => format!("m.add_motor(\"part\", #{{ from: a, to: \"ground\"{axis}, torque: {} }});", self.amplitude(0.1)),
            _ => UNKNOWN.into(),
        };
        self.line(&text);
    }

    /// A cell with a corner at a point, for a rigid body beside the model.
    fn block(&self, [x, y]: [f64; 2]) -> String {
        if self.is_plane {
            format!("rectangle(#{{ size: [0.4, 0.4], cells: [1, 1], origin: [{x:?}, {y:?}] }})")
        } else {
            format!("block(#{{ size: [0.4, 0.4, 0.4], cells: [1, 1, 1], origin: [{x:?}, {y:?}, 0.0] }})")
        }
    }

    /// Initial position of the joint.
    pub fn joint_point(&self) -> [f64; 3] {
        if self.is_round() { [MIDDLE - RADII[1], self.gap + RADII[1], 0.5] } else { [LEFT, self.gap + 0.5 * SIZE[1], 0.1] }
    }

    pub(super) fn joint(&mut self) {
        let kind = self.product.row("joint");
        if !has_joint(self.product) {
            return;
        }
        let [x, y, depth] = self.joint_point();
        let place = |x: f64, y: f64| if self.is_plane { format!("[{x:?}, {y:?}]") } else { format!("[{x:?}, {y:?}, {depth:?}]") };
        let (point, above) = (place(x, y), place(x, y + ABOVE));
        let turns = if self.is_plane { "point" } else { "hinge" };
        let kind = if kind == "gear" { turns } else { kind };
        let mut options = format!("kind: \"{kind}\", from: a, point: {point}");
        if self.numbers.is_joined && self.is("partner", &["free_body", "rigid_body", "held_body"]) && !["link", "cable"].contains(&kind) {
            options += ", to: b";
        }
        match kind {
            "hinge" => options += ", axis: [0.0, 0.0, 1.0]",
            "slider" | "slot" => {
                write!(options, ", axis: {}", if self.is_plane { "[0.0, 1.0]" } else { "[0.0, 1.0, 0.0]" }).expect("a string")
            }
            "link" | "cable" => write!(options, ", to_point: {above}").expect("a string"),
            _ => {}
        }
        match self.product.row("rubbing") {
            "none" => {}
            "friction" if kind == turns => options += ", friction: 0.2, radius: 0.05",
            "friction" => options += ", friction: 0.2",
            "friction_moment" => options += ", friction_moment: 0.01",
            "friction_force" => options += ", friction_force: 0.05",
            _ => options += UNKNOWN,
        }
        match self.product.row("drive") {
            "drive" => write!(options, ", drive: {}", self.motion(0.02)).expect("a string"),
            "limits" if kind == "link" => options += ", limits: [0.98, 1.01]",
            "limits" => options += ", limits: [-0.005, 0.01]",
            _ => {}
        }
        self.line(&format!("m.add_joint(\"joint\", #{{ {options} }});"));
        if self.is("joint", &["gear"]) {
            let axis = if self.is_plane { "" } else { ", axis: [0.0, 0.0, 1.0]" };
            let (mesh, point) = (self.block([4.0, 2.0]), if self.is_plane { "[4.2, 2.2]" } else { "[4.2, 2.2, 0.2]" });
            self.line(&format!("let wheel = m.add_rigid_body(\"wheel\", {mesh}, #{{ density: 1.0 }});"));
            self.line(&format!("m.add_joint(\"bearing\", #{{ kind: \"{turns}\", from: wheel, point: {point}{axis} }});"));
            self.line("m.add_gear(\"gear\", #{ joints: [\"joint\", \"bearing\"], ratio: 2.0 });");
        }
    }

    pub(super) fn load(&mut self) {
        let amplitude = self.amplitude(1.0);
        let size = |value: f64| format!("{:?}", value * self.numbers.load);
        let position = if self.is_plane { "|x, y|" } else { "|x, y, z|" };
        let text = match self.product.row("load") {
            "none" => return,
            "gravity" => format!("m.gravity({}, {amplitude});", self.vector(1.0, -5.0)),
            "rotating_frame" => format!("m.rotating_frame(#{{ velocity: {} }});", self.amplitude(0.5)),
            "initial_displacement" => {
                let far = if self.is_axial() { "0.0" } else { "0.01 * (x - 1.0)" };
                let third = if self.is_plane { "" } else { ", 0.0" };
                format!("m.initial_displacement(a, {position} [{far}, 0.01 * y{third}]);")
            }
            "traction" => format!("m.traction(cap, {}, {amplitude});", self.vector(0.5, -1.0)),
            "force" => format!("m.force(cap, {}, {amplitude});", self.vector(0.5, -1.0)),
            "pressure" => format!("m.pressure(cap, {}, {amplitude});", size(1.0)),
            "torque" => format!("m.torque(cap, {});", self.amplitude(0.1)),
            "body_force" => format!("m.body_force(\"body force\", a, |x, v, t| {});", self.vector(0.5, -2.0)),
            "grow" => "a.grow(1.005);".into(),
            _ => UNKNOWN.into(),
        };
        self.line(&text);
    }

    pub(super) fn support(&mut self) {
        let row = self.product.row("support");
        let text = match row {
            "none" => String::new(),
            "fix" => "m.fix(cap);".into(),
            "fix_x" => "m.fix(flank, \"x\");".into(),
            "prescribe" => format!("m.prescribe(cap, #{{ y: {} }});", self.motion(prescribed_peak(self.product))),
            "prescribe_angle" => {
                let about = self.point(MIDDLE, self.gap + SIZE[1]);
                format!("m.prescribe(cap, #{{ angle: {}, about: {about} }});", self.motion(prescribed_angle(self.product)))
            }
            "add_symmetry" => "m.add_symmetry(\"symmetry\", flank);".into(),
            "add_periodic" => "m.add_periodic(\"periodic\", #{ from: flank, to: far });".into(),
            _ => UNKNOWN.into(),
        };
        if !text.is_empty() {
            self.line(&text);
        }
        if rests(self.product) {
            // A task at rest needs supports.
            match row {
                "fix" | "prescribe_angle" => {}
                "prescribe" => {
                    let others = if self.is_plane { "x" } else { "xz" };
                    self.line(&format!("m.fix(cap, \"{others}\");"));
                }
                _ => self.line("m.fix(cap);"),
            }
        }
    }
}
