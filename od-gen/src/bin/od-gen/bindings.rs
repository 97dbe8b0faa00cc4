//! `od-gen bindings`: what of a data sheet stands for what of the drive.

use std::fmt::Write;
use std::process::ExitCode;

use cia402_parameters::{ALL, Direction};
use od_gen::bind;

use crate::Failure;
use crate::arguments::Bindings;
use crate::{input, output};

pub(crate) fn run(arguments: &Bindings) -> Result<ExitCode, Failure> {
    let model = input::model(&arguments.file, &arguments.allow)?;
    let bindings = input::bindings(&arguments.file, &model)?;
    let mut text = String::new();
    for parameter in ALL {
        let home = bind::home(&model, parameter).map(|_| parameter.home);
        let home = home.filter(|(index, _)| !bindings.is_foreign(*index));
        let own = bindings
            .rows
            .iter()
            .filter(|binding| binding.parameter == parameter);
        let mut objects: Vec<String> = own
            .clone()
            .map(|binding| object((binding.index, binding.sub)))
            .collect();
        let is_bound = own
            .clone()
            .any(|binding| Some((binding.index, binding.sub)) == home);
        objects.extend(home.filter(|_| !is_bound).map(object));
        let way = match parameter.direction {
            Direction::Taken => "<-",
            Direction::Shown => "->",
        };
        let objects = if let Some(number) = bindings.constant(parameter) {
            number.to_string()
        } else if objects.is_empty() {
            "-".into()
        } else {
            objects.join(", ")
        };
        let line = format!(
            "{:32} {:12} {way} {objects}",
            parameter.name, parameter.unit
        );
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{}", line.trim_end());
    }
    output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn object((index, sub): (u16, u8)) -> String {
    if sub == 0 {
        format!("{index:04X}h")
    } else {
        format!("{index:04X}h:{sub:X}")
    }
}
