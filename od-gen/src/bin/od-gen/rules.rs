//! `od-gen rules`: the rules that data sheets are held to.

use std::fmt::Write;
use std::process::ExitCode;

use od_gen::{Rule, rules};
use serde_json::{Value, json};

use crate::Failure;
use crate::arguments::{ListFormat, Rules};
use crate::output;

pub(crate) fn run(arguments: &Rules) -> Result<ExitCode, Failure> {
    let mut asked = Vec::new();
    for name in &arguments.names {
        let rule = rules::find(name);
        asked.push(rule.ok_or_else(|| Failure::Refused(unknown(name)))?);
    }
    let text = match (arguments.format, asked.as_slice()) {
        (ListFormat::Text, []) => list(),
        (ListFormat::Text, asked) => {
            let explained: Vec<String> = asked.iter().copied().map(explain).collect();
            explained.join("\n")
        }
        (ListFormat::Json, []) => {
            format!("{:#}\n", Value::Array(rules::all().map(value).collect()))
        }
        (ListFormat::Json, asked) => {
            let values = asked.iter().copied().map(value).collect();
            format!("{:#}\n", Value::Array(values))
        }
    };
    output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Each rule on a line, below the title of its chapter.
fn list() -> String {
    let widest = rules::all().map(|rule| rule.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for chapter in rules::chapters() {
        let separator = if text.is_empty() { "" } else { "\n" };
        // Writing into memory does not fail.
        let _ = writeln!(text, "{separator}{}", chapter.title);
        for rule in chapter.rules {
            let (name, severity) = (rule.name, rule.severity);
            let _ = writeln!(text, "  {severity:7}  {name:widest$}  {}", rule.summary);
        }
    }
    text
}

fn explain(rule: &Rule) -> String {
    let silenced = if rule.can_be_allowed {
        format!(
            "Silence it with `;od-gen: allow {} because REASON`.",
            rule.name
        )
    } else {
        "It cannot be silenced.".into()
    };
    let explanation = wrapped(rule.explanation);
    format!(
        "{}[{}]: {}\n\n{explanation}\n\n{silenced}\n",
        rule.severity, rule.name, rule.summary
    )
}

/// Lines of at most 80 characters.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 80 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines.join("\n")
}

fn value(rule: &Rule) -> Value {
    json!({
        "name": rule.name,
        "severity": rule.severity.to_string(),
        "can_be_allowed": rule.can_be_allowed,
        "summary": rule.summary,
        "explanation": rule.explanation,
    })
}

/// What is said about a name that no rule has, with the rule that was perhaps meant.
fn unknown(name: &str) -> String {
    let near = rules::all()
        .map(|rule| (strsim::levenshtein(name, rule.name), rule.name))
        .min()
        .filter(|(distance, _)| *distance <= 2 + name.len() / 4);
    let advice = match near {
        Some((_, near)) => format!("did you mean `{near}`?"),
        None => "`od-gen rules` lists them".into(),
    };
    format!("error: there is no rule `{name}`: {advice}")
}
