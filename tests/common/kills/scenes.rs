//! Models for random scripts other than elastic bodies in the plane, each with statements that read its results: machines, bodies in space,
//! statics, moving obstacles.
//!
//! Placeholders in texts: `{m}` is the variable of the model, `{b}` that of its first body, `{s}` that of the simulation, and `{x}` a
//! suffix for the uniqueness of further names.

/// A model with statements that read its results.
pub struct Scene {
    /// Statements that make the model and its first body.
    pub model: &'static str,
    /// Integrators that the model supports.
    pub integrators: &'static [&'static str],
    /// Name of the contact; `None` for a model without contact.
    pub contact: Option<&'static str>,
    /// True for a supported model, which has an equilibrium.
    pub is_held: bool,
    /// Statements that read the simulation and are possible at any time after the first step.
    pub readers: &'static [&'static str],
}

/// Statements that read results of any model.
pub const COMMON: &[&str] = &[
    "print({s}.body({b}).center); print({s}.body({b}).velocity); print({s}.body({b}).kinetic); print({s}.body({b}).momentum);",
    "print({s}.body({b}).strain); print({s}.body({b}).potential); print({s}.body({b}).stress_error);",
    "print({s}.body({b}).angular_momentum);",
    "print({s}.field(\"velocity\", {b}).len()); print({s}.extremes(\"velocity\", {b}));",
    "print({s}.history.columns.len()); print({s}.history.time[-1]); print({s}.history[\"total\"][0]); ",
    "let sum = 0.0; for k in 0..{s}.history.time.len() { sum += {s}.history.total[k] * {s}.history.dt[k]; } print(sum);",
    "print({s}.dt); print({s}.unknowns); print({s}.name); print({s}.bodies); print({s}.angular_momentum); print({s}.momentum);",
    "expect_conserved({s}, \"ledger\", #{ after: 0.0, tolerance: 1e3 });",
    "print({s}); print({s}.energy);",
];

/// The scenes.
pub const SCENES: &[Scene] = &[
    Scene {
        model: "let {b} = {m}.add_rigid_body(\"arm\", rectangle(#{ size: [1.0, 0.1], cells: [4, 1], origin: [0.0, -0.05] }),
    #{ density: 1.0 });
let fore{x} = {m}.add_rigid_body(\"fore\", rectangle(#{ size: [1.0, 0.1], cells: [4, 1], origin: [1.0, -0.05] }), #{ density: 1.0 });
{m}.add_joint(\"shoulder\", #{ kind: \"point\", from: {b}, point: [0.0, 0.0] });
{m}.add_joint(\"elbow\", #{ kind: \"point\", from: fore{x}, to: {b}, point: [1.0, 0.0], drive: |t| 2.0 * t * t });
{m}.add_spring(\"spring\", #{ from: fore{x}, from_point: [2.0, 0.05], to: \"ground\", to_point: [2.0, 2.0], stiffness: 20.0 });
{m}.add_damper(\"damper\", #{ from: fore{x}, from_point: [2.0, -0.05], to: \"ground\", to_point: [2.5, -2.0], coefficient: 0.5 });
{m}.add_actuator(\"push\", #{ from: {b}, from_point: [1.0, 0.05], to: \"ground\", to_point: [1.0, 3.0], force: |t| sin(20.0 * t) });
{m}.add_motor(\"motor\", #{ from: {b}, to: \"ground\", torque: |t| cos(9.0 * t) });
{m}.add_torsion_spring(\"coil\", #{ from: {b}, from_points: [[0.0, 0.05], [1.0, 0.05]], stiffness: 3.0, to: fore{x},
    to_points: [[1.0, 0.05], [2.0, 0.05]] });
{m}.gravity([0.0, -9.81]);",
        integrators: &["energy_momentum", "midpoint", "mean_value"],
        contact: None,
        is_held: false,
        readers: &[
            "print({s}.joint(\"shoulder\").angle); print({s}.joint(\"shoulder\").force); print({s}.joint(\"shoulder\").position);",
            "print({s}.joint(\"elbow\")); print({s}.joint(\"elbow\").work); print({s}.joint(\"elbow\").moment);",
            "print({s}.history[\"spring.energy\"][-1]); print({s}.history[\"damper.speed\"][-1]); print({s}.history[\"push.work\"].sum());",
            "print({s}.history[\"motor.torque\"][-1]);",
            "if {s}.joint(\"shoulder\").angle < -0.1 { {s}.step(2); } else { {s}.step(3); }",
        ],
    },
    Scene {
        model: "let {b} = {m}.add_rigid_body(\"wheel\", disk(#{ radius: 0.5, cells: [1, 12], center: [0.0, 0.55] }), #{ density: 1.0 });
let pinion{x} = {m}.add_rigid_body(\"pinion\", disk(#{ radius: 0.25, cells: [1, 12], center: [4.0, 0.0] }), #{ density: 1.0 });
let large{x} = {m}.add_rigid_body(\"large\", disk(#{ radius: 0.5, cells: [1, 12], center: [4.75, 0.0] }), #{ density: 1.0 });
{m}.add_joint(\"small\", #{ kind: \"point\", from: pinion{x}, point: [4.0, 0.0], drive: |t| 3.0 * t * t });
{m}.add_joint(\"big\", #{ kind: \"point\", from: large{x}, point: [4.75, 0.0] });
{m}.add_gear(\"teeth\", #{ joints: [\"small\", \"big\"], ratio: 2.0 });
{m}.initial_velocity({b}, #{ linear: [1.0, 0.0] });
{m}.gravity([0.0, -9.81]);
{m}.add_contact(\"ground\", #{ secondary: {b}.boundary(\"outer\"), friction: 0.3,
    primary: rigid_plane(#{ point: [0.0, 0.0], normal: [0.0, 1.0] }) });",
        integrators: &["energy_momentum"],
        contact: Some("ground"),
        is_held: false,
        readers: &[
            "print({s}.joint(\"big\").angle); print({s}.joint(\"small\").work);",
            "let c = {s}.contact(\"ground\"); print(c.shear); print(c.slip); print(c.slip_path); print(c.heat); print(c.sliding);",
            "let c = {s}.contact(\"ground\"); print(c.state); print(c.area); print(c.pressure); print(c.mean_pressure); \
             print(c.positions.len());",
            "let c = {s}.contact(\"ground\"); print(c.normal_force); print(c.forces.len()); print(c.cycling);",
        ],
    },
    Scene {
        model: "let {b} = {m}.add_body(\"cube\", block(#{ size: [1.0, 1.0, 1.0], cells: [2, 2, 2], origin: [-0.5, -0.5, 0.01] }), soft);
{m}.gravity([0.0, 0.5, -10.0]);
{m}.add_contact(\"floor\", #{ secondary: {b}.boundary(\"bottom\"), friction: 0.2,
    primary: rigid_plane(#{ point: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] }) });
{m}.add_contact(\"ball\", #{ secondary: {b}.boundary(\"top\"),
    primary: rigid_sphere(#{ center: [0.0, 0.0, 1.6], radius: 0.5, motion: #{ z: |t| -0.5 * t * t } }) });",
        integrators: &["energy_momentum", "midpoint"],
        contact: Some("floor"),
        is_held: false,
        readers: &[
            "let c = {s}.contact(\"floor\"); print(c.force); print(c.gap); print(c.active); print(c.slip); print(c.state);",
            "let c = {s}.contact(\"ball\"); print(c.force); print(c.gap); print(c.normal_force);",
            "{s}.picture(\"cube.svg\", #{ field: \"von_mises\", width: 240 });",
        ],
    },
    Scene {
        model: "let {b} = {m}.add_body(\"strip\", rectangle(#{ size: [2.0, 0.2], cells: [10, 1] }), soft);
let left{x} = {b}.boundary(\"left\");
{m}.fix(left{x});
{m}.force({b}.boundary(\"right\"), [0.0, -1.0], |t| 0.4 * t);
{m}.add_mass(\"tip\", #{ body: {b}, point: [2.0, 0.2], mass: 0.01 });",
        integrators: &["statics"],
        contact: None,
        is_held: true,
        readers: &[
            "print({s}.reaction(left{x})); print({s}.reaction(left{x}).force); print({s}.reaction(left{x}).moment);",
            "let path = {s}.follow_load(#{ load: {s}.time + 1.0, increment: 0.5, points: 4 }); print(path.time); print(path.strain); \
             print(path.critical); print(path.unstable); print(path.end); {s}.restore(path.state(1));",
            "let found = {s}.modes(#{ count: 2 }); print(found.frequencies); print(found.participation); print(found.shape(0, {b}).len());",
            "print({s}.history.load_work); print({s}.history[\"strip.left.reaction.force_y\"]);",
        ],
    },
    Scene {
        model:
            "let {b} = {m}.add_body(\"tube\", ring(#{ inner_radius: 0.5, outer_radius: 0.7, cells: [2, 16], center: [0.0, 0.0] }), soft);
{m}.add_chamber(\"air\", #{ boundaries: {b}.boundary(\"inner\"), pressure: 12.0, exponent: 1.4, ambient: 10.0 });
{m}.add_drag(\"drag\", #{ boundary: {b}.boundary(\"outer\"), coefficient: 0.02 });
{m}.initial_velocity({b}, #{ angular: 1.0 });
let post{x} = {m}.add_body(\"post\", rectangle(#{ size: [0.2, 1.0], cells: [1, 4], origin: [2.0, 0.0] }), soft);
let foot{x} = post{x}.boundary(\"bottom\");
{m}.prescribe(foot{x}, #{ x: |t| 0.2 * t * t, y: 0.0 });",
        integrators: &["energy_momentum", "midpoint", "trapezoidal"],
        contact: None,
        is_held: false,
        readers: &[
            "print({s}.history[\"air.pressure\"][-1]); print({s}.history[\"air.volume\"][-1]); \
             print({s}.history[\"drag.dissipation\"][-1]);",
            "print({s}.reaction(foot{x})); print({s}.reaction(foot{x}).force);",
            "let found = {s}.harmonic_response(#{ frequencies: [0.5], boundary: post{x}.boundary(\"top\"), force: [1.0, 0.0], \
             loss_factor: 0.1 }); print(found.frequencies);",
            "print({s}.field(\"von_mises\", {b}).len()); print({s}.field(\"pressure\", post{x}, #{ at: \"cells\" }).len());",
        ],
    },
];
