//! Answers to the requests of an editor.

use std::collections::HashMap;

use lsp_server::ErrorCode;
use lsp_types::request::{
    Completion, DocumentHighlightRequest, DocumentSymbolRequest, Formatting, GotoDefinition, HoverRequest, PrepareRenameRequest,
    References, Rename, Request, ResolveCompletionItem, SignatureHelpRequest,
};
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionParams, CompletionTextEdit, DocumentFormattingParams, DocumentHighlight,
    DocumentSymbolParams, Documentation, GotoDefinitionParams, HoverParams, InsertTextFormat, Location, MarkupContent, MarkupKind,
    ParameterInformation, ParameterLabel, ReferenceParams, RenameParams, SignatureHelp, SignatureHelpParams, SignatureInformation,
    SymbolInformation, SymbolKind, TextDocumentPositionParams, TextEdit, Uri, WorkspaceEdit,
};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::documents::Documents;
use super::positions::{address_of, byte_of, position_of, range_of};
use crate::script::{Candidate, Document, Role};

/// Code and text of a refusal.
type Refusal = (ErrorCode, String);

/// A text, its address, and a byte in it.
type At<'a> = (&'a Document, Uri, usize);

/// Answers a request by its method; `null` without a result.
///
/// # Errors
/// An unknown method, invalid parameters, an invalid new name.
pub fn answer(documents: &Documents, method: &str, parameters: Value) -> Result<Value, Refusal> {
    match method {
        Completion::METHOD => completion(documents, read(parameters)?),
        ResolveCompletionItem::METHOD => resolved(documents, read(parameters)?),
        HoverRequest::METHOD => {
            let HoverParams { text_document_position_params: at, .. } = read(parameters)?;
            shown(on(documents, at).and_then(|(document, _, byte)| {
                let found = document.hover(byte)?;
                Some(json!({ "contents": markdown(found.text), "range": range_of(document.text(), &found.range) }))
            }))
        }
        SignatureHelpRequest::METHOD => {
            let SignatureHelpParams { text_document_position_params: at, .. } = read(parameters)?;
            shown(on(documents, at).and_then(|(document, _, byte)| signature(document, byte)))
        }
        GotoDefinition::METHOD => {
            let GotoDefinitionParams { text_document_position_params: at, .. } = read(parameters)?;
            shown(on(documents, at).and_then(definition))
        }
        References::METHOD => {
            let ReferenceParams { text_document_position: at, .. } = read(parameters)?;
            shown(on(documents, at).map(|(document, uri, byte)| {
                let places = document.occurrences(byte).into_iter();
                places.map(|range| Location::new(uri.clone(), range_of(document.text(), &range))).collect::<Vec<_>>()
            }))
        }
        DocumentHighlightRequest::METHOD => {
            let at: TextDocumentPositionParams = read(parameters)?;
            shown(on(documents, at).map(|(document, _, byte)| {
                let places = document.occurrences(byte).into_iter();
                places.map(|range| DocumentHighlight { range: range_of(document.text(), &range), kind: None }).collect::<Vec<_>>()
            }))
        }
        PrepareRenameRequest::METHOD => {
            let at: TextDocumentPositionParams = read(parameters)?;
            shown(on(documents, at).and_then(|(document, _, byte)| {
                let places = document.occurrences(byte).into_iter();
                let here = places.into_iter().find(|range| range.start <= byte && byte <= range.end)?;
                Some(range_of(document.text(), &here))
            }))
        }
        Rename::METHOD => rename(documents, read(parameters)?),
        DocumentSymbolRequest::METHOD => symbols(documents, &read(parameters)?),
        Formatting::METHOD => formatting(documents, &read(parameters)?),
        other => Err((ErrorCode::MethodNotFound, format!("there is no method {other}"))),
    }
}

fn read<T: DeserializeOwned>(parameters: Value) -> Result<T, Refusal> {
    serde_json::from_value(parameters).map_err(|error| (ErrorCode::InvalidParams, error.to_string()))
}

fn shown(value: Option<impl serde::Serialize>) -> Result<Value, Refusal> {
    serde_json::to_value(value).map_err(|error| (ErrorCode::InternalError, error.to_string()))
}

fn on(documents: &Documents, at: TextDocumentPositionParams) -> Option<At<'_>> {
    let document = documents.get(&at.text_document.uri)?;
    let byte = byte_of(document.text(), at.position);
    Some((document, at.text_document.uri, byte))
}

fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}

fn completion(documents: &Documents, parameters: CompletionParams) -> Result<Value, Refusal> {
    let sign = parameters.context.and_then(|context| context.trigger_character);
    let Some((document, _, byte)) = on(documents, parameters.text_document_position) else { return Ok(Value::Null) };
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
        CompletionItem {
            label: name,
            kind: Some(kind),
            detail: Some(candidate.display),
            sort_text: Some(format!("{number:05}")),
            insert_text_format: Some(format),
            text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text })),
            ..CompletionItem::default()
        }
    });
    shown(Some(items.collect::<Vec<_>>()))
}

/// Returns the inserted text and its format: with the closing brackets, between which the editor puts the cursor, if it can.
fn inserted(text: &str, name: &str, is_called: bool, has_snippets: bool) -> (String, InsertTextFormat) {
    let plain = |text: &str| (text.to_string(), InsertTextFormat::PLAIN_TEXT);
    match text {
        _ if text.contains('(') && is_called => plain(name),
        _ if !has_snippets => plain(text),
        _ if text.ends_with("(#{ ") => (format!("{name}(#{{ $0 }})"), InsertTextFormat::SNIPPET),
        _ if text.ends_with('(') => (format!("{name}($0)"), InsertTextFormat::SNIPPET),
        _ => plain(text),
    }
}

fn kind_of(candidate: &Candidate, is_keyword: bool, is_in_string: bool) -> CompletionItemKind {
    match &candidate.text {
        _ if is_in_string => CompletionItemKind::VALUE,
        _ if is_keyword => CompletionItemKind::KEYWORD,
        text if text.contains('(') || candidate.display.contains('(') => CompletionItemKind::FUNCTION,
        text if text.ends_with("::") => CompletionItemKind::MODULE,
        text if text.ends_with(": ") => CompletionItemKind::PROPERTY,
        _ => CompletionItemKind::VARIABLE,
    }
}

/// Adds the help of the reference to a completion.
fn resolved(documents: &Documents, item: CompletionItem) -> Result<Value, Refusal> {
    let help = documents.any().and_then(|document| document.help(&item.label));
    shown(Some(CompletionItem { documentation: help.map(|text| Documentation::MarkupContent(markdown(text))), ..item }))
}

fn signature(document: &Document, byte: usize) -> Option<SignatureHelp> {
    let found = document.signature(byte)?;
    let parameter = |name: String| ParameterInformation { label: ParameterLabel::Simple(name), documentation: None };
    let active = u32::try_from(found.active).ok();
    let signature = SignatureInformation {
        label: found.label,
        documentation: Some(Documentation::MarkupContent(markdown(found.summary))),
        parameters: Some(found.parameters.into_iter().map(parameter).collect()),
        active_parameter: active,
    };
    Some(SignatureHelp { signatures: vec![signature], active_signature: Some(0), active_parameter: active })
}

fn definition((document, uri, byte): At<'_>) -> Option<Location> {
    let (file, range) = document.definition(byte)?;
    match file {
        None => Some(Location::new(uri, range_of(document.text(), &range))),
        Some(file) => {
            let text = crate::machine::files::read_text(&file).ok()?;
            Some(Location::new(address_of(&file)?, range_of(&text, &range)))
        }
    }
}

fn rename(documents: &Documents, parameters: RenameParams) -> Result<Value, Refusal> {
    let Some((document, uri, byte)) = on(documents, parameters.text_document_position) else { return Ok(Value::Null) };
    let name = parameters.new_name;
    let places = document.rename(byte, &name).map_err(|cause| (ErrorCode::InvalidParams, cause))?;
    let edits = places.into_iter().map(|range| TextEdit::new(range_of(document.text(), &range), name.clone()));
    #[allow(clippy::mutable_key_type)] // the protocol defines the key type
    let changes = HashMap::from([(uri, edits.collect())]);
    shown(Some(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }))
}

fn symbols(documents: &Documents, parameters: &DocumentSymbolParams) -> Result<Value, Refusal> {
    let uri = &parameters.text_document.uri;
    let Some(document) = documents.get(uri) else { return Ok(Value::Null) };
    let kind = |role| match role {
        Role::Function => SymbolKind::FUNCTION,
        Role::Module => SymbolKind::MODULE,
        Role::Variable | Role::Parameter => SymbolKind::VARIABLE,
    };
    #[allow(deprecated)] // the protocol's struct requires the deprecated field
    let symbol = |(name, role, range): (&str, Role, std::ops::Range<usize>)| SymbolInformation {
        name: name.into(),
        kind: kind(role),
        tags: None,
        deprecated: None,
        location: Location::new(uri.clone(), range_of(document.text(), &range)),
        container_name: None,
    };
    shown(Some(document.outline().into_iter().map(symbol).collect::<Vec<_>>()))
}

fn formatting(documents: &Documents, parameters: &DocumentFormattingParams) -> Result<Value, Refusal> {
    let Some(document) = documents.get(&parameters.text_document.uri) else { return Ok(Value::Null) };
    let (text, formatted) = (document.text(), document.formatted());
    let whole = lsp_types::Range::new(position_of(text, 0), position_of(text, text.len()));
    let edits = if formatted == text { Vec::new() } else { vec![TextEdit::new(whole, formatted)] };
    shown(Some(edits))
}
