//! `study.html`: the study as a page without external resources.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;

use super::collected::Collected;
use super::draw::StudyPicture;
use super::folder::{PointState, StudyFolder};
use super::plan::Plan;
use super::table::StudyColumn;
use crate::output::{escaped, svg};

/// Largest number of rows of the table on the page; `table.csv` has all.
const ROWS: usize = 2000;
/// Columns not shown on the page: long, or equal in every row.
const HIDDEN: [&str; 4] = ["id", "version", "scripts", "command"];

/// Start of a table, which can be scrolled with the keyboard if it is wider than the page.
const WIDE: &str = "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"Table\">";

const STYLE: &str = include_str!("page/style.css");
const PROGRAM: &str = include_str!("page/sort.js");

/// Returns the text of the page.
pub fn page(study: &StudyFolder, plan: &Plan, collected: &Collected, pictures: &[StudyPicture]) -> String {
    let script = plan.scenario.script.display().to_string();
    let title = format!("Study of {}", script.rsplit(['/', '\\']).next().unwrap_or(&script));
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{}</h1>\n",
        escaped(&title),
        escaped(&title)
    );
    text += &summary(plan, collected);
    text += &troubles(plan, collected);
    if !pictures.is_empty() {
        text += "<h2>Results</h2>\n<div class=\"pictures\">\n";
        for StudyPicture { title, drawing, .. } in pictures {
            // Separate images, because identifiers inside the drawings, such as those of clips, would collide on one page.
            let data = BASE64_STANDARD.encode(svg(drawing));
            text += &format!("<figure><img alt=\"{}\" src=\"data:image/svg+xml;base64,{data}\"></figure>\n", escaped(title));
        }
        text += "</div>\n";
    }
    text += &table(study, plan, collected);
    text += &format!("</main>\n<script>\n{PROGRAM}</script>\n</body>\n</html>\n");
    text
}

fn summary(plan: &Plan, collected: &Collected) -> String {
    let count = plan.points.len();
    let mut rows = vec![
        ("script".to_string(), plan.scenario.script.display().to_string()),
        ("points".to_string(), format!("{count}: {}", collected.tally())),
        ("varied".to_string(), plan.names.join(", ")),
    ];
    rows.extend(plan.scenario.fixed.iter().cloned());
    let rows: String = rows.iter().map(|(name, value)| format!("<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(value))).collect();
    let remarks: String = collected.remarks.iter().map(|remark| format!("<p class=\"remark\">{}</p>\n", escaped(remark))).collect();
    format!("<dl>{rows}</dl>\n{remarks}")
}

/// Lists points without results, each with its cause and the command to repeat it.
fn troubles(plan: &Plan, collected: &Collected) -> String {
    let is_well = |state: &PointState| matches!(state, PointState::Done(record) if record.outcome.is_completed());
    let rows: Vec<usize> = (0..plan.points.len()).filter(|&row| !is_well(&collected.states[row])).take(ROWS).collect();
    if rows.is_empty() {
        return String::new();
    }
    let cell = |name: &str, row: usize| match collected.table.column(name) {
        Some(StudyColumn::Texts(column)) => column.values[row].clone().unwrap_or_default(),
        _ => String::new(),
    };
    let mut text = format!(
        "<h2>Points that did not come to their end</h2>\n{WIDE}<table>\n<tr><th>point</th><th>outcome</th><th>cause</th>\
         <th>command</th></tr>\n"
    );
    for row in rows {
        let cells =
            [plan.points[row].id.clone(), cell("outcome", row), cell("cause", row)].map(|cell| format!("<td>{}</td>", escaped(&cell)));
        text += &format!("<tr>{}<td><code>{}</code></td></tr>\n", cells.concat(), escaped(&cell("command", row)));
    }
    text + "</table></div>\n"
}

fn table(study: &StudyFolder, plan: &Plan, collected: &Collected) -> String {
    // Columns without any value, such as the drifts of scripts without simulations, only take up space and are left out.
    let has_any = |column: &StudyColumn| (0..collected.table.rows()).any(|row| !column.cell(row).is_empty());
    let is_shown = |column: &&StudyColumn| !HIDDEN.contains(&column.name()) && has_any(column);
    let shown: Vec<&StudyColumn> = collected.table.columns.iter().filter(is_shown).collect();
    let head: String = shown
        .iter()
        .map(|column| format!("<th><button type=\"button\">{}</button></th>", escaped(&collected.table.titled(column))))
        .collect();
    let more = collected.table.rows().saturating_sub(ROWS);
    let note = if more > 0 { format!("<p>{more} further rows are in table.csv.</p>\n") } else { String::new() };
    let mut text = format!("<h2>Table</h2>\n{note}{WIDE}<table class=\"sorted\">\n<thead><tr>{head}</tr></thead>\n<tbody>\n");
    for row in 0..collected.table.rows().min(ROWS) {
        let cells: String = shown
            .iter()
            .map(|column| {
                let words = column.shown(row);
                let kind = if column.numbers().is_some() { " class=\"number\"" } else { "" };
                // The run of a point has its own report.
                let report = study.point(&plan.points[row]).join("report.html");
                match column.name() == "index" && report.is_file() {
                    true => format!("<td{kind}><a href=\"points/{}/report.html\">{words}</a></td>", linked(&plan.points[row].id)),
                    false => format!("<td{kind}>{}</td>", escaped(&words)),
                }
            })
            .collect();
        text += &format!("<tr>{cells}</tr>\n");
    }
    text + "</tbody></table></div>\n"
}

/// Escapes a part of an address.
fn linked(text: &str) -> String {
    text.bytes()
        .map(
            |byte| {
                if byte.is_ascii_alphanumeric() || b"-._~=,".contains(&byte) { (byte as char).to_string() } else { format!("%{byte:02X}") }
            },
        )
        .collect()
}
