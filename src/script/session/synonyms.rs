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
    (&["optimization", "optimisation", "calibration", "identification"], &["minimize", "fit"]),
];

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
    use super::SYNONYMS;
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
    }
}
