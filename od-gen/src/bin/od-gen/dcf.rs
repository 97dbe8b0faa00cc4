//! `od-gen dcf`: the configuration of one device.

use std::path::Path;
use std::process::ExitCode;

use od_gen::dcf::{self, Values};
use od_gen::model::Commissioning;
use od_gen::{Diagnostic, Report, Severity};

use crate::Failure;
use crate::arguments::Dcf;
use crate::{input, output};

pub(crate) fn run(arguments: &Dcf) -> Result<ExitCode, Failure> {
    let mut model = input::model(&arguments.file)?;
    let node = Commissioning {
        node_id: arguments.node_id,
        node_name: arguments.name.clone(),
        bit_rate: arguments.bit_rate,
        net_number: arguments.network,
        network_name: arguments.network_name.clone(),
        is_manager: arguments.manager,
        serial_number: arguments.serial_number,
    };
    let file = name(arguments);
    dcf::commission(&mut model, node, &file);
    let before = Report::new(&file, &od_gen::print(&model));

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
    let text = od_gen::print(&model);
    let mut report = Report::new(&file, &text);
    report.findings.retain(|finding| is_new(finding, &before));
    if report.has_errors() {
        output::tell(report.render(output::colour_of_errors()).trim_end());
        return Ok(ExitCode::FAILURE);
    }
    output::write(&text, arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}

/// Whether a finding comes from the values: what the data sheet has without them, it was found to be usable with.
fn is_new(finding: &Diagnostic, before: &Report) -> bool {
    let is_same = |own: &Diagnostic| own.rule == finding.rule && own.message == finding.message;
    !before.findings.iter().any(is_same)
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
