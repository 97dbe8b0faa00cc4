//! Faults: what each error code means for the motor and for the error register, and which faults stand.
//!
//! A fault is raised when its cause appears, and stands until a fault reset finds the cause gone; it is sent once (one
//! emergency message) however often the cause comes and goes in between. A fault reset while the cause is still there is
//! answered by sending it again.

use canopen::cia301::emergency::{Emergency, ErrorRegister};
use heapless::{Deque, Vec};

use crate::board::Inputs;
use crate::periphery::power_stage::{PowerStage, Warnings};

/// 3210h, DC link over-voltage: the supply is above 2073h:4.
pub const OVER_VOLTAGE: u16 = 0x3210;
/// 3110h, mains over-voltage: a warning, the supply is above 2073h:3.
pub const OVER_VOLTAGE_WARNING: u16 = 0x3110;
/// 3120h, mains under-voltage: a warning, the supply is below 2073h:2.
pub const UNDER_VOLTAGE_WARNING: u16 = 0x3120;
/// 4210h, excess temperature of the device: the power stage is above 2074h:3.
pub const OVER_TEMPERATURE: u16 = 0x4210;
/// 4310h, excess temperature of the drive: a warning, the power stage is above 2074h:2.
pub const TEMPERATURE_WARNING: u16 = 0x4310;
/// 3220h, DC link under-voltage: the supply is gone while there should be current in the motor.
pub const UNDER_VOLTAGE: u16 = 0x3220;
/// 5200h, control hardware: what makes the pulses has stood still.
pub const PULSES_STOPPED: u16 = 0x5200;
/// 6100h, internal software: pulses came too late, so that a motor that moved had none for a moment. A warning where 20A2h only tells.
pub const PULSES_LATE: u16 = 0x6100;
/// 8612h, reference limit: both limit switches are active, so that no direction is free.
pub const BOTH_LIMITS: u16 = 0x8612;
/// 8250h, RPDO timeout: set-points of a cyclic mode did not come.
pub const SET_POINTS_LOST: u16 = 0x8250;
/// 8700h, SYNC controller: SYNC does not come with the period that is set up. A warning: it changes no state.
pub const SYNC_DIFFERS: u16 = 0x8700;
/// 8611h, following error: the motor stands, but not where its pulses should have taken it.
pub const POSITION_MISMATCH: u16 = 0x8611;
/// 9000h, external error: something outside has cut the pulses off. Those committed since are counted, and have not left.
pub const EXTERNAL: u16 = 0x9000;

/// What a timer with DMA tells of the pulses it makes, as a fault: it has stood still, or its outputs are cut off.
pub const fn of_pulses(has_failed: bool, is_broken: bool) -> Option<u16> {
    match (has_failed, is_broken) {
        (true, _) => Some(PULSES_STOPPED),
        (false, true) => Some(EXTERNAL),
        (false, false) => None,
    }
}

/// How a fault stops the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// As the fault reaction option 605Eh says.
    AsConfigured,
    /// Power off at once: no more current may flow, or none can.
    PowerOff,
}

/// A class of error codes (CiA 301, "error code classes").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultClass {
    /// The high byte of the first and the last code.
    pub codes: (u8, u8),
    /// Its bits in the error register 1001h.
    pub register: u8,
    /// What is done with the motor.
    pub reaction: Reaction,
}

/// Every class of error codes that a drive reports, in ascending order. A code outside of them counts as manufacturer
/// specific and is stopped like the hardware faults: what is not understood gets no current.
pub const CLASSES: [FaultClass; 9] = [
    class((0x10, 0x1F), ErrorRegister::GENERIC, Reaction::AsConfigured),
    class((0x20, 0x2F), ErrorRegister::CURRENT, Reaction::PowerOff),
    class((0x30, 0x3F), ErrorRegister::VOLTAGE, Reaction::PowerOff),
    class(
        (0x40, 0x4F),
        ErrorRegister::TEMPERATURE,
        Reaction::AsConfigured,
    ),
    class((0x50, 0x5F), ErrorRegister::GENERIC, Reaction::PowerOff),
    class((0x60, 0x7F), ErrorRegister::GENERIC, Reaction::AsConfigured),
    class(
        (0x80, 0x82),
        ErrorRegister::COMMUNICATION,
        Reaction::AsConfigured,
    ),
    class(
        (0x83, 0x8F),
        ErrorRegister::DEVICE_PROFILE,
        Reaction::AsConfigured,
    ),
    // No pulse reaches the motor any more: there is nothing to ramp down.
    class((0x90, 0x9F), ErrorRegister::GENERIC, Reaction::PowerOff),
];

const OTHER: FaultClass = class(
    (0x00, 0xFF),
    ErrorRegister::MANUFACTURER,
    Reaction::PowerOff,
);

const fn class(codes: (u8, u8), register: u8, reaction: Reaction) -> FaultClass {
    FaultClass {
        codes,
        register,
        reaction,
    }
}

impl FaultClass {
    /// The class of an error code.
    pub fn of(code: u16) -> Self {
        let [high, _] = code.to_be_bytes();
        *CLASSES
            .iter()
            .find(|class| class.codes.0 <= high && high <= class.codes.1)
            .unwrap_or(&OTHER)
    }
}

/// The emergency message of an error code.
pub fn emergency(code: u16) -> Emergency {
    Emergency {
        code,
        register: FaultClass::of(code).register,
        info: [0; 5],
    }
}

/// News of a fault, from the drive to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultNotice {
    /// It appeared.
    Raised(u16),
    /// It is gone.
    Cleared(u16),
}

/// How many faults can stand at one time. A further one stops the motor, but neither an emergency message nor 603Fh shows it.
const STANDING: usize = 8;

/// The faults that stand.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    error_code: u16,
    board: Option<u16>,
    no_supply: bool,
    over_voltage: bool,
    over_temperature: bool,
    both_limits: bool,
    late: bool,
    sync_differs: bool,
    /// What the thresholds of the power stage warn of.
    stage_warnings: Warnings,
    /// What the board warns of.
    board_warning: Option<u16>,
    standing: Vec<u16, STANDING>,
    notices: Deque<FaultNotice, { 2 * STANDING + 8 }>,
}

impl Faults {
    /// Looks for faults at the start of a tick. `displaced` says that the motor stands at a wrong position, `both_limits` that both limit
    /// switches are active; `stage` is what is measured of the power stage, `found` the fault of the stage or of the product's module.
    /// Returns the strongest reaction to the faults that have just appeared.
    pub(crate) fn detect(
        &mut self,
        inputs: &Inputs,
        power: bool,
        displaced: bool,
        both_limits: bool,
        stage: &PowerStage,
        found: Option<u16>,
    ) -> Option<Reaction> {
        let mut reaction = None;
        self.warn(inputs.warning);
        if stage.warnings != self.stage_warnings {
            self.warn_of_stage(stage.warnings);
        }
        if found != self.board {
            self.board = found;
            if let Some(code) = found {
                self.raise(code, &mut reaction);
            }
        }
        if power && !stage.has_supply {
            self.no_supply = true;
            self.raise(UNDER_VOLTAGE, &mut reaction);
        } else if stage.has_supply {
            self.no_supply = false;
        }
        if stage.over_voltage && !self.over_voltage {
            self.raise(OVER_VOLTAGE, &mut reaction);
        }
        self.over_voltage = stage.over_voltage;
        if stage.over_temperature && !self.over_temperature {
            self.raise(OVER_TEMPERATURE, &mut reaction);
        }
        self.over_temperature = stage.over_temperature;
        if displaced {
            self.raise(POSITION_MISMATCH, &mut reaction);
        }
        if power && both_limits {
            self.both_limits = true;
            self.raise(BOTH_LIMITS, &mut reaction);
        } else if !both_limits {
            self.both_limits = false;
        }
        reaction
    }

    fn raise(&mut self, code: u16, reaction: &mut Option<Reaction>) {
        if *reaction != Some(Reaction::PowerOff) {
            *reaction = Some(FaultClass::of(code).reaction);
        }
        if !self.standing.contains(&code) && self.standing.push(code).is_ok() {
            self.error_code = code;
            self.notify(FaultNotice::Raised(code));
        }
    }

    /// The network was lost, and 6007h makes a fault of it. 603Fh shows the code; the node has sent the emergency message
    /// already.
    pub(crate) const fn lose_connection(&mut self, code: u16) {
        self.error_code = code;
    }

    /// Whether the cause of a fault is there now.
    pub(crate) const fn cause_stands(&self) -> bool {
        self.board.is_some()
            || self.no_supply
            || self.over_voltage
            || self.over_temperature
            || self.both_limits
    }

    /// Transition 15: the master has reset the fault. 603Fh keeps the code of the last one.
    pub(crate) fn reset(&mut self) {
        while let Some(code) = self.standing.pop() {
            self.notify(FaultNotice::Cleared(code));
        }
    }

    /// A fault reset that found the cause still there: the fault is cleared and raised anew.
    pub(crate) fn renew(&mut self) {
        self.reset();
        let mut reaction = None;
        if let Some(code) = self.board {
            self.raise(code, &mut reaction);
        }
        if self.no_supply {
            self.raise(UNDER_VOLTAGE, &mut reaction);
        }
        if self.over_voltage {
            self.raise(OVER_VOLTAGE, &mut reaction);
        }
        if self.over_temperature {
            self.raise(OVER_TEMPERATURE, &mut reaction);
        }
        if self.both_limits {
            self.raise(BOTH_LIMITS, &mut reaction);
        }
    }

    /// What the thresholds of the power stage warn of now.
    #[cold]
    #[inline(never)]
    fn warn_of_stage(&mut self, now: Warnings) {
        let before = core::mem::replace(&mut self.stage_warnings, now);
        for (code, was, is) in [
            (
                UNDER_VOLTAGE_WARNING,
                before.under_voltage,
                now.under_voltage,
            ),
            (OVER_VOLTAGE_WARNING, before.over_voltage, now.over_voltage),
            (TEMPERATURE_WARNING, before.temperature, now.temperature),
        ] {
            match (was, is) {
                (false, true) => self.notify(FaultNotice::Raised(code)),
                (true, false) => self.notify(FaultNotice::Cleared(code)),
                _ => {}
            }
        }
    }

    /// What the board warns of now.
    fn warn(&mut self, warning: Option<u16>) {
        if warning == self.board_warning {
            return;
        }
        if let Some(code) = self.board_warning {
            self.notify(FaultNotice::Cleared(code));
        }
        if let Some(code) = warning {
            self.notify(FaultNotice::Raised(code));
        }
        self.board_warning = warning;
    }

    /// Warns of pulses that came too late, or takes the warning back when the motor stands.
    pub(crate) fn warn_of_late_pulses(&mut self, late: bool) {
        if late != self.late {
            self.late = late;
            self.notify(match late {
                true => FaultNotice::Raised(PULSES_LATE),
                false => FaultNotice::Cleared(PULSES_LATE),
            });
        }
    }

    /// Raises the fault of too many missing set-points in a cyclic mode.
    pub(crate) fn raise_lost_set_points(&mut self) -> Reaction {
        let mut reaction = None;
        self.raise(SET_POINTS_LOST, &mut reaction);
        reaction.unwrap_or(Reaction::AsConfigured)
    }

    /// Raises the fault of a moving motor that had no pulses for a moment.
    pub(crate) fn raise_lost_pulses(&mut self) -> Reaction {
        let mut reaction = None;
        self.raise(PULSES_LATE, &mut reaction);
        reaction.unwrap_or(Reaction::AsConfigured)
    }

    /// Warns of a SYNC whose period is not the one that is set up, or takes the warning back.
    pub(crate) fn warn_of_sync_period(&mut self, differs: bool) {
        if differs != self.sync_differs {
            self.sync_differs = differs;
            self.notify(match differs {
                true => FaultNotice::Raised(SYNC_DIFFERS),
                false => FaultNotice::Cleared(SYNC_DIFFERS),
            });
        }
    }

    /// Statusword bit 7.
    pub(crate) const fn warning(&self) -> bool {
        let stage = self.stage_warnings;
        let by_stage = stage.under_voltage || stage.over_voltage || stage.temperature;
        self.sync_differs || self.late || self.board_warning.is_some() || by_stage
    }

    /// 603Fh: the code of the last fault since power-on; 0 before the first.
    pub(crate) const fn error_code(&self) -> u16 {
        self.error_code
    }

    /// Whether there is news that has not been taken.
    pub(crate) fn has_notices(&self) -> bool {
        !self.notices.is_empty()
    }

    /// The next piece of news, oldest first.
    pub(crate) fn take_notice(&mut self) -> Option<FaultNotice> {
        self.notices.pop_front()
    }

    /// One tick adds at most as many notices as the queue holds, and every tick empties it.
    #[inline(never)]
    fn notify(&mut self, notice: FaultNotice) {
        let _ = self.notices.push_back(notice);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CALM: Inputs = Inputs {
        supply: true,
        position: 0,
        warning: None,
        fault: None,
        digital: crate::inputs::DigitalInputs::NONE,
        stall: None,
        absolute_turn: 0,
        position_tolerance: 0,
        supply_voltage: None,
        temperature: None,
        analogue: None,
        auxiliary_voltage: None,
        battery_voltage: None,
        has_compare: false,
        counter: 0,
    };

    const SUPPLIED: PowerStage = PowerStage {
        has_supply: true,
        ..PowerStage::new()
    };

    #[test]
    fn the_classes_are_in_order_and_do_not_overlap() {
        let mut next = 0;
        for class in CLASSES {
            assert!(
                class.codes.0 >= next && class.codes.0 <= class.codes.1,
                "{class:?}"
            );
            next = class.codes.1 + 1;
        }
    }

    #[test]
    fn every_code_has_its_class() {
        for (code, register, reaction) in [
            (0x2310, 0x02, Reaction::PowerOff),
            (0x3220, 0x04, Reaction::PowerOff),
            (0x4210, 0x08, Reaction::AsConfigured),
            (0x6100, 0x01, Reaction::AsConfigured),
            (0x8130, 0x10, Reaction::AsConfigured),
            (0x8611, 0x20, Reaction::AsConfigured),
            (0x9000, 0x01, Reaction::PowerOff),
            (0xFF00, 0x80, Reaction::PowerOff),
            (0x0001, 0x80, Reaction::PowerOff),
        ] {
            let class = FaultClass::of(code);
            assert_eq!(
                (class.register, class.reaction),
                (register, reaction),
                "{code:04X}h"
            );
        }
    }

    #[test]
    fn of_several_faults_in_one_tick_the_strongest_reaction_counts() {
        let over_current = Inputs {
            fault: Some(0x2310),
            ..CALM
        };
        assert_eq!(
            Faults::default().detect(
                &over_current,
                true,
                true,
                false,
                &SUPPLIED,
                over_current.fault
            ),
            Some(Reaction::PowerOff)
        );
        assert_eq!(
            Faults::default().detect(&CALM, true, true, false, &SUPPLIED, None),
            Some(Reaction::AsConfigured)
        );
        assert_eq!(
            Faults::default().detect(&CALM, true, false, false, &SUPPLIED, None),
            None
        );
    }

    #[test]
    fn what_603fh_shows_is_the_last_emergency_message() {
        let mut faults = Faults::default();
        let mut told = 0;
        // One that comes again while it stands is no new one.
        for code in [0x7301, 0x7302, 0x7303, 0x7304, 0x7301, 0x7305] {
            let inputs = Inputs {
                fault: Some(code),
                ..CALM
            };
            faults.detect(&inputs, true, false, false, &SUPPLIED, inputs.fault);
            while let Some(notice) = faults.take_notice() {
                assert_eq!(notice, FaultNotice::Raised(code));
                told = code;
            }
            assert_eq!(faults.error_code(), told);
        }
        assert_eq!(told, 0x7305);
    }

    #[test]
    fn of_more_faults_than_can_be_told_apart_the_last_one_told_is_in_603fh() {
        let mut faults = Faults::default();
        for code in 0x7301..=0x730C {
            let inputs = Inputs {
                fault: Some(code),
                ..CALM
            };
            assert!(
                faults
                    .detect(&inputs, true, false, false, &SUPPLIED, inputs.fault)
                    .is_some()
            );
        }
        assert_eq!(faults.error_code(), 0x7308);
        let told = core::iter::from_fn(|| faults.take_notice()).count();
        assert_eq!(told, STANDING);
        faults.reset();
        let cleared = core::iter::from_fn(|| faults.take_notice()).count();
        assert_eq!(cleared, STANDING, "each is cleared that was told");
    }
}
