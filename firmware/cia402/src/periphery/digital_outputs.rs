//! The digital outputs: object 60FEh, and functions of the drive (2060h).
//!
//! An output is set by the master (function 0), or shows something of the drive. Only the bits of 60FEh:1 in the
//! mask 60FEh:2 count; an output whose bit is not in the mask stays as it is. Bits 16 to 19 are outputs 1 to 4. Bit 0 is the holding brake
//! (1 closes it). The state machine moves the brake, and bit 0 is ignored unless 2063h is 1: then bit 0 decides while it is in the mask
//! and the network commands the drive, so that an axis can be moved by hand.
//!
//! When the network is lost, outputs set by the master are switched off, but for those in 2062h, which stay as they are. They stay so
//! until 60FEh is written again. NMT reset node switches all of them off. Outputs with a function go on showing it.
//!
//! 2061h inverts outputs: an inverted one is low where it would be high. After power-on, and while the processor is reset, all are low.

use motion::low;

use crate::commands::Commands;
use crate::outputs::{ALL, COUNT, OutputConfiguration, OutputFunction};
use crate::state_machine::State;
use crate::statusword;

/// Where the outputs are in 60FEh.
const FIRST: u32 = 16;
/// The brake in 60FEh.
const BRAKE: u32 = 1;

/// What outputs can show of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shown {
    pub(crate) state: State,
    /// 6041h.
    pub(crate) statusword: u16,
    pub(crate) referenced: bool,
    pub(crate) moving: bool,
    pub(crate) brake_released: bool,
}

impl Shown {
    const fn has(&self, function: OutputFunction) -> bool {
        match function {
            OutputFunction::Manual => false,
            OutputFunction::Fault => {
                matches!(self.state, State::FaultReactionActive | State::Fault)
            }
            OutputFunction::Warning => self.statusword & statusword::WARNING != 0,
            OutputFunction::OperationEnabled => matches!(self.state, State::OperationEnabled),
            OutputFunction::TargetReached => self.statusword & statusword::TARGET_REACHED != 0,
            OutputFunction::Referenced => self.referenced,
            OutputFunction::Moving => self.moving,
            OutputFunction::Limit => self.statusword & statusword::INTERNAL_LIMIT != 0,
            OutputFunction::BrakeReleased => self.brake_released,
        }
    }
}

/// The outputs at work.
#[derive(Debug)]
pub(crate) struct DigitalOutputs {
    /// What the master has set, bits as in 60FEh.
    set: u32,
    /// The master's outputs are at rest until 60FEh is written.
    is_at_rest: bool,
    /// What 60FEh asks of the brake, if it may: whether it is open.
    brake: Option<bool>,
}

impl DigitalOutputs {
    pub(crate) const fn new() -> Self {
        Self {
            set: 0,
            is_at_rest: true,
            brake: None,
        }
    }

    /// Takes what the master wants, at the start of a tick.
    pub(crate) fn command(&mut self, commands: &Commands, configuration: &OutputConfiguration) {
        if !commands.remote {
            // A device that starts anew keeps nothing.
            let kept = if commands.restart {
                0
            } else {
                configuration.kept
            };
            self.set &= u32::from(kept) << FIRST;
            self.is_at_rest = true;
            self.brake = None;
            return;
        }
        self.is_at_rest &= !commands.outputs_written;
        if self.is_at_rest {
            return;
        }
        let mask = commands.digital_outputs_mask;
        self.set = self.set & !mask | commands.digital_outputs & mask;
        let has_brake = configuration.is_brake_manual && mask & BRAKE != 0;
        self.brake = has_brake.then_some(commands.digital_outputs & BRAKE == 0);
    }

    /// Whether 60FEh opens the brake (true), closes it (false), or leaves it to the state machine.
    pub(crate) const fn brake(&self) -> Option<bool> {
        self.brake
    }

    /// The levels of the outputs, output 1 in bit 0.
    pub(crate) fn levels(&self, shown: &Shown, configuration: &OutputConfiguration) -> u8 {
        let mut levels = low::u8(self.set >> FIRST) & ALL;
        // As numbers they are one word; 0 is what the master sets.
        if configuration.functions.map(|function| function as u8) != [0; COUNT] {
            let mut output = 1;
            for function in configuration.functions {
                if function != OutputFunction::Manual {
                    levels &= !output;
                    levels |= if shown.has(function) { output } else { 0 };
                }
                output <<= 1;
            }
        }
        levels ^ configuration.inverted
    }
}

#[cfg(test)]
mod tests;
