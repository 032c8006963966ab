//! A material in a script.

use crate::materials::{HYPERELASTIC, Material, Viscosity};
use crate::script::language::digits::{number_text, vector_text};
use crate::script::language::handle::Handle;

/// A material in a script.
#[derive(Clone)]
pub struct MaterialHandle(pub Material);

impl Handle for MaterialHandle {
    const NAME: &'static str = "Material";
    const MAKER: &'static str = "make one with a material function such as `neo_hookean`";

    fn describe(&self) -> String {
        if let Some(constants) = self.0.plasticity() {
            return super::flow_text::describe(constants);
        }
        let mut entries = Vec::new();
        if let (HYPERELASTIC, Some(energy)) = (self.0.name(), self.0.energy()) {
            entries.push(format!("energy: \"{}\"", energy.energy.text()));
            entries.extend(energy.volumetric.iter().map(|text| format!("volumetric: \"{}\"", text.text())));
            let fibers: Vec<String> = energy.fibers.iter().map(|fiber| vector_text(fiber)).collect();
            if !fibers.is_empty() {
                entries.push(format!("fibers: [{}]", fibers.join(", ")));
            }
        }
        entries.extend(self.0.constants().iter().map(|(name, value)| format!("{name}: {}", number_text(*value))));
        let form = self.0.volumetric_form().filter(|form| !form.is_usual());
        entries.extend(form.map(|form| format!("volumetric: \"{}\"", form.name)));
        let mut text = format!("{}(#{{ {} }})", self.0.name(), entries.join(", "));
        let Viscosity { shear, bulk, branches } = self.0.viscosity();
        if *shear > 0.0 || *bulk > 0.0 {
            let [shear, bulk] = [*shear, *bulk].map(number_text);
            text += &format!(".viscous(#{{ shear_viscosity: {shear}, bulk_viscosity: {bulk} }})");
        }
        for branch in branches {
            let [modulus, time] = [branch.shear_modulus, branch.relaxation_time].map(number_text);
            text += &format!(".relaxing(#{{ shear_modulus: {modulus}, relaxation_time: {time} }})");
        }
        text
    }
}
