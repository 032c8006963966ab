//! An editor that speaks the language server protocol with `conserva lsp`, for its tests and its benchmark.

// Each program uses a part of this file.
#![allow(dead_code)]

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Time after which an answer counts as missing, on a machine with much else to do.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running server and its answers.
pub struct Editor {
    child: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    count: i64,
    version: i64,
}

impl Editor {
    /// Starts the server in a folder and greets it.
    pub fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_conserva"));
        command.current_dir(folder).arg("lsp").args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            while let Some(message) = message(&mut output) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let mut editor = Editor { child, input, messages, count: 0, version: 0 };
        let root = json!({ "rootUri": address(folder), "capabilities": {
            "textDocument": { "completion": { "completionItem": { "snippetSupport": true } } },
        } });
        let greeting = editor.ask("initialize", root);
        assert!(greeting["capabilities"]["renameProvider"].is_object(), "{greeting}");
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        self.input.flush().unwrap();
    }

    /// Sends a notification.
    pub fn tell(&mut self, method: &str, parameters: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": parameters }));
    }

    /// Sends a request; returns the whole answer.
    pub fn answer(&mut self, method: &str, parameters: Value) -> Value {
        self.count += 1;
        let id = self.count;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": parameters }));
        self.wait(|message| message["id"] == id, method)
    }

    /// Sends a request; returns the result.
    pub fn ask(&mut self, method: &str, parameters: Value) -> Value {
        let answer = self.answer(method, parameters);
        assert!(answer.get("error").is_none_or(Value::is_null), "{method}: {answer}");
        answer["result"].clone()
    }

    fn wait(&mut self, is_wanted: impl Fn(&Value) -> bool, what: &str) -> Value {
        let begun = Instant::now();
        loop {
            let left = PATIENCE.saturating_sub(begun.elapsed());
            let message = self.messages.recv_timeout(left).unwrap_or_else(|error| panic!("{what}: {error}"));
            if is_wanted(&message) {
                return message;
            }
        }
    }

    /// Opens a text; returns the messages about it.
    pub fn open(&mut self, file: &Path, text: &str) -> Vec<Value> {
        self.version += 1;
        let document = json!({ "uri": address(file), "languageId": "conserva", "version": self.version, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.messages(file)
    }

    /// Replaces a text, and does not wait.
    pub fn type_text(&mut self, file: &Path, text: &str) {
        self.version += 1;
        let document = json!({ "uri": address(file), "version": self.version });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [{ "text": text }] }));
    }

    /// Replaces a text; returns the messages about it.
    pub fn change(&mut self, file: &Path, text: &str) -> Vec<Value> {
        self.type_text(file, text);
        self.messages(file)
    }

    fn messages(&mut self, file: &Path) -> Vec<Value> {
        let (uri, version) = (address(file), self.version);
        let is_wanted = |message: &Value| message["params"]["uri"] == uri && message["params"]["version"] == version;
        let found = self.wait(is_wanted, "messages");
        found["params"]["diagnostics"].as_array().unwrap().clone()
    }

    /// Sends a request about the position behind the first occurrence of `before` in a text.
    pub fn ask_at(&mut self, method: &str, file: &Path, text: &str, before: &str) -> Value {
        self.ask(method, place(file, text, before))
    }

    /// Names of the completions behind the first occurrence of `before` in a text.
    pub fn complete(&mut self, file: &Path, text: &str, before: &str) -> Vec<String> {
        let found = self.ask_at("textDocument/completion", file, text, before);
        found.as_array().into_iter().flatten().map(|item| item["label"].as_str().unwrap().to_string()).collect()
    }

    /// Ends the server; returns its exit code.
    pub fn quit(mut self) -> Option<i32> {
        self.ask("shutdown", Value::Null);
        self.tell("exit", Value::Null);
        self.child.wait().unwrap().code()
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        let _ = self.child.kill();
    }
}

fn message(output: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if output.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim().split_once(": ") {
            Some(("Content-Length", number)) => length = number.parse().ok()?,
            Some(_) => {}
            None => break,
        }
    }
    let mut text = vec![0; length];
    output.read_exact(&mut text).ok()?;
    serde_json::from_slice(&text).ok()
}

/// The address of a file.
pub fn address(file: &Path) -> String {
    format!("file://{}", file.display())
}

/// Parameters of a request about the position behind the first occurrence of `before` in a text.
pub fn place(file: &Path, text: &str, before: &str) -> Value {
    let end = text.find(before).unwrap_or_else(|| panic!("`{before}` is not in the text")) + before.len();
    let line = text[..end].matches('\n').count();
    let start = text[..end].rfind('\n').map_or(0, |newline| newline + 1);
    let character = text[start..end].encode_utf16().count();
    json!({ "textDocument": { "uri": address(file) }, "position": { "line": line, "character": character } })
}

/// Script of about `lines` lines: small models with contacts, loads, functions and closures.
pub fn long_script(lines: usize) -> String {
    let mut text = String::from("let rubber = neo_hookean(#{ youngs_modulus: 100.0, poisson_ratio: 0.3, density: 1.0 });\n");
    let mut number = 0;
    while text.matches('\n').count() + 20 < lines {
        number += 1;
        text += &PART.replace("NUMBER", &number.to_string());
    }
    text
}

const PART: &str = r#"
/// Height of the block NUMBER at a time.
fn height_NUMBER(t, speed) {
    let drop = 0.5 * t * t;
    if drop > 1.0 { 0.0 } else { 1.0 - drop + speed * t }
}
let press_NUMBER = model("press NUMBER");
let table_NUMBER = press_NUMBER.add_body("table", rectangle(#{ size: [3.0, 1.0], cells: [6, 2], origin: [-1.0, -1.0] }), rubber);
let block_NUMBER = press_NUMBER.add_body("block", rectangle(#{ size: [1.0, 1.0], cells: [3, 3], origin: [0.1, 0.01] }), rubber);
press_NUMBER.fix(table_NUMBER.boundary("bottom"));
press_NUMBER.add_contact("foot", #{
    secondary: block_NUMBER.boundary("bottom"),
    primary: table_NUMBER.boundary("top"),
    method: mortar(),
});
press_NUMBER.gravity([0.0, -10.0]);
press_NUMBER.pressure(block_NUMBER.boundary("top"), 0.1, |t| height_NUMBER(t, 0.0));
let sim_NUMBER = simulate(press_NUMBER, #{ integrator: energy_momentum(), dt: 0.01 });
print(`model NUMBER has ${block_NUMBER}`);
"#;
