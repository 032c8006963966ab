//! Tables of other programs: lines of fields below a header, or without one.
//!
//! Fields are parted by semicolons, commas, tabs or blanks, whichever the first line has; where they are not parted by commas, a number may
//! be written with one, as `0,5`. `#` begins a remark.

use std::path::Path;

use super::error::{ReadError, bytes_of};

/// A column of texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadColumn {
    /// Its name.
    pub name: String,
    /// Its fields.
    pub fields: Vec<String>,
}

/// Reads the columns of a table; numbers in the fields have a decimal point.
///
/// # Errors
/// A file that cannot be read or is not text; a line with another number of fields; no line at all.
pub fn read_columns(path: &Path) -> Result<Vec<ReadColumn>, ReadError> {
    columns_of(path, &bytes_of(path)?)
}

fn columns_of(path: &Path, bytes: &[u8]) -> Result<Vec<ReadColumn>, ReadError> {
    let text = std::str::from_utf8(bytes).map_err(|_| wrong(path, "is not text (UTF-8)".into()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.split('#').next().unwrap_or("")));
    let lines: Vec<(usize, &str)> = lines.filter(|(_, line)| !line.trim().is_empty()).collect();
    let Some((_, first)) = lines.first() else {
        return Err(ReadError::new(path, "has no lines", "write a header and a line of numbers for each point"));
    };
    let separator = [';', '\t', ','].into_iter().find(|separator| first.contains(*separator));
    let mut rows = Vec::new();
    for (number, line) in &lines {
        let fields = fields_of(line, separator);
        let fields = fields.ok_or_else(|| wrong(path, format!("has a quote in line {number} that is not closed")))?;
        rows.push((*number, fields));
    }
    let is_number = |field: &String| field.is_empty() || field.parse::<f64>().is_ok();
    let count = rows[0].1.len();
    let names: Vec<String> = if rows[0].1.iter().all(is_number) {
        match count {
            2 => vec!["x".into(), "y".into()],
            count => (1..=count).map(|number| format!("c{number}")).collect(),
        }
    } else {
        rows.remove(0).1
    };
    if let Some((number, fields)) = rows.iter().find(|(_, fields)| fields.len() != count) {
        return Err(wrong(path, format!("has {} in line {number}, and {count} in its first line", counted(fields.len()))));
    }
    let column =
        |(index, name): (usize, String)| ReadColumn { name, fields: rows.iter().map(|(_, fields)| fields[index].clone()).collect() };
    Ok(names.into_iter().enumerate().map(column).collect())
}

fn wrong(path: &Path, what: String) -> ReadError {
    ReadError::new(path, what, "write lines of the same number of fields, such as `time,force` and `0.5,1.2`")
}

fn counted(fields: usize) -> String {
    if fields == 1 { "1 field".into() } else { format!("{fields} fields") }
}

/// The fields of a line; `None` for a quote that is not closed.
fn fields_of(line: &str, separator: Option<char>) -> Option<Vec<String>> {
    let Some(separator) = separator else { return Some(line.split_whitespace().map(|field| decimal(field, true)).collect()) };
    let (mut fields, mut field, mut is_quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            letter if letter == separator && !is_quoted => fields.push(std::mem::take(&mut field)),
            letter => field.push(letter),
        }
    }
    fields.push(field);
    (!is_quoted).then(|| fields.iter().map(|field| decimal(field.trim(), separator != ',')).collect())
}

/// A field, with a decimal point where it is a number with a decimal comma.
fn decimal(field: &str, has_commas: bool) -> String {
    let pointed = field.replacen(',', ".", 1);
    if has_commas && pointed.parse::<f64>().is_ok() { pointed } else { field.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<(String, Vec<String>)>, String> {
        let columns = columns_of(Path::new("curve.csv"), text.as_bytes());
        columns.map(|all| all.into_iter().map(|column| (column.name, column.fields)).collect()).map_err(|error| error.to_string())
    }

    fn column(name: &str, fields: &[&str]) -> (String, Vec<String>) {
        (name.into(), fields.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn tables_of_all_kinds_are_read() {
        let expected = [column("time [s]", &["0", "0.5"]), column("force", &["1e3", ""])];
        for text in [
            "time [s],force\n0,1e3\n0.5,\n",
            "# a remark\n\ntime [s];force\r\n0;1e3\r\n0,5;",
            "\u{feff}\"time [s]\"\tforce # kN\n0\t1e3\n0.5\t",
        ] {
            assert_eq!(read(text).unwrap(), expected, "{text:?}");
        }
        assert_eq!(read("0 1\n0,5  2,25\n").unwrap(), [column("x", &["0", "0.5"]), column("y", &["1", "2.25"])]);
        assert_eq!(read("1,2,3\n").unwrap(), [column("c1", &["1"]), column("c2", &["2"]), column("c3", &["3"])]);
        assert_eq!(read("name,\"a, b\"\nx,1\n").unwrap(), [column("name", &["x"]), column("a, b", &["1"])]);
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_line() {
        assert!(read("# nothing\n").unwrap_err().contains("has no lines"));
        assert!(read("a,b\n1,2\n# remark\n1,2,3\n").unwrap_err().contains("has 3 fields in line 4, and 2 in its first line"));
        assert!(read("a,b\n\"1,2\n").unwrap_err().contains("has a quote in line 2"));
        assert!(columns_of(Path::new("x"), &[0xff, 0xfe]).is_err());
    }
}
