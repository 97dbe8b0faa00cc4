//! How long the sources are.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::place;

/// Folders that hold no sources of ours.
const ELSEWHERE: [&str; 4] = ["target", ".git", "corpus", "artifacts"];

/// The lines of a crate's sources, its tests left aside.
///
/// # Errors
/// When a file cannot be read.
pub fn without_tests(crate_folder: &str) -> Result<u64> {
    let mut lines = 0;
    for file in sources(&place::root().join(crate_folder).join("src"))? {
        if !is_test(&file) {
            lines += product(&read(&file)?).count();
        }
    }
    Ok(lines as u64)
}

/// The files of the workspace that have more lines than this, and how many each has.
///
/// # Errors
/// When a file cannot be read.
pub fn files_above(most: usize) -> Result<Vec<(PathBuf, usize)>> {
    let root = place::root();
    let mut long = Vec::new();
    for file in sources(&root)? {
        let lines = read(&file)?.lines().count();
        if lines > most {
            let name = file.strip_prefix(&root).unwrap_or(&file);
            long.push((name.to_owned(), lines));
        }
    }
    long.sort();
    Ok(long)
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))
}

/// All Rust files below a folder.
fn sources(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).with_context(|| format!("reading {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() && !ELSEWHERE.contains(&&*name) {
            found.append(&mut sources(&path)?);
        } else if name.ends_with(".rs") {
            found.push(path);
        }
    }
    Ok(found)
}

/// Files that only a test build compiles, by their names.
fn is_test(file: &Path) -> bool {
    let mut parts = file.iter().filter_map(|part| part.to_str());
    parts.any(|part| ["tests", "tests.rs", "testing.rs", "vectors.rs"].contains(&part))
}

/// The lines of a file without its items for tests. They stand at the margin, and so does their last line.
fn product(text: &str) -> impl Iterator<Item = &str> {
    let mut in_test = false;
    text.lines().filter(move |line| {
        if line.starts_with("#[cfg(test)]") || line.starts_with("#[cfg(all(test") {
            in_test = true;
            return false;
        }
        let counts = !in_test;
        let ends = *line == "}" || (!line.starts_with([' ', '#']) && line.ends_with(';'));
        in_test &= !ends;
        counts
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_for_tests_are_no_lines_of_the_product() {
        let text = "\
//! A file.
mod plan;
#[cfg(test)]
mod vectors;

fn run() {
    plan::run();
}

#[cfg(test)]
#[path = \"more.rs\"]
mod more;
#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn runs() {
        run();
    }
}
";
        let lines: Vec<_> = product(text).collect();
        assert_eq!(
            lines,
            [
                "//! A file.",
                "mod plan;",
                "",
                "fn run() {",
                "    plan::run();",
                "}",
                ""
            ]
        );
        assert!(is_test(Path::new("src/plan/tests/smooth.rs")));
        assert!(!is_test(Path::new("src/plan/mod.rs")));
    }

    #[test]
    fn the_sources_of_this_program_are_found() {
        let own = without_tests("xtask").unwrap();
        assert!((1_000..10_000).contains(&own), "{own}");
    }
}
