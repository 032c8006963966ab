//! Warnings of certain mistakes in a text, before it runs.

use rhai::Engine;

use super::diagnostics::Diagnostic;
use super::host::Host;
use super::scan;
use super::sources::SourceSpan;

/// Warns of certain mistakes: a division of two whole numbers that drops a remainder, `^` for a power.
pub fn lint(host: &Host, engine: &Engine, source: &str) {
    let Some(text) = host.sources.text(source) else { return };
    let lexemes = scan::lexemes(engine, &text);
    for (range, a, b) in scan::exclusive_ors(&lexemes) {
        let place = SourceSpan { source: source.to_string(), text: text.clone(), range };
        let warning = Diagnostic::warning(format!("{a} ^ {b} is {}", a ^ b), Some(place)).code("C1051").label("an exclusive or of bits");
        host.warn(warning.hint(format!("write `{a} ** {b}` for the power")));
    }
    for (range, dividend, divisor) in scan::truncating_divisions(&lexemes) {
        let place = SourceSpan { source: source.to_string(), text: text.clone(), range };
        let warning = Diagnostic::warning(format!("{dividend}/{divisor} is {}", dividend / divisor), Some(place))
            .code("C1052")
            .label("a division of whole numbers")
            .cause("whole numbers are divided without a remainder")
            .hint(format!("write `{dividend}.0/{divisor}` for the fraction"));
        host.warn(warning);
    }
}
