//! What is held of the documents themselves.

use std::path::Path;

/// A row of a table that is longer is an essay, in characters.
const LONGEST_ROW: usize = 700;

#[test]
fn no_row_of_the_decisions_is_an_essay() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/decisions.md");
    let text = std::fs::read_to_string(file).unwrap();
    let rows: Vec<_> = text.lines().filter(|line| line.starts_with('|')).collect();
    assert!(rows.len() > 50, "the decisions are a table");
    for row in rows {
        let length = row.chars().count();
        assert!(length <= LONGEST_ROW, "{length} characters: {row}");
    }
}
