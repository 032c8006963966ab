//! Answers to the requests of an editor.

use lsp_server::ErrorCode;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::documents::Documents;
use super::positions::{address_of, byte_of, range_of};
use super::protocol::{AtPosition, CompletionParameters, Location, OfDocument, RenameParameters, TextEdit};
use crate::script::{Candidate, Document, Role};

/// Code and text of a refusal.
type Refusal = (ErrorCode, String);

/// A text, its address, and a byte in it.
type At<'a> = (&'a Document, String, usize);

/// Answers a request by its method; `null` without a result.
///
/// # Errors
/// An unknown method, invalid parameters, an invalid new name.
pub fn answer(documents: &Documents, method: &str, parameters: Value) -> Result<Value, Refusal> {
    let here = |parameters| Ok(on(documents, read(parameters)?));
    match method {
        "textDocument/completion" => completion(documents, read(parameters)?),
        "completionItem/resolve" => Ok(resolved(documents, parameters)),
        "textDocument/hover" => shown(here(parameters)?.and_then(|(document, _, byte)| {
            let found = document.hover(byte)?;
            Some(json!({ "contents": markdown(found.text), "range": range_of(document.text(), &found.range) }))
        })),
        "textDocument/signatureHelp" => shown(here(parameters)?.and_then(|(document, _, byte)| signature(document, byte))),
        "textDocument/definition" => shown(here(parameters)?.and_then(definition)),
        "textDocument/references" => shown(here(parameters)?.map(|(document, uri, byte)| {
            let places = document.occurrences(byte).into_iter();
            places.map(|range| Location { uri: uri.clone(), range: range_of(document.text(), &range) }).collect::<Vec<_>>()
        })),
        "textDocument/documentHighlight" => shown(here(parameters)?.map(|(document, _, byte)| {
            let places = document.occurrences(byte).into_iter();
            places.map(|range| json!({ "range": range_of(document.text(), &range) })).collect::<Vec<_>>()
        })),
        "textDocument/prepareRename" => shown(here(parameters)?.and_then(|(document, _, byte)| {
            let places = document.occurrences(byte).into_iter();
            let here = places.into_iter().find(|range| range.start <= byte && byte <= range.end)?;
            Some(range_of(document.text(), &here))
        })),
        "textDocument/rename" => rename(documents, read(parameters)?),
        "textDocument/documentSymbol" => symbols(documents, &read(parameters)?),
        "textDocument/formatting" => formatting(documents, &read(parameters)?),
        other => Err((ErrorCode::MethodNotFound, format!("there is no method {other}"))),
    }
}

fn read<T: DeserializeOwned>(parameters: Value) -> Result<T, Refusal> {
    serde_json::from_value(parameters).map_err(|error| (ErrorCode::InvalidParams, error.to_string()))
}

fn shown(value: Option<impl serde::Serialize>) -> Result<Value, Refusal> {
    serde_json::to_value(value).map_err(|error| (ErrorCode::InternalError, error.to_string()))
}

fn on(documents: &Documents, at: AtPosition) -> Option<At<'_>> {
    let document = documents.get(&at.text_document.uri)?;
    let byte = byte_of(document.text(), at.position);
    Some((document, at.text_document.uri, byte))
}

fn markdown(value: String) -> Value {
    json!({ "kind": "markdown", "value": value })
}

fn completion(documents: &Documents, parameters: CompletionParameters) -> Result<Value, Refusal> {
    let sign = parameters.context.and_then(|context| context.trigger_character);
    let Some((document, _, byte)) = on(documents, parameters.at) else { return Ok(Value::Null) };
    let (text, before) = (document.text(), &document.text()[..byte]);
    // Of all braces only those of options trigger completion of names.
    if sign.as_deref() == Some("{") && !before.ends_with("#{") || sign.as_deref() == Some(":") && !before.ends_with("::") {
        return Ok(Value::Null);
    }
    let (start, found) = document.complete(byte);
    let range = range_of(text, &(start..byte));
    let is_called = text[byte..].starts_with('(');
    let items = found.into_iter().enumerate().map(|(number, candidate)| {
        let name = candidate.text.trim_end_matches(['(', ')', '#', '{', ' ', ':']).to_string();
        let kind = kind_of(&candidate, document.is_keyword(&name), before[..start].ends_with(['"', '`']));
        let (new_text, format) = inserted(&candidate.text, &name, is_called, documents.has_snippets);
        json!({
            "label": name,
            "kind": kind,
            "detail": candidate.display,
            "sortText": format!("{number:05}"),
            "insertTextFormat": format,
            "textEdit": TextEdit { range, new_text },
        })
    });
    shown(Some(items.collect::<Vec<_>>()))
}

/// Formats of inserted texts in the protocol.
const PLAIN_TEXT: u8 = 1;
const SNIPPET: u8 = 2;

/// Returns the inserted text and its format: with the closing brackets, between which the editor puts the cursor, if it can.
fn inserted(text: &str, name: &str, is_called: bool, has_snippets: bool) -> (String, u8) {
    let plain = |text: &str| (text.to_string(), PLAIN_TEXT);
    match text {
        _ if text.contains('(') && is_called => plain(name),
        _ if !has_snippets => plain(text),
        _ if text.ends_with("(#{ ") => (format!("{name}(#{{ $0 }})"), SNIPPET),
        _ if text.ends_with('(') => (format!("{name}($0)"), SNIPPET),
        _ => plain(text),
    }
}

/// Number of the kind of a completion in the protocol.
fn kind_of(candidate: &Candidate, is_keyword: bool, is_in_string: bool) -> u8 {
    let [function, variable, module, property, value, keyword] = [3, 6, 9, 10, 12, 14];
    match &candidate.text {
        _ if is_in_string => value,
        _ if is_keyword => keyword,
        text if text.contains('(') || candidate.display.contains('(') => function,
        text if text.ends_with("::") => module,
        text if text.ends_with(": ") => property,
        _ => variable,
    }
}

/// Adds the help of the reference to a completion.
fn resolved(documents: &Documents, mut item: Value) -> Value {
    let label = item.get("label").and_then(Value::as_str);
    let help = label.and_then(|label| documents.any()?.help(label));
    if let (Some(help), Some(fields)) = (help, item.as_object_mut()) {
        fields.insert("documentation".into(), markdown(help));
    }
    item
}

fn signature(document: &Document, byte: usize) -> Option<Value> {
    let found = document.signature(byte)?;
    let parameters: Vec<Value> = found.parameters.into_iter().map(|name| json!({ "label": name })).collect();
    Some(json!({
        "signatures": [{ "label": found.label, "documentation": markdown(found.summary), "parameters": parameters }],
        "activeSignature": 0,
        "activeParameter": found.active,
    }))
}

fn definition((document, uri, byte): At<'_>) -> Option<Location> {
    let (file, range) = document.definition(byte)?;
    match file {
        None => Some(Location { uri, range: range_of(document.text(), &range) }),
        Some(file) => {
            let text = crate::machine::files::read_text(&file).ok()?;
            Some(Location { uri: address_of(&file)?, range: range_of(&text, &range) })
        }
    }
}

fn rename(documents: &Documents, parameters: RenameParameters) -> Result<Value, Refusal> {
    let Some((document, uri, byte)) = on(documents, parameters.at) else { return Ok(Value::Null) };
    let name = parameters.new_name;
    let places = document.rename(byte, &name).map_err(|cause| (ErrorCode::InvalidParams, cause))?;
    let edit = |range| TextEdit { range: range_of(document.text(), &range), new_text: name.clone() };
    let edits: Vec<TextEdit> = places.into_iter().map(edit).collect();
    shown(Some(json!({ "changes": { uri: edits } })))
}

fn symbols(documents: &Documents, parameters: &OfDocument) -> Result<Value, Refusal> {
    let uri = &parameters.text_document.uri;
    let Some(document) = documents.get(uri) else { return Ok(Value::Null) };
    let [module, function, variable] = [2, 12, 13];
    let kind = |role| match role {
        Role::Function => function,
        Role::Module => module,
        Role::Variable | Role::Parameter => variable,
    };
    let symbol = |(name, role, range): (&str, Role, std::ops::Range<usize>)| {
        let location = Location { uri: uri.clone(), range: range_of(document.text(), &range) };
        json!({ "name": name, "kind": kind(role), "location": location })
    };
    shown(Some(document.outline().into_iter().map(symbol).collect::<Vec<_>>()))
}

fn formatting(documents: &Documents, parameters: &OfDocument) -> Result<Value, Refusal> {
    let Some(document) = documents.get(&parameters.text_document.uri) else { return Ok(Value::Null) };
    let (text, formatted) = (document.text(), document.formatted());
    let range = range_of(text, &(0..text.len()));
    let edits = if formatted == text { Vec::new() } else { vec![TextEdit { range, new_text: formatted }] };
    shown(Some(edits))
}
