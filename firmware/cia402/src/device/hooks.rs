//! The rules of the drive objects: what may be written to them, and what a write sets off.
//!
//! A master writes the drive's parameters by SDO or by receive PDOs, in objects 6000h to 67FFh or in others that are bound to
//! them. The dictionary checks access, length and limits. The hooks refuse the values that CiA 402-2 leaves out: a mode that
//! 6502h does not list, a quick stop option code that the drive does not support, an acceleration of 0.
//!
//! The contract:
//! - A refused write changes nothing; an SDO gets an abort code.
//! - Every write of a drive object leads to new [`Commands`]. They carry all values at once, so a tick never sees
//!   half of a receive PDO.
//! - The controlword is followed write by write. Bits that rose and commands to stop since the last commands are in the next
//!   ones, even if a later write took them back. They are passed on once.
//! - A write that the drive allows goes to the application of the firmware next, which may still refuse it. Streamed objects
//!   belong to the application alone.
//! - The serial number 1018h:4 is filled in at every start, before a master can read it.

use canopen::cia301::sdo::{AbortCode, Completion};
use canopen::od::{self, Entry, write_u32};
use canopen::{Application, Instant};

use super::commissioning::{Commissioning, setting};
use crate::behaviour::{Behaves, Behaviour};
use crate::commands::Commands;
use crate::controlword::ControlwordHistory;
use crate::cyclic::{CyclicConfiguration, SyncEvent};
use crate::objects::Objects;
use crate::parameters::Parameter;
use crate::protection::{PASSWORD, PRODUCTION, Protection};
use crate::recorder::ScopeObjects;
use crate::rules;
use crate::units::Units;

const SYNC_PERIOD: u16 = canopen::cia301::sync::PERIOD;
/// How long the controller stays off the bus after bus-off.
pub(crate) const RESTART_DELAY: u16 = 0x2011;
/// How long an SDO server waits for the next frame of a client.
pub(crate) const SDO_TIME_OUT: u16 = 0x5FF3;
/// The data sheet of the device.
const STORE_EDS: u16 = 0x1021;
const IDENTITY: u16 = 0x1018;
const SERIAL_NUMBER: u8 = 4;
/// What the drive knows of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Network {
    /// It commands the drive.
    Remote,
    /// It was lost: 6007h says what follows, and if that is a fault, it has this error code.
    Lost(u16),
    /// The device boots anew, and stops the drive first.
    Resetting {
        /// The drive restarts as well.
        restart: bool,
    },
}

/// The application of the node. It handles the drive objects, and passes every call on to the module `B` of the product and to the
/// application `A` of the firmware.
#[derive(Debug)]
pub(crate) struct Hooks<A, B> {
    pub(crate) application: A,
    pub(crate) behaviour: B,
    serial_number: u32,
    /// The modes of the actuator, bits as in 6502h.
    pub(crate) modes: u32,
    history: ControlwordHistory,
    units: Units,
    written: bool,
    configured: bool,
    delay_written: bool,
    /// Bits 0 and 8 of 60B8h that were 0 since the last commands.
    probes_off: u16,
    /// 60FEh was written since the last commands.
    outputs_written: bool,
    pub(crate) protection: Protection,
    pub(crate) commissioning: Commissioning,
    /// The scope.
    pub(crate) scope: ScopeObjects,
    /// The serial number of production; 0 for none.
    produced: u32,
    /// Which set-points of the cyclic modes were written since the last sync event: 607Ah, 60FFh, 6071h.
    fresh: (bool, bool, bool),
    /// The data record 60C1h:1, if one was written since it was taken last.
    record: Option<i32>,
    /// 60C2h was written, or loaded with a value that is not its default.
    has_period: bool,
}

impl<A, B: Behaviour> Hooks<A, B> {
    pub(crate) fn new(serial_number: u32, application: A) -> Self {
        Self {
            application,
            behaviour: B::default(),
            serial_number,
            modes: u32::MAX,
            history: ControlwordHistory::new(0),
            units: Units::NONE,
            written: true,
            configured: true,
            delay_written: false,
            probes_off: 0,
            outputs_written: false,
            protection: Protection::default(),
            commissioning: Commissioning::default(),
            scope: ScopeObjects::default(),
            produced: 0,
            fresh: (false, false, false),
            record: None,
            has_period: false,
        }
    }

    /// Sets the serial number that production has written, if there is one.
    pub(crate) fn set_serial_number(&mut self, serial_number: Option<u32>) {
        if let Some(number) = serial_number {
            self.serial_number = number;
            self.produced = number;
        }
    }

    /// The serial number that production has given; 0 for none.
    pub(crate) const fn produced(&self) -> u32 {
        self.produced
    }

    /// Whether 2011h or 5FF3h was written since the last call.
    pub(crate) const fn take_delay_written(&mut self) -> bool {
        let written = self.delay_written;
        self.delay_written = false;
        written
    }

    /// Commands and configuration are to be posted even if no drive object was written.
    pub(crate) const fn post_all_anew(&mut self) {
        self.written = true;
        self.configured = true;
    }

    /// Commands are to be posted even if no drive object was written.
    pub(crate) const fn post_commands_anew(&mut self) {
        self.written = true;
    }

    /// Whether a drive object was written since the last call.
    pub(crate) const fn take_written(&mut self) -> bool {
        let written = self.written;
        self.written = false;
        written
    }

    /// The motor is to lose its power at once, whatever it does.
    pub(crate) const fn disable_voltage(&mut self) {
        self.history.disable_voltage();
    }

    /// Whether the interpolation time period 60C2h was written, or loaded with another value than its default.
    pub(crate) const fn has_period(&self) -> bool {
        self.has_period
    }

    /// Notes that parameters were loaded. All parameters are stored, so 60C2h counts as written only if it differs from its default.
    pub(crate) fn note_load<D: Objects>(&mut self, dictionary: &D) {
        let period = CyclicConfiguration::of(dictionary).period;
        self.has_period = period != CyclicConfiguration::NONE.period;
    }

    /// Whether an object of the configuration was written since the last call.
    pub(crate) const fn take_configured(&mut self) -> bool {
        let configured = self.configured;
        self.configured = false;
        configured
    }

    /// Whether a set-point of a cyclic mode was written since the last sync event.
    pub(crate) const fn has_set_point(&self) -> bool {
        self.fresh.0 || self.fresh.1 || self.fresh.2 || self.record.is_some()
    }

    /// The data record 60C1h:1 that was written since the last call.
    pub(crate) const fn take_record(&mut self) -> Option<i32> {
        self.record.take()
    }

    /// The sync event at `at`, with the set-points written since the one before. They count for one event.
    pub(crate) fn sync_event<D: Objects>(
        &mut self,
        dictionary: &D,
        at: Instant,
        is_sync: bool,
    ) -> SyncEvent {
        let (position, velocity, torque) = core::mem::take(&mut self.fresh);
        let units = self.units.of_drive::<D>();
        SyncEvent {
            at,
            is_sync,
            position: position.then(|| {
                let target = dictionary.target_position();
                target.saturating_add(dictionary.position_offset())
            }),
            velocity: velocity.then(|| {
                let target = units.velocity(dictionary.target_velocity());
                target.plus(units.velocity(dictionary.velocity_offset()))
            }),
            torque: torque.then(|| {
                let target = dictionary.target_torque();
                target.saturating_add(dictionary.torque_offset())
            }),
        }
    }

    /// Sets the units in which the master counts.
    pub(crate) const fn set_units(&mut self, units: Units) {
        self.units = units;
    }

    /// The commands in the drive objects. Edges of the controlword are passed on once. Velocities and accelerations are converted to
    /// increments.
    pub(crate) fn commands<D: Behaves>(&mut self, dictionary: &D, network: Network) -> Commands {
        let units = self.units.of_drive::<D>();
        let passed = self.history.take();
        let mut commands = Commands {
            controlword: dictionary.controlword(),
            rising: passed.rising,
            stop: passed.stop,
            shutdown_first: passed.shutdown_first,
            overwritten: passed.command,
            remote: network == Network::Remote,
            connection_error: match network {
                Network::Lost(code) => Some(code),
                Network::Remote | Network::Resetting { .. } => None,
            },
            restart: network == Network::Resetting { restart: true },
            mode: dictionary.modes_of_operation(),
            vl_target_velocity: dictionary.vl_target_velocity(),
            target_position: dictionary.target_position(),
            profile_velocity: units.speed(dictionary.profile_velocity()),
            end_velocity: units.speed(dictionary.end_velocity()),
            positioning_option: dictionary.positioning_option_code(),
            profile_acceleration: units.acceleration(dictionary.profile_acceleration()),
            profile_deceleration: units.acceleration(dictionary.profile_deceleration()),
            target_velocity: units.velocity(dictionary.target_velocity()),
            #[cfg(feature = "torque")]
            velocity_offset: units.velocity(dictionary.velocity_offset()),
            target_torque: dictionary.target_torque(),
            torque_offset: dictionary.torque_offset(),
            touch_probe_function: dictionary.touch_probe_function(),
            touch_probes_off: core::mem::take(&mut self.probes_off),
            digital_outputs: dictionary.digital_outputs(),
            digital_outputs_mask: dictionary.digital_outputs_mask(),
            outputs_written: core::mem::take(&mut self.outputs_written),
            passed_set_point: None,
            fault: None,
            home_switch: None,
            compare: None,
        };
        if B::IS_THERE {
            self.behaviour.command(dictionary, units, &mut commands);
        }
        commands
    }
}

impl<A, B> Hooks<A, B> {
    /// Whether an object that sets node-ID or bit rate may be written. Like 5FF0h, not while the power stage is on. A value that is
    /// loaded with the parameters is accepted, and ignored.
    fn check_setting<D: Behaves>(&self, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        if !D::DRIVE_HABITS.network.are_own() && setting::<D>(entry).is_some() {
            if self.protection.is_loading() {
                return Ok(());
            }
            if self.protection.is_powered() {
                return Err(AbortCode::DeviceState);
            }
        }
        self.commissioning.check::<D>(entry, value)
    }
}

impl<D: Behaves, A: Application<D>> Application<D> for Hooks<A, D::Behaviour> {
    fn validate(&mut self, dictionary: &D, entry: &Entry, value: &[u8]) -> Result<(), AbortCode> {
        let parameter = D::parameter(entry);
        let protected = self.protection.check(dictionary, entry, parameter, value);
        protected.inspect_err(|code| self.protection.count_refusal(entry, *code))?;
        self.check_setting::<D>(entry, value)?;
        if D::DRIVE.scope {
            self.scope.check(dictionary, entry, value)?;
        }
        if let Some(parameter) = parameter
            && let Some(number) = od::number(entry, value)
        {
            rules::check(
                parameter,
                D::converted(entry, number)?,
                dictionary,
                self.modes,
            )?;
        }
        if D::Behaviour::IS_THERE {
            self.behaviour.check(dictionary, entry, value)?;
        }
        self.application.validate(dictionary, entry, value)
    }

    fn written(&mut self, dictionary: &mut D, entry: &Entry) {
        let parameter = D::parameter(entry);
        if parameter.is_some() {
            dictionary.carry_over(entry);
        }
        if parameter == Some(Parameter::Controlword) {
            self.history.write(dictionary.controlword());
        }
        match parameter {
            Some(Parameter::TouchProbeFunction) => {
                self.probes_off |= !dictionary.touch_probe_function();
            }
            Some(Parameter::DigitalOutputs | Parameter::DigitalOutputsMask) => {
                self.outputs_written = true;
            }
            Some(Parameter::TargetPosition) => self.fresh.0 = true,
            Some(Parameter::TargetVelocity) => self.fresh.1 = true,
            Some(Parameter::TargetTorque) => self.fresh.2 = true,
            Some(Parameter::InterpolationRecord) => {
                self.record = Some(dictionary.interpolation_record());
            }
            Some(Parameter::InterpolationTimeValue | Parameter::InterpolationTimeIndex) => {
                self.has_period = true;
            }
            _ => {}
        }
        self.written |= parameter.is_some();
        self.configured |= entry.index == SYNC_PERIOD;
        self.configured |= parameter.is_some_and(|parameter| !parameter.is_command());
        self.delay_written |= entry.index == RESTART_DELAY;
        if D::DRIVE.scope {
            self.scope.written(dictionary, entry);
        }
        if entry.index >> 4 == PASSWORD >> 4 {
            self.delay_written |= entry.index == SDO_TIME_OUT;
            self.protection.written(dictionary, entry);
            self.commissioning.written(dictionary, entry);
        }
        // The stored setting is newer than a value that is loaded with the parameters.
        let is_elsewhere = !D::DRIVE_HABITS.network.are_own() && setting::<D>(entry).is_some();
        if is_elsewhere && !self.protection.is_loading() {
            self.commissioning.written(dictionary, entry);
        }
        if D::Behaviour::IS_THERE {
            self.behaviour.written(dictionary, entry);
        }
        self.application.written(dictionary, entry);
    }

    fn completion(&mut self, dictionary: &D, entry: &Entry) -> Completion {
        if self.commissioning.is_waiting::<D>(entry) {
            return Completion::Later;
        }
        self.application.completion(dictionary, entry)
    }

    fn size(&mut self, dictionary: &D, entry: &Entry) -> Result<Option<u32>, AbortCode> {
        if !D::DATA_SHEET.is_empty() && entry.index == STORE_EDS {
            return Ok(u32::try_from(D::DATA_SHEET.len()).ok());
        }
        self.application.size(dictionary, entry)
    }

    fn read_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        into: &mut [u8],
    ) -> Result<usize, AbortCode> {
        if !D::DATA_SHEET.is_empty() && entry.index == STORE_EDS {
            let from = usize::try_from(position).unwrap_or(usize::MAX);
            let rest = D::DATA_SHEET.get(from..).unwrap_or_default();
            for (to, byte) in into.iter_mut().zip(rest) {
                *to = *byte;
            }
            return Ok(rest.len().min(into.len()));
        }
        if D::Behaviour::IS_THERE
            && let Some(number) = self.behaviour.read(dictionary, entry)
        {
            for (to, byte) in into.iter_mut().zip(number.to_le_bytes()) {
                *to = byte;
            }
            return Ok(into.len());
        }
        self.application.read_at(dictionary, entry, position, into)
    }

    fn begin_write(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        size: Option<u32>,
    ) -> Result<(), AbortCode> {
        // The bytes come later; no rule depends on them.
        self.protection.check(dictionary, entry, None, &[])?;
        self.application.begin_write(dictionary, entry, size)
    }

    fn write_at(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        position: u32,
        data: &[u8],
    ) -> Result<(), AbortCode> {
        self.application.write_at(dictionary, entry, position, data)
    }

    fn end_write(
        &mut self,
        dictionary: &mut D,
        entry: &Entry,
        length: u32,
    ) -> Result<Completion, AbortCode> {
        self.application.end_write(dictionary, entry, length)
    }

    fn abandon_write(&mut self, dictionary: &D, entry: &Entry) {
        self.application.abandon_write(dictionary, entry);
    }

    fn power_on(&mut self, dictionary: &mut D) {
        // The data sheet has 0 for the serial number. A dictionary without 1018h:4 does not take it.
        let _ = write_u32(dictionary, IDENTITY, SERIAL_NUMBER, self.serial_number);
        let (index, sub) = D::DRIVE_HABITS.network.serial_number;
        if index != 0 {
            let _ = write_u32(dictionary, index, sub, self.serial_number);
        }
        let _ = write_u32(dictionary, PRODUCTION, 1, self.produced);
        self.protection.reset();
        self.protection.load();
        self.protection.show(dictionary);
        if D::DRIVE.scope {
            self.scope.power_on(dictionary);
        }
        if D::Behaviour::IS_THERE {
            self.behaviour.power_on(dictionary);
        }
        self.application.power_on(dictionary);
        dictionary.agree();
        self.history = ControlwordHistory::new(dictionary.controlword());
        self.has_period = false;
        self.written = true;
        self.configured = true;
    }
}
