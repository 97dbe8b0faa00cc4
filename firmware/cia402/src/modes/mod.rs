//! The modes of operation 6060h: one at a time decides how the motor moves while the drive is in operation enabled.
//!
//! A new mode takes effect at once while the motor stands or has no power. While it moves, the velocity modes take over and go
//! on from there; before any other mode the motor slows down with 6084h (6049h) and set-points are forgotten. 6061h shows the new mode
//! when it is really at work. Halt and a held bit 4 are no obstacle.
//! A value that is not supported is refused by SDO and ignored in a PDO.

mod braking;
mod cyclic_position;
mod cyclic_torque;
mod cyclic_velocity;
mod following;
mod held_torque;
mod homing;
mod interpolated_position;
mod kept_velocity;
mod profile_position;
mod profile_torque;
mod profile_velocity;
mod velocity;

use canopen::Instant;
use motion::{Demand, Limits, Ramps, SignedSpeed, Speed};

use crate::actuator::Actuator;
use crate::commands::Commands;
use crate::configuration::Configuration;
use crate::controlword::HALT;
use crate::cyclic::{Buffer, Pipeline, Slot};
use crate::inputs::Switches;
use crate::mode::Mode;
use crate::monitor::Observed;
use crate::motor::Motor;
use crate::objects::Objects;
use crate::option_codes::StopRamp;
use crate::statusword::HOMING_ATTAINED;
use crate::travel::Travel;
use crate::units::{PositionFrame, Units};

use cyclic_position::CyclicPosition;
use cyclic_torque::CyclicTorque;
use cyclic_velocity::CyclicVelocity;
use homing::Homing;
use interpolated_position::InterpolatedPosition;
use profile_position::ProfilePosition;
use profile_torque::ProfileTorque;
use profile_velocity::ProfileVelocity;
use velocity::Velocity;

/// The types of a drive: the objects of its data sheet and its actuator.
pub(crate) trait Types {
    type Objects: Objects;
    type Actuator: Actuator;
}

impl<D: Objects, A: Actuator> Types for (D, A) {
    type Objects = D;
    type Actuator = A;
}

/// What a mode sees, and the motor it moves, in one control tick.
pub(crate) struct Context<'a, P: Types> {
    pub(crate) now: Instant,
    /// The mode at work.
    pub(crate) mode: Mode,
    pub(crate) commands: &'a Commands,
    pub(crate) configuration: &'a Configuration,
    pub(crate) switches: &'a Switches,
    /// The motor does not follow its pulses; `None` if nothing can tell.
    pub(crate) blocked: Option<bool>,
    /// Microseconds since the last tick.
    pub(crate) elapsed: u32,
    /// Where the motor is, in increments.
    pub(crate) position: i64,
    /// What was being played when the tick began.
    pub(crate) demand: Demand,
    /// What the motor did.
    pub(crate) observed: &'a Observed,
    /// Where the motor may go by 607Dh.
    pub(crate) travel: &'a Travel,
    /// The configuration or the travel may have changed since the last tick.
    pub(crate) has_changed: bool,
    /// Neither that nor the commands have changed: what the tick before has computed from them holds.
    pub(crate) is_as_before: bool,
    pub(crate) frame: &'a mut PositionFrame,
    pub(crate) is_brake_open: bool,
    pub(crate) motor: &'a mut Motor<P::Actuator>,
    /// The set-points of this tick, for the cyclic modes.
    pub(crate) slots: &'a [Slot],
    /// The data records that wait.
    pub(crate) buffer: &'a mut Buffer,
    /// The delays between a sync event and the motor.
    pub(crate) pipeline: &'a Pipeline,
    /// A regular tick follows in less than a period.
    pub(crate) is_early: bool,
    /// Too many set-points were missing.
    pub(crate) lost_set_points: &'a mut bool,
}

impl<'a, P: Types> Context<'a, P> {
    /// The units of the user.
    pub(crate) const fn units(&self) -> &'a Units {
        self.configuration.units.of_drive::<P::Objects>()
    }

    /// What the drive does otherwise than the standard says.
    pub(crate) const fn habits(&self) -> crate::Habits {
        P::Objects::DRIVE_HABITS
    }

    /// Too many set-points were missing: stops with 6085h.
    #[inline(never)]
    pub(crate) fn lose_set_points(&mut self) {
        let deceleration = self.deceleration(StopRamp::QuickStop);
        self.motor.stop(deceleration);
        *self.lost_set_points = true;
    }

    /// No set-point has come for so long that the motor would stand with no ramp before the next tick.
    pub(crate) fn is_running_out(&self) -> bool {
        !self.is_early && self.motor.is_running_out(self.pipeline.next_tick())
    }

    /// The position of a target of the user, in increments: of those that are shown like it, the one nearest to where the motor
    /// should be. There 6062h and 6064h will read as it was given.
    pub(crate) fn target(&mut self, user: i32) -> i64 {
        let units = self.units();
        let now = self.frame.position(self.demand.position, units);
        let target = units.range().nearest(user.into(), now);
        let increments = units.position(target);
        self.frame.remember(target, increments);
        increments
    }

    /// Controlword bit 8.
    pub(crate) const fn is_halted(&self) -> bool {
        self.commands.controlword & HALT != 0
    }

    /// The motor is not to move: halt, or the brake is not open yet.
    pub(crate) const fn is_held(&self) -> bool {
        self.is_halted() || !self.is_brake_open
    }

    /// Stops on the ramp of 605Dh.
    pub(crate) fn halt(&mut self) {
        if !self.motor.standstill() {
            self.stop_on(self.configuration.halt);
        }
    }

    /// Stops on a ramp of the mode at work.
    pub(crate) fn stop_on(&mut self, ramp: StopRamp) {
        let deceleration = self.deceleration(ramp);
        let is_smooth = self.configuration.profile.is_smooth(ramp);
        self.motor.stop_on(deceleration, is_smooth);
    }

    /// The deceleration of a ramp in the mode at work, in steps/s². 60C6h caps it.
    pub(crate) fn deceleration(&self, ramp: StopRamp) -> u32 {
        ramp_in(self.mode, ramp, self.commands, self.configuration)
    }

    /// The fastest the motor may go.
    pub(crate) fn max_velocity(&self) -> Speed {
        self.configuration
            .max_velocity
            .min(self.motor.max_velocity())
    }

    /// A velocity and ramps, within 607Fh, 6080h, 60C5h, 60C6h and what the pulses can reach; and whether one of them was cut.
    #[inline(never)]
    pub(crate) fn within(&self, asked: Limits) -> (Limits, bool) {
        let limits = Limits {
            velocity: asked.velocity.min(self.max_velocity()),
            acceleration: asked.acceleration.min(self.configuration.max_acceleration),
            deceleration: asked.deceleration.min(self.configuration.max_deceleration),
        };
        (limits, limits != asked)
    }
}

/// The deceleration of a ramp in a mode, in steps/s². 60C6h caps it.
fn ramp_in(mode: Mode, ramp: StopRamp, commands: &Commands, configuration: &Configuration) -> u32 {
    let deceleration = match (mode, ramp) {
        (Mode::Velocity, StopRamp::SlowDown) => configuration.velocity.deceleration,
        (Mode::Velocity, _) => configuration.velocity.quick_stop,
        (Mode::Homing, StopRamp::SlowDown) => configuration.homing.acceleration,
        (_, StopRamp::SlowDown) => commands.profile_deceleration,
        (_, _) => configuration.quick_stop_deceleration,
    };
    deceleration.min(configuration.max_deceleration)
}

/// The mode at work, with what it keeps from tick to tick. No mode uses what another one keeps.
#[derive(Debug)]
enum ActiveMode {
    NoMode,
    ProfilePosition(ProfilePosition),
    Velocity(Velocity),
    ProfileVelocity(ProfileVelocity),
    Homing(Homing),
    InterpolatedPosition(InterpolatedPosition),
    CyclicPosition(CyclicPosition),
    CyclicVelocity(CyclicVelocity),
    ProfileTorque(ProfileTorque),
    CyclicTorque(CyclicTorque),
}

/// Which of the modes is at work.
#[derive(Debug)]
pub(crate) struct Modes {
    /// That of `state`.
    mode: Mode,
    state: ActiveMode,
    /// The active mode has given up its set-points, and the motor is slowing down.
    interrupted: bool,
    /// The ramp of 605Dh has been taken since then.
    halted: bool,
    /// 2034h:2, while homing is not at work.
    homing_failure: u8,
}

impl Modes {
    pub(crate) const fn new() -> Self {
        Self {
            mode: Mode::NoMode,
            state: ActiveMode::NoMode,
            interrupted: false,
            halted: false,
            homing_failure: homing::NO_FAILURE,
        }
    }

    /// The mode that is at work (6061h).
    pub(crate) const fn active(&self) -> Mode {
        self.mode
    }

    /// Another mode is at work, and has not begun.
    #[inline(never)]
    fn set(&mut self, mode: Mode) {
        self.homing_failure = self.homing_failure();
        self.mode = mode;
        self.state = match mode {
            Mode::NoMode => ActiveMode::NoMode,
            Mode::ProfilePosition => ActiveMode::ProfilePosition(ProfilePosition::new()),
            Mode::Velocity => ActiveMode::Velocity(Velocity::new()),
            Mode::ProfileVelocity => ActiveMode::ProfileVelocity(ProfileVelocity::new()),
            Mode::Homing => ActiveMode::Homing(Homing::new(self.homing_failure)),
            Mode::InterpolatedPosition => {
                ActiveMode::InterpolatedPosition(InterpolatedPosition::new())
            }
            Mode::CyclicPosition => ActiveMode::CyclicPosition(CyclicPosition::new()),
            Mode::CyclicVelocity => ActiveMode::CyclicVelocity(CyclicVelocity::new()),
            Mode::ProfileTorque => ActiveMode::ProfileTorque(ProfileTorque::new()),
            Mode::CyclicTorque => ActiveMode::CyclicTorque(CyclicTorque::new()),
        };
    }

    /// The deceleration of a ramp in the mode at work, in steps/s².
    pub(crate) fn deceleration(
        &self,
        ramp: StopRamp,
        commands: &Commands,
        configuration: &Configuration,
    ) -> u32 {
        ramp_in(self.active(), ramp, commands, configuration)
    }

    /// Whether the mode at work looks for the home position, and enforces the limit switches itself.
    pub(crate) const fn is_homing(&self) -> bool {
        matches!(&self.state, ActiveMode::Homing(homing) if homing.is_under_way())
            && !self.interrupted
    }

    /// 2034h:2: why homing failed last.
    pub(crate) const fn homing_failure(&self) -> u8 {
        match &self.state {
            ActiveMode::Homing(homing) => homing.failure(),
            _ => self.homing_failure,
        }
    }

    /// A limit switch is stopping the motor: what the mode was after is not reached.
    #[inline(never)]
    pub(crate) fn on_limit(&mut self, motor: &Motor<impl Actuator>) {
        match &mut self.state {
            ActiveMode::NoMode | ActiveMode::Homing(_) => {}
            ActiveMode::ProfilePosition(mode) => mode.on_limit(motor),
            ActiveMode::Velocity(mode) => mode.on_limit(motor),
            ActiveMode::ProfileVelocity(mode) => mode.on_limit(motor),
            ActiveMode::InterpolatedPosition(mode) => mode.on_limit(),
            ActiveMode::CyclicPosition(mode) => mode.on_limit(),
            ActiveMode::CyclicVelocity(mode) => mode.on_limit(),
            ActiveMode::ProfileTorque(mode) => mode.on_limit(motor),
            ActiveMode::CyclicTorque(mode) => mode.on_limit(motor),
        }
    }

    /// The motor stands, and no mode is at work: the mode that is asked for is the mode.
    pub(crate) fn select(&mut self, modes: u32, code: i8) {
        if let Some(mode) = Mode::among(modes, code)
            && mode != self.active()
        {
            self.set(mode);
        }
    }

    /// Operation is enabled: the mode starts with no set-point and all its bits at rest.
    pub(crate) fn enter(&mut self, motor: &Motor<impl Actuator>) {
        self.interrupted = false;
        match &mut self.state {
            ActiveMode::NoMode => {}
            ActiveMode::ProfilePosition(mode) => mode.enter(motor),
            ActiveMode::Velocity(mode) => mode.enter(),
            ActiveMode::ProfileVelocity(mode) => mode.enter(),
            ActiveMode::Homing(mode) => mode.enter(),
            ActiveMode::InterpolatedPosition(mode) => mode.enter(),
            ActiveMode::CyclicPosition(mode) => mode.enter(),
            ActiveMode::CyclicVelocity(mode) => mode.enter(motor),
            ActiveMode::ProfileTorque(mode) => mode.enter(),
            ActiveMode::CyclicTorque(mode) => mode.enter(),
        }
    }

    /// The velocity that the motor is to keep for good, if that is what the mode at work is after.
    const fn kept_velocity(&self) -> Option<SignedSpeed> {
        match &self.state {
            ActiveMode::ProfilePosition(mode) => mode.end_velocity(),
            ActiveMode::Velocity(mode) => mode.kept_velocity(),
            ActiveMode::ProfileVelocity(mode) => mode.kept_velocity(),
            _ => None,
        }
    }

    /// Operation is to be left, or the mode: the motor slows down on this ramp, its set-points are forgotten. A halt, and whatever stop is
    /// under way, becomes no gentler by that.
    pub(crate) fn interrupt(
        &mut self,
        motor: &mut Motor<impl Actuator>,
        ramp: StopRamp,
        commands: &Commands,
        configuration: &Configuration,
    ) {
        if !self.interrupted {
            self.interrupted = true;
            self.halted = false;
            self.slow_down(motor, ramp, commands, configuration);
        }
        let halts =
            commands.controlword & HALT != 0 && !matches!(self.state, ActiveMode::Homing(_));
        if halts && !self.halted {
            self.halted = true;
            self.slow_down(motor, configuration.halt, commands, configuration);
        }
    }

    fn slow_down(
        &self,
        motor: &mut Motor<impl Actuator>,
        ramp: StopRamp,
        commands: &Commands,
        configuration: &Configuration,
    ) {
        if !motor.standstill() {
            let deceleration = self.deceleration(ramp, commands, configuration);
            motor.stop_no_gentler(deceleration, configuration.profile.is_smooth(ramp));
        }
    }

    /// Whether data records of interpolated position are kept: not outside of the mode, and not after it has given up its set-points.
    pub(crate) const fn keeps_records(&self) -> bool {
        matches!(self.state, ActiveMode::InterpolatedPosition(_)) && !self.interrupted
    }

    /// The bits of the statusword that a mode has outside of operation enabled: a master that asks whether home is known need not
    /// enable the drive for it.
    pub(crate) const fn idle_bits(
        &self,
        motor: &Motor<impl Actuator>,
        configuration: &Configuration,
    ) -> u16 {
        let shows =
            matches!(self.state, ActiveMode::Homing(_)) && !configuration.homing.starts_afresh();
        if shows && motor.is_referenced() {
            HOMING_ATTAINED
        } else {
            0
        }
    }

    /// One control tick in operation enabled. Returns the bits of the statusword that belong to the mode. A mode that the drive has
    /// not got is not linked.
    pub(crate) fn tick<P: Types>(&mut self, context: &mut Context<'_, P>) -> u16 {
        let modes = const { P::Objects::DRIVE.modes & P::Actuator::MODES };
        let has = |mode: Mode| mode.is_among(modes);
        let active = self.active();
        let wanted = Mode::among(modes, context.commands.mode).unwrap_or(active);
        if wanted != active {
            if !context.motor.standstill() && !wanted.begins_in_motion() {
                let (commands, configuration) = (context.commands, context.configuration);
                self.interrupt(context.motor, StopRamp::SlowDown, commands, configuration);
                return 0;
            }
            let kept = self.kept_velocity();
            self.set(wanted);
            context.mode = wanted;
            self.enter(context.motor);
            if let ActiveMode::CyclicVelocity(mode) = &mut self.state {
                mode.go_on_with(kept);
            }
        } else if self.interrupted {
            self.enter(context.motor);
        }
        if !wanted.has_profile() {
            context.motor.set_ramps(Ramps::Linear);
        }
        match &mut self.state {
            ActiveMode::ProfilePosition(mode) if has(Mode::ProfilePosition) => mode.tick(context),
            ActiveMode::Velocity(mode) if has(Mode::Velocity) => mode.tick(context),
            ActiveMode::ProfileVelocity(mode) if has(Mode::ProfileVelocity) => mode.tick(context),
            ActiveMode::Homing(mode) if has(Mode::Homing) => mode.tick(context),
            ActiveMode::InterpolatedPosition(mode) if has(Mode::InterpolatedPosition) => {
                mode.tick(context)
            }
            ActiveMode::CyclicPosition(mode) if has(Mode::CyclicPosition) => mode.tick(context),
            ActiveMode::CyclicVelocity(mode) if has(Mode::CyclicVelocity) => mode.tick(context),
            ActiveMode::ProfileTorque(mode) if has(Mode::ProfileTorque) => mode.tick(context),
            ActiveMode::CyclicTorque(mode) if has(Mode::CyclicTorque) => mode.tick(context),
            _ => 0,
        }
    }
}
