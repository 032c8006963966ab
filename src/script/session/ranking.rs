//! Order of the entries found by a search: the best match comes first.

use std::cmp::Reverse;
use std::rc::Rc;

use super::reference::{Entry, Reference};
use super::synonyms::meant;
use crate::script::language::function::Function;
use crate::script::language::parameter::Parameter;

/// Rank of an entry whose subject is the text; entries that only mention it have larger ranks.
const MEANT: usize = 50;

/// Returns all entries whose subject is a text or that mention all its words, the best matches first.
pub fn ranked(reference: &Reference, text: &str) -> Vec<Entry> {
    let mut found = reference.search(text);
    let names: Vec<&str> = meant(text).into_iter().flat_map(|(_, names)| names.iter().copied()).collect();
    let is_found =
        |function: &Rc<Function>| found.iter().any(|entry| matches!(entry, Entry::Function(known) if Rc::ptr_eq(known, function)));
    let meant = reference.functions().iter().filter(|function| names.contains(&function.name) && !is_found(function));
    let meant: Vec<Entry> = meant.cloned().map(Entry::Function).collect();
    found.extend(meant);
    found.sort_by_key(|entry| Reverse(rank(entry, text)));
    found
}

/// True if the text is the subject of the entry.
pub fn is_meant(entry: &Entry, text: &str) -> bool {
    rank(entry, text) >= MEANT
}

/// Relevance of an entry for a text: found in its name, in a key of its options, in its summary, or only in other texts.
fn rank(entry: &Entry, text: &str) -> usize {
    let text = text.trim().to_lowercase();
    let wanted = text.replace([' ', '-'], "_");
    match entry {
        Entry::Function(function) => {
            let synonyms: Vec<&str> = meant(&text).into_iter().flat_map(|(_, names)| names.iter().copied()).collect();
            let place = synonyms.iter().position(|name| *name == function.name);
            let of_synonyms = place.map_or(0, |place| 2 * MEANT - place);
            let of_key = if has_key(&function.parameters, &wanted) { MEANT } else { 0 };
            // Methods that create objects precede methods that read them.
            let of_form = if function.reads() { 0 } else { 1 };
            let of_name = if function.name == wanted {
                if function.reads() { MEANT } else { 4 * MEANT }
            } else if function.name.contains(&wanted) {
                20
            } else {
                0
            };
            let of_summary = if function.summary.to_lowercase().contains(&text) { 10 } else { 0 };
            of_synonyms + of_key + of_name + of_summary + of_form
        }
        Entry::Word(word) if word.name.contains(&wanted) => 15,
        Entry::Page(page) if page.names.contains(&text.as_str()) => 4 * MEANT,
        Entry::Topic(..) | Entry::Type(..) => 5,
        Entry::Word(_) | Entry::Page(_) | Entry::Code(_) => 0,
    }
}

fn has_key(parameters: &[Parameter], name: &str) -> bool {
    let keys = |parameter: &Parameter| parameter.kind.keys().is_some_and(|keys| keys.iter().any(|key| key.name == name));
    parameters.iter().any(keys)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::session::Session;
    use super::*;
    use crate::script::language::observer::Silent;
    use crate::script::language::settings::Settings;

    #[test]
    fn what_is_meant_comes_first() {
        let session = Session::new(Settings::default(), Path::new("."), Rc::new(Silent)).unwrap();
        let reference = Reference::new(&session.registry());
        for (text, name) in [("friction", "add_contact"), ("dashpot", "add_damper"), ("natural frequency", "modes"), ("weld", "tie")] {
            let first = ranked(&reference, text).into_iter().next();
            let found = first.as_ref().map(Entry::line).unwrap_or_default();
            assert!(found.split(':').next().unwrap_or("").ends_with(name), "{text}: {found}");
        }
    }
}
