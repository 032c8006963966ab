//! Properties of a model.

use super::handle::{BodyHandle, ModelHandle};
use crate::script::api::examples::plate_example;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        member("press", "name", "the name of the model", "String", |ModelHandle(model)| model.borrow().model.name.clone().into()),
        member("press", "bodies", "the bodies of the model, in the order in which they were added", "Array", |model: ModelHandle| {
            let count = model.0.borrow().model.bodies.len();
            (0..count).map(|index| Dynamic::from(BodyHandle { model: model.clone(), index })).collect::<Array>().into()
        }),
    ]
}

/// Script function for a property of a model or of a body, which is named `object` in the example.
pub fn member<T: Handle>(
    object: &str,
    name: &'static str,
    summary: &'static str,
    returns: &'static str,
    read: fn(T) -> Dynamic,
) -> Function {
    property_of::<T>(Topic::Model, name)
        .summary(summary)
        .returns(returns)
        .see_also(&["add_body"])
        .example(plate_example(&format!("print({object}.{name});")))
        .body(move |_, object| Ok(read(object)))
}
