//! `od-gen rust`: the dictionary as code.

use std::process::ExitCode;

use od_gen::Options;

use crate::Failure;
use crate::arguments::Rust;
use crate::{input, output};

pub(crate) fn run(arguments: &Rust) -> Result<ExitCode, Failure> {
    let model = input::model_for_code(&arguments.file, &arguments.allow)?;
    let cia402 = arguments.cia402;
    let bindings = input::bindings(&arguments.file, &model)?;
    let options = Options {
        cia402,
        bindings: &bindings,
        names: arguments.names,
        ..Options::DEVICE
    };
    let text = od_gen::generate(&model, options);
    output::write(&text, arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}
