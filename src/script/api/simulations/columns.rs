//! The columns of a simulation's history behind those of the ledger: totals of contact pairs, reactions of supports, readings of springs
//! and other parts, what joints exert, impacts of rigid bodies, values of probes.

use crate::dynamics::{ContactTotals, JointTotals, LedgerRow, Model, PartTotals, ProbeValues, Reaction};

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

/// Column of bodies with plasticity: heat of plastic flow since the start `[energy]`.
const PLASTIC_WORK: &str = "plastic_work";

/// Returns the names of the history's columns: contact pairs, boundaries with supports, force elements such as springs, joints, and impacts
/// of rigid bodies.
pub fn model_columns(model: &Model) -> Vec<String> {
    let contacts = ContactTotals::columns(model.dimension());
    let mut names: Vec<String> =
        model.contact_names().iter().flat_map(|name| contacts.iter().map(move |column| format!("{name}.{column}"))).collect();
    let reactions = Reaction::columns(model.dimension());
    names.extend(model.reaction_names().iter().flat_map(|name| reactions.iter().map(move |column| format!("{name}.reaction.{column}"))));
    names.extend(model.parts.iter().flat_map(|part| PartTotals::columns(&**part).map(|column| format!("{}.{column}", part.name()))));
    for joint in &model.joints {
        names.extend(JointTotals::columns(joint, model.dimension()).iter().map(|column| format!("{}.{column}", joint.name)));
    }
    names.extend(model.has_rigid_contacts().then(|| IMPACT_LOSS.to_string()));
    names.extend(model.flowing_bodies().map(|body| format!("{}.{PLASTIC_WORK}", body.name)));
    names
}

/// Names of the history's columns of probes.
pub fn probe_columns(model: &Model, probes: &[Probe]) -> Vec<String> {
    let columns = ProbeValues::columns(model.dimension());
    probes.iter().flat_map(|probe| columns.iter().map(move |column| format!("{}.{column}", probe.name))).collect()
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
