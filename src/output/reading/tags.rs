//! Tags of the XML that this program writes: names, attributes, and the text after each. This is not a general XML reader: no CDATA, only
//! the five standard entities, and no check that tags are closed.

/// Name of VTK's information key for units of arrays.
pub const UNITS_LABEL: &str = "UNITS_LABEL";

/// A tag with the text between it and the next one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tag<'a> {
    /// Name of the tag; `/Piece` for a closing tag, `!--` for a comment, whose words are in `text`.
    pub name: &'a str,
    attributes: &'a str,
    /// Text up to the next tag.
    pub text: &'a str,
}

impl Tag<'_> {
    /// Returns the value of an attribute.
    pub fn attribute(&self, key: &str) -> Option<String> {
        let mut rest = self.attributes;
        while let Some((before, after)) = rest.split_once('=') {
            let (name, quoted) = (before.trim(), after.trim_start());
            let quote = quoted.chars().next().filter(|quote| "\"'".contains(*quote))?;
            let (value, next) = quoted[1..].split_once(quote)?;
            if name == key {
                return Some(unescaped(value));
            }
            rest = next;
        }
        None
    }

    /// Returns the value of an attribute as a whole number.
    pub fn count(&self, key: &str) -> Option<usize> {
        self.attribute(key)?.trim().parse().ok()
    }
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'").replace("&amp;", "&")
}

/// Returns all tags of a text in their order, up to the first incomplete tag.
pub fn tags(text: &str) -> Vec<Tag<'_>> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some((_, inside)) = rest.split_once('<') {
        if let Some(comment) = inside.strip_prefix("!--") {
            let Some((words, next)) = comment.split_once("-->") else { break };
            found.push(Tag { name: "!--", attributes: "", text: words.trim() });
            rest = next;
            continue;
        }
        let Some((tag, next)) = inside.split_once('>') else { break };
        let text = next.split('<').next().unwrap_or_default();
        let tag = tag.trim_end_matches(['/', '?']);
        let name = tag.split_whitespace().next().unwrap_or_default();
        found.push(Tag { name, attributes: tag.get(name.len()..).unwrap_or_default(), text });
        rest = next;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_attributes_and_texts() {
        let all = tags("<?xml version=\"1.0\"?>\n<A x=\"1\" file='a&amp;&quot;b.vtu'/><!-- body 0: ring <1> --><B>1 2</B><C");
        assert_eq!(all.iter().map(|tag| tag.name).collect::<Vec<_>>(), ["?xml", "A", "!--", "B", "/B"]);
        assert_eq!((all[1].count("x"), all[1].attribute("file").as_deref()), (Some(1), Some("a&\"b.vtu")));
        assert_eq!((all[2].text, all[3].text, all[1].attribute("y")), ("body 0: ring <1>", "1 2", None));
    }
}
