//! The four limits of the LMD (2020h): which are reached, and on which of them the drive acts.

use canopen::od::Dictionary;
use cia402::behaviour::{number, put_number};

/// Objects of our own that the drive reads: inputs of the positive and of the negative limit switch, software limits.
const SWITCHES: [u16; 2] = [0x5F05, 0x5F06];
const POSITIONS: [u16; 2] = [0x5F07, 0x5F08];

const FLAGS: u16 = 0x2020;
const DIGITAL: u16 = 0x60FD;

/// Bits 0 and 1 are the negative and the positive limit switch, here and in 60FDh.
const HARDWARE: u8 = 0b11;

/// How they are set up, and which are reached.
#[derive(Debug, Default)]
pub(super) struct Limits {
    mask: u8,
    /// Inputs of the negative and the positive limit switch, and those that are active while they are low.
    inputs: [u8; 2],
    inverted: u8,
    positions: [i32; 2],
    reached: u8,
}

impl Limits {
    pub(super) fn set_up<D: Dictionary>(&mut self, dictionary: &mut D) {
        let byte = |index, sub| number(dictionary, index, sub) as u8;
        self.mask = byte(FLAGS, 2);
        self.inputs = [byte(0x2002, 3), byte(0x2002, 2)];
        self.inverted = byte(0x2000, 4);
        self.positions = [1, 2].map(|sub| number(dictionary, 0x2022, sub) as i32);
        let acts = |bit: u8| self.mask & bit != 0;
        let of = |acts, inputs: u8| if acts { inputs.into() } else { 0 };
        let [negative, positive] = self.inputs;
        let [low, high] = self.positions;
        let values = [
            (SWITCHES, [of(acts(2), positive), of(acts(1), negative)]),
            (
                POSITIONS,
                [
                    if acts(4) { low.into() } else { i32::MIN.into() },
                    if acts(8) {
                        high.into()
                    } else {
                        i32::MAX.into()
                    },
                ],
            ),
        ];
        for (objects, values) in values {
            for (index, value) in objects.into_iter().zip(values) {
                put_number(dictionary, index, 0, value);
            }
        }
    }

    /// 60FDh as the drive has it, and where the motor is.
    pub(super) fn look(&mut self, digital: u32, position: i32) {
        let wires = (digital >> 16) as u8 ^ self.inverted;
        let [negative, positive] = self.inputs.map(|inputs| wires & inputs & 0x0F != 0);
        let [low, high] = self.positions;
        // Behind its filter, where the drive acts on it.
        let filtered = digital as u8 & self.mask & HARDWARE;
        let bare = u8::from(negative) | u8::from(positive) << 1;
        self.reached = filtered
            | bare & !self.mask
            | u8::from(position <= low) << 2
            | u8::from(position >= high) << 3;
    }

    /// Whether one is reached.
    pub(super) const fn is_any(&self) -> bool {
        self.reached != 0
    }

    pub(super) fn show<D: Dictionary>(&self, dictionary: &mut D) {
        put_number(dictionary, FLAGS, 1, self.reached.into());
        let bare = self.reached & !self.mask & HARDWARE;
        if bare != 0 {
            let word = number(dictionary, DIGITAL, 0);
            put_number(dictionary, DIGITAL, 0, word | i64::from(bare));
        }
    }
}
