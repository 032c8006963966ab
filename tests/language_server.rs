//! Language server, tested by a client of its protocol: messages, completion, help, definitions, renaming, malformed texts.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

#[path = "common/editor.rs"]
mod editor;
#[path = "common/program.rs"]
mod program;
#[path = "common/splitmix.rs"]
mod splitmix;

use editor::{Editor, address, long_script, place};
use splitmix::SplitMix;

const PRESS: &str = r#"let steel = neo_hookean(#{ youngs_modulus: 1e3, poisson_ratio: 0.3, density: 1.0 });
let press = model("press");
let table = press.add_body("table", rectangle(#{ size: [3.0, 1.0], cells: [6, 2] }), steel);
/// Twice a number.
fn twice(x) { 2.0 * x }
let load = twice(0.25);
press.fix(table.boundary("bottom"));
press.gravity([0.0, -load]);
let sim = simulate(press, #{ integrator: energy_momentum(), dt: 0.01 });
sim.run_to(0.1);
print(sim.history.total[0] + twice(load));
"#;

fn started(name: &str) -> (PathBuf, Editor) {
    let folder = program::empty_folder(name).canonicalize().unwrap();
    let editor = Editor::start(&folder, &["--patience", "2"]);
    (folder, editor)
}

/// Severity, line (from 1) and text of messages.
fn told(messages: &[Value]) -> Vec<(i64, i64, String)> {
    let line = |of: &Value| of["range"]["start"]["line"].as_i64().unwrap() + 1;
    messages.iter().map(|of| (of["severity"].as_i64().unwrap(), line(of), of["message"].as_str().unwrap().to_string())).collect()
}

/// Messages without the note about the first use of a result.
fn faults(messages: &[Value]) -> Vec<(i64, i64, String)> {
    told(messages).into_iter().filter(|(severity, ..)| *severity < 3).collect()
}

#[test]
fn mistakes_are_told_while_typing() {
    let (folder, mut editor) = started("mistakes");
    let file = folder.join("press.rhai");
    let found = told(&editor.open(&file, PRESS));
    assert!(matches!(found.as_slice(), [(4, 11, text)] if text.contains("a result is used here")), "{found:?}");
    for (mistake, replacement, severity, line, wanted) in [
        ("press.fix(", "press.fix((", 1, 7, "`)` is missing"),
        ("youngs_modulus", "young_modulus", 1, 1, "did you mean `youngs_modulus`"),
        ("\"bottom\"", "\"botom\"", 1, 7, "hint: did you mean"),
        ("twice(0.25)", "twic(0.25)", 1, 6, "did you mean `twice`"),
        ("2.0 * x", "2.0 * y", 1, 5, "there is no variable `y`"),
        ("load = twice(0.25)", "load = 1/4", 2, 6, "1/4 is 0"),
        // after the first use of a result, which a check does not pass
        ("total[0] + twice(", "total[0] + twise(", 2, 11, "there is no function `twise`"),
        ("print(sim.", "sim.plot(\"a.svg\", \"total\", #{ titel: 1 });\nprint(sim.", 1, 11, "has no option `titel`"),
    ] {
        let text = PRESS.replacen(mistake, replacement, 1);
        assert_ne!(text, PRESS);
        let found = faults(&editor.change(&file, &text));
        let is_wanted = |(of, at, told): &(i64, i64, String)| *of == severity && *at == line && told.contains(wanted);
        assert!(found.iter().any(is_wanted), "{replacement}: {found:?}");
        assert_eq!(faults(&editor.change(&file, PRESS)), []);
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "a file was written");
    assert_eq!(editor.quit(), Some(0));
}

#[test]
fn completions_know_values_and_types() {
    let (folder, mut editor) = started("completions");
    let file = folder.join("press.rhai");
    editor.open(&file, PRESS);
    let mut complete = |line: &str, wanted: &[&str], unwanted: &[&str]| {
        // The text is typed at the end of the script, which is then incomplete.
        let text = format!("{PRESS}{line}");
        editor.type_text(&file, &text);
        let found = editor.complete(&file, &text, &text);
        for name in wanted {
            assert!(found.iter().any(|known| known == name), "{line}: no {name} in {found:?}");
        }
        for name in unwanted {
            assert!(!found.iter().any(|known| known == name), "{line}: {name}");
        }
    };
    complete("sim.", &["run_to", "history", "energy"], &["fix", "PI"]);
    complete("rectangle(#{ size: [1.0, 1.0], ", &["cells"], &["size"]);
    complete("table.boundary(\"", &["bottom", "left"], &["table"]);
    complete("sim.history[\"", &["total", "kinetic"], &[]);
    complete("let a = tw", &["twice"], &["table"]);
    complete("fn f(sim) { let part = rectangle(#{ size: [1.0, 1.0], cells: [1, 1] }); part.", &["refine", "nodes"], &["run_to"]);
    complete("fn f(length) { le", &["length", "let"], &["load"]);
    complete("fn f(body) { body.bound", &["boundary"], &[]);
    // Units by name, also behind a quotient.
    complete("let e = quantity(1.0, \"k", &["kg", "kN"], &["table"]);
    complete("let e = in_unit([1.0], \"kg/m", &["kg/mm"], &[]);
    complete("units(\"m", &["mm-N-t", "mm"], &[]);
    complete("// tw", &[], &["twice"]);
    // The help of a completion is sent on request.
    let text = format!("{PRESS}le");
    let items = editor.ask_at("textDocument/completion", &file, &text, &text);
    let item = items.as_array().unwrap().first().cloned().unwrap_or(json!({ "label": "linspace" }));
    let item = editor.ask("completionItem/resolve", json!({ "label": "ring", "kind": 3, "detail": item["detail"] }));
    assert!(item["documentation"]["value"].as_str().unwrap().contains("inner_radius"), "{item}");
}

#[test]
fn names_are_explained_found_and_renamed() {
    let (folder, mut editor) = started("names");
    let file = folder.join("press.rhai");
    editor.open(&file, PRESS);
    let mut hover = |before: &str| editor.ask_at("textDocument/hover", &file, PRESS, before)["contents"]["value"].to_string();
    for (before, wanted) in [
        ("let load", "0.5"),
        ("let table", "Body"),
        ("= twice", "Twice a number."),
        ("press.grav", "Model.gravity"),
        ("youngs_mod", "neo_hookean"),
        ("\"table\", rect", "rectangle(#{"),
    ] {
        let found = hover(before);
        assert!(found.contains(wanted), "{before}: {found}");
    }
    let definition = editor.ask_at("textDocument/definition", &file, PRESS, "total[0] + twi");
    assert_eq!(
        (definition["uri"].as_str(), definition["range"]["start"].clone()),
        (Some(&*address(&file)), json!({ "line": 4, "character": 3 }))
    );
    let signature = editor.ask_at(
        "textDocument/signatureHelp",
        &file,
        PRESS,
        "press.add_body(\"table\", rectangle(#{ size: [3.0, 1.0], cells: [6, 2] }),",
    );
    assert_eq!(
        (signature["activeParameter"].clone(), signature["signatures"][0]["label"].as_str().unwrap().contains("add_body")),
        (json!(2), true)
    );
    let mut parameters = place(&file, PRESS, "let loa");
    parameters["context"] = json!({ "includeDeclaration": true });
    let uses = editor.ask("textDocument/references", parameters);
    assert_eq!(uses.as_array().map(Vec::len), Some(3), "{uses}");

    let mut parameters = place(&file, PRESS, "fn twi");
    parameters["newName"] = json!("doubled");
    let edits = editor.ask("textDocument/rename", parameters.clone())["changes"][address(&file)].clone();
    let renamed = applied(PRESS, &edits);
    assert_eq!(renamed, PRESS.replace("twice", "doubled"));
    assert_eq!(faults(&editor.change(&file, &renamed)), []);
    editor.change(&file, PRESS);
    for name in ["for", "2x", "mean", "", "a b"] {
        parameters["newName"] = json!(name);
        assert!(editor.answer("textDocument/rename", parameters.clone())["error"].is_object(), "{name}");
    }
    let mut parameters = place(&file, PRESS, "let loa");
    parameters["newName"] = json!("table");
    let refused = editor.answer("textDocument/rename", parameters)["error"]["message"].to_string();
    assert!(refused.contains("another `table`"), "{refused}");

    let symbols = editor.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": address(&file) } }));
    let names: Vec<&str> = symbols.as_array().unwrap().iter().map(|symbol| symbol["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["steel", "press", "table", "twice", "load", "sim"]);
    let text = PRESS.replace("press.fix", "  press.fix");
    editor.change(&file, &text);
    let options = json!({ "tabSize": 4, "insertSpaces": true });
    let edits = editor.ask("textDocument/formatting", json!({ "textDocument": { "uri": address(&file) }, "options": options }));
    assert_eq!(applied(&text, &edits), PRESS);
}

/// Applies edits to a text.
fn applied(text: &str, edits: &Value) -> String {
    let byte = |of: &Value| {
        let (line, character) = (of["line"].as_u64().unwrap() as usize, of["character"].as_u64().unwrap() as usize);
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        (start + character).min(text.len())
    };
    let mut places: Vec<(usize, usize, &str)> = edits
        .as_array()
        .unwrap()
        .iter()
        .map(|edit| (byte(&edit["range"]["start"]), byte(&edit["range"]["end"]), edit["newText"].as_str().unwrap()))
        .collect();
    places.sort();
    let mut text = text.to_string();
    places.iter().rev().for_each(|(start, end, new)| text.replace_range(*start..*end, new));
    text
}

#[test]
fn modules_are_read_where_the_script_reads_them() {
    let (folder, mut editor) = started("modules");
    std::fs::create_dir(folder.join("lib")).unwrap();
    std::fs::write(folder.join("lib/parts.rhai"), "fn plate(n) {\n    rectangle(#{ size: [1.0, 1.0], cells: [n, n] })\n}\n").unwrap();
    std::fs::write(folder.join("lib/all.rhai"), "import \"lib/parts\" as parts;\nfn two() { parts::plate(2) }\n").unwrap();
    let (main, text) = (folder.join("main.rhai"), "import \"lib/all\" as all;\nlet plate = all::two();\nplate.nodes\n");
    assert_eq!(faults(&editor.open(&main, text)), []);
    assert_eq!(editor.complete(&main, text, "all::"), ["two"]);
    let definition = editor.ask_at("textDocument/definition", &main, text, "all::tw");
    assert_eq!(definition["uri"].as_str(), Some(&*address(&folder.join("lib/all.rhai"))));
    // Opened alone, the module belongs to the script above.
    let module = folder.join("lib/all.rhai");
    assert_eq!(faults(&editor.open(&module, &std::fs::read_to_string(&module).unwrap())), []);
    // Errors in a module are reported at the import in the script.
    std::fs::write(folder.join("lib/parts.rhai"), "fn plate(n) {\n    rectangle(#{ size: [1.0, 1.0], cels: [n, n] })\n}\n").unwrap();
    let found = faults(&editor.change(&main, &format!("{text}\n")));
    assert!(matches!(found.as_slice(), [(1, 2, text)] if text.contains("cels") && text.contains("lib/parts.rhai:2")), "{found:?}");
}

#[test]
fn nothing_runs_and_nothing_hangs() {
    let (folder, mut editor) = started("hostile");
    let file = folder.join("main.rhai");
    let found = told(&editor.open(&file, "let x = 1;\nloop { x += 1; }\n"));
    assert!(found.iter().any(|(severity, _, text)| *severity == 3 && text.contains("stopped after 2 s")), "{found:?}");
    // A request during this check is answered at once.
    editor.type_text(&file, "let xyz = 1;\nloop { xyz += 1; }\n// ");
    std::thread::sleep(std::time::Duration::from_millis(200));
    let begun = std::time::Instant::now();
    assert!(editor.complete(&file, "let xyz = 1;\nlo", "let xyz = 1;\nlo").contains(&"loop".to_string()));
    assert!(begun.elapsed() < std::time::Duration::from_secs(1), "the check was not interrupted");
    let writing = format!("{PRESS}sim.write_table(\"a.csv\", [\"total\"]);\nsim.picture(\"a.svg\");\n");
    assert_eq!(faults(&editor.change(&file, &writing)), []);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "a file was written");
    let error = editor.answer("no/such", json!({}))["error"]["code"].clone();
    assert_eq!(error, json!(-32601));
    assert!(editor.answer("textDocument/hover", json!({ "textDocument": 7 }))["error"].is_object());
    assert_eq!(editor.quit(), Some(0));
}

/// Times are printed, not compared (`-- --nocapture`): they depend on the load of the machine.
#[test]
fn messages_of_500_lines_come_with_every_change() {
    let (folder, mut editor) = started("quick");
    let (file, text) = (folder.join("long.rhai"), long_script(500));
    editor.open(&file, &text);
    let mut time = |number: usize| {
        let clock = std::time::Instant::now();
        assert_eq!(editor.change(&file, &format!("{text}// {number}\n")), Vec::<Value>::new());
        clock.elapsed().as_millis()
    };
    let mut times: Vec<u128> = (0..16).map(&mut time).collect();
    times.sort_unstable();
    println!("messages of 500 lines: {} ms, half of them at most {} ms", times[0], times[times.len() / 2]);
}

/// Characters, words and brackets for malformed texts.
const PIECES: [&str; 24] = [
    "(",
    ")",
    "{",
    "}",
    "#{",
    "[",
    "`",
    "\"",
    "${",
    "'",
    "\\",
    "|",
    "fn ",
    "let ",
    "import \"",
    "::",
    ".",
    "é",
    "𝄞",
    "/*",
    "*/",
    "//",
    "\r\n",
    "\u{0}",
];

fn mutated(text: &str, random: &mut SplitMix) -> String {
    let mut text = text.to_string();
    for _ in 0..1 + random.below(6) {
        let mut at = random.below(text.len() + 1);
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        match random.below(3) {
            0 => text.insert_str(at, PIECES[random.below(PIECES.len())]),
            1 => text.truncate(at),
            _ => {
                let mut end = (at + random.below(30)).min(text.len());
                while !text.is_char_boundary(end) {
                    end -= 1;
                }
                text.replace_range(at.min(end)..end, "");
            }
        }
    }
    text
}

#[test]
fn no_text_brings_the_server_down() {
    let (folder, mut editor) = started("fuzz");
    let file = folder.join("main.rhai");
    editor.open(&file, PRESS);
    let long = long_script(100);
    let mut random = SplitMix(7);
    for round in 0..250 {
        let text = mutated(if round % 4 == 0 { &long } else { PRESS }, &mut random);
        editor.type_text(&file, &text);
        let lines = text.matches('\n').count() + 2;
        let position = json!({ "line": random.below(lines), "character": random.below(60) });
        let mut parameters = json!({ "textDocument": { "uri": address(&file) }, "position": position, "newName": "other" });
        parameters["context"] = json!({ "includeDeclaration": true, "triggerKind": 1 });
        parameters["options"] = json!({ "tabSize": 4, "insertSpaces": true });
        for method in ["completion", "hover", "definition", "signatureHelp", "references", "rename", "documentSymbol", "formatting"] {
            let answer = editor.answer(&format!("textDocument/{method}"), parameters.clone());
            let is_defect = answer["error"]["message"].as_str().is_some_and(|text| text.contains("defect"));
            assert!(!is_defect, "{method} at {position} of\n{text}");
        }
    }
    let found = editor.change(&file, PRESS);
    assert_eq!(faults(&found), []);
    assert_eq!(editor.quit(), Some(0));
}

#[test]
fn scripts_of_this_repository_have_no_findings() {
    let (_, mut editor) = started("shipped");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts");
    for folder in ["scenarios", "tutorials"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let file = entry.unwrap().path();
            if file.extension().is_none_or(|ending| ending != "rhai") {
                continue;
            }
            let text = std::fs::read_to_string(&file).unwrap();
            let found = faults(&editor.open(&file, &text));
            let shows_an_error = file.ends_with("08_why_a_step_failed.rhai");
            assert!(found.is_empty() || shows_an_error, "{}: {found:?}", file.display());
            editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": address(&file) } }));
        }
    }
}
