//! Source files split into tokens: place of each token, code that is compiled for tests only, and the list of files.

use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Source file as tokens.
pub struct Source {
    /// Path from the repository, with slashes.
    pub path: String,
    pub text: String,
    pub tokens: Vec<Token>,
}

/// Token with its line; `::` is one token. The text of a literal is empty, so that strings may name anything.
#[derive(Clone)]
pub struct Token {
    pub text: String,
    pub literal: String,
    pub line: usize,
}

impl Source {
    pub fn new(path: &str, text: &str) -> Source {
        let stream: TokenStream = text.parse().unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut tokens = Vec::new();
        flatten_into(stream, &mut tokens);
        Source { path: path.into(), text: text.into(), tokens }
    }

    /// Modules from the root of the crate down to this file.
    pub fn module_path(&self) -> Vec<&str> {
        let inner = self.path.trim_start_matches("src/").trim_end_matches(".rs");
        inner.split('/').filter(|part| *part != "mod" && *part != "lib").collect()
    }

    /// Module of `lib.rs` that the file belongs to; `main` and `lib` for themselves.
    pub fn floor_module(&self) -> &str {
        self.module_path().first().copied().unwrap_or("lib")
    }

    pub fn text_at(&self, index: usize) -> &str {
        self.tokens.get(index).map_or("", |token| &token.text)
    }

    pub fn at(&self, index: usize) -> String {
        format!("{}:{}", self.path, self.tokens[index].line)
    }

    /// Index of the bracket that closes the one at `index`; the end without one.
    pub fn closing(&self, index: usize) -> usize {
        let mut depth = 0;
        for place in index..self.tokens.len() {
            match self.text_at(place) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                return place;
            }
        }
        self.tokens.len()
    }

    /// Token ranges of items that are compiled for tests only: from the attribute `#[cfg(test)]` on.
    fn test_items(&self) -> Vec<std::ops::Range<usize>> {
        let mut items = Vec::new();
        let mut index = 0;
        while index < self.tokens.len() {
            let attribute = ["#", "[", "cfg", "(", "test", ")", "]"];
            if !attribute.iter().enumerate().all(|(offset, text)| self.text_at(index + offset) == *text) {
                index += 1;
                continue;
            }
            let start = index;
            index += attribute.len();
            while index < self.tokens.len() {
                match self.text_at(index) {
                    ";" => break,
                    "{" => {
                        index = self.closing(index);
                        break;
                    }
                    "(" | "[" => index = self.closing(index) + 1,
                    _ => index += 1,
                }
            }
            index += 1;
            items.push(start..index.min(self.tokens.len()));
        }
        items
    }

    /// The file without its tests, and the number of lines left out.
    pub fn without_tests(&self) -> (Source, usize) {
        let items = self.test_items();
        let lines = items.iter().map(|item| self.tokens[item.end - 1].line - self.tokens[item.start].line + 1).sum();
        let kept = (0..self.tokens.len()).filter(|index| !items.iter().any(|item| item.contains(index)));
        let tokens = kept.map(|index| self.tokens[index].clone()).collect();
        (Source { path: self.path.clone(), text: self.text.clone(), tokens }, lines)
    }

    /// Modules in files of their own that are compiled for tests only.
    fn test_modules(&self) -> Vec<String> {
        let declared = |item: std::ops::Range<usize>| {
            let place = item.clone().find(|&index| self.text_at(index) == "mod")?;
            (self.text_at(place + 2) == ";").then(|| self.text_at(place + 1).to_string())
        };
        self.test_items().into_iter().filter_map(declared).collect()
    }
}

/// The files of the program without their tests.
pub fn program(sources: &[Source]) -> Vec<Source> {
    let mut tests: Vec<Vec<String>> = Vec::new();
    for source in sources {
        let own: Vec<String> = source.module_path().into_iter().map(String::from).collect();
        tests.extend(source.test_modules().into_iter().map(|module| [own.clone(), vec![module]].concat()));
    }
    let is_test =
        |source: &Source| tests.iter().any(|test| source.module_path().starts_with(&test.iter().map(String::as_str).collect::<Vec<_>>()));
    sources.iter().filter(|source| !is_test(source)).map(|source| source.without_tests().0).collect()
}

fn flatten_into(stream: TokenStream, tokens: &mut Vec<Token>) {
    for tree in stream {
        let line = tree.span().start().line;
        let after_colon = tokens.last().is_some_and(|last: &Token| last.text == ": ");
        let mut push = |text: String| tokens.push(Token { text, literal: String::new(), line });
        match tree {
            TokenTree::Ident(ident) => push(ident.to_string().trim_start_matches("r#").into()),
            TokenTree::Literal(literal) => tokens.push(Token { text: String::new(), literal: literal.to_string(), line }),
            TokenTree::Punct(punct) => match (punct.as_char(), punct.spacing()) {
                (':', _) if after_colon => {
                    tokens.pop();
                    tokens.push(Token { text: "::".into(), literal: String::new(), line });
                }
                // two colons are one token
                (':', Spacing::Joint) => push(": ".into()),
                (other, _) => push(other.into()),
            },
            TokenTree::Group(group) => {
                let [open, close] = match group.delimiter() {
                    Delimiter::Parenthesis => ["(", ")"],
                    Delimiter::Brace => ["{", "}"],
                    Delimiter::Bracket => ["[", "]"],
                    Delimiter::None => ["", ""],
                };
                push(open.into());
                flatten_into(group.stream(), tokens);
                tokens.push(Token { text: close.into(), literal: String::new(), line: group.span_close().start().line });
            }
        }
    }
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let inner = |path: PathBuf| if path.is_dir() { rust_files(&path) } else { vec![path] };
    paths.into_iter().flat_map(inner).filter(|path| path.extension().is_some_and(|e| e == "rs")).collect()
}

pub fn sources(folders: &[&str]) -> Vec<Source> {
    let files = folders.iter().flat_map(|folder| rust_files(&repository().join(folder)));
    files
        .map(|file| {
            let path = file.strip_prefix(repository()).unwrap().to_string_lossy().replace('\\', "/");
            Source::new(&path, &std::fs::read_to_string(&file).unwrap())
        })
        .collect()
}
