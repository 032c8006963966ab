//! A value that stays on its thread, with a handle that may be sent to others.
//!
//! Models and simulations can be sent to other threads, values of the engine cannot. A closure called by the solver is therefore stored by
//! the thread of its engine, and the solver holds its number. On any other thread the handle finds no value, and the call fails as that of
//! a closure whose script has ended.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::marker::PhantomData;
use std::rc::Rc;
use std::thread::{self, ThreadId};

thread_local! {
    static KEPT: RefCell<HashMap<u64, Rc<dyn Any>>> = RefCell::default();
    static NEXT: Cell<u64> = const { Cell::new(0) };
}

/// Handle of a value that belongs to the thread of its creation.
#[derive(Debug)]
pub struct ThreadBound<T> {
    number: u64,
    home: ThreadId,
    kind: PhantomData<fn() -> T>,
}

impl<T: 'static> ThreadBound<T> {
    /// Keeps a value as long as the handle lives, or else as long as the thread.
    pub fn new(value: T) -> Self {
        let number = NEXT.replace(NEXT.get() + 1);
        KEPT.with_borrow_mut(|kept| kept.insert(number, Rc::new(value)));
        ThreadBound { number, home: thread::current().id(), kind: PhantomData }
    }

    /// Returns the value; `None` on another thread.
    pub fn get(&self) -> Option<Rc<T>> {
        let found = (thread::current().id() == self.home).then(|| KEPT.with_borrow(|kept| kept.get(&self.number).cloned()))?;
        found?.downcast().ok()
    }
}

impl<T> Drop for ThreadBound<T> {
    fn drop(&mut self) {
        if thread::current().id() == self.home {
            // The value is dropped outside of any borrow, since it may contain further handles. At the end of a thread all values have been
            // dropped.
            let value = KEPT.try_with(|kept| kept.borrow_mut().remove(&self.number));
            drop(value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_found_on_its_thread_alone_and_goes_with_its_handle() {
        let shared = Rc::new(7);
        let outer = ThreadBound::new((shared.clone(), ThreadBound::new(shared.clone())));
        let found = outer.get().unwrap();
        assert_eq!((*found.0, **found.1.get().unwrap()), (7, 7));
        drop(found);
        assert_eq!(Rc::strong_count(&shared), 3);
        let outer = thread::spawn(move || {
            assert!(outer.get().is_none());
            outer
        });
        drop(outer.join().unwrap());
        assert_eq!(Rc::strong_count(&shared), 1);
    }
}
