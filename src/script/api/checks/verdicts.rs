//! Common end of all checks: reports the measured value, ends the script, or only lists the check in `conserva check`.

use rhai::EvalAltResult;

use crate::script::language::failure::Class;
use crate::script::language::prelude::*;

/// Returns the failure of a check.
pub fn failed(call: &Call, title: impl Into<String>) -> Failure {
    Failure::new(Class::Check, title).in_method(call.function.form.receiver().is_some())
}

/// Reports a check that holds.
pub fn passed(call: &Call, line: &str) -> Result<(), Box<EvalAltResult>> {
    call.host.passed(line, call.place(&Target::Call).as_ref());
    Ok(())
}

/// In `conserva check`, lists the check instead of evaluating it, and returns true.
pub fn only_listed(call: &Call, line: &str) -> bool {
    if call.host.is_check() {
        let place = call.place(&Target::Call).map(|place| format!("{place}: ")).unwrap_or_default();
        call.host.findings.borrow_mut().push(format!("check: {place}{line}"));
    }
    call.host.is_check()
}
