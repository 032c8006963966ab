//! Words of the language that are no functions: values of options, columns of the history, keys of the summary, findings.

use crate::dynamics::{LedgerRow, Quantity, RunFindingKind, UPDATE_RULES};
use crate::elements::CellKind;
use crate::output::{Field, KEYS};

/// A word of the language that is no function: the value of an option, or the name of a column.
#[derive(Clone, Debug)]
pub struct Word {
    /// The word as written in a script.
    pub name: &'static str,
    /// Catalogue of the word, such as `update rule of a contact pair`.
    pub group: &'static str,
    /// Description, one sentence.
    pub summary: String,
}

/// Descriptions of the columns of the history.
const COLUMNS: &[(&str, &str)] = &[
    ("step", "the number of the accepted step, 0 for the beginning; a step that is halved counts as two"),
    ("time", "the time at the end of the step"),
    ("dt", "the size of the step"),
    ("kinetic", "the kinetic energy"),
    ("strain", "the strain energy"),
    ("potential", "the potential energy of gravity, springs, viscous materials and penalty potentials, and the `reserve`"),
    ("total", "the sum of the three energies"),
    ("load_work", "the work of loads and prescribed displacements in this step"),
    (
        "contact_work",
        "the work of contact between bodies in this step, by which the update rule gap dissipates energy; never positive in motion; in \
         statics the trapezoidal rule, of either sign",
    ),
    ("friction_work", "the work of friction in contacts and joints in this step, which turns into heat; never positive"),
    ("dissipation", "the heat of viscous materials, dampers and drag and the loss of impacts of rigid bodies in this step, never negative"),
    (
        "energy_defect",
        "change of `total` - `load_work` - `contact_work` - `friction_work` + `dissipation` in this step: round-off when the scheme \
         conserves",
    ),
    ("momentum_x", "the linear momentum along x"),
    ("momentum_y", "the linear momentum along y"),
    ("momentum_z", "the linear momentum along z"),
    ("angular_momentum", "the angular momentum about the origin; in space its length"),
    ("angular_momentum_x", "the angular momentum about the x axis"),
    ("angular_momentum_y", "the angular momentum about the y axis"),
    ("angular_momentum_z", "the angular momentum about the z axis"),
    ("momentum_defect", "the largest change of linear momentum in this step that neither loads nor supports explain"),
    ("angular_momentum_defect", "the largest change of angular momentum in this step that neither loads nor supports explain"),
    (
        "newton_iterations",
        "the Newton iterations of the step, those of attempts that failed and of larger steps that were refused included",
    ),
    ("factorizations", "the numeric factorizations of the step, counted as its iterations"),
    ("halvings", "how often the step was tried and halved before it was accepted; what is halved untried is not counted"),
    ("active", "the number of closed contact nodes"),
    ("max_penetration", "the largest depth of a node of either side in the other body, point by point"),
    ("reserve", "the stored impact energy of the update rule velocity until the contact opens, part of `potential`"),
];

/// Returns all words, catalogue by catalogue.
pub fn words() -> Vec<Word> {
    let mut all = Vec::new();
    let mut add = |name, group, summary: String| all.push(Word { name, group, summary });
    for rule in UPDATE_RULES {
        add(rule.name, "update rule of a contact pair", rule.summary.into());
    }
    for kind in CellKind::ALL {
        add(kind.name(), "cell kind", kind.summary().into());
    }
    let with_dimension = |summary: &str, dimension: &str| match dimension {
        "1" => summary.to_string(),
        _ => format!("{summary} [{dimension}]"),
    };
    for field in Field::all() {
        add(field.name(), "field of a picture", with_dimension(field.words(), field.dimension()));
    }
    for Quantity { name, dimension } in LedgerRow::columns(3) {
        let summary = COLUMNS.iter().find(|(known, _)| *known == name).map_or("", |(_, summary)| summary);
        add(name, "column of the history", with_dimension(summary, dimension));
    }
    for (name, summary) in KEYS {
        add(name, "key of summary.json", (*summary).into());
    }
    for (name, summary) in RunFindingKind::ALL {
        add(name, "finding of a run", (*summary).into());
    }
    all
}
