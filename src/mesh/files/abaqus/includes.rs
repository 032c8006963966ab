//! `*INCLUDE` and `INPUT=`: lines of other files are inserted before the text is read, and places in that text are mapped back to lines of
//! the files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::super::options::Includes;
use crate::machine::files;
use crate::mesh::MeshError;
use crate::mesh::file_error::{FileError, FilePosition, FileProblem};

/// Largest nesting depth of included files.
const DEEPEST: usize = 16;
/// Largest number of included files.
const MOST: usize = 1000;

/// Consecutive lines from one file.
struct Stretch {
    /// First line in the text, counted from 1.
    from: usize,
    /// Line of the file at `from`, counted from 1.
    line: usize,
    /// Index into [`Origins::files`]; none for the file that is read.
    file: Option<usize>,
}

/// Origins of the lines of a text.
#[derive(Default)]
pub(super) struct Origins {
    stretches: Vec<Stretch>,
    files: Vec<PathBuf>,
}

/// A text with the lines of all included files.
pub(super) struct Text<'a> {
    pub content: Cow<'a, [u8]>,
    pub origins: Origins,
}

impl<'a> Text<'a> {
    /// Content of a file with all included files.
    pub fn new(content: &'a [u8], includes: Includes) -> Result<Text<'a>, MeshError> {
        let has = |text: &[u8]| content.windows(text.len()).any(|word| word.eq_ignore_ascii_case(text));
        if !has(b"input") && !has(b"include") {
            return Ok(Text { content: Cow::Borrowed(content), origins: Origins::default() });
        }
        let mut expansion = Expansion { origins: Origins::default(), lines: 0, whole: Vec::new(), chain: Vec::new(), includes };
        let outcome = expansion.add(content, None);
        let Expansion { origins, whole, .. } = expansion;
        match outcome {
            Ok(()) => Ok(Text { content: Cow::Owned(whole), origins }),
            Err(error) => Err(origins.located(error)),
        }
    }
}

impl Origins {
    /// Error with its place in the original file.
    pub fn located(&self, mut error: MeshError) -> MeshError {
        let Some(FilePosition::Line(line)) = error.place() else { return error };
        let Some((line, file)) = self.line_of_file(line) else { return error };
        error.set_place(FilePosition::Line(line));
        if let MeshError::File(FileError { problem, .. }) = &mut error {
            use FileProblem::*;
            if let DuplicateNode { first, .. } | DuplicateElement { first, .. } | Truncated { begin: first, .. } = problem
                && let FilePosition::Line(before) = *first
            {
                *first = FilePosition::Line(self.line_of_file(before).map_or(before, |(line, _)| line));
            }
        }
        match file {
            Some(file) => MeshError::Included { file: self.files[file].clone(), error: Box::new(error) },
            None => error,
        }
    }

    /// Line and file of a line of the text.
    fn line_of_file(&self, line: usize) -> Option<(usize, Option<usize>)> {
        let next = self.stretches.partition_point(|stretch| stretch.from <= line);
        let stretch = self.stretches.get(next.checked_sub(1)?)?;
        Some((stretch.line + (line - stretch.from), stretch.file))
    }
}

/// Text under construction.
struct Expansion<'a> {
    origins: Origins,
    /// Lines of the text so far.
    lines: usize,
    whole: Vec<u8>,
    /// Files that are being included, the outermost first.
    chain: Vec<PathBuf>,
    includes: Includes<'a>,
}

impl Expansion<'_> {
    fn add(&mut self, content: &[u8], file: Option<usize>) -> Result<(), MeshError> {
        self.origins.stretches.push(Stretch { from: self.lines + 1, line: 1, file });
        let mut lines = content.split_inclusive(|&byte| byte == b'\n').enumerate();
        while let Some((index, line)) = lines.next() {
            let begin = line.trim_ascii_start();
            let is_keyword = begin.starts_with(b"*") && !begin.starts_with(b"**");
            let mut keyword = if is_keyword { begin.trim_ascii_end().to_vec() } else { Vec::new() };
            let (at, mut last) = (self.lines + 1, index);
            self.push(if is_include(&keyword) { b"\n" } else { line });
            while keyword.ends_with(b",") {
                let Some((index, more)) = lines.next() else { break };
                self.push(if is_include(&keyword) { b"\n" } else { more });
                keyword.extend(more.trim_ascii());
                last = index;
            }
            if let Some(name) = input_of(&keyword) {
                self.include(&keyword, &name, FilePosition::Line(at))?;
                self.origins.stretches.push(Stretch { from: self.lines + 1, line: last + 2, file });
            } else if is_include(&keyword) {
                let problem = FileProblem::MissingParameter { keyword: "INCLUDE".into(), parameter: "INPUT" };
                return Err(FileError { at: FilePosition::Line(at), problem }.into());
            }
        }
        Ok(())
    }

    fn push(&mut self, line: &[u8]) {
        self.whole.extend(line);
        if !line.ends_with(b"\n") {
            self.whole.push(b'\n');
        }
        self.lines += 1;
    }

    fn include(&mut self, keyword: &[u8], name: &str, at: FilePosition) -> Result<(), MeshError> {
        let fail = |problem| Err(FileError { at, problem }.into());
        let Some(find) = self.includes else {
            let keyword = if is_include(keyword) { "INCLUDE".into() } else { name_of(keyword) };
            return fail(FileProblem::Keyword { keyword, reason: "it takes lines from another file" });
        };
        let refused = |reason: String| FileProblem::Included { name: name.into(), reason };
        let path = match find(name) {
            Ok(path) => path,
            Err(reason) => return fail(refused(reason)),
        };
        if self.chain.contains(&path) {
            return fail(refused("it includes itself".into()));
        }
        if self.chain.len() >= DEEPEST || self.origins.files.len() >= MOST {
            return fail(refused(format!("at most {DEEPEST} files include each other in a chain, and {MOST} in all")));
        }
        match files::read(&path) {
            Ok(content) => {
                let file = self.origins.files.len();
                self.origins.files.push(path.clone());
                self.chain.push(path);
                self.add(&content, Some(file))?;
                self.chain.pop();
                Ok(())
            }
            Err(error) => fail(refused(error.to_string())),
        }
    }
}

fn name_of(keyword: &[u8]) -> String {
    let name = keyword.split(|&byte| byte == b',').next().unwrap_or_default();
    String::from_utf8_lossy(name).trim_start_matches('*').trim().to_ascii_uppercase()
}

fn is_include(keyword: &[u8]) -> bool {
    name_of(keyword) == "INCLUDE"
}

/// The value of the parameter `INPUT` of keywords whose lines may come from another file; `INCLUDE` may have `FILE` in its place.
fn input_of(keyword: &[u8]) -> Option<String> {
    if !matches!(&*name_of(keyword), "INCLUDE" | "NODE" | "ELEMENT" | "NSET" | "ELSET") {
        return None;
    }
    String::from_utf8_lossy(keyword).split(',').skip(1).find_map(|field| {
        let (name, value) = field.split_once('=')?;
        let is_file = |name: &str| name.eq_ignore_ascii_case("input") || name.eq_ignore_ascii_case("file") && is_include(keyword);
        is_file(name.trim()).then(|| value.trim().trim_matches('"').to_string())
    })
}

/// Finds included files below the folder of the file that includes them.
pub fn below_folder_of(path: &Path) -> impl Fn(&str) -> Result<PathBuf, String> + use<> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    move |name| {
        let real = |path: &Path| path.canonicalize().map_err(|error| error.to_string());
        let (folder, file) = (real(&folder)?, real(&folder.join(name))?);
        if file.starts_with(&folder) { Ok(file) } else { Err("it is not below the folder of the file that includes it".into()) }
    }
}
