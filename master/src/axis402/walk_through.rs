//! The commands that the walk-through of the documentation tells are commands.

use clap::Parser;

use super::arguments::CommandLine;

const PAGE: &str = include_str!("../../../docs/commissioning.md");

/// The words of a line as a shell would give them to the program: quotes hold words together, a remark ends it.
fn words(line: &str) -> Vec<&str> {
    let command = line.split(" #").next().unwrap_or_default();
    let parts = command.split('"').enumerate();
    let words = parts.flat_map(|(number, part)| match number % 2 {
        0 => part.split_whitespace().collect(),
        _ => vec![part],
    });
    words.collect()
}

#[test]
fn its_commands_are_understood() {
    let lines: Vec<_> = PAGE
        .lines()
        .filter(|line| line.starts_with("axis402 "))
        .collect();
    assert!(lines.len() > 5, "the page tells of axis402");
    for line in lines {
        if let Err(error) = CommandLine::try_parse_from(words(line)) {
            panic!("{line}: {error}");
        }
    }
}
