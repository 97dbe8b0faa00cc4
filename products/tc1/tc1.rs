//! What the TC1 does that is no data: its clock. 1013h counts microseconds; what a master writes there sets it.

use canopen::od::{Dictionary, Entry};
use cia402::Objects;
use cia402::behaviour::{Behaviour, View, number, put_number};

/// High resolution time stamp.
const CLOCK: u16 = 0x1013;

/// The module.
#[derive(Debug, Default)]
pub struct Module {
    /// What the clock has beyond the drive's own, modulo 2³².
    ahead: u32,
    shown: u32,
}

impl Behaviour for Module {
    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        if entry.index == CLOCK {
            let written = number(dictionary, CLOCK, 0) as u32;
            self.ahead = self.ahead.wrapping_add(written.wrapping_sub(self.shown));
        }
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        self.shown = (view.at.ticks() as u32).wrapping_add(self.ahead);
        put_number(dictionary, CLOCK, 0, self.shown.into());
    }

    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        *self = Self::default();
        let _ = dictionary;
    }
}
