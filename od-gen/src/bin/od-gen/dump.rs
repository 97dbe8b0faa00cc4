//! `od-gen dump`: the dictionary for other programs.

use std::process::ExitCode;

use crate::Failure;
use crate::arguments::Dump;
use crate::{input, output};

pub(crate) fn run(arguments: &Dump) -> Result<ExitCode, Failure> {
    let model = input::readable(&arguments.file, &arguments.allow)?.model;
    output::write(&od_gen::json(&model), arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}
