//! Terms of other programs and textbooks, and the corresponding names in this language.

/// Words, and the entries of the reference that are meant.
const SYNONYMS: &[(&[&str], &[&str])] = &[
    (&["quasi-static", "quasistatic", "static", "equilibrium", "load step", "increment"], &["settle"]),
    (&["dirichlet", "displacement boundary", "imposed displacement", "encastre", "clamp"], &["fix", "prescribe"]),
    (&["neumann", "surface load"], &["traction", "pressure", "force"]),
    (&["friction", "coulomb", "stick-slip"], &["add_contact", "coulomb", "friction_curve", "add_joint"]),
    (&["roller"], &["fix"]),
    (&["symmetry"], &["add_symmetry", "fix"]),
    (&["periodic", "representative volume", "rve"], &["add_periodic"]),
    (&["b-bar", "bbar", "f-bar", "fbar", "locking", "incompressible", "hybrid", "mixed form"], &["add_body"]),
    (&["plane strain", "plane stress", "axisymmetric"], &["add_body"]),
    (&["restart", "snapshot"], &["save", "restore"]),
    (&["dashpot", "shock absorber"], &["add_damper"]),
    (&["damping", "rayleigh"], &["add_damping", "viscous", "relaxing"]),
    (&["relaxation", "prony", "maxwell", "viscoelastic"], &["relaxing", "viscous"]),
    (&["plasticity", "yield", "von mises", "hardening"], &["elastic_plastic", "hardening_curve"]),
    (&["hinge", "revolute", "slider", "ball joint", "prismatic", "connector"], &["add_joint"]),
    (&["self-contact", "self contact"], &["add_self_contact"]),
    (&["rigid body", "discrete rigid"], &["add_rigid_body"]),
    (&["rigid wall", "analytical rigid", "ground plane"], &["add_contact"]),
    (&["motor", "actuator", "servo"], &["add_motor", "add_actuator"]),
    (&["clearance", "opening"], &["contact"]),
    (&["interference", "press fit", "shrink fit", "overclosure"], &["add_contact", "settle"]),
    (&["modal", "eigenfrequency", "eigenvalue", "natural frequency"], &["modes"]),
    (&["frequency response", "steady-state dynamics"], &["harmonic_response"]),
    (&["riks", "arc-length", "snap-through"], &["follow_load", "buckling"]),
    (&["thermal expansion", "eigenstrain", "swelling"], &["grow"]),
    (&["paraview", "vtk", "vtu", "visualization", "visualisation"], &["write_fields", "simulate"]),
    (&["animation", "video"], &["movie"]),
    (&["python", "pandas", "excel", "spreadsheet"], &["table", "write_table"]),
    (&["glue", "bond", "weld", "mesh tie", "mpc"], &["tie"]),
    (&["tabular", "time series", "load curve"], &["table", "ramp"]),
    (&["parametric", "design of experiments", "doe"], &["sweep", "param"]),
    (&["unit system", "consistent units", "millimeter", "gigapascal"], &["units", "quantity"]),
    (&["preload", "pretension", "clamping force"], &["add_bolt", "add_joint"]),
    (&["backlash", "free play"], &["add_joint", "add_gear"]),
    (&["stroke", "piston"], &["add_actuator", "add_joint"]),
    (&["controller", "feedback", "pid"], &["on_step", "add_actuator", "add_motor"]),
    (&["drop test", "bounce", "impact", "collision"], &["add_contact", "initial_velocity"]),
    (
        &["conveyor", "turntable", "paddle", "blade", "cam follower", "moving wall"],
        &["rigid_plane", "rigid_polyline", "rigid_disk", "rigid_box"],
    ),
    (&["stress concentration", "notch", "safety factor", "hot spot"], &["extremes", "probe"]),
    (&["linearized stress", "stress classification", "membrane stress"], &["along"]),
    (&["hertz", "contact pressure", "contact area"], &["contact"]),
    (&["journal bearing", "bearing clearance"], &["add_contact", "add_joint"]),
    (&["optimization", "optimisation", "calibration", "identification"], &["minimize", "fit"]),
];

/// Words for which the language has no function, each with a sentence on the substitute.
const MISSING: &[(&[&str], &str)] = &[
    (
        &["cohesive", "crack", "fracture", "damage", "delamination", "debonding"],
        "no law breaks: bodies and bonds have no damage, and `tie` holds for good (docs/limits.md)",
    ),
    (
        &["fatigue", "rainflow", "s-n curve"],
        "there is no law of fatigue: `sim.probe` records the stresses at a point, for evaluation in another program",
    ),
    (
        &["wear", "archard"],
        "surfaces do not wear: `friction_work` of the history is the work to which a law of wear in another program applies",
    ),
    (
        &["lubrication", "oil film", "hydrodynamic", "reynolds equation"],
        "there is no pressure of a film: `add_bushing` or `add_damper` replace a film, and `coulomb` takes its shear stress per speed",
    ),
    (
        &["roughness", "asperit"],
        "surfaces are as smooth as their mesh: `penalty` in `add_contact` makes a contact compliant, `rough()` prevents sliding",
    ),
    (
        &["adhesion", "van der waals"],
        "contacts press only: `equality: true` in `add_contact` admits tension, `tie` holds surfaces together",
    ),
    (&["mass scaling"], "masses are never changed: implicit steps need no scaling, and `stable_step` returns the largest explicit one"),
    (&["hourglass", "reduced integration"], "all cells are fully integrated: there is no hourglass mode to control"),
    (
        &["submodel", "global-local"],
        "there are no submodels: `prescribe` moves the boundary of a finer model by a closure or a `table` of results of a coarser one",
    ),
    (&["heat transfer", "temperature", "thermomechanical"], "there are no temperatures: `grow` expands a body by a constant factor"),
    (
        &["beam element", "shell element", "truss", "membrane element"],
        "there are solids only: cells of second order bend well; see docs/limits.md",
    ),
];

/// Returns a sentence on the substitute for a term of the field that the language does not have.
pub fn missing(text: &str) -> Option<&'static str> {
    let text = text.to_lowercase();
    MISSING.iter().find(|(words, _)| words.iter().any(|word| text.contains(word))).map(|(_, sentence)| *sentence)
}

/// Returns the known terms in a text, each with the corresponding names.
pub fn meant(text: &str) -> Vec<(&'static str, &'static [&'static str])> {
    let text = text.to_lowercase();
    let known = |words: &[&'static str]| words.iter().copied().find(|word| text.contains(word));
    SYNONYMS.iter().filter_map(|(words, ours)| Some((known(words)?, *ours))).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::rc::Rc;

    use super::super::reference::Reference;
    use super::super::session::Session;
    use super::{MISSING, SYNONYMS, missing};
    use crate::script::language::observer::Silent;
    use crate::script::language::settings::Settings;

    #[test]
    fn what_is_meant_is_in_the_reference() {
        let session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).expect("the folder is there");
        let reference = Reference::new(&session.registry());
        for (words, ours) in SYNONYMS {
            for name in *ours {
                assert!(reference.find(name).is_ok(), "{words:?}: {name}");
            }
        }
        for (words, sentence) in MISSING {
            // Functions stand with or without parentheses, or behind an object; options and columns are no entries.
            let named = sentence.split('`').skip(1).step_by(2).filter(|code| !code.contains(':'));
            for name in named.map(|code| code.trim_start_matches("sim.").trim_end_matches("()")) {
                let is_else = ["friction_work", "penalty"].contains(&name);
                assert!(is_else || reference.find(name).is_ok(), "{words:?}: {name}");
            }
        }
        assert!(missing("Cohesive zone").is_some() && missing("friction").is_none());
    }
}
