//! The rows of a run so far: the last ones in memory, the older ones as numbers on the disk.
//!
//! Rows that are full blocks never change, so histories of saved states and branches share them. Without a folder of results blocks stay in
//! memory. The file has no name as soon as it is open, where the system allows that: nothing of it is left, however the program ends.

use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::counted::FOLDER;
use crate::dynamics::{LedgerRow, RowShape, Rows};

/// Rows of a block at most. Between one and two blocks are in memory.
const BLOCK: usize = 64;
/// Name of the file of blocks in the folder of the checkpoints, with a number behind it.
pub const ROWS: &str = "rows";
/// Bytes of a number.
const NUMBER: usize = 8;

/// Where blocks of rows are kept.
#[derive(Debug, Default)]
pub struct RowStore {
    file: RefCell<Stored>,
}

/// The file of blocks.
#[derive(Debug, Default)]
struct Stored {
    /// Folder of the run.
    folder: Option<PathBuf>,
    file: Option<File>,
    length: u64,
    /// Why blocks could not be read.
    problem: Option<String>,
}

impl RowStore {
    /// Keeps blocks in the folder of a run from now on.
    pub fn keep_in(&self, folder: &Path) {
        self.file.borrow_mut().folder.get_or_insert_with(|| folder.into());
    }

    /// Why rows could not be read back, if that has happened.
    pub fn problem(&self) -> Option<String> {
        self.file.borrow().problem.clone()
    }

    /// Puts numbers into the file; their place. `None` where there is no folder, or it cannot be written to.
    fn put(&self, numbers: &[f64]) -> Option<u64> {
        let mut stored = self.file.borrow_mut();
        let Stored { folder, file, length, .. } = &mut *stored;
        let folder = folder.as_ref()?;
        if file.is_none() {
            *file = opened(folder).ok();
        }
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let written = |file: &mut File| file.seek(SeekFrom::Start(*length)).and_then(|_| file.write_all(&bytes));
        written(file.as_mut()?).ok()?;
        let place = *length;
        *length += bytes.len() as u64;
        Some(place)
    }

    /// Reads numbers back. No numbers where that fails, which is kept as a problem.
    fn take(&self, place: u64, count: usize) -> Vec<f64> {
        let mut stored = self.file.borrow_mut();
        let mut bytes = vec![0; NUMBER * count];
        let read = match &mut stored.file {
            Some(file) => file.seek(SeekFrom::Start(place)).and_then(|_| file.read_exact(&mut bytes)),
            None => Err(io::Error::from(io::ErrorKind::NotFound)),
        };
        if let Err(error) = read {
            stored.problem.get_or_insert_with(|| error.to_string());
            return vec![f64::NAN; count];
        }
        bytes.chunks_exact(NUMBER).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default())).collect()
    }
}

/// A file below the folder of a run that has lost its name.
fn opened(run: &Path) -> io::Result<File> {
    let folder = run.join(FOLDER);
    fs::create_dir_all(&folder)?;
    let place = folder.join(format!("{ROWS}-{}", std::process::id()));
    let file = File::options().read(true).write(true).create(true).truncate(true).open(&place)?;
    if cfg!(unix) {
        fs::remove_file(&place)?;
        // Only an empty one goes.
        let _ = fs::remove_dir(&folder);
    }
    Ok(file)
}

/// Rows of one shape that do not change any more.
#[derive(Debug)]
struct Block {
    /// Index of its first row in every history that has it.
    first: usize,
    count: usize,
    shape: RowShape,
    place: Place,
}

#[derive(Debug)]
enum Place {
    Memory(Vec<f64>),
    File(u64),
}

impl Block {
    /// Calls a function with its rows from the one of index `from` of the history on.
    fn visit(&self, store: &RowStore, from: usize, row: &mut LedgerRow, each: &mut dyn FnMut(&LedgerRow)) {
        let size = self.shape.numbers();
        let from = from.saturating_sub(self.first).min(self.count);
        let read;
        let numbers = match &self.place {
            Place::Memory(numbers) => &numbers[size * from..],
            Place::File(place) => {
                read = store.take(place + (NUMBER * size * from) as u64, size * (self.count - from));
                &read[..]
            }
        };
        for numbers in numbers.chunks_exact(size) {
            row.take_numbers(&self.shape, numbers);
            each(row);
        }
    }
}

/// The rows of a run so far; cheap to clone.
#[derive(Clone, Debug)]
pub struct History {
    store: Rc<RowStore>,
    blocks: Vec<Rc<Block>>,
    /// Rows in blocks.
    blocked: usize,
    last: Vec<LedgerRow>,
}

impl History {
    /// A history of some rows.
    pub fn new(store: Rc<RowStore>, rows: Vec<LedgerRow>) -> Self {
        let mut history = History { store, blocks: Vec::new(), blocked: 0, last: Vec::new() };
        rows.into_iter().for_each(|row| history.push(row));
        history
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.blocked + self.last.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Why rows could not be read back from the disk, if that has happened.
    pub fn problem(&self) -> Option<String> {
        self.store.problem()
    }

    /// The last row.
    pub fn last(&self) -> Option<&LedgerRow> {
        self.last.last()
    }

    /// The row of an index.
    pub fn row(&self, index: usize) -> Option<LedgerRow> {
        let mut found = None;
        self.visit_some(index, index + 1, &mut |row| found = Some(row.clone()));
        found
    }

    /// Rows of a range of indices.
    pub fn rows(&self, from: usize, to: usize) -> Vec<LedgerRow> {
        let mut found = Vec::new();
        self.visit_some(from, to, &mut |row| found.push(row.clone()));
        found
    }

    /// The history of the first rows.
    pub fn first(&self, count: usize) -> Self {
        let whole = self.blocks.partition_point(|block| block.first + block.count <= count);
        let mut first = History { store: self.store.clone(), blocks: self.blocks[..whole].to_vec(), blocked: 0, last: Vec::new() };
        first.blocked = first.blocks.last().map_or(0, |block| block.first + block.count);
        // The last row is one in memory, so that it can be looked at and replaced.
        if first.blocked == count && count > 0 {
            first.blocked = first.blocks.pop().map_or(0, |block| block.first);
        }
        first.last = self.rows(first.blocked, count);
        first
    }

    /// Adds a row.
    pub fn push(&mut self, row: LedgerRow) {
        self.last.push(row);
        if self.last.len() >= 2 * BLOCK {
            self.put_away(BLOCK);
        }
    }

    /// Replaces the last row.
    pub fn replace_last(&mut self, row: LedgerRow) {
        if let Some(last) = self.last.last_mut() {
            *last = row;
        }
    }

    /// Takes all rows out.
    pub fn clear(&mut self) {
        (self.blocks, self.blocked, self.last) = (Vec::new(), 0, Vec::new());
    }

    /// Number of rows at the beginning that both have.
    pub fn common(&self, other: &History) -> usize {
        let shared = self.blocks.iter().zip(&other.blocks).take_while(|(a, b)| Rc::ptr_eq(a, b)).count();
        let from = shared.checked_sub(1).map_or(0, |last| self.blocks[last].first + self.blocks[last].count);
        self.alike(other, from, |a, b| a == b)
    }

    /// Index from `from` on up to which the rows of both are alike.
    pub fn alike(&self, other: &History, mut from: usize, are: impl Fn(&LedgerRow, &LedgerRow) -> bool) -> usize {
        loop {
            let [own, others] = [self, other].map(|history| history.rows(from, from + BLOCK));
            let same = own.iter().zip(&others).take_while(|(a, b)| are(a, b)).count();
            from += same;
            if same < BLOCK {
                return from;
            }
        }
    }

    /// Makes blocks of the first rows in memory, one for each shape in turn.
    fn put_away(&mut self, count: usize) {
        let mut rest = self.last.split_off(count);
        std::mem::swap(&mut rest, &mut self.last);
        let mut numbers = Vec::new();
        for rows in rest.chunk_by(|a, b| RowShape::of(a).is_of(b)) {
            let shape = RowShape::of(&rows[0]);
            rows.iter().for_each(|row| row.put_numbers(&mut numbers));
            let place = match self.store.put(&numbers) {
                Some(place) => Place::File(place),
                None => Place::Memory(numbers.clone()),
            };
            numbers.clear();
            self.blocks.push(Rc::new(Block { first: self.blocked, count: rows.len(), shape, place }));
            self.blocked += rows.len();
        }
    }

    fn visit_some(&self, from: usize, to: usize, each: &mut dyn FnMut(&LedgerRow)) {
        let mut index = from;
        let mut within = |row: &LedgerRow| {
            if index < to {
                each(row);
            }
            index += 1;
        };
        let mut row = LedgerRow::default();
        let begin = self.blocks.partition_point(|block| block.first + block.count <= from);
        let blocks = self.blocks[begin..].iter().take_while(|block| block.first < to);
        blocks.for_each(|block| block.visit(&self.store, from, &mut row, &mut within));
        let skipped = from.saturating_sub(self.blocked).min(self.last.len());
        let end = to.saturating_sub(self.blocked).min(self.last.len()).max(skipped);
        self.last[skipped..end].iter().for_each(within);
    }
}

impl Rows for History {
    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&self, from: usize, each: &mut dyn FnMut(&LedgerRow)) {
        self.visit_some(from, usize::MAX, each);
    }

    fn last_row(&self) -> Option<LedgerRow> {
        self.last.last().cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::scratch;
    use super::*;
    use crate::dynamics::ProbeValues;

    fn row(step: usize) -> LedgerRow {
        let probes = vec![ProbeValues { displacement: [step as f64; 3], ..ProbeValues::default() }; usize::from(step > 700)];
        LedgerRow { step, time: 0.1 * step as f64, probes, ..LedgerRow::default() }
    }

    #[test]
    fn rows_come_back_from_memory_and_from_the_disk() {
        let (directory, _) = scratch("history rows");
        for is_on_disk in [false, true] {
            let store = Rc::new(RowStore::default());
            if is_on_disk {
                store.keep_in(&directory);
            }
            let all: Vec<LedgerRow> = (0..1500).map(row).collect();
            let history = History::new(store.clone(), all.clone());
            assert!(history.last.len() < 2 * BLOCK && history.len() == 1500 && history.last() == all.last());
            for from in [0, 1, 255, 256, 257, 701, 1200, 1499, 1500, 2000] {
                let mut seen = Vec::new();
                history.visit(from, &mut |row| seen.push(row.clone()));
                assert_eq!(seen, all[from.min(1500)..], "from {from}");
                assert_eq!(history.row(from), all.get(from).cloned());
            }
            for count in [0, 1, 256, 512, 700, 701, 1400, 1500] {
                let mut first = history.first(count);
                assert_eq!((first.rows(0, 9999), first.last()), (all[..count].to_vec(), all[..count].last()));
                assert_eq!((first.common(&history), history.common(&first)), (count, count));
                first.push(row(7));
                assert_eq!(first.common(&history), count + usize::from(count == 7));
            }
            assert_eq!(store.problem(), None);
            assert_eq!(store.file.borrow().length > 0, is_on_disk);
            assert!(!directory.join(FOLDER).exists());
        }
    }
}
