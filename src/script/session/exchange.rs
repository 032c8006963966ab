//! Values of [`Calls`] as data for a program in another language: meshes, states, files as bytes, variables of a text.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;
use std::sync::Arc;

use rhai::{Dynamic, Map, Scope};

use super::calls::Calls;
use super::compile::{compile, constants};
use crate::mesh::Mesh;
use crate::output::checkpoint::{Checkpoint, CheckpointError, SavedSimulation};
use crate::output::{History, RowStore, decoded, encoded};
use crate::script::api::files::writing::RequestedFile;
use crate::script::api::meshes::handle::MeshHandle;
use crate::script::api::remedies::ScriptWords;
use crate::script::api::simulations::states::StateHandle;
use crate::script::language::diagnostics::{Diagnostic, defect};
use crate::script::language::explain::explain;
use crate::script::language::failure::Class;

impl Calls {
    /// The mesh behind an object of the type `Mesh`.
    pub fn mesh(&self, value: &Dynamic) -> Option<Arc<Mesh>> {
        value.clone().try_cast::<MeshHandle>().map(|handle| handle.mesh())
    }

    /// An object of the type `Mesh`.
    ///
    /// # Errors
    /// The first defect of the mesh.
    pub fn mesh_object(&self, mesh: Mesh) -> Result<Dynamic, Box<Diagnostic>> {
        match mesh.check() {
            Ok(()) => Ok(Dynamic::from(MeshHandle::new(mesh))),
            Err(error) => {
                let refused = Diagnostic::error(Class::Script, error.to_string()).code(error.code());
                Err(Box::new(refused.hint(error.remedy())))
            }
        }
    }

    /// A state as a checkpoint, and the rows of its history; `None` for other values.
    pub fn state_bytes(&self, value: &Dynamic) -> Option<(Vec<u8>, Vec<u8>)> {
        let StateHandle { state, history, name, .. } = value.clone().try_cast::<StateHandle>()?;
        let rows = history.rows(0, history.len());
        let saved = SavedSimulation { name, reached: (state.row.step, state.row.time), state: Some(state), ..Default::default() };
        let checkpoint = Checkpoint { simulations: vec![saved], ..Default::default() };
        Some((checkpoint.to_bytes(), encoded(&rows)))
    }

    /// A state from the bytes of [`Self::state_bytes`]. Simulations of an equal model can restore it.
    ///
    /// # Errors
    /// Bytes of another version of the program, or of something else.
    pub fn state_object(&self, checkpoint: &[u8], rows: &[u8]) -> Result<Dynamic, Box<Diagnostic>> {
        let refused = |cause: String, code| {
            let error = Diagnostic::error(Class::Script, "the state cannot be read").code(code).cause(cause);
            Box::new(error.hint("pickle states only between processes with the same version of Conserva; compute it anew"))
        };
        let saved = Checkpoint::from_bytes(checkpoint).map_err(|error| refused(error.to_string(), error.code()))?.simulations.pop();
        let rows = decoded(rows);
        let (Some(SavedSimulation { name, state: Some(state), .. }), Some(rows)) = (saved, rows) else {
            return Err(refused("the bytes hold no state".into(), CheckpointError::Foreign.code()));
        };
        let history = History::new(Rc::<RowStore>::default(), rows);
        Ok(Dynamic::from(StateHandle { state, history, name, simulation: None }))
    }

    /// Calls a function that writes a file and returns its bytes instead of writing it; `None` if the function wrote no file.
    ///
    /// # Errors
    /// The message with which a script would end.
    pub fn file(&self, function: usize, values: Vec<Dynamic>) -> Result<Option<Vec<u8>>, Box<Diagnostic>> {
        let wanted: Rc<RequestedFile> = self.session.borrow().host.slots.get();
        wanted.ask();
        let outcome = self.call(function, values);
        let bytes = wanted.take();
        outcome.map(|_| bytes)
    }

    /// Runs a text with variables; returns a map of its variables, and the value of its last expression under an empty name.
    ///
    /// # Errors
    /// The message with which a script would end.
    pub fn text(&self, text: &str, variables: Vec<(String, Dynamic)>) -> Result<Map, Box<Diagnostic>> {
        match catch_unwind(AssertUnwindSafe(|| self.text_unguarded(text, variables))) {
            Ok(outcome) => outcome,
            Err(panic) => Err(defect(&*panic)),
        }
    }

    fn text_unguarded(&self, text: &str, variables: Vec<(String, Dynamic)>) -> Result<Map, Box<Diagnostic>> {
        let (engine, host) = {
            let session = self.session.borrow();
            (session.engine.clone(), session.host.clone())
        };
        let engine = engine.borrow();
        // Closures of earlier texts keep their source names.
        let (source, mut scope): (_, Scope) = (format!("cell {}", host.sources.all().len()), constants());
        let constant = scope.len();
        for (name, value) in variables {
            scope.push_dynamic(name, value);
        }
        host.sources.insert(&source, text);
        let tree = compile(&engine, &scope, &source, text);
        let value = tree.and_then(|tree| engine.eval_ast_with_scope::<Dynamic>(&mut scope, &tree));
        let value = value.map_err(|error| Box::new(explain(&host, &engine, &error, &source)))?;
        let variables = scope.iter().skip(constant).map(|(name, _, value)| (name.into(), value.flatten_clone()));
        Ok(variables.chain([("".into(), value.flatten())]).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::mesh::rectangle;
    use crate::script::language::observer::Silent;
    use crate::script::language::settings::Settings;

    fn calls() -> Calls {
        Calls::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap()
    }

    const FLIGHT: &str = r#"
        let flight = model("flight");
        let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });
        let plate = flight.add_body("plate", rectangle(#{ size: [2.0, 1.0], cells: [columns, 2] }), rubber);
        flight.initial_velocity(plate, #{ angular: 2.0 });
        let sim = simulate(flight, #{ integrator: energy_momentum(), dt: 0.01 });
        "#;

    #[test]
    fn a_state_goes_on_in_another_session_to_the_same_bytes() {
        let columns = |count: i64| vec![("columns".to_string(), Dynamic::from(count))];
        let first = calls();
        let made =
            first.text(&format!("{FLIGHT} sim.step(3); let state = sim.save(); sim.step(2); sim.energy.strain"), columns(4)).unwrap();
        let (state, rows) = first.state_bytes(&made["state"]).unwrap();
        let second = calls();
        let given = |count| [columns(count), vec![("state".to_string(), second.state_object(&state, &rows).unwrap())]].concat();
        let text =
            format!("{FLIGHT} sim.restore(state); sim.step(2); if sim.history.time.len() != 6 {{ throw \"rows\" }} sim.energy.strain");
        let again = second.text(&text, given(4)).unwrap();
        assert!(made[""].as_float().unwrap() > 0.0);
        assert_eq!(made[""].as_float(), again[""].as_float());
        assert!(second.text(&text, given(5)).unwrap_err().title.contains("does not fit"));
    }

    #[test]
    fn bytes_that_are_no_state_are_refused() {
        assert!(calls().state_object(b"nothing", b"").unwrap_err().code.starts_with("C09"));
    }

    #[test]
    fn the_file_of_a_call_is_returned_without_a_folder() {
        let calls = calls();
        let made = calls.text(&format!("{FLIGHT} sim.step(3);"), vec![("columns".to_string(), Dynamic::from(4_i64))]).unwrap();
        let picture = calls.functions().iter().position(|function| function.signature().starts_with("simulation.picture")).unwrap();
        let bytes = calls.file(picture, vec![made["sim"].clone(), "a.svg".into()]).unwrap().unwrap();
        assert!(bytes.starts_with(b"<svg"));
    }

    #[test]
    fn a_mesh_with_a_defect_is_refused() {
        let mut mesh = rectangle([1.0, 1.0], [1, 1], [0.0, 0.0]).unwrap();
        assert!(calls().mesh_object(mesh.clone()).is_ok());
        mesh.blocks[0].connectivity.reverse();
        assert!(!calls().mesh_object(mesh).unwrap_err().hints.is_empty());
    }
}
