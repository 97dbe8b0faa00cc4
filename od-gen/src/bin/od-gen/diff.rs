//! `od-gen diff`: what two data sheets mean differently. Exit codes as those of `diff`: 0 for nothing, 1 for something, 2 when
//! they cannot be compared.

use std::process::ExitCode;

use od_gen::diff::{Change, Difference};
use serde_json::{Value, json};

use crate::Failure;
use crate::arguments::{Diff, ListFormat};
use crate::{input, output};

pub(crate) fn run(arguments: &Diff) -> Result<ExitCode, Failure> {
    let mut models = Vec::new();
    for file in [&arguments.before, &arguments.after] {
        match input::readable(file, &arguments.allow) {
            Ok(report) => models.push(report.model),
            Err(Failure::Findings) => return Ok(ExitCode::from(2)),
            Err(failure) => return Err(failure),
        }
    }
    let [before, after] = models.as_slice() else {
        return Ok(ExitCode::SUCCESS);
    };
    let differences = od_gen::diff::diff(before, after);
    match arguments.format {
        ListFormat::Text => {
            let lines = differences
                .iter()
                .map(|difference| format!("{difference}\n"));
            output::print(&lines.collect::<String>())?;
        }
        ListFormat::Json => {
            let values = differences.iter().map(value).collect();
            output::print(&format!("{:#}\n", Value::Array(values)))?;
        }
    }
    Ok(if differences.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn value(difference: &Difference) -> Value {
    let (key, before, after) = match &difference.change {
        Change::Added(what) => (None, None, Some(what)),
        Change::Removed(what) => (None, Some(what), None),
        Change::Changed { key, before, after } => (Some(*key), Some(before), Some(after)),
    };
    json!({
        "place": difference.place.to_string(),
        "key": key,
        "before": before,
        "after": after,
        "breaks": difference.breaks,
    })
}
