//! Open texts: changes since the last check, and checks.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use serde_json::Value;

use super::diagnostics::{published, stopped_note, too_long_note};
use super::positions::file_of;
use super::protocol::Published;
use crate::script::{Class, Document, Settings, imports_of};

/// An open text.
struct Open {
    uri: String,
    version: i32,
    document: Document,
    is_unchecked: bool,
}

/// All open texts.
pub struct Documents {
    settings: Settings,
    /// Folder of the editor's project.
    root: Option<PathBuf>,
    /// Time after which a check is stopped.
    patience: Duration,
    /// True if the editor supports placeholders in inserted texts.
    pub has_snippets: bool,
    open: BTreeMap<String, Open>,
}

impl Documents {
    /// Set without texts, for an editor with these parameters of `initialize`.
    pub fn new(editor: &Value, settings: Settings, patience: Duration) -> Self {
        // Older editors send `rootUri`, newer ones a list of folders.
        let folder = editor.pointer("/workspaceFolders/0/uri").or(editor.get("rootUri")).and_then(Value::as_str);
        let root = folder.and_then(file_of);
        let snippets = editor.pointer("/capabilities/textDocument/completion/completionItem/snippetSupport");
        let has_snippets = snippets.and_then(Value::as_bool).unwrap_or(false);
        Documents { settings, root, patience, has_snippets, open: BTreeMap::new() }
    }

    /// The text of an address.
    pub fn get(&self, uri: &str) -> Option<&Document> {
        self.open.get(uri).map(|open| &open.document)
    }

    /// Any open text; the functions of the language are the same for all.
    pub fn any(&self) -> Option<&Document> {
        self.open.values().next().map(|open| &open.document)
    }

    /// True if a text has changed since its last check.
    pub fn has_unchecked(&self) -> bool {
        self.open.values().any(|open| open.is_unchecked)
    }

    /// Checks all texts again.
    pub fn check_all(&mut self) {
        self.open.values_mut().for_each(|open| open.is_unchecked = true);
    }

    /// Closes a text.
    pub fn close(&mut self, uri: &str) {
        self.open.remove(uri);
    }

    /// Opens or replaces a text; returns its errors if it cannot be compiled, so that no check is needed.
    pub fn change(&mut self, uri: &str, version: i32, text: &str) -> Option<Published> {
        if !self.open.contains_key(uri) {
            let (name, home) = self.name_and_home(uri, text);
            let document = Document::new(&name, &home, self.settings.clone());
            let document = document.or_else(|_| Document::new(&name, Path::new("."), self.settings.clone())).ok()?;
            self.open.insert(uri.into(), Open { uri: uri.into(), version, document, is_unchecked: false });
        }
        let open = self.open.get_mut(uri)?;
        open.version = version;
        let (findings, is_compiled) = open.document.set_text(text);
        open.is_unchecked = is_compiled;
        if is_compiled {
            return None;
        }
        let findings = findings.into_iter().chain(open.document.linted()).collect::<Vec<_>>();
        let diagnostics = findings.iter().map(|finding| published(&open.document, finding)).collect();
        Some(Published { uri: uri.into(), diagnostics, version: Some(version) })
    }

    /// Name of a text in messages, and the folder of its files: its own folder, or for a module that of the importing script.
    fn name_and_home(&self, uri: &str, text: &str) -> (String, PathBuf) {
        let Some(file) = file_of(uri) else {
            return (uri.into(), self.root.clone().unwrap_or_else(|| ".".into()));
        };
        let imports = imports_of(text);
        let has_all = |folder: &&Path| imports.iter().all(|path| folder.join(format!("{path}.rhai")).is_file());
        let above = file.ancestors().skip(1).take_while(|folder| self.root.as_ref().is_none_or(|root| folder.starts_with(root)));
        let own = file.parent().unwrap_or(Path::new("."));
        let home = above.take(if self.root.is_some() { usize::MAX } else { 1 }).find(has_all).unwrap_or(own);
        (file.display().to_string(), home.into())
    }

    /// Checks a text that has changed; `None` if the check was interrupted by a message, so that it is repeated.
    pub fn check_next(&mut self) -> Option<Published> {
        let open = self.open.values_mut().find(|open| open.is_unchecked)?;
        open.is_unchecked = false;
        let interrupt = self.settings.interrupt.clone();
        interrupt.store(false, Ordering::SeqCst);
        let (is_late, (done, waiting)) = (Arc::new(AtomicBool::new(false)), mpsc::channel::<()>());
        let (patience, late) = (self.patience, is_late.clone());
        let watch = move || {
            if waiting.recv_timeout(patience) == Err(mpsc::RecvTimeoutError::Timeout) {
                late.store(true, Ordering::SeqCst);
                interrupt.store(true, Ordering::SeqCst);
            }
        };
        // If the thread cannot be started, a check ends by its number of operations.
        let watching = std::thread::Builder::new().name("patience".into()).spawn(watch);
        let checked = open.document.check();
        drop((done, watching));
        let is_late = is_late.load(Ordering::SeqCst);
        let is_interrupted = checked.findings.iter().any(|finding| finding.class == Class::Interrupted);
        if is_interrupted && !is_late {
            open.is_unchecked = true;
            return None;
        }
        let findings = checked.findings.iter().filter(|finding| finding.class != Class::Interrupted);
        let found = findings.map(|finding| published(&open.document, finding));
        let stopped = checked.stopped.iter().map(|place| stopped_note(&open.document, place));
        let late = is_late.then(|| too_long_note(self.patience));
        let diagnostics = found.chain(stopped).chain(late).collect();
        Some(Published { uri: open.uri.clone(), diagnostics, version: Some(open.version) })
    }
}
