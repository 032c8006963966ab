//! Values of time functions.

use crate::dynamics::model::amplitude::Amplitude;
use crate::dynamics::model::step_error::StepError;

/// Value of the time function of the entity `name` at a time.
///
/// # Errors
/// The function failed, or returned a value that is not finite.
pub fn value_of(name: &str, function: &Amplitude, time: f64) -> Result<f64, StepError> {
    let failed = |source| StepError::Amplitude { boundary: name.into(), time, source };
    let value = function.value(time).map_err(failed)?;
    if value.is_finite() { Ok(value) } else { Err(failed(format!("the time function returned {value}").into())) }
}
