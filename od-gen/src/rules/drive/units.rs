//! Rules: factors and units (CiA 402-2, the factor group).

use super::axes;
use crate::diagnostic::Findings;
use crate::rules::setting::Setting;
use crate::rules::{Rule, Subject};

pub(crate) const RULES: &[&Rule] = &[&ZERO_FACTOR, &OBSOLETE_UNIT, &UNIT, &POLARITY];

static ZERO_FACTOR: Rule = Rule::masters(
    "zero-factor",
    "Gear ratio, feed constant, encoder resolution and the other factors are not 0.",
    "Positions and velocities are multiplied and divided by them: 0 leaves no motion, or no result. When this is silenced, the \
     drive takes 1.",
).strict();

static OBSOLETE_UNIT: Rule = Rule::masters(
    "obsolete-unit",
    "Units are given by 60A8h to 60ABh, and factors by 608Fh to 6092h, 6096h and 6097h.",
    "The notation and dimension indices 6089h to 608Eh and the factors 6093h to 6095h are of the first version of CiA 402; newer \
     masters do not look at them.",
);

static UNIT: Rule = Rule::masters(
    "si-unit",
    "60A8h to 60ABh are units of CiA 303-2.",
    "Bits 24 to 31 are the prefix as a power of ten, bits 16 to 23 the numerator, bits 8 to 15 the denominator, and bits 0 to 7 \
     are 0.",
);

static POLARITY: Rule = Rule::masters(
    "polarity",
    "607Eh sets bits 6 and 7 at most.",
    "Bit 7 turns positions around, bit 6 velocities; the others are reserved.",
);

/// What is a divisor or a multiplier.
const FACTORS: [u16; 6] = [0x608F, 0x6090, 0x6091, 0x6092, 0x6096, 0x6097];
/// Of an acceleration ramp: the time it takes.
const RAMPS: [u16; 2] = [0x6048, 0x6049];

pub(crate) fn check(model: &Subject<'_>, findings: &mut Findings) {
    for axis in axes(model) {
        let factors = FACTORS
            .iter()
            .flat_map(|index| [(index + axis, 1), (index + axis, 2)]);
        let ramps = RAMPS.iter().map(|index| (index + axis, 2));
        for (index, sub) in factors.chain(ramps) {
            if let Some(factor) = Setting::at(model, index, sub).filter(|factor| factor.value == 0)
            {
                let message = format!("{index:04X}h:{sub:X} is 0");
                findings.report(&ZERO_FACTOR, factor.span, message);
            }
        }
        for object in [0x6089_u16..=0x608E, 0x6093..=0x6095]
            .into_iter()
            .flat_map(|range| model.objects_in(range.start() + axis..=range.end() + axis))
        {
            let message = format!("{:04X}h is obsolete", object.index);
            findings.report(&OBSOLETE_UNIT, object.places.section, message);
        }
        for index in 0x60A8 + axis..=0x60AB + axis {
            if let Some(unit) = Setting::at(model, index, 0).filter(|unit| unit.value & 0xFF != 0) {
                let message = format!(
                    "{index:04X}h is {:08X}h: bits 0 to 7 are reserved",
                    unit.value
                );
                findings.report(&UNIT, unit.span, message);
            }
        }
        let index = 0x607E + axis;
        if let Some(polarity) = Setting::at(model, index, 0)
            && polarity.value & 0x3F != 0
        {
            let message = format!(
                "{index:04X}h is {:02X}h: bits 0 to 5 are reserved",
                polarity.value
            );
            findings.report(&POLARITY, polarity.span, message);
        }
    }
}
