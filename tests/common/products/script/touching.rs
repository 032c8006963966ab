//! Partner of the body of a product, and the contact between them.

use super::super::catalogue::{is_quadratic, wedge_section};
use super::{MIDDLE, RADII, UNKNOWN, Writer, friction_law, obstacle, obstacle_peak, rests};

impl Writer<'_> {
    pub(super) fn partner(&mut self) {
        let is_body = self.is("partner", &["held_body", "free_body", "rigid_body", "tie"]);
        if !is_body {
            return;
        }
        let cell = self.product.row("cell");
        let cells = match (self.is_plane, is_quadratic(cell)) {
            (true, true) => "[3, 1]",
            (true, false) => "[5, 2]",
            (false, true) => "[2, 1, 1]",
            (false, false) => "[3, 1, 2]",
        };
        let mesh = match wedge_section(cell) {
            Some(section) => format!(
                "rectangle(#{{ size: [1.8, 0.5], cells: [3, 1], origin: [0.1, -0.5], element: \"{section}\" }})\
                 .extrude(#{{ height: 1.0, layers: 1, wedges: true }})"
            ),
            None if self.is_plane => {
                format!("rectangle(#{{ size: [1.8, 0.5], cells: {cells}, origin: [0.1, -0.5], element: \"{cell}\" }})")
            }
            None => format!("block(#{{ size: [1.8, 0.5, 1.0], cells: {cells}, origin: [0.1, -0.5, 0.0], element: \"{cell}\" }})"),
        };
        let mut options: Vec<String> = Vec::new();
        if self.is_plane && !self.is("plane", &["strain"]) {
            options.push(format!("plane: \"{}\"", self.product.row("plane")));
        }
        if self.is("partner", &["rigid_body"]) {
            options.push("rigid: true".into());
        }
        let options = if options.is_empty() { String::new() } else { format!(", #{{ {} }}", options.join(", ")) };
        self.line(&format!(
            "let b = m.add_body(\"b\", {mesh}, neo_hookean(#{{ youngs_modulus: 200.0, poisson_ratio: 0.3, density: 1.0 }}){options});"
        ));
        if self.is("partner", &["held_body", "tie"]) || rests(self.product) {
            self.line("m.fix(b.boundary(\"bottom\"));");
        }
    }

    /// The exact shape of a side of the contact: that of the body, or the even top of its partner.
    fn exact(&self, side: &str) -> String {
        let [depth, along] = if self.is_plane { ["", ""] } else { [", 0.5", ", 0.0"] };
        let middle = self.gap + RADII[1];
        match (side, self.is_round()) {
            ("secondary_shape", true) => {
                let name = if self.is_plane { "rigid_disk" } else { "rigid_sphere" };
                format!("{name}(#{{ center: [{MIDDLE:?}, {middle:?}{depth}], radius: {:?} }})", RADII[1])
            }
            ("secondary_shape", false) => format!("rigid_plane(#{{ point: [0.0, {:?}{depth}], normal: [0.0, -1.0{along}] }})", self.gap),
            ("primary_shape", _) => format!("rigid_plane(#{{ point: [0.0, 0.0{depth}], normal: [0.0, 1.0{along}] }})"),
            _ => UNKNOWN.into(),
        }
    }

    pub(super) fn contact(&mut self) {
        let mut options: Vec<String> = Vec::new();
        if !self.is("method", &["default"]) {
            options.push(format!("method: {}()", self.product.row("method")));
        }
        if !self.is("update", &["default"]) {
            options.push(format!("update: \"{}\"", self.product.row("update")));
        }
        match self.product.row("enforcement") {
            "multipliers" => {}
            "penalty" => options.push("penalty: 20.0".into()),
            "augmented_lagrange" => options.push("augmented_lagrange: 100.0".into()),
            "equality" => options.push("equality: true".into()),
            other => options.push(format!("{other}: 0.5")),
        }
        let coefficient = format!("{:?}", self.numbers.friction);
        match self.product.row("friction") {
            "none" => {}
            "number" => options.push(format!("friction: {coefficient}")),
            law => options.push(format!("friction: {}", friction_law(law).unwrap_or(UNKNOWN).replace("MU", &coefficient))),
        }
        match self.product.row("exact") {
            "none" => {}
            name => options.push(format!("{name}: {}", self.exact(name))),
        }
        let options: String = options.iter().map(|option| format!(", {option}")).collect();
        match self.product.row("partner") {
            "none" => {}
            "tie" => self.line("m.tie(\"pair\", #{ secondary: foot, primary: b.boundary(\"top\") });"),
            "self" => {
                let arguments = if self.is_plane { "|x, y|" } else { "|x, y, z|" };
                self.line(&format!("m.add_self_contact(\"pair\", #{{ surface: a.boundary_where(\"hull\", {arguments} true){options} }});"));
            }
            "held_body" | "free_body" | "rigid_body" => {
                self.line(&format!("m.add_contact(\"pair\", #{{ secondary: foot, primary: b.boundary(\"top\"){options} }});"));
            }
            name => {
                let high = if self.is_round() { 1.5 } else { (1.5f64.powi(2) - 0.25).sqrt() };
                let shape = obstacle(name).unwrap_or(UNKNOWN).replace('@', if self.is_plane { "" } else { ", 0.0" });
                let shape = shape.replace("HIGH", &format!("{high:?}"));
                let motion = if self.is("moving", &["moving"]) {
                    let turns = ["rigid_disk", "rigid_ring", "rigid_cylinder", "rigid_cone", "rigid_torus"].contains(&name);
                    let turn = if turns { format!(", angle: {}", self.motion(0.05)) } else { String::new() };
                    format!(", motion: #{{ y: {}{turn} }}", self.motion(obstacle_peak(self.product)))
                } else {
                    String::new()
                };
                self.line(&format!("m.add_contact(\"pair\", #{{ secondary: foot, primary: {name}(#{{ {shape}{motion} }}){options} }});"));
            }
        }
    }
}
