//! The mode of operation in a tick, and what is enforced whatever it does.

use motion::low;

use super::{Drive, Tick};
use crate::actuator::{Actuator, TORQUE_MODES, TorqueLimits};
use crate::controlword::Command;
use crate::mode::Mode;
use crate::modes::Context;
use crate::objects::Objects;
use crate::option_codes::Stop;
use crate::state_machine::State;
use crate::statusword;

impl<D: Objects, A: Actuator> Drive<D, A> {
    /// Whether the motor is blocked: the motor driver says so, or it is too far behind its pulses. `None` if neither can tell.
    fn blocked(&self, tick: &Tick<'_>) -> Option<bool> {
        let inputs = tick.inputs;
        let window = self.configuration.homing.block_window;
        if window == 0 {
            return inputs.stall;
        }
        let behind = low::i32(self.motor.demand().position.wrapping_sub(tick.position));
        Some(inputs.stall == Some(true) || behind.unsigned_abs() >= window)
    }

    /// Sets the limits of torque and current, and the feed-forward, for this tick and the refills behind it. Returns bit 11 of the
    /// statusword.
    fn limit_torque(&mut self) -> u16 {
        if Self::MODES & TORQUE_MODES == 0 {
            return 0;
        }
        let torque = &self.configuration.torque;
        let limits = TorqueLimits {
            positive: torque.max.min(torque.positive),
            negative: torque.max.min(torque.negative),
            current: torque.max_current,
            velocity: self.configuration.max_velocity,
        };
        let is_ahead = matches!(
            self.modes.active(),
            Mode::CyclicPosition | Mode::CyclicVelocity
        );
        let ahead = if is_ahead && self.power.is_on() {
            self.commands.torque_offset
        } else {
            0
        };
        self.motor.set_torque(limits, ahead);
        #[cfg(feature = "torque")]
        {
            let is_ahead = self.modes.active() == Mode::CyclicPosition && self.power.is_on();
            let velocity = is_ahead.then_some(self.commands.velocity_offset);
            self.motor.set_velocity_ahead(velocity.unwrap_or_default());
        }
        let is_limited = self.motor.torque().is_some_and(|torque| torque.is_limited);
        if self.power.is_on() && is_limited {
            statusword::INTERNAL_LIMIT
        } else {
            0
        }
    }

    /// The mode of operation. Returns its bits of the statusword.
    #[inline(never)]
    pub(super) fn operate(&mut self, tick: &Tick<'_>, command: Option<Command>) -> u16 {
        let state = self.machine.state();
        let torque_limit = self.limit_torque();
        if state != State::OperationEnabled && self.motor.standstill() {
            self.modes.select(Self::MODES, self.commands.mode);
        }
        let bits = match state {
            State::OperationEnabled => {
                if let Some(Stop::Ramp(ramp)) = self.leaving(command) {
                    // The transition waits until the motor stands.
                    self.modes.interrupt(
                        &mut self.motor,
                        ramp,
                        &self.commands,
                        &self.configuration,
                    );
                    return self.enforce_limit_switches()
                        | self.enforce_software_limits()
                        | torque_limit;
                }
                let limit = self.enforce_limit_switches();
                let is_brake_open = self.is_brake_open(tick.now);
                let blocked = self.blocked(tick);
                let bits = self.modes.tick::<(D, A)>(&mut Context {
                    now: tick.now,
                    mode: self.modes.active(),
                    commands: &self.commands,
                    configuration: &self.configuration,
                    demand: self.motor.demand(),
                    observed: self.monitor.observed(),
                    travel: self.limits.travel(),
                    has_changed: tick.has_changed,
                    is_as_before: !tick.has_commands && !tick.has_changed,
                    frame: &mut self.frame,
                    switches: &self.switches,
                    blocked,
                    elapsed: tick.elapsed,
                    position: tick.position,
                    is_brake_open,
                    motor: &mut self.motor,
                    slots: &self.cyclic.slots,
                    buffer: &mut self.cyclic.buffer,
                    pipeline: &self.cyclic.pipeline,
                    is_early: tick.is_early,
                    lost_set_points: &mut self.cyclic.set_points_lost,
                });
                bits | limit
            }
            State::QuickStopActive | State::FaultReactionActive => {
                let stays = state == State::QuickStopActive && self.machine.quick_stop().stays();
                let bits = if stays && self.motor.standstill() {
                    statusword::TARGET_REACHED
                } else {
                    0
                };
                bits | self.idle_bits() | self.enforce_limit_switches()
            }
            _ => return self.idle_bits(),
        };
        bits | self.enforce_software_limits() | torque_limit
    }
}
