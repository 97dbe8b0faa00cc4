//! What the S200 does that is no data: motion tasks, the commands among its parameters, its command engine and its text interface, its own modes,
//! limits of speed, warnings that become faults, status words, and the loops of its motor.
//!
//! Where its manual gives no coding or unit, those of its series hold; each place says so.

mod access;
mod commands;
mod enable;
mod gearing;
mod homing;
mod limits;
mod modes;
mod prompt;
mod registers;
mod servo;
mod status;
mod supply;
mod tasks;
mod units;

use canopen::Instant;
use canopen::cia301::nmt::NmtState;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{self, Dictionary, Entry};
use cia402::behaviour::{Behaviour, Requests, View, number, put_number};
use cia402::commands::Commands;
use cia402::controlword::{CHANGE_IMMEDIATELY, NEW_SET_POINT};
use cia402::loops::{LoopReport, Request, ServoSettings};
use cia402::units::Units;
use cia402::{Objects, State};

use commands::Orders;
use enable::Enable;
use gearing::Gearing;
use homing::Reference;
use modes::Modes;
use prompt::Prompt;
use registers::{Call, Registers};
use servo::Servo;
use status::{Found, Status};
use supply::Supply;
use tasks::{Faulty, Tasks};

/// What the drive was like when it was looked at last.
#[derive(Clone, Copy, Debug)]
struct Seen {
    statusword: u16,
    mode: i8,
    error_code: u16,
    /// In the user's counts, and in those of the motor.
    position: i32,
    internal: i32,
    /// Increments/s, and those that are asked for.
    speed: i32,
    speed_demand: i32,
    /// 60FDh.
    inputs: u32,
    /// The external encoder.
    counter: i32,
    is_enabled: bool,
    has_power: bool,
    is_referenced: bool,
    is_moving: bool,
    is_storing: bool,
    state: NmtState,
    /// When the tick ran, and when it was looked at.
    ticked: Instant,
    at: Instant,
}

impl Default for Seen {
    fn default() -> Self {
        Self {
            statusword: 0,
            mode: 0,
            error_code: 0,
            position: 0,
            internal: 0,
            speed: 0,
            speed_demand: 0,
            inputs: 0,
            counter: 0,
            is_enabled: false,
            has_power: false,
            is_referenced: false,
            is_moving: false,
            is_storing: false,
            state: NmtState::Initialisation,
            ticked: Instant::from_ticks(0),
            at: Instant::from_ticks(0),
        }
    }
}

impl Seen {
    fn of(view: &View<'_>, units: &Units) -> Self {
        let actuals = view.actuals;
        Self {
            statusword: actuals.statusword,
            mode: actuals.mode_display,
            error_code: actuals.error_code,
            position: actuals.position_actual,
            internal: actuals.position_actual_internal,
            speed: units.velocity(actuals.velocity_actual).whole(),
            speed_demand: units.velocity(actuals.velocity_demand).whole(),
            inputs: actuals.digital_inputs,
            counter: actuals.counter,
            is_enabled: State::from_statusword(actuals.statusword) == Some(State::OperationEnabled),
            has_power: actuals.has_power(),
            is_referenced: actuals.referenced,
            is_moving: actuals.is_moving,
            is_storing: view.is_storing,
            state: view.state,
            ticked: actuals.at,
            at: view.at,
        }
    }
}

/// The module.
#[derive(Debug, Default)]
pub struct Module {
    seen: Seen,
    tasks: Tasks,
    orders: Orders,
    modes: Modes,
    gearing: Gearing,
    prompt: Prompt,
    enable: Enable,
    supply: Supply,
    registers: Registers,
    reference: Reference,
    /// What stands for the password of PASSCNFG; 0 for none.
    password: i64,
    units: Option<Units>,
    servo: Servo,
    status: Status,
    requests: Requests,
    /// Power-on values are loaded, and the stored ones may not be yet.
    is_starting: bool,
}

impl Module {
    /// Starts a motion task, or tells why it does not.
    fn start<D: Dictionary>(&mut self, dictionary: &mut D, number: u16, is_by_edge: bool) {
        let seen = self.seen;
        match self.tasks.start(dictionary, number, &seen, is_by_edge) {
            Ok(()) => self.tell(None),
            Err(why) => self.tell(Some(why)),
        }
        self.requests.commands = true;
    }

    /// STOP.
    fn stop(&mut self) {
        self.tasks.stop();
        self.modes.stop();
        self.requests.commands = true;
    }

    /// n08 and n09, and the emergency message of an invalid number.
    fn tell(&mut self, why: Option<Faulty>) {
        const INVALID_TASK: u16 = 0x8681;
        let was_told = self.status.faulty == Some(Faulty::Task);
        match (was_told, why == Some(Faulty::Task)) {
            (false, true) => self.requests.error = Some((INVALID_TASK, true)),
            (true, false) => self.requests.error = Some((INVALID_TASK, false)),
            _ => {}
        }
        self.status.faulty = why;
    }

    /// A new controlword.
    fn controlword<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        let word = dictionary.controlword();
        let rises = self.orders.controlword(word, &self.seen);
        if rises & 1 << 7 != 0 {
            self.tell(None);
            self.status.clear_warnings();
            if self.status.needs_cold_start() {
                self.orders.start_anew(&self.seen);
            }
        }
        if self.seen.is_enabled && self.seen.mode == 6 && rises & NEW_SET_POINT != 0 {
            self.reference
                .begin(dictionary, &self.seen, &mut self.requests);
        }
        if !self.seen.is_enabled || rises & NEW_SET_POINT == 0 {
            return;
        }
        let chosen = u16::try_from(number(dictionary, 0x2080, 0)).unwrap_or(0);
        let is_by_edge = matches!(self.seen.mode, 1) && word & CHANGE_IMMEDIATELY != 0;
        let task = if chosen == 0 {
            self.tasks.repeated()
        } else {
            chosen
        };
        if is_by_edge && task != 0 {
            put_number(dictionary, 0x2080, 0, 0);
            self.start(dictionary, task, true);
        } else {
            // A direct set-point, or homing.
            self.tasks.cancel();
            put_number(dictionary, 0x2081, 0, 0);
            let target = dictionary.target_position();
            put_number(dictionary, 0x3654, 1, target.into());
        }
    }
}

impl Behaviour for Module {
    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        *self = Self {
            is_starting: true,
            ..Self::default()
        };
        self.status.power_on();
        let _ = dictionary;
    }

    fn check<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        if self.is_starting {
            return Ok(());
        }
        let value = od::number(entry, value).unwrap_or(0);
        access::check(self.password, entry, value)?;
        modes::check(dictionary, entry, value)?;
        supply::check(entry, value)?;
        homing::check(entry, value)?;
        limits::check(entry, value)?;
        units::check(entry, value, &self.seen)?;
        registers::check(entry, value)?;
        gearing::check(entry, value)?;
        self.prompt.check(entry, value)?;
        Servo::check(entry, value)?;
        self.orders.check(dictionary, entry, value, &self.seen)
    }

    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        match (entry.index, entry.sub) {
            (0x6040, _) => self.controlword(dictionary),
            (0x607A | 0x6081 | 0x6083 | 0x6084 | 0x35BE | 0x35BF, _) => self.tasks.is_direct(),
            // MTMUX: the task that the next edge starts.
            (0x365B, 1) => {
                let task = number(dictionary, 0x365B, 1);
                put_number(dictionary, 0x2080, 0, task.clamp(0, tasks::LAST.into()));
            }
            (0x36D8, 1) => access::written(dictionary, &mut self.password, self.is_starting),
            (0x358D, 1) => {
                self.reference
                    .begin(dictionary, &self.seen, &mut self.requests);
            }
            (0x3642, 1) => {
                let task = u16::try_from(number(dictionary, 0x3642, 1)).unwrap_or(0);
                self.start(dictionary, task, false);
            }
            (0x35FE, 1) => self.stop(),
            (0x3518, 1) => self.status.clear_warnings(),
            (0x2082, 0) => {
                let [f0, f1, t0, t1] = (number(dictionary, 0x2082, 0) as u32).to_le_bytes();
                let (from, to) = (u16::from_le_bytes([f0, f1]), u16::from_le_bytes([t0, t1]));
                self.tasks.copy(dictionary, from, to);
                self.requests.configuration |= to == 0;
            }
            (0x2083, 0) => self.tasks.forget_flash(dictionary),
            (0x4000, 2) => {
                let task = u16::try_from(number(dictionary, 0x4000, 2)).unwrap_or(0);
                self.tasks.put(dictionary, task, tasks::Task::default());
            }
            (0x4000, 3) => self.tasks.forget(dictionary),
            _ => {}
        }
        self.enable.written(entry, self.is_starting);
        match self.registers.written(dictionary, entry) {
            Some(Call::Start(task)) if !self.is_starting => self.start(dictionary, task, false),
            Some(Call::Stop) => self.stop(),
            _ => {}
        }
        self.requests.configuration |= supply::written(dictionary, entry);
        self.requests.configuration |= homing::written(dictionary, entry);
        self.requests.configuration |= limits::written(dictionary, entry);
        self.requests.configuration |= units::written(dictionary, entry);
        let seen = self.seen;
        self.orders
            .written(dictionary, entry, &seen, &mut self.requests);
        self.modes
            .written(dictionary, entry, &seen, &mut self.requests);
        gearing::written(dictionary, entry);
        self.prompt.written(dictionary, entry);
        if self.servo.written(dictionary, entry) {
            self.requests.configuration = true;
        }
        self.status.written(entry);
    }

    fn read<D: Dictionary + Objects>(&mut self, dictionary: &D, entry: &Entry) -> Option<i64> {
        let _ = dictionary;
        self.prompt.read(entry)
    }

    fn wrote<D: Dictionary + Objects>(&mut self, dictionary: &D, result: Result<(), AbortCode>) {
        let _ = dictionary;
        self.prompt.wrote(result);
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let seen = Seen::of(view, self.units.as_ref().unwrap_or(&Units::NONE));
        if seen.ticked <= self.seen.ticked && !self.is_starting {
            // Nothing is new since the last tick, and a frame on a busy bus has no time to lose.
            (self.seen.is_storing, self.seen.state) = (seen.is_storing, seen.state);
            self.modes.show(dictionary, &seen, self.tasks.takes_mode());
            self.gearing.show(dictionary, &seen);
            self.status.show_again(dictionary);
            return;
        }
        let before = core::mem::replace(&mut self.seen, seen);
        if self.is_starting && seen.state != NmtState::Initialisation {
            self.is_starting = false;
            self.requests.configuration |= modes::begin(dictionary);
            self.enable.begin(dictionary);
            self.servo.limit(dictionary);
            Servo::limit_speed(dictionary);
            self.requests.configuration = true;
        }
        let elapsed = seen.ticked.checked_duration_since(before.ticked);
        let elapsed = elapsed.and_then(|elapsed| u32::try_from(elapsed.ticks()).ok());
        let elapsed = elapsed.unwrap_or(u32::MAX);
        if before.ticked < seen.ticked {
            self.requests.commands |= self.tasks.tick(dictionary, &seen);
            self.requests.commands |= self.modes.tick(dictionary, &seen);
            self.requests.commands |= self.gearing.tick(dictionary, &seen, elapsed);
            self.requests.commands |= self.servo.tick(dictionary);
            self.requests.commands |= self.orders.tick(dictionary, &seen, &mut self.requests);
            units::show(dictionary, &seen);
            self.requests.commands |= self.enable.tick(dictionary, &seen);
            self.requests.commands |= self.registers.tick(dictionary, &seen);
            self.supply.tick(dictionary, &seen, elapsed);
            let is_homing = self.orders.is_homing();
            self.reference
                .tick(dictionary, &seen, is_homing, &mut self.requests);
            let begins = seen.is_enabled && !before.is_enabled && !seen.is_referenced;
            if begins && number(dictionary, 0x36D7, 1) == 1 {
                self.orders.home();
                self.reference.begin(dictionary, &seen, &mut self.requests);
            }
            // NREFMT: a task behind homing.
            let is_home = |seen: &Seen| seen.mode == 6 && seen.statusword & 0x1400 == 0x1400;
            let task = u16::try_from(number(dictionary, 0x36D2, 1)).unwrap_or(0);
            if task != 0 && is_home(&seen) && !is_home(&before) && seen.is_enabled {
                self.start(dictionary, task, false);
            }
        }
        self.modes.show(dictionary, &seen, self.tasks.takes_mode());
        self.gearing.show(dictionary, &seen);
        self.status.more = self.servo.beside;
        let found = Found {
            warnings: self.supply.warnings | self.registers.warnings,
            hidden: supply::hidden(dictionary),
            fault: self.supply.fault,
            is_jogging: self.modes.is_jogging(),
            is_hardware_enabled: self.enable.is_there(),
            registers: self.registers.state,
            elapsed,
        };
        self.requests.commands |= self.status.show(dictionary, &seen, &found);
    }

    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let seen = self.seen;
        self.units = Some(*units);
        self.enable.command(commands);
        self.gearing.command(dictionary, units, &seen, commands);
        self.modes.command(dictionary, units, &seen, commands);
        self.tasks.command(dictionary, units, &seen, commands);
        self.orders.command(&seen, commands);
        self.registers.command(units, commands);
        modes::latch(dictionary, commands);
        modes::disable(dictionary, units, commands);
        modes::limit(dictionary, units, &seen, commands);
        commands.fault = self.status.fault();
        self.servo.command(dictionary, commands);
        self.status.outputs(dictionary, commands);
    }

    fn loops<D: Dictionary + Objects>(
        &mut self,
        dictionary: &mut D,
        report: &LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        self.requests.configuration |= self.servo.take_motor(dictionary, report);
        let request = self.servo.loops(dictionary, report, settings);
        self.requests.commands |= self.servo.fault().is_some();
        request
    }

    fn take_requests(&mut self) -> Requests {
        let mut requests = core::mem::take(&mut self.requests);
        // One write at a time.
        if requests.write.is_none() {
            requests.write = self.prompt.order();
        }
        requests
    }
}
