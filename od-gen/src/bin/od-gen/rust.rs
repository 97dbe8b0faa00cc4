//! `od-gen rust`: the dictionary as code.

use std::process::ExitCode;

use od_gen::{Identity, Options};

use crate::Failure;
use crate::arguments::Rust;
use crate::{input, output};

pub(crate) fn run(arguments: &Rust) -> Result<ExitCode, Failure> {
    let mut report = input::report_for_code(&arguments.file, &arguments.allow)?;
    let identity = arguments.identity.iter();
    let identity = identity.fold(Identity::STATED, |all, own| all.with(*own));
    identity
        .set(&mut report.model)
        .map_err(|problem| Failure::Refused(format!("error: {problem}")))?;
    let model = &report.model;
    let cia402 = arguments.cia402;
    let bindings = input::bindings(&arguments.file, model)?;
    if cia402 {
        let misfits = od_gen::misfits(model, &bindings);
        for finding in &misfits {
            let colour = output::colour_of_errors();
            output::tell(&od_gen::render(finding, &report.source, colour));
        }
        if !misfits.is_empty() {
            return Err(Failure::Findings);
        }
    }
    let options = Options {
        cia402,
        bindings: &bindings,
        names: arguments.names,
        ..Options::DEVICE
    };
    let text = od_gen::generate(model, options);
    output::write(&text, arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}
