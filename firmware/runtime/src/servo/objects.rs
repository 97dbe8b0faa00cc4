//! Between the objects of a servo and its loops: gains and data of the motor, orders to measure it, and what was found.

use canopen::od::{self, Dictionary};
use cia402::RatedMotor;

use super::{Found, Request, ServoSettings, StepperSettings};

/// What was seen and shown last.
#[derive(Debug, Default)]
pub struct ServoObjects {
    command: u8,
    found: Option<Found>,
}

impl ServoObjects {
    /// What masters have set, and what they ask for if that is new.
    pub fn read<D: Dictionary>(&mut self, dictionary: &D) -> (ServoSettings, Option<Request>) {
        if od::find::<D>(0x20C4, 1).is_err() {
            // A product: its module says it.
            return (ServoSettings::NONE, None);
        }
        let byte = |index, sub| od::read_u8(dictionary, index, sub).unwrap_or(0);
        let word = |index, sub| od::read_u16(dictionary, index, sub).unwrap_or(0);
        let long = |index, sub| od::read_u32(dictionary, index, sub).unwrap_or(0);
        let settings = ServoSettings {
            motor: [1, 2, 3, 4, 5, 6].map(|sub| long(0x20C2, sub)),
            weakening: long(0x20C2, 7),
            gains: [word(0x60F9, 1), word(0x60F9, 2), word(0x60FB, 1)],
            share: word(0x60F6, 1),
            filters: [1, 2, 3, 4].map(|sub| word(0x20C3, sub)),
            stepper: StepperSettings {
                mode: byte(0x20C4, 1),
                bound: word(0x20C4, 2),
                speed: word(0x20C4, 3),
                current: word(0x20C4, 4),
                at_rest: word(0x20C4, 5),
                fall: word(0x20C4, 6),
                is_at_once: false,
            },
            blocked: (word(0x20C5, 1), word(0x20C5, 2)),
            ..ServoSettings::NONE
        };
        let command = byte(0x20C0, 1);
        if command == core::mem::replace(&mut self.command, command) {
            return (settings, None);
        }
        // Told anew, though it may end as the one before.
        self.found = None;
        let request = match command {
            1 => Request::Motor {
                current: word(0x20C0, 2),
                distance: word(0x20C0, 3),
                bandwidth: word(0x20C0, 4),
            },
            2 => Request::Chirp {
                torque: word(0x20C0, 5),
                frequencies: (word(0x20C0, 6), word(0x20C0, 7)),
                time: word(0x20C0, 8),
                distance: word(0x20C0, 3),
            },
            _ => Request::End,
        };
        (settings, Some(request))
    }

    /// Shows the lead of a stepper's field, in hundredths of a full step.
    pub fn show_lead<D: Dictionary>(dictionary: &mut D, lead: u16) {
        od::write_u16(dictionary, 0x20C4, 7, lead);
    }

    /// Shows the rated current and torque of the motor, unless a master has given others.
    pub fn show_rated<D: Dictionary>(dictionary: &mut D, motor: RatedMotor) {
        for (index, own) in [(0x6075, motor.current), (0x6076, motor.torque)] {
            if od::read_u32(dictionary, index, 0) == Some(0) {
                od::write_u32(dictionary, index, 0, own);
            }
        }
    }

    /// Shows what was found, if that is not what was shown last. A command that has ended is none any more, so that the next one can be the same.
    pub fn show<D: Dictionary>(&mut self, dictionary: &mut D, found: &Found) {
        const RESULT: u16 = 0x20C1;
        if self.found.replace(*found) == Some(*found) {
            return;
        }
        if found.has_ended() {
            od::write_u8(dictionary, 0x20C0, 1, 0);
            self.command = 0;
        }
        od::write_u8(dictionary, RESULT, 1, found.state);
        od::write_u8(dictionary, RESULT, 2, found.failure);
        for (sub, value) in (3..).zip(found.winding) {
            od::write_u32(dictionary, RESULT, sub, value);
        }
        od::write_u16(dictionary, RESULT, 7, found.pole_pairs);
        od::write_u8(dictionary, RESULT, 8, found.direction.cast_unsigned());
        od::write_u16(dictionary, RESULT, 9, found.angle);
        for (sub, value) in (10..).zip(found.loads) {
            od::write_u32(dictionary, RESULT, sub, value);
        }
        for (sub, value) in (12..).zip(found.gains) {
            od::write_u16(dictionary, RESULT, sub, value);
        }
    }
}
