//! Results of script tests as JUnit XML, for build servers.
//!
//! One `testsuite` for each file, one `testcase` for each test. The format is small enough to be implemented here.

use std::fmt::Write;

use crate::output::escaped;
use crate::script::{Ink, TestCase, TestOutcome};

/// A test with its outcome.
pub struct Tested {
    /// The test.
    pub case: TestCase,
    /// Outcome of the test.
    pub outcome: TestOutcome,
}

/// Returns the text of the file.
pub fn junit(suites: &[(String, Vec<&Tested>)], broken: &[(String, String)], seconds: f64) -> String {
    let tests: usize = suites.iter().map(|(_, tests)| tests.len()).sum();
    let failures: usize = suites.iter().map(|(_, tests)| failed(tests)).sum();
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let (all, errors) = (tests + broken.len(), broken.len());
    line(
        &mut xml,
        0,
        &format!("<testsuites name=\"conserva\" tests=\"{all}\" failures=\"{failures}\" errors=\"{errors}\" time=\"{seconds:.3}\">"),
    );
    for (file, message) in broken {
        let name = escaped(file);
        line(&mut xml, 1, &format!("<testsuite name=\"{name}\" tests=\"1\" failures=\"0\" errors=\"1\" time=\"0.000\">"));
        line(&mut xml, 2, &format!("<testcase name=\"parse\" classname=\"{name}\" time=\"0.000\">"));
        line(&mut xml, 3, &format!("<error message=\"does not parse\">{}</error>", escaped(message)));
        line(&mut xml, 2, "</testcase>");
        line(&mut xml, 1, "</testsuite>");
    }
    for (file, tests) in suites {
        let time: f64 = tests.iter().map(|test| test.outcome.time.as_secs_f64()).sum();
        let (name, count, failures) = (escaped(file), tests.len(), failed(tests));
        line(
            &mut xml,
            1,
            &format!("<testsuite name=\"{name}\" tests=\"{count}\" failures=\"{failures}\" errors=\"0\" time=\"{time:.3}\">"),
        );
        for test in tests {
            case(&mut xml, &name, test);
        }
        line(&mut xml, 1, "</testsuite>");
    }
    line(&mut xml, 0, "</testsuites>");
    xml
}

fn failed(tests: &[&Tested]) -> usize {
    tests.iter().filter(|test| test.outcome.error.is_some()).count()
}

fn case(xml: &mut String, file: &str, test: &Tested) {
    let name = escaped(test.case.function.as_deref().unwrap_or("(the whole file)"));
    let open = format!("<testcase name=\"{name}\" classname=\"{file}\" time=\"{:.3}\"", test.outcome.time.as_secs_f64());
    let Some(error) = &test.outcome.error else {
        return line(xml, 2, &format!("{open}/>"));
    };
    line(xml, 2, &format!("{open}>"));
    let text = escaped(&error.render(Ink::Plain));
    line(xml, 3, &format!("<failure message=\"{}\">{text}</failure>", escaped(&error.title)));
    if !test.outcome.output.is_empty() {
        line(xml, 3, &format!("<system-out>{}</system-out>", escaped(&test.outcome.output.join("\n"))));
    }
    line(xml, 2, "</testcase>");
}

fn line(xml: &mut String, depth: usize, text: &str) {
    let _ = writeln!(xml, "{:indent$}{text}", "", indent = 2 * depth);
}
