//! Descriptions of pictures, movies and reports for `conserva info`.

use serde_json::Value;

/// Properties of a file with their values, in the order of output.
type Facts = Vec<(&'static str, Value)>;

/// First bytes of a PNG file.
pub const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// First bytes of a GIF file, without the version.
pub const GIF: &[u8] = b"GIF8";

/// Describes a picture or movie; `None` for other files.
pub fn picture(bytes: &[u8]) -> Option<Facts> {
    let (format, size, delays) = if bytes.starts_with(PNG) {
        png(bytes)?
    } else if bytes.starts_with(GIF) {
        gif(bytes)?
    } else {
        let text = String::from_utf8_lossy(bytes);
        let tag = text.split("<svg").nth(1)?.split('>').next()?;
        let value = |key: &str| Some(tag.split(&format!(" {key}=\"")).nth(1)?.split('"').next()?.to_string());
        ("SVG", [value("width")?, value("height")?], Vec::new())
    };
    let mut facts: Facts = vec![("format", format.into()), ("size", size.join(" x ").into())];
    if !delays.is_empty() {
        facts.push(("pictures", delays.len().into()));
        facts.push(("seconds", delays.iter().sum::<f64>().into()));
    }
    Some(facts)
}

/// Format, width and height, and the duration of each picture of a movie `[s]`.
type Drawn = (&'static str, [String; 2], Vec<f64>);

fn png(bytes: &[u8]) -> Option<Drawn> {
    let whole = |at: usize| Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let half = |at: usize| Some(u16::from_be_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    let (mut at, mut delays) = (PNG.len(), Vec::new());
    // Chunks: length, name, content, checksum.
    while let Some(length) = whole(at) {
        if bytes.get(at + 4..at + 8)? == b"fcTL" {
            let (numerator, denominator) = (half(at + 28)?, half(at + 30)?);
            // No denominator means hundredths.
            delays.push(f64::from(numerator) / f64::from(if denominator == 0 { 100 } else { denominator }));
        }
        at = at.checked_add(length as usize)?.checked_add(12)?;
    }
    Some(("PNG", [whole(16)?.to_string(), whole(20)?.to_string()], delays))
}

fn gif(bytes: &[u8]) -> Option<Drawn> {
    let half = |at: usize| Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    let colors = |flags: u8| if flags & 0x80 == 0 { 0 } else { 3 << ((flags & 7) + 1) };
    // Skips sub-blocks, each with its length, up to an empty one.
    let behind = |mut at: usize| {
        while *bytes.get(at)? > 0 {
            at += 1 + usize::from(bytes[at]);
        }
        Some(at + 1)
    };
    let mut at = 13 + colors(*bytes.get(10)?);
    let (mut delays, mut delay) = (Vec::new(), 0.0);
    loop {
        match *bytes.get(at)? {
            0x21 => {
                if bytes.get(at + 1) == Some(&0xf9) {
                    delay = f64::from(half(at + 4)?) / 100.0;
                }
                at = behind(at + 2)?;
            }
            0x2c => {
                delays.push(delay);
                at = behind(at + 11 + colors(*bytes.get(at + 9)?))?;
            }
            0x3b => break,
            _ => return None,
        }
    }
    // A single picture is no movie.
    let delays = if delays.len() > 1 { delays } else { Vec::new() };
    Some(("GIF", [half(6)?.to_string(), half(8)?.to_string()], delays))
}

/// Describes a report; `None` for other pages.
pub fn report(page: &str) -> Option<Facts> {
    let start = "<script type=\"application/json\" id=\"data\">";
    let data = page.split(start).nth(1)?.split("</script>").next()?;
    let data: Value = serde_json::from_str(data).ok()?;
    let stills = data["stills"].as_array()?;
    let names = |list: &Value| list.as_array().map(|all| all.iter().map(|one| one["name"].clone()).collect::<Vec<_>>());
    let outcome = if data["outcome"].is_null() { "the run had not ended".into() } else { data["outcome"].clone() };
    Some(vec![
        ("simulation", data["name"].clone()),
        ("outcome", outcome),
        ("version", data["version"].clone()),
        ("parameters", data["parameters"].clone()),
        ("bodies", names(&data["bodies"])?.into()),
        ("rows", data["row_count"].clone()),
        ("stills", stills.len().into()),
        ("end time", stills.last().map(|still| still["time"].clone()).into()),
        ("warnings", data["warnings"].as_array()?.len().into()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::LedgerRow;
    use crate::output::{MovieFormat, energies, movie};

    #[test]
    fn movies_tell_their_pictures_and_their_time() {
        for (format, name) in [(MovieFormat::Png, "PNG"), (MovieFormat::Gif, "GIF")] {
            let rows = |last: usize| (0..=last).map(|k| LedgerRow { time: k as f64, kinetic: k as f64, ..LedgerRow::default() });
            let draw = |index: usize| Some(energies("a", &rows(index + 1).collect::<Vec<_>>()).draw());
            let bytes = movie(4, &draw, 2.0, format).unwrap();
            let facts: std::collections::BTreeMap<_, _> = picture(&bytes).unwrap().into_iter().collect();
            assert_eq!((&facts["format"], &facts["pictures"]), (&name.into(), &4.into()));
            assert!((facts["seconds"].as_f64().unwrap() - 2.0).abs() < 0.05, "{facts:?}");
            // Incomplete files are not described, and cause no panic.
            (0..bytes.len()).step_by(7).for_each(|length| drop(picture(&bytes[..length])));
        }
        assert!(report("<html></html>").is_none());
    }
}
