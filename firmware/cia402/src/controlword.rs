//! The controlword 6040h: how a master asks for a state, and what it asks of the mode (CiA 402-2, "controlword").
//!
//! The state commands are coded in bits 0 to 3 and 7 under masks: bits that a command does not name never disturb it,
//! so 8006h and 0106h are both "shutdown". Any value with bit 7 set is no state command at all; its rising edge resets a
//! fault. Bits 4 to 6, 8 and 9 belong to the mode of operation, bits 10 to 15 are ignored.

/// Bit 1, enable voltage: 0 is "disable voltage".
pub const ENABLE_VOLTAGE: u16 = 1 << 1;
/// Bit 2, quick stop: active when 0.
pub const QUICK_STOP: u16 = 1 << 2;
/// Bit 4 in profile position: new set-point.
pub const NEW_SET_POINT: u16 = 1 << 4;
/// Bit 5 in profile position: change set immediately.
pub const CHANGE_IMMEDIATELY: u16 = 1 << 5;
/// Bit 6 in profile position: 607Ah is relative.
pub const RELATIVE: u16 = 1 << 6;
/// Bit 9 in profile position: change on set-point.
pub const CHANGE_ON_SET_POINT: u16 = 1 << 9;
/// Bit 4 in the velocity mode: enable ramp.
pub const ENABLE_RAMP: u16 = 1 << 4;
/// Bit 5 in the velocity mode: unlock ramp.
pub const UNLOCK_RAMP: u16 = 1 << 5;
/// Bit 6 in the velocity mode: reference ramp.
pub const REFERENCE_RAMP: u16 = 1 << 6;
/// Bit 7: fault reset, by its rising edge.
pub const FAULT_RESET: u16 = 1 << 7;
/// Bit 8: halt.
pub const HALT: u16 = 1 << 8;

const SWITCH_ON: u16 = 1 << 0;
const ENABLE_OPERATION: u16 = 1 << 3;

/// A state command (CiA 402-2, "command coding").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// xxxx.x110
    Shutdown,
    /// xxxx.0111. In operation enabled the same bits mean "disable operation".
    SwitchOn,
    /// xxxx.1111
    EnableOperation,
    /// xxxx.x01x
    QuickStop,
    /// xxxx.xx0x
    DisableVoltage,
}

impl Command {
    /// The command in a controlword, under its mask; `None` while bit 7 is set.
    pub const fn decode(controlword: u16) -> Option<Self> {
        if controlword & FAULT_RESET != 0 {
            None
        } else if controlword & ENABLE_VOLTAGE == 0 {
            Some(Self::DisableVoltage)
        } else if controlword & QUICK_STOP == 0 {
            Some(Self::QuickStop)
        } else if controlword & SWITCH_ON == 0 {
            Some(Self::Shutdown)
        } else if controlword & ENABLE_OPERATION == 0 {
            Some(Self::SwitchOn)
        } else {
            Some(Self::EnableOperation)
        }
    }
}

/// Whether data records of interpolated position that come with this controlword are taken: under the command "enable
/// operation", but not under halt while bit 4 is 0.
pub(crate) const fn takes_records(controlword: u16) -> bool {
    const OPERATES: u16 = SWITCH_ON | ENABLE_VOLTAGE | QUICK_STOP | ENABLE_OPERATION;
    controlword & OPERATES == OPERATES && controlword & (HALT | NEW_SET_POINT) != HALT
}

/// What a master wrote to the controlword between two control ticks, frame by frame. A tick takes the last value; what must
/// not be missed because it was overwritten is remembered here: every rising edge, the strongest command to stop, that
/// "shutdown" came first, so that a master that writes 6, 7 and Fh without waiting gets to operation enabled, and the command before
/// a controlword with bit 7, which is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlwordHistory {
    last: u16,
    rising: u16,
    stop: Option<Command>,
    shutdown_first: bool,
    command: Option<Command>,
}

/// What happened in the controlword between two control ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlwordEvents {
    /// Bits that rose.
    pub rising: u16,
    /// The strongest command to stop.
    pub stop: Option<Command>,
    /// "Shutdown" was written, and no command to stop after it.
    pub shutdown_first: bool,
    /// The last command, where a controlword with bit 7 has taken its place.
    pub command: Option<Command>,
}

impl ControlwordHistory {
    /// Nothing written yet; edges count from `controlword`.
    pub const fn new(controlword: u16) -> Self {
        Self {
            last: controlword,
            rising: 0,
            stop: None,
            shutdown_first: false,
            command: None,
        }
    }

    /// A frame wrote the controlword.
    pub const fn write(&mut self, controlword: u16) {
        self.rising |= controlword & !self.last;
        self.last = controlword;
        let command = Command::decode(controlword);
        if command.is_some() {
            self.command = command;
        }
        match command {
            Some(stop @ (Command::DisableVoltage | Command::QuickStop)) => {
                self.shutdown_first = false;
                if !matches!(self.stop, Some(Command::DisableVoltage)) {
                    self.stop = Some(stop);
                }
            }
            Some(Command::Shutdown) => self.shutdown_first = true,
            Some(Command::SwitchOn | Command::EnableOperation) => {}
            // A fault reset: what was written before it asked for something else.
            None => self.shutdown_first = false,
        }
    }

    /// As if "disable voltage" had been written in between.
    pub(crate) const fn disable_voltage(&mut self) {
        self.stop = Some(Command::DisableVoltage);
        self.shutdown_first = false;
    }

    /// What is remembered, once.
    pub const fn take(&mut self) -> ControlwordEvents {
        let taken = ControlwordEvents {
            rising: self.rising,
            stop: self.stop,
            shutdown_first: self.shutdown_first,
            command: if Command::decode(self.last).is_none() {
                self.command
            } else {
                None
            },
        };
        *self = Self::new(self.last);
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d07_bits_of_others_do_not_disturb_a_command() {
        for (controlword, command) in [
            (0x0006, Command::Shutdown),
            (0x0106, Command::Shutdown),
            (0x8006, Command::Shutdown),
            (0x0116, Command::Shutdown),
            (0x000E, Command::Shutdown),
            (0x0007, Command::SwitchOn),
            (0xFF77, Command::SwitchOn),
            (0x000F, Command::EnableOperation),
            (0xF97F, Command::EnableOperation),
            (0x0002, Command::QuickStop),
            (0x000B, Command::QuickStop),
            (0x0000, Command::DisableVoltage),
            (0x000D, Command::DisableVoltage),
        ] {
            assert_eq!(
                Command::decode(controlword),
                Some(command),
                "{controlword:04X}h"
            );
        }
    }

    #[test]
    fn m17_reserved_bits_are_ignored() {
        for low in 0..=0xFFu16 {
            for high in 0..=0xFFu16 {
                assert_eq!(Command::decode(high << 8 | low), Command::decode(low));
            }
        }
    }

    #[test]
    fn m11_with_bit_7_set_there_is_no_command() {
        for low in 0x80..=0xFF {
            assert_eq!(Command::decode(low), None);
        }
    }

    #[test]
    fn d11_an_edge_between_two_ticks_is_not_missed() {
        let mut history = ControlwordHistory::new(0x0000);
        history.write(0x0080);
        history.write(0x0000);
        history.write(0x0006);
        let passed = history.take();
        assert_eq!(
            (passed.rising, passed.stop),
            (0x0086, Some(Command::DisableVoltage))
        );
        let passed = history.take();
        assert_eq!((passed.rising, passed.stop), (0, None));
    }

    #[test]
    fn a_command_to_stop_between_two_ticks_is_not_missed() {
        let mut history = ControlwordHistory::new(0x000F);
        history.write(0x0002);
        history.write(0x000F);
        assert_eq!(history.take().stop, Some(Command::QuickStop));
        history.write(0x0000);
        history.write(0x0002);
        history.write(0x000F);
        assert_eq!(history.take().stop, Some(Command::DisableVoltage));
    }
}
