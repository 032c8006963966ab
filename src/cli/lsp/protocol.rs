//! Messages of the Language Server Protocol (Microsoft, version 3.17) that the server reads and sends, with the fields that it uses.

use serde::{Deserialize, Serialize};

/// Position in a text: line, and UTF-16 unit in the line, both from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Position {
    /// Line.
    pub line: u32,
    /// UTF-16 unit in the line.
    pub character: u32,
}

/// Range of a text; its end does not belong to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Range {
    /// First position.
    pub start: Position,
    /// Position after the last one.
    pub end: Position,
}

/// Text document by its address.
#[derive(Deserialize)]
pub struct DocumentAddress {
    /// Address, `file:///folder/file.rhai` for files.
    pub uri: String,
}

/// Parameters of a request or notification about a document.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct OfDocument {
    /// Document.
    pub text_document: DocumentAddress,
}

/// Parameters of a request about a position.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct AtPosition {
    /// Document.
    pub text_document: DocumentAddress,
    /// Position in its text.
    pub position: Position,
}

/// Parameters of `textDocument/completion`.
#[derive(Deserialize)]
pub struct CompletionParameters {
    /// Position of the cursor.
    #[serde(flatten)]
    pub at: AtPosition,
    /// Cause of the request.
    pub context: Option<CompletionContext>,
}

/// Cause of a request for completions.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CompletionContext {
    /// Typed character that caused the request; none if the user asked for it.
    pub trigger_character: Option<String>,
}

/// Parameters of `textDocument/rename`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct RenameParameters {
    /// Position of the name.
    #[serde(flatten)]
    pub at: AtPosition,
    /// New name.
    pub new_name: String,
}

/// Parameters of `textDocument/didOpen`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Opened {
    /// Opened document.
    pub text_document: DocumentText,
}

/// Document with its text.
#[derive(Deserialize)]
pub struct DocumentText {
    /// Address.
    pub uri: String,
    /// Version, which grows with each change.
    pub version: i32,
    /// Text.
    pub text: String,
}

/// Parameters of `textDocument/didChange`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Changed {
    /// Changed document.
    pub text_document: DocumentVersion,
    /// New texts; the last one holds.
    pub content_changes: Vec<Change>,
}

/// Document with its version.
#[derive(Deserialize)]
pub struct DocumentVersion {
    /// Address.
    pub uri: String,
    /// Version, which grows with each change.
    pub version: i32,
}

/// Change of a document: its whole text, as the server asks for in its capabilities.
#[derive(Deserialize)]
pub struct Change {
    /// New text.
    pub text: String,
}

/// Location in a document.
#[derive(Serialize)]
pub struct Location {
    /// Address of the document.
    pub uri: String,
    /// Range in its text.
    pub range: Range,
}

/// Replacement of a range.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TextEdit {
    /// Replaced range.
    pub range: Range,
    /// New text of the range.
    pub new_text: String,
}

/// Message about a range of a text.
#[derive(Serialize)]
pub struct Diagnostic {
    /// Range.
    pub range: Range,
    /// 1 for an error, 2 a warning, 3 an information, 4 a hint.
    pub severity: u8,
    /// Code of the message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// Program that gives the message.
    pub source: &'static str,
    /// Text of the message.
    pub message: String,
}

/// Parameters of `textDocument/publishDiagnostics`: all messages about a document.
#[derive(Serialize)]
pub struct Published {
    /// Address of the document.
    pub uri: String,
    /// Messages.
    pub diagnostics: Vec<Diagnostic>,
    /// Version of the text that was checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<i32>,
}
