//! Random scripts with everything that affects a resumed run: states, steps back, branches, closures after steps, probes, files, studies,
//! caught errors; models of every kind with statements that read them ([`SCENES`]); and the examples of the reference, so that every
//! function is called.

use std::fmt::Write as _;
use std::path::Path;
use std::rc::Rc;
use std::sync::OnceLock;

use conserva::script::{Session, Settings, Silent};

use super::super::splitmix::SplitMix;
use super::scenes::{COMMON, SCENES};

/// CSV table that scripts read.
pub const TABLE: &str = "t,size\n0.0,1.0\n0.1,2.5\n0.3,0.5\n";

/// Data of a simulation of the script while the script is written.
struct Known {
    /// Variable of the simulation.
    name: String,
    /// Variable of its first body.
    body: String,
    /// Step size at its creation.
    dt: f64,
    /// Name of the contact; `None` for a model without contact.
    contact: Option<&'static str>,
    /// True for a supported model, which has an equilibrium.
    is_held: bool,
    /// Variables with states of the simulation.
    states: Vec<String>,
    probes: usize,
    /// Statements that read the simulation, with `{s}` for its variable.
    readers: Vec<String>,
}

/// Number of examples in a script.
const EXAMPLES: usize = 2;

/// Functions of the language with their examples.
pub fn examples() -> &'static [(String, String)] {
    static ALL: OnceLock<Vec<(String, String)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap();
        let registry = session.registry();
        registry.functions().iter().map(|function| (function.signature(), function.example.to_string())).collect()
    })
}

/// Numbers of the examples in the script of a seed; consecutive seeds use all examples.
pub fn examples_of(seed: u64) -> impl Iterator<Item = usize> {
    let count = examples().len();
    (0..EXAMPLES).map(move |index| (EXAMPLES * (seed as usize % count) + index) % count)
}

/// Writer of a script.
struct Writer {
    random: SplitMix,
    text: String,
    simulations: Vec<Known>,
    /// Number of names of variables and files in use.
    names: usize,
}

/// The script of a seed.
pub fn script(seed: u64) -> String {
    let mut writer = Writer { random: SplitMix(seed), text: String::new(), simulations: Vec::new(), names: 0 };
    writer.line("let soft = neo_hookean(#{ youngs_modulus: 400.0, poisson_ratio: 0.3, density: 1.0 });");
    writer.line("let slow = soft.relaxing(#{ shear_modulus: 60.0, relaxation_time: 0.05 });");
    writer.line("let damped = viscous(soft, #{ shear_viscosity: 0.5, bulk_viscosity: 0.5 });");
    writer.line("let heap = [];");
    writer.simulation();
    let count = 6 + writer.random.below(22);
    let places: Vec<(usize, usize)> = examples_of(seed).map(|example| (writer.random.below(count), example)).collect();
    for place in 0..count {
        writer.statement();
        for (_, example) in places.iter().filter(|(at, _)| *at == place) {
            writer.line(&format!("try {{\n{}\n}} catch (e) {{ print(`example: ${{e}}`); }}", examples()[*example].1));
        }
    }
    let mut text = writer.text;
    for known in &writer.simulations {
        let _ = writeln!(text, "print(`end {{{}.time}} ${{{0}.energy}} ${{{0}.steps}}`);", known.name);
    }
    text
}

impl Writer {
    fn line(&mut self, line: &str) {
        self.text += line;
        self.text.push('\n');
    }

    fn fresh(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}{}", self.names)
    }

    fn chance(&mut self, percent: usize) -> bool {
        self.random.below(100) < percent
    }

    /// A model and a simulation of it.
    fn simulation(&mut self) {
        if self.chance(40) {
            return self.scene();
        }
        let (model, body, name) = (self.fresh("m"), self.fresh("b"), self.fresh("s"));
        let material = *self.random.pick(&["soft", "slow", "damped"]);
        let title = *self.random.pick(&["drop", "drop", "plate two", "r/ing"]);
        let mut made = format!("let {model} = model(\"{title}\");\n");
        let (contact, is_held) = match self.random.below(4) {
            0 => {
                let cells = [2 + self.random.below(5), 1 + self.random.below(3)];
                let _ = writeln!(
                    made,
                    "let {body} = {model}.add_body(\"plate\", rectangle(#{{ size: [2.0, 1.0], cells: {cells:?} }}), {material});"
                );
                let _ = writeln!(made, "{model}.initial_velocity({body}, #{{ angular: 1.0, linear: [0.3, 0.1] }});");
                (None, false)
            }
            1 => {
                let _ = writeln!(
                    made,
                    "let {body} = {model}.add_body(\"bar\", rectangle(#{{ size: [2.0, 0.5], cells: [6, 2] }}), {material});"
                );
                let _ = writeln!(made, "{model}.fix({body}.boundary(\"left\"));\n{model}.gravity([0.0, -2.0]);");
                let _ = writeln!(made, "{model}.force({body}.boundary(\"right\"), [0.0, 1.0], |t| if t < 0.1 {{ 2.0 }} else {{ 0.5 }});");
                (None, true)
            }
            2 => {
                let around = 8 + 4 * self.random.below(4);
                let _ = writeln!(
                    made,
                    "let {body} = {model}.add_body(\"ring\", ring(#{{ inner_radius: 0.6, outer_radius: 1.0, cells: [1, {around}], \
                     center: [0.0, 1.05] }}), {material});"
                );
                let update = *self.random.pick(&["gap", "velocity", "persistency"]);
                let _ = writeln!(
                    made,
                    "{model}.gravity([0.5, -10.0]);\n{model}.add_contact(\"ground\", #{{ secondary: {body}.boundary(\"outer\"), \
                     primary: rigid_plane(#{{ point: [0.0, 0.0], normal: [0.0, 1.0] }}), update: \"{update}\" }});"
                );
                (Some("ground"), false)
            }
            _ => {
                let method = *self.random.pick(&["mortar", "node_to_segment", "dual_mortar"]);
                let _ = writeln!(
                    made,
                    "let {body} = {model}.add_body(\"top\", rectangle(#{{ size: [0.8, 0.5], cells: [4, 2], origin: [-0.4, 0.02] }}), \
                     {material});"
                );
                let _ = writeln!(
                    made,
                    "let low{model} = {model}.add_body(\"low\", rectangle(#{{ size: [2.0, 0.5], cells: [6, 2], origin: [-1.0, -0.5] }}), \
                     soft);"
                );
                let _ = writeln!(made, "{model}.fix(low{model}.boundary(\"bottom\"));\n{model}.gravity([0.0, -5.0]);");
                let _ = writeln!(
                    made,
                    "{model}.add_contact(\"pair\", #{{ secondary: {body}.boundary(\"bottom\"), primary: low{model}.boundary(\"top\"), \
                     method: {method}() }});"
                );
                (Some("pair"), false)
            }
        };
        let dt = *self.random.pick(&[0.004, 0.01, 0.007]);
        let integrator = *self.random.pick(&["energy_momentum", "energy_momentum", "midpoint", "trapezoidal", "newmark"]);
        let mut options = format!("integrator: {integrator}(), dt: {dt:?}");
        if self.chance(80) {
            let _ = write!(options, ", fields_every: {:?}", dt * *self.random.pick(&[1.0, 2.0, 3.5, 8.0]));
        }
        if self.chance(40) {
            let _ = write!(options, ", stills: {}", 2 + self.random.below(30));
        }
        let _ = write!(made, "let {name} = simulate({model}, #{{ {options} }});");
        self.line(&made);
        let readers = COMMON.iter().map(|text| text.replace("{b}", &body)).collect();
        self.simulations.push(Known { name, body, dt, contact, is_held, states: Vec::new(), probes: 0, readers });
    }

    /// A simulation of one of the scenes.
    fn scene(&mut self) {
        let scene = self.random.pick(SCENES);
        let (model, body, name) = (self.fresh("m"), self.fresh("b"), self.fresh("s"));
        let unique = self.names.to_string();
        let own = |text: &str| text.replace("{m}", &model).replace("{b}", &body).replace("{x}", &unique);
        let integrator = *self.random.pick(scene.integrators);
        let dt = if integrator == "statics" { 0.1 } else { *self.random.pick(&[0.004, 0.01]) };
        let mut options = format!("integrator: {integrator}(), dt: {dt:?}");
        if self.chance(60) {
            let _ = write!(options, ", fields_every: {:?}", dt * *self.random.pick(&[1.0, 2.0, 3.5, 8.0]));
        }
        self.line(&format!("let {model} = model(\"{model}\");\n{}\nlet {name} = simulate({model}, #{{ {options} }});", own(scene.model)));
        let readers = scene.readers.iter().chain(COMMON).map(|text| own(text)).collect();
        let (contact, is_held) = (scene.contact, scene.is_held);
        self.simulations.push(Known { name, body, dt, contact, is_held, states: Vec::new(), probes: 0, readers });
    }

    /// A random statement.
    fn statement(&mut self) {
        let index = self.random.below(self.simulations.len());
        let (name, body, dt, contact) = {
            let known = &self.simulations[index];
            (known.name.clone(), known.body.clone(), known.dt, known.contact)
        };
        match self.random.below(44) {
            0..=4 => {
                let count = 1 + self.random.below(12);
                self.line(&format!("{name}.step({count});"));
            }
            5..=7 => {
                let further = dt * (1 + self.random.below(25)) as f64;
                self.line(&format!("{name}.run_to({name}.time + {further:?});"));
            }
            8 | 9 => self.save(index),
            10 | 11 => self.restore(index),
            12..=14 => {
                let (steps, back) = (2 + self.random.below(7), self.random.below(9));
                self.line(&format!("{name}.step({steps});\ntry {{ {name}.back({back}); }} catch (e) {{ print(e); }}"));
            }
            15 if self.simulations.len() < 5 => {
                let branch = self.fresh("s");
                self.line(&format!("let {branch} = {name}.branch();"));
                let Known { is_held, readers, .. } = &self.simulations[index];
                let (is_held, readers) = (*is_held, readers.clone());
                self.simulations.push(Known { name: branch, body, dt, contact, is_held, states: Vec::new(), probes: 0, readers });
            }
            16 if self.simulations.len() < 4 => self.simulation(),
            17 => {
                let factor = *self.random.pick(&[0.5, 1.0, 0.7]);
                self.line(&format!("{name}.set(#{{ dt: {:?} }});", dt * factor));
            }
            18 => {
                let probe = self.simulations[index].probes;
                self.simulations[index].probes += 1;
                let tag = self.fresh("p");
                self.line(&format!("let {tag} = {name}.probe(\"{tag}\", {body}, [0.{probe}, 0.4]);\nprint({tag});"));
            }
            19 => self.hook(index),
            20 => {
                let file = self.fresh("picture");
                let ending = *self.random.pick(&["svg", "png"]);
                self.line(&format!("{name}.picture(\"{file}.{ending}\", #{{ width: 240 }});"));
            }
            21 | 22 => {
                // Some files are written repeatedly.
                let file = if self.chance(50) { "movie".into() } else { self.fresh("movie") };
                let ending = *self.random.pick(&["gif", "png"]);
                self.line(&format!("{name}.movie(\"{file}.{ending}\", #{{ width: 240, seconds: 1 }});"));
            }
            23 => {
                let file = if self.chance(50) { "page".into() } else { self.fresh("page") };
                self.line(&format!("report({name}, \"{file}.html\");"));
            }
            24 => {
                let file = self.fresh("table");
                let ending = *self.random.pick(&["csv", "parquet"]);
                self.line(&format!("{name}.table(\"{file}.{ending}\");\n{name}.plot(\"{file}.svg\", [\"total\", \"kinetic\"]);"));
            }
            25 => {
                let file = self.fresh("now");
                self.line(&format!("{name}.write_fields(\"{file}.vtu\");"));
            }
            26 => self.study(),
            27 => self.line(&format!("print({name});\nprint({name}.history.total.len());")),
            28 => {
                self.line(&format!(
                    "try {{ {name}.set(#{{ dt: 40.0, max_halvings: 0 }}); {name}.step(); }} catch (e) {{ print(`failed: ${{e}}`); }}"
                ));
                self.line(&format!("{name}.set(#{{ dt: {dt:?}, max_halvings: 7 }});"));
            }
            29 if self.simulations[index].is_held => {
                let later = self.random.below(2) as f64 * dt;
                self.line(&format!("try {{ print({name}.settle({name}.time + {later:?})); }} catch (e) {{ print(e); }}"));
            }
            30 => {
                let (rounds, at, back) = (3 + self.random.below(6), self.random.below(6), 1 + self.random.below(3));
                let state = self.fresh("v");
                self.line(&format!(
                    "let {state} = {name}.save();\nfor k in 0..{rounds} {{ {name}.step(3); if k == {at} {{ {name}.back({back}); }} \
                     if k == 4 {{ {name}.restore({state}); }} }}"
                ));
                self.simulations[index].states.push(state);
            }
            31 => {
                let field = *self.random.pick(&["von_mises", "pressure", "velocity"]);
                self.line(&format!("print({name}.momentum); print({name}.active); {name}.show(\"{}\");", "total"));
                let file = self.fresh("f");
                self.line(&format!("{name}.picture(\"{file}.svg\", #{{ field: \"{field}\", width: 240 }});"));
            }
            32 => {
                let key = self.fresh("r");
                self.line(&format!(
                    "result(\"{key}\", {name}.energy.total);\nwrite_table(\"{key}.csv\", [#{{ a: {name}.time, b: {name}.energy.strain }}]);"
                ));
                let file = self.fresh("c");
                self.line(&format!("let {file} = read_csv(\"table.csv\");\nprint({file}.size[1] * {name}.time);"));
            }
            33..=41 => {
                let reader = self.random.pick(&self.simulations[index].readers).replace("{s}", &name);
                self.line(&format!("try {{ {reader} }} catch (e) {{ print(e); }}"));
            }
            _ => {
                if let Some(contact) = contact {
                    self.line(&format!("let c = {name}.contact(\"{contact}\"); print(`${{c.force}} ${{c.gap}} ${{c.active}}`);"));
                } else {
                    self.line(&format!("if {name}.energy.kinetic > 0.2 {{ {name}.step(2); }} else {{ {name}.step(5); }}"));
                }
            }
        }
    }

    fn save(&mut self, index: usize) {
        let state = self.fresh("v");
        let name = self.simulations[index].name.clone();
        self.line(&format!("let {state} = {name}.save();"));
        self.simulations[index].states.push(state);
    }

    fn restore(&mut self, index: usize) {
        let known = &self.simulations[index];
        let name = known.name.clone();
        if known.states.is_empty() {
            return self.save(index);
        }
        let place = self.random.below(known.states.len());
        let state = self.simulations[index].states[place].clone();
        self.line(&format!("{name}.restore({state});"));
    }

    /// A closure after every step.
    fn hook(&mut self, index: usize) {
        let (name, contact) = (self.simulations[index].name.clone(), self.simulations[index].contact);
        let every = 2 + self.random.below(9);
        let reader = self.random.pick(&self.simulations[index].readers).replace("{s}", "sim");
        let action = match (self.random.below(7), contact) {
            (0, _) => "print(`${sim.time}: ${sim.energy.total}`)".to_string(),
            (1, Some(contact)) => format!("print(`${{sim.contact(\"{contact}\").force}}`)"),
            (2, _) => "heap.push(sim.save())".into(),
            (3, _) => "sim.picture(\"hook.svg\", #{ width: 240 })".into(),
            (4, _) => "sim.movie(\"hook.gif\", #{ width: 240, seconds: 1 })".into(),
            (5 | 6, _) if !reader.contains("step(") => format!("try {{ {reader} }} catch (e) {{ print(e); }}"),
            _ => "print(sim)".into(),
        };
        self.line(&format!("{name}.on_step(|sim| {{ if sim.steps % {every} == 0 {{ {action}; }} }});"));
    }

    /// A study of small runs.
    fn study(&mut self) {
        let inner = "let sky = model(\"sky\"); let plate = sky.add_body(\"plate\", rectangle(#{ size: [2.0, 1.0], cells: [2, 1] }), \
                     neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 })); \
                     sky.initial_velocity(plate, #{ angular: p.w }); \
                     let sim = simulate(sky, #{ integrator: energy_momentum(), dt: 0.01 }); sim.step(5);";
        let variable = self.fresh("rows");
        let line = if self.chance(60) {
            format!(
                "let {variable} = sweep(#{{ vary: #{{ w: [1.0, 2.0, 3.0] }}, run: |p| {{ {inner} print(`point ${{p.w}}`); \
                 if p.w == 2.0 {{ sim.back(2); }} #{{ e: sim.energy.total }} }} }});\nprint(format_table({variable}));"
            )
        } else {
            format!(
                "let {variable} = minimize(|p| {{ {inner} (sim.energy.strain - 0.001) ** 2.0 }}, \
                 #{{ bounds: #{{ w: [0.5, 2.0] }}, name: \"w\" }});\nprint({variable}.best);"
            )
        };
        self.line(&line);
    }
}
