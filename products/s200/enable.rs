//! The hardware enable and what the drive does at power-up without a master (AENA).
//!
//! 5106h, which is our own, says which input the hardware enable is; without one it is always there. While it is missing the motor has no power, whatever
//! the controlword says.
//!
//! AENA acts as its manual says, at the power-up behind a save. So that no motor gets power that nobody expects, the drive enables itself only
//! where it has a hardware enable, and until a controlword is written.

use canopen::od::{Dictionary, Entry};
use cia402::State;
use cia402::behaviour::{number, put_number};
use cia402::commands::Commands;

use super::Seen;

/// What is known of the enable.
#[derive(Debug, Default)]
pub(super) struct Enable {
    by_itself: bool,
    is_there: bool,
    state: Option<State>,
}

impl Enable {
    pub(super) fn written(&mut self, entry: &Entry, is_starting: bool) {
        if entry.index == 0x6040 {
            self.by_itself &= is_starting;
        }
    }

    /// What was stored is loaded.
    pub(super) fn begin<D: Dictionary>(&mut self, dictionary: &D) {
        // The input is none by default: it was saved.
        let has_input = number(dictionary, 0x5106, 0) != 0;
        self.by_itself = has_input && number(dictionary, 0x3506, 1) != 0;
    }

    /// Whether the hardware enable is there.
    pub(super) const fn is_there(&self) -> bool {
        self.is_there
    }

    /// A tick has passed. Returns whether the commands are others now.
    pub(super) fn tick<D: Dictionary>(&mut self, dictionary: &mut D, seen: &Seen) -> bool {
        let was_there = self.is_there;
        self.is_there = match u32::try_from(number(dictionary, 0x5106, 0)) {
            // Inputs begin with bit 16 of 60FDh.
            Ok(input @ 1..=6) => seen.inputs >> (15 + input) & 1 == 1,
            _ => true,
        };
        put_number(dictionary, 0x35E4, 1, self.is_there.into());
        let state = State::from_statusword(seen.statusword);
        let before = core::mem::replace(&mut self.state, state);
        self.is_there != was_there || self.by_itself && state != before
    }

    pub(super) fn command(&self, commands: &mut Commands) {
        const SHUTDOWN: u16 = 0x06;
        const SWITCH_ON: u16 = 0x07;
        const ENABLE: u16 = 0x0F;
        const VOLTAGE: u16 = 0x02;
        if self.by_itself {
            commands.controlword = match self.state {
                Some(State::ReadyToSwitchOn) => SWITCH_ON,
                Some(State::SwitchedOn | State::OperationEnabled) => ENABLE,
                _ => SHUTDOWN,
            };
        }
        if !self.is_there {
            commands.controlword &= !VOLTAGE;
        }
    }
}
