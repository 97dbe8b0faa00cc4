//! What the LMD does that is no data: the inhibit input, filters of inputs, limits, capture or trip, the targets of its set-points, an encoder that is
//! followed, reactions to errors, supplies and the temperature of its board, its closed loop.
//!
//! What its manual leaves open: "override" is a command that counts while the inhibit input is active, "overwrite" one that takes the place of the
//! controlword; a trip is a pulse of one control tick at output 3, when the demand passes the point in either direction.

mod errors;
mod following;
mod hmt;
mod inhibit;
mod limits;
mod trip;

use canopen::Instant;
use canopen::cia301::sdo::AbortCode;
use canopen::od::{Dictionary, Entry};
use cia402::behaviour::{Behaviour, Requests, View, number, put_number};
use cia402::commands::Commands;
use cia402::controlword::{CHANGE_IMMEDIATELY, NEW_SET_POINT, RELATIVE};
use cia402::loops::{self, Request, ServoSettings};
use cia402::units::Units;
use cia402::{Objects, State};

use errors::{FOLLOWING_ERROR, HOT, Plausibility, WARM, Warnings};
use following::Following;
use hmt::Hmt;
use inhibit::Inhibit;
use limits::Limits;
use trip::Trip;

/// Objects of our own, which parameters of the drive are read from or shown in.
const DEBOUNCE: u16 = 0x5F00;
const QUICK_STOP: u16 = 0x5F01;
const CAPTURES: u16 = 0x5F02;
const FILTERED: u16 = 0x5F03;
const RAW: u16 = 0x5F04;
const HOME_OFFSET: u16 = 0x5F09;

/// 605Ah of an error that keeps the power on.
const STAYS: i64 = 6;

/// 2031h: the trip output takes the place of the capture input.
const HAS_TRIP: i64 = 1 << 2;

/// Outputs are off at this temperature, whatever the thresholds are.
const HOTTEST: i64 = 85;

/// So many control ticks behind a set-point the statusword tells of it.
const SETTLED: u8 = 3;

/// 6041h.
const WARNING: u16 = 1 << 7;
const REACHED: u16 = 1 << 10;
const INTERNAL_LIMIT: u16 = 1 << 11;
const ACKNOWLEDGE: u16 = 1 << 12;
const IS_BEHIND: u16 = 1 << 13;

/// The module.
#[derive(Debug, Default)]
pub struct Module {
    hmt: Hmt,
    inhibit: Inhibit,
    trip: Trip,
    limits: Limits,
    following: Following,
    warnings: Warnings,
    plausibility: Plausibility,
    requests: Requests,
    statusword: u16,
    position: i32,
    is_enabled: bool,
    is_moving: bool,
    /// 60FDh, as the wires are.
    wires: u32,
    /// A set-point waits for the one under way.
    waits: bool,
    /// Control ticks since a set-point was handed over: the statusword tells of it a few later.
    since: u8,
    ticked: Option<Instant>,
    captures: i64,
    /// A supply is out of its range.
    is_warned: bool,
    is_hot: bool,
    is_behind: bool,
    /// The bridge is off until the controlword is written anew.
    is_disabled: bool,
    /// A motor that was idle in a move is stopped until then, with its power.
    is_stopped: bool,
    fault: Option<u16>,
    /// What the hardware has found: it stands until the power goes.
    broken: Option<u16>,
}

impl Module {
    /// 2211h and 2212h: an edge of bit 4 hands over a set-point.
    fn take_set_point<D: Dictionary + Objects>(&mut self, dictionary: &mut D, word: u16) {
        let target = i64::from(dictionary.target_position());
        let target = if word & RELATIVE != 0 {
            number(dictionary, 0x2212, 0).saturating_add(target)
        } else {
            target
        };
        let is_under_way = self.since < SETTLED || self.is_moving;
        self.waits = word & CHANGE_IMMEDIATELY == 0 && is_under_way;
        self.since = 0;
        put_number(dictionary, 0x2212, 0, target);
        if !self.waits {
            put_number(dictionary, 0x2211, 0, target);
        }
    }

    /// What hangs on the set-up: one filter for the home switch and the limits, the longest of theirs; the index pulse, which counts as if it were elsewhere.
    fn set_up<D: Dictionary>(&mut self, dictionary: &mut D) {
        let switches = (1..=3).fold(0, |all, sub| all | number(dictionary, 0x2002, sub));
        let time = inhibit::filter(dictionary, switches);
        let code = number(dictionary, 0x605A, 0);
        let has_index = matches!(number(dictionary, 0x6098, 0), 1..=14 | 33 | 34);
        let index = if has_index {
            number(dictionary, 0x2099, 0)
        } else {
            0
        };
        let offset = number(dictionary, 0x607C, 0).saturating_add(index);
        for (index, value) in [
            (DEBOUNCE, time),
            (QUICK_STOP, if self.is_stopped { STAYS } else { code }),
            (HOME_OFFSET, offset),
        ] {
            put_number(dictionary, index, 0, value);
        }
        self.limits.set_up(dictionary);
        self.following.set_up(dictionary);
        self.hmt.limit(dictionary);
        self.requests.configuration = true;
    }

    /// The reading of the analogue input, filtered if it is to be.
    fn show_analogue<D: Dictionary>(dictionary: &mut D) {
        let full = if number(dictionary, 0x2010, 2) == 8 {
            10_000
        } else {
            5_000
        };
        let reading = match number(dictionary, 0x2010, 3) {
            0 => number(dictionary, RAW, 0),
            _ => number(dictionary, FILTERED, 0) * 4_095 / full,
        };
        put_number(dictionary, 0x2010, 1, reading.clamp(0, 4_095));
    }

    /// The sensor of the bridge stands for that of the board too: 2018h.
    fn look_at_temperature<D: Dictionary>(&mut self, dictionary: &mut D) {
        let temperature = number(dictionary, 0x2019, 1);
        put_number(dictionary, 0x2018, 1, temperature);
        let is_warm = temperature >= number(dictionary, 0x2018, 2);
        self.warnings.set(WARM, is_warm);
        self.is_hot = temperature >= number(dictionary, 0x2018, 3).min(HOTTEST);
    }

    /// 2014h and 2016h: supply of the electronics and battery, each with its range; 2017h is what the battery holds.
    fn look_at_supplies<D: Dictionary>(&mut self, dictionary: &mut D) {
        let is_outside = |index| {
            let [voltage, low, high] = [1, 2, 3].map(|sub| number(dictionary, index, sub));
            voltage < low || high != 0 && voltage > high
        };
        self.is_warned = is_outside(0x2014) || is_outside(0x2016);
        let battery = number(dictionary, 0x2016, 1);
        put_number(dictionary, 0x2017, 0, battery);
    }

    /// FF01h, and errors of the hardware.
    fn look_at_motor<D: Dictionary>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let actuals = view.actuals;
        // A motor that is moved by its current has its lead and its locked rotor.
        if !self.is_enabled || self.hmt.is_there() {
            self.plausibility.forget(&mut self.warnings);
        } else if self.plausibility.look(
            view.at.ticks(),
            (actuals.position_demand, actuals.position_actual),
            actuals.is_moving,
            &mut self.warnings,
        ) && !self.is_stopped
        {
            self.is_stopped = true;
            self.set_up(dictionary);
        }
        if actuals.error_code >> 12 == 5 {
            self.broken = Some(actuals.error_code);
        }
    }

    /// What of the drive's own words is another's here.
    fn show<D: Dictionary>(&self, dictionary: &mut D) {
        self.limits.show(dictionary);
        let mut word = number(dictionary, 0x6041, 0) as u16;
        word |= if self.is_warned { WARNING } else { 0 };
        word |= if self.limits.is_any() {
            INTERNAL_LIMIT
        } else {
            0
        };
        word &= if self.following.is_pending {
            !REACHED
        } else {
            !0
        };
        put_number(dictionary, 0x6041, 0, word.into());
        self.hmt.show(dictionary);
    }

    /// The drive has published what it does.
    fn tick<D: Dictionary>(&mut self, dictionary: &mut D, view: &View<'_>) {
        let actuals = view.actuals;
        self.since = self.since.saturating_add(1);
        self.statusword = actuals.statusword;
        self.position = actuals.position_actual;
        self.is_moving = actuals.is_moving;
        self.wires = actuals.digital_inputs >> 16;
        let was_enabled = self.is_enabled;
        let state = State::from_statusword(actuals.statusword);
        self.is_enabled = state == Some(State::OperationEnabled);
        if self.is_enabled && !was_enabled {
            self.since = SETTLED;
            for index in [0x2211, 0x2212] {
                put_number(dictionary, index, 0, self.position.into());
            }
        }
        if self.waits && self.since >= SETTLED && self.statusword & ACKNOWLEDGE == 0 {
            self.waits = false;
            let target = number(dictionary, 0x2212, 0);
            put_number(dictionary, 0x2211, 0, target);
        }
        self.hmt.tick(
            dictionary,
            (self.is_enabled, actuals.is_moving),
            (
                actuals.velocity_actual,
                actuals.position_actual,
                actuals.position_demand,
            ),
        );
        self.is_disabled |= self.is_enabled && self.hmt.bars(dictionary);
        let captures = number(dictionary, CAPTURES, 0);
        if captures != core::mem::replace(&mut self.captures, captures) {
            put_number(dictionary, 0x2033, 2, 1);
        }
        Self::show_analogue(dictionary);
        self.look_at_temperature(dictionary);
        self.look_at_following(dictionary);
        self.look_at_supplies(dictionary);
        self.look_at_motor(dictionary, view);
        self.limits
            .look(actuals.digital_inputs, actuals.position_actual);
        let follows = self.following.look(
            dictionary,
            view.at.ticks(),
            self.is_enabled && actuals.mode_display == 1,
            (actuals.counter, actuals.position_demand, actuals.is_moving),
        );
        let is_changed = self.inhibit.look(dictionary, self.wires, view.at);
        let demand = actuals.position_demand.into();
        let has_tripped = self.trip.look(actuals.at, demand, actuals.has_compare);
        let code = number(dictionary, 0x2712, 0);
        let fault = if self.is_hot {
            Some(HOT)
        } else if self.is_behind && matches!(code, 3 | 5) {
            Some(FOLLOWING_ERROR)
        } else {
            self.inhibit.fault()
        };
        let is_new = fault != core::mem::replace(&mut self.fault, fault);
        self.requests.commands |=
            is_changed || has_tripped || is_new || follows || self.is_disabled;
    }

    /// 2712h: what a following error leads to.
    fn look_at_following<D: Dictionary>(&mut self, dictionary: &D) {
        let is_behind = self.statusword & IS_BEHIND != 0 && number(dictionary, 0x6061, 0) == 1;
        if is_behind == self.is_behind {
            return;
        }
        self.is_behind = is_behind;
        let code = number(dictionary, 0x2712, 0);
        self.warnings.set(FOLLOWING_ERROR, is_behind && code == 4);
        self.is_disabled |= is_behind && matches!(code, 2 | 4);
    }
}

impl Behaviour for Module {
    fn power_on<D: Dictionary + Objects>(&mut self, dictionary: &mut D) {
        *self = Self {
            broken: self.broken,
            ..Self::default()
        };
        self.set_up(dictionary);
    }

    fn check<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        entry: &Entry,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let _ = dictionary;
        if entry.index == 0x2710 && value == [1, 0] {
            return Err(AbortCode::InvalidValue);
        }
        // Bits 14 to 12 are 0.
        let is_known = entry.index != 0x2038
            || entry.sub != 1
            || value.get(1).is_none_or(|high| high & 0x70 == 0);
        is_known.then_some(()).ok_or(AbortCode::InvalidValue)
    }

    fn written<D: Dictionary + Objects>(&mut self, dictionary: &mut D, entry: &Entry) {
        match (entry.index, entry.sub) {
            (0x6040, _) => {
                let word = dictionary.controlword();
                self.is_disabled = false;
                if core::mem::take(&mut self.is_stopped) {
                    self.set_up(dictionary);
                }
                if self.inhibit.controlword(word) & NEW_SET_POINT != 0
                    && self.is_enabled
                    && number(dictionary, 0x6061, 0) == 1
                {
                    self.take_set_point(dictionary, word);
                }
            }
            (
                0x2000 | 0x2002 | 0x2004 | 0x2006 | 0x2020 | 0x2022 | 0x2099 | 0x2231 | 0x605A
                | 0x607C | 0x6098,
                _,
            ) => self.set_up(dictionary),
            (0x2704 | 0x6060, _) => self.requests.configuration |= self.hmt.limit(dictionary),
            (0x2740, _) => self.hmt.clear(dictionary),
            // All ones clear it.
            (0x2033, 2) => put_number(dictionary, 0x2033, 2, 0),
            (0x2031 | 0x2038, _) => {
                let has_trip = number(dictionary, 0x2031, 0) & HAS_TRIP != 0;
                self.trip.set_up(dictionary, has_trip);
                self.requests.commands = true;
            }
            _ => {}
        }
    }

    fn look<D: Dictionary + Objects>(&mut self, dictionary: &mut D, view: &View<'_>) {
        // Where nothing is new since the last tick, a frame on a busy bus has no time to lose.
        if self.ticked.is_none_or(|last| view.actuals.at > last) {
            self.ticked = Some(view.actuals.at);
            self.tick(dictionary, view);
        }
        self.show(dictionary);
    }

    fn command<D: Dictionary + Objects>(
        &mut self,
        dictionary: &D,
        units: &Units,
        commands: &mut Commands,
    ) {
        let _ = units;
        if number(dictionary, 0x2031, 0) & HAS_TRIP != 0 {
            commands.touch_probe_function = 0;
            commands.touch_probes_off |= 1;
        }
        self.inhibit.command(commands);
        self.following.command(commands);
        if self.is_disabled {
            commands.controlword &= !2;
        } else if self.is_stopped {
            commands.controlword = commands.controlword & !6 | 2;
        }
        commands.fault = self.broken.or(self.fault);
        self.trip.command(commands);
    }

    fn loops<D: Dictionary + Objects>(
        &mut self,
        dictionary: &mut D,
        report: &loops::LoopReport,
        settings: &mut ServoSettings,
    ) -> Option<Request> {
        self.hmt.loops(dictionary, report, settings);
        None
    }

    fn take_requests(&mut self) -> Requests {
        self.requests.error = self.warnings.next_change();
        core::mem::take(&mut self.requests)
    }
}
