//! `conserva repl`: the terminal of an interactive session. Lines are edited by `rustyline`; the language is that of the session.
//!
//! Ctrl-C clears the line while editing; during a computation it sets the flag that engine and solver check, so that the session stays
//! usable. The history is kept across sessions in the state folder of the XDG base directory specification.

use std::borrow::Cow;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::{Hint, Hinter, HistoryHinter};
use rustyline::history::FileHistory;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{
    Cmd, CompletionType, ConditionalEventHandler, Config, Context, Editor, Event, EventContext, EventHandler, Helper, KeyCode, KeyEvent,
    Modifiers, RepeatCount,
};

use super::console::{Console, complain, ink};
use super::memory::MemoryArguments;
use super::process::exit_code;
use super::script_arguments::threads;
use super::signals;
use crate::script::{Checkpoints, Class, Ink, Interactive, MAX_OPERATIONS, Mode, Settings, Style, home, indentation, processors};

/// Arguments of `conserva repl`.
#[derive(Args)]
pub struct Arguments {
    /// A script to run first
    script: Option<PathBuf>,
    /// Value of a parameter of the script (`param(name, default)`)
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = super::script_arguments::assignment)]
    overrides: Vec<(String, String)>,
    /// Let the session read files below this folder, too (it may read those below the script's, or the current one)
    #[arg(long, value_name = "DIR")]
    allow_read: Vec<PathBuf>,
    /// Folder of the results [default: out/<script name>-repl, or out/repl]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads of the element loop; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = threads)]
    threads: u16,
    #[command(flatten)]
    memory: MemoryArguments,
}

const PROMPT: &str = "conserva> ";

/// Text of `:help`.
const HELP: &str = "\
  help()           topics and functions; help(\"topic\"), help(\"function\"), ?function, help(object)
  ans              the last value; a semicolon at the end keeps a value from being shown
  Tab              completes names, members, options, names and files in strings
  Ctrl-R           searches the history, which lasts across sessions
  Ctrl-C           clears the line, or stops what runs at a whole step; Ctrl-D quits
  ?for, ?array     the language itself; ?f one's own function, too
  :undo            takes back the last entry: variables and functions, not steps of a simulation
  :time ENTRY      evaluates and tells how long it took
  :vars            lists the variables
  :load FILE       evaluates a file
  :digits N        shows numbers with N digits (6 at first), with `all` as they are; also %digits N
  !COMMAND         runs a command of the shell
  :save FILE       writes the session as a script that runs from scratch to the same results; :save! FILE overwrites
  :help, :quit, exit, quit
  An `if` over several lines ends with an empty line, so that `else` may follow.";

/// Interface of the session to rustyline.
struct Prompt {
    session: Rc<RefCell<Interactive>>,
    history: HistoryHinter,
    files: FilenameCompleter,
    is_colored: bool,
}

/// Suggestion behind the cursor: the rest of a signature (only shown), or of an earlier entry (accepted by the right arrow).
struct Suggestion {
    text: String,
    is_entry: bool,
}

impl Hint for Suggestion {
    fn display(&self) -> &str {
        &self.text
    }

    fn completion(&self) -> Option<&str> {
        self.is_entry.then_some(&self.text)
    }
}

impl Helper for Prompt {}

impl Completer for Prompt {
    type Candidate = Pair;

    fn complete(&self, line: &str, position: usize, context: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        let before = &line[..position];
        if let Some(command) = before.strip_prefix(':') {
            if command.starts_with("load ") || command.starts_with("save ") {
                return self.files.complete(line, position, context);
            }
            if let Some(entry) = command.strip_prefix("time ") {
                let (start, found) = self.session.borrow().complete(entry);
                return Ok((start + before.len() - entry.len(), found.into_iter().map(pair).collect()));
            }
            let names =
                ["digits ", "help", "load ", "quit", "save ", "time ", "undo", "vars"].into_iter().filter(|name| name.starts_with(command));
            return Ok((1, names.map(|name| Pair { display: format!(":{name}"), replacement: name.into() }).collect()));
        }
        let (start, found) = self.session.borrow().complete(before);
        Ok((start, found.into_iter().map(pair).collect()))
    }
}

fn pair(candidate: crate::script::Candidate) -> Pair {
    Pair { display: candidate.display, replacement: candidate.text }
}

impl Hinter for Prompt {
    type Hint = Suggestion;

    fn hint(&self, line: &str, position: usize, context: &Context<'_>) -> Option<Suggestion> {
        if position < line.len() || line.is_empty() {
            return None;
        }
        if !line.starts_with(':')
            && let Some(text) = self.session.borrow().hint(line)
        {
            return Some(Suggestion { text, is_entry: false });
        }
        self.history.hint(line, position, context).map(|text| Suggestion { text, is_entry: true })
    }
}

impl Validator for Prompt {
    fn validate(&self, context: &mut ValidationContext) -> rustyline::Result<ValidationResult> {
        let input = context.input();
        let is_command = input.starts_with([':', '?', '%']) || shell_command(&self.session.borrow(), input).is_some();
        let is_incomplete = !is_command && self.session.borrow().is_incomplete(input);
        Ok(if is_incomplete { ValidationResult::Incomplete } else { ValidationResult::Valid(None) })
    }
}

impl Highlighter for Prompt {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        if !self.is_colored || line.starts_with([':', '%', '!']) {
            return line.into();
        }
        let mut text = String::with_capacity(2 * line.len());
        let mut end = 0;
        for (range, style) in self.session.borrow().styles(line) {
            let code = match style {
                Style::Keyword => "35",
                Style::Function => "34",
                Style::Number => "36",
                Style::Text => "32",
                Style::Comment => "90",
            };
            text += &line[end..range.start];
            text += &format!("\x1b[{code}m{}\x1b[0m", &line[range.clone()]);
            end = range.end;
        }
        text += &line[end..];
        text.into()
    }

    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, _: bool) -> Cow<'b, str> {
        if self.is_colored { format!("\x1b[1m{prompt}\x1b[0m").into() } else { prompt.into() }
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        if self.is_colored { format!("\x1b[90m{hint}\x1b[0m").into() } else { hint.into() }
    }

    fn highlight_char(&self, _: &str, _: usize, kind: CmdKind) -> bool {
        self.is_colored && kind != CmdKind::MoveCursor
    }
}

/// Returns the command of the shell in a line `!command`; `None` for the negation of a value, such as `!flag` or `!(a > b)`.
fn shell_command<'l>(session: &Interactive, line: &'l str) -> Option<&'l str> {
    let command = line.strip_prefix('!')?.trim();
    let word = command.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next().unwrap_or("");
    let is_value = || matches!(word, "true" | "false") || session.variables().iter().any(|variable| variable.name == word);
    let is_call = || !word.is_empty() && command[word.len()..].starts_with(['(', '.']) || command.starts_with('(');
    (!command.is_empty() && !is_value() && !is_call()).then_some(command)
}

/// Handler of the Enter key: a new line of an incomplete entry is indented by the open brackets.
struct Indent;

impl ConditionalEventHandler for Indent {
    fn handle(&self, _: &Event, _: RepeatCount, _: bool, context: &EventContext) -> Option<Cmd> {
        let line = context.line();
        if context.pos() < line.len() || line.starts_with([':', '?', '%']) {
            return None;
        }
        let indentation = indentation(line);
        (!indentation.is_empty()).then(|| Cmd::Insert(1, format!("\n{indentation}")))
    }
}

/// Returns the path of the history file; its folder is created.
fn history_file() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let state = folder("XDG_STATE_HOME").or_else(|| Some(folder("HOME")?.join(".local/state")))?;
    let folder = state.join("conserva");
    std::fs::create_dir_all(&folder).ok()?;
    Some(folder.join("history"))
}

/// Runs the prompt; returns the exit code.
pub fn repl(arguments: Arguments) -> u8 {
    arguments.memory.apply();
    let waiting = Arc::new(AtomicBool::new(false));
    let (interrupt, over) = match signals::prompt(&waiting) {
        Ok(flags) => flags,
        Err(error) => {
            complain(&format!("error: the interrupt key cannot be watched\n= cause: {error}\n"));
            return exit_code(Class::Internal);
        }
    };
    let stem = arguments.script.as_ref().and_then(|script| script.file_stem()).map(|stem| stem.to_string_lossy().into_owned());
    let out = arguments.out.unwrap_or_else(|| Path::new("out").join(stem.map_or_else(|| "repl".into(), |stem| format!("{stem}-repl"))));
    let console = Rc::new(Console::new(false));
    let settings = Settings {
        mode: Mode::Run,
        overrides: arguments.overrides,
        allow_read: arguments.allow_read,
        output: Some(out),
        threads: usize::from(arguments.threads),
        solver: None,
        workers: processors(),
        max_operations: MAX_OPERATIONS,
        interrupt: interrupt.clone(),
        factorization: console.factorization(),
        checkpoints: Checkpoints::Never,
        until: None,
        live: None,
        interactive: true,
    };
    let home = arguments.script.as_deref().map_or(Path::new("."), home);
    let session = match Interactive::new(settings, home, console.clone()) {
        Ok(session) => Rc::new(RefCell::new(session)),
        Err(error) => {
            complain(&error.render(ink()));
            return exit_code(error.class);
        }
    };
    let mut terminal = Terminal { session, console, interrupt, waiting, over };
    if let Some(script) = &arguments.script {
        terminal.load(script);
    }
    terminal.prompt();
    let report = terminal.session.borrow_mut().finish();
    match report.error {
        None => 0,
        Some(error) => {
            terminal.console.report(&error);
            exit_code(error.class)
        }
    }
}

/// A session and its terminal.
struct Terminal {
    session: Rc<RefCell<Interactive>>,
    console: Rc<Console>,
    interrupt: Arc<AtomicBool>,
    /// True while the prompt waits for input.
    waiting: Arc<AtomicBool>,
    /// True if the session is to end.
    over: Arc<AtomicBool>,
}

impl Terminal {
    /// Reads and evaluates entries until the end of the session.
    fn prompt(&mut self) {
        let config = Config::builder().completion_type(CompletionType::List).auto_add_history(true).max_history_size(10_000);
        let editor = config.map(|config| Editor::<Prompt, FileHistory>::with_config(config.build()));
        let mut editor = match editor {
            Ok(Ok(editor)) => editor,
            Ok(Err(error)) | Err(error) => return complain(&format!("error: the terminal cannot be used\n= cause: {error}\n")),
        };
        let is_colored = self.console_ink() == Ink::Colored;
        editor.set_helper(Some(Prompt {
            session: self.session.clone(),
            history: HistoryHinter::new(),
            files: FilenameCompleter::new(),
            is_colored,
        }));
        let indent = EventHandler::Conditional(Box::new(Indent));
        editor.bind_sequence(KeyEvent(KeyCode::Enter, Modifiers::NONE), indent);
        let history = history_file();
        if let Some(file) = &history {
            // A first session has no history file.
            let _ = editor.load_history(file);
        }
        self.console.say(&format!("conserva {}   :help for help, Ctrl-D to quit", env!("CARGO_PKG_VERSION")));
        while !self.over.load(Ordering::Relaxed) {
            self.waiting.store(true, Ordering::Relaxed);
            let line = editor.readline(PROMPT);
            self.waiting.store(false, Ordering::Relaxed);
            match line {
                Ok(line) => {
                    if let Some(file) = &history {
                        let _ = editor.append_history(file);
                    }
                    if !self.answer(line.trim()) {
                        return;
                    }
                }
                Err(ReadlineError::Interrupted) => {}
                Err(ReadlineError::Eof) => return,
                Err(error) => return complain(&format!("error: the input ended\n= cause: {error}\n")),
            }
        }
    }

    fn console_ink(&self) -> Ink {
        use crate::script::Observer;
        self.console.ink()
    }

    /// Evaluates an entry; returns false at the end of the session.
    fn answer(&mut self, line: &str) -> bool {
        self.interrupt.store(false, Ordering::Relaxed);
        if let Some(name) = line.strip_prefix('?') {
            self.console.say(&self.session.borrow().help(name));
            return true;
        }
        let command = shell_command(&self.session.borrow(), line).map(ToString::to_string);
        if let Some(command) = command {
            self.shell(&command);
            return true;
        }
        let Some(command) = line.strip_prefix([':', '%']) else {
            let plain = line.trim_end_matches([';', ' ']).trim_end_matches("()");
            let is_variable = || self.session.borrow().variables().iter().any(|variable| variable.name == plain);
            if matches!(plain, "exit" | "quit") && !is_variable() {
                return false;
            }
            self.evaluate(line, false);
            return true;
        };
        let (command, rest) = command.split_once(char::is_whitespace).unwrap_or((command, ""));
        let rest = rest.trim();
        match command {
            "quit" | "q" => return false,
            "help" => self.console.say(HELP),
            "vars" => self.variables(),
            "digits" => self.digits(rest),
            "undo" => {
                let undone = self.session.borrow_mut().undo();
                match undone {
                    Ok(()) => self.console.say("taken back; `:vars` lists the variables"),
                    Err(cause) => complain(&format!("error: nothing is taken back\n= cause: {cause}\n")),
                }
            }
            "time" if !rest.is_empty() => self.evaluate(rest, true),
            "load" if !rest.is_empty() => self.load(Path::new(rest)),
            "save" if !rest.is_empty() && Path::new(rest).exists() => {
                complain(&format!("error: {rest} is there already\n= hint: choose another name, or overwrite it: `:save! {rest}`\n"))
            }
            "save" | "save!" if !rest.is_empty() => self.save(Path::new(rest)),
            "time" | "load" | "save" | "save!" => {
                complain(&format!("error: `:{command}` needs what follows it\n= hint: `:help` lists the commands\n"))
            }
            other => complain(&format!("error: there is no command `:{other}`\n= hint: `:help` lists the commands\n")),
        }
        true
    }

    /// Sets or prints the number of digits.
    fn digits(&self, text: &str) {
        let mut session = self.session.borrow_mut();
        match (text, text.parse::<usize>()) {
            ("", _) => {}
            ("all", _) => session.digits = None,
            (_, Ok(digits @ 1..=17)) => session.digits = Some(digits),
            _ => return complain("error: the number of digits must be 1 to 17, or `all`\n= hint: write `:digits 6`\n"),
        }
        let told = session.digits.map_or("all digits".into(), |digits| format!("{digits} digits"));
        self.console.say(&format!("numbers are shown with {told}"));
    }

    /// Runs a shell command, which uses the terminal until its end.
    fn shell(&self, command: &str) {
        let shell = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        match std::process::Command::new(shell.0).arg(shell.1).arg(command).status() {
            Ok(status) if status.success() => {}
            Ok(status) => complain(&format!("error: the command ended with {status}\n")),
            Err(error) => complain(&format!("error: the shell `{}` cannot be started\n= cause: {error}\n", shell.0)),
        }
    }

    fn evaluate(&self, text: &str, is_timed: bool) {
        if text.is_empty() {
            return;
        }
        let answer = self.session.borrow_mut().evaluate(text);
        self.show(answer, is_timed);
    }

    fn show(&self, answer: Result<crate::script::Answer, Box<crate::script::Diagnostic>>, is_timed: bool) {
        match answer {
            Ok(answer) => {
                if let Some(text) = answer.shown {
                    self.console.say(&text);
                }
                if is_timed {
                    self.console.say(&format!("{:.6} s", answer.elapsed.as_secs_f64()));
                }
            }
            Err(error) => self.console.report(&error),
        }
    }

    fn load(&self, path: &Path) {
        let answer = self.session.borrow_mut().load(path);
        self.show(answer, false);
    }

    fn save(&self, path: &Path) {
        let script = self.session.borrow().script();
        match std::fs::write(path, script) {
            Ok(()) => self.console.say(&format!("written to {}", path.display())),
            Err(error) => complain(&format!("error: {} cannot be written\n= cause: {error}\n= hint: check the path\n", path.display())),
        }
    }

    fn variables(&self) {
        let variables = self.session.borrow().variables();
        let width = |text: fn(&crate::script::Variable) -> &str| variables.iter().map(|variable| text(variable).chars().count()).max();
        let (name, kind) = (width(|variable| &variable.name).unwrap_or(0), width(|variable| &variable.kind).unwrap_or(0));
        for variable in &variables {
            self.console.say(&format!("  {:<name$}  {:<kind$}  {}", variable.name, variable.kind, variable.value));
        }
    }
}
