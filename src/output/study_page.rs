//! A self-contained page with a table and drawings.

use super::drawing::{Drawing, svg};
use super::markup::escaped;

/// Page of a study: a title, a sentence, a table, and drawings below the table.
pub fn study_page(title: &str, about: &str, header: &[&str], rows: &[Vec<String>], drawings: &[Drawing]) -> String {
    let cells = |tag: &str, cells: &mut dyn Iterator<Item = String>| -> String {
        let cells: String = cells.map(|cell| format!("<{tag}>{}</{tag}>", escaped(&cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let head = cells("th", &mut header.iter().map(|name| (*name).to_string()));
    let body: String = rows.iter().map(|row| cells("td", &mut row.iter().cloned())).collect();
    let figures: String = drawings.iter().map(|drawing| format!("<figure>{}</figure>\n", svg(drawing))).collect();
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>\n:root {{ color-scheme: light dark; }}\n\
         body {{ font: 15px/1.45 sans-serif; max-width: 76rem; margin: 1.5rem auto; padding: 0 1rem; overflow-wrap: anywhere; }}\n\
         .wide {{ overflow-x: auto; }}\ntable {{ border-collapse: collapse; font-variant-numeric: tabular-nums; }}\n\
         th, td {{ border-bottom: 1px solid #888; padding: 0.3em 0.7em; text-align: left; white-space: nowrap; }}\n\
         td:last-child {{ white-space: normal; min-width: 14em; }}\n\
         figure {{ margin: 1.2rem 0; }}\nsvg {{ max-width: 100%; height: auto; background: #fff; }}\n</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n<p>{}</p>\n<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table\"><table>\n\
         <thead>{head}</thead>\n<tbody>\n{body}</tbody>\n</table></div>\n{figures}</main>\n</body>\n</html>\n",
        escaped(about)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_markup_is_escaped() {
        let page = study_page("a < b", "one & all", &["x"], &[vec!["<script>".into()]], &[]);
        assert!(page.contains("<h1>a &lt; b</h1>") && page.contains("one &amp; all") && page.contains("<td>&lt;script&gt;</td>"));
    }
}
