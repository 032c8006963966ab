//! `conserva lsp`: a language server over standard input and output, for editors.
//!
//! One thread answers, another one reads. Checks run while there are no requests: a message interrupts the check, which restarts after the
//! answer. Scripts are checked as by `conserva check`: no step is taken, no file is written.

mod answers;
mod diagnostics;
mod documents;
mod positions;
mod protocol;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use clap::Args;
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use serde_json::{Value, json};

use super::console::complain;
use super::memory::MemoryArguments;
use super::process::exit_code;
use crate::script::{Class, MAX_OPERATIONS, Settings};
use documents::Documents;
use protocol::{Changed, OfDocument, Opened, Published};

/// Arguments of `conserva lsp`.
#[derive(Args)]
pub struct Arguments {
    /// Let scripts read files below this folder, too (they may read those below their own)
    #[arg(long, value_name = "DIR")]
    allow_read: Vec<PathBuf>,
    /// Operations after which a script counts as endless
    #[arg(long, value_name = "N", default_value_t = MAX_OPERATIONS)]
    max_operations: u64,
    /// Seconds after which a check is stopped
    #[arg(long, value_name = "SECONDS", default_value_t = 10)]
    patience: u64,
    /// Ignored: editors pass it to select standard input and output, which are always used
    #[arg(long, hide = true)]
    stdio: bool,
    #[command(flatten)]
    memory: MemoryArguments,
}

/// Time without a message after which checks begin `[s]`: fast typing causes one check.
const CALM: Duration = Duration::from_millis(5);

/// Runs the server until the editor ends it; returns the exit code.
pub fn serve(arguments: Arguments) -> u8 {
    arguments.memory.apply();
    let (connection, threads) = Connection::stdio();
    let interrupt = Arc::new(AtomicBool::new(false));
    let settings = Settings {
        allow_read: arguments.allow_read,
        max_operations: arguments.max_operations,
        interrupt: interrupt.clone(),
        ..Settings::default()
    };
    let outcome = converse(connection, settings, Duration::from_secs(arguments.patience));
    match outcome.and_then(|()| threads.join().map_err(|error| error.to_string())) {
        Ok(()) => 0,
        Err(cause) => {
            complain(&format!("error: the conversation with the editor ended\n= cause: {cause}\n"));
            exit_code(Class::Internal)
        }
    }
}

/// Capabilities of the server.
fn capabilities() -> Value {
    /// Documents are sent whole.
    const FULL: u8 = 1;
    json!({
        "textDocumentSync": FULL,
        "completionProvider": { "triggerCharacters": [".", "\"", "/", ":", "{"], "resolveProvider": true },
        "hoverProvider": true,
        "signatureHelpProvider": { "triggerCharacters": ["(", ","] },
        "definitionProvider": true,
        "referencesProvider": true,
        "documentHighlightProvider": true,
        "documentSymbolProvider": true,
        "documentFormattingProvider": true,
        "renameProvider": { "prepareProvider": true },
    })
}

/// Initializes the connection to the editor and answers its messages.
///
/// # Errors
/// A violation of the protocol, or a closed connection; as a text.
fn converse(connection: Connection, settings: Settings, patience: Duration) -> Result<(), String> {
    let (id, parameters) = connection.initialize_start().map_err(|error| error.to_string())?;
    let greeting = json!({
        "capabilities": capabilities(),
        "serverInfo": { "name": "conserva", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, greeting).map_err(|error| error.to_string())?;

    let (sender, messages) = channel();
    let (receiver, interrupt) = (connection.receiver.clone(), settings.interrupt.clone());
    let reading = move || {
        for message in receiver {
            if sender.send(message).is_err() {
                return;
            }
            // The flag is set after the message, so that a check that begins in between detects one of the two.
            interrupt.store(true, Ordering::SeqCst);
        }
    };
    std::thread::Builder::new().name("messages".into()).spawn(reading).map_err(|error| error.to_string())?;
    let mut server = Server { documents: Documents::new(&parameters, settings, patience), connection };
    server.answer_all(&messages)
}

/// The documents of an editor, and the connection to it.
struct Server {
    connection: Connection,
    documents: Documents,
}

impl Server {
    fn answer_all(&mut self, messages: &Receiver<Message>) -> Result<(), String> {
        loop {
            let message = match self.documents.has_unchecked() {
                false => messages.recv().map_err(|_| RecvTimeoutError::Disconnected),
                true => messages.recv_timeout(CALM),
            };
            match message {
                // The editor continues with the notification `exit`.
                Ok(Message::Request(request)) if request.method == "shutdown" => self.send(Response::new_ok(request.id, ()))?,
                Ok(Message::Request(request)) => self.answer(request)?,
                Ok(Message::Notification(note)) => {
                    if note.method == "exit" {
                        return Ok(());
                    }
                    self.note(note)?;
                }
                Ok(Message::Response(_)) => {}
                Err(RecvTimeoutError::Timeout) => self.check()?,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }

    fn send(&self, message: impl Into<Message>) -> Result<(), String> {
        self.connection.sender.send(message.into()).map_err(|error| error.to_string())
    }

    fn answer(&mut self, request: Request) -> Result<(), String> {
        let Request { id, method, params } = request;
        let answer = catch_unwind(AssertUnwindSafe(|| answers::answer(&self.documents, &method, params)));
        let response = match answer {
            Ok(Ok(value)) => Response::new_ok(id, value),
            Ok(Err((code, text))) => Response::new_err(id, code as i32, text),
            Err(_) => Response::new_err(id, ErrorCode::InternalError as i32, "the program has a defect; please report it".into()),
        };
        self.send(response)
    }

    /// Handles a notification; those other than of open texts have no effect.
    fn note(&mut self, note: Notification) -> Result<(), String> {
        fn read<T: serde::de::DeserializeOwned>(note: Notification) -> Option<T> {
            serde_json::from_value(note.params).ok()
        }
        let changed = match note.method.as_str() {
            "textDocument/didOpen" => read(note).map(|Opened { text_document: of }| (of.uri, of.version, of.text)),
            "textDocument/didChange" => read(note).and_then(|Changed { text_document: of, content_changes }| {
                Some((of.uri, of.version, content_changes.into_iter().last()?.text))
            }),
            "textDocument/didSave" => {
                // Another open text may import a saved module.
                if read::<OfDocument>(note).is_some() {
                    self.documents.check_all();
                }
                None
            }
            "textDocument/didClose" => {
                if let Some(OfDocument { text_document: of }) = read(note) {
                    self.documents.close(&of.uri);
                    self.publish(vec![Published { uri: of.uri, diagnostics: Vec::new(), version: None }])?;
                }
                None
            }
            _ => None,
        };
        let Some((uri, version, text)) = changed else { return Ok(()) };
        let found = catch_unwind(AssertUnwindSafe(|| self.documents.change(&uri, version, &text)));
        self.publish(found.ok().flatten().into_iter().collect())
    }

    fn publish(&self, found: Vec<Published>) -> Result<(), String> {
        found.into_iter().try_for_each(|found| self.send(Notification::new("textDocument/publishDiagnostics".into(), found)))
    }

    /// Checks a text that has changed.
    fn check(&mut self) -> Result<(), String> {
        let found = catch_unwind(AssertUnwindSafe(|| self.documents.check_next()));
        self.publish(found.ok().flatten().into_iter().collect())
    }
}
