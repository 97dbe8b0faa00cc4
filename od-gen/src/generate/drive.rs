//! The CiA 402 objects as the firmware sees them: an implementation of `cia402::Objects`.
//!
//! Each method has the type of the data sheet, so a data sheet that disagrees with the firmware does not compile. Objects the
//! data sheet leaves out keep the trait's own answer. Bindings put other objects in their place or beside them: the first
//! that can be written is what the drive reads, unless the object of CiA 402 itself is there; the others follow it.

use cia402_parameters::{self as parameters, Description, Direction, Features, Parameter};

use super::accessors::{is_narrow, value_type};
use super::documentation::title;
use super::layout::{Layout, Place, Row};
use super::sites::{Site, sites};
use super::{ABORT_CODE, Options, bindings, habits};
use crate::bind::{Bindings, Fact, Mask, Word};

/// Converts between the numbers of the dictionary, which have different types.
const NUMBER: &str = "::cia402::binding::Number";

/// What switches the scope on; it is no parameter.
const SCOPE: (u16, u8) = (0x20D0, 1);

pub(super) fn write(layout: &Layout<'_>, options: &Options<'_>) -> String {
    let (bound, behaviour) = (options.bindings, options.behaviour);
    let all: Vec<(&Description, Vec<Site<'_>>)> = parameters::ALL
        .iter()
        .map(|parameter| (parameter, sites(layout, bound, parameter)))
        .collect();
    let mut methods = vec![
        behaves(behaviour),
        features(layout, &all, bound, behaviour.is_some()),
    ];
    methods.extend(options.data_sheet.map(data_sheet));
    let habits = habits::of_drive(&bound.habits);
    methods.extend((!habits.is_empty()).then_some(habits));
    for (parameter, sites) in &all {
        if let Some(method) = masked(layout, bound, parameter) {
            methods.push(method);
            continue;
        }
        if let Some(number) = bound.constant(parameter) {
            methods.push(constant(parameter, number));
            continue;
        }
        let Some(home) = sites.first() else {
            continue;
        };
        methods.push(match parameter.direction {
            Direction::Taken => getter(parameter, home, bound.unset(parameter)),
            Direction::Shown => setter(parameter, sites),
        });
    }
    let elsewhere = |(parameter, sites): &(&Description, Vec<Site<'_>>)| {
        sites.iter().any(|site| !site.is_in_profile(parameter))
    };
    let foreign = foreign(layout, bound);
    if all.iter().any(elsewhere) || !foreign.is_empty() || !bound.masks.is_empty() {
        methods.push(parameter(&all, &foreign, &bound.masks));
    }
    methods.extend(converted(&all, bound));
    methods.extend(words(layout, &bound.words));
    let bound = &bound.rows;
    if !bound.is_empty() {
        methods.extend(carry_over(&all));
        methods.extend(agree(&all));
    }
    let mut out = behaviour.map_or_else(String::new, module) + &bindings::write(&all);
    if !bound.is_empty() {
        // Calls within calls: one line each reads better than what rustfmt makes of them.
        out += "#[rustfmt::skip]\n";
    }
    out += &format!(
        "impl ::cia402::Objects for Dictionary {{\n{}}}\n\n",
        methods.join("\n")
    );
    out
}

/// What is no data: the module beside the data sheet.
fn module(path: &str) -> String {
    format!("#[path = {path:?}]\nmod behaviour;\n\n")
}

/// What a client of 1021h gets.
fn data_sheet(file: &str) -> String {
    format!(
        "    const DATA_SHEET: &'static [u8] = include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\"));\n"
    )
}

/// Where the drive finds it.
fn behaves(behaviour: Option<&str>) -> String {
    let module = behaviour.map_or("()", |_| "behaviour::Module");
    format!("    type Behaviour = {module};\n")
}

/// What the drive has of all that the firmware can do.
fn features(
    layout: &Layout<'_>,
    all: &[(&Description, Vec<Site<'_>>)],
    bound: &Bindings,
    has_module: bool,
) -> String {
    let modes = all
        .iter()
        .find(|(parameter, _)| parameter.parameter == Parameter::SupportedDriveModes)
        .and_then(|(parameter, sites)| {
            let told = || sites.first().map(Site::default);
            bound.constant(parameter).or_else(told)
        })
        .unwrap_or(0);
    let offered: Vec<Parameter> = all
        .iter()
        .filter(|(parameter, sites)| !sites.is_empty() || bound.constant(parameter).is_some())
        .map(|(parameter, _)| parameter.parameter)
        .collect();
    let scope = layout
        .row(SCOPE.0, SCOPE.1)
        .is_some_and(|row| row.object.name.starts_with("Scope"));
    let Features {
        modes,
        touch_probes,
        digital_outputs,
        analogue_input,
        motor_current,
        power_stage,
        scope,
        units,
        cubic_interpolation,
        positioning_options,
    } = Features::of(&offered, u32::try_from(modes).unwrap_or(0), scope);
    // A module commands them without an object.
    let positioning_options = positioning_options || has_module;
    format!(
        "    const DRIVE: ::cia402::Features = ::cia402::Features {{
        modes: {modes:#X},
        touch_probes: {touch_probes},
        digital_outputs: {digital_outputs},
        analogue_input: {analogue_input},
        motor_current: {motor_current},
        power_stage: {power_stage},
        scope: {scope},
        units: {units},
        cubic_interpolation: {cubic_interpolation},
        positioning_options: {positioning_options},
    }};\n"
    )
}

/// The function of an input or an output, if masks say it.
fn masked(layout: &Layout<'_>, bound: &Bindings, parameter: &Description) -> Option<String> {
    let (is_of_outputs, number) = match parameter.home {
        (0x2031, number) => (false, number),
        (0x2060, number) => (true, number),
        _ => return None,
    };
    let bit = 1_u32.checked_shl(u32::from(number.checked_sub(1)?))?;
    let mut body = String::new();
    for mask in &bound.masks {
        let row = layout.row(mask.index, mask.sub);
        if let Some(row) = row.filter(|_| mask.is_of_outputs == is_of_outputs) {
            body += &format!(
                "        if {NUMBER}::number(Self::{}(self)) & {bit} != 0 {{\n            \
                 return {};\n        }}\n",
                row.name, mask.function
            );
        }
    }
    if body.is_empty() {
        return None;
    }
    let otherwise = bound.constant(parameter).unwrap_or(0);
    let method = parameter.name;
    Some(format!(
        "    fn {method}(&self) -> u8 {{\n{body}        {otherwise}\n    }}\n"
    ))
}

/// A parameter that no object stands for.
fn constant(parameter: &Description, number: i64) -> String {
    let (method, of) = (parameter.name, parameter.number.name());
    format!("    fn {method}(&self) -> {of} {{\n        {number}\n    }}\n")
}

/// The homes of parameters in the drive profile that stand for nothing here.
fn foreign(layout: &Layout<'_>, bound: &Bindings) -> Vec<(u16, u8)> {
    let homes = parameters::ALL.iter().map(|parameter| parameter.home);
    let is_foreign = |(index, sub): &(u16, u8)| {
        let is_bound = bound
            .rows
            .iter()
            .any(|row| (row.index, row.sub) == (*index, *sub));
        bound.is_foreign(*index) && !is_bound && layout.row(*index, *sub).is_some()
    };
    homes.filter(is_foreign).collect()
}

fn getter(parameter: &Description, home: &Site<'_>, unset: Option<i64>) -> String {
    let (title, own, method) = (title(home.row), &home.row.name, parameter.name);
    let Some(module) = home.module() else {
        // Where the trait has another type, the compiler says so.
        let number = value_type(home.row.entry.data_type);
        let body = set_or(unset, format!("Self::{own}(self)"));
        return format!(
            "    // {title}.\n    fn {method}(&self) -> {number} {{\n        {body}\n    }}\n"
        );
    };
    let number = parameter.number.name();
    // Writes are checked, so that only the default is left for a number that means nothing.
    let default = home.default();
    let body = set_or(
        unset,
        format!("{NUMBER}::nearest(number.unwrap_or({default}))"),
    );
    format!(
        "    // {title}.\n    fn {method}(&self) -> {number} {{\n        \
         let number = {module}::to_parameter({NUMBER}::number(Self::{own}(self)));\n        \
         {body}\n    }}\n"
    )
}

/// A number that counts unless it is 0, which says nothing.
fn set_or(unset: Option<i64>, number: String) -> String {
    match unset {
        None => number,
        Some(unset) => format!(
            "match {number} {{\n            0 => {unset},\n            number => number,\n        }}"
        ),
    }
}

fn setter(parameter: &Description, sites: &[Site<'_>]) -> String {
    let method = parameter.name;
    let titles: Vec<String> = sites.iter().map(|site| title(site.row)).collect();
    let number = match sites.first().filter(|home| home.binding.is_none()) {
        Some(home) => value_type(home.row.entry.data_type),
        None => parameter.number.name(),
    };
    let mut out = format!(
        "    // {}.\n    fn set_{method}(&mut self, value: {number}) {{\n",
        titles.join("; ")
    );
    for site in sites {
        out += &match site.module() {
            None => format!("        Self::set_{}(self, value);\n", site.row.name),
            Some(_) => put(site, &format!("{NUMBER}::number(value)")),
        };
    }
    out + "    }\n"
}

/// Statements that give an object the number that shows `number` of the parameter, an expression of type `i64`.
fn put(site: &Site<'_>, number: &str) -> String {
    let own = &site.row.name;
    let set = |number: &str| {
        let data_type = site.row.entry.data_type;
        if is_narrow(data_type) {
            let (low, high) = data_type.range().unwrap_or_default();
            let own_type = value_type(data_type);
            format!("let _ = Self::set_{own}(self, {number}.clamp({low}, {high}) as {own_type});\n")
        } else {
            format!("Self::set_{own}(self, {NUMBER}::nearest({number}));\n")
        }
    };
    match site.module() {
        Some(module) => format!(
            "        if let Some(number) = {module}::to_object({number}) {{\n            {}        }}\n",
            set("number")
        ),
        None => format!("        {}", set(number)),
    }
}

/// Objects that are written for each parameter.
fn parameter(
    all: &[(&Description, Vec<Site<'_>>)],
    foreign: &[(u16, u8)],
    masks: &[Mask],
) -> String {
    let mut out = String::from(
        "    fn parameter(entry: &::canopen::od::Entry) -> Option<::cia402::Parameter> {\n        \
         use ::cia402::Parameter;\n        match (entry.index, entry.sub) {\n",
    );
    for (parameter, sites) in all {
        for site in sites.iter().filter(|site| !site.is_in_profile(parameter)) {
            out += &format!(
                "            {} => Some(Parameter::{:?}),\n",
                key(site.row),
                parameter.parameter
            );
        }
    }
    for mask in masks {
        // What has no rule of its own and is set up with the functions.
        let stands_for = if mask.is_of_outputs {
            Parameter::OutputsInverted
        } else {
            Parameter::InputsInverted
        };
        let (index, sub) = (mask.index, mask.sub);
        out += &format!("            (0x{index:04X}, {sub}) => Some(Parameter::{stands_for:?}),\n");
    }
    for (index, sub) in foreign {
        out += &format!("            (0x{index:04X}, {sub}) => None,\n");
    }
    out + "            (index, sub) => Parameter::in_profile(index, sub),\n        }\n    }\n"
}

/// What a number that is written means to the drive.
fn converted(all: &[(&Description, Vec<Site<'_>>)], bound: &Bindings) -> Option<String> {
    let mut arms = String::new();
    for (parameter, sites) in all {
        let home = sites.first();
        for site in sites {
            if let Some(unset) = bound.unset(parameter).filter(|_| site.binding.is_none()) {
                arms += &format!(
                    "            {} if number == 0 => Ok({unset}),\n",
                    key(site.row)
                );
            }
            let Some(module) = site.module().filter(|_| site.is_taken) else {
                continue;
            };
            let (mut low, mut high) = parameter.range;
            // What the drive reads keeps its own limits.
            if let Some(home) = home.filter(|home| home.binding.is_none()) {
                let (least, most) = home.row.entry.integer_limits();
                let narrow =
                    |limit: Option<i128>| limit.and_then(|limit| i64::try_from(limit).ok());
                low = low.max(narrow(least).unwrap_or(i64::MIN));
                high = high.min(narrow(most).unwrap_or(i64::MAX));
            }
            arms += &format!(
                "            {} => {{\n                \
                 ::cia402::binding::within({module}::to_parameter(number), {low}, {high})\n            }}\n",
                key(site.row)
            );
        }
    }
    if arms.is_empty() {
        return None;
    }
    Some(format!(
        "    fn converted(entry: &::canopen::od::Entry, number: i64) -> Result<i64, {ABORT_CODE}> {{\n        \
         match (entry.index, entry.sub) {{\n{arms}            _ => Ok(number),\n        }}\n    }}\n"
    ))
}

/// After a write to one of several objects of a parameter.
fn carry_over(all: &[(&Description, Vec<Site<'_>>)]) -> Option<String> {
    let mut arms = String::new();
    for (parameter, sites) in all {
        let Some((home, others)) = sites.split_first().filter(|(_, others)| !others.is_empty())
        else {
            continue;
        };
        if parameter.direction == Direction::Shown {
            continue;
        }
        for written in sites.iter().filter(|site| site.is_taken) {
            let mut body = String::new();
            if let Some(module) = written.module().filter(|_| written.key() != home.key()) {
                body += &format!(
                    "        let number = {module}::to_parameter({NUMBER}::number(Self::{}(self)));\n",
                    written.row.name
                );
                body +=
                    "        let Some(number) = number else {\n            return;\n        };\n";
                if matches!(home.row.place, Place::Ram(_)) {
                    body += &put(home, "number");
                }
            } else {
                body += &present(parameter);
            }
            let followers = others
                .iter()
                .filter(|site| site.is_shown && site.key() != written.key());
            body += &followers
                .map(|site| put(site, "number"))
                .collect::<String>();
            arms += &format!(
                "            {} => {{\n{}            }}\n",
                key(written.row),
                deeper(&body)
            );
        }
    }
    if arms.is_empty() {
        return None;
    }
    let allow = if arms.matches(" => {\n").count() == 1 {
        "    #[allow(clippy::single_match, reason = \"there could be more objects\")]\n"
    } else {
        ""
    };
    Some(format!(
        "{allow}    fn carry_over(&mut self, entry: &::canopen::od::Entry) {{\n        \
         match (entry.index, entry.sub) {{\n{arms}            _ => {{}}\n        }}\n    }}\n"
    ))
}

/// After values were loaded.
fn agree(all: &[(&Description, Vec<Site<'_>>)]) -> Option<String> {
    let mut body = String::new();
    for (parameter, sites) in all {
        if parameter.direction == Direction::Shown {
            continue;
        }
        let followers = sites.iter().skip(1).filter(|site| site.is_shown);
        let statements: String = followers.map(|site| put(site, "number")).collect();
        if !statements.is_empty() {
            body += &present(parameter);
            body += &statements;
        }
    }
    (!body.is_empty()).then(|| format!("    fn agree(&mut self) {{\n{body}    }}\n"))
}

/// The number of a parameter that the drive reads.
fn present(parameter: &Description) -> String {
    format!(
        "        let number = {NUMBER}::number(::cia402::Objects::{}(self));\n",
        parameter.name
    )
}

/// The words that are made of facts.
fn words(layout: &Layout<'_>, words: &[Word]) -> Option<String> {
    let mut errors: Vec<u16> = Vec::new();
    let mut body = String::new();
    for word in words {
        let Some(row) = layout.row(word.index, word.sub) else {
            continue;
        };
        if !matches!(row.place, Place::Ram(_)) {
            continue;
        }
        let data_type = row.entry.data_type;
        let own_type = value_type(data_type);
        let mut parts = Vec::new();
        for (bit, fact) in &word.facts {
            let number = match fact {
                Fact::Statusword => "u32::from(status.statusword)".to_owned(),
                Fact::StatusBit(bit) => format!("u32::from(status.statusword >> {bit} & 1)"),
                Fact::Input(bit) => format!("(status.inputs >> {bit} & 1)"),
                Fact::Power => "u32::from(status.has_power)".to_owned(),
                Fact::Referenced => "u32::from(status.is_referenced)".to_owned(),
                Fact::Moving => "u32::from(status.is_moving)".to_owned(),
                Fact::Standstill => "u32::from(!status.is_moving)".to_owned(),
                Fact::Mode(mode) => {
                    format!("u32::from(status.is_moving && status.mode == {mode})")
                }
                Fact::Error(code) => {
                    let place = errors.iter().position(|other| other == code);
                    let place = place.unwrap_or_else(|| {
                        errors.push(*code);
                        errors.len() - 1
                    });
                    format!("(status.errors >> {place} & 1)")
                }
                Fact::Always => "1".to_owned(),
            };
            parts.push(format!("{number} << {bit}"));
        }
        body += &format!(
            "        // {}.\n        let word: u32 = {};\n        Self::set_{}(self, word as {own_type});\n",
            title(row),
            if parts.is_empty() {
                "0".to_owned()
            } else {
                parts.join("\n            | ")
            },
            row.name
        );
    }
    let codes: Vec<String> = errors.iter().map(|code| format!("0x{code:04X}")).collect();
    (!body.is_empty()).then(|| {
        format!(
            "    const TOLD_ERRORS: &'static [u16] = &[{}];\n\n    \
             #[allow(clippy::unnecessary_cast, clippy::identity_op, reason = \"one text for all words\")]\n    \
             fn show_status(&mut self, status: &::cia402::DriveStatus) {{\n{body}    }}\n",
            codes.join(", ")
        )
    })
}

fn deeper(body: &str) -> String {
    body.lines()
        .map(|line| format!("        {line}\n"))
        .collect()
}

fn key(row: &Row<'_>) -> String {
    format!("(0x{:04X}, {})", row.object.index, row.entry.sub)
}
