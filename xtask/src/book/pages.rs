//! The chapters, gathered where mdBook finds them: the same folders as in the repository.

use std::fs;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, bail};

/// Copies the chapters of docs/SUMMARY.md, and the files that they link to, from the repository to the source of the book. What is
/// there already was made for it.
///
/// # Errors
/// When a chapter, or a file that is linked, is missing.
pub fn gather(root: &Path, source: &Path) -> Result<()> {
    let docs = Path::new("docs");
    let summary = read(&root.join("docs/SUMMARY.md"))?;
    let mut chapters = Vec::new();
    let mut moved = String::new();
    let mut done = 0;
    for link in targets(&summary) {
        let chapter = within(docs, &summary[link.clone()]);
        moved += &summary[done..link.start];
        moved += &chapter.to_string_lossy();
        done = link.end;
        chapters.push(chapter);
    }
    moved += &summary[done..];
    fs::write(source.join("SUMMARY.md"), moved)?;
    for chapter in &chapters {
        let place = source.join(chapter);
        let text = match place.exists() {
            true => read(&place)?,
            false => read(&root.join(chapter))?,
        };
        let text = follow(&text, chapter, &chapters, root, source)
            .with_context(|| format!("{}", chapter.display()))?;
        put(&place, text.as_bytes())?;
    }
    Ok(())
}

/// A chapter with the links as the book can have them.
fn follow(
    text: &str,
    chapter: &Path,
    chapters: &[PathBuf],
    root: &Path,
    source: &Path,
) -> Result<String> {
    let folder = chapter.parent().unwrap_or(Path::new(""));
    let mut made = String::new();
    let mut done = 0;
    for link in targets(text) {
        let target = &text[link.clone()];
        let path = target.split('#').next().unwrap_or_default();
        if path.is_empty() || target.contains(':') {
            continue;
        }
        let path = within(folder, path);
        if path.starts_with("api") {
            continue;
        }
        if chapters.contains(&path) {
            // mdBook makes the first page of a folder of a README, but leads nobody there.
            made += &text[done..link.start];
            made += &target.replacen("README.md", "index.html", 1);
            done = link.end;
            continue;
        }
        let original = root.join(&path);
        if original.is_file() {
            put(&source.join(&path), &fs::read(&original)?)?;
        } else if original.is_dir() {
            // The text of the link stays, without its brackets.
            let label = text[..link.start].rfind('[').unwrap_or(link.start);
            made += &text[done..label];
            made += &text[label + 1..link.start - 2];
            done = link.end + 1;
        } else {
            bail!("{target} is no file of the repository");
        }
    }
    made += &text[done..];
    Ok(made)
}

/// Where the targets of the links stand in a page: `[text](target)`, outside of code.
fn targets(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    let mut in_fence = false;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("```") {
            in_fence = !in_fence;
        } else if !in_fence {
            for (at, _) in line.match_indices("](") {
                let begin = at + 2;
                let is_code = line[..at].matches('`').count() % 2 == 1;
                if let Some(length) = line[begin..].find(')').filter(|_| !is_code) {
                    found.push(start + begin..start + begin + length);
                }
            }
        }
        start += line.len();
    }
    found
}

/// A relative path from a folder, without `..`.
pub fn within(folder: &Path, path: &str) -> PathBuf {
    let mut made = PathBuf::new();
    for part in folder.join(path).components() {
        match part {
            Component::ParentDir => {
                made.pop();
            }
            Component::Normal(name) => made.push(name),
            _ => {}
        }
    }
    made
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))
}

fn put(file: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = file.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(file, bytes).with_context(|| format!("writing {}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_outside_of_code() {
        let text = "See [units](units.md#factor) and `[no](link.md)`.\n```\n[no](code.md)\n```\n![p](../a.svg)\n";
        let found: Vec<&str> = targets(text).into_iter().map(|at| &text[at]).collect();
        assert_eq!(found, ["units.md#factor", "../a.svg"]);
        assert_eq!(
            within(Path::new("docs"), "../od-gen/README.md"),
            Path::new("od-gen/README.md")
        );
    }

    #[test]
    fn chapters_keep_their_places_files_come_along_and_folders_lose_their_link() {
        let (root, source) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let write = |path: &str, text: &str| put(&root.path().join(path), text.as_bytes()).unwrap();
        write(
            "docs/SUMMARY.md",
            "- [One](one.md)\n- [Two](../crate/README.md)\n",
        );
        write(
            "docs/one.md",
            "[two](../crate/README.md#x), [`code`](../crate), [file](../crate/a.rs)\n",
        );
        write("crate/README.md", "# Two\n");
        write("crate/a.rs", "// Rust\n");
        gather(root.path(), source.path()).unwrap();
        let made = |path: &str| read(&source.path().join(path)).unwrap();
        assert_eq!(
            made("SUMMARY.md"),
            "- [One](docs/one.md)\n- [Two](crate/README.md)\n"
        );
        assert_eq!(
            made("docs/one.md"),
            "[two](../crate/index.html#x), `code`, [file](../crate/a.rs)\n"
        );
        assert_eq!(made("crate/a.rs"), "// Rust\n");
        write("docs/one.md", "[gone](gone.md)");
        let source = tempfile::tempdir().unwrap();
        assert!(gather(root.path(), source.path()).is_err());
    }
}
