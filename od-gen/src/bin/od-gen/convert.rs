//! `od-gen convert`: a data sheet in another format.

use std::path::Path;
use std::process::ExitCode;

use od_gen::convert::{Format, convert};

use crate::Failure;
use crate::arguments::Convert;
use crate::{input, output};

pub(crate) fn run(arguments: &Convert) -> Result<ExitCode, Failure> {
    let Convert { input, output, .. } = arguments;
    let refuse = |file: &Path, why: &str| {
        Err(Failure::Refused(format!(
            "{}: error: {why}",
            file.display()
        )))
    };
    let extension = output.extension().and_then(|extension| extension.to_str());
    let Some(format) = extension.and_then(Format::of_extension) else {
        return refuse(output, "the extension is not .eds, .dcf, .xdd or .xdc");
    };
    let report = input::readable(input, &arguments.allow)?;
    let name = output.file_name().map(Path::new).unwrap_or(output);
    let name = name.display().to_string();
    let Some(converted) = convert(&report.model, format, &name) else {
        return refuse(
            input,
            "it is for no node: `od-gen dcf --node-id` makes it for one",
        );
    };
    for lost in &converted.lost {
        let name = output.display();
        output::tell(&format!(
            "{name}: warning: this format does not say: {lost}"
        ));
    }
    output::write(&converted.text, Some(output))?;
    Ok(ExitCode::SUCCESS)
}
