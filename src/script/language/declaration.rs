//! Declarations of functions: a chain that begins with topic and name and ends with the body.
//!
//! Summary and example are links of the chain, so that a function without them does not compile. Parameters, the type of the returned
//! value and related functions may be left out.

use std::borrow::Cow;
use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult};

use super::function::{Call, Form, Function, Topic};
use super::handle::Handle;
use super::parameter::Parameter;

/// Begins the declaration of a function `name(…)`.
pub fn function(topic: Topic, name: &'static str) -> Undescribed {
    declaration(topic, Form::Function, name)
}

/// Begins the declaration of a method `object.name(…)` of objects of type `T`.
pub fn method_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed {
    declaration(topic, Form::Method(T::receiver()), name)
}

/// Begins the declaration of a property `object.name` of objects of type `T`.
pub fn property_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed {
    declaration(topic, Form::Property(T::receiver()), name)
}

/// Begins the declaration of `object["name"]` and `object.name` for every name, of objects of type `T`.
pub fn column_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed {
    declaration(topic, Form::Column(T::receiver()), name)
}

/// Begins the declaration of a function with a form.
pub fn declaration(topic: Topic, form: Form, name: &'static str) -> Undescribed {
    Undescribed { topic, form, name }
}

/// Declaration without summary.
pub struct Undescribed {
    topic: Topic,
    form: Form,
    name: &'static str,
}

impl Undescribed {
    /// Adds the summary, one sentence.
    pub fn summary(self, summary: &'static str) -> Described {
        let Undescribed { topic, form, name } = self;
        Described(Function {
            name,
            form,
            topic,
            summary,
            parameters: Vec::new(),
            returns: "",
            example: Cow::Borrowed(""),
            see_also: &[],
            body: Rc::new(|_| Ok(Dynamic::UNIT)),
        })
    }
}

/// Declaration without example.
pub struct Described(Function);

impl Described {
    /// Adds the parameters; optional ones last.
    pub fn parameters(mut self, parameters: Vec<Parameter>) -> Self {
        self.0.parameters = parameters;
        self
    }

    /// Adds the name of the type of the returned value.
    pub fn returns(mut self, name: &'static str) -> Self {
        self.0.returns = name;
        self
    }

    /// Adds names of related functions.
    pub fn see_also(mut self, names: &'static [&'static str]) -> Self {
        self.0.see_also = names;
        self
    }

    /// Adds the example, a script that runs.
    pub fn example(mut self, script: impl Into<Cow<'static, str>>) -> Exemplified {
        self.0.example = script.into();
        Exemplified(self.0)
    }
}

/// Declaration without body.
pub struct Exemplified(Function);

impl Exemplified {
    /// Completes the declaration by the native implementation.
    pub fn body(self, closure: impl Fn(&Call) -> Result<Dynamic, Box<EvalAltResult>> + 'static) -> Function {
        Function { body: Rc::new(closure), ..self.0 }
    }
}
