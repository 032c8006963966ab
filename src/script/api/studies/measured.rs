//! `read_csv`: measured data, or results of another program.

use crate::output::{ReadError, read_columns};
use crate::script::language::prelude::*;

/// Function `read_csv` of scripts.
pub fn read_csv() -> Function {
    function(Topic::Studies, "read_csv")
        .summary(
            "the columns of a table in a file: a map of arrays by the names in its first line (`x` and `y`, or `c1`, `c2`, …, where it has \
             numbers already). A name with a unit, such as `force [N]`, is there without it, too: `table.force`. Fields are parted by \
             commas, semicolons, tabs or blanks, `#` begins a remark; an empty field of numbers is NaN",
        )
        .parameters(vec![Parameter::text("path", "the file, below the folder of the script or a folder that `--allow-read` names")])
        .see_also(&["compare", "write_table", "fit"])
        .example(
            "// measured.csv has the lines `time,force`, `0.0,0.0`, `0.5,1.2`, …\n\
                  try {\n    \
                  let measured = read_csv(\"measured.csv\");\n    \
                  print(measured.force.max());\n\
                  } catch (problem) {\n    \
                  print(problem);\n\
                  }",
        )
        .body(|call| Ok(read(call)?))
}

fn read(call: &Call) -> Result<Map, Failure> {
    let argument = call.argument("path");
    let path = argument.text()?;
    let file = call.host.sandbox.readable(&path).map_err(|failure| {
        let again =
            failure.causes.iter().fold(argument.fail(failure.title.clone()).code(&failure.code), |again, cause| again.cause(cause.clone()));
        failure.hints.iter().fold(again, |again, hint| again.hint(hint.clone()))
    })?;
    let columns = read_columns(&file).map_err(|error| {
        let failure = argument.fail(format!("\"{path}\" {}", error.what)).code(error.code());
        let ReadError { cause, hint, .. } = error;
        cause.into_iter().fold(failure, |failure, cause| failure.cause(cause)).hint(hint)
    })?;
    let mut table = Map::new();
    for column in &columns {
        if table.contains_key(column.name.as_str()) {
            let failure = argument.refuse(causes::NAME_TAKEN, format!("\"{path}\" has two columns `{}`", column.name));
            return Err(failure.hint("give every column a name of its own in the first line"));
        }
        table.insert(column.name.as_str().into(), values(&column.fields).into());
    }
    for column in &columns {
        if let Some(name) = without_unit(&column.name).filter(|name| !table.contains_key(*name)) {
            table.insert(name.into(), values(&column.fields).into());
        }
    }
    Ok(table)
}

/// Column name without its unit, such as `force` for `force [N]`; `None` for a header without a unit.
fn without_unit(header: &str) -> Option<&str> {
    let name = header.strip_suffix(']').and_then(|header| header.split_once('['))?.0.trim_end();
    (!name.is_empty()).then_some(name)
}

/// Returns numbers, or strings if a field is no number.
fn values(fields: &[String]) -> Array {
    let number = |field: &String| if field.is_empty() { Some(f64::NAN) } else { field.parse::<f64>().ok() };
    match fields.iter().map(number).collect::<Option<Vec<f64>>>() {
        Some(numbers) => numbers.into_iter().map(Dynamic::from).collect(),
        None => fields.iter().map(|field| Dynamic::from(field.clone())).collect(),
    }
}
