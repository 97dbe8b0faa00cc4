//! What the TC1 does that is no data: its clock. 1013h counts microseconds; what a master writes there sets it.

use canopen::od::Dictionary;
use cia402::Objects;
use cia402::behaviour::{Behaviour, View, number, put_number};

/// High resolution time stamp.
const CLOCK: u16 = 0x1013;

/// The module.
#[derive(Debug, Default)]
pub struct Module {
    /// What the clock has beyond the drive's own, modulo 2³².
    ahead: u32,
    shown: Option<u32>,
}

impl Behaviour for Module {
    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let own = view.at.ticks() as u32;
        let held = number(dictionary, CLOCK, 0) as u32;
        if let Some(shown) = self.shown.filter(|shown| *shown != held) {
            // Somebody has written it since, at about the time that was shown.
            self.ahead = held.wrapping_sub(shown.wrapping_sub(self.ahead));
        }
        let shown = own.wrapping_add(self.ahead);
        self.shown = Some(shown);
        put_number(dictionary, CLOCK, 0, shown.into());
    }

    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        *self = Self::default();
        let _ = dictionary;
    }
}
