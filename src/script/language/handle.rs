//! Objects of the language: what every type of objects must say of itself, and the table of all types.
//!
//! The language knows no type of the API. A type joins the table when the session is made; messages, completion and `print` ask the
//! table.

use std::any::TypeId;

use rhai::{Dynamic, Engine, FuncRegistration, ImmutableString};

/// The object a method belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Receiver {
    /// Name of its type.
    pub name: &'static str,
    /// The type behind it.
    pub id: TypeId,
}

/// An object of the language: a cheap handle that scripts pass around.
pub trait Handle: Clone + 'static {
    /// Name of its type in scripts.
    const NAME: &'static str;

    /// How a script gets one, for the message of a call that was given something else.
    const MAKER: &'static str = "give an object of that type";

    /// What `print` shows.
    fn describe(&self) -> String;

    /// The object as the receiver of methods.
    fn receiver() -> Receiver {
        Receiver { name: Self::NAME, id: TypeId::of::<Self>() }
    }

    /// What to write instead of a property of that name, which the type does not have.
    fn instead_of_property(_name: &str) -> Option<String> {
        None
    }

    /// What to write instead of an operator between an object of this type and something else.
    fn instead_of_operator() -> Option<&'static str> {
        None
    }
}

/// What the language knows of one type of objects.
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

    /// Their names.
    pub fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// Whether there is a type of that name.
    pub fn contains(&self, name: &str) -> bool {
        self.names.contains(&name)
    }

    /// Name of the type of an object; `None` for a value that is no object of the language.
    pub fn name_of(&self, value: &Dynamic) -> Option<&'static str> {
        self.rows.iter().find(|row| row.id == value.type_id()).map(|row| row.name)
    }

    /// What `print` shows of an object of the language.
    pub fn print(&self, value: &Dynamic) -> Option<String> {
        let row = self.rows.iter().find(|row| row.id == value.type_id())?;
        (row.print)(value)
    }

    /// How a script gets an object of a type.
    pub(crate) fn maker(&self, name: &str) -> &'static str {
        self.row(name).map_or("give an object of that type", |row| row.maker)
    }

    /// What to write instead of a property that a type does not have.
    pub(crate) fn instead_of_property(&self, type_name: &str, name: &str) -> Option<String> {
        (self.row(type_name)?.instead_of_property)(name)
    }

    /// What to write instead of an operator that a type does not have.
    pub(crate) fn instead_of_operator(&self, type_name: &str) -> Option<&'static str> {
        (self.row(type_name)?.instead_of_operator)()
    }
}
