//! Response times of the language server for a script of 500 lines.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

#[path = "../../tests/common/editor.rs"]
mod client;

use client::{Editor, long_script};

/// Request to the language server; the arguments are the client, the script, and the number of the repetition.
type Ask = Box<dyn FnMut(&mut Editor, &Path, usize)>;

/// Median and maximum of times `[ms]`.
fn spread(mut times: Vec<f64>) -> (f64, f64) {
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], times[times.len() - 1])
}

/// Prints the times of answers after a keystroke.
pub fn times(repetitions: usize) -> Result<(), Box<dyn Error>> {
    let folder = std::env::temp_dir().join(format!("conserva-editor-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let (file, text) = (folder.join("long.rhai"), long_script(500));
    let mut editor = Editor::start(&folder, &[]);
    editor.open(&file, &text);
    let repetitions = 10 * repetitions.max(1);
    let mut measure = |what: &str, mut ask: Ask| {
        let times = (0..repetitions).map(|number| {
            let clock = Instant::now();
            ask(&mut editor, &file, number);
            1e3 * clock.elapsed().as_secs_f64()
        });
        let (median, most) = spread(times.collect());
        println!("{what}: {median:.1} ms, at most {most:.1} ms of {repetitions}");
    };
    println!("language server, {} lines:", text.lines().count());
    let (typed, broken, whole) = (format!("{text}press_3."), format!("{text}let x = ("), text.clone());
    measure(
        "completion after a keystroke",
        Box::new(move |editor, file, number| {
            let typed = format!("{typed}{}", &"add_c"[..number % 6]);
            editor.type_text(file, &typed);
            assert!(!editor.complete(file, &typed, &typed).is_empty());
        }),
    );
    let again = text.clone();
    measure(
        "messages after a keystroke",
        Box::new(move |editor, file, number| {
            let found = editor.change(file, &format!("{again}// {number}\n"));
            assert!(found.is_empty(), "{found:?}");
        }),
    );
    measure("messages of a text that does not parse", Box::new(move |editor, file, _| assert!(!editor.change(file, &broken).is_empty())));
    measure(
        "help at the pointer",
        Box::new(move |editor, file, number| {
            if number == 0 {
                editor.change(file, &whole);
            }
            assert!(editor.ask_at("textDocument/hover", file, &whole, "press_3.gravi").is_object());
        }),
    );
    editor.quit();
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
