//! Objects of the language: the description that every type of objects provides, and the table of all types.
//!
//! The language is independent of the types of the API. A type is added to the table when the session is made; messages, completion and
//! `print` use the table.

use std::any::TypeId;

use rhai::{Dynamic, Engine, FuncRegistration, ImmutableString};

/// Type of the object of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Receiver {
    /// Name of the type.
    pub name: &'static str,
    /// Rust type.
    pub id: TypeId,
}

/// An object of the language: a cheap handle that scripts pass around.
pub trait Handle: Clone + 'static {
    /// Name of the type in scripts.
    const NAME: &'static str;

    /// Hint how a script makes an object of this type, for the message of a call with another value.
    const MAKER: &'static str = "give an object of that type";

    /// Returns the text that `print` shows.
    fn describe(&self) -> String;

    /// The object as the receiver of methods.
    fn receiver() -> Receiver {
        Receiver { name: Self::NAME, id: TypeId::of::<Self>() }
    }

    /// Returns a hint for a property `_name` that the type does not have.
    fn instead_of_property(_name: &str) -> Option<String> {
        None
    }

    /// Returns a hint for an operator between an object of this type and another value.
    fn instead_of_operator() -> Option<&'static str> {
        None
    }
}

/// Description of a type of objects.
struct TypeRow {
    name: &'static str,
    id: TypeId,
    maker: &'static str,
    print: fn(&Dynamic) -> Option<String>,
    instead_of_property: fn(&str) -> Option<String>,
    instead_of_operator: fn() -> Option<&'static str>,
}

/// All types of objects.
#[derive(Default)]
pub struct Types {
    names: Vec<&'static str>,
    rows: Vec<TypeRow>,
}

impl Types {
    /// Adds a type of objects with its printed form.
    pub fn add<T: Handle>(&mut self, engine: &mut Engine) {
        engine.register_type_with_name::<T>(T::NAME);
        for name in ["to_string", "to_debug"] {
            FuncRegistration::new(name)
                .in_global_namespace()
                .with_params_info([format!("object: {}", T::NAME), "String".into()])
                .with_comments(["/// What `print` shows."])
                .register_into_engine(engine, |object: &mut T| ImmutableString::from(object.describe()));
        }
        self.names.push(T::NAME);
        self.rows.push(TypeRow {
            name: T::NAME,
            id: TypeId::of::<T>(),
            maker: T::MAKER,
            print: |value| value.clone().try_cast::<T>().map(|object| object.describe()),
            instead_of_property: T::instead_of_property,
            instead_of_operator: T::instead_of_operator,
        });
    }

    fn row(&self, name: &str) -> Option<&TypeRow> {
        self.rows.iter().find(|row| row.name == name)
    }

    /// Names of all types.
    pub fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// True if a type of that name exists.
    pub fn contains(&self, name: &str) -> bool {
        self.names.contains(&name)
    }

    /// Name of the type of an object; `None` for a value that is no object of the language.
    pub fn name_of(&self, value: &Dynamic) -> Option<&'static str> {
        self.rows.iter().find(|row| row.id == value.type_id()).map(|row| row.name)
    }

    /// Returns the text that `print` shows of an object of the language; `None` for other values.
    pub fn print(&self, value: &Dynamic) -> Option<String> {
        let row = self.rows.iter().find(|row| row.id == value.type_id())?;
        (row.print)(value)
    }

    /// Returns a hint how a script makes an object of a type.
    pub(crate) fn maker(&self, name: &str) -> &'static str {
        self.row(name).map_or("give an object of that type", |row| row.maker)
    }

    /// Returns a hint for a property that a type does not have.
    pub(crate) fn instead_of_property(&self, type_name: &str, name: &str) -> Option<String> {
        (self.row(type_name)?.instead_of_property)(name)
    }

    /// Returns a hint for an operator that a type does not have.
    pub(crate) fn instead_of_operator(&self, type_name: &str) -> Option<&'static str> {
        (self.row(type_name)?.instead_of_operator)()
    }
}
