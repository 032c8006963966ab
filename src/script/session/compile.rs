//! Compilation of texts for the engine, and their initial scope.

use rhai::{AST, Engine, EvalAltResult, Scope};

/// Returns a scope with the constants of the language.
pub fn constants() -> Scope<'static> {
    let mut scope = Scope::new();
    scope.push_constant("PI", std::f64::consts::PI);
    scope
}

/// Compiles a text; the result has the name of its source.
///
/// # Errors
/// A text that does not parse.
pub fn compile(engine: &Engine, scope: &Scope, name: &str, text: &str) -> Result<AST, Box<EvalAltResult>> {
    let mut tree = engine.compile_with_scope(scope, text)?;
    tree.set_source(name);
    Ok(tree)
}
