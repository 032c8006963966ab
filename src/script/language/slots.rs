//! Values of a session, one of each type.
//!
//! The API stores in the session the shared data of its functions: the simulations of a script, the models that were simulated, the values
//! of `--set`. The host stores these without depending on their types, so that the language stays below the API.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A value of each type.
#[derive(Default)]
pub struct Slots(RefCell<BTreeMap<TypeId, Rc<dyn Any>>>);

impl Slots {
    /// Returns the value of a type; its default on the first call.
    pub fn get<T: Default + 'static>(&self) -> Rc<T> {
        let mut slots = self.0.borrow_mut();
        let slot = slots.entry(TypeId::of::<T>()).or_insert_with(|| Rc::new(T::default()));
        slot.clone().downcast::<T>().unwrap_or_default()
    }

    /// Sets the value of a type.
    pub fn set<T: 'static>(&self, value: Rc<T>) {
        let before = self.0.borrow_mut().insert(TypeId::of::<T>(), value);
        drop(before);
    }

    /// Drops all values. Drop implementations may access slots, so the table is unlocked by then.
    pub fn clear(&self) {
        let slots = self.0.take();
        drop(slots);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Count(std::cell::Cell<usize>);

    #[test]
    fn there_is_one_value_of_each_type() {
        let slots = Slots::default();
        slots.get::<Count>().0.set(3);
        assert_eq!(slots.get::<Count>().0.get(), 3);
        slots.set(Rc::new(Count::default()));
        assert_eq!(slots.get::<Count>().0.get(), 0);
        slots.get::<Count>().0.set(1);
        slots.clear();
        assert_eq!(slots.get::<Count>().0.get(), 0);
    }
}
