//! The tables of `docs/benchmarks.md`: Markdown in which the first columns are measured, and the rest is a person's.
//!
//! A row is `| name | figure | ... | other columns |`. A new measurement replaces the figures and leaves the other
//! columns of the row as they are.

use anyhow::{Context, Result};

/// A table of the document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Its heading, without the signs of Markdown.
    pub heading: String,
    /// What was measured.
    pub rows: Vec<Row>,
    /// By how much a figure may move and be the same.
    pub slack: u64,
}

/// A name, and what was measured for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// The first column.
    pub name: String,
    /// The columns after it.
    pub figures: Vec<u64>,
}

impl Row {
    /// A row.
    pub fn new(name: &str, figures: &[u64]) -> Self {
        Self {
            name: name.to_owned(),
            figures: figures.to_vec(),
        }
    }
}

/// The column with the figure that we aim at; the first figure is held against it.
const GOAL: &str = "goal";

/// What stands before a goal that a figure is not to be below.
const AT_LEAST: &str = "at least ";

/// The column that tells how far the goal is.
const MISSED: &str = "missed by";

/// The rows of the table under this heading, with as many figures as `columns`.
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

/// The document with these rows in their table, and how far each is from its goal.
///
/// # Errors
/// When there is no such heading, or no table after it.
pub fn write(document: &str, table: &Table) -> Result<String> {
    let lines: Vec<_> = document.lines().collect();
    let (header, start, end) = find(&lines, &table.heading)?;
    let titles = cells(lines[header]);
    let old: Vec<_> = lines[start..end].iter().map(|line| cells(line)).collect();

    let mut text: Vec<String> = lines[..start]
        .iter()
        .map(|line| (*line).to_owned())
        .collect();
    for row in &table.rows {
        let mut new = vec![row.name.clone()];
        new.extend(row.figures.iter().map(u64::to_string));
        let kept = old
            .iter()
            .find(|cells| cells.first() == Some(&row.name.as_str()));
        for column in new.len()..titles.len() {
            new.push(
                kept.and_then(|cells| cells.get(column))
                    .copied()
                    .unwrap_or_default()
                    .to_owned(),
            );
        }
        tell_missed(&titles, &mut new);
        text.push(format!("| {} |", new.join(" | ")));
    }
    text.extend(lines[end..].iter().map(|line| (*line).to_owned()));
    Ok(text.join("\n") + "\n")
}

/// Fills the column that tells how far the goal is. A goal is a number that the figure is not to be above, or `at least` and one that it
/// is not to be below.
fn tell_missed(titles: &[&str], cells: &mut [String]) {
    let column = |title| titles.iter().position(|other| *other == title);
    let (Some(goal), Some(missed)) = (column(GOAL), column(MISSED)) else {
        return;
    };
    let cell = |column: usize| cells.get(column).map_or("", String::as_str);
    let (figure, goal) = (cell(1), cell(goal));
    let least = goal.strip_prefix(AT_LEAST);
    let text = match (figure.parse::<u64>(), least.unwrap_or(goal).parse::<u64>()) {
        (Ok(now), Ok(goal)) if least.is_some() && now < goal => {
            format!("{} %", (goal - now) * 100 / goal)
        }
        (Ok(now), Ok(goal)) if least.is_none() && now > goal => (now - goal)
            .saturating_mul(100)
            .checked_div(goal)
            // Of a goal of 0 there is no share.
            .map_or_else(|| now.to_string(), |share| format!("{share} %")),
        _ => String::new(),
    };
    if let Some(cell) = cells.get_mut(missed) {
        *cell = text;
    }
}

/// The numbers of the lines of a table: its header, its first row, and the line after its last row.
fn find(lines: &[&str], heading: &str) -> Result<(usize, usize, usize)> {
    let at = lines
        .iter()
        .position(|line| line.starts_with('#') && line.trim_start_matches('#').trim() == heading)
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
    let figures = figures
        .collect::<Result<Vec<_>, _>>()
        .with_context(|| format!("not a number in `{line}`"))?;
    Ok(Row::new(
        cells.first().copied().unwrap_or_default(),
        &figures,
    ))
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

    fn table(heading: &str, rows: &[Row]) -> Table {
        Table {
            heading: heading.to_owned(),
            rows: rows.to_vec(),
            slack: 0,
        }
    }

    #[test]
    fn the_table_after_the_heading_is_read() {
        assert_eq!(
            read(DOCUMENT, "Instructions", 1).unwrap(),
            [Row::new("heartbeat", &[30]), Row::new("gone", &[1])]
        );
        assert_eq!(
            read(DOCUMENT, "Sizes", 1).unwrap(),
            [Row::new("canopen", &[5])]
        );
    }

    #[test]
    fn figures_are_replaced_and_everything_else_is_kept() {
        let rows = [Row::new("idle", &[7]), Row::new("heartbeat", &[29])];
        let new = write(DOCUMENT, &table("Instructions", &rows)).unwrap();
        let expected = DOCUMENT.replace(
            "| heartbeat | 30 | 33 |\n| gone | 1 | 2 |",
            "| idle | 7 |  |\n| heartbeat | 29 | 33 |",
        );
        assert_eq!(new, expected);
    }

    #[test]
    fn how_far_a_goal_is_stands_beside_it() {
        let document = "\
## Goals
| operation | here | goal | missed by |
|---|---|---|---|
| near | 1 | 100 | 7 % |
| far | 1 | 100 |  |
| free | 1 |  | 5 % |
";
        let rows = [
            Row::new("near", &[100]),
            Row::new("far", &[150]),
            Row::new("free", &[9]),
        ];
        let new = write(document, &table("Goals", &rows)).unwrap();
        let lines: Vec<_> = new.lines().skip(3).collect();
        assert_eq!(
            lines,
            [
                "| near | 100 | 100 |  |",
                "| far | 150 | 100 | 50 % |",
                "| free | 9 |  |  |"
            ]
        );
    }

    #[test]
    fn a_goal_may_be_nothing_or_the_least() {
        let document = "\
## Goals
| operation | here | goal | missed by |
|---|---|---|---|
| none | 0 | 0 |  |
| some | 0 | 0 |  |
| fast | 1 | at least 100 |  |
| slow | 1 | at least 100 |  |
";
        let rows = [
            Row::new("none", &[0]),
            Row::new("some", &[3]),
            Row::new("fast", &[100]),
            Row::new("slow", &[60]),
        ];
        let new = write(document, &table("Goals", &rows)).unwrap();
        let lines: Vec<_> = new.lines().skip(3).collect();
        assert_eq!(
            lines,
            [
                "| none | 0 | 0 |  |",
                "| some | 3 | 0 | 3 |",
                "| fast | 100 | at least 100 |  |",
                "| slow | 60 | at least 100 | 40 % |"
            ]
        );
    }

    #[test]
    fn a_missing_table_and_a_figure_that_is_none_are_errors() {
        assert!(read(DOCUMENT, "Nothing", 1).is_err());
        assert!(read("## Empty\n", "Empty", 1).is_err());
        assert!(read(DOCUMENT, "Sizes", 1).is_ok());
        let wrong = DOCUMENT.replace("| 30 |", "| many |");
        assert!(read(&wrong, "Instructions", 1).is_err());
    }
}
