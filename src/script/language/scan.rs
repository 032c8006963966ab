//! Finds places in the text of a script: an argument, a key of an options map, the extent of a word.
//!
//! Run-time errors of the engine have at most the start of a call. From there, the text is scanned again with the tokens of the language,
//! so that a message can point at a key or value.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

use rhai::{Engine, Token};

use super::sources::Offsets;

/// A token and its range of bytes.
#[derive(Clone, Debug)]
pub struct Lexeme {
    /// Token of the language.
    pub token: Token,
    /// Byte range of the token in the text.
    pub range: Range<usize>,
}

/// Part of a call at which a message points.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// The name of the called function.
    #[default]
    Call,
    /// The argument with this index (from 0), without the object in front of the dot.
    Argument(usize),
    /// A key of an options map.
    Key {
        /// Number of the argument that is the map.
        argument: usize,
        /// Name of the key.
        key: String,
        /// True for the value of the key, false for the key itself.
        value: bool,
    },
}

/// A text with its tokens.
type Read = (Arc<str>, Rc<[Lexeme]>);

thread_local! {
    /// Last text, with its tokens.
    static LAST: RefCell<Option<Read>> = const { RefCell::new(None) };
}

/// Returns all tokens of the text of a source, as [`lexemes`]; those of the last text are cached, because checks in a loop use one text
/// repeatedly.
pub fn lexemes_of_source(engine: &Engine, text: &Arc<str>) -> Rc<[Lexeme]> {
    let known = LAST.with_borrow(|last| last.as_ref().filter(|(known, _)| Arc::ptr_eq(known, text)).map(|(_, lexemes)| lexemes.clone()));
    known.unwrap_or_else(|| {
        let lexemes: Rc<[Lexeme]> = lexemes(engine, text).into();
        LAST.set(Some((text.clone(), lexemes.clone())));
        lexemes
    })
}

/// Returns all tokens of a text, up to the first invalid one.
pub fn lexemes(engine: &Engine, text: &str) -> Vec<Lexeme> {
    let texts = [text];
    let (tokens, control) = engine.lex(&texts);
    let mut found: Vec<Lexeme> = Vec::new();
    let mut braces: Vec<usize> = Vec::new();
    let mut offsets = Offsets::new(text);
    for (token, position) in tokens {
        if matches!(token, Token::EOF | Token::LexError(_)) {
            break;
        }
        // The empty part at the end of an interpolated string has no position: it follows the bracket before it.
        let behind = found.last().map_or(0, |last| last.range.start + 1);
        let start = offsets.of(position).unwrap_or(behind);
        match token {
            Token::InterpolatedString(_) => braces.push(0),
            Token::LeftBrace | Token::MapStart => braces.iter_mut().for_each(|depth| *depth += 1),
            Token::RightBrace => {
                braces.iter_mut().for_each(|depth| *depth = depth.saturating_sub(1));
                if braces.last() == Some(&0) {
                    braces.pop();
                    control.borrow_mut().is_within_text = true;
                }
            }
            _ => {}
        }
        found.push(Lexeme { token, range: start..start });
    }
    let ends: Vec<usize> = found.iter().skip(1).map(|lexeme| lexeme.range.start).chain([text.len()]).collect();
    for (lexeme, end) in found.iter_mut().zip(ends) {
        let start = lexeme.range.start;
        let mut covered = text.get(start..end).unwrap_or("");
        if !matches!(lexeme.token, Token::StringConstant(_) | Token::InterpolatedString(_)) {
            let comment = [covered.find("//"), covered.find("/*")].into_iter().flatten().min();
            covered = &covered[..comment.unwrap_or(covered.len())];
        }
        lexeme.range.end = start + covered.trim_end().len();
    }
    found
}

/// Returns the bytes of the token that begins at `start`, or of one character if there is none.
pub fn word(lexemes: &[Lexeme], text: &str, start: usize) -> Range<usize> {
    match lexemes.iter().find(|lexeme| lexeme.range.start == start && !lexeme.range.is_empty()) {
        Some(lexeme) => lexeme.range.clone(),
        None => start..start + text[start..].chars().next().filter(|c| *c != '\n').map_or(0, char::len_utf8),
    }
}

/// Returns the start of a property's name, for the position of the dot in front.
pub fn name_after_dot(lexemes: &[Lexeme], start: usize) -> usize {
    let dot = lexemes.windows(2).find(|pair| pair[0].range.start == start && matches!(pair[0].token, Token::Period | Token::Elvis));
    dot.map_or(start, |pair| pair[1].range.start)
}

/// Index of the token after a bracket that opens at `start`.
pub fn behind_bracket(lexemes: &[Lexeme], start: usize) -> Option<Range<usize>> {
    let opens = |lexeme: &Lexeme| matches!(lexeme.token, Token::LeftBracket | Token::QuestionBracket);
    lexemes.windows(2).find(|pair| pair[0].range.start == start && opens(&pair[0])).map(|pair| pair[1].range.clone())
}

/// True if the value of `.name` or `[index]` at `start` is indexed immediately: `[` follows.
pub fn is_indexed(lexemes: &[Lexeme], start: usize) -> bool {
    let Some(begin) = lexemes.iter().position(|lexeme| lexeme.range.start == start) else { return false };
    let opens = |token: &Token| matches!(token, Token::LeftBracket | Token::QuestionBracket);
    let end = match &lexemes[begin].token {
        Token::Period | Token::Elvis => begin + 1,
        token if opens(token) => {
            let mut depth = 0usize;
            let closes = |lexeme: &Lexeme| {
                depth += usize::from(opens(&lexeme.token));
                depth -= usize::from(matches!(lexeme.token, Token::RightBracket));
                depth == 0
            };
            begin + lexemes[begin..].iter().position(closes).unwrap_or(lexemes.len())
        }
        _ => return false,
    };
    lexemes.get(end + 1).is_some_and(|next| opens(&next.token))
}

/// The end of the token before `start`.
pub fn end_before(lexemes: &[Lexeme], start: usize) -> Option<Range<usize>> {
    let last = lexemes.iter().rev().find(|lexeme| lexeme.range.start < start && !lexeme.range.is_empty())?;
    Some(last.range.clone())
}

/// Returns the name of the single method call `object.method(…)` whose arguments use `object` itself; `None` if there are none or several.
pub fn self_use(lexemes: &[Lexeme], method: &str) -> Option<Range<usize>> {
    let is = |index: usize, name: &str| matches!(&lexemes[index].token, Token::Identifier(found) if found.as_str() == name);
    let mut found = (2..lexemes.len()).filter(|&index| {
        let Token::Identifier(object) = &lexemes[index - 2].token else { return false };
        is(index, method)
            && matches!(lexemes[index - 1].token, Token::Period)
            && lexemes.get(index + 1).is_some_and(|next| matches!(next.token, Token::LeftParen))
            && elements(lexemes, index + 1).into_iter().flatten().any(|inside| is(inside, object))
    });
    let only = found.next()?;
    found.next().is_none().then(|| lexemes[only].range.clone())
}

/// Returns the bytes of a call's argument or key, for the call whose name (or property) begins at `start`.
///
/// With `method`, the object of the function is not counted among the arguments; a call of the form `f(object, …)` is recognized.
pub fn locate(lexemes: &[Lexeme], start: usize, target: &Target, method: bool) -> Option<Range<usize>> {
    let name = lexemes.iter().position(|lexeme| lexeme.range.start == start)?;
    let (index, key) = match target {
        Target::Call => return Some(lexemes[name].range.clone()),
        Target::Argument(index) => (*index, None),
        Target::Key { argument, key, value } => (*argument, Some((key, *value))),
    };
    if !matches!(lexemes.get(name + 1)?.token, Token::LeftParen) {
        return None;
    }
    let after_dot = name > 0 && matches!(lexemes[name - 1].token, Token::Period | Token::Elvis);
    let index = index + usize::from(method && !after_dot);
    let arguments = elements(lexemes, name + 1);
    let argument = arguments.get(index)?;
    let Some((key, value)) = key else { return covered(lexemes, argument) };
    if !matches!(lexemes.get(argument.start)?.token, Token::MapStart) {
        return covered(lexemes, argument);
    }
    let entry = elements(lexemes, argument.start).into_iter().find(|entry| match &lexemes[entry.start].token {
        Token::Identifier(found) => found.as_str() == key.as_str(),
        Token::StringConstant(found) => found.as_str() == key.as_str(),
        _ => false,
    })?;
    if value { covered(lexemes, &(entry.start + 2..entry.end)) } else { Some(lexemes[entry.start].range.clone()) }
}

/// Divisions of two integer literals that leave a remainder: their bytes and the two numbers.
pub fn truncating_divisions(lexemes: &[Lexeme]) -> Vec<(Range<usize>, i64, i64)> {
    let mut found = Vec::new();
    for (index, window) in lexemes.windows(3).enumerate() {
        let (Token::IntegerConstant(a), Token::Divide, Token::IntegerConstant(b)) = (&window[0].token, &window[1].token, &window[2].token)
        else {
            continue;
        };
        let binds_left = index > 0
            && matches!(lexemes[index - 1].token, Token::Multiply | Token::Divide | Token::Modulo | Token::PowerOf | Token::Period);
        let binds_right = lexemes.get(index + 3).is_some_and(|next| matches!(next.token, Token::PowerOf | Token::Period));
        if !binds_left && !binds_right && a.checked_rem(*b).is_some_and(|rest| rest != 0) {
            found.push((window[0].range.start..window[2].range.end, *a, *b));
        }
    }
    found
}

/// Exclusive ors of two integer literals, which were probably meant as powers: their bytes and the two numbers.
pub fn exclusive_ors(lexemes: &[Lexeme]) -> Vec<(Range<usize>, i64, i64)> {
    let found = |window: &[Lexeme]| match (&window[0].token, &window[1].token, &window[2].token) {
        (Token::IntegerConstant(a), Token::XOr, Token::IntegerConstant(b)) => Some((window[0].range.start..window[2].range.end, *a, *b)),
        _ => None,
    };
    lexemes.windows(3).filter_map(found).collect()
}

/// Returns the bytes of each `param` in a text, with the name of the parameter if it is a literal.
pub fn asked_parameters(lexemes: &[Lexeme]) -> Vec<(Range<usize>, Option<String>)> {
    let called = |window: &[Lexeme]| match (&window[0].token, &window[1].token, &window[2].token) {
        (Token::Identifier(name), Token::LeftParen, argument) if name.as_str() == "param" => match argument {
            Token::StringConstant(name) => Some((window[0].range.clone(), Some(name.to_string()))),
            _ => Some((window[0].range.clone(), None)),
        },
        _ => None,
    };
    lexemes.windows(3).filter_map(called).collect()
}

/// Returns the paths of the imports of a text; `None` for a computed path.
pub fn imports(lexemes: &[Lexeme]) -> Vec<Option<String>> {
    let path = |pair: &[Lexeme]| match (&pair[0].token, &pair[1].token) {
        (Token::Import, Token::StringConstant(path)) => Some(Some(path.to_string())),
        (Token::Import, _) => Some(None),
        _ => None,
    };
    lexemes.windows(2).filter_map(path).collect()
}

/// Returns the functions defined in a text, each with its first byte.
pub fn functions(lexemes: &[Lexeme]) -> Vec<(String, usize)> {
    let name = |pair: &[Lexeme]| match (&pair[0].token, &pair[1].token) {
        (Token::Fn, Token::Identifier(name)) => Some((name.to_string(), pair[0].range.start)),
        _ => None,
    };
    lexemes.windows(2).filter_map(name).collect()
}

/// Returns a loop in a function, or in a function called by it, in which the function may run endlessly.
pub fn loop_in(lexemes: &[Lexeme], function: &str) -> Option<Range<usize>> {
    let mut waiting = vec![function.to_string()];
    let mut seen: Vec<String> = Vec::new();
    while let Some(name) = waiting.pop() {
        if seen.contains(&name) {
            continue;
        }
        let is_it = |pair: &[Lexeme]| matches!((&pair[0].token, &pair[1].token), (Token::Fn, Token::Identifier(found)) if **found == *name);
        let Some(start) = lexemes.windows(2).position(is_it) else { continue };
        let body = &lexemes[start + 2..];
        let end = body.iter().position(|lexeme| matches!(lexeme.token, Token::Fn)).unwrap_or(body.len());
        if let Some(found) = body[..end].iter().find(|lexeme| matches!(lexeme.token, Token::Loop | Token::While | Token::Do)) {
            return Some(found.range.clone());
        }
        waiting.extend(body[..end].iter().filter_map(|lexeme| match &lexeme.token {
            Token::Identifier(called) => Some(called.to_string()),
            _ => None,
        }));
        seen.push(name);
    }
    None
}

/// Names that a text declares: variables, functions, parameters, imports.
pub fn declared(lexemes: &[Lexeme]) -> Vec<String> {
    let mut names = Vec::new();
    for window in lexemes.windows(2) {
        if let (
            Token::Let | Token::Const | Token::Fn | Token::For | Token::As | Token::Comma | Token::LeftParen | Token::Pipe,
            Token::Identifier(name),
        ) = (&window[0].token, &window[1].token)
        {
            names.push(name.to_string());
        }
    }
    names.sort();
    names.dedup();
    names
}

/// True if a text declares a variable of that name.
pub fn has_variable(lexemes: &[Lexeme], name: &str) -> bool {
    lexemes.windows(2).any(|pair| {
        matches!(pair[0].token, Token::Let | Token::Const | Token::For)
            && matches!(&pair[1].token, Token::Identifier(found) if found.as_str() == name)
    })
}

/// Index ranges of the comma-separated elements inside the bracket at `open`.
fn elements(lexemes: &[Lexeme], open: usize) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut depth, mut start) = (0_usize, open + 1);
    for (index, lexeme) in lexemes.iter().enumerate().skip(open) {
        match lexeme.token {
            Token::LeftParen | Token::LeftBracket | Token::LeftBrace | Token::MapStart => depth += 1,
            Token::RightParen | Token::RightBracket | Token::RightBrace => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    if index > start {
                        found.push(start..index);
                    }
                    break;
                }
            }
            Token::Comma if depth == 1 => {
                found.push(start..index);
                start = index + 1;
            }
            _ => {}
        }
    }
    found
}

/// Bytes from the first to the last token of an index range.
fn covered(lexemes: &[Lexeme], range: &Range<usize>) -> Option<Range<usize>> {
    let (first, last) = (lexemes.get(range.start)?, lexemes.get(range.end.checked_sub(1)?)?);
    (first.range.start < last.range.end).then_some(first.range.start..last.range.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found<'a>(text: &'a str, call: &str, target: Target, method: bool) -> Option<&'a str> {
        let lexemes = lexemes(&Engine::new_raw(), text);
        locate(&lexemes, text.find(call).unwrap(), &target, method).map(|range| &text[range])
    }

    #[test]
    fn keys_and_values_are_found_at_their_own_depth() {
        let text = "let a = `${x + #{inner: 1}.inner} {`; b.ring(\"inner: 0\", #{ cells: [1, f(#{inner: 3})], // inner: 4\n  \
                    inner: -1.0 * (2), \"out er\": 5 });";
        let key = |name: &str, value| Target::Key { argument: 1, key: name.into(), value };
        assert_eq!(found(text, "ring", key("inner", true), true), Some("-1.0 * (2)"));
        assert_eq!(found(text, "ring", key("inner", false), true), Some("inner"));
        assert_eq!(found(text, "ring", key("out er", false), true), Some("\"out er\""));
        assert_eq!(found(text, "ring", key("cells", true), true), Some("[1, f(#{inner: 3})]"));
        assert_eq!(found(text, "ring", key("other", true), true), None);
        assert_eq!(found(text, "ring", Target::Argument(0), true), Some("\"inner: 0\""));
        assert_eq!(found(text, "ring", Target::Call, true), Some("ring"));
    }

    #[test]
    fn a_method_called_like_a_function_has_its_object_in_front() {
        assert_eq!(found("fix(model, side)", "fix", Target::Argument(0), true), Some("side"));
        assert_eq!(found("model.fix(side)", "fix", Target::Argument(0), true), Some("side"));
        assert_eq!(found("fix(model, side)", "fix", Target::Argument(0), false), Some("model"));
        assert_eq!(found("fix()", "fix", Target::Argument(0), false), None);
    }

    #[test]
    fn a_method_whose_closure_uses_its_object_is_found() {
        let text = "a.run(|t| b.time); sim.run(|s| sim.time);";
        let lexemes = lexemes(&Engine::new_raw(), text);
        assert_eq!(self_use(&lexemes, "run"), Some(23..26));
        assert_eq!(self_use(&lexemes, "stop"), None);
        assert_eq!(name_after_dot(&lexemes, 1), 2);
        assert_eq!(end_before(&lexemes, 2), Some(1..2));
    }

    #[test]
    fn what_follows_several_interpolations_is_read() {
        let text = "print(`a ${f(b, 4)} of ${#{c: [1]}.c[0]} and ${d}`); print(`${e}`); ring(1.5);";
        assert_eq!(found(text, "ring", Target::Argument(0), false), Some("1.5"));
        assert_eq!(found(text, "f(b", Target::Argument(1), false), Some("4"));
    }

    #[test]
    fn only_divisions_that_truncate_are_reported() {
        let divisions = |text: &str| truncating_divisions(&lexemes(&Engine::new_raw(), text)).len();
        assert_eq!(divisions("let a = 1/2;"), 1);
        assert_eq!(divisions("f(-1 / 3)"), 1);
        // The quotient exceeds 64 bits.
        assert_eq!(divisions("-9223372036854775808 / -1; 1/0"), 0);
        assert_eq!(divisions("4/2 + 1.0/2 + 2*1/2 + x/2 + 1/2**3"), 0);
    }
}
