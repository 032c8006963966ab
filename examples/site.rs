//! Builds the documents as a searchable site in `target/site`, with mdBook and without a network, and checks every link in it.
//!
//! Pages keep their paths in the repository, so that links between them remain valid. Documents linked from the listed pages
//! (`docs/SUMMARY.md`) become pages, too; scripts and other files are copied.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (work, site) = (repository.join("target/site-source"), repository.join("target/site"));
    for folder in [&work, &site] {
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
    }
    let source = work.join("source");
    fs::create_dir_all(&source)?;
    fs::copy(repository.join("docs/book.toml"), work.join("book.toml"))?;
    let pages = write_pages(repository, &source)?;
    let built = Command::new("mdbook").arg("build").arg(&work).status();
    match built {
        Ok(status) if status.success() => {}
        Ok(status) => return Err(format!("mdBook ended with {status}").into()),
        Err(error) => return Err(format!("mdBook cannot be started ({error}); install it: cargo install --locked mdbook").into()),
    }
    let (count, broken) = broken_links(&site)?;
    for link in &broken {
        eprintln!("{link}");
    }
    if !broken.is_empty() {
        return Err(format!("{} of {count} links lead nowhere", broken.len()).into());
    }
    println!("{pages} pages, {count} links, all of which lead somewhere: open {}", site.join("index.html").display());
    Ok(())
}

/// Writes the sources of all pages and their list; returns their number.
fn write_pages(repository: &Path, source: &Path) -> Outcome<usize> {
    let listed = fs::read_to_string(repository.join("docs/SUMMARY.md"))?;
    let mut summary = String::new();
    let mut waiting = Vec::new();
    for line in listed.lines() {
        match target(line) {
            Some(target) => {
                let page = plain(&Path::new("docs").join(target));
                summary += &line.replace(&format!("({target})"), &format!("({})", page.display()));
                waiting.push(page);
            }
            None => summary += line,
        }
        summary.push('\n');
    }
    let mut known: BTreeSet<PathBuf> = waiting.iter().cloned().collect();
    let listed = known.clone();
    waiting.reverse();
    let mut further = Vec::new();
    while let Some(page) = waiting.pop() {
        let text = fs::read_to_string(repository.join(&page))?;
        let text = with_links(&text, &page, repository, |other| {
            if known.insert(other.clone()) && is_page(&other) {
                waiting.push(other);
            }
        });
        put(&source.join(&page), colored(&text).as_bytes())?;
        if !listed.contains(&page) {
            further.push((title(&text).unwrap_or_else(|| page.display().to_string()), page));
        }
    }
    if !further.is_empty() {
        summary += "\n# For those who change it\n\n";
    }
    further.sort();
    for (title, page) in &further {
        summary += &format!("- [{title}]({})\n", page.display());
    }
    put(&source.join("SUMMARY.md"), summary.as_bytes())?;
    for file in known.iter().filter(|file| !is_page(file)) {
        put(&source.join(file), &fs::read(repository.join(file))?)?;
    }
    Ok(listed.len() + further.len())
}

fn put(file: &Path, bytes: &[u8]) -> Outcome<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    Ok(fs::write(file, bytes)?)
}

fn is_page(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "md")
}

/// The target of a line's first link.
fn target(line: &str) -> Option<&str> {
    line.split("](").nth(1)?.split(')').next()
}

fn title(text: &str) -> Option<String> {
    text.lines().find_map(|line| line.strip_prefix("# ")).map(String::from)
}

/// A path without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            other => plain.push(other),
        }
    }
    plain
}

/// Marks scripts as the most similar language that mdBook can color.
fn colored(text: &str) -> String {
    text.replace("\n```rhai\n", "\n```js\n")
}

/// Returns a page whose links to folders lead to the page of the folder or are removed; `found` is called with the files of other links.
fn with_links(text: &str, page: &Path, repository: &Path, mut found: impl FnMut(PathBuf)) -> String {
    let folder = page.parent().unwrap_or(Path::new(""));
    let mut result = String::with_capacity(text.len());
    let (mut rest, mut is_code) = (text, false);
    while let Some(at) = rest.find("](") {
        let (before, after) = rest.split_at(at);
        is_code ^= before.matches("\n```").count() % 2 == 1;
        let target = after[2..].split(')').next().unwrap_or_default();
        let (file, anchor) = target.split_once('#').map_or((target, ""), |(file, anchor)| (file, anchor));
        let path = plain(&folder.join(file));
        result += before;
        rest = &after[2 + target.len()..];
        let is_other = is_code || target.contains("://") || target.contains([' ', '\n']) || file.is_empty();
        let place = repository.join(&path);
        match () {
            () if is_other || !place.exists() => result += &after[..2 + target.len()],
            () if place.is_dir() && place.join("README.md").is_file() => {
                found(path.join("README.md"));
                result += &format!("]({}/index.md", file.trim_end_matches('/'));
            }
            () if place.is_dir() => {
                // Removes the link and keeps its name.
                let name = result.rfind('[').unwrap_or(result.len());
                result.replace_range(name..name + 1, "");
                rest = rest.strip_prefix(')').unwrap_or(rest);
            }
            () => {
                found(path);
                // The page of a folder is its index in a site.
                let file = file.strip_suffix("README.md").map_or(file.to_string(), |folder| format!("{folder}index.md"));
                result += &format!("]({file}{}{anchor}", if anchor.is_empty() { "" } else { "#" });
            }
        }
    }
    result + rest
}

fn html_files(folder: &Path, found: &mut Vec<PathBuf>) -> Outcome<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            html_files(&path, found)?;
        } else if path.extension().is_some_and(|ending| ending == "html") {
            found.push(path);
        }
    }
    Ok(())
}

/// Values of an attribute in a page.
fn attributes<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
    let begin = format!(" {name}=\"");
    text.split(begin.as_str()).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// Number of links between the pages of a site, and those that lead nowhere.
fn broken_links(site: &Path) -> Outcome<(usize, Vec<String>)> {
    let mut files = Vec::new();
    html_files(site, &mut files)?;
    // The page with all pages, for printing, repeats the links of each of them.
    files.retain(|file| !file.ends_with("print.html"));
    let texts: BTreeMap<PathBuf, String> =
        files.into_iter().map(|file| Ok((file.clone(), fs::read_to_string(&file)?))).collect::<Outcome<_>>()?;
    let anchors: BTreeMap<&PathBuf, BTreeSet<&str>> =
        texts.iter().map(|(file, text)| (file, attributes(text, "id").into_iter().collect())).collect();
    let (mut count, mut broken) = (0, Vec::new());
    for (file, text) in &texts {
        // The page shown for missing addresses has links relative to the top folder.
        if file.ends_with("404.html") {
            continue;
        }
        for link in attributes(text, "href").into_iter().chain(attributes(text, "src")) {
            if link.contains("://") || link.starts_with("data:") || link.starts_with("mailto:") {
                continue;
            }
            count += 1;
            let (path, anchor) = link.split_once('#').map_or((link, ""), |(path, anchor)| (path, anchor));
            let wanted = if path.is_empty() { file.clone() } else { plain(&file.parent().unwrap_or(site).join(path)) };
            let has_anchor = anchor.is_empty() || anchors.get(&wanted).is_some_and(|known| known.contains(anchor));
            if !wanted.exists() || !has_anchor {
                broken.push(format!("{}: {link}", file.strip_prefix(site)?.display()));
            }
        }
    }
    Ok((count, broken))
}
