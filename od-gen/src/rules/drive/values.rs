//! Rules: the defaults of a drive are ones that it can work with (CiA 402-2).

use std::ops::RangeInclusive;

use super::axes;
use super::objects::claimed_modes;
use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &OPTION_CODE,
    &CROSSED_LIMITS,
    &HOMING_METHOD,
    &INTERPOLATION_TIME,
    &VELOCITY_ABOVE_MAXIMUM,
];

static OPTION_CODE: Rule = Rule::masters(
    "option-code",
    "6007h and 605Ah to 605Eh hold options of CiA 402, or negative ones of the manufacturer.",
    "6007h: 0 to 3; 605Ah: 0 to 8; 605Bh and 605Ch: 0 and 1; 605Dh and 605Eh: 0 to 4. The others are reserved.",
).strict();

static CROSSED_LIMITS: Rule = Rule::masters(
    "crossed-limits",
    "Of a pair of limits, the lower one is not above the upper one.",
    "607Bh and 607Dh are position limits, 6046h limits of the velocity: with crossed limits no target is allowed.",
).strict();

static HOMING_METHOD: Rule = Rule::masters(
    "homing-method",
    "6098h is a homing method that exists, and that 60E3h lists.",
    "1 to 14, 17 to 30 and 33 to 37 are methods of CiA 402, 0 is none, negative ones are the manufacturer's.",
);

static INTERPOLATION_TIME: Rule = Rule::masters(
    "interpolation-time",
    "A drive with cyclic or interpolated modes has an interpolation time, 60C2h, that is not 0.",
    "Sub-index 1 times ten to the power of sub-index 2 is the time in seconds between two set-points; sub-index 2 is -128 to 63.",
);

static VELOCITY_ABOVE_MAXIMUM: Rule = Rule::warning(
    "velocity-above-maximum",
    "The profile velocity, 6081h, is not above the maximum, 607Fh.",
    "The drive would start with a limit in the way: statusword bit 11.",
);

/// Each option code with what CiA 402 has for it.
const OPTIONS: [(u16, RangeInclusive<i128>); 6] = [
    (0x6007, 0..=3),
    (0x605A, 0..=8),
    (0x605B, 0..=1),
    (0x605C, 0..=1),
    (0x605D, 0..=4),
    (0x605E, 0..=4),
];

/// Interpolated position, and the cyclic synchronous modes.
const CYCLIC: i128 = 0b111_1100_0000;

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for axis in axes(model) {
        for (index, options) in OPTIONS {
            let index = index + axis;
            if let Some(option) = Setting::at(model, index, 0)
                && option.value >= 0
                && !options.contains(&option.value)
            {
                let message = format!("{index:04X}h is the reserved option {}", option.value);
                let finding = findings.report(&OPTION_CODE, option.span, message);
                let (low, high) = options.into_inner();
                finding.help(format!("{low} to {high}, or negative"));
            }
        }
        for index in [0x6046 + axis, 0x607B + axis, 0x607D + axis] {
            let (low, high) = (Setting::at(model, index, 1), Setting::at(model, index, 2));
            if let (Some(low), Some(high)) = (low, high)
                && low.value > high.value
            {
                let message = format!(
                    "{index:04X}h:1 is {}, above {index:04X}h:2, {}",
                    low.value, high.value
                );
                let finding = findings.report(&CROSSED_LIMITS, low.span, message);
                finding.also(high.span, "the upper limit");
            }
        }
        check_homing(model, axis, findings);
        check_interpolation(model, axis, findings);
        if let Some(velocity) = Setting::at(model, 0x6081 + axis, 0)
            && let Some(most) = Setting::at(model, 0x607F + axis, 0)
            && velocity.value > most.value
        {
            let message = format!(
                "{:04X}h is {}, above {:04X}h, {}",
                0x6081 + axis,
                velocity.value,
                0x607F + axis,
                most.value
            );
            let finding = findings.report(&VELOCITY_ABOVE_MAXIMUM, velocity.span, message);
            finding.also(most.span, "the greatest velocity");
        }
    }
}

fn check_homing(model: &Subject<'_>, axis: u16, findings: &mut Findings) {
    let index = 0x6098 + axis;
    let Some(method) = Setting::at(model, index, 0) else {
        return;
    };
    let is_known = matches!(method.value, i128::MIN..=14 | 17..=30 | 33..=37);
    let listed = model
        .object(0x60E3 + axis)
        .into_iter()
        .flat_map(|object| &object.entries);
    let mut listed = listed
        .filter(|entry| entry.sub != 0)
        .filter_map(Setting::of);
    // A list without defaults says nothing.
    let has_list = listed.clone().any(|method| method.value != 0);
    let is_listed = !has_list || method.value == 0 || listed.any(|own| own.value == method.value);
    if !is_known {
        let message = format!("{index:04X}h is the reserved method {}", method.value);
        findings.report(&HOMING_METHOD, method.span, message);
    } else if !is_listed {
        let message = format!(
            "{index:04X}h is {}, which {:04X}h does not list",
            method.value,
            0x60E3 + axis
        );
        let finding = findings.report(&HOMING_METHOD, method.span, message);
        if let Some(list) = model.object(0x60E3 + axis) {
            finding.also(list.places.section, "the methods that are listed");
        }
    }
}

fn check_interpolation(model: &Subject<'_>, axis: u16, findings: &mut Findings) {
    let index = 0x60C2 + axis;
    let is_cyclic = claimed_modes(model, axis).is_some_and(|modes| modes & CYCLIC != 0);
    if let Some(time) = Setting::at(model, index, 1)
        && time.value == 0
        && is_cyclic
    {
        let message = format!("{index:04X}h:1 is 0: set-points would come without a pause");
        findings.report(&INTERPOLATION_TIME, time.span, message);
    }
    if let Some(power) = Setting::at(model, index, 2)
        && power.value > 63
    {
        let message = format!("{index:04X}h:2 is {}, above 63", power.value);
        findings.report(&INTERPOLATION_TIME, power.span, message);
    }
}
