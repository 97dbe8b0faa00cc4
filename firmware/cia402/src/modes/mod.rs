//! The modes of operation 6060h: one at a time decides how the motor moves while the drive is in operation enabled.
//!
//! A new mode takes effect at once while the motor stands or has no power. While it moves, it first slows down with 6084h
//! and forgets its set-points; 6061h shows the new mode when it is really at work. Halt and a held bit 4 are no obstacle.
//! A value that is not supported is refused by SDO and ignored in a PDO.

mod position_window;
mod profile_position;

use canopen::Instant;

use crate::configuration::Configuration;
use crate::exchange::Commands;
use crate::motor::Motor;
use crate::option_codes::StopRamp;

use profile_position::ProfilePosition;

/// A mode of operation, with its number in 6060h and 6061h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum Mode {
    /// No mode: the motor holds its position.
    NoMode = 0,
    /// Profile position: the motor goes to set-points, each on its own profile.
    ProfilePosition = 1,
}

impl Mode {
    /// Every mode of this firmware.
    pub const ALL: [Self; 2] = [Self::NoMode, Self::ProfilePosition];

    /// The mode with this number; `None` if it is not supported.
    pub fn from_code(code: i8) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.code() == code)
    }

    /// Its number.
    pub const fn code(self) -> i8 {
        self as i8
    }

    /// Its bit in 6502h, "supported drive modes"; 0 for no mode, which every drive has.
    pub const fn supported_bit(self) -> u32 {
        match self {
            Self::NoMode => 0,
            Self::ProfilePosition => 1 << 0,
        }
    }
}

/// What a mode sees, and the motor it moves, in one control tick.
#[derive(Debug)]
pub(crate) struct Context<'a> {
    pub(crate) now: Instant,
    pub(crate) commands: &'a Commands,
    pub(crate) configuration: &'a Configuration,
    /// 6064h before it is cut to 32 bits.
    pub(crate) position: i64,
    pub(crate) motor: &'a mut Motor,
}

impl Context<'_> {
    /// The deceleration of a ramp in the profile modes, in steps/s².
    pub(crate) fn profile_ramp(&self, ramp: StopRamp) -> u32 {
        profile_ramp(ramp, self.commands, self.configuration)
    }
}

fn profile_ramp(ramp: StopRamp, commands: &Commands, configuration: &Configuration) -> u32 {
    match ramp {
        StopRamp::SlowDown => commands.profile_deceleration,
        StopRamp::QuickStop | StopRamp::CurrentLimit => configuration.quick_stop_deceleration,
    }
}

/// The modes, and which of them is at work.
#[derive(Debug)]
pub(crate) struct Modes {
    active: Mode,
    /// The active mode has given up its set-points, and the motor is slowing down.
    interrupted: bool,
    profile_position: ProfilePosition,
}

impl Modes {
    pub(crate) const fn new() -> Self {
        Self {
            active: Mode::NoMode,
            interrupted: false,
            profile_position: ProfilePosition::new(),
        }
    }

    /// The mode that is at work (6061h).
    pub(crate) const fn active(&self) -> Mode {
        self.active
    }

    /// The deceleration of a ramp in the mode at work, in steps/s².
    pub(crate) fn deceleration(
        &self,
        ramp: StopRamp,
        commands: &Commands,
        configuration: &Configuration,
    ) -> u32 {
        match self.active {
            Mode::NoMode | Mode::ProfilePosition => profile_ramp(ramp, commands, configuration),
        }
    }

    /// The motor stands, and no mode is at work: the mode that is asked for is the mode.
    pub(crate) fn select(&mut self, code: i8) {
        self.active = Mode::from_code(code).unwrap_or(self.active);
    }

    /// Operation is enabled: the mode starts with no set-point and all its bits at rest.
    pub(crate) fn enter(&mut self, motor: &Motor) {
        self.interrupted = false;
        match self.active {
            Mode::NoMode => {}
            Mode::ProfilePosition => self.profile_position.enter(motor),
        }
    }

    /// Operation is to be left, or the mode: the motor slows down with `deceleration`, its set-points are forgotten.
    pub(crate) fn interrupt(&mut self, motor: &mut Motor, deceleration: u32) {
        if !self.interrupted {
            self.interrupted = true;
            if !motor.standstill() {
                motor.stop(deceleration);
            }
        }
    }

    /// One control tick in operation enabled. Returns the bits of the statusword that belong to the mode.
    pub(crate) fn tick(&mut self, context: &mut Context<'_>) -> u16 {
        let wanted = Mode::from_code(context.commands.mode).unwrap_or(self.active);
        if wanted != self.active {
            if !context.motor.standstill() {
                let deceleration =
                    self.deceleration(StopRamp::SlowDown, context.commands, context.configuration);
                self.interrupt(context.motor, deceleration);
                return 0;
            }
            self.active = wanted;
            self.enter(context.motor);
        } else if self.interrupted {
            self.enter(context.motor);
        }
        match self.active {
            Mode::NoMode => 0,
            Mode::ProfilePosition => self.profile_position.tick(context),
        }
    }
}
