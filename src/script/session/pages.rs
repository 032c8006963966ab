//! Pages on the language itself: features of its engine that no registered function describes, as far as scenarios need them.

use serde_json::{Value, json};

/// Characters per line on a terminal.
const WIDTH: usize = 100;

/// A page on a subject of the language.
#[derive(Debug, PartialEq, Eq)]
pub struct Page {
    /// Names under which the page is found.
    pub names: &'static [&'static str],
    /// Title of the page.
    pub title: &'static str,
    /// Content of the page.
    pub about: &'static str,
    /// Script with an example, which runs.
    pub example: &'static str,
}

/// All pages, in the order of learning.
pub const PAGES: &[Page] = &[
    Page {
        names: &["let", "const", "variable", "variables"],
        title: "variables",
        about: "`let` declares a variable, `const` a value that stays. A statement ends with `;`. A variable is known to the end of the \
                block `{ … }` in which it stands. Functions see no variables from outside, but constants as `global::NAME`. Objects \
                (models, simulations) are handles: `let b = a` is a second name. Arrays and maps are values: `let b = a` is a copy.",
        example: "let dt = 0.01;\nconst STEPS = 100;\nprint(dt * STEPS);",
    },
    Page {
        names: &["number", "numbers", "arithmetic"],
        title: "numbers",
        about: "`2` is a whole number, `2.0` and `1e-3` are fractions. `+ - * / % **` work on both; a division of two whole numbers drops \
                its remainder, so write `1.0/2`. `x.to_int()`, `x.to_float()` and `parse_float(text)` convert. `PI` is a constant.",
        example: "print(7 / 2);   // 3\nprint(7 / 2.0); // 3.5\nprint(2 ** 10);",
    },
    Page {
        names: &["if", "else", "switch"],
        title: "decisions",
        about: "`if condition { … } else if other { … } else { … }`; it has a value. Conditions are `true` or `false`: compare with `== != \
                < <= > >=` and join with `&&`, `||` and `!`. `switch value { 1 => a, 2 | 3 => b, _ => c }` chooses among values.",
        example: "let n = 3;\nlet kind = if n % 2 == 0 { \"even\" } else { \"odd\" };\nprint(kind);",
    },
    Page {
        names: &["for", "in", "range", ".."],
        title: "loops over values",
        about: "`for x in values { … }` goes through an array, `m.keys()` and `m.values()` of a map, or a range: `0..5` is 0 to 4, `0..=5` \
                is 0 to 5, `range(0, 10, 2)` has steps of 2. `for (x, i) in values` counts from 0. `linspace(0.0, 1.0, 11)` gives \
                fractions. `break` ends the loop, `continue` goes on with the next value.",
        example: "for i in 0..3 { print(2 * i); }\nfor (word, i) in [\"a\", \"b\"] { print(`${i}: ${word}`); }",
    },
    Page {
        names: &["while", "loop", "do", "break", "continue"],
        title: "loops until something holds",
        about: "`while condition { … }` and `loop { … }`, which `break` ends. A script that does not come to an end is stopped after \
                `--max-operations`; Ctrl-C stops it at once.",
        example: "let x = 1.0;\nwhile x < 100.0 { x *= 2.0; }\nprint(x);",
    },
    Page {
        names: &["fn", "function", "functions", "return"],
        title: "functions of one's own",
        about: "`fn name(a, b) { … }` at the top level of a script; the last expression without `;`, or `return x;`, is its value. \
                Parameters are copies, but for objects. `///` comments in front of it are its help. It sees its parameters alone, no \
                variables around it.",
        example: "/// The square of a number.\nfn square(x) { x * x }\nprint(square(3));",
    },
    Page {
        names: &["closure", "closures", "|x|", "Fn"],
        title: "closures",
        about: "`|x| x * x` is a function without a name; it may use the variables around it. Amplitudes take `|t| …`, `on_step` takes \
                `|sim| …`. Call one that is in a variable with `f.call(x)`. Braces hold several statements: `|t| { let a = sin(t); a * a \
                }`.",
        example: "let factor = 3;\nlet scaled = |x| factor * x;\nprint(scaled.call(2));",
    },
    Page {
        names: &["array", "arrays", "list", "push", "append", "insert", "pop", "remove", "len", "sort", "map", "filter"],
        title: "arrays",
        about: "`[1, 2, 3]`; `a[0]` is the first entry, `a[-1]` the last. `a.len()`, `a.push(x)` puts one at the end, `a.append(b)` all of \
                another array, `a.insert(0, x)`, `a.pop()` takes the last, `a.remove(i)`, `a.contains(x)`, `a.index_of(x)`, `a.extract(1, \
                2)`, `a.reverse()`, `a.sort()`, `a.sorted()`; `a.map(|x| …)`, `a.filter(|x| …)`, `a.reduce(|sum, x| …, 0)`. Numbers are \
                computed with entry by entry: `a + b`, `2.0 * a`, `-a`, `a ** 2`; see also `max`, `min`, `sum`, `mean`, `linspace`. But `a \
                += b` appends, as `push` does: write `a = a + b` to add.",
        example: "let times = [];\nfor i in 0..5 { times.push(0.1 * i); }\nlet half = times / 2;\nprint(half.max());",
    },
    Page {
        names: &["object map", "maps", "#{", "keys", "values"],
        title: "object maps",
        about: "`#{ size: [2, 1], cells: [4, 2] }` holds values under names, as the options of functions do. `m.size` and `m[\"size\"]` \
                read and write an entry; `m.contains(\"size\")`, `m.keys()`, `m.values()`, `m.len()`, `m.remove(\"size\")`; `a + b` joins \
                two maps, the entries of `b` counting.",
        example: "let options = #{ size: [2, 1] };\noptions.cells = [4, 2];\nprint(rectangle(options).cells);",
    },
    Page {
        names: &["string", "strings", "text", "${"],
        title: "strings",
        about: "`\"text\"`, or `` `x = ${x}` `` with values inside and over several lines. `a + b` joins; `s.len()`, `s.contains(\"t\")`, \
                `s.replace(\"a\", \"b\")`, `s.split(\",\")`, `s.to_upper()`, `s.trim()`. `fmt(x, 3)` writes a number with three digits.",
        example: "let x = 2.0 / 3.0;\nprint(`x = ${fmt(x, 3)}`);",
    },
    Page {
        names: &["print", "debug", "comment", "//"],
        title: "printing and comments",
        about: "`print(value)` writes a line to standard output; it takes one value, so join several in back-ticks. `//` begins a comment \
                to the end of the line, `/* … */` is one, too.",
        example: "let n = 3;\nlet x = 0.5; // a comment\nprint(`n = ${n}, x = ${x}`);",
    },
    Page {
        names: &["import", "export", "module", "modules"],
        title: "modules",
        about: "`import \"lib/rings\" as rings;` loads `lib/rings.rhai` below the folder of the script; its functions are \
                `rings::name(…)`. A module's functions are public unless `private fn`; `export x;` offers a variable.",
        example: "// import \"lib/rings\" as rings;\n// let outer = rings::thick(2.0);",
    },
    Page {
        names: &["try", "catch", "throw", "error", "errors"],
        title: "errors",
        about: "`try { … } catch (e) { … }` goes on after an error; `print(e)` shows what went wrong. `throw \"text\"` raises one of one's \
                own. Endless scripts, values that grow too large and Ctrl-C cannot be caught.",
        example: "try { throw \"too soft\"; } catch (e) { print(e); }",
    },
];

/// The page of that name.
pub fn page(name: &str) -> Option<&'static Page> {
    PAGES.iter().find(|page| page.names.contains(&name) || page.title == name)
}

impl Page {
    /// The page for a terminal.
    pub fn text(&self) -> String {
        let mut lines = vec![String::new()];
        for word in self.about.split_whitespace() {
            match lines.last_mut() {
                Some(line) if line.chars().count() + word.chars().count() < WIDTH => *line += &format!(" {word}"),
                _ => lines.push(format!(" {word}")),
            }
        }
        let about: Vec<String> = lines.iter().map(|line| format!(" {line}")).collect();
        let example: Vec<String> = self.example.lines().map(|line| format!("    {line}")).collect();
        format!("{}\n{}\n  example:\n{}", self.title, about.join("\n"), example.join("\n"))
    }

    /// The page for the reference.
    pub fn markdown(&self) -> String {
        format!("### {}\n\n{}\n\n```rhai\n{}\n```\n\n", self.heading(), self.about, self.example)
    }

    /// Returns the title as a heading.
    pub fn heading(&self) -> String {
        self.title[..1].to_uppercase() + &self.title[1..]
    }

    /// The page for programs.
    pub fn json(&self) -> Value {
        json!({ "names": self.names, "form": "page", "title": self.title, "text": self.about, "example": self.example })
    }
}
