//! Rows of a run so far: the last ones in memory, the older ones on disk.
//!
//! Complete blocks of rows never change, so histories of saved states and branches share blocks. Without an output folder, blocks stay in
//! memory. The file of blocks is unlinked when opened, if the system permits, so that no file is left however the program ends; a resumed
//! run fills a new file from its journal.

use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::rc::Rc;

use super::counted::FOLDER;
use super::files::RunFiles;
use crate::dynamics::{LedgerRow, Rows};

/// Rows per block. Between one and two blocks are in memory.
const BLOCK: usize = 64;
/// Name of the file of blocks in the folder of the checkpoints, followed by the process number.
pub const ROWS: &str = "rows";

/// Storage of blocks of rows.
#[derive(Debug, Default)]
pub struct RowStore {
    file: RefCell<Stored>,
}

/// File of blocks.
#[derive(Debug, Default)]
struct Stored {
    /// Files of the run that has the history.
    run: Option<RunFiles>,
    file: Option<File>,
    length: u64,
    /// Reason why blocks could not be read.
    problem: Option<String>,
}

impl RowStore {
    /// Stores further blocks in the folder of a run.
    pub fn keep_in(&self, run: &RunFiles) {
        self.file.borrow_mut().run.get_or_insert_with(|| run.clone());
    }

    /// Reason why rows could not be read back, if that has happened.
    pub fn problem(&self) -> Option<String> {
        self.file.borrow().problem.clone()
    }

    /// Stores a block in the file, or in memory without a folder or with a full disk.
    fn put(&self, bytes: Vec<u8>) -> BlockStorage {
        let mut stored = self.file.borrow_mut();
        let Stored { run, file, length, .. } = &mut *stored;
        if let (None, Some(run)) = (&file, run) {
            *file = opened(run);
        }
        let written = |file: &mut File| file.seek(SeekFrom::Start(*length)).and_then(|_| file.write_all(&bytes));
        if file.as_mut().is_none_or(|file| written(file).is_err()) {
            return BlockStorage::Memory(bytes);
        }
        let place = BlockStorage::File { start: *length, length: bytes.len() };
        *length += bytes.len() as u64;
        place
    }

    /// Reads a block from the file.
    fn take(&self, start: u64, length: usize) -> io::Result<Vec<u8>> {
        let mut stored = self.file.borrow_mut();
        let file = stored.file.as_mut().ok_or(io::ErrorKind::NotFound)?;
        let mut bytes = vec![0; length];
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

/// Creates a file below the folder of a run, unlinked where the system allows that; links are not followed.
fn opened(run: &RunFiles) -> Option<File> {
    let place = run.place(&format!("{FOLDER}/{ROWS}-{}", std::process::id())).ok()?;
    let _ = fs::remove_file(&place);
    let file = File::options().read(true).write(true).create_new(true).open(&place).ok()?;
    if cfg!(unix) {
        fs::remove_file(&place).ok()?;
        // A folder with other files is not removed.
        let _ = place.parent().map(fs::remove_dir);
    }
    Some(file)
}

/// Rows that are final, encoded by [`LedgerRow::pack`].
#[derive(Debug)]
struct Block {
    /// Index of the block's first row, equal in every history that shares the block.
    first: usize,
    count: usize,
    place: BlockStorage,
}

#[derive(Debug)]
enum BlockStorage {
    Memory(Vec<u8>),
    File { start: u64, length: usize },
}

impl Block {
    /// Calls `each` with every row. If the block cannot be read, the rows are meaningless, and the store records the problem.
    fn visit(&self, store: &RowStore, each: &mut dyn FnMut(&LedgerRow)) {
        let read;
        let mut rest = match &self.place {
            BlockStorage::Memory(bytes) => &bytes[..],
            BlockStorage::File { start, length } => {
                let bytes = store.take(*start, *length);
                read = bytes.unwrap_or_else(|error| {
                    store.file.borrow_mut().problem.get_or_insert_with(|| error.to_string());
                    Vec::new()
                });
                &read[..]
            }
        };
        let mut row = LedgerRow::default();
        for _ in 0..self.count {
            rest = row.unpack(rest).unwrap_or_else(|| {
                store.file.borrow_mut().problem.get_or_insert_with(|| "a block of rows is damaged".into());
                &[]
            });
            each(&row);
        }
    }
}

/// Rows of a run; cheap to clone.
#[derive(Clone, Debug)]
pub struct History {
    store: Rc<RowStore>,
    blocks: Vec<Rc<Block>>,
    /// Number of rows in blocks.
    blocked: usize,
    last: Vec<LedgerRow>,
}

impl History {
    /// Returns a history with the given rows.
    pub fn new(store: Rc<RowStore>, rows: Vec<LedgerRow>) -> Self {
        let mut history = History { store, blocks: Vec::new(), blocked: 0, last: Vec::new() };
        rows.into_iter().for_each(|row| history.push(row));
        history
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.blocked + self.last.len()
    }

    /// True if the history has no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Reason why rows could not be read back from the disk, if that has happened.
    pub fn problem(&self) -> Option<String> {
        self.store.problem()
    }

    /// The last row.
    pub fn last(&self) -> Option<&LedgerRow> {
        self.last.last()
    }

    /// Returns the row with an index.
    pub fn row(&self, index: usize) -> Option<LedgerRow> {
        let mut found = None;
        self.visit_some(index, index + 1, &mut |row| found = Some(row.clone()));
        found
    }

    /// Returns the rows `from` to `to`.
    pub fn rows(&self, from: usize, to: usize) -> Vec<LedgerRow> {
        let mut found = Vec::new();
        self.visit_some(from, to, &mut |row| found.push(row.clone()));
        found
    }

    /// Returns a history of the first `count` rows.
    pub fn first(&self, count: usize) -> Self {
        let whole = self.blocks.partition_point(|block| block.first + block.count <= count);
        let mut first = History { store: self.store.clone(), blocks: self.blocks[..whole].to_vec(), blocked: 0, last: Vec::new() };
        first.blocked = first.blocks.last().map_or(0, |block| block.first + block.count);
        // The last row must be in memory, where it can be read and replaced.
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

    /// Removes all rows.
    pub fn clear(&mut self) {
        (self.blocks, self.blocked, self.last) = (Vec::new(), 0, Vec::new());
    }

    /// Returns the number of leading rows that both histories share.
    pub fn common(&self, other: &History) -> usize {
        let shared = self.blocks.iter().zip(&other.blocks).take_while(|(a, b)| Rc::ptr_eq(a, b)).count();
        let from = shared.checked_sub(1).map_or(0, |last| self.blocks[last].first + self.blocks[last].count);
        self.alike(other, from, |a, b| a == b)
    }

    /// Returns the first index from `from` at which the rows of both histories differ, or one history ends.
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

    /// Moves the first `count` rows in memory into a block.
    fn put_away(&mut self, count: usize) {
        let mut bytes = Vec::new();
        self.last.drain(..count).for_each(|row| row.pack(&mut bytes));
        self.blocks.push(Rc::new(Block { first: self.blocked, count, place: self.store.put(bytes) }));
        self.blocked += count;
    }

    fn visit_some(&self, from: usize, to: usize, each: &mut dyn FnMut(&LedgerRow)) {
        let begin = self.blocks.partition_point(|block| block.first + block.count <= from);
        for block in self.blocks[begin..].iter().take_while(|block| block.first < to) {
            let mut index = block.first;
            block.visit(&self.store, &mut |row| {
                if (from..to).contains(&index) {
                    each(row);
                }
                index += 1;
            });
        }
        let skipped = from.saturating_sub(self.blocked).min(self.last.len());
        let end = to.saturating_sub(self.blocked).min(self.last.len()).max(skipped);
        self.last[skipped..end].iter().for_each(each);
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
        let (directory, files) = scratch("history rows");
        for is_on_disk in [false, true] {
            let store = Rc::new(RowStore::default());
            if is_on_disk {
                store.keep_in(&files);
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

    #[test]
    fn rows_stay_in_memory_where_the_disk_takes_none() {
        let (directory, files) = scratch("history without a disk");
        let store = Rc::new(RowStore::default());
        store.keep_in(&files);
        fs::write(directory.join(FOLDER), "").unwrap();
        let all: Vec<LedgerRow> = (0..300).map(row).collect();
        let history = History::new(store.clone(), all.clone());
        assert_eq!((history.rows(0, 300), store.problem()), (all, None));
    }

    #[test]
    #[cfg(unix)]
    fn no_link_is_followed() {
        let (directory, files) = scratch("history behind a link");
        let name = format!("{ROWS}-{}", std::process::id());
        fs::create_dir_all(directory.join(FOLDER)).unwrap();
        fs::write(directory.join("mine"), "mine").unwrap();
        std::os::unix::fs::symlink("../mine", directory.join(FOLDER).join(name)).unwrap();
        let store = Rc::new(RowStore::default());
        store.keep_in(&files);
        let all: Vec<LedgerRow> = (0..300).map(row).collect();
        assert_eq!(History::new(store, all.clone()).rows(0, 300), all);
        assert_eq!(fs::read_to_string(directory.join("mine")).unwrap(), "mine");
    }

    #[test]
    fn rows_that_the_disk_has_lost_are_a_problem() {
        let (_directory, files) = scratch("history lost");
        let store = Rc::new(RowStore::default());
        store.keep_in(&files);
        let mut history = History::new(store.clone(), (0..300).map(row).collect());
        store.file.borrow().file.as_ref().unwrap().set_len(100).unwrap();
        let mut count = 0;
        history.visit(0, &mut |_| count += 1);
        assert_eq!(count, 300);
        assert!(store.problem().is_some() && history.problem().is_some());
        // Rows can still be added in memory.
        history.push(row(300));
        assert_eq!(history.last(), Some(&row(300)));
    }
}
