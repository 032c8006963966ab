//! How a script function describes itself, and how descriptions become functions of the engine.
//!
//! Every function is one [`Function`]: name, topic, summary, parameters with dimension, range and default, an example, and its body. A
//! field cannot be left out, so a function without documentation does not compile. The same description registers the function (with
//! every number of arguments that its optional parameters allow), checks its arguments, suggests names in errors and feeds the reference.

use std::any::TypeId;
use std::borrow::Cow;
use std::rc::Rc;

use rhai::{Dynamic, Engine, EvalAltResult, FuncRegistration, ImmutableString, Module, NativeCallContext, RhaiFunc};

use super::arguments::Call;
use super::failure::Failure;
use super::host::Host;
use crate::math::catalogue::Interval;

/// Heading of the reference under which a function stands.
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
    /// Values from the command line.
    Parameters,
    /// Numbers and text.
    Numbers,
}

/// What a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number, whole or not.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Flag,
    /// A string.
    Text,
    /// One of some strings.
    Choice(&'static [&'static str]),
    /// An array of as many numbers as the space has dimensions.
    Vector,
    /// An array of whole numbers.
    Counts,
    /// An array.
    Array,
    /// A number, a time function or a closure of time.
    Amplitude,
    /// A closure with the given parameters.
    Closure(&'static str),
    /// An object of the named type.
    Handle(&'static str),
    /// An object map with these keys.
    Options(Vec<Parameter>),
    /// One of several kinds, in words with their articles.
    Either(&'static str),
    /// Anything.
    Any,
}

impl Kind {
    /// With its article, as messages name it.
    pub fn phrase(&self) -> String {
        match self {
            Kind::Number => "a number".into(),
            Kind::Integer => "a whole number".into(),
            Kind::Flag => "`true` or `false`".into(),
            Kind::Text => "a string".into(),
            Kind::Choice(words) => {
                let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                super::failure::joined(&quoted, "or")
            }
            Kind::Vector => "an array of numbers, such as `[1.0, 0.0]`".into(),
            Kind::Counts => "an array of whole numbers, such as `[10, 40]`".into(),
            Kind::Array => "an array".into(),
            Kind::Amplitude => "a number, a time function such as `hat(0.0, 1.0, 5.0)`, or a closure `|t| …`".into(),
            Kind::Closure(parameters) => format!("a closure `{parameters} …`"),
            Kind::Handle(name) => with_article(name),
            Kind::Options(_) => "an object map `#{ … }`".into(),
            Kind::Either(words) => (*words).into(),
            Kind::Any => "a value".into(),
        }
    }

    /// One word, as signatures name it.
    pub fn word(&self) -> &'static str {
        match self {
            Kind::Number => "number",
            Kind::Integer => "int",
            Kind::Flag => "bool",
            Kind::Text | Kind::Choice(_) => "String",
            Kind::Vector | Kind::Counts | Kind::Array => "Array",
            Kind::Amplitude => "Amplitude",
            Kind::Closure(_) => "Fn",
            Kind::Handle(name) => name,
            Kind::Options(_) => "Map",
            Kind::Either(_) | Kind::Any => "any",
        }
    }
}

/// `a Mesh`, `an Integrator`.
pub fn with_article(name: &str) -> String {
    let vowel = name.chars().next().is_some_and(|first| "AEIOUaeiou".contains(first));
    format!("{} {name}", if vowel { "an" } else { "a" })
}

/// What holds when a parameter is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// It must not be left out.
    Refused,
    /// What is done instead, in words.
    Means(&'static str),
    /// This number.
    Number(f64),
    /// This whole number.
    Integer(i64),
    /// This truth value.
    Flag(bool),
    /// This string.
    Text(&'static str),
}

impl std::fmt::Display for Absent {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Absent::Refused => write!(out, "required"),
            Absent::Means(words) => write!(out, "{words}"),
            Absent::Number(value) => write!(out, "{}", number_text(*value)),
            Absent::Integer(value) => write!(out, "{value}"),
            Absent::Flag(value) => write!(out, "{value}"),
            Absent::Text(value) => write!(out, "\"{value}\""),
        }
    }
}

/// A parameter of a function or a key of an options map.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// What it takes.
    pub kind: Kind,
    /// Physical dimension, `1` for a pure number, `any` where it depends on the use, empty for what is no number.
    pub dimension: &'static str,
    /// Admissible values of a number.
    pub range: Interval,
    /// What holds when it is left out.
    pub absent: Absent,
    /// One sentence: what it is.
    pub summary: &'static str,
}

impl Parameter {
    /// A required parameter.
    pub fn new(name: &'static str, kind: Kind, summary: &'static str) -> Self {
        Parameter { name, kind, dimension: "", range: Interval::Finite, absent: Absent::Refused, summary }
    }

    /// A required number with its dimension and range.
    pub fn number(name: &'static str, dimension: &'static str, range: Interval, summary: &'static str) -> Self {
        Parameter { dimension, range, ..Parameter::new(name, Kind::Number, summary) }
    }

    /// The same, which may be left out.
    pub fn or(self, absent: Absent) -> Self {
        Parameter { absent, ..self }
    }

    /// The same with a dimension.
    pub fn of(self, dimension: &'static str) -> Self {
        Parameter { dimension, ..self }
    }

    /// The same with a range.
    pub fn within(self, range: Interval) -> Self {
        Parameter { range, ..self }
    }

    /// Whether it may be left out.
    pub fn is_optional(&self) -> bool {
        self.absent != Absent::Refused
    }

    /// What must be given, such as `a number greater than 0 [length]`.
    pub fn requirement(&self) -> String {
        let mut text = self.kind.phrase();
        if matches!(self.kind, Kind::Number | Kind::Integer) && self.range != Interval::Finite {
            text = format!("{text} {}", self.range);
        }
        if !matches!(self.dimension, "" | "1" | "any") {
            text = format!("{text} [{}]", self.dimension);
        }
        text
    }
}

/// The object a method belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Receiver {
    /// Name of its type.
    pub name: &'static str,
    id: TypeId,
}

/// How a function is called.
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
    /// The object's type, if it has one.
    pub fn receiver(self) -> Option<Receiver> {
        match self {
            Form::Function => None,
            Form::Method(receiver) | Form::Property(receiver) | Form::Column(receiver) => Some(receiver),
        }
    }
}

/// What a function computes.
pub type Body = Rc<dyn Fn(&Call) -> Result<Dynamic, Box<EvalAltResult>>>;

/// A body from a closure.
pub fn body(closure: impl Fn(&Call) -> Result<Dynamic, Box<EvalAltResult>> + 'static) -> Body {
    Rc::new(closure)
}

/// A function of the language.
#[derive(Clone)]
pub struct Function {
    /// Name.
    pub name: &'static str,
    /// How it is called.
    pub form: Form,
    /// Where it stands in the reference.
    pub topic: Topic,
    /// One sentence: what it is or does.
    pub summary: &'static str,
    /// Parameters, the object of a method not among them; optional ones last.
    pub parameters: Vec<Parameter>,
    /// Name of the type of its value; empty for none.
    pub returns: &'static str,
    /// A script that uses it and runs.
    pub example: Cow<'static, str>,
    /// Names of related functions.
    pub see_also: &'static [&'static str],
    /// What it computes.
    pub body: Body,
}

impl Function {
    /// As it is written, such as `model.fix(boundary, components)`.
    pub fn signature(&self) -> String {
        let object = self.form.receiver().map(|receiver| receiver.name.to_lowercase());
        let names: Vec<String> = self
            .parameters
            .iter()
            .map(|parameter| match &parameter.kind {
                Kind::Options(keys) => {
                    let keys: Vec<String> =
                        keys.iter().map(|key| if key.is_optional() { format!("{}?", key.name) } else { key.name.to_string() }).collect();
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

    /// How messages name it: `` `f` `` or `` `model.f` ``.
    pub fn title(&self) -> String {
        format!("`{}`", self.name)
    }
}

/// An object of the language: a cheap handle that scripts pass around.
pub trait Handle: Clone + 'static {
    /// Name of its type in scripts.
    const NAME: &'static str;

    /// What `print` shows.
    fn describe(&self) -> String;

    /// The object as the receiver of methods.
    fn receiver() -> Receiver {
        Receiver { name: Self::NAME, id: TypeId::of::<Self>() }
    }
}

/// All functions of the language.
#[derive(Default)]
pub struct Registry {
    functions: Vec<Rc<Function>>,
    types: Vec<&'static str>,
    printers: Vec<(TypeId, Printer)>,
}

/// Prints a value of one type.
type Printer = fn(&Dynamic) -> Option<String>;

impl Registry {
    /// The functions in the order of their registration.
    pub fn functions(&self) -> &[Rc<Function>] {
        &self.functions
    }

    /// Functions, methods and properties of that name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Rc<Function>> + 'a {
        self.functions.iter().filter(move |function| function.name == name)
    }

    /// Methods and properties of a type.
    pub fn members<'a>(&'a self, type_name: &'a str) -> impl Iterator<Item = &'a Rc<Function>> + 'a {
        self.functions.iter().filter(move |function| function.form.receiver().is_some_and(|receiver| receiver.name == type_name))
    }

    /// Names of the types of objects.
    pub fn types(&self) -> &[&'static str] {
        &self.types
    }

    /// What `print` shows of an object of the language.
    pub fn print(&self, value: &Dynamic) -> Option<String> {
        let (_, printer) = self.printers.iter().find(|(id, _)| *id == value.type_id())?;
        printer(value)
    }

    /// Whether the language has objects of that type.
    pub fn has_type(&self, name: &str) -> bool {
        self.types.contains(&name)
    }

    /// Adds a type of objects with its printed form.
    pub fn add_type<T: Handle>(&mut self, engine: &mut Engine) {
        engine.register_type_with_name::<T>(T::NAME);
        for name in ["to_string", "to_debug"] {
            FuncRegistration::new(name)
                .in_global_namespace()
                .with_params_info([format!("object: {}", T::NAME), "String".into()])
                .with_comments(["/// What `print` shows."])
                .register_into_engine(engine, |object: &mut T| ImmutableString::from(object.describe()));
        }
        self.types.push(T::NAME);
        self.printers.push((TypeId::of::<T>(), |value| value.clone().try_cast::<T>().map(|object| object.describe())));
    }

    /// Adds functions to a module and to the reference.
    pub fn add(&mut self, module: &mut Module, host: &Rc<Host>, functions: Vec<Function>) {
        for function in functions {
            let function = Rc::new(function);
            register(module, host, &function);
            self.functions.push(function);
        }
    }
}

fn register(module: &mut Module, host: &Rc<Host>, function: &Rc<Function>) {
    let least = function.parameters.iter().take_while(|parameter| !parameter.is_optional()).count();
    debug_assert!(function.parameters[least..].iter().all(Parameter::is_optional), "optional parameters of {} come last", function.name);
    for count in least..=function.parameters.len() {
        let registration = match function.form {
            Form::Property(_) => FuncRegistration::new_getter(function.name),
            Form::Column(_) => FuncRegistration::new_index_getter(),
            Form::Function | Form::Method(_) => FuncRegistration::new(function.name).in_global_namespace(),
        };
        let receiver = function.form.receiver();
        let types: Vec<TypeId> = receiver
            .map(|receiver| receiver.id)
            .into_iter()
            .chain(function.parameters[..count].iter().map(|_| match function.form {
                Form::Column(_) => TypeId::of::<ImmutableString>(),
                _ => TypeId::of::<Dynamic>(),
            }))
            .collect();
        let information = receiver
            .map(|receiver| format!("{}: {}", receiver.name.to_lowercase(), receiver.name))
            .into_iter()
            .chain(function.parameters[..count].iter().map(|parameter| format!("{}: {}", parameter.name, parameter.kind.word())))
            .chain([if function.returns.is_empty() { "()".to_string() } else { function.returns.to_string() }]);
        let (host, function) = (host.clone(), function.clone());
        let comment = format!("/// {}\n///\n/// ```\n/// {}\n/// ```", function.summary, function.example.replace('\n', "\n/// "));
        registration.with_params_info(information).with_comments([comment]).set_into_module_raw(
            module,
            types,
            RhaiFunc::Pure {
                func: Rc::new(move |context: Option<NativeCallContext>, values: &mut [&mut Dynamic]| {
                    let context = context.ok_or_else(|| Failure::script("the function was called without a context"))?;
                    let values: Vec<Dynamic> = values.iter_mut().map(|value| value.flatten_clone()).collect();
                    let call = Call::new(&context, &function, values, &host);
                    call.check()?;
                    (function.body)(&call)
                }),
                has_context: true,
                is_pure: true,
                is_volatile: true,
            },
        );
    }
}

/// Shortest text that reads back as the same number, with a decimal point or exponent only where needed.
pub fn number_text(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e16).contains(&size) || !value.is_finite() { format!("{value}") } else { format!("{value:e}") }
}
