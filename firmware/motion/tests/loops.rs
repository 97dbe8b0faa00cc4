//! No loop of the crate is without a bound: a `while` and a `loop` count their iterations against one that stands beside them, and a `for` goes through
//! what has an end. Every other test, property and fuzz target then finds one iteration more (`src/iterations.rs`).

use std::fs;
use std::path::{Path, PathBuf};

/// What never ends, and what may not.
const ENDLESS: [&str; 6] = [
    ".cycle()",
    "repeat(",
    "repeat_with(",
    "from_fn(",
    "successors(",
    "..)",
];

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

/// The lines of code, without comments and without the tests at its end.
fn code(text: &str) -> Vec<&str> {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let lines = code.lines().map(str::trim);
    lines.filter(|line| !line.starts_with("//")).collect()
}

fn first_word(line: &str) -> &str {
    // A label, and what the loop is the value of.
    let line =
        line.split_once(": ").map_or(
            line,
            |(label, rest)| {
                if label.starts_with('\'') { rest } else { line }
            },
        );
    let line = line.rsplit_once(" = loop").map_or(line, |_| "loop");
    let end = line.find(|c: char| !c.is_alphanumeric() && c != '_');
    &line[..end.unwrap_or(line.len())]
}

/// What is wrong with the loops of a file: the line, and why.
fn unbounded(text: &str) -> Vec<String> {
    let lines = code(text);
    let mut found = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let behind = &lines[number..];
        let opens = behind.iter().position(|line| line.ends_with('{'));
        let (head, body) = behind.split_at(opens.map_or(behind.len(), |at| at + 1));
        match first_word(line) {
            "while" | "loop" => {
                let counts = body.first() == Some(&"iterations.count();");
                // Two loops that share a bound stand one behind the other.
                let bound = lines[..number]
                    .iter()
                    .rev()
                    .take(12)
                    .any(|line| line.starts_with("let mut iterations = Iterations::"));
                if !counts || !bound {
                    found.push((*line).to_owned());
                }
            }
            "for" => {
                let head = head.join(" ");
                let is_open = head.contains(".. {") || ENDLESS.iter().any(|it| head.contains(it));
                if head.contains(" in ") && is_open {
                    found.push((*line).to_owned());
                }
            }
            _ => {}
        }
    }
    found
}

#[test]
fn every_loop_has_a_bound_that_is_counted() {
    let mut all = Vec::new();
    files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut all);
    let mut loops = 0;
    for path in all {
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(unbounded(&text), [""; 0], "{}", path.display());
        loops += code(&text)
            .iter()
            .filter(|line| **line == "iterations.count();")
            .count();
    }
    assert!(loops > 10, "only {loops} loops were found");
}

#[test]
fn a_loop_without_a_bound_is_found() {
    for text in [
        "while left > 0 {\n    left -= 1;\n}",
        "loop {\n    step();\n}",
        "let most = loop {\n    step();\n}",
        "'outer: loop {\n    step();\n}",
        "while left > 0 {\n    iterations.count();\n}",
        "for n in 0.. {\n}",
        "for n in ring.iter().cycle() {\n}",
    ] {
        assert_eq!(unbounded(text).len(), 1, "{text}");
    }
    for text in [
        "let mut iterations = Iterations::at_most(2);\nwhile left > 0\n    && right > 0\n{\n    iterations.count();\n}",
        "for n in 0..MOST {\n}",
        "// while it lasts\n",
        "for record in &records {\n}",
    ] {
        assert_eq!(unbounded(text), [""; 0], "{text}");
    }
}
