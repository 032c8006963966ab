//! Completeness of the gallery: every scenario and tutorial has a picture in it, and there are no other pictures.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Largest picture in bytes: the gallery is downloaded with the repository.
const LARGEST: u64 = 160_000;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// Files in a folder, by name.
fn files(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

/// Texts in parentheses after `](` that begin with `beginning`.
fn links(page: &str, beginning: &str) -> BTreeSet<String> {
    page.split("](").skip(1).filter_map(|rest| rest.split(')').next()?.strip_prefix(beginning)).map(String::from).collect()
}

#[test]
fn every_script_stands_in_the_gallery_with_a_picture() {
    let page = std::fs::read_to_string(repository().join("docs/gallery.md")).unwrap();
    let mut scripts = BTreeSet::new();
    for folder in ["scenarios", "tutorials"] {
        let names = files(&repository().join("scripts").join(folder));
        scripts.extend(names.into_iter().filter(|name| name.ends_with(".rhai")).map(|name| format!("{folder}/{name}")));
    }
    assert_eq!(links(&page, "../scripts/"), scripts, "run `cargo example gallery`");
    let folder = repository().join("docs/images/gallery");
    assert_eq!(links(&page, "images/gallery/"), files(&folder), "run `cargo example gallery`");
    assert_eq!(links(&page, "images/gallery/").len(), scripts.len());
    for name in files(&folder) {
        let bytes = std::fs::read(folder.join(&name)).unwrap();
        assert!((bytes.len() as u64) < LARGEST, "{name} has {} bytes", bytes.len());
        let is_picture = if name.ends_with(".svg") { bytes.starts_with(b"<svg") } else { bytes.starts_with(b"\x89PNG") };
        assert!(is_picture, "{name} is no picture");
    }
}

/// The text beside a picture equals the first comment of the script.
#[test]
fn the_gallery_says_what_the_scripts_say() {
    let page = std::fs::read_to_string(repository().join("docs/gallery.md")).unwrap();
    for script in links(&page, "../scripts/") {
        let text = std::fs::read_to_string(repository().join("scripts").join(&script)).unwrap();
        let first = text.lines().next().unwrap().trim_start_matches('/').trim();
        assert!(page.contains(first), "{script} begins with other words: run `cargo example gallery`");
    }
}
