//! Functions of the language with their description, and calls of them.
//!
//! Every function is a [`Function`]: name, topic, summary, parameters with dimension, range and default, an example, and its body; it is
//! declared by a chain (`declaration.rs`). The description determines its registration (`registry.rs`), the checks of its arguments
//! (`arguments.rs`), the names that errors suggest, and the reference.

use std::borrow::Cow;
use std::rc::Rc;

use rhai::{Dynamic, Engine, EvalAltResult, NativeCallContext, Position};

use super::failure::Failure;
use super::handle::{Handle, Receiver};
use super::host::Host;
use super::parameter::{Kind, Parameter};
use super::scan::{self, Target};
use super::sources::{SourceSpan, offset};

/// Topic of a function, a heading of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// Generators, readers and transforms of meshes.
    Meshes,
    /// Material laws.
    Materials,
    /// Bodies, supports, loads, contact pairs.
    Model,
    /// Histories that loads follow.
    TimeFunctions,
    /// Contact methods.
    Contact,
    /// Integrators, steps, states.
    Simulation,
    /// Columns, fields, pictures.
    Results,
    /// Expectations.
    Checks,
    /// Many runs, searches, comparisons of curves.
    Studies,
    /// Values from the command line.
    Parameters,
    /// Numbers and text.
    Numbers,
    /// Arrays of numbers.
    Arrays,
}

/// Form of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `f(…)`.
    Function,
    /// `object.f(…)`.
    Method(Receiver),
    /// `object.f`.
    Property(Receiver),
    /// `object["name"]` and `object.name` for every name.
    Column(Receiver),
}

impl Form {
    /// Type of the object of a method or property.
    pub fn receiver(self) -> Option<Receiver> {
        match self {
            Form::Function => None,
            Form::Method(receiver) | Form::Property(receiver) | Form::Column(receiver) => Some(receiver),
        }
    }
}

/// Native implementation of a function.
pub type Body = Rc<dyn Fn(&Call) -> Result<Dynamic, Box<EvalAltResult>>>;

/// A function of the language.
#[derive(Clone)]
pub struct Function {
    /// Name.
    pub name: &'static str,
    /// Form of a call.
    pub form: Form,
    /// Topic in the reference.
    pub topic: Topic,
    /// Summary, one sentence.
    pub summary: &'static str,
    /// Parameters without the object of a method; optional ones last.
    pub parameters: Vec<Parameter>,
    /// Name of the type of the returned value; empty for none.
    pub returns: &'static str,
    /// Script with an example, which runs.
    pub example: Cow<'static, str>,
    /// Names of related functions.
    pub see_also: &'static [&'static str],
    /// Native implementation.
    pub body: Body,
}

impl Function {
    /// True if the function reads a value of an object: a property or a column.
    pub fn reads(&self) -> bool {
        matches!(self.form, Form::Property(_) | Form::Column(_))
    }

    /// Returns the signature, such as `model.fix(boundary, components)`.
    pub fn signature(&self) -> String {
        let object = self.form.receiver().map(|receiver| receiver.name.to_lowercase());
        let names: Vec<String> = self
            .parameters
            .iter()
            .map(|parameter| match &parameter.kind {
                Kind::Options(keys) | Kind::OpenOptions(keys) => {
                    let others = matches!(parameter.kind, Kind::OpenOptions(_)).then(|| "…".to_string());
                    let keys = keys.iter().map(|key| if key.is_optional() { format!("{}?", key.name) } else { key.name.to_string() });
                    let keys: Vec<String> = keys.chain(others).collect();
                    format!("#{{ {} }}", keys.join(", "))
                }
                _ if parameter.is_optional() => format!("{}?", parameter.name),
                _ => parameter.name.to_string(),
            })
            .collect();
        let names = names.join(", ");
        match (self.form, object) {
            (Form::Property(_), Some(object)) => format!("{object}.{}", self.name),
            (Form::Column(_), Some(object)) => format!("{object}.{names}"),
            (_, Some(object)) => format!("{object}.{}({names})", self.name),
            (_, None) => format!("{}({names})", self.name),
        }
    }

    /// Returns the name in messages: `` `f` `` or `` `model.f` ``.
    pub fn title(&self) -> String {
        format!("`{}`", self.name)
    }
}

/// A call of a script function.
pub struct Call<'a> {
    /// The engine's context of the call.
    pub context: &'a NativeCallContext<'a>,
    /// The called function.
    pub function: &'a Function,
    /// Data and services of the session.
    pub host: &'a Rc<Host>,
    /// Values of the engine, the object of a method first.
    pub(super) values: Vec<Dynamic>,
}

impl<'a> Call<'a> {
    /// Returns a call with its values, the object of a method first.
    pub fn new(context: &'a NativeCallContext<'a>, function: &'a Function, values: Vec<Dynamic>, host: &'a Rc<Host>) -> Self {
        Call { context, function, host, values }
    }

    /// The object of a method.
    pub fn receiver<T: Handle>(&self) -> T {
        self.values[0].clone().cast::<T>()
    }

    /// Engine that executes the call.
    pub fn engine(&self) -> &Engine {
        self.context.engine()
    }

    /// A failure of this call.
    pub fn fail(&self, title: impl Into<String>) -> Failure {
        Failure::script(title).in_method(self.function.form.receiver().is_some())
    }

    /// A failure of this call with a stable code of [`causes`](super::causes).
    pub fn refuse(&self, code: &'static str, title: impl Into<String>) -> Failure {
        self.fail(title).code(code)
    }

    /// Position of the call in the source.
    pub fn position(&self) -> Position {
        self.context.call_position()
    }

    /// Name of the source that contains the call.
    pub fn source(&self) -> String {
        self.context.call_source().unwrap_or_default().to_string()
    }

    /// True if the value of the call, which is at a dot or bracket in `text`, is indexed immediately.
    pub fn is_indexed(&self, text: &str) -> bool {
        offset(text, self.position()).is_some_and(|start| scan::is_indexed(&scan::lexemes(self.engine(), text), start))
    }

    /// Returns the place of the call, or of a part of the call.
    pub fn place(&self, target: &Target) -> Option<SourceSpan> {
        self.host.place(self.engine(), &self.source(), self.position(), target, self.function.form.receiver().is_some())
    }
}
