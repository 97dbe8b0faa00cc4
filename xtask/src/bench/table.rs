//! The tables of `docs/benchmarks.md`: Markdown in which the first columns are measured, and the rest is a person's.
//!
//! A row is `| name | figure | ... | other columns |`. A new measurement replaces the figures and leaves the other
//! columns of the row as they are.

use anyhow::{Context, Result};

/// A name, and what was measured for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The first column.
    pub name: String,
    /// The columns after it.
    pub figures: Vec<u64>,
}

/// The rows of the first table after the line `heading`, with as many figures as `columns`.
///
/// # Errors
/// When there is no such heading, no table after it, or a figure that is no number.
pub fn read(document: &str, heading: &str, columns: usize) -> Result<Vec<Row>> {
    let lines: Vec<_> = document.lines().collect();
    let (_, start, end) = find(&lines, heading)?;
    lines[start..end]
        .iter()
        .map(|line| row(line, columns))
        .collect()
}

/// The document with `rows` in that table.
///
/// # Errors
/// When there is no such heading, or no table after it.
pub fn write(document: &str, heading: &str, rows: &[Row]) -> Result<String> {
    let lines: Vec<_> = document.lines().collect();
    let (header, start, end) = find(&lines, heading)?;
    let width = cells(lines[header]).len();
    let old: Vec<_> = lines[start..end].iter().map(|line| cells(line)).collect();

    let mut text: Vec<String> = lines[..start]
        .iter()
        .map(|line| (*line).to_owned())
        .collect();
    for row in rows {
        let mut new = vec![row.name.clone()];
        new.extend(row.figures.iter().map(u64::to_string));
        let kept = old
            .iter()
            .find(|cells| cells.first() == Some(&row.name.as_str()));
        for column in new.len()..width {
            new.push(
                kept.and_then(|cells| cells.get(column))
                    .copied()
                    .unwrap_or_default()
                    .to_owned(),
            );
        }
        text.push(format!("| {} |", new.join(" | ")));
    }
    text.extend(lines[end..].iter().map(|line| (*line).to_owned()));
    Ok(text.join("\n") + "\n")
}

/// The numbers of the lines of a table: its header, its first row, and the line after its last row.
fn find(lines: &[&str], heading: &str) -> Result<(usize, usize, usize)> {
    let at = lines
        .iter()
        .position(|line| line.trim() == heading)
        .with_context(|| format!("no heading `{heading}`"))?;
    let header = (at..lines.len())
        .find(|&line| lines[line].starts_with('|'))
        .with_context(|| format!("no table after `{heading}`"))?;
    // The line under the header is the rule.
    let start = (header + 2).min(lines.len());
    let end = (start..lines.len())
        .find(|&line| !lines[line].starts_with('|'))
        .unwrap_or(lines.len());
    Ok((header, start, end))
}

fn cells(line: &str) -> Vec<&str> {
    line.trim()
        .trim_matches('|')
        .split('|')
        .map(str::trim)
        .collect()
}

fn row(line: &str, columns: usize) -> Result<Row> {
    let cells = cells(line);
    let figures = cells.iter().skip(1).take(columns).map(|cell| cell.parse());
    Ok(Row {
        name: cells.first().copied().unwrap_or_default().to_owned(),
        figures: figures
            .collect::<Result<_, _>>()
            .with_context(|| format!("not a number in `{line}`"))?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = "\
# Costs

## Sizes
| crate | flash |
|---|---|
| canopen | 5 |

## Instructions
Some words.

| operation | here | others |
|---|---|---|
| heartbeat | 30 | 33 |
| gone | 1 | 2 |

The end.
";

    fn row(name: &str, figure: u64) -> Row {
        Row {
            name: name.to_owned(),
            figures: vec![figure],
        }
    }

    #[test]
    fn the_table_after_the_heading_is_read() {
        assert_eq!(
            read(DOCUMENT, "## Instructions", 1).unwrap(),
            [row("heartbeat", 30), row("gone", 1)]
        );
        assert_eq!(read(DOCUMENT, "## Sizes", 1).unwrap(), [row("canopen", 5)]);
    }

    #[test]
    fn figures_are_replaced_and_everything_else_is_kept() {
        let new = write(
            DOCUMENT,
            "## Instructions",
            &[row("idle", 7), row("heartbeat", 29)],
        )
        .unwrap();
        let expected = DOCUMENT.replace(
            "| heartbeat | 30 | 33 |\n| gone | 1 | 2 |",
            "| idle | 7 |  |\n| heartbeat | 29 | 33 |",
        );
        assert_eq!(new, expected);
    }

    #[test]
    fn a_missing_table_and_a_figure_that_is_none_are_errors() {
        assert!(read(DOCUMENT, "## Nothing", 1).is_err());
        assert!(read("## Empty\n", "## Empty", 1).is_err());
        assert!(read(DOCUMENT, "## Sizes", 1).is_ok());
        assert!(
            read(
                &DOCUMENT.replace("| 30 |", "| many |"),
                "## Instructions",
                1
            )
            .is_err()
        );
    }
}
