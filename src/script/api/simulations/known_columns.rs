//! Cache of the columns of a history read last, and access to single cells, so that loops over cells are linear in the number of cells.
//!
//! The engine copies an array and measures its size at each use. Therefore a column that a script indexes immediately,
//! `sim.history.total[k]`, is an object with an indexer in place of an array.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use rhai::{Dynamic, Engine, EvalAltResult, Position};

use crate::script::language::function::Call;

/// Number of cached columns.
const KEPT: usize = 4;

/// Columns of a history that the script has read last.
#[derive(Default)]
pub struct KnownColumns(Vec<(String, Rc<Vec<f64>>)>);

impl KnownColumns {
    /// Returns a column of a history with `count` rows; `further` reads the rows from an index on, `None` for an unknown column.
    pub fn read(&mut self, name: &str, count: usize, further: impl FnOnce(usize) -> Option<Vec<f64>>) -> Option<Rc<Vec<f64>>> {
        let place = self.0.iter().position(|(column, _)| column == name);
        let (column, mut values) = match place {
            Some(place) => self.0.remove(place),
            None => (name.to_string(), Rc::default()),
        };
        if values.len() < count || place.is_none() {
            let further = further(values.len())?;
            Rc::make_mut(&mut values).extend(further);
        }
        if self.0.len() >= KEPT {
            self.0.remove(0);
        }
        self.0.push((column, values.clone()));
        Some(values)
    }

    /// Clears the cache, because the history is replaced.
    pub fn forget(&mut self) {
        self.0.clear();
    }
}

/// A column of which a script reads single cells.
#[derive(Clone)]
pub struct ColumnCells {
    values: Rc<Vec<f64>>,
    is_count: bool,
}

impl ColumnCells {
    /// Cells of a column.
    pub fn new(values: Rc<Vec<f64>>, is_count: bool) -> Self {
        ColumnCells { values, is_count }
    }

    fn cell(&self, index: i64) -> Result<Dynamic, Box<EvalAltResult>> {
        let length = self.values.len();
        let place = if index < 0 { length.checked_sub(index.unsigned_abs() as usize) } else { Some(index as usize) };
        let value = place.and_then(|place| self.values.get(place).copied());
        let value = value.ok_or_else(|| EvalAltResult::ErrorArrayBounds(length, index, Position::NONE))?;
        // Counts are whole numbers, so that they index arrays and print as such.
        Ok(if self.is_count { (value as i64).into() } else { value.into() })
    }
}

/// Start of the indexers of columns in a definition file, which describes arrays without indexers.
pub const CELL_INDEXER: &str = "fn index$get$(_: array";

/// Registers the indexers of columns.
pub fn register_column_cells(engine: &mut Engine) {
    engine.register_type_with_name::<ColumnCells>("Array");
    engine.register_indexer_get(|column: &mut ColumnCells, index: i64| column.cell(index));
    engine.register_indexer_get(|_: &mut ColumnCells, index: Dynamic| -> Result<Dynamic, Box<EvalAltResult>> {
        Err(EvalAltResult::ErrorMismatchDataType("i64".into(), index.type_name().into(), Position::NONE).into())
    });
}

/// Text of a script in which a call was inspected, and true if the call's value is indexed immediately.
struct Found {
    text: Arc<str>,
    is_indexed: bool,
}

/// Calls whose value is a column, by source and position.
#[derive(Default)]
pub struct CellPlaces(RefCell<HashMap<(String, Position), Found>>);

impl CellPlaces {
    /// True if the script indexes the value of this property access immediately.
    pub fn has(call: &Call) -> bool {
        let (host, key) = (call.host, (call.source(), call.position()));
        let name = if key.0.is_empty() { host.main.borrow().clone() } else { key.0.clone() };
        let (Some(text), places) = (host.sources.text(&name), host.slots.get::<CellPlaces>()) else { return false };
        if let Some(found) = places.0.borrow().get(&key)
            && Arc::ptr_eq(&found.text, &text)
        {
            return found.is_indexed;
        }
        let is_indexed = call.is_indexed(&text);
        places.0.borrow_mut().insert(key, Found { text, is_indexed });
        is_indexed
    }
}
