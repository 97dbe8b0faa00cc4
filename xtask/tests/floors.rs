//! In a crate that has floors no import runs upwards, and none in a circle: the floors are those of the tables in docs/design.md, "The floors of ...".

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The crates of the firmware that have floors.
const CRATES: [&str; 2] = ["canopen", "cia402"];

/// What is on no floor: what tests alone have.
const ASIDE: &str = "testing.rs";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn source(name: &str) -> PathBuf {
    root().join("firmware").join(name).join("src")
}

/// The floor of each file or folder at the top of `src`, the highest first.
fn floors(name: &str) -> BTreeMap<String, usize> {
    let design = fs::read_to_string(root().join("docs/design.md")).unwrap();
    let title = format!("## The floors of `{name}`");
    let (_, chapter) = design.split_once(&title).unwrap();
    let (chapter, _) = chapter.split_once("\n## ").unwrap();
    let rows = chapter.lines().filter(|line| line.starts_with('|')).skip(2);
    let mut floors = BTreeMap::new();
    for (floor, row) in rows.enumerate() {
        for name in row.split('`').skip(1).step_by(2) {
            let before = floors.insert(name.to_owned(), floor);
            assert_eq!(before, None, "{name} is on two floors");
        }
    }
    floors
}

/// The files of a folder and below, without those of tests.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_stem().is_some_and(|name| name == "tests") {
            continue;
        }
        if path.is_dir() {
            files(&path, found);
        } else {
            found.push(path);
        }
    }
}

/// The names at the top of `src` that a file imports.
fn imports(text: &str) -> BTreeSet<String> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code: String = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .map(|line| format!("{line}\n"))
        .collect();
    let name = |part: &str| -> String {
        let end = part.find(|c: char| !c.is_alphanumeric() && c != '_');
        part[..end.unwrap_or(part.len())].to_owned()
    };
    let imports: BTreeSet<_> = code.split("crate::").skip(1).map(name).collect();
    assert!(!imports.contains(""), "one file a line is imported");
    imports
}

/// What the root of a crate names again, and the file or folder that it lies in.
fn named_again(source: &Path) -> BTreeMap<String, String> {
    let root = fs::read_to_string(source.join("lib.rs")).unwrap();
    let uses = root
        .lines()
        .filter_map(|line| line.strip_prefix("pub use "));
    let pairs = uses.flat_map(|line| {
        let (file, names) = line.split_once("::").unwrap();
        let names = names.split(|c: char| !c.is_alphanumeric());
        names.map(|name| (name.to_owned(), file.to_owned()))
    });
    pairs.collect()
}

/// Each import from one file or folder at the top of `src` into another.
fn crossing(name: &str, floors: &BTreeMap<String, usize>) -> BTreeSet<(String, String)> {
    let source = source(name);
    let mut all = Vec::new();
    files(&source, &mut all);
    let mut crossing = BTreeSet::new();
    let again = named_again(&source);
    for path in all {
        let inside = path.strip_prefix(&source).unwrap();
        let first = inside.components().next().unwrap().as_os_str();
        let own = Path::new(first).file_stem().unwrap().to_str().unwrap();
        if own == "lib" || inside == Path::new(ASIDE) {
            continue;
        }
        assert!(floors.contains_key(own), "{own} is on no floor");
        let imports = imports(&fs::read_to_string(&path).unwrap()).into_iter();
        let imports = imports.map(|import| again.get(&import).cloned().unwrap_or(import));
        let others = imports.filter(|import| import != own && floors.contains_key(import));
        crossing.extend(others.map(|other| (own.to_owned(), other)));
    }
    crossing
}

#[test]
fn no_import_runs_upwards() {
    for name in CRATES {
        let floors = floors(name);
        let all = crossing(name, &floors);
        assert!(all.len() > floors.len(), "{name} has imports: {all:?}");
        let upwards = all
            .into_iter()
            .filter(|(from, to)| floors[to] < floors[from]);
        assert_eq!(upwards.collect::<Vec<_>>(), [], "{name}");
    }
}

#[test]
fn no_imports_run_in_a_circle() {
    for name in CRATES {
        let mut left = crossing(name, &floors(name));
        // Who imports from nobody is in no circle, and nobody is in one because of him.
        loop {
            let importing: BTreeSet<_> = left.iter().map(|(from, _)| from.clone()).collect();
            let before = left.len();
            left.retain(|(_, to)| importing.contains(to));
            if left.len() == before {
                break;
            }
        }
        assert_eq!(left, BTreeSet::new(), "{name}");
    }
}
