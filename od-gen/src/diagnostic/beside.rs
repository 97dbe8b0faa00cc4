//! Allowances that stand beside a data sheet, so that a maker's file is never edited: in `NAME.allow.toml`, or on the command line.
//!
//! ```toml
//! [[allow]]
//! rules = ["configured-read-only", "sub-number"]
//! objects = ["1018h", "2000h-20FFh"] # the whole file without this key
//! because = "the maker's tool writes them"
//! ```

use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::files;
use crate::rules::{self, Rule};

/// A rule that is silenced from outside of the file.
#[derive(Clone, Debug)]
pub struct Exemption {
    pub(crate) rule: &'static Rule,
    /// The objects that it is for; all of the file where there are none.
    pub(crate) objects: Vec<RangeInclusive<u16>>,
    pub(crate) reason: String,
}

impl Exemption {
    /// A rule that whoever asks does not want to hear of.
    ///
    /// # Errors
    /// There is no such rule, or it cannot be silenced.
    pub fn of_rule(name: &str) -> Result<Self, String> {
        Ok(Self {
            rule: rule(name)?,
            objects: Vec::new(),
            reason: "it is asked for".into(),
        })
    }
}

fn rule(name: &str) -> Result<&'static Rule, String> {
    let rule = rules::find(name).ok_or_else(|| format!("there is no rule `{name}`"))?;
    let cannot = || format!("`{name}` cannot be silenced: nothing of the file can be read then");
    rule.can_be_allowed.then_some(rule).ok_or_else(cannot)
}

/// The file of allowances that belongs to a data sheet: `drive.allow.toml` for `drive.eds`.
pub fn allowances_beside(sheet: &Path) -> PathBuf {
    sheet.with_extension("allow.toml")
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    allow: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    rules: Vec<String>,
    #[serde(default)]
    objects: Vec<String>,
    because: String,
}

/// What is allowed beside a data sheet; nothing where there is no such file.
pub(crate) fn read(sheet: &Path) -> io::Result<Vec<Exemption>> {
    let file = allowances_beside(sheet);
    let wrong = |why: String| io::Error::other(format!("{}: {why}", file.display()));
    let text = match files::read_text(&file) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(wrong(error.to_string())),
    };
    parse(&text).map_err(wrong)
}

fn parse(text: &str) -> Result<Vec<Exemption>, String> {
    let file: File = toml::from_str(text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start));
        let line = before.map_or(1, |before| before.lines().count().max(1));
        format!("line {line}: {}", error.message())
    })?;
    let mut exemptions = Vec::new();
    for row in file.allow {
        if row.because.trim().is_empty() {
            return Err("an allowance has no reason: write because = \"...\"".into());
        }
        let objects = row.objects.iter().map(|text| objects(text));
        let objects = objects.collect::<Result<Vec<_>, _>>()?;
        for name in &row.rules {
            exemptions.push(Exemption {
                rule: rule(name)?,
                objects: objects.clone(),
                reason: row.because.clone(),
            });
        }
    }
    Ok(exemptions)
}

/// `2000h`, or `2000h-20FFh`.
fn objects(text: &str) -> Result<RangeInclusive<u16>, String> {
    let index = |text: &str| {
        let digits = text.trim().trim_end_matches(['h', 'H']);
        u16::from_str_radix(digits, 16)
    };
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (index(first), index(last)) {
        (Ok(first), Ok(last)) if first <= last => Ok(first..=last),
        _ => Err(format!(
            "`{text}` is not an object: write it as 2000h, or 2000h-20FFh"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_is_told() {
        let row = |rules: &str, objects: &str, why: &str| {
            format!("[[allow]]\nrules = [{rules}]\nobjects = [{objects}]\nbecause = \"{why}\"\n")
        };
        for (text, why) in [
            (
                row("\"sub-nmber\"", "", "x"),
                "there is no rule `sub-nmber`",
            ),
            (
                row("\"not-text\"", "", "x"),
                "`not-text` cannot be silenced",
            ),
            (
                row("\"sub-number\"", "\"20xx\"", "x"),
                "`20xx` is not an object",
            ),
            (
                row("\"sub-number\"", "\"2001h-2000h\"", "x"),
                "is not an object",
            ),
            (row("\"sub-number\"", "", " "), "has no reason"),
            ("[[allow]]\nrules = []\n".into(), "missing field `because`"),
            ("[[allow]\n".into(), "line 1: "),
        ] {
            let said = parse(&text).unwrap_err();
            assert!(said.contains(why), "{said}");
        }
        assert_eq!(
            parse(&row("\"sub-number\"", "\"2000h-20FFh\"", "x"))
                .unwrap()
                .len(),
            1
        );
    }
}
