//! What a file of bindings says, held against the data sheet and the drive.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use cia402_parameters::{self as parameters, Description, Direction, Parameter};
use toml::{Spanned, Value};

use super::file::{File, Row, place};
use super::place::{entry, indices, name};
use super::unbound::unbound;
use super::words;
use super::{Binding, Bindings, HABITS, Habit, Meaning, home};
use crate::data_type::DataType;
use crate::diagnostic::Findings;
use crate::model::{Access, DefaultValue, Entry, Model};
use crate::rules::binding;
use crate::source::Source;
use crate::spelling;

/// Offsets beyond this would leave no room for the number itself.
const LARGEST_OFFSET: i64 = 1 << 53;

/// All that the file says, and the objects of the manufacturer that stand for nothing.
pub(super) fn check(
    file: &File,
    source: &Source,
    model: &Model,
    findings: &mut Findings,
) -> (Bindings, Vec<u16>) {
    let foreign = ranges(&file.foreign.objects, source, findings);
    let mut bindings: Vec<Binding> = Vec::new();
    for row in &file.binding {
        let mut reader = Reader {
            row: row.get_ref(),
            source,
            model,
            foreign: &foreign,
            findings,
        };
        let Some(found) = reader.read() else {
            continue;
        };
        if bindings
            .iter()
            .any(|other| (other.index, other.sub) == (found.index, found.sub))
        {
            let span = place(source, row.get_ref().object.span());
            let message = format!("{} is bound already", name((found.index, found.sub)));
            findings.report(&binding::BOUND_TWICE, span, message);
        } else {
            bindings.push(found);
        }
    }
    let storage = ranges(&file.storage.objects, source, findings);
    let unbound = unbound(file, model, storage, findings);
    let bindings = Bindings {
        constants: numbers(&file.constants, source, &bindings, findings),
        unset: numbers(&file.unset, source, &[], findings),
        habits: habits(file, source, findings),
        axis: file.virtual_drive.axis.clone(),
        words: words::words(&file.word, source, model, findings),
        masks: words::masks(&file.mask, source, model, findings),
        errors: words::errors(&file.error, source, findings),
        rows: bindings,
        foreign,
    };
    (bindings, unbound)
}

/// Objects and ranges of them.
fn ranges(
    list: &[Spanned<String>],
    source: &Source,
    findings: &mut Findings,
) -> Vec<RangeInclusive<u16>> {
    let mut found = Vec::new();
    for item in list {
        match indices(item.get_ref()) {
            Some(range) => found.push(range),
            None => {
                let message = format!("`{}` is neither an object nor a range", item.get_ref());
                let span = place(source, item.span());
                let finding = findings.report(&binding::STORAGE, span, message);
                finding.help("write 2100h or 2100h-21FFh");
            }
        }
    }
    found
}

/// The tables `[constants]` and `[unset]`; no object in `bindings` stands for any of them.
fn numbers(
    table: &BTreeMap<Spanned<String>, Spanned<i64>>,
    source: &Source,
    bindings: &[Binding],
    findings: &mut Findings,
) -> Vec<(&'static Description, i64)> {
    let mut found = Vec::new();
    for (name, number) in table {
        let taken = parameters::ALL
            .iter()
            .find(|parameter| parameter.name == name.get_ref())
            .filter(|parameter| parameter.direction == Direction::Taken);
        let Some(parameter) = taken else {
            let message = format!("the drive takes no parameter `{}`", name.get_ref());
            findings.report(&binding::PARAMETER, place(source, name.span()), message);
            continue;
        };
        let (low, high) = parameter.range;
        let value = *number.get_ref();
        if !(low..=high).contains(&value) {
            let message = format!("{value} is not {} ({low} to {high})", parameter.name);
            findings.report(&binding::RANGE, place(source, number.span()), message);
        } else if bindings.iter().any(|row| row.parameter == parameter) {
            let message = format!("{} has an object that stands for it", parameter.name);
            findings.report(&binding::BOUND_TWICE, place(source, name.span()), message);
        } else {
            found.push((parameter, value));
        }
    }
    found
}

/// The table `[habits]`.
fn habits(file: &File, source: &Source, findings: &mut Findings) -> Vec<Habit> {
    let mut found = Vec::new();
    for (name, value) in &file.habits {
        let Some(known) = HABITS.iter().find(|known| known.name == name.get_ref()) else {
            let message = format!("the firmware has no habit `{}`", name.get_ref());
            let near = spelling::nearest(name.get_ref(), HABITS.iter().map(|known| known.name));
            let finding = findings.report(&binding::HABIT, place(source, name.span()), message);
            if let Some(near) = near {
                finding.help(format!("did you mean `{near}`?"));
            }
            continue;
        };
        match known.value(value.get_ref()) {
            Some(value) => found.push(Habit { known, value }),
            None => {
                let message = format!("{} is {}", known.name, known.wanted());
                findings.report(&binding::HABIT, place(source, value.span()), message);
            }
        }
    }
    found
}

/// One table `[[binding]]` and what it is held against.
struct Reader<'a> {
    row: &'a Row,
    source: &'a Source,
    model: &'a Model,
    /// Objects of the profile that do not mean what CiA 402 says.
    foreign: &'a [RangeInclusive<u16>],
    findings: &'a mut Findings,
}

impl Reader<'_> {
    fn read(&mut self) -> Option<Binding> {
        let object = self.object();
        let parameter = self.parameter();
        let ((index, sub), parameter) = (object?, parameter?);
        let model = self.model;
        let entry = model.entry(index, sub)?;
        if let Some(own) =
            Parameter::in_profile(index, sub).filter(|own| *own != parameter.parameter)
            && !self.foreign.iter().any(|range| range.contains(&index))
        {
            let home = parameters::ALL.iter().find(|other| other.parameter == own);
            let message = format!(
                "{} is {} in CiA 402",
                name((index, sub)),
                home.map_or("", |home| home.name)
            );
            self.report(
                &binding::BOUND_TWICE,
                &self.row.object,
                message,
                "bind another object, or list it in [foreign]",
            );
            return None;
        }
        if entry.is_with_application {
            let message = format!("{} is with the application", name((index, sub)));
            let help = "remove `;Memory=application` from the data sheet";
            self.report(&binding::OBJECT, &self.row.object, message, help);
            return None;
        }
        let (is_taken, is_shown) = self.access(entry, parameter)?;
        let meaning = self.meaning(entry, parameter, is_shown)?;
        let binding = Binding {
            index,
            sub,
            parameter,
            meaning,
            is_taken,
            is_shown,
        };
        self.default(entry, parameter, &binding)?;
        Some(binding)
    }

    fn object(&mut self) -> Option<(u16, u8)> {
        let text = self.row.object.get_ref();
        let Some((index, sub)) = entry(text) else {
            let message = format!("`{text}` is not an object");
            self.report(
                &binding::OBJECT,
                &self.row.object,
                message,
                "write it as 2054h or 2060h:1",
            );
            return None;
        };
        let model = self.model;
        let found = model.entry(index, sub).filter(|_| index >= 0x2000);
        let Some(found) = found else {
            let message = match model.object(index) {
                _ if index < 0x2000 => format!("{index:04X}h belongs to the communication"),
                Some(object) if object.object_type.has_subs() => {
                    format!("{index:04X}h has no sub-index {sub:X}h")
                }
                _ => format!("{} is not in the data sheet", name((index, sub))),
            };
            self.report(
                &binding::OBJECT,
                &self.row.object,
                message,
                "name a value of the data sheet",
            );
            return None;
        };
        if !is_integer(found.data_type) {
            let message = format!("{} is a {}", name((index, sub)), found.data_type.name());
            self.report(
                &binding::OBJECT_TYPE,
                &self.row.object,
                message,
                "bind an integer",
            );
            return None;
        }
        Some((index, sub))
    }

    fn parameter(&mut self) -> Option<&'static Description> {
        let text = self.row.parameter.get_ref();
        let found = parameters::ALL
            .iter()
            .find(|parameter| parameter.name == text);
        if found.is_none() {
            let names = parameters::ALL.iter().map(|parameter| parameter.name);
            let help = match spelling::nearest(text, names.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it offers {}", names.collect::<Vec<_>>().join(", ")),
            };
            let message = format!("the drive has no parameter `{text}`");
            self.report(&binding::PARAMETER, &self.row.parameter, message, &help);
        }
        found
    }

    /// Whether the object is taken, and whether it shows.
    fn access(&mut self, entry: &Entry, parameter: &Description) -> Option<(bool, bool)> {
        let object = self.row.object.get_ref();
        let (access, own) = (entry.access, entry.access.name());
        let is_writable = access.is_writable();
        if parameter.direction == Direction::Shown && (is_writable || access == Access::Constant) {
            let message = format!(
                "{object} is {own}, and the drive only shows {}",
                parameter.name
            );
            self.report(
                &binding::ACCESS,
                &self.row.object,
                message,
                "make it ro in the data sheet",
            );
            return None;
        }
        let wanted = self.row.access.as_ref();
        let wanted = match wanted.map(|access| access.get_ref().as_str()) {
            None if !is_writable => (false, access != Access::Constant),
            None => (true, access.is_readable()),
            Some("ro") if !is_writable && access != Access::Constant => (false, true),
            Some("wo") if is_writable => (true, false),
            Some("rw") if is_writable && access.is_readable() => (true, true),
            Some(text) => {
                let message = match text {
                    "ro" if is_writable => {
                        format!("{object} is {own}: what masters write would be lost")
                    }
                    "ro" | "wo" | "rw" => format!("{object} is {own} in the data sheet"),
                    _ => format!("access `{text}` is not ro, wo or rw"),
                };
                let place = self.row.access.as_ref()?;
                self.report(
                    &binding::ACCESS,
                    place,
                    message,
                    "leave it out: the data sheet says it",
                );
                return None;
            }
        };
        Some(wanted)
    }

    fn meaning(
        &mut self,
        entry: &Entry,
        parameter: &Description,
        is_shown: bool,
    ) -> Option<Meaning> {
        let Some(values) = &self.row.values else {
            let (numerator, denominator) = match &self.row.scale {
                Some(scale) => self.scale(scale)?,
                None => (1, 1),
            };
            let offset = self
                .row
                .offset
                .as_ref()
                .map_or(0, |offset| *offset.get_ref());
            if offset.unsigned_abs() > LARGEST_OFFSET.unsigned_abs() {
                let place = self.row.offset.as_ref()?;
                self.report(
                    &binding::SCALE,
                    place,
                    format!("the offset {offset} is too large"),
                    "",
                );
                return None;
            }
            return Some(Meaning::Scale {
                numerator,
                denominator,
                offset,
            });
        };
        if self.row.scale.is_some() || self.row.offset.is_some() {
            let message = "a list of values has no scale and no offset".into();
            self.report(&binding::SCALE, values, message, "leave them out");
            return None;
        }
        let mut pairs = Vec::new();
        for (from, to) in values.get_ref() {
            match from.parse::<i64>() {
                Ok(from) => pairs.push((from, *to)),
                Err(_) => {
                    let message = format!("`{from}` is not a decimal number");
                    self.report(&binding::VALUES, values, message, "write { 0 = 2, 1 = 6 }");
                    return None;
                }
            }
        }
        pairs.sort_unstable();
        let mistake = mistake_in(&pairs, entry, parameter, is_shown);
        if let Some(message) = mistake {
            self.report(&binding::VALUES, values, message, "");
            return None;
        }
        Some(Meaning::Values(pairs))
    }

    /// A whole number or a fraction of two.
    fn scale(&mut self, scale: &Spanned<Value>) -> Option<(i32, i32)> {
        let fraction = match scale.get_ref() {
            Value::Integer(number) => Some((*number, 1)),
            Value::String(text) => {
                let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
                let number = |text: &str| text.trim().parse::<i64>().ok();
                number(numerator).zip(number(denominator))
            }
            _ => None,
        };
        let fits = |number: i64| i32::try_from(number).ok().filter(|number| *number != 0);
        let found = fraction.and_then(|(numerator, denominator)| {
            Some((
                fits(numerator)?,
                fits(denominator).filter(|number| *number > 0)?,
            ))
        });
        if found.is_none() {
            let help = "write a whole number or a fraction of two, such as 10 or \"1/10\"; not 0";
            self.report(&binding::SCALE, scale, "this is not a scale".into(), help);
        }
        found
    }

    /// The default of an object that is taken means something to the drive; that of one that follows the object of CiA 402 is
    /// never seen.
    fn default(&mut self, entry: &Entry, parameter: &Description, binding: &Binding) -> Option<()> {
        let is_home = (binding.index, binding.sub) == parameter.home;
        let follows = binding.is_shown && !is_home && home(self.model, parameter).is_some();
        if parameter.direction == Direction::Shown || follows {
            return Some(());
        }
        let meaning = &binding.meaning;
        let DefaultValue::Number { value, .. } = entry.initial() else {
            return None;
        };
        let default = i64::try_from(value).unwrap_or(i64::MAX);
        let (low, high) = parameter.range;
        let number = meaning.to_parameter(default);
        if number.is_some_and(|number| (low..=high).contains(&number)) {
            return Some(());
        }
        let message = match number {
            Some(number) => format!(
                "the default {default} of {} is {number} for {}, which is {low} to {high}",
                self.row.object.get_ref(),
                parameter.name
            ),
            None => format!(
                "the default {default} of {} is not among the values",
                self.row.object.get_ref()
            ),
        };
        self.report(
            &binding::RANGE,
            &self.row.object,
            message,
            "give the object another default",
        );
        None
    }

    fn report<T>(
        &mut self,
        rule: &'static crate::rules::Rule,
        at: &Spanned<T>,
        message: String,
        help: &str,
    ) {
        let finding = self
            .findings
            .report(rule, place(self.source, at.span()), message);
        if !help.is_empty() {
            finding.help(help);
        }
    }
}

/// What is wrong with a sorted list of values.
fn mistake_in(
    pairs: &[(i64, i64)],
    entry: &Entry,
    parameter: &Description,
    is_shown: bool,
) -> Option<String> {
    let (low, high) = entry.data_type.range()?;
    let mut shown = BTreeMap::new();
    for (from, to) in pairs {
        if !(low..=high).contains(&i128::from(*from)) {
            return Some(format!("{from} does not fit {}", entry.data_type.name()));
        }
        let (low, high) = parameter.range;
        if !(low..=high).contains(to) {
            return Some(format!("{to} is not {} ({low} to {high})", parameter.name));
        }
        if let Some(other) = shown.insert(to, from).filter(|_| is_shown) {
            return Some(format!(
                "{other} and {from} both mean {to}: which one is shown?"
            ));
        }
    }
    pairs.is_empty().then(|| "there are no values".into())
}

fn is_integer(data_type: DataType) -> bool {
    let is_time = matches!(data_type, DataType::TimeOfDay | DataType::TimeDifference);
    data_type.range().is_some() && !is_time
}
