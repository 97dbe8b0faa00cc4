//! `od-gen doc`: the dictionary reference.

use std::process::ExitCode;

use crate::Failure;
use crate::arguments::{Doc, DocFormat};
use crate::{input, output};

pub(crate) fn run(arguments: &Doc) -> Result<ExitCode, Failure> {
    let model = input::readable(&arguments.file, &arguments.allow)?.model;
    let text = match arguments.format {
        DocFormat::Html => od_gen::doc::html(&model),
        DocFormat::Markdown => od_gen::doc::markdown(&model),
    };
    output::write(&text, arguments.output.as_deref())?;
    Ok(ExitCode::SUCCESS)
}
