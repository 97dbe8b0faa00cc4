//! `od-gen dcf`: the configuration of one device.

use std::path::Path;
use std::process::ExitCode;

use od_gen::dcf::{self, Values};
use od_gen::model::{Commissioning, FileKind};
use od_gen::{Diagnostic, Report, Severity};

use crate::Failure;
use crate::arguments::Dcf;
use crate::{input, output};

pub(crate) fn run(arguments: &Dcf) -> Result<ExitCode, Failure> {
    let input = input::readable(&arguments.file, &arguments.allow)?;
    let mut model = input.model.clone();
    let node = node(arguments, model.commissioning.take())?;
    let file = name(arguments);
    dcf::commission(&mut model, node, &file);

    let mut values = Vec::new();
    for file in &arguments.values {
        values.push(Values::read(file).map_err(|error| input::unreadable(file, &error))?);
    }
    values.push(Values::new("--set", &arguments.set.join("\n")));
    let mut is_wrong = false;
    for values in &values {
        for finding in dcf::apply(&mut model, values) {
            is_wrong |= finding.severity == Severity::Error;
            output::tell(&od_gen::render(
                &finding,
                values.source(),
                output::colour_of_errors(),
            ));
        }
    }
    if is_wrong {
        return Ok(ExitCode::FAILURE);
    }

    // What each value is on its own may be wrong for all of them together, such as one COB-ID twice.
    let text = with_silence(od_gen::print(&model), &file, &input);
    let mut report = Report::new(&file, &text);
    report.findings.retain(|finding| !is_in(&input, finding));
    if report.has_errors() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
        // Of a data sheet alone it is the maker's, and told; what is asked for is refused.
        let is_asked_for = !(arguments.set.is_empty() && arguments.values.is_empty());
        if is_asked_for {
            return Ok(ExitCode::FAILURE);
        }
    }
    // A line break or a ` ;` ends a value for who reads it.
    let differences = od_gen::diff::diff(&model, &report.model);
    if let Some(difference) = differences.first() {
        let line = format!("{file}: error: a DCF cannot say this: {difference}");
        return Err(Failure::Refused(line.replace(['\n', '\r'], " ")));
    }
    output::write(&text, arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

/// The node that is asked for; what is not asked for stays as the file has it.
fn node(arguments: &Dcf, before: Option<Commissioning>) -> Result<Commissioning, Failure> {
    let node_id = before.as_ref().map(|node| node.node_id);
    let node_id = node_id.filter(|node_id| *node_id != 0);
    let Some(node_id) = arguments.node_id.or(node_id) else {
        let file = arguments.file.display();
        let line = format!("{file}: error: it is for no node: --node-id says for which");
        return Err(Failure::Refused(line));
    };
    let before = before.unwrap_or_else(|| Commissioning {
        bit_rate: 125,
        ..Commissioning::default()
    });
    let text = |asked: &Option<String>, before: String| asked.clone().unwrap_or(before);
    Ok(Commissioning {
        node_id,
        node_name: text(&arguments.name, before.node_name),
        bit_rate: arguments.bit_rate.unwrap_or(before.bit_rate),
        net_number: arguments.network.unwrap_or(before.net_number),
        network_name: text(&arguments.network_name, before.network_name),
        is_manager: arguments.manager.unwrap_or(before.is_manager),
        serial_number: arguments.serial_number.or(before.serial_number),
    })
}

/// Whether the data sheet has the same finding: it has been shown.
fn is_in(input: &Report, finding: &Diagnostic) -> bool {
    input.findings.iter().any(|own| own.says_what(finding))
}

/// What a device description in XML silences for a whole object, a DCF silences in the section that it is found in.
fn with_silence(text: String, file: &str, input: &Report) -> String {
    if input.model.kind != FileKind::Xdd {
        return text;
    }
    let report = Report::new(file, &text);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let is_section = |line: &String| line.starts_with('[');
    // From the last line to the first, so that the numbers of the lines above stay what they are.
    for finding in report.findings.iter().rev() {
        let Some(line) = (finding.span.line as usize).checked_sub(1) else {
            continue;
        };
        let place = section_of(&report, finding);
        let is_it = |(own, _): &&(Diagnostic, String)| {
            own.rule == finding.rule && section_of(input, own) == place
        };
        let silenced = input.silenced.iter().find(is_it);
        if let Some((_, reason)) = silenced {
            let above = lines.iter().take(line + 1).rposition(is_section);
            let allowance = format!(";od-gen: allow {} because {reason}", finding.rule.name);
            lines.insert(above.map_or(0, |section| section + 1), allowance);
        } else if finding.rule.name == "unused-allowance" && line < lines.len() {
            lines.remove(line);
        }
    }
    lines.join("\n") + "\n"
}

/// The object or the value whose section a finding is in.
fn section_of(report: &Report, finding: &Diagnostic) -> Option<(u16, Option<u8>)> {
    let objects = report.model.objects.iter();
    let objects = objects.map(|object| (object.places.section.line, (object.index, None)));
    let entries = report.model.entries().map(|(object, entry)| {
        let sub = object.object_type.has_subs().then_some(entry.sub);
        (entry.places.section.line, (object.index, sub))
    });
    let above = objects
        .chain(entries)
        .filter(|(line, _)| *line <= finding.span.line);
    above.max_by_key(|(line, _)| *line).map(|(_, place)| place)
}

/// The name of the configuration: that of the output, or that of the data sheet with another ending.
fn name(arguments: &Dcf) -> String {
    let file = match &arguments.output {
        Some(output) => output.clone(),
        None => arguments.file.with_extension("dcf"),
    };
    let name = file.file_name().map(Path::new).unwrap_or(&file);
    name.display().to_string()
}
