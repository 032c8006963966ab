//! Factors of products, from the registry of the language and the catalogues of the kernels.
//!
//! A new row of a catalogue is drawn automatically. Data that a script needs besides the name (the place of an obstacle, the ends of a
//! spring) are in `script.rs`; [`Catalogue::strangers`] lists rows without such data.

use std::path::Path;
use std::rc::Rc;

use conserva::elements::{CellKind, CellShape};
use conserva::integrators;
use conserva::materials;
use conserva::script::{Function, Kind, Parameter, Registry, Session, Settings, Silent};

use super::{Named, Product, script};

/// A feature with its rows, the simplest first.
pub struct Factor {
    /// Name.
    pub name: &'static str,
    /// Values of the feature, each a piece of script; the simplest first.
    pub rows: Vec<String>,
}

/// All factors.
pub struct Catalogue {
    /// The factors.
    pub factors: Vec<Factor>,
    /// Names of methods of a model that no factor uses.
    methods: Vec<String>,
    /// Names of methods and functions that create the objects of a factor.
    makers: Vec<(&'static str, String)>,
}

/// Obstacles that exist in the plane only.
const PLANE_OBSTACLES: [&str; 3] = ["rigid_disk", "rigid_ring", "rigid_polyline"];

/// Methods of a model that every product uses, or that do not affect a run.
const OTHER_METHODS: [&str; 9] =
    ["add_body", "add_contact", "add_joint", "check", "name", "bodies", "initial_velocity", "tie", "add_self_contact"];

/// Tasks: operations of a script on its simulation.
const TASKS: [&str; 12] = [
    "run",
    "settle",
    "settle_without_friction",
    "modes",
    "harmonic_response",
    "harmonic_base",
    "buckling",
    "follow_load",
    "restore",
    "back",
    "branch",
    "set",
];

/// Trials: a second run of the product in another way.
pub const TRIALS: [&str; 8] = ["once", "threads", "resume", "rotate", "translate", "units", "renumber", "process"];

/// Material outside of the catalogue of stored energies, which [`Catalogue::flowing`] draws.
const FLOWS: &str = "elastic_plastic";

/// Options of a body that make it rigid.
const RIGID: [&str; 2] = ["rigid", "rigid_numbers"];

fn registry() -> Rc<Registry> {
    let session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).expect("there is a folder");
    session.registry()
}

/// Names of the functions that return an object of a type.
fn functions_that_give(registry: &Registry, kind: &str) -> Vec<String> {
    let makes = |function: &&Rc<Function>| function.form.receiver().is_none() && function.returns == kind;
    registry.functions().iter().filter(makes).map(|function| function.name.to_string()).collect()
}

/// Names of the methods of a type that satisfy a condition.
fn methods(registry: &Registry, of: &str, accepts: impl Fn(&str) -> bool) -> Vec<String> {
    registry.members(of).map(|function| function.name.to_string()).filter(|name| accepts(name)).collect()
}

/// The options of a function.
fn keys(registry: &Registry, function: &str) -> Vec<Parameter> {
    let all = registry.named(function).flat_map(|function| function.parameters.clone());
    all.filter_map(|parameter| parameter.kind.keys().map(<[Parameter]>::to_vec)).flatten().collect()
}

/// Values that an option of a function accepts.
fn choices(registry: &Registry, function: &str, key: &str) -> Vec<String> {
    let of_key = keys(registry, function).into_iter().find(|parameter| parameter.name == key);
    match of_key.expect("the function has that option").kind {
        Kind::Choice(words) => words.iter().map(ToString::to_string).collect(),
        other => panic!("{function}: {key} is {other:?}"),
    }
}

fn with(first: &[&str], further: Vec<String>) -> Vec<String> {
    first.iter().map(ToString::to_string).chain(further).collect()
}

impl Catalogue {
    /// The factors of the current program.
    pub fn new() -> Self {
        let registry = registry();
        let plain_first = |mut rows: Vec<String>, first: &str| {
            let place = rows.iter().position(|row| row == first).expect("the catalogue has it");
            rows[..=place].rotate_right(1);
            rows
        };
        // No generator makes a mesh of pyramids alone.
        let is_made = |kind: &&CellKind| kind.row().cell_shape != CellShape::Pyramid;
        let cells = CellKind::ALL.iter().filter(is_made).map(|kind| kind.name().to_string()).collect();
        let materials = materials::CATALOGUE.iter().chain(materials::LINEAR).map(|row| row.title()).collect();
        let enforcement = keys(&registry, "add_contact")
            .into_iter()
            .filter(|key| matches!(key.kind, Kind::Number | Kind::Flag) && key.absent != conserva::script::Absent::Refused);
        let enforcement = enforcement.map(|key| key.name.to_string()).collect();
        let obstacles = functions_that_give(&registry, "Obstacle");
        let adders = methods(&registry, "Model", |name| {
            name.starts_with("add_")
                && !OTHER_METHODS.contains(&name)
                && !script::SUPPORTS.contains(&name)
                && name != "add_rigid_body"
                && name != "add_gear"
        });
        let joints = with(&["none"], choices(&registry, "add_joint", "kind"));
        let loads = methods(&registry, "Model", |name| {
            !name.starts_with("add_") && !OTHER_METHODS.contains(&name) && !script::SUPPORTS.contains(&name)
        });
        let loads = with(&["none"], loads).into_iter().chain(["grow".to_string()]).collect();
        let options = |function: &str, accepts: &dyn Fn(&str) -> bool| -> Vec<String> {
            keys(&registry, function).iter().map(|key| key.name.to_string()).filter(|name| accepts(name)).collect()
        };
        let rubbing = options("add_joint", &|name| name.starts_with("friction"));
        let shapes = options("add_contact", &|name| name.ends_with("_shape"));
        let integrators = functions_that_give(&registry, "Integrator");
        let amplitudes = functions_that_give(&registry, "TimeFunction");
        let laws = functions_that_give(&registry, "FrictionLaw");
        let makers =
            [("material", functions_that_give(&registry, "Material")), ("method", functions_that_give(&registry, "ContactMethod"))];
        let makers = makers.into_iter().flat_map(|(factor, names)| names.into_iter().map(move |name| (factor, name))).collect();
        let factor = |name: &'static str, rows: Vec<String>| Factor { name, rows };
        let words = |rows: &[&str]| with(rows, Vec::new());
        // The distributed solver needs programs that not every machine has.
        let solvers = choices(&registry, "simulate", "solver").into_iter().filter(|name| name != "mumps").collect();
        let factors = vec![
            factor("cell", plain_first(cells, "quad4")),
            factor("plane", plain_first(choices(&registry, "add_body", "plane"), "strain")),
            factor("shape", words(&["box", "round"])),
            factor("body", words(&["elastic", "viscous", "relaxing", RIGID[0], RIGID[1]])),
            factor("material", with(&[], materials).into_iter().chain(["hyperelastic".to_string()]).collect()),
            factor("dilatation", with(&["default"], choices(&registry, "add_body", "dilatation"))),
            factor("partner", with(&["none", "held_body", "free_body", "rigid_body", "tie", "self"], obstacles)),
            factor("moving", words(&["rest", "moving"])),
            factor("method", with(&["default"], functions_that_give(&registry, "ContactMethod"))),
            factor("exact", with(&["none"], shapes)),
            factor("enforcement", with(&["multipliers"], enforcement)),
            factor("update", with(&["default"], choices(&registry, "add_contact", "update"))),
            factor("friction", with(&["none", "number"], laws)),
            factor("part", with(&["none"], adders)),
            factor("joint", with(&[], joints).into_iter().chain(["gear".to_string()]).collect()),
            factor("rubbing", with(&["none"], rubbing)),
            factor("drive", words(&["free", "drive", "limits"])),
            factor("load", loads),
            factor("amplitude", with(&["number", "closure"], amplitudes)),
            factor("support", words(&["none", "fix", "fix_x", "prescribe", "prescribe_angle", "add_symmetry", "add_periodic"])),
            factor("integrator", integrators),
            factor("steps", words(&["fixed", "auto"])),
            factor("solver", plain_first(solvers, "auto")),
            factor("declared", words(&["none", "SI", "mm-N-t", "US"])),
            factor("task", words(&TASKS)),
            factor("trial", words(&TRIALS)),
        ];
        let drawn = |name: &String| factors.iter().any(|factor| factor.rows.contains(name)) || OTHER_METHODS.contains(&name.as_str());
        let methods = methods(&registry, "Model", |_| true).into_iter().filter(|name| !drawn(name)).collect();
        Catalogue { factors, methods, makers }
    }

    /// The factors of deformable bodies, with the elastic-plastic material in place of all others.
    pub fn flowing() -> Self {
        let mut catalogue = Catalogue::new();
        let material = catalogue.index("material");
        catalogue.factors[material].rows = vec![FLOWS.to_string()];
        let body = catalogue.index("body");
        catalogue.factors[body].rows.retain(|row| !RIGID.contains(&row.as_str()));
        catalogue
    }

    /// Index of a factor by its name.
    pub fn index(&self, name: &str) -> usize {
        self.factors.iter().position(|factor| factor.name == name).unwrap_or_else(|| panic!("no factor {name}"))
    }

    /// Product that has the first, simplest row of every factor.
    pub fn plain(&self) -> Product {
        Product { rows: vec![0; self.factors.len()], seed: 0 }
    }

    /// The plain product with given rows, each written as `factor=row`.
    pub fn product(&self, given: &str) -> Product {
        let mut product = self.plain();
        for word in given.split_whitespace() {
            let (name, row) = word.split_once('=').unwrap_or_else(|| panic!("{word}: write factor=row"));
            if name == "seed" {
                product.seed = row.parse().expect("a seed is a number");
                continue;
            }
            // Titles of materials contain blanks, which are underscores here.
            let is_it = |known: &&String| known.replace(' ', "_") == row.replace(' ', "_");
            let index = self.index(name);
            let place = self.factors[index].rows.iter().position(|known| is_it(&known));
            product.rows[index] = place.unwrap_or_else(|| panic!("{name} has no row {row}"));
        }
        product
    }

    /// Names of the catalogue rows that are never drawn, or that have no script.
    pub fn strangers(&self) -> Vec<String> {
        let unknown = |factor: &str, known: &dyn Fn(&str) -> bool| {
            let rows = &self.factors[self.index(factor)].rows;
            rows.iter().filter(|row| !known(row)).map(|row| format!("{factor}: {row}")).collect::<Vec<String>>()
        };
        let mut found: Vec<String> =
            self.methods.iter().filter(|name| !matches!(&name[..], "add_rigid_body" | "add_gear")).cloned().collect();
        found.extend(unknown("partner", &|row| {
            ["none", "held_body", "free_body", "rigid_body", "tie", "self"].contains(&row) || script::obstacle(row).is_some()
        }));
        found.extend(unknown("friction", &|row| ["none", "number"].contains(&row) || script::friction_law(row).is_some()));
        found.extend(unknown("part", &|row| row == "none" || script::PARTS.contains(&row)));
        found.extend(unknown("load", &|row| row == "none" || script::LOADS.contains(&row)));
        found.extend(unknown("rubbing", &|row| row == "none" || script::RUBBING.contains(&row)));
        found.extend(unknown("exact", &|row| ["none", "secondary_shape", "primary_shape"].contains(&row)));
        found.extend(unknown("amplitude", &|row| script::AMPLITUDES.contains(&row)));
        for (factor, name) in self.makers.iter().filter(|(_, name)| name != FLOWS) {
            let rows = &self.factors[self.index(factor)].rows;
            if !rows.iter().any(|row| row.split(',').next() == Some(name)) {
                found.push(format!("{factor}: {name}"));
            }
        }
        let schemes = integrators::CATALOGUE.iter().chain(integrators::EXPLICIT).chain(integrators::STATIC);
        let rows = &self.factors[self.index("integrator")].rows;
        found.extend(
            schemes.filter(|scheme| !rows.iter().any(|row| row == scheme.name)).map(|scheme| format!("integrator: {}", scheme.name)),
        );
        found
    }

    /// Replaces rows that have no effect in combination with the others: a friction law without contact, a material of a rigid body.
    pub fn normalized(&self, product: &Product) -> Product {
        let mut product = product.clone();
        // A replaced row may make another one ineffective.
        for _ in 0..2 {
            let named = Named { catalogue: self, product: &product };
            let dropped: Vec<usize> = (0..self.factors.len()).filter(|&index| !self.is_meant(named, self.factors[index].name)).collect();
            dropped.into_iter().for_each(|index| product.rows[index] = 0);
        }
        product
    }

    fn is_meant(&self, product: Named, factor: &str) -> bool {
        let is_plane = is_plane(product.row("cell"));
        let deforms = !product.is("body", &RIGID);
        let touches = !product.is("partner", &["none", "tie"]);
        let is_obstacle = product.row("partner").starts_with("rigid_") && product.row("partner") != "rigid_body";
        match factor {
            "plane" => is_plane,
            "material" | "dilatation" => deforms,
            "partner" if is_obstacle => {
                product.row("partner") == "rigid_plane" || is_plane == PLANE_OBSTACLES.contains(&product.row("partner"))
            }
            "moving" => is_obstacle,
            "method" => touches && !is_obstacle,
            "exact" => touches,
            "enforcement" | "update" | "friction" => touches,
            "part" => product.row("part") != "add_chamber" || (is_plane && product.row("shape") == "round"),
            "drive" | "rubbing" => product.row("joint") != "none",
            "amplitude" => {
                product.is("load", &["gravity", "rotating_frame", "traction", "force", "pressure", "torque"])
                    || product.is("support", &["prescribe", "prescribe_angle"])
                    || product.is("part", &["add_actuator", "add_motor"])
                    || (product.row("joint") != "none" && product.row("drive") == "drive")
                    || product.row("moving") == "moving"
            }
            _ => true,
        }
    }
}

/// True for plane elements.
pub fn is_plane(cell: &str) -> bool {
    CellKind::ALL.iter().any(|kind| kind.name() == cell && kind.dimension() == 2)
}

/// True for elements of second order.
pub fn is_quadratic(cell: &str) -> bool {
    CellKind::ALL.iter().any(|kind| kind.name() == cell && kind.is_quadratic())
}

/// Plane cells whose extrusion gives wedges.
pub fn wedge_section(cell: &str) -> Option<&'static str> {
    match cell {
        "wedge6" => Some("tri3"),
        "wedge15" => Some("tri6"),
        _ => None,
    }
}
