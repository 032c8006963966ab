//! Declarations of a script text and their uses, found without the engine, so that incomplete text can be analyzed.
//!
//! Rules of the language: a variable is visible from the end of its statement to the end of its block; a function has access to its
//! parameters only, a closure also to the surrounding variables; functions are visible everywhere, constants of the script in functions as
//! `global::NAME`.

use std::ops::Range;

use super::completion::KEYWORDS;
use super::cursor::{TextToken, TextTokenKind, pieces_with_interpolations};

/// Kind of a declared name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// `let` and `const`.
    Variable,
    /// Parameter of a function or closure, variable of a loop or of `catch`.
    Parameter,
    /// `fn`.
    Function,
    /// `import … as`.
    Module,
}

/// Declaration of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declaration {
    /// Declared name.
    pub name: String,
    /// Kind of the name.
    pub role: Role,
    /// Bytes of the name.
    pub range: Range<usize>,
    /// Bytes in which the name is visible.
    pub visible: Range<usize>,
    /// Bytes of the value after `=`, of the path after `import`, or of the parameters of a function.
    pub value: Range<usize>,
    /// True outside of all blocks, functions and closures.
    pub is_global: bool,
}

/// Declarations of a text and their uses.
#[derive(Clone, Debug, Default)]
pub struct Declarations {
    /// Declarations in the order of the text.
    pub all: Vec<Declaration>,
    /// Byte range of each use of a name, and the index of its declaration.
    pub uses: Vec<(Range<usize>, usize)>,
    /// Byte ranges of called names without a declaration in the text.
    pub unknown_calls: Vec<Range<usize>>,
    /// Byte ranges of the bodies of functions.
    bodies: Vec<Range<usize>>,
}

impl Declarations {
    /// Finds the declarations of a script text and the uses of each.
    pub fn of(text: &str) -> Self {
        let mut pieces = pieces_with_interpolations(text);
        pieces.retain(|piece| !matches!(piece.kind, TextTokenKind::Comment { .. }));
        let mut reader =
            Reader { text, pieces, found: Declarations::default(), scopes: vec![Scope::default()], depth: 0, pending: Vec::new() };
        let mut calls = Vec::new();
        let mut index = 0;
        while index < reader.pieces.len() {
            index = reader.read(index, &mut calls);
        }
        reader.end_scopes(0, text.len());
        let mut found = reader.found;
        for range in calls {
            match found.all.iter().position(|declaration| declaration.role == Role::Function && declaration.name == text[range.clone()]) {
                Some(function) => found.uses.push((range, function)),
                None => found.unknown_calls.push(range),
            }
        }
        found.uses.sort_by_key(|(range, _)| range.start);
        found
    }

    /// Index of the declaration whose name, or a use of it, includes a byte.
    pub fn at(&self, byte: usize) -> Option<usize> {
        let is_here = |range: &Range<usize>| range.start <= byte && byte <= range.end;
        let declared = self.all.iter().position(|declaration| is_here(&declaration.range));
        declared.or_else(|| self.uses.iter().find(|(range, _)| is_here(range)).map(|(_, number)| *number))
    }

    /// Bytes of a declared name and its uses. Functions of one name with different numbers of parameters belong together.
    pub fn occurrences(&self, number: usize) -> Vec<Range<usize>> {
        let Some(wanted) = self.all.get(number) else { return Vec::new() };
        let is_same = |other: usize| {
            let other = &self.all[other];
            other.range == wanted.range || wanted.role == Role::Function && other.role == Role::Function && other.name == wanted.name
        };
        let declared = (0..self.all.len()).filter(|other| is_same(*other)).map(|other| self.all[other].range.clone());
        let used = self.uses.iter().filter(|(_, other)| is_same(*other)).map(|(range, _)| range.clone());
        let mut all: Vec<Range<usize>> = declared.chain(used).collect();
        all.sort_by_key(|range| range.start);
        all
    }

    /// Declarations that are visible at a byte, the innermost last.
    pub fn visible(&self, byte: usize) -> impl Iterator<Item = &Declaration> {
        let body = self.body(byte);
        self.all.iter().filter(move |declaration| match declaration.role {
            Role::Function => true,
            Role::Module => declaration.visible.contains(&byte) || declaration.visible.end == byte,
            Role::Variable | Role::Parameter => {
                declaration.visible.start <= byte && byte <= declaration.visible.end && self.body(declaration.visible.start) == body
            }
        })
    }

    /// Declaration to which a name refers at a byte.
    pub fn meaning(&self, name: &str, byte: usize) -> Option<&Declaration> {
        let named = || self.visible(byte).filter(|declaration| declaration.name == name);
        named().filter(|declaration| declaration.role != Role::Function).last().or_else(|| named().last())
    }

    /// Body of the function around a byte.
    fn body(&self, byte: usize) -> Option<usize> {
        self.bodies.iter().position(|body| body.start < byte && byte <= body.end)
    }
}

/// Bytes in which names are visible.
#[derive(Default)]
struct Scope {
    /// Number of open brackets outside of the scope.
    depth: usize,
    /// True for a closure without braces, which a comma or a closing bracket ends.
    is_expression: bool,
    /// True if names outside are not visible.
    is_function: bool,
    names: Vec<usize>,
    /// Declaration whose statement is not complete.
    begun: Option<usize>,
}

struct Reader<'a> {
    text: &'a str,
    pieces: Vec<TextToken>,
    found: Declarations,
    scopes: Vec<Scope>,
    /// Open brackets.
    depth: usize,
    /// Scopes to be opened by the next brace at a depth.
    pending: Vec<Scope>,
}

impl Reader<'_> {
    fn kind(&self, index: usize) -> Option<TextTokenKind> {
        self.pieces.get(index).map(|piece| piece.kind)
    }

    fn range(&self, index: usize) -> Range<usize> {
        self.pieces.get(index).map_or(self.text.len()..self.text.len(), |piece| piece.range.clone())
    }

    fn word(&self, index: usize) -> &str {
        &self.text[self.range(index)]
    }

    fn is(&self, index: usize, kind: TextTokenKind) -> bool {
        self.kind(index) == Some(kind)
    }

    fn is_name(&self, index: usize) -> bool {
        self.is(index, TextTokenKind::Name) && !KEYWORDS.contains(&self.word(index))
    }

    /// Reads the token at an index; returns the index of the next one.
    fn read(&mut self, index: usize, calls: &mut Vec<Range<usize>>) -> usize {
        let Some(kind) = self.kind(index) else { return index + 1 };
        match kind {
            TextTokenKind::Open(bracket) => self.open(index, bracket),
            TextTokenKind::Close(_) => {
                self.depth = self.depth.saturating_sub(1);
                self.end_scopes(self.depth + 1, self.range(index).start);
            }
            TextTokenKind::Sign(',' | ';') => {
                let end = self.range(index).start;
                self.end_expressions(end);
                if kind == TextTokenKind::Sign(';') {
                    self.end_statement(end);
                }
            }
            TextTokenKind::Sign('|') => return self.bar(index),
            TextTokenKind::Name => return self.name(index, calls),
            // A function pointer `Fn("name")` uses the function of that name.
            TextTokenKind::Text { closed: true }
                if index > 1 && self.is(index - 1, TextTokenKind::Open('(')) && self.word(index - 2) == "Fn" =>
            {
                let range = self.range(index);
                calls.push(range.start + 1..range.end.saturating_sub(1).max(range.start + 1));
            }
            _ => {}
        }
        index + 1
    }

    fn open(&mut self, index: usize, bracket: char) {
        if bracket == '{' {
            let scope = match self.pending.last() {
                Some(scope) if scope.depth == self.depth => self.pending.pop(),
                _ => None,
            };
            let scope = scope.unwrap_or(Scope { depth: self.depth, ..Scope::default() });
            let start = self.range(index).start;
            if scope.is_function {
                self.found.bodies.push(start..self.text.len());
            }
            for &number in &scope.names {
                self.found.all[number].visible.start = start + 1;
            }
            self.scopes.push(scope);
        }
        self.depth += 1;
    }

    /// Ends the scopes that contain at least `depth` open brackets.
    fn end_scopes(&mut self, depth: usize, end: usize) {
        self.pending.retain(|scope| scope.depth < depth);
        while self.scopes.len() > 1 && self.scopes.last().is_some_and(|scope| scope.depth + usize::from(!scope.is_expression) >= depth) {
            self.end_scope(end);
        }
        if depth == 0 {
            self.end_scope(end);
        }
    }

    fn end_scope(&mut self, end: usize) {
        let Some(scope) = self.scopes.pop() else { return };
        for number in scope.names.into_iter().chain(scope.begun) {
            let visible = &mut self.found.all[number].visible;
            visible.end = end.max(visible.start);
        }
        if let Some(number) = scope.begun {
            let value = &mut self.found.all[number].value;
            value.end = end.max(value.start);
        }
        if scope.is_function
            && let Some(body) = self.found.bodies.last_mut()
        {
            body.end = end;
        }
    }

    /// Ends closures without braces.
    fn end_expressions(&mut self, end: usize) {
        while self.scopes.last().is_some_and(|scope| scope.is_expression && scope.depth == self.depth) {
            self.end_scope(end);
        }
    }

    /// Makes the variable of a complete statement visible.
    fn end_statement(&mut self, end: usize) {
        let Some(scope) = self.scopes.last_mut() else { return };
        if let Some(number) = scope.begun.take() {
            let declaration = &mut self.found.all[number];
            declaration.visible.start = end;
            declaration.value.end = end.max(declaration.value.start);
            scope.names.push(number);
        }
    }

    fn declare(&mut self, index: usize, role: Role, value: Range<usize>) -> usize {
        let range = self.range(index);
        let is_global = role != Role::Parameter && self.scopes.len() == 1 && self.depth == 0;
        let visible = range.end..self.text.len();
        self.found.all.push(Declaration { name: self.word(index).into(), role, range, visible, value, is_global });
        self.found.all.len() - 1
    }

    /// Reads the names of a list up to a closing token; returns their declarations and the index behind.
    fn parameters(&mut self, mut index: usize, close: TextTokenKind) -> (Vec<usize>, usize) {
        let mut names = Vec::new();
        while let Some(kind) = self.kind(index) {
            match kind {
                _ if kind == close => return (names, index + 1),
                TextTokenKind::Name if self.is_name(index) => {
                    let end = self.range(index).end;
                    names.push(self.declare(index, Role::Parameter, end..end));
                }
                TextTokenKind::Sign(',') => {}
                _ => break,
            }
            index += 1;
        }
        (names, index)
    }

    /// Reads `|`: the parameters of a closure, or an operator.
    fn bar(&mut self, index: usize) -> usize {
        let is_operand = |before: usize| match self.kind(before) {
            Some(TextTokenKind::Name) => !matches!(self.word(before), "return" | "in" | "if" | "while" | "throw" | "else"),
            Some(TextTokenKind::Number | TextTokenKind::Text { .. } | TextTokenKind::Close(_)) => true,
            _ => false,
        };
        if index.checked_sub(1).is_some_and(is_operand) {
            // `||` is one operator.
            return index + 1 + usize::from(self.is(index + 1, TextTokenKind::Sign('|')));
        }
        let (names, next) = self.parameters(index + 1, TextTokenKind::Sign('|'));
        let is_block = self.is(next, TextTokenKind::Open('{'));
        let scope = Scope { depth: self.depth, is_expression: !is_block, names, ..Scope::default() };
        if is_block {
            self.pending.push(scope)
        } else {
            self.scopes.push(scope)
        }
        next
    }

    fn name(&mut self, index: usize, calls: &mut Vec<Range<usize>>) -> usize {
        let before = index.checked_sub(1).and_then(|before| self.kind(before));
        if matches!(before, Some(TextTokenKind::Dot)) {
            if self.is(index + 1, TextTokenKind::Open('(')) {
                calls.push(self.range(index));
            }
            return index + 1;
        }
        match self.word(index) {
            "let" | "const" => self.variable(index),
            "fn" => self.function(index),
            "for" => self.head(index, index + 1),
            "catch" => self.head(index, index + 1),
            "import" if self.word(index + 2) == "as" && self.is_name(index + 3) => {
                let path = self.range(index + 1);
                let number = self.declare(index + 3, Role::Module, path);
                self.enter(number);
                index + 4
            }
            word if KEYWORDS.contains(&word) => index + 1,
            _ => {
                self.used(index, before, calls);
                index + 1
            }
        }
    }

    fn enter(&mut self, number: usize) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.names.push(number);
        }
    }

    /// Reads `let name` or `const name`.
    fn variable(&mut self, index: usize) -> usize {
        // A statement without a semicolon ends here.
        self.end_statement(self.range(index).start);
        if !self.is_name(index + 1) {
            return index + 1;
        }
        let value = self.range(index + 2).end..self.text.len();
        let number = self.declare(index + 1, Role::Variable, value);
        if let Some(scope) = self.scopes.last_mut() {
            scope.begun = Some(number);
        }
        index + 2
    }

    /// Reads `fn name(…)`.
    fn function(&mut self, index: usize) -> usize {
        self.end_statement(self.range(index).start);
        if !self.is_name(index + 1) || !self.is(index + 2, TextTokenKind::Open('(')) {
            return index + 1;
        }
        let number = self.declare(index + 1, Role::Function, 0..0);
        let (names, next) = self.parameters(index + 3, TextTokenKind::Close(')'));
        let start = self.range(index + 2).start;
        self.found.all[number].value = start..self.range(next.saturating_sub(1)).end.max(start);
        self.found.all[number].visible = 0..self.text.len();
        self.pending.push(Scope { depth: self.depth, is_function: true, names, ..Scope::default() });
        next
    }

    /// Reads the variables of `for x in`, `for (x, i) in` or `catch (error)`, which are visible in the next block.
    fn head(&mut self, index: usize, first: usize) -> usize {
        let (names, next) = match self.is(first, TextTokenKind::Open('(')) {
            true => self.parameters(first + 1, TextTokenKind::Close(')')),
            false if self.is_name(first) => {
                let end = self.range(first).end;
                (vec![self.declare(first, Role::Parameter, end..end)], first + 1)
            }
            false => return index + 1,
        };
        self.pending.push(Scope { depth: self.depth, names, ..Scope::default() });
        next
    }

    /// Records the use of a name, unless it is the key of a map.
    fn used(&mut self, index: usize, before: Option<TextTokenKind>, calls: &mut Vec<Range<usize>>) {
        let follows = self.kind(index + 1);
        let is_key =
            matches!(before, Some(TextTokenKind::Open('#') | TextTokenKind::Sign(','))) && follows == Some(TextTokenKind::Sign(':'));
        if is_key {
            return;
        }
        let (name, range) = (self.word(index).to_string(), self.range(index));
        if before == Some(TextTokenKind::Path) {
            let is_constant = index >= 2 && self.word(index - 2) == "global";
            let constant = self.found.all.iter().rposition(|of| of.role == Role::Variable && of.is_global && of.name == name);
            self.found.uses.extend(constant.filter(|_| is_constant).map(|number| (range, number)));
            return;
        }
        let wanted = |number: &usize| {
            let of = &self.found.all[*number];
            of.name == name && (of.role == Role::Module) == (follows == Some(TextTokenKind::Path))
        };
        let mut is_outside = false;
        for scope in self.scopes.iter().rev() {
            let visible = |number: &usize| !is_outside || self.found.all[*number].role == Role::Module;
            if let Some(number) = scope.names.iter().rev().copied().find(|number| wanted(number) && visible(number)) {
                // A call refers to a function, not to a variable of the same name.
                if follows != Some(TextTokenKind::Open('(')) {
                    self.found.uses.push((range, number));
                    return;
                }
            }
            is_outside |= scope.is_function;
        }
        match follows {
            Some(TextTokenKind::Open('(')) => calls.push(range),
            Some(TextTokenKind::Path) => {}
            _ => {
                let function = self.found.all.iter().position(|of| of.role == Role::Function && of.name == name);
                self.found.uses.extend(function.map(|number| (range, number)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines (from 1) of the declared name at the first occurrence of a text, and of all its uses.
    fn lines(text: &str, at: &str) -> Vec<usize> {
        let found = Declarations::of(text);
        let number = found.at(text.find(at).unwrap()).unwrap_or_else(|| panic!("{at} is not declared"));
        found.occurrences(number).iter().map(|range| text[..range.start].matches('\n').count() + 1).collect()
    }

    #[test]
    fn variables_hide_each_other_in_blocks() {
        let text = "let a = 1;\nlet b = a;\nif b > a {\n  let a = a + 1;\n  print(a);\n}\nprint(`a ${a + `${a}`}`);\nlet a = a;\na;";
        assert_eq!(lines(text, "a = 1"), [1, 2, 3, 4, 7, 7, 8]);
        assert_eq!(lines(text, "a = a + 1"), [4, 5]);
        assert_eq!(lines(text, "a = a;\na;"), [8, 9]);
    }

    #[test]
    fn functions_see_their_parameters_and_closures_what_is_around() {
        let text = "let k = 2;\nconst C = 3;\nfn f(k) {\n k + global::C\n}\nlet g = |x| k * f(x);\n\
            let h = |x, y| {\n let k = x;\n k + y };\nk.f();\nFn(\"f\")";
        assert_eq!(lines(text, "k = 2"), [1, 6, 10]);
        assert_eq!(lines(text, "k) {"), [3, 4]);
        assert_eq!(lines(text, "C = 3"), [2, 4]);
        assert_eq!(lines(text, "f(k)"), [3, 6, 10, 11]);
        assert_eq!(lines(text, "x| k"), [6, 6]);
        assert_eq!(lines(text, "k = x"), [8, 9]);
    }

    #[test]
    fn keys_members_and_loops_are_told_apart() {
        let text = "let size = 1;\nlet m = #{ size: size, other: m2.size };\nfor (x, i) in m.map(|size| { size }) {\n x + i || size }\nx";
        assert_eq!(lines(text, "size = 1"), [1, 2, 4]);
        assert_eq!(lines(text, "x, i"), [3, 4]);
        let found = Declarations::of("import \"lib/a\" as a;\nlet a2 = a::f(1);\nfn g() { a::f(nothing(2)) }");
        assert_eq!(found.occurrences(0).len(), 3);
        assert_eq!(found.unknown_calls.len(), 1);
    }

    #[test]
    fn unfinished_text_is_read() {
        for text in
            ["let", "fn f(", "for (", "|", "|a", "`${", "`${`${", "let a = |x| {", "}}}", "catch (", "import \"a", "é'\\", "global::"]
        {
            let found = Declarations::of(text);
            assert!(found.all.iter().all(|of| of.visible.start <= of.visible.end && of.value.start <= of.value.end), "{text}");
        }
        let text = "fn f(model) {\n let part = ";
        let found = Declarations::of(text);
        assert!(found.visible(text.len()).any(|of| of.name == "model"));
    }
}
