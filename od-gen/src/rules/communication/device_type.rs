//! Rules: the device type, 1000h, is that of the objects (CiA 301, 7.5.2.1).

use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[
    &PROFILE_WITHOUT_OBJECTS,
    &OBJECTS_WITHOUT_PROFILE,
    &MODULE_TYPE,
];

static PROFILE_WITHOUT_OBJECTS: Rule = Rule::warning(
    "profile-without-objects",
    "A device that claims a profile has objects of it.",
    "The low word of 1000h is the number of the device profile, 0192h for CiA 402; its objects are at 6000h to 9FFFh. A device \
     without a profile has 0 there.",
);

static OBJECTS_WITHOUT_PROFILE: Rule = Rule::masters(
    "objects-without-profile",
    "A device with objects of a profile says which one.",
    "Objects at 6000h to 9FFFh mean nothing without the number of their profile in the low word of 1000h. Objects of the \
     manufacturer are at 2000h to 5FFFh.",
);

static MODULE_TYPE: Rule = Rule::warning(
    "axis-device-type",
    "67FFh is the device type of the first axis, as in 1000h.",
    "A device with one profile says the same in both places; with several (1000h = FFFFFFFFh or its high word), 67FFh is the \
     first one's.",
);

/// Several profiles in one device: each module says its own.
const SEVERAL: i128 = 0xFFFF_FFFF;

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    let Some(device_type) = Setting::at(model, 0x1000, 0) else {
        return;
    };
    let profile = device_type.value & 0xFFFF;
    match model.objects_in(0x6000..=0x9FFF).first() {
        None if profile != 0 => {
            let message = format!("1000h claims CiA {profile}, but nothing is at 6000h to 9FFFh");
            findings.report(&PROFILE_WITHOUT_OBJECTS, device_type.span, message);
        }
        Some(object) if profile == 0 => {
            let message = format!(
                "1000h claims no profile, but {:04X}h belongs to one",
                object.index
            );
            let finding = findings.report(&OBJECTS_WITHOUT_PROFILE, device_type.span, message);
            finding.also(object.places.section, "the first of them");
        }
        _ => {}
    }
    if let Some(module) = Setting::at(model, 0x67FF, 0)
        && device_type.value != SEVERAL
        && module.value & 0xFFFF != profile
    {
        let message = format!(
            "67FFh is {:08X}h, but 1000h is {:08X}h",
            module.value, device_type.value
        );
        let finding = findings.report(&MODULE_TYPE, module.span, message);
        finding.also(device_type.span, "the device");
    }
}
