//! The page of one run or of several, from its template.

use serde_json::Value;

use super::assets::{HEAD, STYLE};
use crate::output::markup::escaped;

/// Parts that are inserted into a template.
pub struct TemplateParts<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// Addition to the policy that limits what the page may load.
    pub connections: &'a str,
    /// Parts of the page's program, in the order of their dependencies.
    pub program: &'a [&'a str],
    /// Data that are embedded as JSON.
    pub data: &'a Value,
    /// Packed arrays with their names.
    pub blobs: &'a [(String, String)],
}

/// Fills the template of a page with the body `body`.
pub fn fill(body: &str, filling: &TemplateParts) -> Vec<u8> {
    let mut page = String::with_capacity(1 << 20);
    let template = [HEAD, body].concat();
    let mut rest = template.as_str();
    // One pass from the left, so that inserted texts are not searched again.
    while let Some(start) = rest.find("{{") {
        let Some(length) = rest[start..].find("}}") else { break };
        page.push_str(&rest[..start]);
        match &rest[start + 2..start + length] {
            "title" => page.push_str(&escaped(filling.title)),
            "style" => page.push_str(STYLE),
            "connections" => page.push_str(filling.connections),
            "program" => filling.program.iter().for_each(|part| page.push_str(part)),
            "data" => page.push_str(&filling.data.to_string().replace('<', "\\u003c")),
            "blobs" => {
                for (name, text) in filling.blobs {
                    page.push_str(&format!("<script type=\"text/plain\" id=\"{name}\">{text}</script>\n"));
                }
            }
            _ => {}
        }
        rest = &rest[start + length + 2..];
    }
    page.push_str(rest);
    page.into_bytes()
}
