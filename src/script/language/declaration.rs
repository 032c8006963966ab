//! Declarations of functions: a chain that begins with topic and name and ends with the body.
//!
//! Summary and example are links of the chain, so that a function without them does not compile. Parameters, the type of the returned
//! value and related functions may be left out.

use std::borrow::Cow;
use std::marker::PhantomData;
use std::rc::Rc;

use rhai::{Array, Dynamic, EvalAltResult, Map};

use super::arguments::Options;
use super::function::{Call, Form, Function, Topic};
use super::handle::Handle;
use super::parameter::Parameter;

/// Begins the declaration of a function `name(…)`.
pub fn function(topic: Topic, name: &'static str) -> Undescribed<()> {
    declaration(topic, Form::Function, name)
}

/// Begins the declaration of a method `object.name(…)` of objects of type `T`.
pub fn method_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed<T> {
    declaration(topic, Form::Method(T::receiver()), name)
}

/// Begins the declaration of a property `object.name` of objects of type `T`.
pub fn property_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed<T> {
    declaration(topic, Form::Property(T::receiver()), name)
}

/// Begins the declaration of `object["name"]` and `object.name` for every name, of objects of type `T`.
pub fn column_of<T: Handle>(topic: Topic, name: &'static str) -> Undescribed<T> {
    declaration(topic, Form::Column(T::receiver()), name)
}

fn declaration<T>(topic: Topic, form: Form, name: &'static str) -> Undescribed<T> {
    Undescribed { topic, form, name, receiver: PhantomData }
}

/// Declaration without summary; `T` is the type of the object of a method or property, `()` without one.
pub struct Undescribed<T> {
    topic: Topic,
    form: Form,
    name: &'static str,
    receiver: PhantomData<T>,
}

impl<T> Undescribed<T> {
    /// Adds the summary, one sentence.
    pub fn summary(self, summary: &'static str) -> Described<T> {
        let function = Function {
            name: self.name,
            form: self.form,
            topic: self.topic,
            summary,
            parameters: Vec::new(),
            returns: "",
            example: Cow::Borrowed(""),
            see_also: &[],
            body: Rc::new(|_| Ok(Dynamic::UNIT)),
        };
        Described { function, receiver: PhantomData }
    }
}

/// Declaration without example.
pub struct Described<T> {
    function: Function,
    receiver: PhantomData<T>,
}

impl<T> Described<T> {
    /// Adds the parameters; optional ones last.
    pub fn parameters(mut self, parameters: Vec<Parameter>) -> Self {
        self.function.parameters = parameters;
        self
    }

    /// Sets the keys of the last parameter, an options map.
    pub fn keys(mut self, keys: Vec<Parameter>) -> Self {
        let last = self.function.parameters.pop();
        self.function.parameters.extend(last.map(|last| last.keys(keys)));
        self
    }

    /// Adds the name of the type of the returned value, if it is no object of the language.
    pub fn returns(mut self, name: &'static str) -> Self {
        self.function.returns = name;
        self
    }

    /// Adds names of related functions.
    pub fn see_also(mut self, names: &'static [&'static str]) -> Self {
        self.function.see_also = names;
        self
    }

    /// Adds the example, a script that runs.
    pub fn example(mut self, script: impl Into<Cow<'static, str>>) -> Exemplified<T> {
        self.function.example = script.into();
        Exemplified { function: self.function, receiver: PhantomData }
    }
}

/// Declaration without body.
pub struct Exemplified<T> {
    function: Function,
    receiver: PhantomData<T>,
}

impl<T> Exemplified<T> {
    fn with<R: Returned>(self, closure: impl Fn(&Call) -> Result<R, Box<EvalAltResult>> + 'static) -> Function {
        let returns = if R::NAME.is_empty() { self.function.returns } else { R::NAME };
        Function { returns, body: Rc::new(move |call| closure(call).map(R::into_dynamic)), ..self.function }
    }
}

impl Exemplified<()> {
    /// Completes the declaration by the native implementation.
    pub fn body<R: Returned>(self, closure: impl Fn(&Call) -> Result<R, Box<EvalAltResult>> + 'static) -> Function {
        self.with(closure)
    }

    /// Completes the declaration by the native implementation, which receives the last parameter, an options map.
    pub fn body_with_options<R: Returned>(self, closure: impl Fn(&Call, Options) -> Result<R, Box<EvalAltResult>> + 'static) -> Function {
        self.with(move |call| closure(call, call.last_options()?))
    }
}

impl<T: Handle> Exemplified<T> {
    /// Completes the declaration by the native implementation, which receives the object of the method or property.
    pub fn body<R: Returned>(self, closure: impl Fn(&Call, T) -> Result<R, Box<EvalAltResult>> + 'static) -> Function {
        self.with(move |call| closure(call, call.receiver()))
    }

    /// Completes the declaration by the native implementation, which receives the object of the method and the last parameter, an options
    /// map.
    pub fn body_with_options<R: Returned>(
        self,
        closure: impl Fn(&Call, T, Options) -> Result<R, Box<EvalAltResult>> + 'static,
    ) -> Function {
        self.with(move |call| closure(call, call.receiver(), call.last_options()?))
    }
}

/// Value returned by a native implementation. Objects of the language name their type themselves; other types are named by the declaration.
pub trait Returned {
    /// Name of the type in the reference; empty if the declaration names it, or for no value.
    const NAME: &'static str;

    /// Returns the value as passed to the engine.
    fn into_dynamic(self) -> Dynamic;
}

impl<T: Handle> Returned for T {
    const NAME: &'static str = T::NAME;

    fn into_dynamic(self) -> Dynamic {
        Dynamic::from(self)
    }
}

impl Returned for Dynamic {
    const NAME: &'static str = "";

    fn into_dynamic(self) -> Dynamic {
        self
    }
}

impl Returned for () {
    const NAME: &'static str = "";

    fn into_dynamic(self) -> Dynamic {
        Dynamic::UNIT
    }
}

impl Returned for f64 {
    const NAME: &'static str = "number";

    fn into_dynamic(self) -> Dynamic {
        self.into()
    }
}

impl Returned for bool {
    const NAME: &'static str = "bool";

    fn into_dynamic(self) -> Dynamic {
        self.into()
    }
}

impl Returned for String {
    const NAME: &'static str = "String";

    fn into_dynamic(self) -> Dynamic {
        self.into()
    }
}

impl Returned for Array {
    const NAME: &'static str = "Array";

    fn into_dynamic(self) -> Dynamic {
        self.into()
    }
}

impl Returned for Map {
    const NAME: &'static str = "Map";

    fn into_dynamic(self) -> Dynamic {
        self.into()
    }
}
