//! `od-gen rules`: the rules that data sheets are held to.

use std::fmt::Write;
use std::process::ExitCode;

use od_gen::{Class, Rule, rules};
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
            let (name, class) = (rule.name, rule.class.name());
            let severity = severity(rule);
            let _ = writeln!(
                text,
                "  {severity:8}  {class:8}  {name:widest$}  {}",
                rule.summary
            );
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
    let broken = match rule.class {
        Class::Standard => "It is what CiA 306 and CiA 301 ask for",
        Class::Masters => "It is what masters and tools expect",
        Class::Firmware => "It is a limit of this firmware and its tools",
        Class::Advice => "It is advice",
    };
    let is_stricter = rule.severity != rule.severity_for_code;
    let code = if is_stricter {
        "; `od-gen rust` refuses a file that breaks it"
    } else {
        ""
    };
    format!(
        "{}[{}]: {}\n\n{explanation}\n\n{broken}{code}.\n{silenced}\n",
        rule.severity, rule.name, rule.summary
    )
}

/// How bad it is: the star stands for an error of `rust`.
fn severity(rule: &Rule) -> String {
    let is_stricter = rule.severity != rule.severity_for_code;
    format!("{}{}", rule.severity, if is_stricter { "*" } else { "" })
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
        "class": rule.class.name(),
        "severity": rule.severity.to_string(),
        "severity_for_code": rule.severity_for_code.to_string(),
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
