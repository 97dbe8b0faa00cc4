//! Every link of a made site is looked up: the file that it names, and the place in it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::pages::within;

/// The pages of others in the site: rustdoc looks after its own links.
const NOT_OURS: &str = "api";

/// The links that lead nowhere, each with its page.
///
/// # Errors
/// When a page cannot be read.
pub fn check(site: &Path) -> Result<Vec<String>> {
    let mut pages = BTreeMap::new();
    gather(site, Path::new(""), &mut pages)?;
    let mut wrong = Vec::new();
    for (page, text) in &pages {
        let folder = page.parent().unwrap_or(Path::new(""));
        // The page for what is not found is shown anywhere; its links begin at the root.
        if page == Path::new("404.html") {
            continue;
        }
        for link in ["href", "src"].iter().flat_map(|name| values(text, name)) {
            let (path, place) = link.split_once('#').unwrap_or((link, ""));
            if path.contains(':') {
                continue;
            }
            let target = match path.is_empty() {
                true => page.clone(),
                false => within(folder, path),
            };
            let is_there = match pages.get(&target) {
                Some(text) => place.is_empty() || ids(text).contains(place),
                None => site.join(&target).is_file(),
            };
            if !is_there {
                wrong.push(format!("{}: {link}", page.display()));
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    Ok(wrong)
}

fn gather(site: &Path, folder: &Path, pages: &mut BTreeMap<PathBuf, String>) -> Result<()> {
    let there = site.join(folder);
    for entry in fs::read_dir(&there).with_context(|| format!("reading {}", there.display()))? {
        let entry = entry?;
        let path = folder.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            if path != Path::new(NOT_OURS) {
                gather(site, &path, pages)?;
            }
        } else if path.extension().is_some_and(|kind| kind == "html") {
            let text = fs::read_to_string(entry.path())
                .with_context(|| format!("reading {}", path.display()))?;
            pages.insert(path, text);
        }
    }
    Ok(())
}

/// The values of an attribute.
fn values<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    text.match_indices(name).filter_map(move |(at, _)| {
        let is_attribute = text[..at].ends_with(char::is_whitespace);
        let rest = text[at + name.len()..].strip_prefix("=\"")?;
        is_attribute.then(|| rest.split('"').next())?
    })
}

fn ids(text: &str) -> BTreeSet<&str> {
    values(text, "id").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_that_leads_nowhere_is_told_with_its_page() {
        let site = tempfile::tempdir().unwrap();
        let put = |path: &str, text: &str| {
            let file = site.path().join(path);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        put(
            "index.html",
            r##"<a href="docs/a.html#there">a</a> <a href="https://x/">x</a> <a href="#top">up</a> <h1 id="top">"##,
        );
        put(
            "docs/a.html",
            r#"<h2 id="there">a</h2> <img src="../p.svg"> <a href="../index.html">home</a>"#,
        );
        put("p.svg", "<svg/>");
        assert_eq!(check(site.path()).unwrap(), [""; 0]);
        put(
            "docs/b.html",
            r##"<a href="a.html#gone">a</a> <img src="q.svg"> <a href="c.html">c</a> data-id="x""##,
        );
        assert_eq!(
            check(site.path()).unwrap(),
            [
                "docs/b.html: a.html#gone",
                "docs/b.html: c.html",
                "docs/b.html: q.svg"
            ]
        );
    }
}
