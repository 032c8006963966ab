//! Time integrators in scripts: one function for each row of the catalogue.

use crate::integrators::{self, Family, Scheme};
use crate::script::language::digits::number_text;
use crate::script::language::prelude::*;

/// A time integrator in a script.
#[derive(Clone)]
pub struct IntegratorHandle(pub Scheme);

impl Handle for IntegratorHandle {
    const NAME: &'static str = "Integrator";
    const MAKER: &'static str = "make one with `energy_momentum()`, `mean_value()`, `energy_decaying()`, `midpoint()`, `trapezoidal()`, \
         `backward_euler()`, `newmark()`, `hht()`, `wbz()`, `generalized_alpha()`, `bdf2()`, `tr_bdf2()`, `triple_jump()`, \
         `central_differences()` or `statics()`";

    fn describe(&self) -> String {
        let title = title(&self.0);
        if title.ends_with(')') { title } else { format!("{title}()") }
    }
}

/// Returns the title of an integrator: its name, or the call that makes it if its numbers differ from the defaults.
pub fn title(integrator: &Scheme) -> String {
    if integrators::CATALOGUE.iter().chain(integrators::EXPLICIT).chain(integrators::STATIC).any(|row| *row == integrator) {
        return integrator.name.into();
    }
    if let Some(lumping) = integrator.lumping() {
        return format!("{}(#{{ mass: \"{}\" }})", integrator.name, lumping.name());
    }
    let given: Vec<String> = integrator.given().map(|(name, value)| format!("{name}: {}", number_text(value))).collect();
    format!("{}(#{{ {} }})", integrator.name, given.join(", "))
}

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    integrators::CATALOGUE.iter().map(|&integrator| integrator_function(integrator)).collect()
}

fn integrator_function(integrator: &'static Scheme) -> Function {
    let family = integrators::FAMILIES.iter().find(|family| family.default == integrator);
    let keys = |family: &Family| family.parameters.iter().map(Parameter::of_catalogue).collect();
    let parameters = family.map(|family| {
        let options = Parameter::map("options", "the numbers of the method").keys(keys(family));
        options.otherwise("its defaults")
    });
    let example = match family.and_then(|family| family.parameters.last()) {
        Some(last) => format!("print({}());\nprint({0}(#{{ {}: {:?} }}));", integrator.name, last.name, last.default.unwrap_or_default()),
        None => format!("print({}());", integrator.name),
    };
    function(Topic::Simulation, integrator.name)
        .summary(integrator.summary)
        .parameters(parameters.into_iter().collect())
        .see_also(&["simulate"])
        .example(example)
        .body(move |call| {
            let Some(family) = family else { return Ok(IntegratorHandle(*integrator)) };
            let (options, mut values) = (call.options("options")?, [0.0; 2]);
            for (value, parameter) in values.iter_mut().zip(family.parameters) {
                *value = options.number(parameter.name)?;
            }
            Ok(IntegratorHandle((family.make)(values)))
        })
}
