//! What the bus asks of the drive, as one consistent copy.

use motion::{SignedSpeed, Speed};

use crate::board::Compare;
use crate::controlword::{Command, HALT, NEW_SET_POINT};
use crate::copied::copy_fields;

/// Everything the control tick needs from the bus: one consistent copy. Velocities and accelerations are in increments already,
/// positions in units of the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Commands {
    /// 6040h as last written.
    pub controlword: u16,
    /// Bits of 6040h that rose since the last tick took its copy, so that an edge between two ticks is not missed.
    pub rising: u16,
    /// The strongest command to stop (disable voltage, then quick stop) that was written since the last tick took its copy,
    /// so that it is obeyed even if another command followed at once.
    pub stop: Option<Command>,
    /// "Shutdown" was written since the last tick took its copy, and no command to stop after it: whoever writes faster than
    /// the control tick still gets from switch on disabled to ready to switch on.
    pub shutdown_first: bool,
    /// The last command that was written since the last tick took its copy, if a controlword with bit 7 (which is no command) followed it.
    pub overwritten: Option<Command>,
    /// The network lets the drive move: the node is neither stopped nor being reset.
    pub remote: bool,
    /// Why it does not: the error code of a network that was lost, to which 6007h applies; none while the device is being
    /// reset, which always stops the motor.
    pub connection_error: Option<u16>,
    /// The device starts anew (NMT reset node): once the motor stands without power, the drive forgets its faults and its
    /// state machine begins again. One restart is done, until this has been false.
    pub restart: bool,
    /// 6060h.
    pub mode: i8,
    /// 6042h in units of the velocity mode.
    pub vl_target_velocity: i16,
    /// 607Ah in units of the user.
    pub target_position: i32,
    /// 6081h.
    pub profile_velocity: Speed,
    /// 6082h.
    pub end_velocity: Speed,
    /// 60F2h.
    pub positioning_option: u16,
    /// 6083h in steps/s².
    pub profile_acceleration: u32,
    /// 6084h in steps/s².
    pub profile_deceleration: u32,
    /// 60FFh.
    pub target_velocity: SignedSpeed,
    /// 60B1h.
    #[cfg(feature = "torque")]
    pub velocity_offset: SignedSpeed,
    /// 6071h, in thousandths of the rated torque.
    pub target_torque: i16,
    /// 60B2h, in thousandths of the rated torque.
    pub torque_offset: i16,
    /// 60B8h.
    pub touch_probe_function: u16,
    /// Bits 0 and 8 of 60B8h that were 0 since the last tick took its copy, so that a probe switched off and on between two ticks
    /// starts anew.
    pub touch_probes_off: u16,
    /// 60FEh:1.
    pub digital_outputs: u32,
    /// 60FEh:2.
    pub digital_outputs_mask: u32,
    /// 60FEh was written since the last tick took its copy.
    pub outputs_written: bool,
    /// The set-point of an edge of bit 4 behind which a master went on writing before the tick took its copy; `None` where the
    /// set-point is in the values above.
    pub passed_set_point: Option<SetPoint>,
    /// A fault that the module of the product has found; it stands as long as this says so.
    pub fault: Option<u16>,
    /// The level of the home switch as the module of the product gives it, in place of the inputs with that function.
    pub home_switch: Option<bool>,
    /// An output that rises at positions.
    pub compare: Option<Compare>,
}

/// What a set-point of profile position is made from: the objects and bits as they were at the edge of bit 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPoint {
    /// 6040h, of which bits 5, 6 and 9 count.
    pub controlword: u16,
    /// 607Ah in units of the user.
    pub target_position: i32,
    /// 6081h.
    pub profile_velocity: Speed,
    /// 6082h.
    pub end_velocity: Speed,
    /// 60F2h.
    pub positioning_option: u16,
    /// 6083h in steps/s².
    pub profile_acceleration: u32,
    /// 6084h in steps/s².
    pub profile_deceleration: u32,
}

impl Commands {
    /// What holds before the first command: nothing is asked for.
    pub const NONE: Self = Self {
        controlword: 0,
        rising: 0,
        stop: None,
        shutdown_first: false,
        overwritten: None,
        remote: false,
        connection_error: None,
        restart: false,
        mode: 0,
        vl_target_velocity: 0,
        target_position: 0,
        profile_velocity: Speed::ZERO,
        end_velocity: Speed::ZERO,
        positioning_option: 0,
        profile_acceleration: 0,
        profile_deceleration: 0,
        target_velocity: SignedSpeed::ZERO,
        #[cfg(feature = "torque")]
        velocity_offset: SignedSpeed::ZERO,
        target_torque: 0,
        torque_offset: 0,
        touch_probe_function: 0,
        touch_probes_off: 0,
        digital_outputs: 0,
        digital_outputs_mask: 0,
        outputs_written: false,
        passed_set_point: None,
        fault: None,
        home_switch: None,
        compare: None,
    };

    /// Puts what is only posted once on top of `earlier` commands that no tick has taken yet.
    pub(crate) fn after(mut self, earlier: &Self) -> Self {
        if earlier.rising & !self.rising & NEW_SET_POINT != 0 {
            self.passed_set_point = Some(earlier.set_point());
        }
        self.rising |= earlier.rising;
        self.touch_probes_off |= earlier.touch_probes_off;
        self.outputs_written |= earlier.outputs_written;
        self.shutdown_first |= earlier.shutdown_first && self.stop.is_none();
        if Command::decode(self.controlword).is_none() && self.overwritten.is_none() {
            self.overwritten = Command::decode(earlier.controlword).or(earlier.overwritten);
        }
        if self.stop != Some(Command::DisableVoltage) {
            self.stop = earlier.stop.or(self.stop);
        }
        self
    }

    /// Copies field by field.
    #[inline]
    pub(crate) fn assign(&mut self, from: &Self) {
        copy_fields!(Self { controlword, rising, stop, shutdown_first, overwritten, remote, connection_error, restart, mode, vl_target_velocity, target_position, profile_velocity, end_velocity, positioning_option, profile_acceleration, profile_deceleration, target_velocity, #[cfg(feature = "torque")] velocity_offset, target_torque, torque_offset, touch_probe_function, touch_probes_off, digital_outputs, digital_outputs_mask, outputs_written, passed_set_point, fault, home_switch, compare }, from => self);
    }

    /// Whether these ask for a stop that those of before did not: halt, a command that leaves operation enabled, or the loss of the network.
    pub(crate) fn stop_behind(&self, before: &Self) -> bool {
        let standing = Command::decode(before.controlword);
        let leaves = match (self.stop, Command::decode(self.controlword)) {
            (Some(stop), _) => Some(stop),
            (None, command @ Some(Command::Shutdown | Command::SwitchOn)) => command,
            (None, _) => None,
        };
        self.controlword & !before.controlword & HALT != 0
            || leaves.is_some() && leaves != standing
            || before.remote && !self.remote
    }

    /// Whether these differ from those of before in numbers at most, and hold nothing that is carried out once.
    pub(crate) fn repeat(&self, before: &Self) -> bool {
        let asked = |commands: &Self| {
            (
                (commands.controlword, commands.remote, commands.mode),
                (commands.connection_error, commands.restart),
                (commands.digital_outputs, commands.digital_outputs_mask),
                commands.touch_probe_function,
            )
        };
        let is_passed = self.rising | self.touch_probes_off != 0
            || self.stop.is_some()
            || self.overwritten.is_some()
            || self.shutdown_first
            || self.outputs_written
            || self.passed_set_point.is_some();
        !is_passed && asked(self) == asked(before)
    }

    /// Forgets what is carried out once: a tick has taken it.
    pub(crate) const fn forget_passed(&mut self) {
        self.rising = 0;
        self.stop = None;
        self.shutdown_first = false;
        self.overwritten = None;
        self.touch_probes_off = 0;
        self.outputs_written = false;
        self.passed_set_point = None;
    }

    /// The set-point of the last edge of bit 4. Only profile position reads it: whatever else the drive does goes by the newest
    /// values.
    pub(crate) fn set_point(&self) -> SetPoint {
        self.passed_set_point.unwrap_or(SetPoint {
            controlword: self.controlword,
            target_position: self.target_position,
            profile_velocity: self.profile_velocity,
            end_velocity: self.end_velocity,
            positioning_option: self.positioning_option,
            profile_acceleration: self.profile_acceleration,
            profile_deceleration: self.profile_deceleration,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_repeat_those_before_if_they_differ_in_numbers_alone() {
        let before = Commands {
            controlword: 0x0F,
            mode: 8,
            ..Commands::NONE
        };
        let numbers = Commands {
            target_position: 1,
            target_velocity: SignedSpeed::per_second(1),
            vl_target_velocity: 1,
            profile_acceleration: 1,
            ..before
        };
        assert!(before.repeat(&before) && numbers.repeat(&before));
        let asks: [fn(&mut Commands); 16] = [
            |commands| commands.controlword = 0x10F,
            |commands| commands.rising = 0x10,
            |commands| commands.stop = Some(Command::QuickStop),
            |commands| commands.shutdown_first = true,
            |commands| commands.overwritten = Some(Command::Shutdown),
            |commands| commands.remote = true,
            |commands| commands.connection_error = Some(0x8130),
            |commands| commands.restart = true,
            |commands| commands.mode = 1,
            |commands| commands.touch_probe_function = 1,
            |commands| commands.touch_probes_off = 1,
            |commands| commands.digital_outputs = 1,
            |commands| commands.digital_outputs_mask = 1,
            |commands| commands.outputs_written = true,
            |commands| commands.passed_set_point = Some(Commands::NONE.set_point()),
            // What was asked for and is no more.
            |commands| commands.controlword = 0,
        ];
        for (number, ask) in asks.into_iter().enumerate() {
            let mut commands = before;
            ask(&mut commands);
            assert!(!commands.repeat(&before), "{number}");
        }
    }
}
