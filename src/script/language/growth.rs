//! `push` and `sort` of arrays, replacing those of the engine.
//!
//! The engine measures an array with all of its entries after every call that may have changed it, so that `n` pushes cost `n^2`. This
//! `push` caches the sizes of the arrays that were pushed to last, adds the new entry, and measures only unknown or reallocated arrays: the
//! limits hold as before. The engine sorts only values of one type; here whole numbers and fractions are both numbers.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::rc::Rc;

use rhai::{Array, Blob, Dynamic, Engine, EvalAltResult, FuncRegistration, ImmutableString, Map, Module, NativeCallContext, RhaiFunc};

use super::causes;
use super::failure::Failure;
use super::values::{as_number, describe};
use super::wording::joined;

type Outcome = Result<(), Box<EvalAltResult>>;

/// Number of arrays whose size `push` caches.
const REMEMBERED: usize = 32;

/// Size of a value including nested values, as counted by the limits.
#[derive(Clone, Copy, Default)]
struct Size {
    entries: usize,
    keys: usize,
    letters: usize,
}

impl Size {
    fn add(&mut self, value: &Dynamic) {
        if let Some(array) = value.read_lock::<Array>() {
            self.entries += array.len();
            array.iter().for_each(|value| self.add(value));
        } else if let Some(map) = value.read_lock::<Map>() {
            self.keys += map.len();
            map.values().for_each(|value| self.add(value));
        } else if let Some(text) = value.read_lock::<ImmutableString>() {
            self.letters += text.len();
        } else if let Some(bytes) = value.read_lock::<Blob>() {
            self.entries += bytes.len();
        }
    }

    fn of(value: &Dynamic) -> Self {
        let mut size = Size::default();
        size.add(value);
        size
    }

    fn fits(&self, engine: &Engine) -> bool {
        let within = |size: usize, most: usize| most == 0 || size <= most;
        within(self.entries, engine.max_array_size())
            && within(self.keys, engine.max_map_size())
            && within(self.letters, engine.max_string_size())
    }
}

/// Array after its last push: address, length, capacity and size of its entries.
struct Known {
    address: usize,
    length: usize,
    capacity: usize,
    size: Size,
}

/// The arrays that were pushed to last, the latest at the end.
#[derive(Default)]
struct Memory(RefCell<Vec<Known>>);

impl Memory {
    /// Appends a value to an array, unless the array would exceed its limit.
    fn push(&self, engine: &Engine, target: &mut Dynamic, item: Dynamic) -> Outcome {
        let mut known = self.0.borrow_mut();
        let (before, after) = {
            let Ok(mut array) = target.as_array_mut() else { return Ok(()) };
            let before = (array.as_ptr() as usize, array.len(), array.capacity());
            let mut added = Size { entries: 1, ..Size::default() };
            added.add(&item);
            array.push(item);
            (before, Known { address: array.as_ptr() as usize, length: array.len(), capacity: array.capacity(), size: added })
        };
        let place = known.iter().rposition(|known| known.address == before.0);
        let last = place.map(|place| known.remove(place)).filter(|known| (known.address, known.length, known.capacity) == before);
        // Measuring a moved array costs no more than moving it.
        let last = last.filter(|last| last.capacity == after.capacity).map(|last| last.size);
        let mut size = match last {
            Some(Size { entries, keys, letters }) => {
                let added = after.size;
                Size { entries: entries + added.entries, keys: keys + added.keys, letters: letters + added.letters }
            }
            None => Size::of(target),
        };
        if !size.fits(engine) {
            engine.ensure_data_size_within_limits(target)?;
            size = Size::of(target);
        }
        if known.len() == REMEMBERED {
            known.remove(0);
        }
        known.push(Known { size, ..after });
        Ok(())
    }
}

/// Sorts numbers by value, texts alphabetically.
fn sort(engine: &Engine, array: &mut Array) -> Result<(), Failure> {
    let text = |value: &Dynamic| value.read_lock::<ImmutableString>().map(|text| text.clone());
    if array.iter().all(|value| as_number(value).is_some()) {
        array.sort_by(|a, b| match (a.as_int(), b.as_int()) {
            (Ok(a), Ok(b)) => a.cmp(&b),
            _ => as_number(a).zip(as_number(b)).map_or(Ordering::Equal, |(a, b)| a.total_cmp(&b)),
        });
        return Ok(());
    }
    if array.iter().all(|value| value.is_string() || value.is_char()) {
        array.sort_by_cached_key(|value| text(value).unwrap_or_else(|| value.to_string().into()));
        return Ok(());
    }
    if array.iter().all(Dynamic::is_bool) {
        array.sort_by_key(|value| value.as_bool().unwrap_or_default());
        return Ok(());
    }
    let mut kinds: Vec<&Dynamic> = array.iter().collect();
    kinds.dedup_by_key(|value| value.type_id());
    let some: Vec<String> = kinds.iter().take(2).map(|value| describe(engine, value)).collect();
    let failure = Failure::script("`sort` orders numbers, or strings, but no others and no mixture").code(causes::WRONG_TYPE);
    let failure = failure.cause(format!("the array has {}", joined(&some, "and")));
    Err(failure.hint("say what comes first: `array.sort(|a, b| if a.time < b.time { -1 } else { 1 })`"))
}

type Method = fn(&NativeCallContext, &mut Array) -> Result<Dynamic, Failure>;

/// Variants of sorting: in place or as a copy, ascending or descending.
const SORTS: [(&str, Method); 4] = [
    ("sort", |context, array| sort(context.engine(), array).map(|()| Dynamic::UNIT)),
    ("sort_desc", |context, array| {
        sort(context.engine(), array)?;
        array.reverse();
        Ok(Dynamic::UNIT)
    }),
    ("sorted", |context, array| {
        let mut copy = array.clone();
        sort(context.engine(), &mut copy)?;
        Ok(copy.into())
    }),
    ("sorted_desc", |context, array| {
        let mut copy = array.clone();
        sort(context.engine(), &mut copy)?;
        copy.reverse();
        Ok(copy.into())
    }),
];

/// Adds the functions to a module.
pub fn register(module: &mut Module) {
    let memory = Memory::default();
    let push = move |context: Option<NativeCallContext>, values: &mut [&mut Dynamic]| {
        if let (Some(context), [array, item]) = (context, &mut *values) {
            memory.push(context.engine(), array, std::mem::take(*item))?;
            // The engine measures the first argument, which is now the empty place of the item.
            std::mem::swap(array, item);
        }
        Ok(Dynamic::UNIT)
    };
    let types = [std::any::TypeId::of::<Array>(), std::any::TypeId::of::<Dynamic>()];
    let described = ["array: Array", "value: any", "()"];
    FuncRegistration::new("push").in_global_namespace().with_params_info(described).set_into_module_raw(
        module,
        types,
        RhaiFunc::Method { func: Rc::new(push), has_context: true, is_pure: false, is_volatile: true },
    );
    for (name, method) in SORTS {
        FuncRegistration::new(name)
            .in_global_namespace()
            .with_params_info(["array: Array", "any"])
            .set_into_module(module, move |context: NativeCallContext, array: &mut Array| -> Result<Dynamic, Box<EvalAltResult>> {
                Ok(method(&context, array)?)
            });
    }
}
