//! Lines that a script printed and pictures that it drew, for the page of the run.

use std::cell::RefCell;
use std::collections::VecDeque;

use crate::script::language::host::Host;

/// Number of lines that are kept from the start of a run, and from its end.
const LINES: [usize; 2] = [100, 400];

/// Lines that a script printed; if there are many, the first and the last ones.
#[derive(Default)]
pub struct Printed(RefCell<(Vec<String>, VecDeque<String>, usize)>);

impl Printed {
    /// Prints a text of one or more lines, and stores it for the report.
    pub fn show(host: &Host, text: &str) {
        host.observer.print(text);
        let printed = host.slots.get::<Printed>();
        let (first, last, dropped) = &mut *printed.0.borrow_mut();
        for line in text.lines() {
            if first.len() < LINES[0] {
                first.push(line.into());
                continue;
            }
            last.push_back(line.into());
            if last.len() > LINES[1] {
                last.pop_front();
                *dropped += 1;
            }
        }
    }

    /// Returns the printed lines so far.
    pub fn of(host: &Host) -> Vec<String> {
        let printed = host.slots.get::<Printed>();
        let (first, last, dropped) = &*printed.0.borrow();
        let gap = (*dropped > 0).then(|| format!("… {dropped} lines are left out here …"));
        first.iter().cloned().chain(gap).chain(last.iter().cloned()).collect()
    }
}

/// Pictures and movies that a script drew: simulation in whose folder the file is (`None`: folder of the run), and path in that folder.
#[derive(Default)]
pub struct Pictures(RefCell<Vec<(Option<String>, String)>>);

impl Pictures {
    /// Adds a file that was written, if it is a picture; a file that is written again counts once.
    pub fn note(host: &Host, simulation: Option<String>, path: &str) {
        let pictures = host.slots.get::<Pictures>();
        let entry = (simulation, path.to_string());
        let is_picture = [".svg", ".png", ".gif"].iter().any(|ending| path.ends_with(ending));
        let mut all = pictures.0.borrow_mut();
        if is_picture && !all.contains(&entry) {
            all.push(entry);
        }
    }

    /// Returns the pictures so far.
    pub fn of(host: &Host) -> Vec<(Option<String>, String)> {
        host.slots.get::<Pictures>().0.borrow().clone()
    }
}
