//! `units`: declaration of the consistent units of a script.
//!
//! One declaration holds for the whole script, because quantities and materials are made before there is a model, and because models of one
//! script share meshes and materials.

use std::cell::{Cell, RefCell};

use crate::bodies::Plane;
use crate::dynamics::Model;
use crate::output::{ModelUnits, SETS, Unit, UnitError, UnitSet, UnitSetError};
use crate::script::language::prelude::*;
use crate::script::language::wording::{did_you_mean, joined};

/// Names of the parameters of `units`.
const NAMES: [&str; 6] = ["first", "second", "third", "fourth", "fifth", "sixth"];

/// Units that the script has declared.
#[derive(Default)]
pub struct DeclaredUnits {
    set: RefCell<Option<UnitSet>>,
    /// Place of the declaration in words.
    place: RefCell<String>,
    /// True from the first simulation on.
    is_settled: Cell<bool>,
}

impl DeclaredUnits {
    /// Units declared elsewhere, such as in the session for which a worker computes.
    pub fn of_names(names: &[String]) -> Self {
        DeclaredUnits { set: RefCell::new(UnitSet::of(names).ok()), ..DeclaredUnits::default() }
    }

    /// Names of the declared units; empty without a declaration.
    pub fn names(host: &Host) -> Vec<String> {
        Self::set(host).map_or(Vec::new(), |set| set.names().into_iter().map(String::from).collect())
    }

    /// Set of units that the script has declared; `None` without a declaration.
    pub fn set(host: &Host) -> Option<UnitSet> {
        host.slots.get::<DeclaredUnits>().set.borrow().clone()
    }

    /// Refuses declarations from now on: the files of a simulation contain its units.
    pub fn settle(host: &Host) {
        host.slots.get::<DeclaredUnits>().is_settled.set(true);
    }

    fn declare(&self, call: &Call, set: UnitSet) -> Result<(), Failure> {
        let known = self.set.borrow().clone();
        match known {
            Some(known) if known == set => return Ok(()),
            Some(known) => {
                let failure = call.fail(format!("the units of this script are {} already", joined(&known.names(), "and"))).code("C1074");
                let place = self.place.borrow();
                let failure = if place.is_empty() { failure } else { failure.cause(format!("they are declared at {place}")) };
                return Err(failure.hint("call `units` once, at the top; `quantity(…)` converts what is in other units"));
            }
            None if self.is_settled.get() => {
                let failure = call.fail("`units` comes after a simulation was made").code("C1075");
                return Err(failure.cause("its files name no units").hint("call `units` at the top of the script"));
            }
            None => {}
        }
        *self.place.borrow_mut() = call.place(&Target::Call).map(|place| place.to_string()).unwrap_or_default();
        *self.set.borrow_mut() = Some(set);
        Ok(())
    }
}

/// Units of the results of a model; `None` where none are declared.
pub fn model_units(host: &Host, model: &Model) -> Option<ModelUnits> {
    let is_axisymmetric = model.bodies.iter().any(|body| body.formulation.plane == Plane::Axisymmetric);
    let is_per_thickness = model.dimension() == 2 && !is_axisymmetric;
    DeclaredUnits::set(host).map(|set| ModelUnits { set, is_per_thickness })
}

/// The function `units`.
pub fn units() -> Function {
    let names = NAMES.into_iter().enumerate().map(|(index, name)| match index {
        0 => Parameter::text(
            name,
            "a set by name (`\"SI\"`, `\"CGS\"`, `\"US\"`: inches, pounds-force and seconds), units joined by hyphens (`\"mm-N-t\"`, \
             `\"mm-kg-ms\"`), or a unit, followed by at least two further ones from which mass, length and time follow",
        ),
        _ => Parameter::text(name, "a further unit, such as `\"MPa\"`, which must fit the others").otherwise("none"),
    });
    function(Topic::Numbers, "units")
        .summary(
            "declares the consistent units in which the numbers of the script are, once, at its top: plots, reports, tables and files name \
             them, `quantity` and its short forms convert to them, and implausible material constants cause a warning; computed numbers do \
             not change",
        )
        .parameters(names.collect())
        .see_also(&["quantity", "in_unit"])
        .example(
            "units(\"mm\", \"N\", \"MPa\", \"t\", \"s\"); // or units(\"mm-N-t\")\nlet steel = neo_hookean(#{ youngs_modulus: gpa(210), \
                  poisson_ratio: 0.3, density: kg_m3(7850) });\nprint(steel);",
        )
        .body(|call| {
            let set = set_of(call)?;
            call.host.slots.get::<DeclaredUnits>().declare(call, set)?;
            Ok(())
        })
}

/// Set of units in a call of `units`.
fn set_of(call: &Call) -> Result<UnitSet, Failure> {
    let given: Vec<&str> = NAMES.into_iter().filter(|name| call.argument(name).is_given()).collect();
    let mut names: Vec<String> = given.iter().map(|name| call.text(name)).collect::<Result<_, _>>()?;
    let is_set = names.len() == 1;
    if let ([name], true) = (&names[..], is_set) {
        match UnitSet::members(name) {
            Some(members) => names = members,
            None if Unit::parse(name).is_err() => {
                let sets: Vec<&str> = SETS.iter().map(|(name, _)| *name).chain(["mm-N-t", "mm-kg-ms", "m-kg-s"]).collect();
                let failure = call.argument("first").fail(format!("there is no set of units \"{name}\"")).code("C1071");
                let near = did_you_mean(name, sets.iter().copied()).map(|hint| hint.replace('`', "\""));
                return Err(failure.hint(near.unwrap_or_else(|| "write \"SI\", or units joined by hyphens, such as \"mm-N-t\"".into())));
            }
            None => {}
        }
    }
    let at = |index: usize| call.argument(if is_set { "first" } else { given[index] });
    UnitSet::of(&names).map_err(|error| {
        let title = error.to_string();
        match error {
            UnitSetError::Unit { index, error } => refused_unit(at(index).fail(title), &error),
            UnitSetError::Twice { indices: [first, second], .. } => {
                at(second).fail(title).code("C1072").label(format!("beside {}", names[first])).hint("name one unit of each dimension")
            }
            UnitSetError::Open { .. } => {
                let hint = "name units from which mass, length and time follow, such as \"mm\", \"N\", \"t\" or \"m\", \"kg\", \"s\"";
                call.fail(title).code("C1073").hint(hint)
            }
            UnitSetError::Inconsistent { index, fitting, dimension, .. } => {
                let failure = at(index).fail(format!("the units are not consistent: {title}")).code("C1076");
                failure
                    .label(format!("{} is another unit of {dimension}", names[index]))
                    .hint(format!("write \"{fitting}\" in place of \"{}\"", names[index]))
            }
        }
    })
}

/// Completes the failure of an invalid unit expression.
pub fn refused_unit(failure: Failure, error: &UnitError) -> Failure {
    let near = match error {
        UnitError::Unknown(name) => did_you_mean(name, Unit::names()).map(|hint| hint.replace('`', "\"")),
        UnitError::Malformed { .. } => None,
    };
    let usual = "units are products such as \"kg/m^3\", \"N/mm\" or \"MPa\"; there are prefixes from \"n\" to \"T\"";
    failure.code("C1077").hint(near.unwrap_or_else(|| usual.into()))
}
