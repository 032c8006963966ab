//! Properties of a model.

use super::handle::{BodyHandle, ModelHandle};
use crate::script::api::examples::plate_example;
use crate::script::language::declaration::declaration;
use crate::script::language::handle::Receiver;
use crate::script::language::prelude::*;

/// Script functions defined in this file.
pub fn functions() -> Vec<Function> {
    vec![
        member(ModelHandle::receiver(), "name", "the name of the model", "String", |call| {
            call.receiver::<ModelHandle>().0.borrow().model.name.clone().into()
        }),
        member(ModelHandle::receiver(), "bodies", "the bodies of the model, in the order in which they were added", "Array", |call| {
            let model = call.receiver::<ModelHandle>();
            let count = model.0.borrow().model.bodies.len();
            (0..count).map(|index| Dynamic::from(BodyHandle { model: model.clone(), index })).collect::<Array>().into()
        }),
    ]
}

/// Script function for a property of a model or of a body.
pub fn member(
    receiver: Receiver,
    name: &'static str,
    summary: &'static str,
    returns: &'static str,
    read: fn(&Call) -> Dynamic,
) -> Function {
    let object = if receiver == ModelHandle::receiver() { "press" } else { "plate" };
    declaration(Topic::Model, Form::Property(receiver), name)
        .summary(summary)
        .returns(returns)
        .see_also(&["add_body"])
        .example(plate_example(&format!("print({object}.{name});")))
        .body(move |call| Ok(read(call)))
}
