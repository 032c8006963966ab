//! Statements of a text, and values as literals, for the record of a session.

use std::ops::Range;

use rhai::{Dynamic, Token};

use crate::script::language::scan::Lexeme;

/// True if a statement is `object.run_to(…)` or `object.step(…)` without a call inside; after an interrupt, a `run_to` to the time reached
/// repeats its completed part.
pub fn is_plain_stepping(tokens: &[Lexeme]) -> bool {
    let name = |lexeme: &Lexeme| matches!(&lexeme.token, Token::Identifier(name) if matches!(name.as_str(), "run_to" | "step"));
    matches!(tokens, [object, dot, method, open, ..]
        if matches!((&object.token, &dot.token, &open.token), (Token::Identifier(_), Token::Period, Token::LeftParen)) && name(method))
        && tokens.iter().filter(|lexeme| matches!(lexeme.token, Token::LeftParen | Token::LeftBrace)).count() == 1
}

/// Returns the statements of a text outside of any bracket, as ranges of tokens without the semicolons between.
pub fn statements(lexemes: &[Lexeme]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut blocks) = (0, Vec::new());
    for (index, lexeme) in lexemes.iter().enumerate() {
        match lexeme.token {
            Token::LeftParen | Token::LeftBracket | Token::MapStart => blocks.push(false),
            Token::LeftBrace => blocks.push(true),
            Token::RightParen | Token::RightBracket => drop(blocks.pop()),
            Token::RightBrace => {
                let is_block = blocks.pop() == Some(true);
                if blocks.is_empty() && is_block && lexemes.get(index + 1).is_some_and(|next| begins_a_statement(&next.token)) {
                    found.push(start..index + 1);
                    start = index + 1;
                }
            }
            Token::SemiColon if blocks.is_empty() => {
                found.push(start..index);
                start = index + 1;
            }
            _ => {}
        }
    }
    found.push(start..lexemes.len());
    found.retain(|statement| !statement.is_empty());
    found
}

fn begins_a_statement(token: &Token) -> bool {
    use Token::*;
    matches!(
        token,
        Identifier(_)
            | IntegerConstant(_)
            | FloatConstant(_)
            | StringConstant(_)
            | InterpolatedString(_)
            | Let
            | Const
            | Fn
            | Private
            | If
            | For
            | While
            | Loop
            | Do
            | Switch
            | Import
            | Export
            | Return
            | Throw
            | Try
            | True
            | False
    )
}

/// Returns a value as a literal, if it is short and consists of numbers, truth values and strings.
pub fn literal(value: &Dynamic) -> Option<String> {
    const LONGEST: usize = 10_000;
    if value.is_unit() {
        return Some("()".into());
    }
    if let Ok(flag) = value.as_bool() {
        return Some(flag.to_string());
    }
    if let Ok(whole) = value.as_int() {
        return Some(whole.to_string());
    }
    if let Ok(number) = value.as_float() {
        return number.is_finite().then(|| format!("{number:?}"));
    }
    if let Some(array) = value.read_lock::<rhai::Array>() {
        let entries: Option<Vec<String>> = array.iter().take(LONGEST).map(literal).collect();
        return entries.filter(|_| array.len() <= LONGEST).map(|entries| format!("[{}]", entries.join(", ")));
    }
    let text = value.clone().into_string().ok()?;
    (text.chars().all(|letter| !letter.is_control()) && text.len() <= LONGEST)
        .then(|| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")))
}
