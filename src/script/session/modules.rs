//! Imports: `import "lib/rings" as rings` loads `lib/rings.rhai` below the folder of the script that was started, and nothing else.
//!
//! A module is compiled and run once. Its text is added to the table of sources, and its context is kept, so that the solver can call
//! closures made inside the module.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use rhai::{Engine, EvalAltResult, GlobalRuntimeState, Module, ModuleResolver, Position, Scope, Shared};

use super::compile::constants;
use crate::machine::files;
use crate::script::language::causes;
use crate::script::language::failure::Failure;
use crate::script::language::host::Host;
use crate::script::language::lint::lint;
use crate::script::language::sandbox::reason;

/// Hidden function that a module calls at its end, to store its context in the host.
pub const KEEP_CONTEXT: &str = "module_context__";

/// Finds modules for the engine.
pub struct Modules {
    host: Rc<Host>,
    loaded: RefCell<HashMap<PathBuf, Shared<Module>>>,
    loading: RefCell<Vec<PathBuf>>,
}

impl Modules {
    /// A resolver for a host.
    pub fn new(host: Rc<Host>) -> Self {
        Modules { host, loaded: RefCell::default(), loading: RefCell::default() }
    }

    fn load(
        &self,
        engine: &Engine,
        global: &mut GlobalRuntimeState,
        scope: &mut Scope,
        path: &str,
        position: Position,
    ) -> Result<Shared<Module>, Box<EvalAltResult>> {
        let path = path.strip_suffix(".rhai").unwrap_or(path);
        let file = self.host.sandbox.module(path).map_err(|failure| failure.raise(position))?;
        if let Some(module) = self.loaded.borrow().get(&file) {
            return Ok(module.clone());
        }
        if self.loading.borrow().contains(&file) {
            let failure = Failure::script(format!("the module \"{path}\" imports itself, directly or through another")).code(causes::FILE);
            return Err(failure.hint("move what both need into a third module").raise(position));
        }
        let text = files::read_text(&file).map_err(|error| {
            Failure::script(format!("the module \"{path}\" cannot be read"))
                .code(causes::FILE)
                .cause(reason(&error))
                .hint("check the file")
                .raise(position)
        })?;
        let source = format!("{path}.rhai");
        self.host.sources.insert(&source, &text);
        let inside = |error: Box<EvalAltResult>| Box::new(EvalAltResult::ErrorInModule(path.to_string(), error, position));
        let mut tree = engine.compile_with_scope(&constants(), &text).map_err(|error| inside(error.into()))?;
        tree.set_source(&source);
        lint(&self.host, engine, &source);
        let closures = tree.iter_functions().map(|function| function.name.to_string()).filter(|name| name.starts_with("anon$")).collect();
        let last = engine.compile(format!("{KEEP_CONTEXT}();")).map_err(|error| inside(error.into()))?;
        let tree = tree.merge(&last);
        self.loading.borrow_mut().push(file.clone());
        self.host.begin_module(closures);
        let module = Module::eval_ast_as_new_raw(engine, scope, global, &tree);
        self.host.end_module();
        self.loading.borrow_mut().pop();
        let module: Shared<Module> = module.map_err(inside)?.into();
        self.host.note_module(&module, path);
        self.loaded.borrow_mut().insert(file, module.clone());
        Ok(module)
    }
}

impl ModuleResolver for Modules {
    fn resolve(&self, engine: &Engine, _: Option<&str>, path: &str, position: Position) -> Result<Shared<Module>, Box<EvalAltResult>> {
        self.load(engine, &mut engine.new_global_runtime_state(), &mut constants(), path, position)
    }

    fn resolve_raw(
        &self,
        engine: &Engine,
        global: &mut GlobalRuntimeState,
        _: &mut Scope,
        path: &str,
        position: Position,
    ) -> Result<Shared<Module>, Box<EvalAltResult>> {
        self.load(engine, global, &mut constants(), path, position)
    }
}
