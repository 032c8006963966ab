//! Damaged mesh files: bytes flipped, cut, duplicated and moved, numbers replaced by extreme ones, parts of other files inserted.
//!
//! Reading any file ends with a valid mesh or a message, and its memory is bounded by the length of the file.

use std::path::{Path, PathBuf};

use conserva::mesh::{MESH_ENDINGS, ReadOptions, read_deck_bytes, read_mesh_bytes};

#[path = "splitmix.rs"]
mod splitmix;

pub use splitmix::SplitMix;

/// Unusual texts in place of a number or a word.
const STRANGE: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "3",
    "4",
    "5",
    "9",
    "15",
    "16",
    "1000000000000",
    "4294967296",
    "2147483648",
    "18446744073709551615",
    "-9223372036854775808",
    "99999999999999999999",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "1D5",
    "",
    ",",
    ",,",
    "$",
    "*",
    "**",
    "\"",
    "=",
    "GENERATE",
    "S1",
    "S7",
    "*NODE",
    "*ELEMENT, TYPE=CPS4",
    "*NSET, NSET=a",
    "*INCLUDE",
    "*INCLUDE, INPUT=a",
    "*PART, NAME=a",
    "*END PART",
    "*INSTANCE, NAME=a, PART=Square",
    "*END INSTANCE",
    "*ELEMENT, TYPE=S4",
    "*ELEMENT, TYPE=MASS",
    "*CONTACT PAIR",
    "$PartitionedEntities",
    "$ParametricNodes",
    "One.1",
    "INSTANCE=One",
    "$EndNodes",
    "DATASET",
    "FIELD",
    "MARKER_TAG=",
    "GRID",
    "CHEXA",
    "2467",
    "format=\"binary\"",
    "type=\"Float32\"",
    "<!--",
    "$Elements",
    "\n",
    "\u{feff}",
    "ä",
];

/// Undamaged files with their paths.
pub fn originals() -> Vec<(PathBuf, Vec<u8>)> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let mut found = Vec::new();
    for folder in ["made", "refused", "small", "."] {
        let entries = std::fs::read_dir(tests.join(folder)).unwrap_or_else(|error| panic!("{folder}: {error}"));
        let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        paths.sort();
        paths.retain(|path| path.extension().is_some_and(|ending| MESH_ENDINGS.iter().any(|known| ending == *known)));
        found.extend(paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap_or_default())));
    }
    found
}

/// A damaged copy of one of the originals.
pub fn damaged(originals: &[(PathBuf, Vec<u8>)], random: &mut SplitMix) -> Vec<u8> {
    let mut content = random.pick(originals).1.clone();
    for _ in 0..1 + random.below(4) {
        damage(&mut content, originals, random);
    }
    content
}

fn damage(content: &mut Vec<u8>, originals: &[(PathBuf, Vec<u8>)], random: &mut SplitMix) {
    let place = random.below(content.len() + 1);
    let end = (place + 1 + random.below(40)).min(content.len());
    match random.below(9) {
        0 if place < content.len() => content[place] ^= 1 << random.below(8),
        1 if place < content.len() => content[place] = [0, 0xff, 0x7f, 0x80, b'\n', b'$', b'*', b'-', b'9'][random.below(9)],
        2 => content.truncate(place),
        3 => drop(content.drain(place.min(end)..end)),
        4 => {
            let piece = content[place.min(end)..end].to_vec();
            let to = random.below(content.len() + 1);
            drop(content.splice(to..to, piece));
        }
        5 => {
            let other = &random.pick(originals).1;
            let from = random.below(other.len() + 1);
            let piece = other[from..(from + random.below(200)).min(other.len())].to_vec();
            drop(content.splice(place..place, piece));
        }
        6 => {
            // eight bytes that are a count, a size or a floating-point number
            let number: [u8; 8] = match random.below(4) {
                0 => 1_000_000_000_000u64.to_le_bytes(),
                1 => f64::NAN.to_le_bytes(),
                2 => u64::MAX.to_le_bytes(),
                _ => (random.below(20) as u64).to_le_bytes(),
            };
            let end = (place + 8).min(content.len());
            drop(content.splice(place..end, number));
        }
        _ => replace_word(content, place, random),
    }
}

/// Replaces the word at a place of a text.
fn replace_word(content: &mut Vec<u8>, place: usize, random: &mut SplitMix) {
    let is_between = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',' || *byte == b'=';
    let begin = content[..place].iter().rposition(is_between).map_or(0, |before| before + 1);
    let end = content[place..].iter().position(is_between).map_or(content.len(), |after| place + after);
    // words of a text are short; a long one is part of a binary file
    if end - begin < 60 {
        content.splice(begin..end, random.pick(STRANGE).bytes());
    }
}

/// True if a content was read. A mesh that was read must be valid; a message must have a hint.
#[allow(dead_code)] // some test programs do not call it
pub fn judged(content: &[u8]) -> bool {
    if let Ok(deck) = read_deck_bytes(content, ReadOptions::default()) {
        deck.parts.iter().for_each(|part| assert_eq!(part.mesh.defects(), []));
    }
    match read_mesh_bytes(content) {
        Ok(mesh) => {
            assert_eq!(mesh.defects(), []);
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty() && !error.hint().is_empty());
            false
        }
    }
}
