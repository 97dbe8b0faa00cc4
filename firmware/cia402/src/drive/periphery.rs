//! The periphery in a tick: what each part of it is given from the drive, and what the drive takes from it.

use canopen::Instant;

use super::{Drive, Inputs, Tick};
use crate::actuator::{Actuator, TORQUE_MODES};
use crate::board::Compare;
use crate::objects::Objects;
use crate::periphery::Latched;
use crate::periphery::digital_outputs::Shown;
use crate::periphery::motor_current::Motion;

/// So long a rotor swings after it was drawn to its field, in microseconds.
const ALIGNMENT_TIME: u64 = 50_000;

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// What the board has measured, and what the master wants of the outputs, at the start of a tick.
    pub(super) fn measure(&mut self, tick: &Tick<'_>) {
        self.periphery
            .measure::<D>(tick.elapsed, tick.inputs, &self.configuration);
        if D::DRIVE.digital_outputs {
            self.periphery
                .outputs
                .command(&self.commands, &self.configuration.outputs);
        }
    }

    /// The switches look at the inputs, or at what the network tells of the home switch.
    pub(super) fn look_at_switches(&mut self, tick: &Tick<'_>) {
        if tick.is_early {
            self.switches.forget_edges();
            return;
        }
        let configuration = &self.configuration.inputs;
        let mut digital = &tick.inputs.digital;
        let mut told;
        if D::DRIVE_HABITS.home_switch_elsewhere
            && let Some(is_high) = self.commands.home_switch
        {
            told = *digital;
            told.changed &= !configuration.home;
            told.levels &= !configuration.home;
            told.levels |= if is_high { configuration.home } else { 0 };
            digital = &told;
        }
        let count = self.motor.count(tick.position);
        self.switches
            .observe(digital, configuration, count, tick.elapsed);
    }

    /// The touch probes look at the inputs: in regular ticks only, as these alone have the edges. What is only written once is in the
    /// commands of an early one all the same.
    pub(super) fn probe(&mut self, tick: &Tick<'_>) {
        if !D::DRIVE.touch_probes {
            return;
        }
        if tick.is_early {
            self.periphery.probes.follow_later(&self.commands);
            return;
        }
        self.periphery.probes.observe(
            tick.now,
            &tick.inputs.digital,
            &self.commands,
            &self.configuration,
            self.motor.count(tick.position),
        );
    }

    /// What the touch probes have that is new for the device.
    pub(super) fn take_latched(&mut self) -> Option<Latched> {
        let units = self.configuration.units.of_drive::<D>();
        let shown = |increments| self.frame.shown(increments, units);
        self.periphery.take_latched::<D>(shown)
    }

    /// Tells the brake what 60FEh wants of it if that may, else what the state machine wants. 60FEh does not close it on a motor that
    /// turns: the mode stops the motor first, unless that takes too long.
    pub(super) fn move_brake(&mut self, now: Instant) {
        let release = match self.periphery.outputs.brake() {
            Some(manual) => {
                let is_turning = self.power.is_on() && !self.motor.standstill();
                let is_released = self.brakes.actual.is_released();
                manual || is_turning && is_released && !self.is_overdue(now)
            }
            None => self.brakes.wanted.is_released(),
        };
        self.brakes.actual.set(release, now);
    }

    /// Power that comes draws the rotor to the nearest place of its field, up to two full steps away. Where an encoder shows that, the
    /// motor begins from where it has come to rest, and not before the brake has let go of it.
    pub(super) fn await_rotor(&mut self, now: Instant, inputs: &Inputs) {
        if !self.power.is_on() {
            let brake = &self.configuration.brake;
            let power = u64::from(brake.power).saturating_mul(1_000);
            let release = u64::from(brake.release).saturating_mul(1_000);
            self.brakes.may_open_at = Instant::from_ticks(now.ticks().saturating_add(power));
            // A field that follows the rotor does not pull it anywhere.
            let is_drawn = inputs.position_tolerance != 0 && Self::MODES & TORQUE_MODES == 0;
            let wait = if is_drawn {
                power.saturating_add(release).saturating_add(ALIGNMENT_TIME)
            } else {
                0
            };
            self.brakes.aligned_at = Instant::from_ticks(now.ticks().saturating_add(wait));
        }
    }

    /// Whether the brake, and the rotor that is drawn to its field, let the motor move, and are to go on doing so.
    pub(super) fn is_brake_open(&self, now: Instant) -> bool {
        self.brakes.is_rotor_aligned(now)
            && self.periphery.outputs.brake() != Some(false)
            && self.brakes.actual.is_open(self.configuration.brake, now)
    }

    /// The current of the motor in milliamperes.
    pub(super) fn motor_current(&mut self, elapsed: u32) -> u16 {
        if !D::DRIVE.motor_current {
            return 0;
        }
        let motion = Motion {
            power: self.power.is_on(),
            standstill: self.motor.standstill(),
            velocity: self.motor.demand().velocity.whole(),
        };
        self.periphery
            .current
            .choose(motion, elapsed, &self.configuration.currents)
    }

    /// Where an output is to rise, in the count of the board.
    pub(super) fn compare(&self) -> Option<Compare> {
        let compare = self
            .commands
            .compare
            .filter(|_| D::DRIVE_HABITS.compares_positions)?;
        let count = self.motor.count(compare.position.into());
        Some(Compare {
            position: count.board_position(),
            spacing: if count.is_reversed {
                compare.spacing.wrapping_neg()
            } else {
                compare.spacing
            },
            ..compare
        })
    }

    /// The levels of the digital outputs.
    pub(super) fn output_levels(&self, statusword: u16) -> u8 {
        if !D::DRIVE.digital_outputs {
            return 0;
        }
        let shown = Shown {
            state: self.machine.state(),
            statusword,
            referenced: self.motor.is_referenced(),
            moving: !self.motor.standstill(),
            brake_released: self.brakes.actual.is_released(),
        };
        self.periphery
            .outputs
            .levels(&shown, &self.configuration.outputs)
    }
}
