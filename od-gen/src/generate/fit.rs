//! Whether `cia402::Objects` can be implemented: code that does not compile is no answer.

use cia402_parameters::{ALL, Description, Direction};

use super::accessors::value_type;
use super::layout::Layout;
use super::sites::sites;
use crate::bind::Bindings;
use crate::diagnostic::{Diagnostic, Findings, Severity};
use crate::model::{Access, Field, Model};
use crate::rules::standard::check::{STANDARD_ACCESS, STANDARD_TYPE};

/// Objects of the drive that are no numbers of its types, or that it shows and nobody can set. With one of them no code is made that
/// implements `cia402::Objects`.
pub fn misfits(model: &Model, bindings: &Bindings) -> Vec<Diagnostic> {
    let layout = Layout::new(model);
    let mut findings = Findings::new(&model.file).for_code();
    for parameter in ALL {
        let sites = sites(&layout, bindings, parameter);
        let own = sites.iter().filter(|site| site.binding.is_none());
        for site in own {
            check(
                parameter,
                site.row.object.index,
                site.row.entry,
                &mut findings,
            );
        }
    }
    let mut findings = findings.into_sorted();
    for finding in &mut findings {
        finding.severity = Severity::Error;
    }
    findings
}

fn check(
    parameter: &Description,
    index: u16,
    entry: &crate::model::Entry,
    findings: &mut Findings,
) {
    let place = match entry.sub {
        0 => format!("{index:04X}h"),
        sub => format!("{index:04X}h:{sub:X}"),
    };
    let (name, should) = (parameter.name, parameter.number.name());
    if value_type(entry.data_type) != should {
        let is = entry.data_type.name();
        let message = format!("{place} is {is}, but {name} of the drive is {should}");
        let span = entry.places.of(Field::DataType);
        let finding = findings.report(&STANDARD_TYPE, span, message);
        finding.help("give it the type of CiA 402, or bind another object to it (NAME.bind.toml)");
    } else if parameter.direction == Direction::Shown && entry.access == Access::Constant {
        let message = format!("{place} is const, but the drive shows {name} there");
        let span = entry.places.of(Field::AccessType);
        let finding = findings.report(&STANDARD_ACCESS, span, message);
        finding.help("write `AccessType=ro`");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::parse;

    const DRIVE: &str = include_str!("../../tests/data/drive.eds");

    #[test]
    fn what_would_not_compile_is_told_at_its_line() {
        let said = |old: &str, new: &str| {
            let text = DRIVE.replacen(old, new, 1);
            assert_ne!(text, DRIVE);
            let found = misfits(&parse("drive.eds", &text).unwrap(), Bindings::NONE);
            let lines = found.iter().map(|finding| {
                let line = text.lines().nth(finding.span.line as usize - 1).unwrap();
                format!("{line}: {}", finding.message)
            });
            lines.collect::<Vec<_>>()
        };
        assert!(misfits(&parse("drive.eds", DRIVE).unwrap(), Bindings::NONE).is_empty());
        let name = "ParameterName=Control word\nDataType=0x0006";
        assert_eq!(
            said(name, "ParameterName=Control word\nDataType=0x0007"),
            ["DataType=0x0007: 6040h is UNSIGNED32, but controlword of the drive is u16"]
        );
        let name = "ParameterName=Status word\nDataType=0x0006\nAccessType=ro";
        assert_eq!(
            said(
                name,
                "ParameterName=Status word\nDataType=0x0006\nAccessType=const"
            ),
            ["AccessType=const: 6041h is const, but the drive shows statusword there"]
        );
    }
}
