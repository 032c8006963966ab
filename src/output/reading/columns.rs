//! Tables of other programs: lines of fields below a header, or without one.
//!
//! Fields are separated by semicolons, commas, tabs or blanks, as in the first line; unless separated by commas, numbers may have a decimal
//! comma, as in `0,5`. `#` begins a remark.

use std::path::Path;

use super::super::csv_text::meant;
use super::error::{ReadError, bytes_of};

/// A column of texts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadColumn {
    /// Name of the column.
    pub name: String,
    /// Fields by row.
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
    let mut rows = rows_of(text.strip_prefix('\u{feff}').unwrap_or(text))
        .map_err(|line| wrong(path, format!("has a quote in line {line} that is not closed")))?;
    let Some((_, first)) = rows.first() else {
        return Err(ReadError::new(path, "has no lines", "write a header and a line of numbers for each point"));
    };
    let is_number = |field: &String| field.is_empty() || field.parse::<f64>().is_ok();
    let count = first.len();
    let names: Vec<String> = if first.iter().all(is_number) {
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

/// Returns the separator of the fields: the first of `;`, tab and `,` that occurs in the first line outside of quotes and remarks; `None`
/// for blanks.
fn separator_of(text: &str) -> Option<char> {
    let bare = |line: &str| line.split('"').step_by(2).collect::<String>().split('#').next().unwrap_or("").to_string();
    let first = text.lines().map(bare).find(|line| !line.trim().is_empty())?;
    [';', '\t', ','].into_iter().find(|separator| first.contains(*separator))
}

/// A field during reading.
#[derive(Default)]
struct Field {
    text: String,
    is_quoted: bool,
}

/// Returns lines with their numbers and fields, without empty lines. Fails with the number of the line whose quote is not closed.
fn rows_of(text: &str) -> Result<Vec<(usize, Vec<String>)>, usize> {
    let separator = separator_of(text);
    let (mut rows, mut fields, mut field) = (Vec::new(), Vec::new(), Field::default());
    let (mut line, mut begun, mut opened) = (1, 1, None);
    let mut letters = text.chars().chain((!text.ends_with('\n')).then_some('\n')).peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if opened.is_some() && letters.next_if_eq(&'"').is_some() => field.text.push('"'),
            '"' => {
                opened = if opened.is_some() { None } else { Some(line) };
                if !std::mem::replace(&mut field.is_quoted, true) {
                    // Only blanks precede the quote.
                    field.text.truncate(field.text.trim_end().len());
                }
            }
            letter if opened.is_some() => {
                line += usize::from(letter == '\n');
                field.text.push(letter);
            }
            '#' => while letters.next_if(|letter| *letter != '\n').is_some() {},
            '\n' => {
                let is_empty = fields.is_empty() && !field.is_quoted && field.text.trim().is_empty();
                if separator.is_some() || field.is_quoted || !field.text.is_empty() {
                    fields.push(finished(std::mem::take(&mut field), separator));
                }
                let row = std::mem::take(&mut fields);
                if !is_empty {
                    rows.push((begun, row));
                }
                line += 1;
                begun = line;
            }
            letter if Some(letter) == separator => fields.push(finished(std::mem::take(&mut field), separator)),
            letter if separator.is_none() && letter.is_whitespace() => {
                if field.is_quoted || !field.text.is_empty() {
                    fields.push(finished(std::mem::take(&mut field), separator));
                }
            }
            // Blanks behind a quote.
            letter if field.is_quoted && letter.is_whitespace() => {}
            letter => field.text.push(letter),
        }
    }
    opened.map_or(Ok(rows), Err)
}

/// Returns the text of a field: unchanged if quoted, otherwise with a decimal point in numbers.
fn finished(field: Field, separator: Option<char>) -> String {
    let text = if field.is_quoted { field.text.as_str() } else { field.text.trim() };
    decimal(meant(text), separator != Some(','))
}

/// Returns a field, with a decimal point if it is a number with a decimal comma.
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
    fn what_is_written_as_a_table_comes_back() {
        let texts = ["plain", "two words", "a,b", "a \"quote\"", "=1+2", "-x", "# 1", "line\nbreak", " blank ", "", "'=", "a;b\tc"];
        let header = ["id", "name"];
        let rows: Vec<Vec<&str>> = texts.iter().enumerate().map(|(k, text)| vec![["r", "s"][k % 2], text]).collect();
        let written = crate::output::rows_csv(&header, &rows);
        let read = columns_of(Path::new("x"), &written).unwrap();
        assert_eq!((read[1].name.as_str(), &read[1].fields[..]), ("name", &texts.map(String::from)[..]));
        let rows: Vec<Vec<&str>> = texts.iter().map(|text| vec![*text]).collect();
        let read = columns_of(Path::new("x"), &crate::output::rows_csv(&["=name"], &rows)).unwrap();
        assert_eq!((read[0].name.as_str(), &read[0].fields[..]), ("=name", &texts.map(String::from)[..]));
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_line() {
        assert!(read("# nothing\n").unwrap_err().contains("has no lines"));
        assert!(read("a,b\n1,2\n# remark\n1,2,3\n").unwrap_err().contains("has 3 fields in line 4, and 2 in its first line"));
        assert!(read("a,b\n\"1,2\n").unwrap_err().contains("has a quote in line 2"));
        assert!(columns_of(Path::new("x"), &[0xff, 0xfe]).is_err());
    }
}
