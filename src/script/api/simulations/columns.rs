//! Columns of the history of a simulation after those of the ledger: totals of contact pairs, reactions of supports, quantities of springs
//! and other force elements, forces of joints, impacts of rigid bodies, probes.

use crate::dynamics::{ContactTotals, JointTotals, LedgerRow, Model, PartTotals, ProbeValues, Quantity, Reaction};

/// A material point whose motion is recorded.
#[derive(Clone)]
pub struct Probe {
    /// Name of the probe.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// Node in the mesh of the body.
    pub node: usize,
}

/// Column of models with contacts between rigid sides: energy that impacts lost to restitution in a step.
const IMPACT_LOSS: &str = "impact_loss";

/// Dimension of works and heat.
const ENERGY: &str = "energy";

/// Column of bodies with plasticity: heat of plastic flow since the start `[energy]`.
const PLASTIC_WORK: &str = "plastic_work";

/// Column of a history: its name, and its dimension as in [`Quantity::dimension`].
pub type HistoryColumn = (String, &'static str);

/// Names of history columns, without their dimensions.
pub fn names(columns: Vec<HistoryColumn>) -> Vec<String> {
    columns.into_iter().map(|(name, _)| name).collect()
}

/// Columns of a history: those of the ledger, of the model and of probes.
pub fn history_columns(model: &Model, probes: &[Probe]) -> Vec<HistoryColumn> {
    let ledger = LedgerRow::columns(model.dimension()).into_iter().map(|column| (column.name.to_string(), column.dimension));
    ledger.chain(model_columns(model)).chain(probe_columns(model, probes)).collect()
}

/// Returns the columns of the history of a model: contact pairs, boundaries with supports, force elements such as springs, joints, and
/// impacts of rigid bodies.
pub fn model_columns(model: &Model) -> Vec<HistoryColumn> {
    fn of<'a>(owner: &'a str, columns: impl IntoIterator<Item = Quantity> + 'a) -> impl Iterator<Item = HistoryColumn> + 'a {
        columns.into_iter().map(move |column| (format!("{owner}.{}", column.name), column.dimension))
    }
    let dimension = model.dimension();
    let mut columns: Vec<HistoryColumn> =
        model.contact_names().into_iter().flat_map(|name| of(name, ContactTotals::columns(dimension))).collect();
    for name in model.reaction_names() {
        columns.extend(of(&format!("{name}.reaction"), Reaction::columns(dimension)));
    }
    columns.extend(model.parts.iter().flat_map(|part| of(part.name(), PartTotals::columns(&**part))));
    columns.extend(model.joints.iter().flat_map(|joint| of(&joint.name, JointTotals::columns(joint, dimension))));
    columns.extend(model.has_rigid_contacts().then(|| (IMPACT_LOSS.to_string(), ENERGY)));
    columns.extend(model.flowing_bodies().map(|body| (format!("{}.{PLASTIC_WORK}", body.name), ENERGY)));
    columns
}

/// Columns of probes in a history.
pub fn probe_columns(model: &Model, probes: &[Probe]) -> Vec<HistoryColumn> {
    let columns = ProbeValues::columns(model.dimension());
    probes
        .iter()
        .flat_map(|probe| columns.iter().map(move |column| (format!("{}.{}", probe.name, column.name), column.dimension)))
        .collect()
}

/// Returns the values of the columns of a row that follow the ledger's own columns.
pub fn further_values(model: &Model, row: &LedgerRow) -> Vec<f64> {
    let dimension = model.dimension();
    let mut values: Vec<f64> = row.contacts.iter().flat_map(|totals| totals.values(dimension)).collect();
    // Before the first step, contact has no values.
    let contacts = model.contact_names().len() * ContactTotals::columns(dimension).len();
    values.resize(contacts, f64::NAN);
    values.extend(row.reactions.iter().flat_map(|reaction| reaction.values(dimension)));
    values.resize(contacts + model.reaction_names().len() * Reaction::columns(dimension).len(), f64::NAN);
    values.extend(model.parts.iter().zip(&row.parts).flat_map(|(part, totals)| totals.values(&**part)));
    let (joints, known) = (&model.joints, values.len());
    values.extend(joints.iter().zip(&row.joints).flat_map(|(joint, totals)| totals.values(joint, dimension)));
    values.resize(known + joints.iter().map(|joint| JointTotals::columns(joint, dimension).len()).sum::<usize>(), f64::NAN);
    values.extend(model.has_rigid_contacts().then_some(row.impact));
    let known = values.len();
    values.extend(&row.plastic_work);
    values.resize(known + model.flowing_bodies().count(), 0.0);
    values.extend(row.probes.iter().flat_map(|probe| probe.values(dimension)));
    values
}
